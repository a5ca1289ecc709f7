#include "series/period_report.hpp"

#include <cmath>
#include <cstdio>

#include "common/json.hpp"
#include "common/output.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

double shortest(const FrequencyGrid &grid) {
    return 1 / (grid.f0 + grid.df * static_cast<double>(grid.nf - 1));
}

double longest(const FrequencyGrid &grid) {
    return 1 / grid.f0; // infinite if the grid begins at 0
}

void print_peaks(const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    for (size_t i = 1; i < peaks.size(); i++)
        std::printf("peak %-6zu period %.6g, power %.6f, log10 FAP %s%s%s\n", i + 1, peaks[i].period, peaks[i].power,
                    fap.text(peaks[i].log10_residual).c_str(),
                    (peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0 ? ", alias" : "",
                    (peaks[i].flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? ", at the edge of the grid" : "");
}

std::vector<Json> peaks_json(const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    return array_of(peaks, [&](const toliman_period_peak &peak) {
        Json one;
        one.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
        one.set("log10_fap", fap.log10(peak.log10_residual)).set("fwhm_period", peak.fwhm_period);
        one.set("alias", (peak.flags & TOLIMAN_PERIOD_ALIAS) != 0);
        one.set("at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
        return one;
    });
}

} // namespace

void PeriodReport::print() const {
    const toliman_period_peak &peak = periodogram.peak;
    const bool fitted = !std::isnan(peak.frequency_error); // otherwise from the sums alone
    std::printf("period      %s%s, half width %.3g, FWHM %.3g\n",
                text_with_error(peak.period, peak.period_error).c_str(), fitted ? " (least squares)" : "",
                peak.half_width_period, peak.fwhm_period);
    std::printf("amplitude   %s, offset %.6g\n", text_with_error(peak.amplitude, peak.amplitude_error).c_str(),
                peak.offset);
    std::printf("phase       %.4g rad at t = %.15g%s\n", peak.phase, periodogram.time_offset,
                time_scale.empty() ? "" : (", Modified Julian Day in " + time_scale).c_str());
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    const double residual = fap.residual_of(peak);
    std::printf("log10 FAP   %s (%s)\n", fap.text(residual).c_str(), fap.how(residual).c_str());
    print_peaks(peaks, fap);
    std::printf("samples     %lld, grid %.6g + k %.6g, %lld frequencies\n", static_cast<long long>(samples), grid.f0,
                grid.df, static_cast<long long>(grid.nf));
    std::printf("searched    periods from %.6g to %.6g\n", shortest(grid), longest(grid));
    print_stdout("");
}

std::string PeriodReport::json() const {
    const toliman_period_peak &peak = periodogram.peak;
    Json json, at, on, searched;
    at.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
    at.set("log10_residual", peak.log10_residual).set("fwhm_period", peak.fwhm_period);
    at.set("half_width_period", peak.half_width_period).set("frequency_error", peak.frequency_error);
    at.set("period_error", peak.period_error).set("amplitude", peak.amplitude);
    at.set("amplitude_error", peak.amplitude_error);
    at.set("phase", peak.phase).set("time_offset", periodogram.time_offset).set("offset", peak.offset);
    at.set("log10_fap", fap.log10(fap.residual_of(peak))).set("at_edge", periodogram.at_edge());
    on.set("f0", grid.f0).set("df", grid.df).set("nf", grid.nf);
    json.set("schema", "toliman-period/2").set("n", samples);
    time_scale.empty() ? json.set("time_scale", nullptr) : json.set("time_scale", time_scale);
    json.set("peak", std::move(at)).set("fap_method", fap.method());
    searched.set("shortest", shortest(grid)).set("longest", longest(grid));
    json.set("grid", std::move(on)).set("searched", std::move(searched));
    if (peaks.size() > 1)
        json.set("peaks", peaks_json(peaks, fap));
    return json.text();
}

} // namespace cli
