#include "common/terminal.hpp"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <sys/time.h>
#include <unistd.h>

namespace cli {

namespace {

volatile std::sig_atomic_t asked = 0, rang = 0;

void take_note(int signal) {
    asked = signal;
}

void ring(int) {
    rang = 1;
}

} // namespace

void watch_signals() {
    struct sigaction action = {};
    action.sa_handler = take_note;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    struct sigaction hangup = {};
    if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
        ::sigaction(SIGHUP, &action, nullptr);
    // A closed pipe and a file beyond the limit of sizes are then write errors with a message.
    ::signal(SIGPIPE, SIG_IGN);
    ::signal(SIGXFSZ, SIG_IGN);
}

int stop_signal() noexcept {
    return asked;
}

ExitCode stop_code() noexcept {
    return static_cast<ExitCode>(128 + asked); // as shells have it
}

void stop_if_asked() {
    if (asked != 0)
        throw Failure(stop_code(), "stopped by a signal");
}

void set_alarm() {
    struct sigaction action = {};
    action.sa_handler = ring;
    action.sa_flags = SA_RESTART; // no write fails for it
    ::sigaction(SIGALRM, &action, nullptr);
    itimerval minute = {};
    minute.it_interval.tv_sec = minute.it_value.tv_sec = 60;
    ::setitimer(ITIMER_REAL, &minute, nullptr);
}

bool alarm_rang() noexcept {
    const bool result = rang != 0;
    rang = 0;
    return result;
}

Progress::Progress(Style style) : style_(style) {
    if (style_ == Style::automatic && ::isatty(STDERR_FILENO) == 0)
        style_ = Style::none;
}

Progress::~Progress() {
    clear();
}

void Progress::show(const char *stage, double fraction, const std::string &note) {
    using std::chrono::steady_clock;
    if (style_ == Style::none)
        return;
    const auto now = steady_clock::now();
    if (stage_ != stage) {
        stage_ = stage;
        stage_start_ = now;
    } else if (fraction < 1 && now - last_ < std::chrono::milliseconds(100)) {
        return;
    }
    last_ = now;
    const double elapsed = std::chrono::duration<double>(now - stage_start_).count();
    const double left = fraction > 0.02 ? elapsed * (1 - fraction) / fraction : 0;
    if (style_ == Style::json) {
        std::fprintf(stderr, "{\"progress\":\"%s\",\"fraction\":%.4f,\"seconds_left\":%.1f%s}\n", stage, fraction, left,
                     note.empty() ? "" : (",\"note\":\"" + note + "\"").c_str());
        return;
    }
    constexpr int width = 32;
    char bar[width + 1];
    for (int i = 0; i < width; i++)
        bar[i] = i < std::lround(fraction * width) ? '#' : '.';
    bar[width] = '\0';
    std::fprintf(stderr, "\r\033[K%-10s [%s] %3.0f %%  %.0f s left%s%s", stage, bar, 100 * fraction, left,
                 note.empty() ? "" : "  ", note.c_str());
    std::fflush(stderr);
    drawn_ = true;
}

void Progress::note(const char *stage, const std::string &text) {
    const auto now = std::chrono::steady_clock::now();
    if (style_ == Style::none || now - last_ < std::chrono::milliseconds(100))
        return;
    last_ = now;
    if (style_ == Style::json) {
        std::fprintf(stderr, "{\"progress\":\"%s\",\"note\":\"%s\"}\n", stage, text.c_str());
        return;
    }
    std::fprintf(stderr, "\r\033[K%-10s %s", stage, text.c_str());
    std::fflush(stderr);
    drawn_ = true;
}

void Progress::close(const char *stage, const std::string &text) {
    if (drawn_)
        std::fprintf(stderr, "\r\033[K%-10s %s\n", stage, text.c_str());
    drawn_ = false;
}

void Progress::clear() {
    if (drawn_)
        std::fprintf(stderr, "\r\033[K");
    drawn_ = false;
}

void Progress::warn(const std::string &text) {
    log(TOLIMAN_LOG_WARNING, text.c_str(), this);
}

void Progress::tell(const std::string &text) {
    log(TOLIMAN_LOG_INFO, text.c_str(), this);
}

int32_t Progress::callback(const char *stage, double fraction, void *user_data) {
    // What follows a colon is a remark on how the stage goes.
    const std::string text = stage, name = text.substr(0, text.find(": "));
    static_cast<Progress *>(user_data)->show(name.c_str(), fraction, name == text ? "" : text.substr(name.size() + 2));
    return asked != 0 ? 1 : 0;
}

void Progress::log(int32_t level, const char *text, void *user_data) {
    static_cast<Progress *>(user_data)->clear();
    std::fprintf(stderr, "toliman: %s%s\n", level == TOLIMAN_LOG_WARNING ? "warning: " : "", text);
}

} // namespace cli
