#include "series/orbit_functions.hpp"

#include "common/failure.hpp"

namespace cli {

namespace {

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

} // namespace

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

} // namespace cli
