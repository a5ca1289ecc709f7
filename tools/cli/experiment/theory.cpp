// Method: a method that reaches the Cramer-Rao bound leaves the residual fraction sigma^2 / (sigma^2 + var(signal)) at
// the true period; Baluev's FAP of that residual on the experiment's grid is the expected one, and bisection gives the
// amplitude of FAP = 1e-3. For principal components the threshold is the phase transition of Baik, Ben Arous and Peche
// (2005), Ann. Probab. 33, 1643: the signal's variance over sigma^2 must exceed sqrt(pixels/frames). Uniformity of
// FAPs: Kolmogorov-Smirnov D with Stephens' effective argument (sqrt n + 0.12 + 0.11/sqrt n) D, and the alternating
// series p = 2 sum (-1)^(k-1) exp(-2 k^2 x^2).
#include "experiment/theory.hpp"

#include <algorithm>
#include <cmath>

#include "frames/frame_loop.hpp"

namespace cli {

namespace {

toliman::periodogram periodogram_of(const std::vector<double> &times, const std::vector<double> &shape,
                                    const FrequencyGrid &grid) {
    auto options = toliman::sized<toliman_period_options>();
    options.time_offset = *std::min_element(times.begin(), times.end());
    auto result = toliman::make<toliman::periodogram>(toliman_period_create, grid.f0, grid.df, grid.nf, &options);
    toliman::check(toliman_period_push_many(result.get(), times.data(), shape.data(), nullptr, times.size()));
    return result;
}

} // namespace

Theory::Theory(const std::vector<double> &times, const std::vector<double> &shape, const FrequencyGrid &grid)
    : periodogram_(periodogram_of(times, shape, grid)), frames_(static_cast<double>(times.size())),
      variance_(squares(shape) / frames_) {}

double Theory::log10_fap(double amplitude_px, double sigma_px) const {
    const double ratio = amplitude_px / sigma_px;
    double result = 0;
    toliman::check(toliman_period_query_fap(periodogram_.get(), TOLIMAN_PERIOD_FAP_BALUEV,
                                            -std::log1p(ratio * ratio * variance_) / std::log(10), &result));
    return result;
}

double Theory::threshold_px(double sigma_px) const {
    double low = 0, high = sigma_px;
    while (log10_fap(high, sigma_px) > kFound && high < 1e6 * sigma_px)
        high *= 2;
    for (int i = 0; i < 60; i++) {
        const double middle = (low + high) / 2;
        (log10_fap(middle, sigma_px) > kFound ? low : high) = middle;
    }
    return high;
}

double Theory::pca_threshold_px(double sigma_px, double pixels) const {
    return sigma_px * std::sqrt(std::sqrt(pixels / frames_) / variance_);
}

double median(std::vector<double> values) {
    if (values.empty())
        return NAN;
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 != 0 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double uniformity(std::vector<double> values) {
    if (values.empty())
        return NAN;
    std::sort(values.begin(), values.end());
    const auto n = static_cast<double>(values.size());
    double gap = 0;
    for (size_t i = 0; i < values.size(); i++)
        gap = std::max({gap, values[i] - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - values[i]});
    const double x = (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n)) * gap;
    if (x < 0.2)
        return 1; // to 1e-12; the series would need more terms
    double chance = 0;
    for (int k = 1; k <= 40; k++)
        chance += (k % 2 != 0 ? 2 : -2) * std::exp(-2.0 * k * k * x * x);
    return std::clamp(chance, 0.0, 1.0);
}

} // namespace cli
