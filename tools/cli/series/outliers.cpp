#include "series/outliers.hpp"

#include <algorithm>
#include <cmath>

#include "common/text.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;
constexpr size_t kListed = 10;

} // namespace

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
