// Method: the median tells whether the model of a typical frame is right, the trend whether it was and no longer is:
// the least-squares slope of chi-square by time, with the error that the scatter of the frames gives it. A drift of the
// optics by 1 nm in three years raises chi-square from 1 to 18 before a planet is imitated.
#include "track/folder_goodness.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace toliman::track {

namespace {

constexpr double kYearNs = 365.25 * 86400e9;

double median_of(std::vector<double> values) {
    values.erase(std::remove_if(values.begin(), values.end(), [](double value) { return std::isnan(value); }),
                 values.end());
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const auto middle = values.begin() + static_cast<ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void set_trend(const std::vector<double> &years, const std::vector<double> &chi_squares, FolderGoodness &found) {
    const auto n = static_cast<double>(years.size());
    double time = 0, mean = 0, xx = 0, xy = 0, squares = 0;
    for (size_t i = 0; i < years.size(); i++) {
        time += years[i] / n;
        mean += chi_squares[i] / n;
    }
    for (size_t i = 0; i < years.size(); i++) {
        xx += (years[i] - time) * (years[i] - time);
        xy += (years[i] - time) * (chi_squares[i] - mean);
    }
    if (years.size() < 3 || !(xx > 0))
        return;
    const double slope = xy / xx;
    for (size_t i = 0; i < years.size(); i++) {
        const double rest = chi_squares[i] - mean - slope * (years[i] - time);
        squares += rest * rest;
    }
    found.trend_per_year = slope;
    found.trend_sigma_per_year = std::sqrt(squares / (n - 2) / xx);
}

} // namespace

FolderGoodness folder_goodness(const Tracker &tracker) {
    FolderGoodness found;
    std::vector<double> years, chi_squares, sigmas, misfits, misfit_sigmas;
    int64_t first_ns = 0;
    double largest = std::numeric_limits<double>::quiet_NaN();
    tracker.visit(0, tracker.records(), [&](const Record &record, const Outcome &outcome) {
        const bool is_used = outcome.verdict == Verdict::accepted || outcome.verdict == Verdict::unreduced;
        const bool is_valid = record.kind == Kind::accepted || record.kind == Kind::outlier;
        if (!is_valid || std::isnan(outcome.goodness.chi_square))
            return;
        if (outcome.verdict == Verdict::misfit || outcome.verdict == Verdict::outlier) {
            misfits.push_back(outcome.goodness.chi_square);
            misfit_sigmas.push_back(outcome.goodness.sigma);
        }
        if (!is_used)
            return;
        if (years.empty())
            first_ns = outcome.tai_ns;
        years.push_back((static_cast<double>(outcome.tai_ns) - static_cast<double>(first_ns)) / kYearNs);
        chi_squares.push_back(outcome.goodness.chi_square);
        sigmas.push_back(outcome.goodness.sigma);
        largest = std::fmax(largest, outcome.goodness.largest);
        found.poor += outcome.goodness.verdict == GoodnessVerdict::poor;
        found.too_good += outcome.goodness.verdict == GoodnessVerdict::too_good;
        found.bad_pixels += outcome.bad_pixels;
        found.cleaned += outcome.bad_pixels > 0;
    });
    found.frames = static_cast<int64_t>(years.size());
    if (!years.empty()) {
        const auto [first, last] = std::minmax_element(years.begin(), years.end());
        found.years = *last - *first;
    }
    set_trend(years, chi_squares, found);
    if (years.empty()) {
        chi_squares = std::move(misfits);
        sigmas = std::move(misfit_sigmas);
    }
    found.goodness =
        goodness_of(median_of(std::move(chi_squares)), median_of(std::move(sigmas)), largest, kFrameSigmas);
    return found;
}

} // namespace toliman::track
