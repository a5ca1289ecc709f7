// Lines of text as they come, from a file, a pipe or standard input.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace cli {

// A line of a file. Messages call it by its text, which takes longer to make than most lines to read.
struct LinePlace {
    const std::string &file;
    int number;
    std::string text() const { return file + ":" + std::to_string(number); }
};

class LineSource {
  public:
    // A line that has more bytes comes as one more than so many, the rest left out: without any newline it would take
    // all memory.
    static constexpr size_t kLongest = 1 << 16;

    // path: a file, or - for standard input. `awake` is called before every line and, while none comes, every second
    // and after every signal; it ends the waiting by throwing.
    LineSource(const std::string &path, std::function<void()> awake);
    ~LineSource();
    LineSource(const LineSource &) = delete;
    LineSource &operator=(const LineSource &) = delete;

    // False at the end. A line that is under way when `awake` throws is lost, never taken for a whole one.
    bool next(std::string &line);
    bool whole() const noexcept { return !ended_; } // the last line had its newline
    const std::string &name() const noexcept { return name_; }

  private:
    bool fill();
    std::string name_; // as messages call it
    std::function<void()> awake_;
    int file_;
    std::vector<char> buffer_;
    size_t at_ = 0, held_ = 0; // of the buffer: read up to, filled up to
    bool ended_ = false;
};

} // namespace cli
