// Method: all files of the folder are opened relative to one directory descriptor, without following symbolic links,
// and stay open under their names. One writer: a lock on the ledger itself, by its open file description (F_OFD_SETLK),
// which neither another descriptor of the same process nor the end of a thread releases; flock where the system lacks
// these locks. The kernel releases it when the process dies, so that no stale lock file can remain. A new ledger is
// locked as a temporary file before it gets its name, so that it never exists unlocked. After each lock the name is
// checked again: an earlier writer may have replaced or removed the file between opening and locking.
#include "backend/store.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <map>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "backend/file.hpp"
#include "base/error.hpp"

namespace toliman {

namespace {

constexpr const char kOldLock[] = "lock"; // lock file of earlier versions, held by flock
constexpr int kMostAttempts = 100;

// Locks a file exclusively by its open file description, or by flock where that is not supported. False with errno
// EAGAIN if another description holds the lock.
bool lock_whole(int file) noexcept {
    struct flock whole = {}; // l_len = 0: to the end of the file, also when it grows
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (::fcntl(file, F_OFD_SETLK, &whole) == 0)
        return true;
    if (errno == EACCES)
        errno = EAGAIN;
    const bool is_unsupported = errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP;
    return is_unsupported && ::flock(file, LOCK_EX | LOCK_NB) == 0;
}

class Folder final : public Store {
  public:
    Folder(const std::string &path, Access access) : path_(path), access_(access) {
        if (access == Access::write)
            create_folder();
        folder_ = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder_ < 0)
            fail_with_errno(access == Access::write ? Status::write : Status::not_found, "");
    }

    // Removes a temporary file that was never renamed.
    ~Folder() override {
        if (!temporary_.empty())
            ::unlinkat(folder_, temporary_.c_str(), 0);
        for (const auto &[name, file] : files_)
            ::close(file);
        ::close(folder_);
    }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    // Another writer may replace or remove the file between any two steps. A lock counts only if the locked file still
    // has the name; otherwise the attempt is repeated.
    void lock(const std::string &name) override {
        lock_old();
        for (int attempt = 0; attempt < kMostAttempts; attempt++)
            if (lock_existing(name) || lock_new(name))
                return;
        refuse_second_writer();
    }

    void check_unchanged(const std::string &name, uint64_t size) override {
        struct stat opened = {}, named = {};
        if (::fstat(open(name, Missing::refused), &opened) != 0)
            fail_with_errno(Status::write, name);
        const bool exists = find_entry(name, named);
        if (exists && is_same(opened, named) && static_cast<uint64_t>(opened.st_size) == size)
            return;
        const char *const what = !exists                   ? "removed or renamed"
                                 : !is_same(opened, named) ? "replaced by another file"
                                                           : "changed by another program";
        fail(Status::lost, "{%s}: was %s while it was being written: has %lld bytes, %llu were written",
             path(name).c_str(), what, static_cast<long long>(exists ? named.st_size : 0),
             static_cast<unsigned long long>(size));
    }

    int64_t size(const std::string &name) override {
        const int file = open(name, Missing::allowed);
        struct stat status = {};
        if (file >= 0 && ::fstat(file, &status) != 0)
            fail_with_errno(Status::not_found, name);
        return file >= 0 ? status.st_size : -1;
    }

    size_t read(const std::string &name, uint64_t at, void *data, size_t size) override {
        const int file = open(name, Missing::refused);
        size_t done = 0;
        while (done < size) {
            const ssize_t got =
                ::pread(file, static_cast<uint8_t *>(data) + done, size - done, static_cast<off_t>(at + done));
            if (got < 0 && errno == EINTR)
                continue;
            if (got < 0)
                fail_with_errno(Status::not_found, name);
            if (got == 0)
                break;
            done += static_cast<size_t>(got);
        }
        return done;
    }

    void create(const std::string &name) override {
        if (name == temporary_)
            return truncate(name, 0);
        close_file(name);
        if (::unlinkat(folder_, name.c_str(), 0) != 0 && errno != ENOENT)
            fail_with_errno(Status::write, name);
        if (!make_private(name)) {
            errno = EEXIST;
            fail_with_errno(Status::write, name);
        }
    }

    void discard(const std::string &name) noexcept override {
        close_file(name);
        ::unlinkat(folder_, name.c_str(), 0);
    }

    void lock_created(const std::string &name) override {
        if (!lock_whole(open(name, Missing::refused)))
            fail_with_errno(Status::write, name);
    }

