// Functions that are fitted with the mean at each frequency: the polynomials of a trend, and columns.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

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

} // namespace cli
