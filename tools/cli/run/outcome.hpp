// The values of one estimator in a run, their scatter and periodogram.
#pragma once
#include <cmath>
#include <vector>

#include "series/periodogram.hpp"

namespace cli {

struct Outcome {
    std::vector<double> values; // of the first frames of the cadence; NaN: the frame gave none
    double sigma_px = NAN;      // over frames without signal; NaN without controls
    toliman_period_peak peak = {};
    std::vector<double> power;
    double power_at_fap_1e_3 = 0;
};

} // namespace cli
