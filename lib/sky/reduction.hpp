// Means of predictions over exposures, and the reduction of measured separations to the orbit.
#pragma once
#include <limits>
#include <string>

#include "sky/prediction.hpp"

namespace toliman::sky {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(); // what is not known

// When an exposure collected light.
struct Exposure {
    std::vector<Interval> intervals;
    bool on_target; // the telescope pointed at the stars in all of them; false: one interval, of which this is unknown
};

// Why the mean over an exposure cannot be predicted for an observer, whatever the observer file has; "" if it can.
std::string why_unknown(const Observer &observer, const Exposure &exposure);

// The mean over an exposure, if there is one.
struct ExposureMean {
    enum class Outcome {
        known,    // seen is the mean
        no_state, // the observer file does not cover the exposure completely
        unknown,  // the time on target is not known, see why
    };
    Outcome outcome;
    Prediction seen;
    std::string why; // that of why_unknown()
};

// Every reduction uses this. Other errors as Predictor::mean: years outside 1900 to 2100, bad intervals, and stars at
// the same position.
ExposureMean mean_over(const Predictor &predictor, const Exposure &exposure);

struct Reduced {
    double separation_arcsec; // measured/factor - geometric
    Prediction seen;
};

// All numbers are NaN if the observer file has no state for a part of the exposure. A separation of NaN remains NaN.
// Status::argument if why_unknown() has a reason; otherwise as mean_over().
Reduced reduce(const Predictor &predictor, const Exposure &exposure, double separation_arcsec);

} // namespace toliman::sky
