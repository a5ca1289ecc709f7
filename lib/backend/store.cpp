#include "backend/store.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <map>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "backend/file.hpp"
#include "base/error.hpp"

namespace toliman {

namespace {

constexpr const char kLock[] = "lock";

class Folder final : public Store {
  public:
    Folder(const std::string &path, Access access) : path_(path), access_(access) {
        if (access == Access::write)
            make();
        folder_ = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder_ < 0)
            complain(access == Access::write ? Status::write : Status::not_found, "");
        try {
            if (access == Access::write)
                lock();
        } catch (...) {
            close_all();
            throw;
        }
    }

    ~Folder() override { close_all(); }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

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
        forget(name);
        if (::unlinkat(folder_, name.c_str(), 0) != 0 && errno != ENOENT)
            complain(Status::write, name);
        open(name, Missing::made, O_EXCL, 0600);
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
    // or else the lock, which any writer makes first.
    void rename(const std::string &from, const std::string &to) override {
        struct stat facts = {};
        const bool exists = ::fstatat(folder_, to.c_str(), &facts, AT_SYMLINK_NOFOLLOW) == 0;
        if (!exists && errno != ENOENT)
            complain(Status::write, to);
        if (!(exists && S_ISREG(facts.st_mode)) && ::fstatat(folder_, kLock, &facts, AT_SYMLINK_NOFOLLOW) != 0)
            complain(Status::write, kLock);
        const int file = open(from, Missing::refused);
        if (!file::set_mode(file, facts.st_mode & 0777) || ::fsync(file) != 0)
            complain(Status::write, from);
        if (::renameat(folder_, from.c_str(), folder_, to.c_str()) != 0)
            complain(Status::write, to);
        for (const std::string &name : {from, to}) // descriptors follow the file, not the name
            forget(name);
    }

    void sync_folder() override {
        if (::fsync(folder_) != 0)
            complain(Status::write, "");
    }

    std::string path(const std::string &name) const override { return name.empty() ? path_ : path_ + "/" + name; }

  private:
    [[noreturn]] void complain(Status status, const std::string &name) const {
        const int reason = errno;
        fail(status, "%s: %s", path(name).c_str(), std::strerror(reason));
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

    void lock() {
        const int file = open(kLock, Missing::made);
        if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK)
                fail(Status::state, "%s: another process is writing to it", path_.c_str());
            complain(Status::write, kLock);
        }
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

    void close_all() noexcept {
        for (const auto &[name, file] : files_)
            ::close(file);
        ::close(folder_);
    }

    enum class Missing { allowed, refused, made };

    // Negative only for a file that may be missing and is. Opening a pipe would otherwise wait for its other end.
    int open(const std::string &name, Missing missing, int exclusive = 0, mode_t mode = 0666) {
        const auto found = files_.find(name);
        if (found != files_.end())
            return found->second;
        const bool make = missing == Missing::made;
        const int flags = (access_ == Access::write ? O_RDWR : O_RDONLY) | (make ? O_CREAT | exclusive : 0);
        const int file = ::openat(folder_, name.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, mode);
        if (file < 0 && errno == ENOENT && missing == Missing::allowed)
            return file;
        if (file < 0)
            complain(make ? Status::write : Status::not_found, name);
        keep(name, file);
        struct stat facts = {};
        if (::fstat(file, &facts) != 0 || !S_ISREG(facts.st_mode)) {
            forget(name);
            fail(make ? Status::write : Status::not_found, "%s: not a regular file", path(name).c_str());
        }
        return file;
    }

    std::string path_;
    Access access_;
    int folder_ = -1;
    std::map<std::string, int> files_;
};

} // namespace

void read_all(Store &store, const std::string &name, uint64_t at, void *data, size_t size) {
    const size_t done = store.read(name, at, data, size);
    const unsigned long long end = at + done;
    if (done < size)
        fail(Status::format, "%s: truncated: %zu more bytes are needed at %llu", store.path(name).c_str(), size - done,
             end);
}

void replace_whole(Store &store, const std::string &name, const std::vector<uint8_t> &bytes) {
    const std::string beside = name + ".tmp";
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
