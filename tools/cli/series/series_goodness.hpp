// Goodness of the fit of a series, and the samples that do not belong to it, as text and JSON.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/json.hpp"
#include "common/terminal.hpp"
#include "series/series.hpp"

namespace cli {

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
std::string listed_outliers(const std::vector<int64_t> &indices, const Series &series);

// [{"index": 7, "t": 61041.5}, ...]
std::vector<Json> json_of_outliers(const std::vector<int64_t> &indices, const Series &series);

} // namespace cli
