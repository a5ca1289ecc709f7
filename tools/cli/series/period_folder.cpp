#include "series/period_folder.hpp"

#include <cmath>

#include "base/constants.hpp"
#include "common/content.hpp"
#include "common/provenance.hpp"
#include "common/text.hpp"
#include "series/measure.hpp"

namespace cli {

namespace {

constexpr char kResult[] = "result.json", kSeries[] = "series.csv", kPower[] = "periodogram.csv",
               kResidualPower[] = "residual_periodogram.csv";

} // namespace

std::vector<double> nuisance_values(const Series &series, const std::vector<Coefficient> &coefficients) {
    std::vector<double> values(series.t.size(), coefficients[0].value);
    const std::vector<std::vector<double>> functions = functions_of(series);
    for (size_t j = 0; j < functions.size(); j++) {
        const Coefficient &coefficient = coefficients[1 + j];
        for (size_t i = 0; i < values.size(); i++)
            values[i] += coefficient.value / coefficient.unit * functions[j][i];
    }
    return values;
}

PeriodFolder::PeriodFolder(const std::string &path) : folder_(path) {
    for (const char *name : {kResult, kSeries, kPower, kResidualPower})
        folder_.open(name);
}

void PeriodFolder::write(const PeriodReport &report, const Series &series, const toliman::periodogram &residual) {
    write_series(report, series);
    write_power(kPower, report.periodogram.handle, report.grid);
    write_power(kResidualPower, residual, report.grid);
    Json json = report.json();
    json.set("version", toliman_version(), "provenance", provenance(), "power_at_fap_1e-3",
             power_at_fap_1e_3(report.periodogram.handle.get()));
    folder_.open(kResult).write(json.text());
    folder_.commit(kResult); // a result.json implies that the other files are complete
}

void PeriodFolder::write_series(const PeriodReport &report, const Series &series) {
    const std::vector<double> nuisance = report.fitted ? nuisance_values(series, report.fitted->all)
                                                       : std::vector<double>(series.t.size(), report.offset());
    std::string text =
        std::string(kPeriodSeriesMark) + (series.sigma.empty() ? "t,y,nuisance\n" : "t,y,sigma,nuisance\n");
    for (size_t i = 0; i < nuisance.size(); i++)
        text += formatted("%.17g,%.17g,", series.t[i], series.y[i]) +
                (series.sigma.empty() ? "" : formatted("%.17g,", series.sigma[i])) + formatted("%.17g\n", nuisance[i]);
    folder_.open(kSeries).write(text);
}

void PeriodFolder::write_power(const std::string &name, const toliman::periodogram &periodogram,
                               const FrequencyGrid &grid) {
    const std::vector<double> power = power_of(periodogram.get(), grid.nf);
    std::string text = std::string(kPeriodPowerMark) + "frequency,power\n";
    for (size_t k = 0; k < power.size(); k++)
        text += formatted("%.17g,%.17g\n", grid.f0 + grid.df * static_cast<double>(k), power[k]);
    folder_.open(name).write(text);
}

Series without(const Sinusoid &sinusoid, const Series &series) {
    Series rest = series;
    for (size_t i = 0; i < rest.t.size(); i++)
        rest.y[i] -=
            sinusoid.amplitude *
            std::sin(2 * toliman::kPi * sinusoid.frequency * (rest.t[i] - sinusoid.time_offset) + sinusoid.phase);
    return rest;
}

} // namespace cli
