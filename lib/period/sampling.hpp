// What is known of the samples' times: for false alarm probabilities and for judging a grid.
#pragma once
#include <vector>

#include "period/fap.hpp"
#include "period/stream.hpp"

namespace toliman::period {

constexpr double kRounding = 1 + 1e-9; // a grid up to the very limit is not beyond it

Sampling sampling_of(const Stream &stream) noexcept;

// Time span with one step added, and the step: of N times dt apart N dt and dt. 0 where all times are one.
struct Cadence {
    double span, step;
};

// From the sums alone, as if the samples were evenly spread: span by the variance of the times, step = span/N.
Cadence cadence_of(const Stream &stream) noexcept;
// The step of an even series of equal sigmas, exactly.
double even_step(const Stream &stream) noexcept;
// From finite times: the median step between distinct ones.
Cadence cadence_of(std::vector<double> times);
// From the times that were pushed. Fails if they are not as many.
Cadence cadence_of(const Stream &stream, const double *t, size_t count);

} // namespace toliman::period
