// Converts a peak to the public struct.
#pragma once
#include <cmath>

#include <toliman/period.h>

#include "api/goodness.hpp"
#include "api/guard.hpp"
#include "api/members.hpp"
#include "period/fap.hpp"
#include "period/peak.hpp"
#include "period/sampling.hpp"
#include "period/stream/power.hpp"

namespace toliman::api {

// Flags that compare the grid with the samples' cadence: steps too coarse, frequencies above Nyquist.
inline uint32_t grid_flags(const period::Grid &grid, const period::Cadence &cadence) noexcept {
    const bool coarse = grid.df * 5 * cadence.span > period::kRounding;
    const bool past = grid.last() * 2 * cadence.finest > period::kRounding;
    return (coarse ? TOLIMAN_PERIOD_COARSE : 0u) | (past ? TOLIMAN_PERIOD_ABOVE_NYQUIST : 0u);
}

// Flags of a peak that compares with the time span, or with the year, as a slow or seasonal effect may.
inline uint32_t slow_flags(const period::Grid &grid, double frequency, double span) noexcept {
    constexpr double kYearNs = 365.25 * 86400e9;
    const double year = kYearNs / grid.unit_ns;
    const bool is_long = frequency * span < 2;
    const bool is_annual = span > year / 2 && std::fabs(frequency - 1 / year) * span < 1;
    return (is_long ? TOLIMAN_PERIOD_LONG : 0u) | (is_annual ? TOLIMAN_PERIOD_ANNUAL : 0u);
}

// Fails unless there is a model at frequency k.
inline void check_model(const period::PowerQuery &query, const period::Stream &stream, int64_t k) {
    required_index(k, static_cast<size_t>(stream.grid().nf), "k");
    check_meaningful(query, stream, "a model");
    query.check();
}

inline toliman_period_peak public_peak(const period::Stream &stream, const period::Peak &peak) noexcept {
    const period::Sampling sampling = period::sampling_of(stream);
    const period::Cadence cadence = period::cadence_of(sampling);
    toliman_period_peak out = {};
    out.flags = (peak.at_edge ? TOLIMAN_PERIOD_AT_EDGE : 0u) | (peak.alias ? TOLIMAN_PERIOD_ALIAS : 0u) |
                (peak.inaccurate ? TOLIMAN_PERIOD_INACCURATE : 0u) |
                // The sums contain the variance of the times, from which the span follows, but not the step.
                (grid_flags(stream.grid(), cadence) & TOLIMAN_PERIOD_COARSE) |
                slow_flags(stream.grid(), peak.frequency, cadence.span);
    TOLIMAN_COPY(out, peak, frequency, power, log10_residual, fwhm, frequency_error);
    TOLIMAN_COPY(out, peak, amplitude, amplitude_error, phase, offset);
    out.period = 1 / peak.frequency;
    out.fwhm_period = peak.fwhm / (peak.frequency * peak.frequency);
    out.half_width_period = out.fwhm_period / 2;
    out.log10_fap = log10_fap(period::Fap::baluev, sampling, peak.log10_residual);
    out.period_error = peak.frequency_error / (peak.frequency * peak.frequency);
    set_goodness(peak.goodness, out);
    out.outliers = static_cast<uint32_t>(peak.outliers);
    return out;
}

// The peak refined against the samples; their times give the exact grid flags.
inline toliman_period_peak public_fit(const period::Stream &stream, const period::Samples &samples) {
    toliman_period_peak peak = public_peak(stream, period::fit_peak(stream, samples));
    const period::Cadence cadence = period::cadence_of(stream, samples.t, samples.count);
    peak.flags &= ~(TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_LONG | TOLIMAN_PERIOD_ANNUAL);
    peak.flags |= grid_flags(stream.grid(), cadence) | slow_flags(stream.grid(), peak.frequency, cadence.span);
    return peak;
}

} // namespace toliman::api
