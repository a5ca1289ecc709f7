// Method: an output is written to a temporary file in the same folder, fsync'ed and renamed, so that a reader sees the
// old or the new file and never a part. While it is written it is readable by its owner only, and locked, by which the
// next writer of this output knows that its writer lives. Files that must agree are first all fsync'ed. Then
// the one that implies the others is removed, the others are renamed, and it is renamed last. Standard output is
// written by poll(2) and write(2) of at most PIPE_BUF bytes, so that a signal can end the wait for a slow reader.
#include "common/output.hpp"

#include <climits>
#include <fcntl.h>
#include <filesystem>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "backend/temporary.hpp"
#include "common/common.hpp"
#include "common/content.hpp"

namespace cli {

namespace {

namespace temporary = toliman::temporary;

bool is_forced = false;

// fchmod; true also on a file system without permissions.
bool set_mode(int descriptor, mode_t mode) noexcept {
    return ::fchmod(descriptor, mode) == 0 || errno == EPERM || errno == ENOTSUP || errno == ENOSYS;
}

// Number of bytes from `at` on that a ready pipe accepts without blocking (PIPE_BUF), in whole lines if possible. Only
// poll() waits for the reader, so a signal can end the wait and leaves no line incomplete.
size_t portion(const std::string &text, size_t at) {
    const size_t most = std::min<size_t>(text.size() - at, PIPE_BUF);
    const size_t newline = text.rfind('\n', at + most - 1);
    return newline == std::string::npos || newline < at ? most : newline + 1 - at;
}

void check_own(const std::string &path, Replaces what) {
    if (is_forced)
        return;
    const Identity file = identify(path);
    if (file.content != Content::empty && !(file.content == Content::scene && what == Replaces::scenes) &&
        !is_own(file))
        throw Failure(kExitOutput, path + ": exists and was not written by toliman: give --force to replace it");
}

// A signal also interrupts a write to a full pipe.
[[noreturn]] void lost_stdout(int reason) {
    stop_if_asked();
    if (reason == EPIPE) // the reader has closed the pipe, as `| head` does: no message
        throw Failure(kExitOutput, "");
    throw Failure(kExitOutput, std::string("standard output: ") + std::strerror(reason));
}

} // namespace

void replace_anything() noexcept {
    is_forced = true;
}

OutputFile::OutputFile(const std::string &path, Replaces what)
    : path_(path == "-" ? "standard output" : path), is_stdout_(path == "-") {
    if (is_stdout_ && what != Replaces::scenes && ::isatty(STDOUT_FILENO) != 0)
        throw Failure(kExitUsage, "-: standard output is a terminal: redirect it or give a file");
    struct stat status = {};
    const bool exists = !is_stdout_ && ::stat(path.c_str(), &status) == 0;
    mode_ = status.st_mode;
    const int descriptor = is_stdout_                           ? ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3)
                           : exists && !S_ISREG(status.st_mode) ? ::open(path.c_str(), O_WRONLY | O_CLOEXEC)
                                                                : open_temporary(exists, what);
    if (descriptor >= 0)
        file_.reset(::fdopen(descriptor, "wb"));
    if (!file_)
        fail();
}

// Skips names of other writers. A new file is private while it is still empty; its permissions before show the umask,
// which can only be read by changing it.
int OutputFile::open_temporary(bool replaces, Replaces what) {
    std::error_code error;
    target_ = replaces ? std::filesystem::canonical(path_, error).string() : path_;
    if (error)
        fail(error.message());
    if (replaces)
        check_own(path_, what);
    if (!temporary::remove_stale(target_, temporary::Kind::file))
        return -1;
    int descriptor = -1;
    for (int i = 0; i < temporary::kMost; i++) {
        temporary_ = temporary::name(target_, i);
        const auto make = [&] {
            return (descriptor = temporary::create_file(temporary_, replaces ? 0600 : 0666)) >= 0;
        };
        if (make_unfinished(temporary_, make) || errno != EEXIST)
            break;
    }
    struct stat created = {};
    if (descriptor >= 0 && (::fstat(descriptor, &created) != 0 || !set_mode(descriptor, 0600))) {
        ::close(descriptor);
        abandon();
        return -1;
    }
    mode_ = (replaces ? mode_ : created.st_mode) & 0777;
    return descriptor;
}

void OutputFile::abandon() noexcept {
    const int reason = errno;
    file_.reset();
    if (!temporary_.empty()) {
        ::unlink(temporary_.c_str());
        end_unfinished(temporary_);
    }
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
    std::error_code unknown; // then the largest number
    const auto available = static_cast<double>(std::filesystem::space(temporary_, unknown).available);
    if (bytes > available)
        fail("needs " + size_text(bytes) + ", the disk has " + size_text(available) + " free");
}