    void write(const std::string &name, uint64_t at, const void *data, size_t size) override {
        const int file = open(name, Missing::made);
        const auto *next = static_cast<const uint8_t *>(data);
        while (size > 0) {
            const ssize_t put = ::pwrite(file, next, size, static_cast<off_t>(at));
            if (put < 0 && errno == EINTR)
                continue;
            if (put < 0)
                fail_with_errno(Status::write, name);
            next += put;
            at += static_cast<uint64_t>(put);
            size -= static_cast<size_t>(put);
        }
    }

    void truncate(const std::string &name, uint64_t size) override {
        if (::ftruncate(open(name, Missing::made), static_cast<off_t>(size)) != 0)
            fail_with_errno(Status::write, name);
    }

    void sync(const std::string &name) override {
        if (::fdatasync(open(name, Missing::made)) != 0)
            fail_with_errno(Status::write, name);
    }

    // A temporary file is accessible to its owner only until it is renamed; it then gets the permissions of the file
    // that it replaces, or those of a new file. The descriptor, and with it the lock, moves to the new name.
    void rename(const std::string &from, const std::string &to) override {
        struct stat status = {};
        const bool exists = find_entry(to, status);
        const int file = open(from, Missing::refused);
        std::string name = to; // allocated before anything changes, since it may throw
        if (!file::set_mode(file, exists && S_ISREG(status.st_mode) ? status.st_mode & 0777 : mode_) ||
            ::fsync(file) != 0)
            fail_with_errno(Status::write, from);
        if (::renameat(folder_, from.c_str(), folder_, to.c_str()) != 0)
            fail_with_errno(Status::write, to);
        close_file(to);
        auto moved = files_.extract(from);
        moved.key() = std::move(name);
        files_.insert(std::move(moved));
        if (from == temporary_)
            temporary_.clear();
    }

    void sync_folder() override {
        if (::fsync(folder_) != 0)
            fail_with_errno(Status::write, "");
    }

    std::string path(const std::string &name) const override { return name.empty() ? path_ : path_ + "/" + name; }

  private:
    [[noreturn]] void fail_with_errno(Status status, const std::string &name) const {
        const int reason = errno;
        fail(status, "{%s}: %s", path(name).c_str(), std::strerror(reason));
    }

