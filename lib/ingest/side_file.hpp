// The growing side file: splits what is new into lines.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "backend/file.hpp"

namespace toliman::ingest {

class SideFile {
  public:
    using Sink = std::function<void(const std::string &line, int64_t number)>;

    // Gives `sink` each line of the first `size` bytes that it has not had yet, without the newline, and its number
    // from 1. Blank lines are counted, but not given. A line longer than
    // kLongestLine may be given as another text that is too long. A last line without newline is given if `complete`. A
    // line for which sink throws is given again by the next call.
    void read(const file::Reader &file, uint64_t size, bool complete, const Sink &sink);

  private:
    void give(const char *text, size_t length, const Sink &sink);
    const char *split(const char *text, const char *end, const Sink &sink);

    uint64_t position_ = 0; // of the first byte that was not given
    int64_t lines_ = 0;     // before position_
    bool too_long_ = false; // position_ is within a line that is too long
};

} // namespace toliman::ingest
