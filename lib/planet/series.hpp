// The measurements, prepared for fits: centred, padded for the kernels, with their nuisance functions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/buffer.hpp"

namespace toliman::planet {

// Measurements as they are given.
struct GivenSeries {
    std::vector<double> t, y, sigma;        // [n]; sigma: empty if it is not known
    std::vector<double> rows;               // [n][columns]
    std::vector<double> position_angle_deg; // [n], or empty
    int32_t trend, columns;
    double trend_start, trend_end;
    std::vector<double> precision; // [1 + trend + columns]
    bool velocity;
    double frame_chi_square;         // median of the frames; 0: unknown
    std::vector<int32_t> instrument; // [n], index of the instrument of each; empty: one instrument
    std::vector<size_t> offsets;     // of each instrument, index of the column of its offset; not of the first
    std::string name;                // in messages

    size_t n() const noexcept { return t.size(); }
};

// Radial velocities of the stars A and B of a series of separations.
struct GivenVelocities {
    std::optional<GivenSeries> of[2]; // with sigmas
    // Velocity, in units of the velocities, of a star that moves by one unit of y times one radian per unit of t.
    double per_motion[2] = {0, 0};
};

// A function whose coefficient is fitted. The coefficient may have a Gaussian prior.
struct Function {
    Buffer<double> values; // [rows of the series]
    double precision = 0;  // 1/sigma^2 of the prior; 0: none
    double target = 0;     // its mean
    std::string name = {}; // of those of a series, in messages
};

// Measurements of one instrument, of consecutive or scattered rows.
struct Group {
    size_t first, count; // of the series that it belongs to
    int32_t instrument;  // index in that series
    int32_t source;      // 0: the series; 1, 2: velocities of A, B
    size_t offset;       // index of its function: the difference from the mean of the first instrument
};

struct Series {
    size_t n = 0, rows = 0; // measurements; the next multiple of kernels::kRowLanes
    size_t primary = 0;     // the first measurements, those of the series; then come velocities of A, and of B
    size_t used = 0;        // measurements that are not left out
    double time_reference = 0;
    double span = 0;            // last time - first time
    Buffer<double> t, y, sigma; // [rows], about the time reference and the median; sigma is 0 without sigmas
    Buffer<double> factor;      // [rows], of the weights: 1; 0 for measurements that are left out, and in the padding
    Buffer<double> axis_cosine, axis_sine; // [rows], of the angle from the mean axis; empty: the axis is fixed
    double axis = 0, turn = 0;             // position angle of the mean axis, and its range, rad
    Buffer<double> motion[2]; // [rows], per_motion in the rows of the velocities of A, and of B; empty: no velocities
    std::vector<Function> functions; // mean, trend, columns; the same of velocities
    std::vector<Group> groups;       // at least one
    std::vector<uint32_t> group;     // [n], of each measurement
    bool velocity = false;
    double median_sigma = 0; // of the series itself; 0 without sigmas

    // Fails, naming the member, for numbers that are not finite or out of their range.
    explicit Series(const GivenSeries &given, const GivenVelocities &velocities = {});

    bool has_velocities() const noexcept { return !motion[0].empty(); }
    // Number of amplitudes of a signal: along the mean axis, across if the axis turns, and along the line of sight if
    // there are velocities.
    size_t amplitudes() const noexcept { return (axis_cosine.empty() ? 2 : 4) + (has_velocities() ? 2 : 0); }
    // Leaves out the measurements that are marked, and no others.
    void leave_out(const std::vector<bool> &marked);
    // factor/sqrt(sigma^2 + jitter^2), with the jitter times the scale of its group; 0 in the padding.
    Buffer<double> weights(double jitter) const;

    // Jitter of each group over the common one; all 1 at first.
    const std::vector<double> &jitter_scales() const noexcept { return jitter_scales_; }
    void set_jitter_scales(const std::vector<double> &scales) { jitter_scales_ = scales; }
    double jitter_scale(size_t i) const noexcept { return jitter_scales_[group[i]]; }

  private:
    void add(const GivenSeries &given, int32_t source, size_t first);
    std::vector<double> jitter_scales_;
};

} // namespace toliman::planet
