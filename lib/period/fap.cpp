#include "period/fap.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::period {

namespace {

constexpr double kLn10 = 2.302585092994045684;
constexpr double kPi = 3.141592653589793238;

// ln of sqrt(2/n) Gamma(n/2)/Gamma((n-1)/2). Not by lgamma: it writes the global signgam, and the difference of two
// huge values would lose digits.
double ln_gamma_ratio(double n) noexcept {
    if (n > 100) { // Gamma(x + 1/2)/Gamma(x), the next term is below 1e-11
        const double x = (n - 1) / 2, r = 1 / x;
        return 0.5 * std::log1p(-1 / n) +
               std::log1p(r * (-1.0 / 8 + r * (1.0 / 128 + r * (5.0 / 1024 - r * 21 / 32768))));
    }
    const int whole = static_cast<int>(n), start = 2 + whole % 2;
    double ratio = start == 2 ? 1 / std::sqrt(kPi) : std::sqrt(kPi) / 2; // at n = 2, 3
    for (int m = start; m < whole; m += 2)
        ratio *= static_cast<double>(m) / (m - 1);
    return std::log(std::sqrt(2 / n) * ratio);
}

} // namespace

double log10_fap_baluev(double log10_residual, int64_t count, double last_frequency, double time_variance) noexcept {
    const double n = static_cast<double>(count), ln_residual = log10_residual * kLn10;
    const double power = -std::expm1(ln_residual);
    if (!(power > 0))
        return 0;
    const double w = last_frequency * std::sqrt(4 * kPi * time_variance);
    const double ln_single = 0.5 * (n - 3) * ln_residual;
    const double ln_tau =
        ln_gamma_ratio(n - 1) + std::log(w) + 0.5 * (n - 4) * ln_residual + 0.5 * std::log(0.5 * (n - 1) * power);
    if (ln_tau < -30 && ln_single < -30) { // FAP = tau + single up to 1e-13 of itself
        const double larger = std::max(ln_tau, ln_single), smaller = std::min(ln_tau, ln_single);
        return (larger + std::log1p(std::exp(smaller - larger))) / kLn10;
    }
    const double tau = std::exp(ln_tau);
    return std::log10(std::min(1.0, -std::expm1(-tau) + std::exp(ln_single - tau)));
}

} // namespace toliman::period
