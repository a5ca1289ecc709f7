#include "common/terminal.hpp"

#include <cstdlib>
#include <sys/ioctl.h>
#include <unistd.h>

#include "common/common.hpp"

namespace cli {

namespace {

constexpr std::chrono::milliseconds kPause{100};  // between two bars or JSON lines
constexpr std::chrono::seconds kMessagePause{10}; // between two messages, and before the first of a stage

// Current width of the terminal on stderr; if unknown, COLUMNS of the environment, otherwise 80.
size_t columns_now() {
    winsize size = {};
    if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return size.ws_col;
    const char *text = std::getenv("COLUMNS");
    const long columns = text != nullptr ? std::strtol(text, nullptr, 10) : 0;
    return columns > 0 ? static_cast<size_t>(columns) : 80;
}

// A bar of at most 32 characters that fits into `columns` with its brackets and a space; empty if fewer than 8 fit.
std::string bar(double fraction, size_t columns) {
    constexpr size_t most = 32, least = 8, frame = 3;
    if (columns < least + frame)
        return "";
    const size_t width = std::min(columns - frame, most);
    const auto full = static_cast<size_t>(std::lround(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(width)));
    return "[" + std::string(full, '#') + std::string(width - full, '.') + "] ";
}

// "40 s", "3 min", "2.5 h".
std::string rounded(double seconds) {
    return seconds < 90     ? formatted("%.0f s", std::max(1.0, seconds))
           : seconds < 5400 ? formatted("%.0f min", seconds / 60)
                            : formatted("%.1f h", seconds / 3600);
}

std::string padded(const char *stage) {
    return formatted("%-10s ", stage);
}

} // namespace

Progress::Progress(Style style, Clock::time_point (*now)())
    : form_(style == Style::json           ? Form::json
            : style == Style::none         ? Form::none
            : ::isatty(STDERR_FILENO) != 0 ? Form::bar
                                           : Form::messages),
      now_(now) {}

Progress::~Progress() {
    clear();
}

void Progress::show(const char *stage, double fraction, const std::string &note) {
    if (form_ == Form::none)
        return;
    const Clock::time_point now = now_();
    const bool begins = stage_ != stage;
    if (begins || fraction < fraction_) { // the latter begins the next file of the same stage
        stage_start_ = now;
        first_fraction_ = fraction; // above 0 for work that is resumed
    }
    stage_ = stage;
    fraction_ = fraction;
    const std::chrono::duration<double> elapsed = now - stage_start_;
    const bool due = form_ == Form::messages
                         ? fraction < 1 && std::min(now - last_, now - stage_start_) >= kMessagePause
                         : begins || fraction >= 1 || now - last_ >= kPause;
    if (!due)
        return;
    last_ = now;
    // No estimate of the time left before 2 % and half a second.
    const double done = fraction - first_fraction_;
    const bool estimated = fraction >= 1 || (done >= 0.02 && elapsed.count() >= 0.5);
    const double left = fraction >= 1 ? 0 : estimated ? elapsed.count() * (1 - fraction) / done : NAN;
    if (form_ == Form::messages)
        tell(formatted("%s %.0f %%", stage, 100 * fraction) + (estimated ? ", about " + rounded(left) + " left" : ""));
    else if (form_ == Form::json)
        std::fprintf(stderr, "{\"progress\":\"%s\",\"fraction\":%.4f,\"seconds_left\":%s%s}\n", stage, fraction,
                     (estimated ? formatted("%.1f", left) : "null").c_str(),
                     note.empty() ? "" : (",\"note\":\"" + note + "\"").c_str());
    else
        draw_bar(stage, fraction, left, note);
}

void Progress::draw_bar(const char *stage, double fraction, double seconds_left, const std::string &note) {
    const std::string time = std::isnan(seconds_left) ? "estimating" : formatted("%.0f s left", seconds_left);
    const std::string head = padded(stage),
                      tail = formatted("%3.0f %%  ", 100 * fraction) + time + (note.empty() ? "" : "  " + note);
    const size_t columns = columns_now(), used = head.size() + tail.size() + 1;
    draw(head + bar(fraction, columns > used ? columns - used : 0) + tail, columns);
}

bool Progress::is_due() const {
    return (form_ == Form::bar || form_ == Form::json) && now_() - last_ >= kPause;
}

void Progress::note(const char *stage, const std::string &text) {
    if (!is_due())
        return;
    last_ = now_();
    if (form_ == Form::json)
        std::fprintf(stderr, "{\"progress\":\"%s\",\"note\":\"%s\"}\n", stage, text.c_str());
    else
        draw(padded(stage) + text, columns_now());
}

void Progress::close(const char *stage, const std::string &text) {
    if (form_ == Form::bar)
        std::fprintf(stderr, "\r\033[K%s%s\n", padded(stage).c_str(), text.c_str());
    drawn_ = false;
}

void Progress::line(const char *stage, const std::string &text) {
    if (form_ == Form::json)
        std::fprintf(stderr, "{\"progress\":\"%s\",\"note\":\"%s\"}\n", stage, text.c_str());
    else if (form_ != Form::none)
        tell(std::string(stage) + ": " + text);
}

// The last column stays free: some terminals begin a new line after it.
void Progress::draw(std::string line, size_t columns) {
    if (line.size() >= columns) {
        line.resize(columns - 1);
        std::fill(line.begin() + std::max<ptrdiff_t>(0, static_cast<ptrdiff_t>(columns) - 4), line.end(), '.');
    }
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
    drawn_ = true;
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
    // The library's stage may have a note after a colon.
    const std::string text = stage, name = text.substr(0, text.find(": "));
    static_cast<Progress *>(user_data)->show(name.c_str(), fraction, name == text ? "" : text.substr(name.size() + 2));
    return stop_signal() != 0 ? 1 : 0;
}

void Progress::log(int32_t level, const char *text, void *user_data) {
    static_cast<Progress *>(user_data)->clear();
    std::fprintf(stderr, "toliman: %s%s\n", level == TOLIMAN_LOG_WARNING ? "warning: " : "", text);
}

} // namespace cli
