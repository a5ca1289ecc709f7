// Functions that are fitted with the mean at each frequency, the polynomials of a trend and columns, and their
// coefficients.
#pragma once
#include "common/common.hpp"

namespace cli {

constexpr size_t kMostFunctions = 32; // without the mean
constexpr int32_t kMostTrend = 8;

using Function = toliman_measure_function;

std::vector<Function> functions_of(const toliman_measure *series); // T_1 ..., then the columns
std::vector<Function> columns_of(const toliman_measure *series);
// The values of the columns, [samples][columns].
std::vector<double> column_rows(const toliman_measure *series);

// Gives options of a periodogram the functions of a series.
template <class Options> void set_functions(const toliman_measure *series, Options &options) {
    const toliman_measure_info info = info_of(series);
    options.trend = info.trend;
    options.trend_start = info.trend_start;
    options.trend_end = info.trend_end;
    options.columns = info.columns;
    double *precision = options.prior_precision + 1; // after that of the mean
    for (const Function &function : functions_of(series))
        *precision++ = function.sigma > 0 ? 1 / (function.sigma * function.sigma) : 0;
}

// A coefficient of the mean or of a nuisance function, fitted with a sinusoid.
struct Coefficient {
    std::string name;    // "mean", "T1", or that of a column
    double value, error; // error: infinite if the function is not in use
    double prior;        // standard deviation, 0 without a prior
    double unit;         // the three numbers over those of the library
};

struct Coefficients {
    std::vector<Coefficient> all; // the mean, then those of the functions
    int32_t functions, free;      // in use, with the mean; of these, those without a prior
};

// At grid frequency k. columns: their names and units; empty: "column 1", ... No coefficients if the mean alone is
// fitted.
Coefficients coefficients_at(const toliman_period *period, int64_t k, const std::vector<Function> &columns);

std::string text_of(const Coefficients &coefficients);
Json json_of(const Coefficients &coefficients);

} // namespace cli
