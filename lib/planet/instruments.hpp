// The noise of each instrument: its jitter, and how its measurements fit.
#pragma once
#include <array>
#include <vector>

#include "base/goodness.hpp"
#include "planet/design.hpp"

namespace toliman::planet {

// Jitter of each group, in units of its values, that is most probable with these functions.
std::vector<double> jitters_of(const Series &series, const std::vector<const Function *> &functions,
                               const Buffer<double> &values);

// These jitters over a common one, which is at most `rms` if each is at most the rms of its group.
std::vector<double> jitter_scales_of(const Series &series, const std::vector<const Function *> &functions,
                                     const Buffer<double> &values, std::vector<double> jitters, double rms);

// Jitter of each group with this common one, 16, 50 and 84 %: about the most probable. design: with the common jitter.
std::vector<std::array<double, 3>> jitter_intervals(const Series &series, const Design &design, double jitter);

// Residuals of each group over their standard deviations, with the jitter of the design or without one, which needs
// sigmas.
std::vector<Goodness> goodness_of_groups(const Series &series, const Design &design, bool with_jitter);

struct Instrument {
    int32_t source;               // 0: the series; 1, 2: velocities of A, B
    int64_t samples;              // in use
    double offset, offset_error;  // from the first of its source; 0 for the first
    std::array<double, 3> jitter; // 16, 50 and 84 %
    Goodness goodness;            // without the jitter
};

// jitters: of each. design: of the functions of the series, and others after them.
std::vector<Instrument> instruments_of(const Series &series, const Design &design,
                                       const std::vector<std::array<double, 3>> &jitters);

// Those of a fit without planets.
std::vector<Instrument> instruments_alone(const GivenSeries &given);

} // namespace toliman::planet
