// include/toliman/sky.h
#include <toliman/sky.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/measure_handle.hpp"
#include "api/sky_handle.hpp"
#include "api/sky_measurements.hpp"
#include "api/times.hpp"
#include "backend/file.hpp"
#include "base/progress.hpp"
#include "ingest/nanoseconds.hpp"
#include "measure/orbit.hpp"
#include "measure/reduction.hpp"
#include "scene/system.hpp"
#include "sky/columns.hpp"
#include "sky/reduction.hpp"
#include "sky/refit.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

static_assert(sky::kElements == TOLIMAN_SKY_ELEMENTS);
static_assert(sky::kEarthAberration == TOLIMAN_SKY_EARTH_ABERRATION &&
              sky::kSpacecraftAberration == TOLIMAN_SKY_SPACECRAFT_ABERRATION &&
              sky::kParallax == TOLIMAN_SKY_PARALLAX && sky::kRoemer == TOLIMAN_SKY_ROEMER &&
              sky::kLightTime == TOLIMAN_SKY_LIGHT_TIME && sky::kRadialMotion == TOLIMAN_SKY_RADIAL_MOTION &&
              sky::kTransverseMotion == TOLIMAN_SKY_TRANSVERSE_MOTION && sky::kDeflection == TOLIMAN_SKY_DEFLECTION);

constexpr Choice<sky::Observer::Kind> kObservers = {TOLIMAN_SKY_OBSERVER_EARTH, TOLIMAN_SKY_OBSERVER_FILE,
                                                    "TOLIMAN_SKY_OBSERVER_..."};

sky::Observer observer_of(const toliman_sky_options &options) {
    if (options.observer != nullptr && options.altitude_km != 0)
        fail(Status::argument, "{options->altitude_km} = %g: must be 0 with observer", options.altitude_km);
    if (options.node_hours != 0 && options.altitude_km == 0)
        fail(Status::argument, "{options->node_hours} = %g: needs altitude_km", options.node_hours);
    const ingest::LeapSeconds leap_seconds =
        leap_seconds_of(options.leap_seconds, options.leap_second_count, "options->leap_seconds");
    if (options.observer != nullptr)
        return sky::Observer(std::make_shared<const sky::Ephemeris>(
            sky::read_ephemeris(options.observer, leap_seconds, {options.log, options.log_data})));
    if (options.altitude_km == 0)
        return {};
    sky::CircularOrbit orbit;
    orbit.altitude_km = options.altitude_km;
    if (options.node_hours != 0)
        orbit.node_hours = options.node_hours;
    return sky::Observer(orbit);
}

// The orbit and the observer of a scene.
std::unique_ptr<const sky::Predictor> predictor_of_scene(const toliman_sky_options &options) {
    const Use scene(options.scene, "options->scene");
    if (options.observer != nullptr || options.altitude_km != 0 || options.node_hours != 0)
        fail(Status::argument, "{options->observer}, altitude_km, node_hours: must not be given with scene");
    const std::shared_ptr<const sky::Predictor> &sky = scene->simulator.scene().binary.sky;
    if (!sky)
        fail(Status::unsupported, "{options->scene}: its binary has no observer");
    return std::make_unique<const sky::Predictor>(sky->system(), sky->observer(), options.without);
}

std::unique_ptr<const sky::Predictor> predictor_of(const char *system, const toliman_sky_options &options) {
    if (system == nullptr && options.scene != nullptr)
        return predictor_of_scene(options);
    required(system, "system");
    if (options.scene != nullptr)
        fail(Status::argument, "{options->scene}: must be NULL with a system");
    return std::make_unique<const sky::Predictor>(named_system(system), observer_of(options), options.without);
}

toliman_sky_prediction public_prediction(const sky::Prediction &prediction) noexcept {
    toliman_sky_prediction out = {};
    TOLIMAN_COPY(out, prediction, separation_arcsec, position_angle_deg, geometric_arcsec, geometric_angle_deg, factor);
    TOLIMAN_COPY(out, prediction, barycentric_offset_s, approach_m_s, sun_angle_deg);
    std::copy(std::begin(prediction.partials), std::end(prediction.partials), out.partials);
    return out;
}

std::unique_ptr<toliman_sky> new_sky(std::unique_ptr<const sky::Predictor> predictor) {
    auto handle = std::make_unique<toliman_sky>();
    handle->predictor = std::move(predictor);
    handle->orbit = measure::orbit_of;
    return handle;
}

