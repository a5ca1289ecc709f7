// Power of a whole archive at once: non-uniform FFT, direct sums where it is not enough, exact sums where those are
// not.
#pragma once
#include <cstddef>

#include "base/progress.hpp"
#include "period/stream.hpp"

namespace toliman::period {

struct BatchSamples {
    const double *t, *y, *sigma; // sigma may be nullptr
    size_t n;
};

// Tolerances below it go without the FFT.
constexpr double kLeastTolerance = 1e-13;
constexpr double kMostTolerance = 1e-2;

struct BatchJob {
    Grid grid; // f0, df, nf, fixed_mean; the rest is not looked at
    double tolerance = 1e-9;
    unsigned threads = 0;
    Progress progress;
};

// Power of every frequency, in [0, 1], within the tolerance of what exact arithmetic gives. Throws with `power` as it
// was.
void batch_power(const BatchJob &job, const BatchSamples &samples, double *power);

} // namespace toliman::period