    // Creates the folder if it does not exist. A new folder is durable only after fsync of its parent. An existing one
    // may have been created by a process that crashed before that, so the parent is always synced, unless it may not be
    // read and the folder existed before.
    void create_folder() const {
        const bool made = ::mkdir(path_.c_str(), 0777) == 0;
        if (!made && errno != EEXIST)
            fail_with_errno(Status::write, "");
        const int above = ::open((path_ + "/..").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (above < 0 && errno == EACCES && !made)
            return;
        const bool synced = above >= 0 && ::fsync(above) == 0;
        const int reason = errno;
        if (above >= 0)
            ::close(above);
        errno = reason;
        if (!synced)
            fail_with_errno(Status::write, "..");
    }

    [[noreturn]] void refuse_second_writer() const {
        fail(Status::state, "{%s}: another process is writing to it", path_.c_str());
    }

    static bool is_same(const struct stat &a, const struct stat &b) noexcept {
        return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    }

    // Stores the status of the entry of this name; false if there is none.
    bool find_entry(const std::string &name, struct stat &status) const {
        const bool exists = ::fstatat(folder_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
        if (!exists && errno != ENOENT)
            fail_with_errno(Status::write, name);
        return exists;
    }

    // Whether the file opened under this name still has it.
    bool is_named(const std::string &name) const {
        struct stat opened = {}, named = {};
        if (::fstat(files_.at(name), &opened) != 0)
            fail_with_errno(Status::write, name);
        return find_entry(name, named) && is_same(opened, named);
    }

    // Locks an existing file. False if there is none, or if it was replaced meanwhile.
    bool lock_existing(const std::string &name) {
        const int file = open(name, Missing::allowed);
        if (file < 0)
            return false;
        if (!lock_whole(file)) {
            if (errno == EAGAIN)
                refuse_second_writer();
            fail_with_errno(Status::write, name);
        }
        if (is_named(name))
            return true;
        close_file(name);
        return false;
    }

    // Creates and locks the temporary file of a file that does not exist. A temporary file is removed only by a process
    // that has locked it; one that is locked and still has its name is therefore safe.
    bool lock_new(const std::string &name) {
        std::string temporary = temporary_of(name);
        remove_stale(temporary);
        if (!make_private(temporary))
            return false;
        const bool locked = lock_whole(files_.at(temporary));
        if (!locked && errno != EAGAIN)
            fail_with_errno(Status::write, temporary);
        struct stat status = {};
        const bool is_mine = locked && is_named(temporary);
        if (is_mine && !find_entry(name, status)) {
            temporary_ = std::move(temporary);
            return true;
        }
        if (is_mine)
            ::unlinkat(folder_, temporary.c_str(), 0);
        close_file(temporary);
        return false;
    }

    // Removes a temporary file left by a crash, or a link of that name.
    void remove_stale(const std::string &temporary) {
        struct stat status = {};
        if (!find_entry(temporary, status))
            return;
        if (S_ISREG(status.st_mode) && !lock_existing(temporary))
            return;
        if (::unlinkat(folder_, temporary.c_str(), 0) != 0 && errno != ENOENT)
            fail_with_errno(Status::write, temporary);
        close_file(temporary);
    }

    // A writer of an earlier version holds the lock file `lock`.
    void lock_old() {
        const int file = ::openat(folder_, kOldLock, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (file < 0 && errno == ENOENT)
            return;
        if (file < 0)
            fail_with_errno(Status::write, kOldLock);
        add_file(kOldLock, file);
        if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
            refuse_second_writer();
    }

    // Creates a file that only its owner can access. False if the name exists.
    bool make_private(const std::string &name) {
        const int file =
            ::openat(folder_, name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode_t{0666});
        if (file < 0 && errno == EEXIST)
            return false;
        if (file < 0)
            fail_with_errno(Status::write, name);
        add_file(name, file);
        if (!file::keep_private(file, mode_))
            fail_with_errno(Status::write, name);
        return true;
    }

    void add_file(const std::string &name, int file) {
        try {
            files_[name] = file;
        } catch (...) { // out of memory
            ::close(file);
            throw;
        }
    }

    void close_file(const std::string &name) noexcept {
        const auto found = files_.find(name);
        if (found == files_.end())
            return;
        ::close(found->second);
        files_.erase(found);
    }

    enum class Missing { allowed, refused, made };

    // Opens a regular file. Negative only if it is missing and that is allowed. O_NONBLOCK: opening a pipe would
    // otherwise wait for its other end.
    int open(const std::string &name, Missing missing) {
        const auto found = files_.find(name);
        if (found != files_.end())
            return found->second;
        const bool make = missing == Missing::made;
        const int flags = (access_ == Access::write ? O_RDWR : O_RDONLY) | (make ? O_CREAT : 0);
        const int file = ::openat(folder_, name.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, mode_t{0666});
        if (file < 0 && errno == ENOENT && missing == Missing::allowed)
            return file;
        const int reason = errno;
        if (file >= 0)
            add_file(name, file);
        struct stat status = {};
        const bool exists =
            (file < 0 ? ::fstatat(folder_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) : ::fstat(file, &status)) == 0;
        if (exists && S_ISREG(status.st_mode) && file >= 0)
            return file;
        close_file(name);
        if (exists && !S_ISREG(status.st_mode))
            fail(Status::format, "{%s}: is %s: must be a regular file", path(name).c_str(),
                 S_ISLNK(status.st_mode)   ? "a symbolic link"
                 : S_ISDIR(status.st_mode) ? "a folder"
                                           : "a pipe or a device");
        errno = file < 0 ? reason : errno;
        fail_with_errno(access_ == Access::write ? Status::write : Status::not_found, name);
    }

    std::string path_;
    Access access_;
    int folder_ = -1;
    std::map<std::string, int> files_;
    std::string temporary_; // name of the locked temporary file, until it is renamed
    unsigned mode_ = 0600;  // permissions of a new file under the umask
};

} // namespace

void read_all(Store &store, const std::string &name, uint64_t at, void *data, size_t size) {
    const size_t done = store.read(name, at, data, size);
    const unsigned long long end = at + done;
    if (done < size)
        fail(Status::format, "{%s}: truncated: %zu more bytes are needed at %llu", store.path(name).c_str(),
             size - done, end);
}

std::string temporary_of(const std::string &name) {
    return name + ".tmp";
}

void replace_whole(Store &store, const std::string &name, const std::vector<uint8_t> &bytes) {
    const std::string temporary = temporary_of(name);
    store.create(temporary); // replaces one left by a crash
    store.write(temporary, 0, bytes.data(), bytes.size());
    store.sync(temporary);
    store.rename(temporary, name);
    store.sync_folder();
}

std::unique_ptr<Store> open_folder(const std::string &path, Access access) {
    return std::make_unique<Folder>(path, access);
}

} // namespace toliman
