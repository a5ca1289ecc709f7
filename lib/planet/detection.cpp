// Method: with what the nuisance functions leave of cosine and sine, whitened, C and S, the power at a frequency is
// b^T M^-1 b/|r|^2 with the normal equations M of C and S, b = (C r, S r) and the residuals r. The upper limit: ln of
// the posterior of an amplitude A and a phase is A b.u - A^2 u^T M u/2 with the unit vector u of the phase.
#include "planet/detection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/constants.hpp"

namespace toliman::planet {

namespace {

constexpr size_t kPhases = 64, kAmplitudes = 1024;

double time_variance(const Series &series, const Buffer<double> &weights) noexcept {
    double all = 0, mean = 0, square = 0;
    for (size_t i = 0; i < series.n; i++) {
        const double w = weights[i] * weights[i];
        all += w;
        mean += w * series.t[i];
        square += w * series.t[i] * series.t[i];
    }
    mean /= all;
    return std::max(square / all - mean * mean, 0.0);
}

} // namespace

period::Sampling sampling_of(const Series &series, const Design &design, const DetectionGrid &grid) noexcept {
    return {static_cast<int64_t>(series.used), grid.at(grid.count - 1), time_variance(series, design.weights()),
            static_cast<int64_t>(design.free())};
}

CircularPair circular_pair(const Moments &moments) noexcept {
    return {{moments.right[0], moments.right[1]}, moments.matrix[0][0], moments.matrix[1][0], moments.matrix[1][1]};
}

double CircularPair::gain() const noexcept {
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-12 * xx * yy))
        return 0;
    return (right[0] * right[0] * yy - 2 * right[0] * right[1] * xy + right[1] * right[1] * xx) / determinant;
}

DetectionGrid::DetectionGrid(const Series &series, const Prior &prior) noexcept
    : first(prior.frequency_min), step(0.1 / series.span),
      count(static_cast<size_t>((prior.frequency_max - prior.frequency_min) / step) + 1) {}

Detection::Detection(const Problem &problem, const Design &design, double fap)
    : problem_(problem), design_(design), grid_(problem.series, problem.prior),
      log10_threshold_(
          period::log10_threshold(period::Fap::baluev, sampling_of(problem.series, design, grid_), std::log10(fap))) {}

CircularPair Detection::pair_at(double frequency) const {
    ShapeWork work(problem_.series);
    return circular_pair(work.moments(problem_.series, design_, {frequency, 0, 0}));
}

double Detection::log10_fap() const {
    double highest = 0;
    for (size_t i = 0; i < grid_.count; i++)
        highest = std::max(highest, pair_at(grid_.at(i)).gain());
    const double left = design_.square() > 0 ? 1 - highest / design_.square() : 1;
    const double log10_residual =
        std::clamp(left > 0 ? std::log10(left) : period::kMinLogResidual, period::kMinLogResidual, 0.0);
    return period::log10_fap(period::Fap::baluev, sampling_of(problem_.series, design_, grid_), log10_residual);
}

double Detection::upper(double frequency, double probability) const {
    const CircularPair pair = pair_at(frequency);
    const double trace = pair.xx + pair.yy, root = std::hypot(pair.xx - pair.yy, 2 * pair.xy);
    if (!(trace > 0))
        return HUGE_VAL;
    const double least = std::max((trace - root) / 2, 1e-12 * trace); // smaller eigenvalue
    const double most = std::hypot(pair.right[0], pair.right[1]) / least + 8 / std::sqrt(least);
    const double first = 1e-3 / std::sqrt(trace), step = std::log(most / first) / kAmplitudes;
    std::vector<std::array<double, kPhases>> exponents(kAmplitudes);
    std::vector<double> density(kAmplitudes);
    double largest = 0, all = 0;
    for (size_t i = 0; i < kAmplitudes; i++)
        for (size_t j = 0; j < kPhases; j++) {
            const double amplitude = first * std::exp(step * (static_cast<double>(i) + 0.5));
            const double phase = 2 * kPi * static_cast<double>(j) / kPhases;
            const double cosine = std::cos(phase), sine = std::sin(phase);
            exponents[i][j] = amplitude * (pair.right[0] * cosine + pair.right[1] * sine) -
                              amplitude * amplitude * pair.square(cosine, sine) / 2;
            largest = std::max(largest, exponents[i][j]);
        }
    for (size_t i = 0; i < kAmplitudes; i++) { // d amplitude = amplitude d ln amplitude
        for (const double exponent : exponents[i])
            density[i] += std::exp(exponent - largest + step * static_cast<double>(i));
        all += density[i];
    }
    double below = 0;
    for (size_t i = 0; i < kAmplitudes; i++) {
        if (below + density[i] >= probability * all)
            return first * std::exp(step * (static_cast<double>(i) + (probability * all - below) / density[i]));
        below += density[i];
    }
    return most;
}

} // namespace toliman::planet
