// Method: poll(2) with a timeout of a second before every read, so that a signal that arrives just before a blocking
// call is noticed within that second, and slow input can be followed without a thread.
#include "common/lines.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

namespace cli {

namespace {
constexpr size_t kBuffer = 1 << 16;
} // namespace

LineSource::LineSource(const std::string &path, std::function<void()> on_idle)
    : name_(path == "-" ? "standard input" : path), on_idle_(std::move(on_idle)),
      file_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)), buffer_(kBuffer) {
    if (file_ < 0) {
        const int reason = errno;
        on_idle_(); // a signal may have interrupted the wait for the pipe's writer
        malformed(name_, std::strerror(reason));
    }
}

LineSource::~LineSource() {
    if (file_ != STDIN_FILENO)
        ::close(file_);
}

bool LineSource::next(std::string &line) {
    line.clear();
    while (!ended_) {
        on_idle_();
        const char *start = buffer_.data() + at_;
        const auto *newline = static_cast<const char *>(std::memchr(start, '\n', held_ - at_));
        const size_t length = newline != nullptr ? static_cast<size_t>(newline - start) : held_ - at_;
        line.append(start, std::min(length, kLongest + 1 - line.size()));
        at_ += length + 1;
        if (newline != nullptr)
            return true;
        ended_ = !fill();
    }
    on_idle_(); // Ctrl-C also ends the process that writes to the pipe: report the signal, not the end of the input
    return !line.empty();
}

// False at the end.
bool LineSource::fill() {
    for (;;) {
        on_idle_();
        pollfd waiting = {file_, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, kPollTimeout);
        if (ready == 0 || (ready < 0 && errno == EINTR))
            continue;
        const ssize_t count = ::read(file_, buffer_.data(), buffer_.size());
        if (count < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (count < 0)
            malformed(name_, std::string("cannot be read: ") + std::strerror(errno));
        at_ = 0;
        held_ = static_cast<size_t>(count);
        return count > 0;
    }
}

} // namespace cli
