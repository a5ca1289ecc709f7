// The results of `toliman period` as text and JSON.
#pragma once
#include <string>
#include <vector>

#include "series/fap.hpp"
#include "series/periodogram.hpp"

namespace cli {

struct PeriodReport {
    const Periodogram &periodogram;
    FrequencyGrid grid;
    int64_t samples;
    std::vector<toliman_period_peak> peaks; // the highest first
    const Fap &fap;
    std::string time_scale; // of Modified Julian Days; empty for plain numbers

    void print() const; // as text
    std::string json() const;
};

} // namespace cli
