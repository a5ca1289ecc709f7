// Coefficients of mean and nuisance functions, fitted with a sinusoid.
#pragma once
#include <string>
#include <vector>

#include "common/json.hpp"
#include "series/nuisance.hpp"

namespace cli {

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

// At grid frequency k. columns: their names and units; empty: "column 1", ... Nothing if the mean alone is fitted.
std::vector<Coefficient> coefficients_at(const toliman_period *period, int64_t k,
                                         const std::vector<NuisanceColumn> &columns);
// With the numbers of functions of a periodogram.
Coefficients with_counts(const toliman_period *period, std::vector<Coefficient> coefficients);

std::string text_of(const Coefficients &coefficients);
void print(const Coefficients &coefficients);
Json json_of(const Coefficients &coefficients);

} // namespace cli
