// Method: nonparametric bootstrap (VanderPlas 2018, ApJS 236, 16). Each resampling keeps the times and draws (value,
// sigma) pairs with replacement, so that the window function remains and a periodic signal is destroyed. The FAP of a
// peak is (k + 1)/(count + 1), k the number of resamplings with a peak at least as high.
// With nuisance functions, the values drawn are the residuals of these functions: the values themselves would carry the
// trend to other times, where it is noise.
// Why: it assumes no distribution of the noise; its cost is one full periodogram per resampling. Resampling i draws
// from its own counter-based stream, so that the result does not depend on the number of workers.
#include "period/bootstrap.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/workers.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"
#include "period/sample_basis.hpp"
#include "period/stream/power.hpp"

namespace toliman::period {

namespace {

double largest_magnitude(const std::vector<double> &values) noexcept {
    double largest = 0;
    for (const double value : values)
        largest = std::max(largest, std::fabs(value));
    return largest;
}

double highest_of(const Grid &grid, const Samples &samples, uint64_t seed) {
    kernels::Rng rng(seed, kernels::kStreamBootstrap);
    Stream stream(grid);
    for (size_t i = 0; i < samples.count; i++) {
        const auto drawn = static_cast<size_t>(rng.uniform() * static_cast<double>(samples.count));
        const double sigma = samples.sigma != nullptr ? samples.sigma[drawn] : grid.sigma_floor;
        Sample sample = sample_of(stream, samples, i); // its time and columns
        sample.y = samples.y[drawn];
        sample.sigma = sigma;
        stream.push(sample);
    }
    const PowerQuery query(stream); // not meaningful if one value was drawn every time
    return query.meaningful() && query.resolved() ? highest_log10_residual(stream) : 0;
}

} // namespace

void bootstrap(const Stream &stream, const Samples &samples, const Bootstrap &options, double *peaks, size_t count) {
    check_pushed(stream, samples);
    Grid grid = stream.grid();
    Samples drawn = samples;
    std::vector<double> residuals;
    if (grid.basis.any()) {
        residuals = nuisance_residuals(stream, samples);
        drawn.y = residuals.data();
        grid.value_offset = 0;
        grid.value_bound = std::max(grid.value_bound, largest_magnitude(residuals));
    }
    run_jobs(
        worker_count(options.workers), count,
        [&](size_t i) { peaks[i] = highest_of(grid, drawn, options.seed + 0x9e3779b97f4a7c15u * i); },
        [&](double fraction) { options.progress.report("bootstrap", fraction); });
    std::sort(peaks, peaks + count);
}

} // namespace toliman::period
