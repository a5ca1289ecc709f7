#include "kernels/kepler.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMostSteps = 64;

// x - sin x for 0 <= x <= pi, by its series where the difference would cancel.
double less_sine(double x) noexcept {
    if (x > 1)
        return x - std::sin(x);
    const double square = x * x;
    double sum = 1;
    for (int k = 21; k > 3; k -= 2)
        sum = 1 - square / (k * (k - 1)) * sum;
    return x * square / 6 * sum;
}

// Above the root and near it: the smallest of four bounds. On [0, pi] both x and x - sin x are at least x^3/pi^2, so
// mean = (1 - e) x + e (x - sin x) is too.
double start(double mean, double eccentricity) noexcept {
    double bound = std::fmin(kPi, mean + eccentricity);
    bound = std::fmin(bound, mean / (1 - eccentricity));
    return std::fmin(bound, std::cbrt(kPi * kPi * mean));
}

// The root for 0 < mean <= pi. (1 - e) x + e (x - sin x) is a sum of positive terms, x - e sin x is not.
double solve(double mean, double eccentricity) noexcept {
    const double rest = 1 - eccentricity;
    double x = start(mean, eccentricity);
    for (int step = 0; step < kMostSteps; step++) {
        const double half = std::sin(x / 2), slope = rest + 2 * eccentricity * (half * half); // 1 - e cos x
        const double next = x - (rest * x + eccentricity * less_sine(x) - mean) / slope;
        if (!(next < x))
            break;
        x = next;
    }
    return x;
}

} // namespace

double kepler(double mean_anomaly, double eccentricity) noexcept {
    double mean = mean_anomaly;
    if (!(std::fabs(mean) <= kPi)) // exact for any size, as the sine and cosine are
        mean = std::atan2(std::sin(mean), std::cos(mean));
    if (!(std::fabs(mean) > 0)) // 0 or NaN
        return mean;
    return std::copysign(solve(std::fabs(mean), eccentricity), mean);
}

} // namespace toliman::kernels
