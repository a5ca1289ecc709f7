// Reduction of measured separations to the orbit.
#pragma once
#include <string>

#include "sky/prediction.hpp"

namespace toliman::sky {

// When an exposure collected light.
struct Exposure {
    std::vector<Interval> intervals;
    bool on_target; // the telescope pointed at the stars in all of them; false: one interval, of which this is unknown
};

// Why the mean over an exposure cannot be predicted for an observer; "" if it can. Every reduction asks this first.
std::string why_unknown(const Observer &observer, const Exposure &exposure);

struct Reduced {
    double separation_arcsec; // measured/factor - geometric
    Prediction seen;
};

// All numbers are NaN if the observer file has no state for a part of the exposure. A separation of NaN remains NaN.
// Status::argument if why_unknown() has a reason; otherwise as Predictor::mean.
Reduced reduce(const Predictor &predictor, const Exposure &exposure, double separation_arcsec);

} // namespace toliman::sky
