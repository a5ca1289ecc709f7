// Goodness of fit: whether the residuals of a fit are those of its noise. The one place that decides it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>

namespace toliman {

// In the order of TOLIMAN_GOODNESS_....
enum class GoodnessVerdict : int32_t { unknown, good, poor, too_good };
const char *name_of(GoodnessVerdict verdict) noexcept;

struct Goodness {
    double chi_square = std::numeric_limits<double>::quiet_NaN(); // per degree of freedom
    double sigma = std::numeric_limits<double>::quiet_NaN();      // of chi_square, if the model is right
    double largest = std::numeric_limits<double>::quiet_NaN();    // |residual| over its standard deviation
    GoodnessVerdict verdict = GoodnessVerdict::unknown;
};

// Standard deviations of a Gaussian beyond which a chi-square is poor or too good: a mission has a million frames, and
// one series.
constexpr double kFrameSigmas = 6, kSeriesSigmas = 4;

// Chi-square of a series of separations beyond which no jitter excuses it: the model of the frames lacks an effect, or
// times, unit or sigmas are wrong. Results are then not to be used.
constexpr double kMostSeriesChiSquare = 3;

// The chi-square, per degree of freedom, that a right model exceeds as often as a Gaussian exceeds `sigmas`; below it,
// for negative ones. sigma: standard deviation of the chi-square.
double chi_square_quantile(double sigma, double sigmas) noexcept;

// Standard deviation of the chi-square per degree of freedom of `used` pixels, whose expected counts have the sum of
// inverses inverse_counts (0 for Gaussian noise).
double chi_square_sigma(size_t used, double inverse_counts, double freedom) noexcept;

// The verdict on a chi-square; unknown if it is NaN, or if sigma is.
GoodnessVerdict judge(double chi_square, double sigma, double sigmas) noexcept;
inline Goodness goodness_of(double chi_square, double sigma, double largest, double sigmas) noexcept {
    return {chi_square, sigma, largest, judge(chi_square, sigma, sigmas)};
}

} // namespace toliman
