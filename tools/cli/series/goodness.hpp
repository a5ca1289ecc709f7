// What is said of a peak and of the fit of a series, as text, JSON and warnings: flags, aliases, goodness, outliers,
// and its instruments with their offsets and jitters.
#pragma once
#include <toliman/period_sampling.h>

#include "series/series.hpp"

namespace cli {

// ", long period" and ", annual" after the numbers of a peak.
std::string flags_text(uint32_t flags);
// Sets long_period and annual.
void set_flags(uint32_t flags, Json &json);
// One sentence for each flag. hint: option that fits a trend, ": --trend"; "" if there is one.
// is_dated: the times are dates; plain numbers are taken as days.
void warn_of_peak(uint32_t flags, const std::string &hint, bool is_dated, Progress &progress);

using Aliases = std::vector<toliman_period_alias>;

// Those of a peak at `frequency`; none outside the grid.
Aliases aliases_of(const toliman_period *periodogram, double frequency);
// A line for each alias that the samples do not tell from the peak, at most four; "" for none.
std::string text_of(const Aliases &aliases);
std::vector<Json> json_of(const Aliases &aliases);
// Warns if a slow change may cause the peak. hint: option that fits a trend, ": --trend"; "" if there is one.
void warn_of_aliases(const Aliases &aliases, const std::string &hint, Progress &progress);

// "chi-square 0.98 +- 0.07 per degree of freedom: good, largest residual 3.1 sigma", of a result with the four members.
std::string fit_text(double chi_square, double sigma, double largest, int32_t goodness);
template <class Result> std::string fit_text(const Result &result) {
    return fit_text(result.chi_square, result.chi_square_sigma, result.largest_residual, result.goodness);
}

// Warns of a chi-square that is not that of the noise.
void warn_of_fit(double chi_square, double sigma, int32_t goodness, Progress &progress);
template <class Result> void warn_of_fit(const Result &result, Progress &progress) {
    warn_of_fit(result.chi_square, result.chi_square_sigma, result.goodness, progress);
}
// Warns of samples that do not belong. cure: what follows, or is to be done; may be "".
void warn_of_outliers(size_t count, const std::string &cure, Progress &progress);

// The times of the first ten: dates, where times are dates.
std::string listed_outliers(const std::vector<int64_t> &indices, const toliman_measure *series);

// [{"index": 7, "t": 61041.5}, ...]
std::vector<Json> json_of_outliers(const std::vector<int64_t> &indices, const toliman_measure *series);

// The instruments of a series: offsets and jitters.
using Instruments = std::vector<toliman_measure_instrument>;

// Those of a series with several, in a fit of its functions, and of a sinusoid unless the frequency is 0; otherwise
// none.
Instruments instruments_of(const toliman_measure *series, double frequency = 0);

// A copy of the series with the jitter of each instrument whose residuals its sigmas do not explain.
toliman::measurements with_jitters(const toliman_measure *series, const Instruments &instruments);

// A line for each; "" for none. unit: of the values, may be empty.
std::string text_of(const Instruments &instruments, const std::string &unit);
std::vector<Json> json_of(const Instruments &instruments);

} // namespace cli
