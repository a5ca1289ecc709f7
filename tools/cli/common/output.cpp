#include "common/output.hpp"

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <poll.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <utility>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/size_text.hpp"
#include "common/terminal.hpp"

namespace cli {

namespace {

constexpr int kMostTemporaries = 100;
constexpr int kPatience = 1000; // ms, that a stopped program waits for the reader of its output
bool is_forced = false;

bool is_link(const std::string &path) noexcept {
    struct stat facts = {};
    return ::lstat(path.c_str(), &facts) == 0 && S_ISLNK(facts.st_mode);
}

// fchmod; true also on a file system that knows no permissions.
bool set_mode(int descriptor, mode_t mode) noexcept {
    return ::fchmod(descriptor, mode) == 0 || errno == EPERM || errno == ENOTSUP || errno == ENOSYS;
}

// Bytes from `at` on that a pipe which is ready takes at once, and in whole lines if possible: only poll() waits for
// the reader, a signal ends that, and leaves no line cut.
size_t portion(const std::string &text, size_t at) {
    const size_t most = std::min<size_t>(text.size() - at, PIPE_BUF);
    const size_t newline = text.rfind('\n', at + most - 1);
    return newline == std::string::npos || newline < at ? most : newline + 1 - at;
}

void check_own(const std::string &path, Replaces what) {
    if (is_forced || what == Replaces::anything)
        return;
    const Identity file = identify(path);
    if (file.content != Content::empty && !(file.content == Content::scene && what == Replaces::scenes) &&
        !is_own(file))
        throw Failure(kExitOutput,
                      path + ": exists and is not recognised as written by toliman: give --force to replace it");
}

// A write to a full pipe also fails when a signal comes.
[[noreturn]] void lost_stdout(int reason) {
    stop_if_asked();
    if (reason == EPIPE) // as after `| head`
        throw Failure(kExitOutput, "");
    throw Failure(kExitOutput, std::string("standard output: ") + std::strerror(reason));
}

} // namespace

void replace_anything() noexcept {
    is_forced = true;
}

OutputFile::OutputFile(const std::string &path, Replaces what)
    : path_(path == "-" ? "standard output" : path), is_stdout_(path == "-"), file_(nullptr) {
    if (is_stdout_ && what != Replaces::scenes && ::isatty(STDOUT_FILENO) != 0)
        throw Failure(kExitUsage, "-: standard output is a terminal: redirect it or give a file");
    struct stat facts = {};
    const bool exists = path != "-" && ::stat(path.c_str(), &facts) == 0;
    int descriptor;
    if (path == "-") {
        descriptor = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
    } else if (exists && !S_ISREG(facts.st_mode)) {
        descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    } else {
        const std::unique_ptr<char, void (*)(void *)> real(::realpath(path.c_str(), nullptr), std::free);
        if (!real && exists && is_link(path))
            fail();
        target_ = real ? real.get() : path;
        if (exists)
            check_own(path, what);
        mode_ = exists ? facts.st_mode & 0777 : 0;
        descriptor = open_temporary(exists ? 0600 : 0666);
    }
    if (descriptor >= 0)
        file_ = ::fdopen(descriptor, "wb");
    if (file_ == nullptr)
        fail();
    if (!temporary_.empty() && !exists && !keep_private()) {
        abandon();
        fail();
    }
}

// Passes over names that are taken, by other writers or by some that died.
int OutputFile::open_temporary(mode_t mode) {
    int descriptor = -1;
    for (int i = 0; i < kMostTemporaries; i++) {
        temporary_ = target_ + "." + std::to_string(i) + ".tmp";
        descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        if (descriptor >= 0 || errno != EEXIST)
            break;
    }
    return descriptor;
}

// Closes a new, still empty file to all others; the permissions that it had tell the umask without changing it.
bool OutputFile::keep_private() noexcept {
    struct stat facts = {};
    if (::fstat(::fileno(file_), &facts) != 0)
        return false;
    mode_ = facts.st_mode & 0777;
    return set_mode(::fileno(file_), 0600);
}

OutputFile::~OutputFile() {
    abandon();
}

void OutputFile::abandon() noexcept {
    const int reason = errno;
    if (file_ != nullptr)
        std::fclose(file_);
    file_ = nullptr;
    if (!temporary_.empty())
        ::unlink(temporary_.c_str());
    errno = reason;
}

void OutputFile::fail(const std::string &why) const {
    throw Failure(kExitOutput, path_ + ": cannot be written: " + why);
}

void OutputFile::fail() const {
    if (errno == EPIPE && is_stdout_)
        lost_stdout(errno);
    fail((errno == EEXIST ? temporary_ + ": " : "") + std::strerror(errno));
}

void OutputFile::need_space(const std::vector<size_t> &axes, size_t width) const {
    double bytes = static_cast<double>(width);
    for (const size_t axis : axes)
        bytes *= static_cast<double>(axis);
    struct statvfs disk = {};
    if (temporary_.empty() || ::statvfs(temporary_.c_str(), &disk) != 0)
        return;
    const double room = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    if (bytes <= room)
        return;
    fail("takes " + size_text(bytes) + ", the disk has " + size_text(room) + " free");
}

std::string OutputFile::hand_over() {
    if (temporary_.empty())
        fail("this format needs a regular file");
    std::fclose(file_);
    file_ = nullptr;
    if (::unlink(temporary_.c_str()) != 0)
        fail();
    return temporary_;
}

void OutputFile::write(const void *data, size_t size) {
    if (std::fwrite(data, 1, size, file_) != size)
        fail();
}

void OutputFile::print(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int written = std::vfprintf(file_, format, arguments);
    va_end(arguments);
    if (written < 0)
        fail();
}

void OutputFile::close() {
    if (temporary_.empty()) // written straight
        return;
    const int failed = std::fclose(file_);
    file_ = nullptr;
    if (failed != 0)
        fail();
}

void OutputFile::commit() {
    if (file_ == nullptr)
        file_ = std::fopen(temporary_.c_str(), "rb");
    if (file_ == nullptr || std::fflush(file_) != 0)
        fail();
    if (!temporary_.empty() && (!set_mode(::fileno(file_), mode_) || ::fsync(::fileno(file_)) != 0 ||
                                ::rename(temporary_.c_str(), target_.c_str()) != 0))
        fail();
    temporary_.clear();
    std::fclose(file_);
    file_ = nullptr;
}

OutputFolder::OutputFolder(const std::string &path) : path_(path), made_(::mkdir(path.c_str(), 0777) == 0) {
    if (!made_ && errno != EEXIST)
        throw Failure(kExitOutput, path + ": cannot be made: " + std::strerror(errno));
    struct stat facts = {};
    if (::stat(path.c_str(), &facts) == 0 && !S_ISDIR(facts.st_mode))
        throw Failure(kExitOutput, path + ": is not a folder");
    if (::access(path.c_str(), W_OK | X_OK) != 0)
        throw Failure(kExitOutput, path + ": cannot be written: " + std::strerror(errno));
}

OutputFolder::~OutputFolder() {
    if (made_)
        ::rmdir(path_.c_str());
}

void check_apart(const std::string &output, const std::vector<std::string> &inputs) {
    struct stat out = {}, in = {};
    if ((output == "-" ? ::fstat(STDOUT_FILENO, &out) : ::stat(output.c_str(), &out)) != 0 || !S_ISREG(out.st_mode))
        return;
    for (const std::string &input : inputs)
        if (::stat(input.c_str(), &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
            throw Failure(kExitUsage, (output == "-" ? "standard output" : output) + ": is the input" +
                                          (input == output ? "" : " " + input) + ": give another output");
}

void check_output(const std::string &path) {
    struct stat facts = {};
    if (path != "-" && ::stat(path.c_str(), &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))
        return; // opening a pipe would wait for its reader, and closing it send him away
    OutputFile probe(path);
}

void print_stdout(const std::string &text) {
    static std::string waiting; // with what a signal left unwritten
    static size_t written = 0;
    if (std::fflush(stdout) != 0)
        lost_stdout(errno);
    waiting.erase(0, std::exchange(written, 0)) += text;
    while (written < waiting.size()) {
        pollfd out = {STDOUT_FILENO, POLLOUT, 0};
        if (::poll(&out, 1, kPatience) <= 0) {
            stop_if_asked();
            continue;
        }
        const ssize_t count = ::write(STDOUT_FILENO, waiting.data() + written, portion(waiting, written));
        if (count < 0 && errno != EINTR && errno != EAGAIN)
            lost_stdout(errno);
        written += static_cast<size_t>(std::max<ssize_t>(count, 0));
    }
}

} // namespace cli
