#include "series/series_goodness.hpp"

#include <algorithm>
#include <cmath>

#include <toliman/goodness.h>

#include "common/text.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;
constexpr size_t kListed = 10;

} // namespace

std::string fit_text(double chi_square, double sigma, double largest, int32_t goodness) {
    return formatted("chi-square %.4g +- %.2g per degree of freedom: %s, largest residual %.4g sigma", chi_square,
                     sigma, toliman_constant_name(goodness), largest);
}

void warn_of_fit(double chi_square, double sigma, int32_t goodness, Progress &progress) {
    const std::string text = formatted("chi-square %.4g +- %.2g: ", chi_square, sigma);
    if (goodness == TOLIMAN_GOODNESS_POOR)
        progress.warn(text +
                      "poor: the sigmas are too small, or the model lacks an effect, or times, unit or axes are wrong");
    if (goodness == TOLIMAN_GOODNESS_TOO_GOOD)
        progress.warn(text + "too good: the sigmas are too large: are they in the unit of the values?");
}

void warn_of_outliers(size_t count, const std::string &cure, Progress &progress) {
    if (count > 0)
        progress.warn("outliers" + cure + formatted(": %zu", count));
}

std::string listed_outliers(const std::vector<int64_t> &indices, const Series &series) {
    std::string text;
    for (size_t i = 0; i < std::min(indices.size(), kListed); i++) {
        const double t = series.t[static_cast<size_t>(indices[i])];
        text += i == 0 ? "" : ", ";
        text += series.time_scale.empty() ? formatted("t = %.9g", t)
                                          : date_text(std::llround((t - kMjdOf1970) * kNsPerDay)).substr(0, 16);
    }
    return text + (indices.size() > kListed ? ", ..." : "");
}

std::vector<Json> json_of_outliers(const std::vector<int64_t> &indices, const Series &series) {
    return array_of(indices, [&](int64_t i) { return Json("index", i, "t", series.t[static_cast<size_t>(i)]); });
}

} // namespace cli
