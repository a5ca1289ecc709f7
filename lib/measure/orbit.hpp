// The orbit of a system, as an observer sees it, as the reference of a tracker.
#pragma once
#include <string>

#include "sky/prediction.hpp"
#include "track/request.hpp"

namespace toliman::measure {

// The predictor must outlive the result. known: JSON text of the system that a folder has, or "": it stays if it has
// the same numbers. Status::argument if the predictor leaves out effects.
track::Orbit orbit_of(const sky::Predictor &predictor, const std::string &known);

} // namespace toliman::measure
