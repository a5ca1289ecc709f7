// Peaks of a periodogram: the highest on the grid, the local maxima, and the least-squares fit on the samples.
#pragma once
#include <limits>

#include "base/goodness.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct Peak {
    double frequency, power, log10_residual;
    double grid_frequency; // of the grid point with the highest power
    bool at_edge;          // at the grid's first or last frequency: the power may be greater beyond it
    bool alias;            // find_peaks only: the sampling could produce it from a higher peak
    bool inaccurate;       // the error bound of the power at the grid point exceeds 1e-3
    double fwhm;           // full width at half maximum; +infinity without a half-power point on both sides
    double frequency_error, amplitude, amplitude_error, phase, offset; // NaN without samples
    Goodness goodness;                                                 // of the samples and the sigmas; unknown without
    size_t outliers = 0; // samples that do not belong to the others; 0 without sigmas
};

struct Samples {
    const double *t, *y, *sigma; // sigma may be NULL: unweighted
    size_t count;
    const double *columns = nullptr; // [count][columns of the basis]
};

Sample sample_of(const Stream &stream, const Samples &samples, size_t i) noexcept;

// Fails unless these can be the samples pushed: their number matches and each one passes Stream::check.
void check_pushed(const Stream &stream, const Samples &samples);

class PowerQuery;

// Fails with Status::state unless query.meaningful(). what: "a peak".
void check_meaningful(const PowerQuery &query, const Stream &stream, const char *what);

// Returns the grid point of the highest power.
int64_t highest_point(const PowerQuery &query, const Stream &stream);

// Returns the highest peak, or that of the longest period of which it may be an alias (alias.hpp); its frequency is
// refined by a parabola through the neighbours. Does not allocate.
Peak find_peak(const Stream &stream);

// log10(1 - power) of the highest grid point.
double highest_log10_residual(const Stream &stream);

constexpr size_t kMaxPeaks = 64;

// Finds the peak of find_peak and the `most` - 1 (at most kMaxPeaks - 1) highest other local maxima of the grid,
// refined likewise, highest first. Returns their number.
size_t find_peaks(const Stream &stream, size_t most, Peak *peaks);

constexpr long double kMinResidualRatio =
    1e-4900L; // residual over total sum of squares, so that a perfect fit has a logarithm

// Returns the highest peak, refined by least squares in frequency, amplitude, phase and offset on the samples.
Peak fit_peak(const Stream &stream, const Samples &samples);

} // namespace toliman::period
