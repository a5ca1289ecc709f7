// Positions and velocities of a spacecraft relative to the Earth's centre, from a file, and between its rows.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/progress.hpp"
#include "ingest/leap_seconds.hpp"

namespace toliman::sky {

// Relative to the Earth's centre, along the axes of the ICRS.
struct State {
    double position_m[3] = {0, 0, 0}, velocity_m_s[3] = {0, 0, 0};
};

// States of one arc without manoeuvre, at increasing times. No state is interpolated between two segments.
struct Segment {
    std::vector<int64_t> tai_ns;
    std::vector<State> states;
    int64_t first_ns = 0, last_ns = 0; // usable times, within those of the states
};

// Status::range: there is no state for a time.
class NoState final : public Error {
  public:
    explicit NoState(const Error &error) noexcept : Error(error) {}
};

class Ephemeris {
  public:
    static constexpr size_t kPoints = 8; // of the interpolation; no segment has fewer states

    // source: the name of the file, for messages. segments: at least one, increasing, not overlapping.
    Ephemeris(std::string source, std::vector<Segment> segments);

    // The state at a time; one that two segments share belongs to the later segment. Throws NoState, with the covered
    // times, outside the usable times of all segments, and where the states are too far apart to interpolate the
    // velocity to 1 m/s. Any number of threads may call it.
    State at(int64_t tai_ns) const;

    // Whether a segment is usable at a time.
    bool covers(int64_t tai_ns) const noexcept;

    // Throws NoState unless the segments have states for a whole interval.
    void check_interval(int64_t start_ns, int64_t end_ns) const;

    const std::string &source() const noexcept { return source_; }
    const std::vector<Segment> &segments() const noexcept { return segments_; }

  private:
    State known_state(int64_t tai_ns) const; // as at(), but throws Error

    std::string source_;
    std::vector<Segment> segments_;
};

// Reads a CCSDS Orbit Ephemeris Message in key-value notation (its first line has CCSDS_OEM_VERS), or a table in CSV,
// of at most 256 MiB. leap_seconds: for times in UTC. Warns once per segment if some of its states are too far apart.
// Status::not_found; Status::format with file, line and reason.
Ephemeris read_ephemeris(const std::string &path, const ingest::LeapSeconds &leap_seconds, const Log &log);

} // namespace toliman::sky
