#include "series/period_report.hpp"

#include "base/constants.hpp"
#include "common/content.hpp"
#include "series/goodness.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

Json peak_json(const PeriodReport &report) {
    const toliman_period_peak &peak = report.periodogram.peak;
    Json json("frequency", peak.frequency, "period", peak.period, "power", peak.power, "log10_residual",
              peak.log10_residual, "fwhm_period", peak.fwhm_period, "half_width_period", peak.half_width_period,
              "frequency_error", peak.frequency_error, "period_error", peak.period_error, "amplitude", peak.amplitude,
              "amplitude_error", peak.amplitude_error, "phase", peak.phase, "time_offset",
              report.periodogram.time_offset, "offset", peak.offset, "log10_fap",
              report.fap.log10(report.fap.residual_of(peak)), "at_edge", report.periodogram.at_edge(), "chi_square",
              peak.chi_square, "chi_square_sigma", peak.chi_square_sigma, "largest_residual", peak.largest_residual,
              "goodness", toliman_constant_name(peak.goodness), "outliers", peak.outliers);
    set_flags(peak.flags, json);
    return json;
}

Json listed_json(const toliman_period_peak &peak, const Fap &fap) {
    Json json("frequency", peak.frequency, "period", peak.period, "power", peak.power, "log10_fap",
              fap.log10(peak.log10_residual), "fwhm_period", peak.fwhm_period, "alias",
              (peak.flags & TOLIMAN_PERIOD_ALIAS) != 0, "at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    set_flags(peak.flags, json);
    return json;
}

} // namespace

Sinusoid PeriodReport::sinusoid() const {
    const toliman_period_peak &peak = periodogram.peak;
    if (noise == nullptr || !noise->is_ar1())
        return {peak.amplitude, peak.frequency, peak.phase, periodogram.time_offset};
    const toliman_period_noise &found = noise->found();
    return {found.amplitude, found.frequency, found.phase, found.time_reference};
}

double PeriodReport::offset() const {
    return noise != nullptr && noise->is_ar1() ? noise->found().offset : periodogram.peak.offset;
}

void PeriodReport::print() const {
    const toliman_period_peak &peak = periodogram.peak;
    const bool refined = !std::isnan(peak.frequency_error); // otherwise from the sums alone
    std::printf("period      %s%s, half width %.3g, FWHM %.3g%s\n",
                text_with_error(peak.period, peak.period_error).c_str(), refined ? " (least squares)" : "",
                peak.half_width_period, peak.fwhm_period, flags_text(peak.flags).c_str());
    std::printf("amplitude   %s, offset %.6g\n", text_with_error(peak.amplitude, peak.amplitude_error).c_str(),
                peak.offset);
    std::printf("phase       %.4g rad at t = %.15g%s\n", peak.phase, periodogram.time_offset,
                time_scale.empty() ? "" : (", Modified Julian Day in " + time_scale).c_str());
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    const double residual = fap.residual_of(peak);
    std::printf("log10 FAP   %s\n", fap.with_method(residual).c_str());
    if (!std::isnan(peak.chi_square))
        std::printf("residuals   %s\n", fit_text(peak).c_str());
    if (peak.outliers > 0)
        std::printf("outliers    %u\n", peak.outliers);
    std::fputs(text_of(aliases).c_str(), stdout);
    std::fputs(text_of(instruments, "").c_str(), stdout);
    if (noise != nullptr)
        noise->print();
    for (size_t i = 1; i < peaks.size(); i++)
        std::printf("peak %-6zu period %.6g, power %.6f, log10 FAP %s%s%s%s\n", i + 1, peaks[i].period, peaks[i].power,
                    fap.text(peaks[i].log10_residual).c_str(),
                    (peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0 ? ", alias" : "",
                    (peaks[i].flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? ", at the edge of the grid" : "",
                    flags_text(peaks[i].flags).c_str());
    std::printf("samples     %lld, grid %.6g + k %.6g, %lld frequencies\n", static_cast<long long>(samples), grid.f0,
                grid.df, static_cast<long long>(grid.nf));
    std::printf("searched    periods from %.6g to %.6g\n", shortest(), longest());
    if (fitted)
        std::fputs(text_of(*fitted).c_str(), stdout);
    if (reduced != nullptr)
        std::printf("reduced     %s\n", reduced->text.c_str());
    print_stdout("");
}

Json PeriodReport::json() const {
    Json json("schema", "toliman-period/2", "n", samples, "time_scale", text_or_null(time_scale), "peak",
              peak_json(*this), "fap_method", fap.method(), "grid", Json("f0", grid.f0, "df", grid.df, "nf", grid.nf),
              "searched", Json("shortest", shortest(), "longest", longest()), "aliases", cli::json_of(aliases));
    if (peaks.size() > 1)
        json.set("peaks", array_of(peaks, [this](const toliman_period_peak &peak) { return listed_json(peak, fap); }));
    if (fitted)
        json.set("functions", json_of(*fitted));
    if (!instruments.empty())
        json.set("instruments", json_of(instruments));
    if (reduced != nullptr)
        json.set("reduction", reduced->json);
    if (noise != nullptr && noise->known())
        json.set("noise", noise->json());
    return json;
}

std::vector<double> nuisance_values(const toliman_measure *series, const std::vector<Coefficient> &coefficients) {
    std::vector<double> sum(static_cast<size_t>(info_of(series).n), coefficients[0].value);
    const std::vector<Function> functions = functions_of(series);
    for (size_t j = 0; j < functions.size(); j++) {
        const Coefficient &coefficient = coefficients[1 + j];
        const std::vector<double> values = values_of(series, functions[j].name);
        for (size_t i = 0; i < sum.size(); i++)
            sum[i] += coefficient.value / coefficient.unit * values[i];
    }
    return sum;
}

void write(OutputFolder &folder, const PeriodReport &report, const toliman_measure *series,
           const toliman::periodogram &residual) {
    const Samples samples(series);
    const std::vector<double> nuisance = report.fitted ? nuisance_values(series, report.fitted->all)
                                                       : std::vector<double>(samples.count(), report.offset());
    std::vector<Column> columns = samples.columns();
    columns.push_back({"nuisance", &nuisance});
    write_csv(folder.open("series.csv"), kPeriodSeriesMark, columns);
    const std::vector<double> frequencies = frequencies_of(report.grid);
    for (const auto &[name, sums] : {std::pair("periodogram.csv", report.periodogram.handle.get()),
                                     std::pair("residual_periodogram.csv", residual.get())}) {
        const std::vector<double> power = power_of(sums, report.grid.nf);
        write_csv(folder.open(name), kPeriodPowerMark, {{"frequency", &frequencies}, {"power", &power}});
    }
    Json json = report.json();
    json.set("version", toliman_version(), "provenance", provenance(), "power_at_fap_1e-3",
             power_at_fap_1e_3(report.periodogram.handle.get()));
    folder.open("result.json").write(json.text());
    folder.commit("result.json"); // which implies that the other files are complete
}

toliman::measurements without(const Sinusoid &sinusoid, const toliman_measure *series) {
    Samples rest(series);
    for (size_t i = 0; i < rest.count(); i++)
        rest.y[i] -=
            sinusoid.amplitude *
            std::sin(2 * toliman::kPi * sinusoid.frequency * (rest.t[i] - sinusoid.time_offset) + sinusoid.phase);
    auto data = toliman::sized<toliman_measure_data>();
    data.y = rest.y.data();
    return changed(series, data);
}

} // namespace cli
