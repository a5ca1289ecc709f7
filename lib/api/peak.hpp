// A peak as the callers get it.
#pragma once
#include <toliman/period.h>

#include "period/fap.hpp"
#include "period/peak.hpp"
#include "period/sampling.hpp"

namespace toliman::api {

inline toliman_period_peak public_peak(const period::Stream &stream, const period::Peak &peak) noexcept {
    toliman_period_peak out = {};
    out.flags = (peak.at_edge ? TOLIMAN_PERIOD_AT_EDGE : 0u) | (peak.alias ? TOLIMAN_PERIOD_ALIAS : 0u) |
                (peak.inaccurate ? TOLIMAN_PERIOD_INACCURATE : 0u);
    out.frequency = peak.frequency;
    out.period = 1 / peak.frequency;
    out.power = peak.power;
    out.log10_residual = peak.log10_residual;
    out.fwhm = peak.fwhm;
    out.fwhm_period = peak.fwhm / (peak.frequency * peak.frequency);
    out.half_width_period = out.fwhm_period / 2;
    out.frequency_error = peak.frequency_error;
    out.amplitude = peak.amplitude;
    out.amplitude_error = peak.amplitude_error;
    out.phase = peak.phase;
    out.offset = peak.offset;
    out.log10_fap = log10_fap(period::Fap::baluev, period::sampling_of(stream), peak.log10_residual);
    out.period_error = peak.frequency_error / (peak.frequency * peak.frequency);
    return out;
}

} // namespace toliman::api
