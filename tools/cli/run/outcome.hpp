// The values of one estimator in a run, their scatter and periodogram, and the option --controls.
#pragma once
#include <CLI/App.hpp>

#include "common/common.hpp"
#include "series/periodogram.hpp"

namespace cli {

struct Outcome {
    std::vector<double> values; // of the first frames of the cadence; NaN: the frame gave none
    double sigma_px = NAN;      // over frames without signal; NaN without controls
    toliman_period_peak peak = {};
    std::vector<double> power;
    double power_at_fap_1e_3 = 0;
};

enum class Controls { none, quick, full };

std::string name_of(Controls controls);
void add_controls(CLI::App &command, Controls &controls, const std::string &description);

} // namespace cli
