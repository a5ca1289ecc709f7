// A missing grid, clock or function comes from the folder. If the folder has records but has lost its setup, they must
// be given: a guess would silently shift the times of all frames.
#include "track/request.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/words.hpp"
#include "track/ledger_file.hpp"
#include "track/misfit.hpp"

namespace toliman::track {

namespace {

using KnownSetup = std::optional<Setup>;

constexpr double kSigmasToLimit = 1e4, kReducedLimitPx = 0.25; // the latter: error of the reference orbit

// Completes one side of the geometry: frame = crop + image * bin; `own` is the side that the estimator requires, 0 any.
void complete(size_t &frame, size_t crop, size_t bin, size_t &image, size_t own, const char *name) {
    if (image == 0)
        image = own > 0 ? own : (frame > crop ? (frame - crop) / bin : 0);
    if (own > 0 && image != own)
        fail(Status::argument, "{options->frames.image_%s} = %zu: must be %zu, as the estimator requires", name, image,
             own);
    if (frame == 0)
        frame = crop + image * bin;
    if (image == 0)
        fail(Status::argument, "{options->frames.%s} = %zu, crop %zu, bin = %zu: leave no pixels for the estimator",
             name, frame, crop, bin);
}

bool has_ledger(const StateFolder &place) {
    return place.store && place.store->size(LedgerFile::kName) >= 0;
}

bool has_records(const StateFolder &place) {
    return has_ledger(place) && LedgerFile(*place.store).has_records();
}

// The setup of the folder; else that of setup_folder, for a new folder.
KnownSetup known_setup(const Request &request, const StateFolder &place, const Terms &terms) {
    if (place.setup || request.setup_folder == nullptr || has_records(place))
        return place.setup;
    KnownSetup other = load_setup(*open_folder(request.setup_folder, Access::read));
    if (!other)
        fail(Status::format, "{%s}: its setup.tlms is missing or damaged", request.setup_folder);
    if (for_terms(other->grid, terms).digest() != other->grid.digest())
        fail(Status::mismatch, "{%s}: has other terms, such as sigma or value_limit", request.setup_folder);
    return other;
}

void set_grid_and_clock(const Request &request, const KnownSetup &known, const StateFolder &place, Setup &setup) {
    const bool use_known = known && (has_ledger(place) || !place.setup || !request.grid);
    const std::string path = place.store ? place.store->path(Setup::kName) : "";
    if (!request.grid && !use_known && place.store)
        fail(Status::argument,
             "{options->grid.nf} = 0: must be at least 1: %s, which stores the grid, is missing or damaged",
             path.c_str());
    if (!request.grid && !use_known)
        fail(Status::argument, "{options->grid.nf} = 0: must be at least 1");
    if (!request.clock && !use_known && has_records(place))
        fail(Status::argument,
             "{options->clock.pairs} is NULL: %s, which stores the clock, is missing or damaged: give the clock, or "
             "the pair (0, 0) if camera times are TAI",
             path.c_str());
    setup.grid = request.grid ? *request.grid : known->grid;
    if (request.clock)
        setup.clock = *request.clock;
    else if (use_known)
        setup.clock = known->clock;
}

Timing timing_of(const Request &request, const KnownSetup &known, const StateFolder &place) {
    if (!known && !request.stamp && has_records(place))
        fail(Status::argument,
             "{options->frames.stamp} = 0: must be TOLIMAN_FRAME_STAMP_...: %s, which stores the stamp, is missing or "
             "damaged",
             place.store->path(Setup::kName).c_str());
    const Timing otherwise = known ? known->timing : Timing();
    return {request.stamp.value_or(otherwise.stamp),
            request.exposure_s != 0 ? request.exposure_s : otherwise.exposure_s};
}

// The reference of the request, else that of the folder, which must be the same unless it is rebuilt.
Reference reference_of(const Request &request, const Source &source, const KnownSetup &known, const Orbit &orbit) {
    const Reference otherwise = known ? known->reference : Reference();
    if (!request.orbit && otherwise.is_given() && request.has_estimator)
        fail(Status::argument, "{options->reduction.sky} is NULL: must be the system of %s, whose frames are reduced",
             request.folder);
    if (!request.orbit && request.scale_arcsec != 0 && !otherwise.is_given())
        fail(Status::argument, "{options->reduction.plate_scale_arcsec} = %g: needs sky", request.scale_arcsec);
    const double scale = request.scale_arcsec != 0     ? request.scale_arcsec
                         : otherwise.scale_arcsec != 0 ? otherwise.scale_arcsec
                                                       : source.scale_arcsec;
    if (!request.orbit)
        return {otherwise.system, otherwise.is_given() ? scale : 0, otherwise.in_orbit};
    if (scale == 0)
        fail(Status::argument,
             "{options->reduction.plate_scale_arcsec} = 0: must be above 0 arcsec per px for this estimator");
    return {orbit.system, scale, orbit.in_orbit};
}

// In px, so that another plate scale changes them.
void set_priors(Setup &setup) {
    size_t f = setup.grid.basis.first_column();
    for (const double sigma : setup.errors.sigmas)
        if (sigma > 0) {
            const double own = sigma / setup.reference.scale_arcsec;
            setup.grid.basis.precision[f++] = 1 / (own * own);
        }
}

void set_trend(const Request &request, period::Grid &grid) {
    const bool is_given = request.trend_start != 0 || request.trend_end != 0;
    const double mission = 0.1 / grid.df; // of toliman_period_suggest
    grid.basis.trend = request.trend;
    grid.basis.start = is_given ? request.trend_start : -mission / 2;
    grid.basis.end = is_given ? request.trend_end : 1.5 * mission;
}

// Basis and errors of the orbit: those of the request, else those of the folder.
void set_functions(const Request &request, const KnownSetup &known, bool rebuild, const Orbit &orbit, Setup &setup) {
    const bool has_errors = request.trend == 0 && !setup.grid.fixed_mean;
    const bool has_new_errors = has_errors && request.orbit && (!known || rebuild);
    const double of_folder = known ? known->errors.scale_sigma : 0;
    setup.errors.scale_sigma = request.scale_sigma != 0 ? request.scale_sigma : of_folder;
    if (!has_new_errors && setup.errors.scale_sigma != of_folder)
        fail(Status::argument,
             "{options->reduction.scale_sigma} = %g: needs sky, the errors of its orbit, and a new folder or "
             "a rebuild",
             request.scale_sigma);
    setup.grid.basis = {};
    if (request.trend > 0) {
        set_trend(request, setup.grid);
    } else if (has_new_errors) {
        orbit.add_errors(setup.errors.scale_sigma, setup.grid.basis, setup.errors);
        set_priors(setup);
    } else if (has_errors && known) {
        setup.grid.basis = known->grid.basis;
        setup.errors.sigmas = known->errors.sigmas;
        set_priors(setup);
    }
    in_struct("options->grid.", [&] { setup.grid.check(); });
}

double chi_limit_of(const Request &request, const KnownSetup &known, const ModelVerdict &model) {
    if (request.chi_limit != 0)
        return request.chi_limit == kLimitOfMedian ? 0 : request.chi_limit;
    return known ? known->chi_limit : model.is_calibrated ? kCalibratedLimit : 0;
}

} // namespace

Terms completed(Terms terms, const Source &source, bool reduced) {
    Geometry &geometry = terms.geometry;
    complete(geometry.rows, geometry.crop_row, geometry.bin, geometry.out_rows, source.rows, "rows");
    complete(geometry.cols, geometry.crop_col, geometry.bin, geometry.out_cols, source.cols, "cols");
    terms.sigma = terms.sigma != 0 ? terms.sigma : source.sigma;
    if (terms.sigma == 0)
        fail(Status::argument, "{options->estimator.sigma} = 0: must be above 0 for this estimator");
    if (terms.value_limit == 0)
        terms.value_limit = std::max(kSigmasToLimit * terms.sigma, reduced ? kReducedLimitPx : 0);
    terms.estimator = source.digest;
    in_struct("options->frames.", [&] { terms.geometry.check(); });
    terms.check();
    return terms;
}

Columns columns_of(const std::string &values, const Source &source, bool reduced) {
    const std::vector<std::string> given = words_of(values);
    if (!given.empty() && given != words_of(source.values))
        fail(Status::argument, "{options->estimator.values} = \"%s\": must be \"%s\", the values of the estimator",
             values.c_str(), source.values.c_str());
    return Columns(source.values, reduced, source.parameters);
}

std::string parameters_in(const char *folder) {
    const std::unique_ptr<Store> store = open_folder(folder, Access::read);
    return store->size(LedgerFile::kName) >= 0 ? LedgerFile(*store).columns().parameters() : "";
}

Setup setup_of(const Request &request, const Source &source, const Terms &terms, const StateFolder &place,
               Orbit &orbit) {
    const KnownSetup known = known_setup(request, place, terms);
    Setup setup;
    set_grid_and_clock(request, known, place, setup);
    setup.timing = timing_of(request, known, place);
    if (request.orbit)
        orbit = request.orbit(known ? known->reference.system : "");
    setup.reference = reference_of(request, source, known, orbit);
    set_functions(request, known, place.rebuild, orbit, setup);
    setup.model = known && (has_records(place) || !source.estimate) ? known->model : source.model;
    setup.chi_limit = chi_limit_of(request, known, setup.model);
    return setup;
}

} // namespace toliman::track
