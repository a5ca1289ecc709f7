#include "api/track_functions.hpp"

#include "base/error.hpp"

namespace toliman::api {

namespace {

void set_trend(const toliman_track_options &options, period::Grid &grid) {
    const bool is_given = options.grid.trend_start != 0 || options.grid.trend_end != 0;
    const double mission = 0.1 / grid.df; // of toliman_period_suggest
    grid.basis.trend = options.grid.trend;
    grid.basis.start = is_given ? options.grid.trend_start : -mission / 2;
    grid.basis.end = is_given ? options.grid.trend_end : 1.5 * mission;
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
    if (options.grid.trend < -1 || options.grid.trend > period::kMaxTrend)
        fail(Status::argument, "{options->grid.trend} = %d: must be in [-1, %d]", options.grid.trend,
             period::kMaxTrend);
    if (options.grid.trend <= 0 && (options.grid.trend_start != 0 || options.grid.trend_end != 0))
        fail(Status::argument, "{options->grid.trend_start} = %g, trend_end = %g: must be 0 without a trend",
             options.grid.trend_start, options.grid.trend_end);
    if (!(options.reduction.scale_sigma >= 0 && options.reduction.scale_sigma < 1))
        fail(Status::argument, "{options->reduction.scale_sigma} = %g: must be in [0, 1)",
             options.reduction.scale_sigma);
}

void set_functions(const toliman_track_options &options, const KnownSetup &known, const SkySource &sky,
                   track::Setup &setup) {
    const bool is_new = !known || (options.flags & TOLIMAN_TRACK_REBUILD) != 0;
    const bool has_errors = options.grid.trend == 0 && !setup.grid.fixed_mean;
    const bool has_new_errors = has_errors && options.reduction.sky != nullptr && is_new;
    const double of_folder = known ? known->errors.scale_sigma : 0;
    setup.errors.scale_sigma = options.reduction.scale_sigma != 0 ? options.reduction.scale_sigma : of_folder;
    if (!has_new_errors && setup.errors.scale_sigma != of_folder)
        fail(Status::argument,
             "{options->reduction.scale_sigma} = %g: needs sky, the errors of its orbit, and a new folder or "
             "a rebuild",
             options.reduction.scale_sigma);
    setup.grid.basis = {};
    if (options.grid.trend > 0)
        set_trend(options, setup.grid);
    else if (has_new_errors)
        set_columns(sky, setup);
    else if (has_errors && known)
        keep(*known, setup);
    setup.grid.check();
}

void show_functions(const period::Basis &basis, const track::OrbitErrors &errors, bool is_reduced,
                    toliman_track_options &options) {
    options.grid.trend = basis.trend > 0 ? basis.trend : is_reduced && basis.columns == 0 ? -1 : 0;
    options.grid.trend_start = basis.start;
    options.grid.trend_end = basis.end;
    options.reduction.scale_sigma = errors.scale_sigma;
}

} // namespace toliman::api
