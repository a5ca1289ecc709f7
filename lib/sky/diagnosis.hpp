// The mistake that explains why measured separations do not agree with their predictions.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "base/goodness.hpp"
#include "sky/refit.hpp"

namespace toliman::sky {

// In the order of TOLIMAN_SKY_CAUSE_....
enum class Cause : int32_t { none, time, axes, rotation_x, rotation_y, rotation_z, scale, centre };
constexpr size_t kCauses = 7; // without none

struct Hypothesis {
    double value, sigma; // NaN if the cause has none
    double chi_square;   // per degree of freedom, after it
    double gain;         // by which it lowers the sum of squares
    double significance; // standard deviations
    bool is_decisive;
    std::string text;
};

struct Diagnosis {
    Goodness goodness; // of the residuals without a hypothesis
    size_t used;       // measurements
    Cause cause = Cause::none;
    std::vector<Hypothesis> hypotheses; // kCauses, in the order of Cause; none if they were not asked for
};

// Uses at most 4096 measurements. Errors as refit(), except for those for which the observer has no state: they are
// left out. hypotheses: false for goodness only.
Diagnosis diagnose(const Predictor &predictor, const std::vector<Measurement> &measurements, double scale_sigma,
                   bool hypotheses);

} // namespace toliman::sky
