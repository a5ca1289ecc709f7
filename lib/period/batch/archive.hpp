// Samples prepared for sums in double: centred and scaled, so that every sum is a mean of numbers of order 1.
#pragma once
#include "base/buffer.hpp"
#include "period/batch/batch.hpp"

namespace toliman::period {

struct Archive {
    // Fails naming the first invalid sample. Phases at frequencies up to `last` must be below 2^50 cycles.
    Archive(const BatchSamples &given, double last);

    bool constant() const noexcept { return x.empty(); }

    BatchSamples samples; // as given
    size_t n;
    Buffer<double> t_high, t_low; // t - reference, as an unevaluated sum
    Buffer<double> w;             // weights; their sum is 1
    Buffer<double> x;             // w (y - mean)/(standard deviation); empty if the values are constant
    double largest_sum = 0;       // of |x|; at most 1
    // The sample time nearest to the weighted mean: at aliases of 0 the phases of evenly spaced times are then exactly
    // 0, and a sample that outweighs all others has phase 0 at every frequency.
    double reference = 0;
    double first_value = 0, value_bound = 0; // |y - first_value| <= value_bound
    double least_sigma = 1, most_sigma = 1;
    double unit_variance = 1;                // 1/sum of 1/sigma^2
    double mean_in_deviations = 0;           // mean of y, about 0, over its standard deviation
    double value_scale = 1, sigma_scale = 1; // powers of two that bring value_bound and least_sigma to [1/2, 1)
};

} // namespace toliman::period
