// Method: a writer locks its temporary by flock, which the kernel releases when the process dies. Who is about to write
// the same target removes all temporaries that it can lock. A temporary is removed only under its lock; one that is
// locked and still has its name therefore remains until its writer renames or removes it.
#include "backend/temporary.hpp"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace toliman::temporary {

namespace {

bool has_name(int descriptor, const char *path) noexcept {
    struct stat opened = {}, named = {};
    return ::fstat(descriptor, &opened) == 0 && ::lstat(path, &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

bool try_lock(int descriptor) noexcept {
    return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

// Closes the descriptor and returns -1 with EEXIST if another process has locked the temporary, to remove it.
int locked(int descriptor, const char *path) noexcept {
    const bool is_lost = descriptor >= 0 && !try_lock(descriptor) && errno == EWOULDBLOCK;
    if (descriptor < 0 || (!is_lost && has_name(descriptor, path)))
        return descriptor;
    ::close(descriptor);
    errno = EEXIST;
    return -1;
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
    if (is_own && try_lock(descriptor) && has_name(descriptor, path.c_str()))
        kind == Kind::file ? static_cast<void>(::unlink(path.c_str())) : remove_folder(path);
    ::close(descriptor);
}

} // namespace

std::string name(const std::string &target, int number) {
    return target + "." + std::to_string(number) + ".tmp";
}

int create_file(const std::string &path, mode_t mode) noexcept {
    return locked(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode), path.c_str());
}

int create_folder(const std::string &path) noexcept {
    if (::mkdir(path.c_str(), 0777) != 0)
        return -1;
    return locked(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), path.c_str());
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
