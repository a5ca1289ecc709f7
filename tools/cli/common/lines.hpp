// Reads lines of text as they arrive, from a file, a pipe or standard input.
#pragma once
#include "common/common.hpp"

namespace cli {

class LineSource {
  public:
    // Longest line in bytes. A longer line is returned with its first kLongest + 1 bytes, so that input without
    // newlines does not use up the memory.
    static constexpr size_t kLongest = 1 << 16;

    // path: a file, or - for standard input. on_idle is called before every line and, while no line arrives, every
    // second and after every signal. It ends the wait by throwing.
    LineSource(const std::string &path, std::function<void()> on_idle);
    ~LineSource();
    LineSource(const LineSource &) = delete;
    LineSource &operator=(const LineSource &) = delete;

    // False at the end. An incomplete line is discarded when on_idle throws; it is never returned as a whole one.
    bool next(std::string &line);
    bool whole() const noexcept { return !ended_; } // the last line had its newline
    const std::string &name() const noexcept { return name_; }

  private:
    bool fill();
    std::string name_; // the input's name in messages
    std::function<void()> on_idle_;
    int file_;
    std::vector<char> buffer_;
    size_t at_ = 0, held_ = 0; // position and end of the bytes in the buffer
    bool ended_ = false;
};

} // namespace cli
