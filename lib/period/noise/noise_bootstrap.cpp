// Method: moving blocks of residuals (Kuensch 1989, Ann. Statist. 17, 1217), whitened by the fitted autoregression
// before and coloured after the resampling (Davison and Hinkley 1997, Bootstrap Methods and their Application,
// section 8.2.3). The colouring is implicit: powers are computed from whitened values.
// Why: blocks keep the correlation only within their length. Without whitening, n^(1/3) samples are too short for noise
// with rho = 0.9, and for periods longer than a block.
#include "period/noise/noise_bootstrap.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/workers.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"
#include "period/fap.hpp"

namespace toliman::period {

namespace {

double highest_of(NoiseModel model, const NoiseGrid &grid, size_t block, uint64_t seed) {
    kernels::Rng rng(seed, kernels::kStreamBootstrap);
    const size_t n = model.samples(), starts = n - block + 1;
    const std::vector<double> residuals(model.residuals(), model.residuals() + n);
    std::vector<double> drawn(n), power(grid.nf);
    for (size_t i = 0; i < n; i += block) {
        const auto from = static_cast<size_t>(rng.uniform() * static_cast<double>(starts));
        std::copy_n(&residuals[from], std::min(block, n - i), &drawn[i]);
    }
    if (!model.set_residuals(drawn.data()))
        return 0;
    model.powers(grid.f0, grid.df, grid.nf, power.data());
    const double rest = 1 - *std::max_element(power.begin(), power.end());
    return std::clamp(std::log10(rest), kMinLogResidual, 0.0);
}

} // namespace

void bootstrap_noise(const NoiseModel &model, const NoiseGrid &grid, const NoiseBootstrap &options, double *peaks,
                     size_t count) {
    const size_t n = model.samples();
    const auto usual = static_cast<size_t>(std::ceil(std::cbrt(static_cast<double>(n))));
    const size_t block = options.block != 0 ? options.block : usual;
    run_jobs(
        worker_count(options.workers), count,
        [&](size_t i) { peaks[i] = highest_of(model, grid, block, options.seed + 0x9e3779b97f4a7c15u * i); },
        [&](double fraction) { options.progress.report("bootstrap", fraction); });
    std::sort(peaks, peaks + count);
}

} // namespace toliman::period
