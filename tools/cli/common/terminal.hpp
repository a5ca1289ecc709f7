// Progress on stderr, and signals turned into a clean stop.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "common/failure.hpp"

namespace cli {

// Installs handlers for SIGINT, SIGTERM and SIGHUP (unless it is ignored, as by nohup) that only take note.
void watch_signals();
// The signal that asked to stop, 0 if none, and the exit code that tells of it.
int stop_signal() noexcept;
ExitCode stop_code() noexcept;
// Throws Failure with that exit code once a signal has asked to stop.
void stop_if_asked();

// From now on every minute, and at every SIGALRM, an alarm: whether there was one since the last call.
void set_alarm();
bool alarm_rang() noexcept;

// A line with a bar on a terminal, a JSON line per step with --progress=json, else nothing. Drawn at most ten times per
// second. The line is never wider than the terminal is at that moment: the bar is shortened first, then the end is cut.
class Progress {
  public:
    enum class Style { automatic, json, none };
    explicit Progress(Style style);
    ~Progress();
    // note: a few words beside the bar, of printable characters without quotes.
    void show(const char *stage, double fraction, const std::string &note = "");
    // The same for a work without a known end: words alone.
    void note(const char *stage, const std::string &text);
    // Prints the result of the whole work on a terminal. It is not redrawn, so never cut.
    void close(const char *stage, const std::string &text);
    // Ends the bar's line, so that what follows on stderr starts at its beginning.
    void clear();
    void warn(const std::string &text);
    void tell(const std::string &text);

    // For the library: user_data is the Progress.
    static int32_t callback(const char *stage, double fraction, void *user_data);
    static void log(int32_t level, const char *text, void *user_data);

  private:
    void draw(std::string line, size_t columns);

    Style style_;
    bool drawn_ = false;
    std::string stage_;
    std::chrono::steady_clock::time_point stage_start_, last_;
};

} // namespace cli
