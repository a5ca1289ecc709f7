// Method: records are appended by one write and fdatasync'ed at most once per second, since a sync may take longer than a
// small result. A record that a kill left incomplete fails its CRC32; it and all that follows are overwritten. flock keeps
// out a second process and is released by the kernel when the process dies.
#include "backend/journal.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "backend/file.hpp"
#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman {

namespace {

constexpr char kMagic[] = "TLMJ";
constexpr uint32_t kVersion = 1;
constexpr size_t kPrefixSize = 16, kChecksumSize = 4; // of a record: key and size before its bytes
constexpr auto kSyncEvery = std::chrono::seconds(1);

std::vector<uint8_t> with_checksum(ByteWriter &writer) {
    writer.u32(zip::crc32(writer.bytes().data(), writer.bytes().size()));
    return writer.take();
}

std::vector<uint8_t> header_of(const std::string &work, const std::vector<Journal::Input> &inputs) {
    ByteWriter writer;
    writer.raw(kMagic, 4);
    writer.u32(kVersion);
    writer.raw(work.data(), 4);
    writer.u32(static_cast<uint32_t>(inputs.size()));
    for (const Journal::Input &input : inputs)
        writer.u64(input.digest);
    return with_checksum(writer);
}

// Reads `size` bytes; false at the end of the file.
bool read_all(int file, uint64_t at, uint8_t *data, size_t size) {
    while (size > 0) {
        const ssize_t got = ::pread(file, data, size, static_cast<off_t>(at));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        data += got;
        at += static_cast<uint64_t>(got);
        size -= static_cast<size_t>(got);
    }
    return true;
}

bool write_all(int file, uint64_t at, const std::vector<uint8_t> &bytes) {
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t put = ::pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
        if (put < 0 && errno != EINTR)
            return false;
        done += put > 0 ? static_cast<size_t>(put) : 0;
    }
    return true;
}

} // namespace

Journal::Journal(const std::string &path, const char *work, std::vector<Input> inputs)
    : path_(path), work_(work), inputs_(std::move(inputs)),
      file_(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)) {
    if (file_ < 0 && errno == ENOENT)
        return;
    if (file_ < 0)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    try {
        check_header();
    } catch (...) {
        ::close(file_);
        throw;
    }
}

Journal::~Journal() {
    if (file_ >= 0)
        ::close(file_);
}

// A file that ends within its header was never a journal with records.
void Journal::check_header() {
    const char *const path = path_.c_str();
    struct stat status = {};
    if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode))
        fail(Status::format, "{%s}: is not a regular file", path);
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        fail(Status::state, "{%s}: another process is writing to it", path);
    const std::vector<uint8_t> wanted = header_of(work_, inputs_);
    std::vector<uint8_t> found(wanted.size());
    size_ = static_cast<uint64_t>(status.st_size);
    at_ = wanted.size();
    if (!read_all(file_, 0, found.data(), found.size())) {
        found.resize(static_cast<size_t>(status.st_size));
        if (found.empty() || std::equal(found.begin(), found.end(), wanted.begin()))
            return create();
        fail(Status::format, "{%s}: is not a journal", path);
    }
    if (found == wanted)
        return;
    const size_t known = 16; // magic, version, work, number of inputs
    if (!std::equal(found.begin(), found.begin() + known, wanted.begin()) ||
        zip::crc32(found.data(), found.size() - kChecksumSize) !=
            ByteReader(&found[found.size() - kChecksumSize], kChecksumSize, "journal").u32())
        fail(Status::format, "{%s}: is not a journal of this work and version", path);
    ByteReader digests(&found[known], found.size() - known, "journal");
    for (const Input &input : inputs_)
        if (digests.u64() != input.digest)
            fail(Status::mismatch, "{%s}: was written with %s: continue with the same, or remove the file", path,
                 input.name);
}

void Journal::create() {
    const std::vector<uint8_t> header = header_of(work_, inputs_);
    if (file_ < 0)
        file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode_t{0666});
    if (file_ < 0 && errno == EEXIST)
        fail(Status::state, "{%s}: another process is writing to it", path_.c_str());
    const int folder = ::open(file::folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool done = file_ >= 0 && (::flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
                      write_all(file_, 0, header) && folder >= 0 && ::fsync(folder) == 0;
    const int reason = errno;
    if (folder >= 0)
        ::close(folder);
    errno = reason;
    if (!done)
        fail_to_write();
    size_ = at_ = header.size();
}

bool Journal::read_record(Record &record) {
    uint8_t prefix[kPrefixSize];
    if (size_ - at_ < kPrefixSize + kChecksumSize || !read_all(file_, at_, prefix, kPrefixSize))
        return false;
    ByteReader reader(prefix, kPrefixSize, "journal");
    record.key = reader.u64();
    const uint64_t size = reader.u64();
    if (size > size_ - at_ - kPrefixSize - kChecksumSize)
        return false;
    record.bytes.resize(static_cast<size_t>(size) + kChecksumSize);
    if (!read_all(file_, at_ + kPrefixSize, record.bytes.data(), record.bytes.size()))
        return false;
    const uint32_t found = ByteReader(&record.bytes[static_cast<size_t>(size)], kChecksumSize, "journal").u32();
    record.bytes.resize(static_cast<size_t>(size));
    return zip::crc32(record.bytes.data(), record.bytes.size(), zip::crc32(prefix, kPrefixSize)) == found;
}

const Journal::Record *Journal::next() {
    if (file_ < 0)
        return nullptr;
    Record record;
    if (!next_ && read_record(record))
        next_ = std::move(record);
    return next_ ? &*next_ : nullptr;
}

void Journal::take() {
    if (next())
        at_ += kPrefixSize + next_->bytes.size() + kChecksumSize;
    next_.reset();
}

void Journal::append(uint64_t key, const std::vector<uint8_t> &bytes) {
    next_.reset();
    ByteWriter writer;
    writer.u64(key);
    writer.u64(bytes.size());
    writer.raw(bytes.data(), bytes.size());
    const std::vector<uint8_t> record = with_checksum(writer);
    if (file_ < 0)
        create();
    if (size_ > at_ && ::ftruncate(file_, static_cast<off_t>(at_)) != 0)
        fail_to_write();
    size_ = at_;
    if (!write_all(file_, at_, record)) {
        const int reason = errno;
        if (::ftruncate(file_, static_cast<off_t>(at_)) == 0) // otherwise its checksum ends the file
            errno = reason;
        fail_to_write();
    }
    size_ = at_ += record.size();
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < kSyncEvery)
        return;
    if (::fdatasync(file_) != 0)
        fail_to_write();
    synced_ = now;
}

void Journal::fail_to_write() const {
    fail(Status::write, "{%s}: cannot be written: %s", path_.c_str(), std::strerror(errno));
}

} // namespace toliman
