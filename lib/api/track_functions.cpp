#include "api/track_functions.hpp"

#include "base/error.hpp"

namespace toliman::api {

namespace {

void set_trend(const toliman_track_options &options, period::Grid &grid) {
    constexpr double kStepsPerSpan = 0.1; // df times the span, of toliman_period_suggest
    const bool is_given = options.trend_start != 0 || options.trend_end != 0;
    grid.basis.trend = options.trend;
    grid.basis.start = options.trend_start;
    grid.basis.end = is_given ? options.trend_end : kStepsPerSpan / grid.df;
}

// In px, so that another plate scale changes them.
void set_priors(track::Setup &setup) {
    size_t f = setup.grid.basis.first_column();
    for (const double sigma : setup.errors.sigmas)
        if (sigma > 0)
            setup.grid.basis.precision[f++] = prior_precision(sigma, setup.reference.scale_arcsec);
}

void set_columns(const SkySource &sky, track::Setup &setup) {
    period::Basis &basis = setup.grid.basis;
    for (const sky::Column &column : sky.error_columns(setup.errors.scale_sigma)) {
        basis.bound[static_cast<size_t>(basis.columns++)] = column.bound;
        setup.errors.sigmas[column.element] = column.sigma;
    }
    set_priors(setup);
}

void keep(const track::Setup &known, track::Setup &setup) {
    setup.grid.basis = known.grid.basis;
    setup.errors.sigmas = known.errors.sigmas;
    set_priors(setup);
}

} // namespace

void check_functions(const toliman_track_options &options) {
    if (options.trend < -1 || options.trend >= static_cast<int32_t>(period::kMaxFunctions))
        fail(Status::argument, "{options->trend} = %d: must be in [-1, %zu]", options.trend, period::kMaxFunctions - 1);
    if (options.trend <= 0 && (options.trend_start != 0 || options.trend_end != 0))
        fail(Status::argument, "{options->trend_start} = %g, trend_end = %g: must be 0 without a trend",
             options.trend_start, options.trend_end);
    if (!(options.scale_sigma >= 0 && options.scale_sigma < 1))
        fail(Status::argument, "{options->scale_sigma} = %g: must be in [0, 1)", options.scale_sigma);
}

void set_functions(const toliman_track_options &options, const KnownSetup &known, const SkySource &sky,
                   track::Setup &setup) {
    const bool is_new = !known || (options.flags & TOLIMAN_TRACK_REBUILD) != 0;
    setup.errors.scale_sigma = options.scale_sigma != 0 ? options.scale_sigma : known ? known->errors.scale_sigma : 0;
    setup.grid.basis = {};
    if (options.trend > 0)
        set_trend(options, setup.grid);
    else if (options.trend == 0 && options.sky != nullptr && is_new && !setup.grid.fixed_mean)
        set_columns(sky, setup);
    else if (options.trend == 0 && known && !setup.grid.fixed_mean)
        keep(*known, setup);
    setup.grid.check();
}

void show_functions(const period::Basis &basis, const track::OrbitErrors &errors, bool is_reduced,
                    toliman_track_options &options) {
    options.trend = basis.trend > 0 ? basis.trend : is_reduced && basis.columns == 0 ? -1 : 0;
    options.trend_start = basis.start;
    options.trend_end = basis.end;
    options.scale_sigma = errors.scale_sigma;
}

} // namespace toliman::api
