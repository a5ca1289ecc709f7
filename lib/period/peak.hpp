// The highest peak of a periodogram and what it means.
#pragma once
#include "period/stream.hpp"

namespace toliman::period {

struct Peak {
    double frequency, power, log10_residual;
    double grid_frequency; // of the highest grid point
    bool at_edge;          // at the grid's first or last frequency: beyond, the power may be greater
    double fwhm;           // +infinity when the peak has no half-power point on one of its sides
    double frequency_error, amplitude, amplitude_error, phase, offset; // NaN when no samples were seen
};

struct Samples {
    const double *t, *y, *sigma; // sigma may be null: unweighted
    size_t count;
};

// Highest grid point, with the frequency of a parabola through its neighbours. Allocates nothing.
Peak find_peak(const Stream &stream);

constexpr long double kLeastRatio = 1e-4900L; // of residual to total: a perfect fit still has a logarithm

// The same, then least squares in frequency, amplitude, phase and offset on the samples.
Peak fit_peak(const Stream &stream, const Samples &samples);

} // namespace toliman::period
