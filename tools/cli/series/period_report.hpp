// What `toliman period` prints of a periodogram.
#pragma once
#include <cstdint>
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

    void print() const; // for people
    std::string json() const;
};

} // namespace cli
