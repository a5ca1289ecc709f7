// Method: atomic replacement by a temporary file, fsync, rename(2) and fsync of the folder. rename is atomic on POSIX
// file systems; without the first fsync the new name could refer to an empty file after a power failure, without the
// second the rename itself could be lost. All other steps that can fail come before the rename.
#include "backend/file.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <new>
#include <sys/stat.h>
#include <unistd.h>

#include "backend/descriptor.hpp"
#include "backend/temporary.hpp"
#include "base/error.hpp"

namespace toliman::file {

namespace {

// Returns the file to replace: the target of a symbolic link, so that the link is kept, else path itself. realpath() is
// used for links only, since it needs search permission on all parent folders.
std::string target_of(const std::string &path) {
    struct stat status = {};
    if (::lstat(path.c_str(), &status) != 0)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    if (!S_ISLNK(status.st_mode))
        return path;
    const std::unique_ptr<char, void (*)(void *)> real(::realpath(path.c_str(), nullptr), std::free);
    if (real == nullptr && errno == ENOMEM)
        throw std::bad_alloc();
    if (real == nullptr)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    return real.get();
}

// Creates a new file in target's folder with these permissions, less the umask, and stores its name in `path`. Negative
// with errno on failure. Names of other writers are skipped.
int open_temporary(const std::string &target, std::string &path, mode_t mode) {
    path = target;
    if (!temporary::remove_stale(target, temporary::Kind::file))
        return -1;
    int descriptor = -1;
    for (int i = 0; i < temporary::kMost; i++) {
        path = temporary::name(target, i);
        descriptor = temporary::create_file(path, mode);
        if (descriptor >= 0 || errno != EEXIST)
            break;
    }
    return descriptor;
}

bool write_all(int descriptor, const void *data, size_t size) noexcept {
    const auto *next = static_cast<const uint8_t *>(data);
    while (size > 0) {
        const ssize_t written = ::write(descriptor, next, size);
        if (written < 0) {
            if (errno == EINTR)
                continue;
            return false;
        }
        next += written;
        size -= static_cast<size_t>(written);
    }
    return true;
}

Stamp stamp_of(const struct stat &status) noexcept {
    return {status.st_ino, static_cast<uint64_t>(status.st_size),
            status.st_mtim.tv_sec * int64_t{1000000000} + status.st_mtim.tv_nsec};
}

void check_not_empty(const std::string &path, const Stamp &stamp) {
    if (stamp.size == 0)
        fail(Status::format, "{%s}: is empty", path.c_str());
}

std::vector<uint8_t> first_bytes(const Reader &input, size_t size) {
    std::vector<uint8_t> bytes(size);
    bytes.resize(input.read(0, bytes.data(), size));
    return bytes;
}

} // namespace

std::string folder_of(const std::string &path) {
    const size_t slash = path.rfind('/');
    if (slash == std::string::npos)
        return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

Stamp stamp(const std::string &path) {
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0)
        fail(Status::not_found, "{%s}: %s", path.c_str(), std::strerror(errno));
    return stamp_of(status);
}

bool is_unchanged(const std::string &path, const Stamp &before) {
    struct stat status = {};
    if (::stat(path.c_str(), &status) == 0)
        return stamp_of(status) == before;
    if (errno != ENOENT)
        fail(Status::not_found, "{%s}: %s", path.c_str(), std::strerror(errno));
    return false;
}

// O_NONBLOCK: opening a pipe would otherwise wait for a writer. It has no effect on regular files.
Reader::Reader(const std::string &path)
    : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    if (descriptor_ < 0)
        fail(Status::not_found, "{%s}: %s", path.c_str(), std::strerror(errno));
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(descriptor_);
        fail(Status::not_found, "{%s}: not a regular file", path.c_str());
    }
}

Reader::~Reader() {
    ::close(descriptor_);
}

Stamp Reader::stamp() const {
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0)
        fail(Status::not_found, "{%s}: %s", path_.c_str(), std::strerror(errno));
    return stamp_of(status);
}

size_t Reader::read(uint64_t at, void *data, size_t size) const {
    size_t done = 0;
    while (done < size) {
        const ssize_t got =
            ::pread(descriptor_, static_cast<uint8_t *>(data) + done, size - done, static_cast<off_t>(at + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            fail(Status::not_found, "{%s}: %s", path_.c_str(), std::strerror(errno));
        if (got == 0)
            break;
        done += static_cast<size_t>(got);
    }
    return done;
}

void Reader::read_exactly(uint64_t at, void *data, size_t size) const {
    if (read(at, data, size) < size)
        fail(Status::not_found, "{%s}: was truncated while it was being read", path_.c_str());
}

std::vector<uint8_t> read(const std::string &path, size_t limit) {
    const Reader input(path);
    const Stamp stamp = input.stamp();
    check_not_empty(path, stamp);
    if (stamp.size > limit)
        fail(Status::format, "{%s}: has %llu bytes: must be at most %zu", path.c_str(),
             static_cast<unsigned long long>(stamp.size), limit);
    std::vector<uint8_t> bytes = first_bytes(input, static_cast<size_t>(stamp.size));
    if (bytes.size() < stamp.size)
        fail(Status::format, "{%s}: was truncated while it was being read", path.c_str());
    return bytes;
}

std::vector<uint8_t> head(const std::string &path, size_t size) {
    const Reader input(path);
    check_not_empty(path, input.stamp());
    return first_bytes(input, size);
}

bool set_mode(int descriptor, unsigned mode) noexcept {
    return ::fchmod(descriptor, static_cast<mode_t>(mode)) == 0 || errno == EPERM || errno == ENOTSUP ||
           errno == ENOSYS;
}

bool keep_private(int descriptor, unsigned &mode) noexcept {
    struct stat status = {};
    if (::fstat(descriptor, &status) != 0)
        return false;
    mode = status.st_mode & 0777;
    return set_mode(descriptor, 0600);
}

void replace(const std::string &path, const void *data, size_t size) {
    struct stat status = {};
    const bool exists = ::stat(path.c_str(), &status) == 0;
    if (!exists && errno != ENOENT)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    if (exists && !S_ISREG(status.st_mode))
        fail(Status::write, "{%s}: cannot be written: not a regular file", path.c_str());
    const std::string target = exists ? target_of(path) : path;
    // Opened before writing, so that only its fsync can fail after the rename.
    Descriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.get() < 0)
        fail(Status::write, "{%s}: cannot be written: its folder cannot be opened: %s", path.c_str(),
             std::strerror(errno));
    std::string name;
    unsigned mode = exists ? status.st_mode & 0777 : 0;
    Descriptor output(open_temporary(target, name, exists ? 0600 : 0666));
    if (output.get() < 0)
        fail(Status::write, "{%s}: cannot be written: %s: %s", path.c_str(), name.c_str(), std::strerror(errno));
    if ((!exists && !keep_private(output.get(), mode)) || !write_all(output.get(), data, size) ||
        !set_mode(output.get(), mode) || ::fsync(output.get()) != 0 || ::rename(name.c_str(), target.c_str()) != 0) {
        const int reason = errno;
        ::unlink(name.c_str());
        fail(Status::write, "{%s}: cannot be written: %s: %s", path.c_str(), name.c_str(), std::strerror(reason));
    }
    if (::fsync(folder.get()) != 0)
        fail(Status::write, "{%s}: was written, but fsync of its folder failed: %s", path.c_str(),
             std::strerror(errno));
}

} // namespace toliman::file
