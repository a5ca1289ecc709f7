#include "series/planet_report.hpp"

#include <tuple>

#include "common/content.hpp"
#include "common/npy.hpp"
#include "scenes/dates.hpp"
#include "series/goodness.hpp"

namespace cli {

namespace {

// "479.10 (-2.30 +2.41)" of the 16, 50 and 84 % points times a factor.
std::string interval_text(const double (&points)[3], double factor = 1) {
    const double middle = points[1] * factor;
    const double below = std::fabs(points[1] - points[0]) * std::fabs(factor);
    const double above = std::fabs(points[2] - points[1]) * std::fabs(factor);
    const double least = std::min(below, above);
    if (!std::isfinite(middle) || !(least > 0))
        return formatted("%.6g", middle);
    if (std::max(std::fabs(middle), above) < 1e-4)
        return formatted("%.4e (-%.1e +%.1e)", middle, below, above);
    const int decimals = decimals_of(least);
    return formatted("%.*f (-%.*f +%.*f)", decimals, middle, decimals, below, decimals, above);
}

std::vector<double> listed(const double (&points)[3]) {
    return {points[0], points[1], points[2]};
}

std::optional<std::vector<double>> listed_if(bool is_known, const double (&points)[3]) {
    return if_known(is_known, listed(points));
}

// An infinite size is never detected.
std::string cell_text(double value) {
    return std::isinf(value) ? formatted("%12s", "never") : formatted("%12.4g", value);
}

std::vector<double> signal_of(const PlanetSearch &search, uint32_t planet, const toliman_measure *series) {
    const std::vector<double> times = values_of(series, "t"), angles = values_of(series, "position_angle_deg");
    std::vector<double> signal(times.size());
    toliman::check(toliman_planet_get_signal(search.handle.get(), planet, times.data(),
                                             angles.empty() ? nullptr : angles.data(), signal.size(), signal.data()));
    return signal;
}

} // namespace

std::string PlanetReport::amplitude_text(double value) const {
    if (search.unit.in_uas())
        return formatted("%.4g uas", search.uas(value));
    return formatted("%.4g ", value) + (search.unit.name.empty() ? "units of y" : search.unit.name);
}

std::string PlanetReport::mass_text(const toliman_planet_candidate &planet) const {
    std::string text;
    if (planet.star >= 0 && search.knows_mass(static_cast<size_t>(planet.star)))
        return interval_text(planet.star == 0 ? planet.mass_a : planet.mass_b) + " Earths";
    if (search.knows_mass(0))
        text = interval_text(planet.mass_a) + (search.unit.is_velocity ? "" : " on A");
    if (search.knows_mass(1))
        text += (text.empty() ? "" : ", ") + interval_text(planet.mass_b) + " on B";
    if (text.empty())
        return std::string("unknown without ") + (search.unit.name.empty() ? "--unit, " : "") +
               (search.unit.is_velocity || search.options.parallax_arcsec > 0 ? "" : "--parallax, ") + "--star-masses";
    return text + (search.unit.is_velocity ? " Earths times sin i" : ", Earths times g");
}

std::string PlanetReport::planet_text(size_t index) const {
    const toliman_planet_candidate &planet = search.candidates[index];
    const bool uas = search.unit.in_uas();
    const std::string unit = uas ? "uas" : search.unit.name;
    std::string text =
        formatted("%s %zu%slog10 Bayes factor %.2f, log10 FAP %.2f, of the orbit %.2f\n",
                  planet.reasons == 0 ? "planet" : "candidate", index + 1, planet.reasons == 0 ? "    " : " ",
                  planet.log10_bayes, planet.log10_fap, planet.log10_fap_orbit);
    for (const std::string &reason : search.reasons(index))
        text += "  reason        " + reason + "\n";
    text += "  period        " + interval_text(planet.period) + " d\n";
    text += "  eccentricity  " + interval_text(planet.eccentricity) + "\n";
    text += "  periastron    " + interval_text(planet.periastron_deg) + " deg\n";
    text += "  epoch         " + interval_text(planet.epoch);
    const std::string scale = name_of_scale(info_of(series).time_scale);
    text += scale.empty() ? "\n" : " MJD, " + mjd_day(planet.epoch[1]) + " " + scale + "\n";
    text += "  amplitude     " + interval_text(planet.amplitude, uas ? search.uas(1) : 1) +
            (unit.empty() ? "" : " " + unit) + "\n";
    if (planet.star >= 0) {
        text += std::string("  star          ") + (planet.star == 0 ? "A" : "B") +
                formatted(", log10 odds against the other star %.2f\n", std::fabs(planet.log10_star));
        text += "  inclination   " + interval_text(planet.inclination_deg) + " deg, or 180 deg minus it\n";
        text += "  node          " + interval_text(planet.node_deg) + " deg from the axis, to either side\n";
    }
    return text + "  mass          " + mass_text(planet) + "\n";
}

// The last candidate, if its odds are below the threshold.
std::string PlanetReport::candidate_text() const {
    if (search.fitted() == search.candidates.size())
        return "";
    const toliman_planet_candidate &next = search.candidates.back();
    const Apart bayes = apart(next.log10_bayes, search.options.threshold, 3);
    return formatted("candidate   period %.6g d, log10 Bayes factor %s below the threshold %s: not a planet; log10 FAP "
                     "%.2f\n",
                     next.period[1], bayes.value.c_str(), bayes.limit.c_str(), next.log10_fap);
}

std::string PlanetReport::axis_text() const {
    const toliman_planet_info &info = search.info;
    if (search.unit.is_velocity)
        return "";
    if (!std::isnan(info.axis_deg))
        return formatted("axis        position angle %.2f deg, turns by %.2f deg\n", info.axis_deg, info.axis_turn_deg);
    return "axis        fixed: no position angles without --system; the period of a face-on orbit is wrong by the "
           "angle "
           "through\n            which the axis turns in one period, divided by 360 deg (alpha Centauri: 0.8 % at 479 "
           "d)\n";
}

// A table; without columns of masses that are not known.
std::string PlanetReport::limits_text() const {
    if (limits.empty())
        return "";
    using Limit = toliman_planet_limit;
    const bool uas = search.unit.in_uas();
    const std::string unit = uas ? "uas" : search.unit.name.empty() ? "units of y" : search.unit.name;
    std::vector<std::tuple<const char *, double Limit::*, double>> columns = {{"period", &Limit::period, 1}};
    const double factor = uas ? search.uas(1) : 1;
    for (const auto &[name, amplitude, mass_a, mass_b] :
         {std::tuple("upper", &Limit::upper, &Limit::upper_mass_a, &Limit::upper_mass_b),
          std::tuple("detectable", &Limit::detectable, &Limit::detectable_mass_a, &Limit::detectable_mass_b)}) {
        columns.emplace_back(name, amplitude, factor);
        if (search.knows_mass(0))
            columns.emplace_back("mass on A", mass_a, 1);
        if (search.knows_mass(1))
            columns.emplace_back("mass on B", mass_b, 1);
    }
    std::string text = formatted("limits      with a probability of %g, amplitudes in ", kLimitProbability) + unit +
                       (columns.size() > 3 ? ", masses in Earths\n" : "\n");
    for (const auto &[name, member, scale] : columns)
        text += formatted("%12s", name);
    text += "\n";
    for (const Limit &limit : limits) {
        for (const auto &[name, member, scale] : columns)
            text += cell_text(limit.*member * scale);
        text += "\n";
    }
    return text;
}

std::string PlanetReport::fit_text() const {
    const toliman_planet_info &info = search.info;
    std::string text = "residuals   rms " + amplitude_text(info.rms);
    if (!std::isnan(info.chi_square))
        text += ", " + cli::fit_text(info);
    if (info.jitter[1] > 0)
        text += "\njitter      " + amplitude_text(info.jitter[1]) +
                formatted(", chi-square with it %.4g", info.chi_square_with_jitter);
    return text + "\n";
}

std::string PlanetReport::outlier_text() const {
    const std::string of_velocities =
        search.velocity_outliers > 0 ? formatted("outliers    %zu velocities\n", search.velocity_outliers) : "";
    if (search.outliers.empty())
        return of_velocities;
    return formatted("outliers    %zu, without weight in the search: ", search.outliers.size()) +
           listed_outliers(search.outliers, series) + "\n" + of_velocities;
}

void PlanetReport::warn(Progress &progress) const {
    warn_of_fit(search.info, progress);
    if ((search.options.flags & TOLIMAN_PLANET_CLIP) == 0)
        warn_of_outliers(search.outliers.size(), ", which --clip leaves out", progress);
}

void PlanetReport::refuse() const {
    std::string text;
    for (size_t i = 0; i < search.fitted(); i++)
        for (const std::string &reason : search.reasons(i))
            text += (text.empty() ? "" : "; ") + formatted("candidate %zu is not a planet: ", i + 1) + reason;
    if (!text.empty())
        throw Failure(kExitRejected, name_of(series) + ": " + text);
}

void PlanetReport::print() const {
    const toliman_planet_info &info = search.info;
    std::string text = info.planets == 0 ? "no planet\n" : "";
    for (size_t i = 0; i < search.fitted(); i++)
        text += planet_text(i);
    text += candidate_text() + fit_text() + outlier_text();
    text += text_of(search.instruments, search.velocities > 0 ? "" : search.unit.name);
    text += formatted("samples     %lld; %u functions fitted, the mean and nuisance functions\n",
                      static_cast<long long>(info_of(series).n), info.functions);
    text += formatted("searched    periods from %.6g to %.6g d, amplitudes from ", info.period_min, info.period_max) +
            amplitude_text(info.amplitude_min) + " to " + amplitude_text(info.amplitude_max) + "\n";
    text += axis_text();
    if (reduced)
        text += "reduced     " + reduced->text + "\n";
    text += limits_text();
    print_stdout(text);
    if (map)
        map->print();
}

std::vector<double> PlanetReport::in_uas(const double (&points)[3]) const {
    return {search.uas(points[0]), search.uas(points[1]), search.uas(points[2])};
}

Json PlanetReport::planet_json(size_t index) const {
    const toliman_planet_candidate &planet = search.candidates[index];
    std::vector<std::vector<double>> correlation;
    for (size_t i = 0; i < 5; i++)
        correlation.emplace_back(planet.correlation + 5 * i, planet.correlation + 5 * (i + 1));
    const auto five = [this](const double(&values)[5]) {
        return Json("period", values[0], "eccentricity", values[1], "periastron_deg", values[2], "epoch", values[3],
                    "amplitude", values[4], "amplitude_uas", uas(values[4]));
    };
    return Json("verdict", planet.reasons == 0 ? "planet" : "candidate", "reasons", search.reasons(index),
                "log10_bayes", planet.log10_bayes, "log10_bayes_error", planet.log10_bayes_error, "log10_fap",
                planet.log10_fap, "log10_fap_orbit", planet.log10_fap_orbit, "period", listed(planet.period),
                "eccentricity", listed(planet.eccentricity), "periastron_deg", listed(planet.periastron_deg), "epoch",
                listed(planet.epoch), "amplitude", listed(planet.amplitude), "amplitude_uas",
                if_known(search.unit.in_uas(), in_uas(planet.amplitude)), "mass_a_earth",
                listed_if(search.knows_mass(0) && planet.star != 1, planet.mass_a), "mass_b_earth",
                listed_if(search.knows_mass(1) && planet.star != 0, planet.mass_b), "star",
                text_or_null(planet.star < 0    ? ""
                             : planet.star == 0 ? "A"
                                                : "B"),
                "log10_star", if_known(planet.star >= 0, planet.log10_star), "inclination_deg",
                listed_if(planet.star >= 0, planet.inclination_deg), "node_deg",
                listed_if(planet.star >= 0, planet.node_deg), "best", five(planet.best), "best_error",
                five(planet.best_error), "correlation", correlation, "power_left", planet.power_left, "at_edge",
                (planet.flags & TOLIMAN_PLANET_AT_EDGE) != 0);
}

std::optional<double> PlanetReport::uas(double value) const {
    return if_known(search.unit.in_uas(), search.uas(value));
}

Json PlanetReport::limit_json(const toliman_planet_limit &limit) const {
    return Json("period", limit.period, "upper", limit.upper, "upper_uas", uas(limit.upper), "detectable",
                limit.detectable, "detectable_uas", uas(limit.detectable), "upper_mass_a", limit.upper_mass_a,
                "upper_mass_b", limit.upper_mass_b, "detectable_mass_a", limit.detectable_mass_a, "detectable_mass_b",
                limit.detectable_mass_b);
}

Json PlanetReport::json() const {
    const toliman_planet_info &info = search.info;
    const toliman_planet_options &how = search.options;
    const toliman_measure_info given = info_of(series);
    const auto positive = [](double value) { return if_known(value > 0, value); };
    std::vector<size_t> indices(search.candidates.size());
    for (size_t i = 0; i < indices.size(); i++)
        indices[i] = i;
    Json json(
        "schema", "toliman-planet/1", "n", given.n, "time_scale", text_or_null(name_of_scale(given.time_scale)), "kind",
        search.unit.is_velocity ? "velocity" : "separation", "unit", text_or_null(search.unit.name), "unit_arcsec",
        if_known(search.unit.in_uas(), search.unit.factor), "parallax_mas", positive(how.parallax_arcsec * 1000),
        "star_masses", std::vector{positive(how.star_mass[0]), positive(how.star_mass[1])}, "functions", info.functions,
        "threshold", how.threshold, "prior",
        Json("period_min", info.period_min, "period_max", info.period_max, "amplitude_min", info.amplitude_min,
             "amplitude_min_uas", uas(info.amplitude_min), "amplitude_max", info.amplitude_max, "amplitude_max_uas",
             uas(info.amplitude_max)),
        "planets", info.planets, "candidates", array_of(indices, [this](size_t index) { return planet_json(index); }),
        "time_reference", info.time_reference, "rms", info.rms, "rms_uas", uas(info.rms), "chi_square", info.chi_square,
        "chi_square_sigma", info.chi_square_sigma, "largest_residual", info.largest_residual, "goodness",
        toliman_constant_name(info.goodness), "chi_square_with_jitter", info.chi_square_with_jitter, "jitter",
        listed_if(info.jitter[1] > 0, info.jitter), "jitter_uas",
        if_known(info.jitter[1] > 0 && search.unit.in_uas(), in_uas(info.jitter)), "frame_chi_square",
        positive(given.frame_chi_square), "outliers", json_of_outliers(search.outliers, series), "clip",
        (how.flags & TOLIMAN_PLANET_CLIP) != 0, "axis",
        if_known(!std::isnan(info.axis_deg), Json("position_angle_deg", info.axis_deg, "turn_deg", info.axis_turn_deg)),
        "detection_fap", how.detection_fap);
    if (!search.instruments.empty())
        json.set("instruments", json_of(search.instruments));
    if (search.velocities > 0)
        json.set("velocities", search.velocities, "velocity_outliers", search.velocity_outliers);
    if (!limits.empty())
        json.set("limits", Json("probability", kLimitProbability, "periods",
                                array_of(limits, [this](const auto &limit) { return limit_json(limit); })));
    if (map)
        json.set("map", map->json());
    if (reduced)
        json.set("reduction", reduced->json);
    return json;
}

std::vector<const char *> files_of(bool with_limits) {
    std::vector<const char *> files = {"result.json", "series.csv"};
    if (with_limits)
        files.push_back("limits.csv");
    return files;
}

namespace {

void write_series(OutputFile &out, const PlanetReport &report) {
    const Samples samples(report.series);
    std::vector<double> residuals(samples.count() + report.search.velocities); // those of velocities follow
    toliman::check(toliman_planet_get_residuals(report.search.handle.get(), residuals.size(), residuals.data()));
    std::vector<Column> columns = samples.columns();
    columns.push_back({"residual", &residuals});
    std::vector<std::vector<double>> signals;
    for (uint32_t i = 0; i < report.search.fitted(); i++)
        signals.push_back(signal_of(report.search, i, report.series));
    for (size_t i = 0; i < signals.size(); i++)
        columns.push_back({formatted("signal_%zu", i + 1), &signals[i]});
    write_csv(out, kPlanetSeriesMark, columns);
}

void write_samples(OutputFile &out, const PlanetSearch &search, uint32_t index) {
    const size_t count = search.options.samples;
    std::vector<double> samples(count * TOLIMAN_PLANET_COLUMNS);
    toliman::check(toliman_planet_get_samples(search.handle.get(), index, count, samples.data()));
    write_npy(out, samples, {count, TOLIMAN_PLANET_COLUMNS});
}

void write_limits(OutputFile &out, const std::vector<toliman_planet_limit> &limits) {
    std::string text = std::string(kPlanetLimitsMark) + "period,upper,detectable,upper_mass_a,upper_mass_b,"
                                                        "detectable_mass_a,detectable_mass_b\n";
    for (const toliman_planet_limit &limit : limits)
        text += formatted("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", limit.period, limit.upper, limit.detectable,
                          limit.upper_mass_a, limit.upper_mass_b, limit.detectable_mass_a, limit.detectable_mass_b);
    out.write(text);
}

} // namespace

void write(OutputFolder &folder, const PlanetReport &report) {
    write_series(folder.open("series.csv"), report);
    for (uint32_t i = 0; i < report.search.info.candidates; i++)
        write_samples(folder.open(formatted("samples_%u.npy", i + 1)), report.search, i);
    if (!report.limits.empty())
        write_limits(folder.open("limits.csv"), report.limits);
    Json json = report.json();
    json.set("version", toliman_version(), "provenance", provenance());
    folder.open("result.json").write(json.text());
    folder.commit("result.json"); // which implies that the other files are complete
}

} // namespace cli
