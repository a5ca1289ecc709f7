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

constexpr const char kOldLock[] = "lock"; // that earlier versions made and held by flock
constexpr int kMostAttempts = 100;

// Locks a file by its open file description, so that closing another descriptor of it does not unlock it, nor does the
// end of a thread. flock, which does the same, where the system does not have such locks. False with errno EAGAIN if
// another holds it.
bool lock_whole(int file) noexcept {
    struct flock whole = {}; // to the end of the file, wherever that will be
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (::fcntl(file, F_OFD_SETLK, &whole) == 0)
        return true;
    if (errno == EACCES)
        errno = EAGAIN;
    const bool is_unknown = errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP;
    return is_unknown && ::flock(file, LOCK_EX | LOCK_NB) == 0;
}

class Folder final : public Store {
  public:
    Folder(const std::string &path, Access access) : path_(path), access_(access) {
        if (access == Access::write)
            make();
        folder_ = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder_ < 0)
            complain(access == Access::write ? Status::write : Status::not_found, "");
    }

    // A file that was begun and not made whole is nothing to leave behind.
    ~Folder() override {
        if (!begun_.empty())
            ::unlinkat(folder_, begun_.c_str(), 0);
        for (const auto &[name, file] : files_)
            ::close(file);
        ::close(folder_);
    }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    // A writer that came first may replace or remove the file between any two steps: only what still has its name once
    // it is locked is taken.
    void lock(const std::string &name) override {
        lock_old();
        for (int attempt = 0; attempt < kMostAttempts; attempt++)
            if (lock_existing(name) || lock_new(name))
                return;
        refuse_second();
    }

    void check_unchanged(const std::string &name, uint64_t size) override {
        struct stat here = {}, named = {};
        if (::fstat(open(name, Missing::refused), &here) != 0)
            complain(Status::write, name);
        const bool exists = look_at(name, named);
        if (exists && is_same(here, named) && static_cast<uint64_t>(here.st_size) == size)
            return;
        const char *const what = !exists                 ? "removed or renamed"
                                 : !is_same(here, named) ? "replaced by another file"
                                                         : "changed by another program";
        fail(Status::lost, "{%s}: was %s while it was being written: %lld bytes where %llu were written",
             path(name).c_str(), what, static_cast<long long>(exists ? named.st_size : 0),
             static_cast<unsigned long long>(size));
    }

    int64_t size(const std::string &name) override {
        const int file = open(name, Missing::allowed);
        struct stat facts = {};
        if (file >= 0 && ::fstat(file, &facts) != 0)
            complain(Status::not_found, name);
        return file >= 0 ? facts.st_size : -1;
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
                complain(Status::not_found, name);
            if (got == 0)
                break;
            done += static_cast<size_t>(got);
        }
        return done;
    }

    void create(const std::string &name) override {
        if (name == begun_)
            return truncate(name, 0);
        forget(name);
        if (::unlinkat(folder_, name.c_str(), 0) != 0 && errno != ENOENT)
            complain(Status::write, name);
        if (!make_private(name)) {
            errno = EEXIST;
            complain(Status::write, name);
        }
    }

    void write(const std::string &name, uint64_t at, const void *data, size_t size) override {
        const int file = open(name, Missing::made);
        const auto *next = static_cast<const uint8_t *>(data);
        while (size > 0) {
            const ssize_t put = ::pwrite(file, next, size, static_cast<off_t>(at));
            if (put < 0 && errno == EINTR)
                continue;
            if (put < 0)
                complain(Status::write, name);
            next += put;
            at += static_cast<uint64_t>(put);
            size -= static_cast<size_t>(put);
        }
    }

    void truncate(const std::string &name, uint64_t size) override {
        if (::ftruncate(open(name, Missing::made), static_cast<off_t>(size)) != 0)
            complain(Status::write, name);
    }

    void sync(const std::string &name) override {
        if (::fdatasync(open(name, Missing::made)) != 0)
            complain(Status::write, name);
    }

    // A file that is made whole before it is shown was its owner's alone; now it is open to whom its predecessor was,
    // or to whom any new file is. Its descriptor goes with it, and with that the lock.
    void rename(const std::string &from, const std::string &to) override {
        struct stat facts = {};
        const bool exists = look_at(to, facts);
        const int file = open(from, Missing::refused);
        std::string name = to; // takes memory before anything changes
        if (!file::set_mode(file, exists && S_ISREG(facts.st_mode) ? facts.st_mode & 0777 : mode_) ||
            ::fsync(file) != 0)
            complain(Status::write, from);
        if (::renameat(folder_, from.c_str(), folder_, to.c_str()) != 0)
            complain(Status::write, to);
        forget(to);
        auto moved = files_.extract(from);
        moved.key() = std::move(name);
        files_.insert(std::move(moved));
        if (from == begun_)
            begun_.clear();
    }

    void sync_folder() override {
        if (::fsync(folder_) != 0)
            complain(Status::write, "");
    }

    std::string path(const std::string &name) const override { return name.empty() ? path_ : path_ + "/" + name; }

  private:
    [[noreturn]] void complain(Status status, const std::string &name) const {
        const int reason = errno;
        fail(status, "{%s}: %s", path(name).c_str(), std::strerror(reason));
    }

    // A folder is on the disk only when the one that it is in is synced, which whoever made it may not have come to;
    // where that one may not be read, another has made this one.
    void make() const {
        const bool made = ::mkdir(path_.c_str(), 0777) == 0;
        if (!made && errno != EEXIST)
            complain(Status::write, "");
        const int above = ::open((path_ + "/..").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (above < 0 && errno == EACCES && !made)
            return;
        const bool synced = above >= 0 && ::fsync(above) == 0;
        const int reason = errno;
        if (above >= 0)
            ::close(above);
        errno = reason;
        if (!synced)
            complain(Status::write, "..");
    }

    [[noreturn]] void refuse_second() const {
        fail(Status::state, "{%s}: another process is writing to it", path_.c_str());
    }

    static bool is_same(const struct stat &a, const struct stat &b) noexcept {
        return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    }

    // What has this name, if anything has.
    bool look_at(const std::string &name, struct stat &facts) const {
        const bool exists = ::fstatat(folder_, name.c_str(), &facts, AT_SYMLINK_NOFOLLOW) == 0;
        if (!exists && errno != ENOENT)
            complain(Status::write, name);
        return exists;
    }

    // Whether the file that is open under a name still has it.
    bool is_named(const std::string &name) const {
        struct stat here = {}, named = {};
        if (::fstat(files_.at(name), &here) != 0)
            complain(Status::write, name);
        return look_at(name, named) && is_same(here, named);
    }

    // False where there is none, or another by now.
    bool lock_existing(const std::string &name) {
        const int file = open(name, Missing::allowed);
        if (file < 0)
            return false;
        if (!lock_whole(file)) {
            if (errno == EAGAIN)
                refuse_second();
            complain(Status::write, name);
        }
        if (is_named(name))
            return true;
        forget(name);
        return false;
    }

    // Makes and locks the temporary of a file that is not there. Whoever removes a temporary has locked it, so that one
    // which is locked and has its name stays.
    bool lock_new(const std::string &name) {
        std::string beside = temporary_of(name);
        remove_left(beside);
        if (!make_private(beside))
            return false;
        const bool locked = lock_whole(files_.at(beside));
        if (!locked && errno != EAGAIN)
            complain(Status::write, beside);
        struct stat facts = {};
        const bool is_mine = locked && is_named(beside);
        if (is_mine && !look_at(name, facts)) {
            begun_ = std::move(beside);
            return true;
        }
        if (is_mine)
            ::unlinkat(folder_, beside.c_str(), 0);
        forget(beside);
        return false;
    }

    // What a crash left under the name of a temporary, or a link.
    void remove_left(const std::string &beside) {
        struct stat facts = {};
        if (!look_at(beside, facts))
            return;
        if (S_ISREG(facts.st_mode) && !lock_existing(beside))
            return;
        if (::unlinkat(folder_, beside.c_str(), 0) != 0 && errno != ENOENT)
            complain(Status::write, beside);
        forget(beside);
    }

    // A writer of an earlier version holds the file `lock`.
    void lock_old() {
        const int file = ::openat(folder_, kOldLock, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (file < 0 && errno == ENOENT)
            return;
        if (file < 0)
            complain(Status::write, kOldLock);
        keep(kOldLock, file);
        if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
            refuse_second();
    }

    // A new file that is its owner's alone. False if there is one of that name.
    bool make_private(const std::string &name) {
        const int file =
            ::openat(folder_, name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode_t{0666});
        if (file < 0 && errno == EEXIST)
            return false;
        if (file < 0)
            complain(Status::write, name);
        keep(name, file);
        if (!file::keep_private(file, mode_))
            complain(Status::write, name);
        return true;
    }

    void keep(const std::string &name, int file) {
        try {
            files_[name] = file;
        } catch (...) { // out of memory
            ::close(file);
            throw;
        }
    }

    void forget(const std::string &name) noexcept {
        const auto found = files_.find(name);
        if (found == files_.end())
            return;
        ::close(found->second);
        files_.erase(found);
    }

    enum class Missing { allowed, refused, made };

    // Negative only for a file that may be missing and is. Opening a pipe would otherwise wait for its other end.
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
            keep(name, file);
        struct stat facts = {};
        const bool exists =
            (file < 0 ? ::fstatat(folder_, name.c_str(), &facts, AT_SYMLINK_NOFOLLOW) : ::fstat(file, &facts)) == 0;
        if (exists && S_ISREG(facts.st_mode) && file >= 0)
            return file;
        forget(name);
        if (exists && !S_ISREG(facts.st_mode))
            fail(Status::format, "{%s}: is %s: must be a regular file", path(name).c_str(),
                 S_ISLNK(facts.st_mode)   ? "a symbolic link"
                 : S_ISDIR(facts.st_mode) ? "a folder"
                                          : "a pipe or a device");
        errno = file < 0 ? reason : errno;
        complain(access_ == Access::write ? Status::write : Status::not_found, name);
    }

    std::string path_;
    Access access_;
    int folder_ = -1;
    std::map<std::string, int> files_;
    std::string begun_;    // the temporary that is locked, until it takes its name
    unsigned mode_ = 0600; // of a new file of this process
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
    const std::string beside = temporary_of(name);
    store.create(beside); // one may have been left behind
    store.write(beside, 0, bytes.data(), bytes.size());
    store.sync(beside);
    store.rename(beside, name);
    store.sync_folder();
}

std::unique_ptr<Store> open_folder(const std::string &path, Access access) {
    return std::make_unique<Folder>(path, access);
}

} // namespace toliman
