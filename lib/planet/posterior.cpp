// Method: systematic resampling of the cells by their mass, a uniform point inside each drawn cell, and there a scale
// of the jitter and of the amplitudes by their evidences and amplitudes from their Gaussian. Cells are below half a
// standard deviation, which widens a marginal by at most 1 %. The jitter of the whitening is that of its node.
// Reference: Kitagawa (1996), J. Comput. Graph. Stat. 5, 1, for systematic resampling
#include "planet/posterior.hpp"

#include <algorithm>
#include <cmath>

#include "base/workers.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"

namespace toliman::planet {

namespace {

constexpr size_t kDrawsAtOnce = 64;

// Random numbers of a sample, drawn in the order of the samples before the threads begin.
struct Draw {
    size_t cell;
    std::array<double, kAxes> part;
    double jitter, in_jitter, scale; // uniform
    Amplitudes normal = {};
};

std::vector<Draw> draws_of(const Lattice &lattice, size_t count, size_t amplitudes, kernels::Rng &rng) {
    const std::vector<Cell> &cells = lattice.cells();
    std::vector<Draw> draws(count);
    const double start = rng.uniform();
    double below = 0; // share of the mass of the cells before `cell`
    size_t cell = 0;
    const auto mass = [&](size_t i) { return std::exp(cells[i].log_mass - lattice.log_evidence()); };
    for (size_t i = 0; i < count; i++) {
        const double at = (static_cast<double>(i) + start) / static_cast<double>(count);
        while (cell + 1 < cells.size() && below + mass(cell) < at)
            below += mass(cell++);
        draws[i].cell = cell;
        for (double &part : draws[i].part)
            part = rng.uniform();
        draws[i].jitter = rng.uniform();
        draws[i].in_jitter = rng.uniform();
        draws[i].scale = rng.uniform();
        for (size_t j = 0; j < amplitudes; j++)
            draws[i].normal[j] = rng.normal();
    }
    for (size_t i = count; i-- > 1;)
        std::swap(draws[i], draws[static_cast<size_t>(rng.uniform() * static_cast<double>(i + 1))]);
    return draws;
}

// Index of the term at the share u of the sum of terms, of which the logarithms are given.
size_t term_at(const std::vector<double> &logs, double u) noexcept {
    const double largest = *std::max_element(logs.begin(), logs.end());
    double all = 0;
    for (const double value : logs)
        all += std::exp(value - largest);
    double below = 0;
    for (size_t i = 0; i + 1 < logs.size(); i++) {
        below += std::exp(logs[i] - largest);
        if (below >= u * all)
            return i;
    }
    return logs.size() - 1;
}

// mean + L^-T normal: covariance (L L^T)^-1.
Amplitudes drawn_amplitudes(const AmplitudeFit &fit, const Amplitudes &normal, size_t size) noexcept {
    Amplitudes drawn = {};
    for (size_t i = size; i-- > 0;) {
        double sum = normal[i];
        for (size_t j = i + 1; j < size; j++)
            sum -= fit.factor[j][i] * drawn[j];
        drawn[i] = sum / fit.factor[i][i];
    }
    for (size_t i = 0; i < size; i++)
        drawn[i] += fit.mean[i];
    return drawn;
}

} // namespace

std::vector<PosteriorSample> draw_samples(const Problem &problem, const Lattice &lattice, size_t count, uint64_t seed,
                                          unsigned threads) {
    kernels::Rng rng(seed, kernels::kStreamPosterior);
    const std::vector<Draw> draws = draws_of(lattice, count, std::max<size_t>(4, problem.series.amplitudes()), rng);
    std::vector<PosteriorSample> samples(count);
    const JitterGrid &jitters = lattice.jitters();
    run_jobs(worker_count(threads), (count + kDrawsAtOnce - 1) / kDrawsAtOnce, [&](size_t chunk) {
        ShapeWork work(problem.series);
        std::vector<double> each(problem.prior.scales.size());
        for (size_t i = chunk * kDrawsAtOnce; i < std::min(count, (chunk + 1) * kDrawsAtOnce); i++) {
            const Draw &draw = draws[i];
            const Cell &cell = lattice.cells()[draw.cell];
            const Orbit orbit = lattice.orbit(cell, draw.part);
            const size_t jitter = term_at(jitters.terms(work, orbit, cell.jitter), draw.jitter);
            const Moments moments = work.moments(problem.series, jitters.design(jitter), orbit);
            log_bayes(moments, problem.prior.scales, each.data());
            const AmplitudeFit fit = fit_amplitudes(moments, problem.prior.scales[term_at(each, draw.scale)]);
            samples[i] = {{orbit, drawn_amplitudes(fit, draw.normal, moments.size)},
                          jitters.jitter(jitter, draw.in_jitter)};
        }
    });
    return samples;
}

Planet best_of(const Problem &problem, const Lattice &lattice) {
    const Cell &cell = lattice.best();
    const Orbit orbit = lattice.orbit(cell, {0.5, 0.5, 0.5});
    ShapeWork work(problem.series);
    std::vector<double> each(problem.prior.scales.size());
    const Moments moments = work.moments(problem.series, lattice.jitters().design(cell.jitter), orbit);
    log_bayes(moments, problem.prior.scales, each.data());
    const auto scale = static_cast<size_t>(std::max_element(each.begin(), each.end()) - each.begin());
    const AmplitudeFit fit = fit_amplitudes(moments, problem.prior.scales[scale]);
    Planet planet = {orbit, {}};
    std::copy(fit.mean, fit.mean + moments.size, planet.amplitudes.begin());
    return planet;
}

// The k-th of n sorted values, from 1, is the point of the share (k - 1/2)/n; linear in between.
// Reference: Hyndman and Fan 1996, Am. Stat. 50, 361, definition 5.
Interval interval_of(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double place = std::max(0.0, share * static_cast<double>(values.size()) - 0.5);
        const auto low = std::min(static_cast<size_t>(place), values.size() - 1);
        const size_t high = std::min(low + 1, values.size() - 1);
        return values[low] + (place - static_cast<double>(low)) * (values[high] - values[low]);
    };
    return {at(0.16), at(0.5), at(0.84)};
}

Interval jitter_of(const std::vector<PosteriorSample> &samples) {
    std::vector<double> jitters;
    jitters.reserve(samples.size());
    for (const PosteriorSample &sample : samples)
        jitters.push_back(sample.jitter);
    return interval_of(std::move(jitters));
}

} // namespace toliman::planet
