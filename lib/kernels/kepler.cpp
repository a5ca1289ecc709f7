// Method: Newton's iteration for f(E) = E - e sin E - M on 0 < M <= pi, from a starting value above the root. There f
// is increasing and convex, so that the iterates decrease monotonically and cannot pass the root; the iteration stops
// when rounding stops the decrease. The start is at most 1.7 times the root. At most 7 steps were observed; 64 are
// allowed.
//
// f is evaluated as (1 - e) E + e (E - sin E) - M, a sum of positive terms before M, with a series for E - sin E: the
// direct form cancels for e near 1 and small E. Large M is reduced by atan2(sin M, cos M), whose functions reduce it
// exactly.
//
// Reference: Danby, Fundamentals of Celestial Mechanics, ch. 6.
#include "kernels/kepler.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman::kernels {

namespace {

constexpr int kMaxSteps = 64;

// x - sin x for 0 <= x <= pi, by its series where the difference would cancel.
double x_minus_sin(double x) noexcept {
    if (x > 1)
        return x - std::sin(x);
    const double square = x * x;
    double sum = 1;
    for (int k = 21; k > 3; k -= 2)
        sum = 1 - square / (k * (k - 1)) * sum;
    return x * square / 6 * sum;
}

// Starting value: the smallest of four upper bounds of the root. The last one holds because on [0, pi] both x and
// x - sin x are at least x^3/pi^2, and therefore so is mean = (1 - e) x + e (x - sin x).
double start(double mean, double eccentricity) noexcept {
    double bound = std::fmin(kPi, mean + eccentricity);
    bound = std::fmin(bound, mean / (1 - eccentricity));
    return std::fmin(bound, std::cbrt(kPi * kPi * mean));
}

// The root for 0 < mean <= pi.
double solve(double mean, double eccentricity) noexcept {
    const double complement = 1 - eccentricity;
    double x = start(mean, eccentricity);
    for (int step = 0; step < kMaxSteps; step++) {
        const double half = std::sin(x / 2), slope = complement + 2 * eccentricity * (half * half); // 1 - e cos x
        const double next = x - (complement * x + eccentricity * x_minus_sin(x) - mean) / slope;
        if (!(next < x))
            break;
        x = next;
    }
    return x;
}

} // namespace

double kepler(double mean_anomaly, double eccentricity) noexcept {
    double mean = mean_anomaly;
    if (!(std::fabs(mean) <= kPi)) // accurate for any magnitude, as sine and cosine are
        mean = std::atan2(std::sin(mean), std::cos(mean));
    if (!(std::fabs(mean) > 0)) // 0 or NaN
        return mean;
    return std::copysign(solve(std::fabs(mean), eccentricity), mean);
}

} // namespace toliman::kernels
