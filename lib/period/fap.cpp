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

double ln_single(const Sampling &sampling, double ln_residual) noexcept {
    return 0.5 * static_cast<double>(sampling.count - 3) * ln_residual;
}

double ln_naive(const Sampling &sampling, double ln_residual) noexcept {
    const double independent = std::max(1.0, sampling.last_frequency * baseline(sampling.time_variance));
    const double single = ln_single(sampling, ln_residual), sum = std::log(independent) + single;
    if (sum < -30) // up to 1e-13 of itself
        return sum;
    return std::log(-std::expm1(independent * std::log1p(-std::exp(single))));
}

double ln_baluev(const Sampling &sampling, double ln_residual) noexcept {
    const auto n = static_cast<double>(sampling.count);
    const double power = -std::expm1(ln_residual);
    if (!(power > 0))
        return 0;
    const double w = sampling.last_frequency * std::sqrt(4 * kPi * sampling.time_variance);
    const double single = ln_single(sampling, ln_residual);
    const double ln_tau =
        ln_gamma_ratio(n - 1) + std::log(w) + 0.5 * (n - 4) * ln_residual + 0.5 * std::log(0.5 * (n - 1) * power);
    if (ln_tau < -30 && single < -30) { // FAP = tau + single up to 1e-13 of itself
        const double larger = std::max(ln_tau, single), smaller = std::min(ln_tau, single);
        return larger + std::log1p(std::exp(smaller - larger));
    }
    const double tau = std::exp(ln_tau);
    return std::log(std::min(1.0, -std::expm1(-tau) + std::exp(single - tau)));
}

// Chance of an alarm at any of all looks. While N grows, the highest peak wanders: where p is the FAP of one look, new
// alarms come at a rate of p K for every factor e in N, with z = -ln(single) and K = z nu(sqrt(2 z/N)). K counts the
// independent looks; nu takes the looks' finite number into account and keeps K below N (Siegmund 1985, Sequential
// Analysis, chapter 4; nu of Siegmund and Yakir 2007, The Statistics of Gene Mapping). An alarm where K p falls below
// a w(ln N), with w of integral 1, therefore spends a in all (Lan and DeMets 1983, Biometrika 70, 659), and the FAP is
// the a of this look: K p/w. Here w(x) = 1/(2 (1 + |x - ln 150|)^2): half is spent by the 150th sample, little on the
// first few, and as slowly as it falls there is still some at the millionth.
double ln_sequential(const Sampling &sampling, double ln_residual) noexcept {
    constexpr double kHalfSpent = 150; // samples
    const auto n = static_cast<double>(sampling.count);
    const double z = -ln_single(sampling, ln_residual);
    double looks = 1;
    if (z > 1) {
        const double half = std::sqrt(0.5 * z / n), inside = 0.5 * std::erf(half / std::sqrt(2.0));
        const double nu = inside / (half * (half * (0.5 + inside) + std::exp(-0.5 * half * half) / std::sqrt(2 * kPi)));
        looks = std::max(1.0, z * nu);
    }
    const double away = 1 + std::fabs(std::log(n / kHalfSpent));
    return std::min(0.0, ln_baluev(sampling, ln_residual) + std::log(looks * 2 * away * away));
}

} // namespace

double baseline(double time_variance) noexcept {
    return std::sqrt(12 * time_variance);
}

double log10_fap(Fap method, const Sampling &sampling, double log10_residual) noexcept {
    const double ln_residual = log10_residual * kLn10;
    switch (method) {
    case Fap::naive:
        return ln_naive(sampling, ln_residual) / kLn10;
    case Fap::single:
        return ln_single(sampling, ln_residual) / kLn10;
    case Fap::sequential:
        return ln_sequential(sampling, ln_residual) / kLn10;
    case Fap::baluev:
        break;
    }
    return ln_baluev(sampling, ln_residual) / kLn10;
}

double log10_level(Fap method, const Sampling &sampling, double log10_fap) noexcept {
    // Baluev's bound falls from P = 1/(N - 3) on, where tau is greatest; before it may dip a little below 1.
    double low = kLeastLogResidual, high = std::log1p(-1 / static_cast<double>(sampling.count - 3)) / kLn10;
    if (period::log10_fap(method, sampling, high) < log10_fap) {
        low = high;
        high = 0;
    }
    for (;;) {
        const double middle = low + 0.5 * (high - low);
        if (!(middle > low && middle < high))
            return low;
        (period::log10_fap(method, sampling, middle) < log10_fap ? low : high) = middle;
    }
}

} // namespace toliman::period
