// Power of a whole archive at once, within a guaranteed tolerance: non-uniform FFT, direct sums, exact sums.
#pragma once
#include <cstddef>

#include "base/progress.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

struct BatchSamples {
    const double *t, *y, *sigma; // sigma may be NULL
    size_t n;
    const double *columns = nullptr; // [n][columns of the basis]
};

// The FFT is not used for tolerances below kMinTolerance.
constexpr double kMinTolerance = 1e-13;
constexpr double kMaxTolerance = 1e-2;

struct BatchJob {
    Grid
        grid; // f0, df, nf, fixed_mean, basis without bounds; start = end: the span of the samples. The rest is ignored
    double tolerance = 1e-9;
    unsigned threads = 0;
    Progress progress;
};

// Computes the power at every frequency, in [0, 1], within the tolerance of the result of exact arithmetic. On an
// exception `power` is unchanged.
void batch_power(const BatchJob &job, const BatchSamples &samples, double *power);

} // namespace toliman::period
