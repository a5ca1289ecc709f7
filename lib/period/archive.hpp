// Samples made ready for sums in double: centred, and scaled so that every sum is a mean of numbers about 1.
#pragma once
#include "base/buffer.hpp"
#include "period/batch.hpp"

namespace toliman::period {

struct Archive {
    // Fails with the first bad sample. Frequencies up to `last` must have less than 2^50 cycles.
    Archive(const BatchSamples &given, double last);

    bool constant() const noexcept { return x.empty(); }

    BatchSamples samples; // as they came
    size_t n;
    Buffer<double> t_high, t_low; // t less the reference, an unevaluated sum
    Buffer<double> w;             // weights; their sum is 1
    Buffer<double> x;             // w times the value about the mean, in standard deviations; empty if that is 0
    double largest_sum = 0;       // of |x|; at most 1
    double reference = 0; // the time nearest to the weighted mean: even times and one heavy sample then have phases 0
    double first_value = 0, value_bound = 0; // values are within value_bound of the first
    double least_sigma = 1, most_sigma = 1;
    double value_scale = 1, sigma_scale = 1; // powers of two that bring value_bound and least_sigma near 1
};

} // namespace toliman::period
