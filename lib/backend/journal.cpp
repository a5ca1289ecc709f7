// Method: records are appended; fdatasync makes those durable that cost enough. A record that a kill left incomplete
// fails its checksum; it and all that follows are overwritten. The checksum takes 8 bytes at a time: a CRC32 of the
// largest records, 100 MB of images, would take longer than their write. After a write that failed nothing more is
// written, since the file may then end within a record.
#include "backend/journal.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "backend/descriptor.hpp"
#include "backend/file.hpp"
#include "backend/lock.hpp"
#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman {

namespace {

constexpr char kMagic[] = "TLMJ";
constexpr uint32_t kVersion = 1;
constexpr size_t kPrefixSize = 24;  // of a record: key, size and checksum, before its bytes
constexpr size_t kChecksumSize = 4; // of the header

std::vector<uint8_t> with_crc(ByteWriter &writer) {
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
    return with_crc(writer);
}

// Four independent chains of 64-bit words, each mixed by a multiplication with an odd number and a rotation.
uint64_t checksum_of(uint64_t key, const std::vector<uint8_t> &bytes) noexcept {
    constexpr uint64_t odd = 0x9e3779b97f4a7c15u;
    uint64_t chains[4] = {key, bytes.size(), odd, ~odd};
    size_t at = 0;
    const auto mix = [&](uint64_t &chain, size_t size) {
        uint64_t word = 0;
        std::memcpy(&word, bytes.data() + at, size);
        chain = (chain ^ word) * odd;
        chain ^= chain >> 29;
        at += size;
    };
    while (bytes.size() - at >= 32)
        for (uint64_t &chain : chains)
            mix(chain, 8);
    while (at < bytes.size())
        mix(chains[0], std::min<size_t>(8, bytes.size() - at));
    uint64_t sum = 0;
    for (const uint64_t chain : chains) {
        sum = (sum ^ chain) * odd;
        sum ^= sum >> 32;
    }
    return sum;
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
    : path_(path), inputs_(std::move(inputs)), header_(header_of(work, inputs_)),
      file_(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)) {
    if (file_ < 0 && errno == ENOENT)
        return;
    if (file_ < 0)
        fail_to_write();
    try {
        open();
    } catch (...) {
        ::close(file_);
        throw;
    }
}

Journal::~Journal() {
    if (file_ >= 0)
        ::close(file_);
}

void Journal::lock() {
    const Lock lock = lock_file(file_);
    const Named named = lock == Lock::failed ? Named::failed : has_name(file_, path_.c_str());
    if (lock == Lock::busy || named == Named::no)
        fail(Status::state, "{%s}: another process is writing to it", path_.c_str());
    if (named == Named::failed)
        fail_to_write();
}

// A file that ends within its header was never a journal with records.
void Journal::open() {
    struct stat status = {};
    if (::fstat(file_, &status) != 0)
        fail_to_write();
    if (!S_ISREG(status.st_mode))
        fail(Status::format, "{%s}: is not a regular file", path_.c_str());
    lock();
    if (::fstat(file_, &status) != 0) // the size, now that no other process changes it
        fail_to_write();
    size_ = static_cast<uint64_t>(status.st_size);
    at_ = header_.size();
    check_header();
}

void Journal::check_header() {
    const char *const path = path_.c_str();
    std::vector<uint8_t> found(header_.size());
    found.resize(read(0, found.data(), found.size()));
    if (found.size() < header_.size() && std::equal(found.begin(), found.end(), header_.begin()))
        return create();
    if (found == header_)
        return;
    const size_t known = 16; // magic, version, work, number of inputs
    if (found.size() < header_.size() || !std::equal(found.begin(), found.begin() + known, header_.begin()) ||
        zip::crc32(found.data(), found.size() - kChecksumSize) !=
            ByteReader(&found[found.size() - kChecksumSize], kChecksumSize, "journal").u32())
        fail(Status::format, "{%s}: is not a journal of this work and version", path);
    ByteReader digests(&found[known], found.size() - known, "journal");
    for (const Input &input : inputs_)
        if (digests.u64() != input.digest)
            fail(Status::mismatch, "{%s}: was written with %s: continue with the same, or remove the file", path,
                 input.name);
}

// The file, if there was none, and its header. A new file that cannot get one is removed.
void Journal::create() {
    const bool is_new = file_ < 0;
    if (is_new)
        file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode_t{0666});
    if (file_ < 0 && errno == EEXIST)
        fail(Status::state, "{%s}: another process is writing to it", path_.c_str());
    if (file_ < 0)
        fail_to_write();
    try {
        if (is_new)
            lock();
        const Descriptor folder(::open(file::folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (folder.get() < 0 || !write_all(file_, 0, header_) || ::fsync(file_) != 0 || ::fsync(folder.get()) != 0)
            fail_to_write();
    } catch (const Error &error) {
        if (is_new && error.status() == Status::write)
            ::unlink(path_.c_str());
        throw;
    }
    size_ = at_ = header_.size();
}

// Returns the number of bytes read: fewer than `size` only at the end of the file.
size_t Journal::read(uint64_t at, uint8_t *data, size_t size) const {
    size_t done = 0;
    while (done < size) {
        const ssize_t got = ::pread(file_, data + done, size - done, static_cast<off_t>(at + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            fail(Status::write, "{%s}: cannot be read: %s", path_.c_str(), std::strerror(errno));
        if (got == 0)
            break;
        done += static_cast<size_t>(got);
    }
    return done;
}

bool Journal::read_record(Record &record) {
    uint8_t prefix[kPrefixSize];
    if (size_ - at_ < kPrefixSize || read(at_, prefix, kPrefixSize) < kPrefixSize)
        return false;
    ByteReader reader(prefix, kPrefixSize, "journal");
    record.key = reader.u64();
    const uint64_t size = reader.u64(), checksum = reader.u64();
    if (size > size_ - at_ - kPrefixSize)
        return false;
    record.bytes.resize(static_cast<size_t>(size));
    return read(at_ + kPrefixSize, record.bytes.data(), record.bytes.size()) == record.bytes.size() &&
           checksum_of(record.key, record.bytes) == checksum;
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
        at_ += kPrefixSize + next_->bytes.size();
    next_.reset();
}

void Journal::return_to(uint64_t position) noexcept {
    if (position == at_)
        return;
    at_ = position;
    next_.reset();
}

void Journal::append(uint64_t key, const std::vector<uint8_t> &bytes, bool durable) {
    next_.reset();
    if (failure_)
        std::rethrow_exception(failure_);
    try {
        write(key, bytes, durable);
    } catch (...) {
        failure_ = std::current_exception();
        throw;
    }
}

void Journal::write(uint64_t key, const std::vector<uint8_t> &bytes, bool durable) {
    if (file_ < 0)
        create();
    at_ = std::max<uint64_t>(at_, header_.size()); // of a position before the file existed
    if (size_ > at_ && ::ftruncate(file_, static_cast<off_t>(at_)) != 0)
        fail_to_write();
    size_ = at_;
    ByteWriter prefix;
    for (const uint64_t value : {key, uint64_t{bytes.size()}, checksum_of(key, bytes)})
        prefix.u64(value);
    if (!write_all(file_, at_, prefix.bytes()) || !write_all(file_, at_ + kPrefixSize, bytes) ||
        (durable && ::fdatasync(file_) != 0)) {
        const int reason = errno;
        [[maybe_unused]] const int cut = ::ftruncate(file_, static_cast<off_t>(at_)); // otherwise its checksum ends it
        errno = reason;
        fail_to_write();
    }
    size_ = at_ += kPrefixSize + bytes.size();
}

void Journal::fail_to_write() const {
    fail(Status::write, "{%s}: cannot be written: %s", path_.c_str(), std::strerror(errno));
}

} // namespace toliman
