#include "common/job_journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "backend/lock.hpp"
#include "backend/temporary.hpp"

namespace cli {

namespace {

// Method: lines are written by one write(2) with O_APPEND and fdatasync'ed at most once per second, since a sync takes
// as long as many results. A lock keeps out a second process.

using toliman::Lock;
using toliman::Named;

[[noreturn]] void unwritable(const std::string &path) {
    throw Failure(kExitOutput, path + ": cannot be written: " + std::strerror(errno));
}

int opened(const std::string &path) {
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0)
        unwritable(path);
    const Lock lock = toliman::lock_file(file);
    const Named named = lock == Lock::failed ? Named::failed : toliman::has_name(file, path.c_str());
    if (lock != Lock::busy && named == Named::yes)
        return file;
    const int reason = errno;
    ::close(file);
    errno = reason;
    if (lock != Lock::busy && named == Named::failed)
        unwritable(path);
    throw Failure(kExitOutput, path + ": another process is writing to it: wait until it ends, or give another --out");
}

// The lines of a file, without an incomplete last one, which is removed.
std::string whole_lines(const std::string &path, int file) {
    std::string text = whole_text(path);
    const size_t whole = text.rfind('\n') + 1; // 0 without a newline
    if (whole < text.size() && ::ftruncate(file, static_cast<off_t>(whole)) != 0)
        unwritable(path);
    text.resize(whole);
    return text;
}

} // namespace

void remove_journal(const std::string &path) {
    const int journal = toliman::temporary::lock(path);
    if (journal < 0 && errno == ENOENT)
        return;
    if (journal < 0 && errno == EEXIST)
        throw Failure(kExitOutput,
                      path + ": another process is writing to it: wait until it ends, or give another --out");
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

JournalFile::JournalFile(const std::string &path) : path_(path), file_(opened(path)) {
    try {
        text_ = whole_lines(path_, file_);
        is_new_ = text_.empty() && make_unfinished(path_, [] { return true; });
    } catch (...) {
        ::close(file_);
        throw;
    }
}

JournalFile::~JournalFile() {
    if (is_new_)
        ::unlink(path_.c_str());
    end_unfinished(path_);
    ::close(file_);
}

void JournalFile::begin(const std::string &lines) {
    append(lines);
}

void JournalFile::add(const std::string &line) {
    if (std::exchange(is_new_, false))
        end_unfinished(path_);
    append(line);
}

void JournalFile::append(const std::string &lines) {
    if (::write(file_, lines.data(), lines.size()) != static_cast<ssize_t>(lines.size()))
        unwritable(path_);
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < std::chrono::seconds(1)) // a sync may take longer than a result
        return;
    if (::fdatasync(file_) != 0)
        unwritable(path_);
    synced_ = now;
}

} // namespace cli
