// The highest peak of a periodogram and what it means.
#pragma once
#include "period/stream.hpp"

namespace toliman::period {

struct Peak {
    double frequency, power, log10_residual;
    double grid_frequency; // of the highest grid point
    bool at_edge;          // at the grid's first or last frequency: beyond, the power may be greater
    bool alias;            // of find_peaks: the sampling could make it of a higher one
    bool inaccurate;       // the grid point's power, by the sums
    double fwhm;           // +infinity when the peak has no half-power point on one of its sides
    double frequency_error, amplitude, amplitude_error, phase, offset; // NaN when no samples were seen
};

struct Samples {
    const double *t, *y, *sigma; // sigma may be null: unweighted
    size_t count;
};

// Fails unless they are as many as were pushed, and such as can be.
void check_pushed(const Stream &stream, const Samples &samples);

// Highest grid point, with the frequency of a parabola through its neighbours. Allocates nothing.
Peak find_peak(const Stream &stream);

constexpr size_t kMostPeaks = 64;

// The `most` highest local maxima of the grid, at most kMostPeaks, highest first, refined likewise; how many there are.
size_t find_peaks(const Stream &stream, size_t most, Peak *peaks);

constexpr long double kLeastRatio = 1e-4900L; // of residual to total: a perfect fit still has a logarithm

// The same, then least squares in frequency, amplitude, phase and offset on the samples.
Peak fit_peak(const Stream &stream, const Samples &samples);

} // namespace toliman::period
