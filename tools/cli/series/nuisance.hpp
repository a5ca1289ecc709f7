// Functions that are fitted with the mean at each frequency, the polynomials of a trend and columns, and their
// coefficients.
#pragma once
#include "common/common.hpp"

namespace cli {

constexpr size_t kMostFunctions = 32; // without the mean
constexpr int32_t kMostTrend = 8;

// Chebyshev polynomials T_1 ... T_order over a span.
struct Trend {
    int32_t order = 0;
    double start = 0, end = 0; // units of t
};

struct NuisanceColumn {
    std::string name;
    std::vector<double> values; // [samples]
    double bound = 0;           // largest |value|
    double unit = 1;            // factor from a coefficient to the number that is printed
};

struct Nuisance {
    Trend trend;
    std::vector<NuisanceColumn> columns;
    std::vector<double> precision; // 1/s^2 of T_1 ..., then of the columns; 0 = no prior; empty: no priors

    size_t count() const noexcept { return static_cast<size_t>(trend.order) + columns.size(); }
    std::vector<double> row(size_t sample) const; // [columns]
    std::vector<double> rows() const;             // [samples][columns]
    void set(toliman_period_options &options) const;
};

// "mean", "T1" ... "T<trend>".
std::vector<std::string> names_of_trend(int32_t order);

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
Coefficients coefficients_at(const toliman_period *period, int64_t k, const std::vector<NuisanceColumn> &columns);

std::string text_of(const Coefficients &coefficients);
void print(const Coefficients &coefficients);
Json json_of(const Coefficients &coefficients);

} // namespace cli
