#include "backend/file.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <new>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.hpp"

namespace toliman::file {

namespace {

constexpr int kMostTemporaries = 100;

class Descriptor {
  public:
    explicit Descriptor(int number) noexcept : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0)
            ::close(number_);
    }
    Descriptor(const Descriptor &) = delete;
    Descriptor &operator=(const Descriptor &) = delete;
    int get() const noexcept { return number_; }
    int close() noexcept {
        const int number = number_;
        number_ = -1;
        return ::close(number);
    }

  private:
    int number_;
};

std::string folder_of(const std::string &path) {
    const size_t slash = path.rfind('/');
    if (slash == std::string::npos)
        return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

// Of a file that exists. A symbolic link keeps standing: its target is replaced. Nothing else asks for the folders
// above, which may be closed to this process.
std::string target_of(const std::string &path) {
    struct stat facts = {};
    if (::lstat(path.c_str(), &facts) != 0)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    if (!S_ISLNK(facts.st_mode))
        return path;
    const std::unique_ptr<char, void (*)(void *)> real(::realpath(path.c_str(), nullptr), std::free);
    if (real == nullptr && errno == ENOMEM)
        throw std::bad_alloc();
    if (real == nullptr)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    return real.get();
}

// A new file beside target with these permissions, less the umask; its name is left in `temporary`; negative with errno
// on failure. Names that are taken, by other writers or by some that died, are passed over.
int open_beside(const std::string &target, std::string &temporary, mode_t mode) {
    int descriptor = -1;
    for (int i = 0; i < kMostTemporaries; i++) {
        temporary = target + "." + std::to_string(i) + ".tmp";
        descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
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

// A regular file for reading.
struct Input {
    // Opening a pipe would otherwise wait for a writer; regular files know no waiting.
    explicit Input(const std::string &path) : descriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
        if (descriptor.get() < 0)
            fail(Status::not_found, "{%s}: %s", path.c_str(), std::strerror(errno));
        if (::fstat(descriptor.get(), &facts) != 0 || !S_ISREG(facts.st_mode))
            fail(Status::not_found, "{%s}: not a regular file", path.c_str());
    }
    Descriptor descriptor;
    struct stat facts = {};
};

void check_not_empty(const std::string &path, const Input &input) {
    if (input.facts.st_size == 0)
        fail(Status::format, "{%s}: is empty", path.c_str());
}

// Up to `size` bytes from where the descriptor stands; fewer only at the end of the file.
std::vector<uint8_t> read_bytes(const std::string &path, const Input &input, size_t size) {
    std::vector<uint8_t> bytes(size);
    size_t done = 0;
    while (done < size) {
        const ssize_t got = ::read(input.descriptor.get(), bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            fail(Status::not_found, "{%s}: %s", path.c_str(), std::strerror(errno));
        if (got == 0)
            break;
        done += static_cast<size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

} // namespace

std::vector<uint8_t> read(const std::string &path, size_t limit) {
    const Input input(path);
    check_not_empty(path, input);
    const struct stat &facts = input.facts;
    if (facts.st_size < 0 || static_cast<uint64_t>(facts.st_size) > limit)
        fail(Status::format, "{%s}: %lld bytes, at most %zu are allowed", path.c_str(),
             static_cast<long long>(facts.st_size), limit);
    std::vector<uint8_t> bytes = read_bytes(path, input, static_cast<size_t>(facts.st_size));
    if (bytes.size() < static_cast<size_t>(facts.st_size))
        fail(Status::format, "{%s}: became shorter while it was read", path.c_str());
    return bytes;
}

std::vector<uint8_t> head(const std::string &path, size_t size) {
    const Input input(path);
    check_not_empty(path, input);
    return read_bytes(path, input, size);
}

bool set_mode(int descriptor, unsigned mode) noexcept {
    return ::fchmod(descriptor, static_cast<mode_t>(mode)) == 0 || errno == EPERM || errno == ENOTSUP ||
           errno == ENOSYS;
}

bool keep_private(int descriptor, unsigned &mode) noexcept {
    struct stat facts = {};
    if (::fstat(descriptor, &facts) != 0)
        return false;
    mode = facts.st_mode & 0777;
    return set_mode(descriptor, 0600);
}

void replace(const std::string &path, const void *data, size_t size) {
    struct stat facts = {};
    const bool exists = ::stat(path.c_str(), &facts) == 0;
    if (!exists && errno != ENOENT)
        fail(Status::write, "{%s}: cannot be written: %s", path.c_str(), std::strerror(errno));
    if (exists && !S_ISREG(facts.st_mode))
        fail(Status::write, "{%s}: cannot be written: not a regular file", path.c_str());
    const std::string target = exists ? target_of(path) : path;
    // Opened first: after the renaming nothing but its sync can fail.
    Descriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.get() < 0)
        fail(Status::write, "{%s}: cannot be written: its folder cannot be opened: %s", path.c_str(),
             std::strerror(errno));
    std::string temporary;
    unsigned mode = exists ? facts.st_mode & 0777 : 0;
    Descriptor output(open_beside(target, temporary, exists ? 0600 : 0666));
    if (output.get() < 0)
        fail(Status::write, "{%s}: cannot be written: %s: %s", path.c_str(), temporary.c_str(), std::strerror(errno));
    if ((!exists && !keep_private(output.get(), mode)) || !write_all(output.get(), data, size) ||
        !set_mode(output.get(), mode) || ::fsync(output.get()) != 0 || output.close() != 0 ||
        ::rename(temporary.c_str(), target.c_str()) != 0) {
        const int reason = errno;
        ::unlink(temporary.c_str());
        fail(Status::write, "{%s}: cannot be written: %s: %s", path.c_str(), temporary.c_str(), std::strerror(reason));
    }
    if (::fsync(folder.get()) != 0)
        fail(Status::write, "{%s}: is written, but its folder cannot be synced: %s", path.c_str(),
             std::strerror(errno));
}

} // namespace toliman::file
