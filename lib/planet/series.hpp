// The measurements, prepared for fits: centred, padded for the kernels, with their nuisance functions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/buffer.hpp"

namespace toliman::planet {

// What the caller gives; sigma, columns and position_angle_deg may be NULL.
struct GivenSeries {
    size_t n;
    const double *t, *y, *sigma;
    const double *rows;               // [n][columns]
    const double *position_angle_deg; // [n]
    int32_t trend, columns;
    double trend_start, trend_end;
    const double *precision; // [1 + trend + columns]
    bool velocity;
    double frame_chi_square; // median of the frames; 0: unknown
};

// A function whose coefficient is fitted. The coefficient may have a Gaussian prior.
struct Function {
    Buffer<double> values; // [rows of the series]
    double precision = 0;  // 1/sigma^2 of the prior; 0: none
    double target = 0;     // its mean
};

struct Series {
    size_t n = 0, rows = 0; // measurements; the next multiple of kernels::kRowLanes
    size_t used = 0;        // measurements that are not left out
    double time_reference = 0;
    double span = 0;            // last time - first time
    Buffer<double> t, y, sigma; // [rows], about the time reference and the median; sigma is 0 without sigmas
    Buffer<double> factor;      // [rows], of the weights: 1; 0 for measurements that are left out, and in the padding
    Buffer<double> axis_cosine, axis_sine; // [rows], of the angle from the mean axis; empty: the axis is fixed
    double axis = 0, turn = 0;             // position angle of the mean axis, and its range, rad
    std::vector<Function> functions;       // mean, trend, columns
    size_t trend = 0;                      // highest order of the trend
    bool velocity = false;
    double median_sigma = 0; // 0 without sigmas

    // Fails, naming the member, for numbers that are not finite or out of their range.
    explicit Series(const GivenSeries &given);

    // Number of amplitudes of a signal: along the mean axis, and across if the axis turns.
    size_t amplitudes() const noexcept { return axis_cosine.empty() ? 2 : 4; }
    // Leaves out the measurements that are marked, and no others.
    void leave_out(const std::vector<bool> &marked);
    // factor/sqrt(sigma^2 + jitter^2); 0 in the padding.
    Buffer<double> weights(double jitter) const;
};

} // namespace toliman::planet
