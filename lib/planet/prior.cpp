// Method: the incomplete beta function from its power series
//     B(e; a, b) = e^a sum over n of (1 - b)_n/n! e^n/(a + n),
// whose terms fall like e^n n^(-b - 1), and its inverse by bisection. The scale of the amplitudes is integrated by the
// midpoint rule in its logarithm: as its function, s^-m exp(-A^2/(2 s^2)) of m <= 4 amplitudes has a width of at least
// 0.35, and steps of at most that have errors below 1e-6.
// Reference: Kipping (2013), MNRAS 434, L51
#include "planet/prior.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace toliman::planet {

namespace {

constexpr double kAlpha = 0.867, kBeta = 3.03, kScaleStep = 0.35;

} // namespace

double beta_share(double e) noexcept {
    double factor = 1, sum = 1 / kAlpha;
    for (int n = 1; n < 2000; n++) {
        factor *= (n - kBeta) / n * e;
        const double term = factor / (kAlpha + n);
        sum += term;
        if (std::fabs(term) < 1e-17 && n > 4)
            break;
    }
    return std::pow(e, kAlpha) * sum;
}

double Prior::share(double from, double to) const noexcept {
    return std::log(to / from) / std::log(frequency_max / frequency_min);
}

double Prior::eccentricity_share(double low, double high) const noexcept {
    return (beta_share(high) - beta_share(low)) / beta_share(eccentricity_max);
}

double Prior::eccentricity_in(double low, double high, double part) const noexcept {
    const double first = beta_share(low), target = first + part * (beta_share(high) - first), resolved = 1e-14 * high;
    for (int i = 0; i < 52 && high - low > resolved; i++) {
        const double middle = (low + high) / 2;
        (beta_share(middle) < target ? low : high) = middle;
    }
    return (low + high) / 2;
}

double Prior::jitter(double u) const noexcept {
    return jitter_max > 0 ? jitter_knee * std::expm1(u * std::log1p(jitter_max / jitter_knee)) : 0;
}

std::vector<double> scales_between(double least, double most) {
    const double range = std::log(most / least);
    const auto count = std::max<size_t>(1, static_cast<size_t>(std::ceil(range / kScaleStep)));
    std::vector<double> scales(count);
    for (size_t i = 0; i < count; i++)
        scales[i] = least * std::exp(range * (static_cast<double>(i) + 0.5) / static_cast<double>(count));
    return scales;
}

} // namespace toliman::planet
