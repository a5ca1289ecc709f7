// Method: lines are written by one write(2) with O_APPEND and fdatasync'ed at most once per second, since a sync takes
// as long as many results. A lock keeps out a second process.
#include "common/job_journal.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "backend/lock.hpp"
#include "backend/temporary.hpp"

namespace cli {

namespace {

constexpr char kBusy[] = ": another process is writing to it",
               kRemedy[] = ": wait until it ends, or give another --out";

} // namespace

void remove_journal(const std::string &path) {
    const int journal = toliman::temporary::lock(path);
    if (journal < 0 && errno == ENOENT)
        return;
    if (journal < 0 && errno == EEXIST)
        throw Failure(kExitOutput, path + kBusy + kRemedy);
    const int reason = ::unlink(path.c_str()) == 0 ? 0 : errno;
    ::close(journal);
    if (reason != 0)
        throw Failure(kExitOutput, path + ": cannot be removed: " + std::strerror(reason));
}

void refuse_journal(const toliman::error &error) {
    const std::string why = error.what();
    switch (error.status()) {
    case TOLIMAN_E_MISMATCH:
        throw Failure(kExitUsage, why + "; without --resume it is replaced");
    case TOLIMAN_E_FORMAT:
        throw Failure(kExitInput, why);
    case TOLIMAN_E_WRITE:
    case TOLIMAN_E_STATE:
        throw Failure(kExitOutput, why + (error.status() == TOLIMAN_E_WRITE
                                              ? ": once this is possible, the same command with --resume continues"
                                              : ""));
    default:
        throw error;
    }
}

void write_and_remove(const std::string &journal, const std::function<void()> &write) {
    try {
        write();
    } catch (const Failure &failure) {
        throw Failure(failure.code(), failure.what() + (": the same command with --resume continues from " + journal));
    }
    remove_journal(journal);
}

AppendFile::AppendFile(const std::string &path, const std::string &remedy)
    : path_(path), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    using toliman::Lock, toliman::Named;
    if (file_ < 0)
        fail();
    const Lock lock = toliman::lock_file(file_);
    const Named named = lock == Lock::failed ? Named::failed : toliman::has_name(file_, path.c_str());
    if (lock != Lock::busy && named == Named::yes)
        return;
    const int reason = errno;
    ::close(file_);
    errno = reason;
    if (lock != Lock::busy && named == Named::failed)
        fail();
    throw Failure(kExitOutput, path + kBusy + remedy);
}

AppendFile::~AppendFile() {
    ::close(file_);
}

int64_t AppendFile::size() const {
    struct stat found = {};
    if (::fstat(file_, &found) != 0)
        fail();
    return found.st_size;
}

void AppendFile::truncate(int64_t size) {
    if (::ftruncate(file_, size) != 0)
        fail();
}

void AppendFile::write(const void *data, size_t size) {
    for (const char *at = static_cast<const char *>(data); size > 0;) {
        const ssize_t done = ::write(file_, at, size);
        if (done < 0 && errno == EINTR)
            continue;
        if (done <= 0)
            fail();
        at += done;
        size -= static_cast<size_t>(done);
    }
}

void AppendFile::sync() {
    if (::fdatasync(file_) != 0)
        fail();
}

void AppendFile::fail() const {
    throw Failure(kExitOutput, path_ + ": cannot be written: " + std::strerror(errno));
}

JournalFile::JournalFile(const std::string &path) : file_(path, kRemedy), text_(whole_text(path)) {
    const size_t whole = text_.rfind('\n') + 1; // 0 without a newline
    if (whole < text_.size())
        file_.truncate(static_cast<int64_t>(whole));
    text_.resize(whole);
    is_new_ = text_.empty() && make_unfinished(path, [] { return true; });
}

JournalFile::~JournalFile() {
    if (is_new_)
        ::unlink(path().c_str());
    end_unfinished(path());
}

void JournalFile::begin(const std::string &lines) {
    append(lines);
}

void JournalFile::add(const std::string &line) {
    if (std::exchange(is_new_, false))
        end_unfinished(path());
    append(line);
}

void JournalFile::append(const std::string &lines) {
    file_.write(lines.data(), lines.size());
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < std::chrono::seconds(1)) // a sync may take longer than a result
        return;
    file_.sync();
    synced_ = now;
}

} // namespace cli
