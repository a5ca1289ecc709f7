#include "series/orbit_functions.hpp"

#include <optional>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "series/diagnosis.hpp"

namespace cli {

namespace {

constexpr int32_t kOrbitTrend = 4; // leaves 0.06 uas of the errors of the orbit of alpha Centauri (median)

struct Declared {
    toliman_period_options options = toliman::sized<toliman_period_options>();
    int32_t elements[TOLIMAN_SKY_ELEMENTS] = {};
};

Declared declared(const toliman_sky *sky, double plate_scale, double scale_sigma) {
    Declared result;
    toliman::check(toliman_sky_set_columns(sky, plate_scale, scale_sigma, &result.options, result.elements));
    return result;
}

// A coefficient times the plate scale is the error of the element, in its unit.
NuisanceColumn column_of(const Measurements &measured, int32_t element, double bound, double plate_scale) {
    NuisanceColumn column = {toliman_sky_element_name(element), {}, bound, plate_scale};
    for (const toliman_sky_prediction &prediction : measured.predictions)
        column.values.push_back(prediction.partials[element]);
    return column;
}

// Empty without priors or sigmas; `why` then states the reason.
std::optional<Nuisance> orbit_functions(const Measurements &measured, const toliman_sky *sky, double plate_scale,
                                        double scale_sigma, std::string &why) {
    why = measured.reduced.sigma.empty()             ? "the series has no sigma"
          : declared(sky, 1, 0).options.columns == 0 ? "the system has no standard deviations of its elements"
                                                     : "";
    if (!why.empty())
        return std::nullopt;
    const Declared known = declared(sky, plate_scale, scale_sigma);
    Nuisance orbit;
    for (int32_t c = 0; c < known.options.columns; c++) {
        orbit.columns.push_back(column_of(measured, known.elements[c], known.options.column_bound[c], plate_scale));
        orbit.precision.push_back(known.options.prior_precision[1 + c]);
    }
    return orbit;
}

void set_functions(const Measurements &measured, const toliman_sky *sky, double plate_scale, double scale_sigma,
                   Nuisance &nuisance, Progress &progress) {
    std::string why;
    if (const std::optional<Nuisance> orbit = orbit_functions(measured, sky, plate_scale, scale_sigma, why)) {
        nuisance = *orbit;
        return;
    }
    nuisance.trend.order = kOrbitTrend;
    progress.warn(
        why + formatted(": a trend of order %d is fitted in place of the errors of the orbit (--trend)", kOrbitTrend));
}

} // namespace

ReductionNote reduce_to_orbit(const std::string &system, const ReductionOptions &reduction,
                              const NuisanceOptions &nuisance, bool with_functions, Series &series,
                              Progress &progress) {
    const auto sky = reduction.observer.predictor(system, 0, progress);
    const Measured given = measured_of(series, reduction);
    const Measurements measured = reduce(given, reduction, sky.get(), progress);
    series = measured.reduced;
    if (with_functions && !nuisance.given())
        set_functions(measured, sky.get(), given.plate_scale, nuisance.scale_sigma, series.nuisance, progress);
    Json json("system", system);
    reduction.set(json);
    json.set("unreduced", measured.unreduced, "diagnosis",
             diagnosis_of(measured, sky.get(), nuisance.scale_sigma, progress));
    return {json, system + " seen from: " + reduction.observer.text() +
                      formatted("; %zu samples left out", measured.unreduced)};
}

} // namespace cli
