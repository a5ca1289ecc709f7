#include "series/planet_report.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/output.hpp"
#include "common/text.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;

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

std::string day_of(double mjd) {
    return date_text(std::llround((mjd - kMjdOf1970) * kNsPerDay)).substr(0, 10);
}

} // namespace

std::string PlanetReport::amplitude_text(double value) const {
    if (search.unit.in_uas())
        return formatted("%.4g uas", search.uas(value));
    return formatted("%.4g ", value) + (search.unit.name.empty() ? "units of y" : search.unit.name);
}

std::string PlanetReport::mass_text(const toliman_planet &planet) const {
    std::string text;
    if (search.knows_mass(0))
        text = interval_text(planet.mass_a) + (search.unit.is_velocity ? "" : " on A");
    if (search.knows_mass(1))
        text += (text.empty() ? "" : ", ") + interval_text(planet.mass_b) + " on B";
    if (text.empty())
        return std::string("unknown without --unit, ") + (search.unit.is_velocity ? "" : "--parallax, ") +
               "--star-masses";
    return text + (search.unit.is_velocity ? " Earths times sin i" : ", Earths times g");
}

std::string PlanetReport::planet_text(size_t index) const {
    const toliman_planet &planet = search.candidates[index];
    const bool uas = search.unit.in_uas();
    const std::string unit = uas ? "uas" : search.unit.name;
    std::string text =
        formatted("planet %-4zu log10 Bayes factor %.2f, log10 FAP %.2f%s\n", index + 1, planet.log10_bayes,
                  planet.log10_fap, (planet.flags & TOLIMAN_PLANET_AT_EDGE) != 0 ? ", at the edge of the prior" : "");
    text += "  period        " + interval_text(planet.period) + " d\n";
    text += "  eccentricity  " + interval_text(planet.eccentricity) + "\n";
    text += "  periastron    " + interval_text(planet.periastron_deg) + " deg\n";
    text += "  epoch         " + interval_text(planet.epoch);
    text += series.time_scale.empty() ? "\n" : " MJD, " + day_of(planet.epoch[1]) + " " + series.time_scale + "\n";
    text += "  amplitude     " + interval_text(planet.amplitude, uas ? search.uas(1) : 1) +
            (unit.empty() ? "" : " " + unit) + "\n";
    return text + "  mass          " + mass_text(planet) + "\n";
}

// The last candidate, if it is not a planet.
std::string PlanetReport::candidate_text() const {
    if (search.info.candidates == search.info.planets)
        return "";
    const toliman_planet &next = search.candidates.back();
    return formatted("candidate   period %.6g d, log10 Bayes factor %.2f below the threshold %.4g: not a planet; log10 "
                     "FAP %.2f\n",
                     next.period[1], next.log10_bayes, search.options.threshold, next.log10_fap);
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

void PlanetReport::warn(Progress &progress) const {
    for (uint32_t i = 0; i < search.info.planets; i++)
        if ((search.candidates[i].flags & TOLIMAN_PLANET_AT_EDGE) != 0)
            progress.warn(formatted("planet %u: more than 1 %% of the posterior is at the edge of the prior: period or "
                                    "eccentricity may be outside (--period-min, --period-max)",
                                    i + 1));
}

void PlanetReport::print() const {
    const toliman_planet_info &info = search.info;
    std::string text = info.planets == 0 ? "no planet\n" : "";
    for (uint32_t i = 0; i < info.planets; i++)
        text += planet_text(i);
    text += candidate_text();
    text += "residuals   rms " + amplitude_text(info.rms) + formatted(", chi-square %.4g per sample", info.chi_square);
    if ((search.options.flags & TOLIMAN_PLANET_JITTER) != 0)
        text += ", jitter " + amplitude_text(info.jitter[1]);
    text += formatted("\nsamples     %zu; %u functions fitted, the mean and nuisance functions\n", series.t.size(),
                      info.functions);
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

Json PlanetReport::planet_json(size_t index) const {
    const toliman_planet &planet = search.candidates[index];
    std::vector<std::vector<double>> correlation;
    for (size_t i = 0; i < 5; i++)
        correlation.emplace_back(planet.correlation + 5 * i, planet.correlation + 5 * (i + 1));
    const auto five = [](const double(&values)[5]) {
        return Json("period", values[0], "eccentricity", values[1], "periastron_deg", values[2], "epoch", values[3],
                    "amplitude", values[4]);
    };
    const double factor = search.uas(1);
    return Json("planet", index < search.info.planets, "log10_bayes", planet.log10_bayes, "log10_fap", planet.log10_fap,
                "period", listed(planet.period), "eccentricity", listed(planet.eccentricity), "periastron_deg",
                listed(planet.periastron_deg), "epoch", listed(planet.epoch), "amplitude", listed(planet.amplitude),
                "amplitude_uas",
                if_known(search.unit.in_uas(), std::vector{planet.amplitude[0] * factor, planet.amplitude[1] * factor,
                                                           planet.amplitude[2] * factor}),
                "mass_a_earth", listed_if(search.knows_mass(0), planet.mass_a), "mass_b_earth",
                listed_if(search.knows_mass(1), planet.mass_b), "best", five(planet.best), "best_error",
                five(planet.best_error), "correlation", correlation, "power_left", planet.power_left, "at_edge",
                (planet.flags & TOLIMAN_PLANET_AT_EDGE) != 0);
}

Json PlanetReport::limit_json(const toliman_planet_limit &limit) const {
    return Json("period", limit.period, "upper", limit.upper, "detectable", limit.detectable, "upper_mass_a",
                limit.upper_mass_a, "upper_mass_b", limit.upper_mass_b, "detectable_mass_a", limit.detectable_mass_a,
                "detectable_mass_b", limit.detectable_mass_b);
}

Json PlanetReport::json() const {
    const toliman_planet_info &info = search.info;
    const toliman_planet_options &how = search.options;
    const auto positive = [](double value) { return if_known(value > 0, value); };
    std::vector<size_t> indices(search.candidates.size());
    for (size_t i = 0; i < indices.size(); i++)
        indices[i] = i;
    Json json(
        "schema", "toliman-planet/1", "n", series.t.size(), "time_scale", text_or_null(series.time_scale), "kind",
        search.unit.is_velocity ? "velocity" : "separation", "unit", text_or_null(search.unit.name), "unit_arcsec",
        if_known(search.unit.in_uas(), search.unit.factor), "parallax_mas", positive(how.parallax_arcsec * 1000),
        "star_masses", std::vector{positive(how.star_mass[0]), positive(how.star_mass[1])}, "functions", info.functions,
        "threshold", how.threshold, "prior",
        Json("period_min", info.period_min, "period_max", info.period_max, "amplitude_min", info.amplitude_min,
             "amplitude_max", info.amplitude_max),
        "planets", info.planets, "candidates", array_of(indices, [this](size_t index) { return planet_json(index); }),
        "time_reference", info.time_reference, "rms", info.rms, "chi_square", info.chi_square, "jitter",
        listed_if((how.flags & TOLIMAN_PLANET_JITTER) != 0, info.jitter), "axis",
        if_known(!std::isnan(info.axis_deg), Json("position_angle_deg", info.axis_deg, "turn_deg", info.axis_turn_deg)),
        "detection_fap", how.detection_fap);
    if (!limits.empty())
        json.set("limits", Json("probability", kLimitProbability, "periods",
                                array_of(limits, [this](const auto &limit) { return limit_json(limit); })));
    if (map)
        json.set("map", map->json());
    if (reduced)
        json.set("reduction", reduced->json);
    return json;
}

} // namespace cli
