// Sampling diagnostics: time span and step of the samples, for false alarm probabilities and for checking a grid.
#pragma once
#include <vector>

#include "period/fap.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

constexpr double kRounding = 1 + 1e-9; // tolerance of a grid that ends exactly at a limit

Sampling sampling_of(const Stream &stream) noexcept;

// Time span including one step, and the step: N dt and dt for N times dt apart. All 0 if all times are equal.
struct Cadence {
    double span, step;
    double finest; // 1/(2 finest) is the last frequency worth a search: see finest_step
};

// For regular samples, whose gaps are multiples of one step to 5 % of it: this step. Above 1/(2 step) they repeat the
// spectrum below. Otherwise a fifth of the gap that 5 % of the gaps do not exceed: unequal gaps tell frequencies above
// 1/(2 gap) from their aliases. gaps: at least one, of different times.
double finest_step(std::vector<double> gaps);

// From the sums, assuming uniform coverage: span = sqrt(12 var t), step = span/N.
Cadence cadence_of(const Stream &stream) noexcept;
Cadence cadence_of(const Sampling &sampling) noexcept;
// Exact step of an evenly spaced series with equal sigmas.
double even_step(const Stream &stream) noexcept;
// From finite times: the median step between distinct ones.
Cadence cadence_of(std::vector<double> times);
// Likewise, from the times that were pushed. Fails if their number differs from that of the samples.
Cadence cadence_of(const Stream &stream, const double *t, size_t count);

} // namespace toliman::period
