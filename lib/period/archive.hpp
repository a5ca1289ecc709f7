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
    Buffer<double> t_high, t_low; // t less its weighted mean, an unevaluated sum
    Buffer<double> w;             // weights; their sum is 1
    Buffer<double> x;             // w times the value about the mean, in standard deviations; empty if that is 0
    double largest_sum;           // of |x|; at most 1
    double reference;             // what t_high + t_low counts from
    double first_value, value_bound, least_sigma, most_sigma;
};

} // namespace toliman::period
