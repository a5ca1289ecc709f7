// Method: a writer locks its temporary; the lock ends with the process. Who is about to write the same target removes
// all temporaries that it can lock. A temporary is removed only under its lock; one that is locked and still has its
// name therefore remains until its writer renames or removes it.
#include "backend/temporary.hpp"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "backend/lock.hpp"

namespace toliman::temporary {

namespace {

// Closes the descriptor and returns -1: with EEXIST if another process has locked the temporary, to remove it.
int locked(int descriptor, const char *path) noexcept {
    if (descriptor < 0)
        return descriptor;
    const Lock lock = lock_file(descriptor);
    const Named named = lock == Lock::held || lock == Lock::none ? has_name(descriptor, path) : Named::failed;
    if (named == Named::yes)
        return descriptor;
    const int reason = lock == Lock::busy || named == Named::no ? EEXIST : errno;
    ::close(descriptor);
    errno = reason;
    return -1;
}

// Of a file or folder that was created under this name: if it cannot be locked, it is removed.
template <class Remove> int locked_or_removed(int descriptor, const char *path, const Remove &remove) noexcept {
    const int result = locked(descriptor, path);
    const int reason = errno;
    if (descriptor >= 0 && result < 0 && reason != EEXIST)
        remove(path);
    errno = reason;
    return result;
}

// A regular file or a folder; never a link.
int open_existing(const char *path) noexcept {
    constexpr int flags = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    const int file = ::open(path, O_RDWR | flags); // some file systems lock only what may be written
    return file < 0 && errno == EISDIR ? ::open(path, O_RDONLY | O_DIRECTORY | flags) : file;
}

// The files of the folder, and the folder if it is then empty.
void remove_folder(const std::string &path) {
    std::error_code error;
    for (std::filesystem::directory_iterator entry(path, error), end; entry != end; entry.increment(error))
        if (!entry->is_directory(error))
            ::unlink(entry->path().c_str());
    ::rmdir(path.c_str());
}

void remove_if_stale(const std::string &path, Kind kind) {
    const int descriptor = open_existing(path.c_str());
    if (descriptor < 0)
        return;
    struct stat status = {};
    const bool is_own = ::fstat(descriptor, &status) == 0 && status.st_uid == ::geteuid() &&
                        (kind == Kind::file ? S_ISREG(status.st_mode) : S_ISDIR(status.st_mode));
    if (is_own && lock_file(descriptor) == Lock::held && has_name(descriptor, path.c_str()) == Named::yes)
        kind == Kind::file ? static_cast<void>(::unlink(path.c_str())) : remove_folder(path);
    ::close(descriptor);
}

} // namespace

std::string name(const std::string &target, int number) {
    return target + "." + std::to_string(number) + ".tmp";
}

int create_file(const std::string &path, mode_t mode) noexcept {
    const char *const name = path.c_str();
    return locked_or_removed(::open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode), name, ::unlink);
}

int create_folder(const std::string &path) noexcept {
    const char *const name = path.c_str();
    if (::mkdir(name, 0777) != 0)
        return -1;
    const int folder = ::open(name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder >= 0)
        return locked_or_removed(folder, name, ::rmdir);
    const int reason = errno;
    ::rmdir(name);
    errno = reason;
    return -1;
}

int lock(const std::string &path) noexcept {
    return locked(open_existing(path.c_str()), path.c_str());
}

bool remove_stale(const std::string &target, Kind kind) {
    struct stat status = {};
    for (int number = 0; number < kMost; number++) {
        const std::string path = name(target, number);
        if (::lstat(path.c_str(), &status) == 0)
            remove_if_stale(path, kind);
        else if (errno != ENOENT)
            return false;
    }
    return true;
}

} // namespace toliman::temporary