void set_orbit(const sky::Observer &observer, toliman_sky_info &info) {
    const sky::OrbitShape shape = observer.shape();
    TOLIMAN_COPY(info, shape, inclination_deg, node_deg, node_hours);
    info.orbit_minutes = shape.period_minutes;
    std::copy_n(shape.altitude_km, 2, info.altitude_km);
    if (observer.ephemeris() == nullptr)
        return;
    const std::vector<sky::Segment> &segments = observer.ephemeris()->segments();
    info.segments = static_cast<int32_t>(segments.size());
    info.first_ns = segments.front().first_ns;
    info.last_ns = segments.back().last_ns;
    for (const sky::Segment &segment : segments)
        info.states += segment.states.size();
}

size_t known_element(int32_t element) {
    const auto known = static_cast<size_t>(int64_t{element} - TOLIMAN_SKY_ELEMENT_PERIOD);
    if (known >= sky::kElements)
        fail(Status::range, "{element} = %d: must be a constant TOLIMAN_SKY_ELEMENT_...", element);
    return known;
}

} // namespace

extern "C" {

toliman_status toliman_sky_create(const char *system, const toliman_sky_options *options, toliman_sky **out) noexcept {
    return guard([&] {
        toliman_sky *&made = required(out, "out");
        const toliman_sky_options known = accept(options, "options");
        auto handle = new_sky(predictor_of(system, known));
        if (handle->predictor->observer().kind() == sky::Observer::Kind::earth &&
            (known.without & sky::kSpacecraftAberration) == 0)
            sky::warn_of_centre(*handle->predictor, {known.log, known.log_data});
        made = handle.release();
    });
}

void toliman_sky_destroy(toliman_sky *sky) noexcept {
    destroy(sky);
}

toliman_status toliman_sky_predict(const toliman_sky *sky, const int64_t *tai_ns, size_t count,
                                   toliman_sky_prediction *predictions) noexcept {
    return call(sky, "sky", [&](auto &self) {
        required_array(tai_ns, count, sizeof *tai_ns, "tai_ns");
        if (count == 0)
            return;
        const StructArray<toliman_sky_prediction> rows(predictions, "predictions");
        required_array(predictions, count, rows.size(), "predictions");
        std::vector<sky::Prediction> found(count);
        for (size_t i = 0; i < count; i++)
            found[i] = self.predictor->at(tai_ns[i]);
        ingest::check_nanoseconds("tai_ns", tai_ns, count);
        for (size_t i = 0; i < count; i++)
            rows.put(i, public_prediction(found[i]));
    });
}

toliman_status toliman_sky_predict_mean(const toliman_sky *sky, const int64_t *intervals, const size_t *interval_counts,
                                        size_t count, toliman_sky_prediction *predictions) noexcept {
    return call(sky, "sky", [&](auto &self) {
        const std::vector<sky::Exposure> exposures = exposures_of(intervals, interval_counts, count);
        if (count == 0)
            return;
        const StructArray<toliman_sky_prediction> rows(predictions, "predictions");
        required_array(predictions, count, rows.size(), "predictions");
        std::vector<sky::Prediction> found;
        for (size_t i = 0; i < count; i++) {
            try {
                found.push_back(sky::reduce(*self.predictor, exposures[i], NAN).seen);
            } catch (const Error &error) {
                if (count == 1)
                    throw;
                fail_within(error, error.status(), "exposure %zu: %s", i, error.what());
            }
        }
        check_exposures(exposures);
        for (size_t i = 0; i < count; i++)
            rows.put(i, public_prediction(found[i]));
    });
}

toliman_status toliman_sky_reduce(const toliman_sky *sky, const toliman_measure *measured,
                                  const toliman_sky_reduce_options *options, toliman_measure **out) noexcept {
    return call(sky, "sky", [&](auto &self) {
        const Use series(measured, "measured");
        toliman_measure *&made = required(out, "out");
        const auto known = accept(options, "options");
        measure::Reduction reduction =
            measure::reduce(series->series, *self.predictor, known_scale_sigma(known.scale_sigma), known.flags == 0);
        if (!reduction.warning.empty())
            Log{known.log, known.log_data}.warn("%s", reduction.warning.c_str());
        made = new toliman_measure{{}, std::move(reduction.series)};
    });
}

toliman_status toliman_sky_get_info(const toliman_sky *sky, toliman_sky_info *out) noexcept {
    return query(sky, "sky", out, [&](auto &self, auto &info) {
        const sky::Predictor &predictor = *self.predictor;
        info.without = predictor.without();
        info.observer = kObservers.to_constant(predictor.observer().kind());
        info.orbit_digest = sky::digest_of(predictor.system().value.orbit);
        info.parallax_arcsec = predictor.system().value.barycentre.parallax_mas / 1000;
        info.star_mass[0] = predictor.system().value.masses.a_sun;
        info.star_mass[1] = predictor.system().value.masses.b_sun;
        set_orbit(predictor.observer(), info);
        put_text(predictor.system().name, info.name);
    });
}

toliman_status toliman_sky_refit(const toliman_sky *sky, const toliman_measure *measured, double scale_sigma,
                                 toliman_sky_refit_result *result, toliman_sky **out) noexcept {
    return call(sky, "sky", [&](auto &self) {
        const Use series(measured, "measured");
        toliman_sky *&made = required(out, "out");
        const double sigma = known_scale_sigma(scale_sigma);
        const std::vector<sky::Measurement> all = measure::measurements_of(series->series),
                                            known = measure::covered(*self.predictor, all);
        const sky::Refit found = sky::refit(*self.predictor, known, sigma);
        auto handle = new_sky(std::make_unique<const sky::Predictor>(found.system, *self.predictor));
        toliman_sky_refit_result filled = {};
        filled.iterations = found.iterations;
        set_goodness(found.goodness, filled);
        TOLIMAN_COPY(filled, found, jitter_arcsec, outliers);
        filled.left_out = static_cast<uint32_t>(all.size() - known.size());
        const bool is_unusable =
            found.goodness.verdict == GoodnessVerdict::poor && found.goodness.chi_square > kMostSeriesChiSquare;
        filled.flags = is_unusable ? TOLIMAN_SKY_UNUSABLE : 0;
        TOLIMAN_COPY(filled, found, rms_arcsec, scale, scale_sigma);
        std::copy_n(found.covariance[0], sky::kElements * sky::kElements, filled.covariance);
        deliver(filled, result, "result");
        made = handle.release();
    });
}

toliman_status toliman_sky_set_columns(const toliman_sky *sky, double unit_arcsec, double scale_sigma,
                                       toliman_period_options *options, int32_t *elements) noexcept {
    return call(sky, "sky", [&](auto &self) {
        required(options, "options");
        required_array(elements, sky::kElements, sizeof *elements, "elements");
        if (!(unit_arcsec > 0 && std::isfinite(unit_arcsec)))
            fail(Status::argument, "{unit_arcsec} = %g: must be above 0 and finite", unit_arcsec);
        const std::vector<sky::Column> columns =
            sky::error_columns(self.predictor->system(), known_scale_sigma(scale_sigma));
        accept(options, "options");
        toliman_period_options changed = copied(options, "options");
        std::fill_n(elements, sky::kElements, -1);
        changed.columns = static_cast<int32_t>(columns.size());
        for (size_t c = 0; c < columns.size(); c++) {
            elements[c] = static_cast<int32_t>(columns[c].element);
            changed.column_bound[c] = columns[c].bound;
            const double sigma = columns[c].sigma / unit_arcsec;
            changed.prior_precision[1 + static_cast<size_t>(changed.trend) + c] = 1 / (sigma * sigma);
        }
        deliver(changed, options, "options");
    });
}

toliman_status toliman_sky_save_file(const toliman_sky *sky, const char *path) noexcept {
    return call(sky, "sky", [&](auto &self) {
        required(path, "path");
        const std::string text = system_json(self.predictor->system());
        file::replace(path, text.data(), text.size());
    });
}

toliman_status toliman_sky_get_element(const toliman_sky *sky, int32_t element, double *value, double *sigma) noexcept {
    return call(sky, "sky", [&](auto &self) {
        const size_t known = known_element(element);
        const sky::System &system = self.predictor->system();
        if (value != nullptr)
            *value = system.value.orbit.*sky::kElementOf[known];
        if (sigma != nullptr)
            *sigma = system.sigma.orbit.*sky::kElementOf[known];
    });
}
}
