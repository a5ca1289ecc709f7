// Interpolates the states of a segment.
#pragma once
#include "sky/ephemeris.hpp"

namespace toliman::sky {

struct Interpolated {
    State state;
    double doubt_m_s; // distance of the velocity from that of an interpolation with two points fewer
    double step_s;    // between the neighbouring states
};

// tai_ns: from the first state to the last one.
Interpolated interpolate(const Segment &segment, int64_t tai_ns) noexcept;
// The same; after: the first state after the time.
Interpolated interpolate(const Segment &segment, size_t after, int64_t tai_ns) noexcept;

constexpr double kMostDoubt = 1; // m/s; a velocity along the star of 1 m/s is 0.03 uas

} // namespace toliman::sky
