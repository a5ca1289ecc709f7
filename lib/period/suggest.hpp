// Suggests a frequency grid and periodogram options for a series.
#pragma once
#include "period/peak.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

// Returns a grid for the samples (y and sigma may be NULL) and for further ones like them up to a time span of
// mission_span; 0: there are no further ones. Without samples the step is 1. Status::argument for samples that are not
// finite; Status::state for fewer than two distinct times without mission_span; Status::range for a ratio of sigmas
// that one periodogram does not support.
Grid suggest(const Samples &samples, double mission_span);

// The offsets and bounds alone, with any valid frequencies; one time suffices.
Grid suggest_bounds(const Samples &samples, double mission_span);

} // namespace toliman::period
