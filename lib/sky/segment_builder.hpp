// Collects the states of a segment from a file and checks them.
#pragma once
#include <string>
#include <vector>

#include "ingest/epoch.hpp"
#include "sky/ephemeris.hpp"

namespace toliman::sky {

// Units of the numbers in a file, for messages.
struct Units {
    const char *position = "km", *velocity = "km/s";
};

// Every failure is Status::format with file, line and reason.
class SegmentBuilder {
  public:
    // line: at which the segment begins.
    SegmentBuilder(std::string path, int line, Units units) : path_(std::move(path)), units_(units), lines_(1, line) {}

    // A state after all others, at a possible place and speed.
    void add(int64_t tai_ns, const State &state, int line);

    int64_t first_ns() const { return segment_.tai_ns.front(); }
    int64_t last_ns() const { return segment_.tai_ns.back(); }
    bool is_empty() const noexcept { return segment_.states.empty(); }

    // The segment, usable from its first to its last state. Checks the number of states, and that velocities agree with
    // positions and with the Earth's attraction. Warns once where states are too far apart to interpolate.
    Segment finish(const Log &log);

  private:
    struct Interval;

    int line_of(size_t state) const noexcept { return lines_[state + 1]; }
    void check_motion(size_t stride) const;
    bool check_velocity(const Interval &interval) const;
    void check_attraction(const Interval &interval) const;
    void warn_of_gaps(const Log &log) const;

    std::string path_;
    Units units_;
    Segment segment_;
    std::vector<int> lines_; // of the segment, of its states
};

// Appends a segment, whose usable times must not begin before those of the last one end.
void append_segment(std::vector<Segment> &segments, Segment segment, const ingest::TextPlace &place);

// A finite decimal number that is the whole text, with an optional sign; NaN for other texts.
double number_of(std::string_view text) noexcept;

} // namespace toliman::sky
