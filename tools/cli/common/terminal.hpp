// Progress on standard error.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace cli {

// A line with a bar on a terminal, JSON lines with --progress=json, otherwise nothing. Drawn at most ten times per
// second. The line is never wider than the terminal: first the bar is shortened, then the end is truncated.
class Progress {
  public:
    enum class Style { automatic, json, none };
    explicit Progress(Style style);
    ~Progress();
    // note: a few words after the bar, of printable characters without quotes.
    void show(const char *stage, double fraction, const std::string &note = "");
    // The same without a bar, for work of unknown length. Whether a note would be drawn now: is_due().
    void note(const char *stage, const std::string &text);
    bool is_due() const;
    // Prints the final result on a terminal. It is not redrawn, so it is not truncated.
    void close(const char *stage, const std::string &text);
    // Erases the bar, so that the next message starts at the beginning of the line.
    void clear();
    void warn(const std::string &text);
    void tell(const std::string &text);

    // Callbacks for the library; user_data is the Progress.
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
