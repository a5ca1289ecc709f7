// Progress on standard error.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace cli {

// A line with a bar on a terminal, drawn at most ten times per second; otherwise, as in the log of a service, a message
// after each 10 s of a stage; JSON lines with --progress=json. The line with a bar is never wider than the terminal:
// first the bar is shortened, then the end is truncated.
class Progress {
  public:
    enum class Style { automatic, json, none };
    using Clock = std::chrono::steady_clock;
    explicit Progress(Style style, Clock::time_point (*now)() = Clock::now);
    ~Progress();
    // note: a few words after the bar, of printable characters without quotes; messages have none.
    void show(const char *stage, double fraction, const std::string &note = "");
    // The same without a bar and time left, for work of unknown length, on a terminal and in JSON. Whether a note would
    // be drawn now: is_due().
    void note(const char *stage, const std::string &text);
    bool is_due() const;
    // Prints the final result on a terminal. It is not redrawn, so it is not truncated.
    void close(const char *stage, const std::string &text);
    // A line that stays, also in a log; in JSON as note() without a limit of time.
    void line(const char *stage, const std::string &text);
    // Erases the bar, so that the next message starts at the beginning of the line.
    void clear();
    void warn(const std::string &text);
    void tell(const std::string &text);

    // Callbacks for the library; user_data is the Progress.
    static int32_t callback(const char *stage, double fraction, void *user_data);
    static void log(int32_t level, const char *text, void *user_data);

  private:
    enum class Form { bar, messages, json, none };
    void draw(std::string line, size_t columns);
    void draw_bar(const char *stage, double fraction, double seconds_left, const std::string &note);

    Form form_;
    Clock::time_point (*now_)();
    bool drawn_ = false;
    std::string stage_;
    double fraction_ = 0, first_fraction_ = 0; // shown last, and first in this stage
    Clock::time_point stage_start_, last_;
};

} // namespace cli
