// Locks between processes: by flock, which the kernel releases when the process that holds it dies.
#pragma once
#include <cerrno>
#include <sys/file.h>
#include <sys/stat.h>

namespace toliman {

// none: the file system has no locks.
enum class Lock { held, busy, none, failed };

// Locks an open file or folder until it is closed, without waiting; failed has the reason in errno.
inline Lock lock_file(int descriptor) noexcept {
    int result = 0;
    do
        result = ::flock(descriptor, LOCK_EX | LOCK_NB);
    while (result != 0 && errno == EINTR);
    if (result == 0)
        return Lock::held;
    if (errno == EWOULDBLOCK)
        return Lock::busy;
    return errno == ENOSYS || errno == EOPNOTSUPP || errno == ENOLCK ? Lock::none : Lock::failed;
}

// Whether an open file or folder still has its name, asked once it is locked: another process may have removed or
// replaced it before. failed has the reason in errno.
enum class Named { yes, no, failed };
inline Named has_name(int descriptor, const char *path) noexcept {
    struct stat opened = {}, named = {};
    if (::fstat(descriptor, &opened) != 0 || (::lstat(path, &named) != 0 && errno != ENOENT))
        return Named::failed;
    return named.st_ino == opened.st_ino && named.st_dev == opened.st_dev ? Named::yes : Named::no;
}

} // namespace toliman