std::string OutputFile::hand_over() {
    if (temporary_.empty())
        fail("this format needs a regular file");
    file_.reset();
    if (::unlink(temporary_.c_str()) != 0)
        fail();
    return temporary_;
}

void OutputFile::take_back() {
    const int descriptor = temporary::lock(temporary_);
    if (descriptor >= 0)
        file_.reset(::fdopen(descriptor, "rb"));
    if (!file_)
        fail();
}

void OutputFile::write(const void *data, size_t size) {
    if (std::fwrite(data, 1, size, file_.get()) != size)
        fail();
}

void OutputFile::finish() {
    if (std::fflush(file_.get()) != 0)
        fail();
    if (!temporary_.empty() && (!set_mode(::fileno(file_.get()), mode_) || ::fsync(::fileno(file_.get())) != 0))
        fail();
}

void OutputFile::commit() {
    finish();
    if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0)
        fail();
    end_unfinished(temporary_);
    temporary_.clear();
    file_.reset();
}

void OutputFile::retract() {
    if (::unlink(target_.c_str()) != 0 && errno != ENOENT)
        fail();
}

OutputFile &OutputFiles::open(const std::string &name, Replaces what) {
    return files_.try_emplace(name, file(name), what).first->second;
}

void OutputFiles::remove(const std::string &name) {
    files_.erase(name);
    removed_.push_back(file(name));
}

void OutputFiles::commit(const std::string &last, const std::function<void()> &write_others) {
    for (auto &[name, file] : files_)
        file.finish();
    files_.at(last).retract();
    write_others();
    for (auto &[name, file] : files_)
        if (name != last)
            file.commit();
    std::error_code error;
    for (const std::string &path : removed_)
        std::filesystem::remove(path, error);
    files_.at(last).commit();
}

OutputFolder::OutputFolder(const std::string &path)
    : OutputFiles(path + "/"), path_(path),
      made_(make_unfinished(path, [&] { return ::mkdir(path.c_str(), 0777) == 0; })) {
    if (!made_ && errno != EEXIST)
        throw Failure(kExitOutput, path + ": cannot be created: " + std::strerror(errno));
    if (exists(path) && !is_folder(path))
        throw Failure(kExitOutput, path + ": is not a folder");
    if (::access(path.c_str(), W_OK | X_OK) != 0)
        throw Failure(kExitOutput, path + ": cannot be written: " + std::strerror(errno));
}

OutputFolder::OutputFolder(const std::string &path, const std::vector<const char *> &names) : OutputFolder(path) {
    for (const char *name : names)
        open(name);
}

OutputFolder::~OutputFolder() {
    files_.clear();
    if (made_)
        ::rmdir(path_.c_str());
    keep();
}

void OutputFolder::keep() noexcept {
    made_ = false;
    end_unfinished(path_);
}

void OutputFolder::commit(const std::string &last) {
    OutputFiles::commit(last);
    keep();
}

void write_csv(OutputFile &out, const std::string &mark, const std::vector<Column> &columns) {
    const char *separator = "";
    out.write(mark);
    for (const Column &column : columns)
        out.write(std::exchange(separator, ",") + column.name);
    for (size_t row = 0; row < columns[0].values->size(); row++) {
        separator = "\n";
        for (const Column &column : columns)
            out.write(std::exchange(separator, ",") + formatted("%.17g", (*column.values)[row]));
    }
    out.write(std::string("\n"));
}

void check_not_input(const std::string &output, const std::vector<std::string> &inputs) {
    std::error_code error;
    const std::string file = output == "-" ? "/proc/self/fd/1" : output;
    for (const std::string &input : inputs)
        if (std::filesystem::is_regular_file(file, error) && std::filesystem::equivalent(file, input, error))
            throw Failure(kExitUsage, (output == "-" ? "standard output" : output) + ": is the input" +
                                          (input == output ? "" : " " + input) + ": give another output");
}

void check_output(const std::string &path) {
    std::error_code error;
    if (path != "-" && std::filesystem::is_other(path, error))
        return; // opening a pipe would wait for its reader, and closing it would end the reader's input
    OutputFile probe(path);
}

void print_stdout(const std::string &text) {
    static std::string waiting; // including text that a signal left unwritten
    static size_t written = 0;
    if (std::fflush(stdout) != 0)
        lost_stdout(errno);
    waiting.erase(0, std::exchange(written, 0)) += text;
    while (written < waiting.size()) {
        pollfd out = {STDOUT_FILENO, POLLOUT, 0};
        if (::poll(&out, 1, kPollTimeout) <= 0) {
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
