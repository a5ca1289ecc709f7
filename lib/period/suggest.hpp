// The grid of frequencies and the options that suit a series.
#pragma once
#include "period/peak.hpp"
#include "period/stream.hpp"

namespace toliman::period {

// The grid for samples, of which y and sigma may be null, and for more of their kind up to a time span of mission_span;
// 0: no more come. Without samples their step is taken to be 1. Status::argument for samples that are not finite;
// Status::state for fewer than two different times and no mission_span; Status::range for more than 2e6 frequencies,
// and for sigmas too different for one periodogram.
Grid suggest(const Samples &samples, double mission_span);

} // namespace toliman::period
