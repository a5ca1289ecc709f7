#include "series/planet_folder.hpp"

#include "common/content.hpp"
#include "common/npy.hpp"
#include "common/provenance.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr char kResult[] = "result.json", kSeries[] = "series.csv", kLimits[] = "limits.csv";

std::vector<double> signal_of(const PlanetSearch &search, uint32_t planet, const Series &series) {
    std::vector<double> signal(series.t.size());
    const std::vector<double> &angles = series.position_angle_deg;
    toliman::check(toliman_planet_get_signal(search.handle.get(), planet, series.t.data(),
                                             angles.empty() ? nullptr : angles.data(), signal.size(), signal.data()));
    return signal;
}

} // namespace

PlanetFolder::PlanetFolder(const std::string &path, bool with_limits) : folder_(path) {
    folder_.open(kResult);
    folder_.open(kSeries);
    if (with_limits)
        folder_.open(kLimits);
}

void PlanetFolder::write(const PlanetReport &report) {
    write_series(report);
    for (uint32_t i = 0; i < report.search.info.candidates; i++)
        write_samples(report.search, i);
    if (!report.limits.empty())
        write_limits(report);
    Json json = report.json();
    json.set("version", toliman_version(), "provenance", provenance());
    folder_.open(kResult).write(json.text());
    folder_.commit(kResult); // a result.json implies that the other files are complete
}

void PlanetFolder::write_series(const PlanetReport &report) {
    const Series &series = report.series;
    const size_t count = series.t.size();
    std::vector<double> residuals(count + report.search.velocities); // those of velocities follow
    toliman::check(toliman_planet_get_residuals(report.search.handle.get(), residuals.size(), residuals.data()));
    std::vector<std::vector<double>> signals;
    std::string text = std::string(kPlanetSeriesMark) + (series.sigma.empty() ? "t,y,residual" : "t,y,sigma,residual");
    for (uint32_t i = 0; i < report.search.fitted(); i++) {
        signals.push_back(signal_of(report.search, i, series));
        text += formatted(",signal_%u", i + 1);
    }
    text += "\n";
    for (size_t i = 0; i < count; i++) {
        text += formatted("%.17g,%.17g,", series.t[i], series.y[i]);
        text += series.sigma.empty() ? "" : formatted("%.17g,", series.sigma[i]);
        text += formatted("%.17g", residuals[i]);
        for (const std::vector<double> &signal : signals)
            text += formatted(",%.17g", signal[i]);
        text += "\n";
    }
    folder_.open(kSeries).write(text);
}

void PlanetFolder::write_samples(const PlanetSearch &search, uint32_t index) {
    const size_t count = search.options.samples;
    std::vector<double> samples(count * TOLIMAN_PLANET_COLUMNS);
    toliman::check(toliman_planet_get_samples(search.handle.get(), index, count, samples.data()));
    write_npy(folder_.open(formatted("samples_%u.npy", index + 1)), samples, {count, TOLIMAN_PLANET_COLUMNS});
}

void PlanetFolder::write_limits(const PlanetReport &report) {
    std::string text = std::string(kPlanetLimitsMark) + "period,upper,detectable,upper_mass_a,upper_mass_b,"
                                                        "detectable_mass_a,detectable_mass_b\n";
    for (const toliman_planet_limit &limit : report.limits)
        text += formatted("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", limit.period, limit.upper, limit.detectable,
                          limit.upper_mass_a, limit.upper_mass_b, limit.detectable_mass_a, limit.detectable_mass_b);
    folder_.open(kLimits).write(text);
}

} // namespace cli
