// include/toliman/planet.h
#include <mutex>

#include <toliman/planet.h>

#include "api/common.hpp"
#include "api/instruments.hpp"
#include "api/measure_handle.hpp"
#include "base/constants.hpp"
#include "base/hash.hpp"
#include "measure/planets.hpp"
#include "planet/limits.hpp"
#include "planet/summary.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_planet : Handle<toliman_planet> {
    static constexpr char kType[] = "toliman_planet";
    toliman_planet(const planet::GivenSeries &given, const planet::GivenVelocities &velocities,
                   const planet::Settings &settings, std::vector<std::string> names_of, uint64_t digest_of)
        : result(given, velocities, settings), names(std::move(names_of)), digest(digest_of) {}

    const planet::Result result;
    const std::vector<std::string> names; // of the instruments
    const uint64_t digest;                // of all series

    const planet::Recovery &recovery() const noexcept { return recovery_; }

  private:
    planet::Detection detection_{*result.rest, *result.design, result.settings.fap};
    planet::Recovery recovery_{detection_, result.settings.threshold};
};

namespace {

constexpr uint32_t kMostInjections = 1'000'000;

static_assert(planet::kReasonOdds == TOLIMAN_PLANET_REASON_ODDS &&
                  planet::kReasonSamples == TOLIMAN_PLANET_REASON_SAMPLES &&
                  planet::kReasonEvidence == TOLIMAN_PLANET_REASON_EVIDENCE,
              "the reasons of lib/planet are those of planet.h");
static_assert(planet::kColumns == TOLIMAN_PLANET_COLUMNS);

void check_pair(const char *least_name, double least, const char *most_name, double most) {
    if ((least == 0) != (most == 0))
        fail(Status::argument, "{options->%s} = %g and %s = %g: give both or none", least_name, least, most_name, most);
}

planet::Settings settings_of(const toliman_planet_options &options, const measure::Series &series) {
    const toliman_planet_prior &prior = options.prior;
    planet::Settings settings;
    settings.most = options.max_planets;
    settings.threads = options.threads;
    settings.jitter = (options.flags & TOLIMAN_PLANET_NO_JITTER) == 0;
    settings.clip = (options.flags & TOLIMAN_PLANET_CLIP) != 0;
    const auto chosen = [](double given, double known) { return given != 0 ? given : known; };
    settings.units = {
        series.kind == measure::Kind::velocity,
        series.time_unit_days,
        series.unit,
        chosen(options.parallax_arcsec, series.parallax_arcsec),
        {chosen(options.star_mass[0], series.star_mass[0]), chosen(options.star_mass[1], series.star_mass[1])}};
    TOLIMAN_COPY(settings, prior, period_min, period_max, eccentricity_max, amplitude_min, amplitude_max);
    check_pair("prior.amplitude_min", prior.amplitude_min, "amplitude_max", prior.amplitude_max);
    settings.jitter_max = prior.jitter_max;
    if (prior.jitter_max != 0 && !settings.jitter)
        fail(Status::argument, "{options->prior.jitter_max} = %g: must be 0 with TOLIMAN_PLANET_NO_JITTER",
             prior.jitter_max);
    if (settings.units.velocity && options.parallax_arcsec != 0)
        fail(Status::argument, "{options->parallax_arcsec} = %g: must be 0 for velocities", options.parallax_arcsec);
    if (settings.units.velocity && options.star_mass[1] != 0)
        fail(Status::argument, "{options->star_mass[1]} = %g: must be 0 for velocities, of one star",
             options.star_mass[1]);
    TOLIMAN_COPY(settings, options, threshold, samples, seed);
    settings.fap = options.detection_fap;
    settings.progress = {options.progress, options.progress_data};
    return settings;
}

void add_velocities(const measure::Series &series, const planet::Units &units, const toliman_measure *handle,
                    size_t star, const char *name, planet::GivenVelocities &velocities, std::vector<std::string> &names,
                    uint64_t &digest) {
    if (handle == nullptr)
        return;
    const Use use(handle, name);
    measure::add_velocities(series, units, use->series, star, name, velocities);
    measure::add_names(use->series, names);
    digest = measure::digest_of(use->series, digest);
}

const planet::Candidate &candidate_of(const planet::Result &result, int64_t index) {
    return result.candidates[required_index(index, result.candidates.size(), "index")];
}

toliman_planet_candidate public_planet(const planet::Result &result, int64_t index) {
    const planet::Candidate &candidate = candidate_of(result, index);
    const planet::Summary summary = planet::summary_of(result, candidate);
    toliman_planet_candidate out = {};
    out.flags = candidate.at_edge ? TOLIMAN_PLANET_AT_EDGE : 0;
    TOLIMAN_COPY(out, candidate, reasons, log10_bayes, log10_bayes_error, log10_fap, log10_fap_orbit);
    double *const intervals[planet::kColumns] = {out.period,          out.eccentricity, out.periastron_deg, out.epoch,
                                                 out.amplitude,       out.mass_a,       out.mass_b,         nullptr,
                                                 out.inclination_deg, out.node_deg};
    for (size_t i = 0; i < planet::kColumns; i++)
        if (intervals[i] != nullptr)
            std::copy(summary.intervals[i].begin(), summary.intervals[i].end(), intervals[i]);
    const bool has_velocities = result.series.has_velocities();
    out.star = has_velocities ? candidate.fitted.planet.orbit.star : -1;
    out.log10_star = has_velocities ? candidate.log10_star : NAN;
    std::copy(candidate.best.begin(), candidate.best.end(), out.best);
    out.best[3] += result.series.time_reference;
    std::copy(candidate.best_error.begin(), candidate.best_error.end(), out.best_error);
    std::copy(summary.correlation.begin(), summary.correlation.end(), out.correlation);
    out.power_left = candidate.power_left;
    return out;
}

} // namespace

extern "C" {

toliman_status toliman_planet_create(const toliman_measure *series, const toliman_planet_options *options,
                                     toliman_planet **out) noexcept {
    return call(series, "series", [&](auto &self) {
        required(out, "out");
        const measure::Series &own = self.series;
        const toliman_planet_options known = accept(options, "options");
        const planet::Settings settings = settings_of(known, own);
        measure::check_reduced(own);
        if (own.is_refitted)
            fail(Status::argument, "{series}: is reduced to an orbit that was refitted to measurements of these dates: "
                                   "reduce it to the orbit before the refit");
        if (own.sigma.empty() && !settings.jitter)
            fail(Status::argument, "{series}: has no sigma: must have one with TOLIMAN_PLANET_NO_JITTER");
        planet::GivenVelocities velocities;
        std::vector<std::string> names;
        measure::add_names(own, names);
        uint64_t digest = measure::digest_of(own, kFnvOffset);
        add_velocities(own, settings.units, known.velocity_a, 0, "options->velocity_a", velocities, names, digest);
        add_velocities(own, settings.units, known.velocity_b, 1, "options->velocity_b", velocities, names, digest);
        *out = new toliman_planet(measure::given_of(own, "series"), velocities, settings, std::move(names), digest);
    });
}

void toliman_planet_destroy(toliman_planet *planets) noexcept {
    destroy(planets);
}

toliman_status toliman_planet_get_info(const toliman_planet *planets, toliman_planet_info *out) noexcept {
    return query(planets, "planets", out, [&](auto &self, auto &info) {
        const planet::Result &result = self.result;
        const planet::Series &series = result.series;
        const auto is_planet = [](const planet::Candidate &candidate) { return candidate.is_planet(); };
        info.planets =
            static_cast<uint32_t>(std::count_if(result.candidates.begin(), result.candidates.end(), is_planet));
        info.candidates = static_cast<uint32_t>(result.candidates.size());
        info.functions = static_cast<uint32_t>(series.functions.size());
        info.rms = planet::rms_of(series, *result.design);
        set_goodness(result.goodness, info);
        info.chi_square_with_jitter = result.chi_square_with_jitter;
        info.outliers = static_cast<uint32_t>(result.outliers.size());
        const planet::Interval jitter = planet::jitter_of_series(result);
        std::copy(jitter.begin(), jitter.end(), info.jitter);
        info.time_reference = series.time_reference;
        info.axis_deg = series.axis_cosine.empty() ? NAN : series.axis / kDegree;
        info.axis_turn_deg = series.turn / kDegree;
        info.series_digest = self.digest;
        TOLIMAN_COPY(info, result.settings, period_min, period_max, amplitude_min, amplitude_max);
    });
}

toliman_status toliman_planet_get_candidate(const toliman_planet *planets, int64_t index,
                                            toliman_planet_candidate *out) noexcept {
    return query(planets, "planets", out,
                 [&](auto &self, auto &planet) { planet = public_planet(self.result, index); });
}

toliman_status toliman_planet_get_samples(const toliman_planet *planets, int64_t index, size_t count,
                                          double *samples) noexcept {
    return call(planets, "planets", [&](auto &self) {
        const planet::Candidate &candidate = candidate_of(self.result, index);
        if (count > candidate.samples.size())
            fail(Status::argument, "{count} = %zu: must be at most %zu", count, candidate.samples.size());
        required_array(samples, count, sizeof(planet::Row), "samples");
        for (size_t i = 0; i < count; i++) {
            const planet::Row row = planet::row_of(self.result, candidate, candidate.samples[i]);
            std::copy(row.begin(), row.end(), samples + i * row.size());
        }
    });
}

toliman_status toliman_planet_get_signal(const toliman_planet *planets, int64_t index, const double *t,
                                         const double *position_angle_deg, size_t n, double *signal) noexcept {
    return call(planets, "planets", [&](auto &self) {
        const planet::Series &series = self.result.series;
        const planet::Candidate &candidate = candidate_of(self.result, index);
        required_array(t, n, sizeof *t, "t");
        required_array(signal, n, sizeof *signal, "signal");
        if (position_angle_deg != nullptr && series.axis_cosine.empty())
            fail(Status::argument, "{position_angle_deg}: must be NULL, as the series has no position angles");
        for (size_t i = 0; i < n; i++) {
            if (!(std::fabs(t[i]) <= 1e100))
                fail(Status::argument, "{t}[%zu] = %g: must be finite and at most 1e100", i, t[i]);
            if (position_angle_deg != nullptr && !std::isfinite(position_angle_deg[i]))
                fail(Status::argument, "{position_angle_deg}[%zu] = %g: must be finite", i, position_angle_deg[i]);
        }
        const Buffer<double> values = planet::signal_at(series, candidate.fitted.planet, t, position_angle_deg, n);
        std::copy(values.begin(), values.end(), signal);
    });
}

toliman_status toliman_planet_get_residuals(const toliman_planet *planets, size_t n, double *residuals) noexcept {
    return call(planets, "planets", [&](auto &self) {
        const Buffer<double> &values = self.result.residuals;
        check_count("n", n, values.size(), "the number of measurements");
        required_array(residuals, n, sizeof *residuals, "residuals");
        std::copy(values.begin(), values.end(), residuals);
    });
}

toliman_status toliman_planet_get_outliers(const toliman_planet *planets, size_t count, int64_t *indices) noexcept {
    return call(planets, "planets", [&](auto &self) {
        const std::vector<size_t> &outliers = self.result.outliers;
        check_count("count", count, outliers.size(), "the number of samples that do not belong");
        required_array(indices, count, sizeof *indices, "indices");
        std::copy(outliers.begin(), outliers.end(), indices);
    });
}

toliman_status toliman_planet_get_instruments(const toliman_planet *planets, toliman_measure_instrument *instruments,
                                              size_t capacity, size_t *count) noexcept {
    return call(planets, "planets", [&](auto &self) {
        const planet::Result &result = self.result;
        const StructOutput<toliman_measure_instrument> out(instruments, "instruments", capacity, count);
        write_instruments(planet::instruments_of(result.series, *result.design, planet::jitters_of(result)), self.names,
                          out);
    });
}

toliman_status toliman_planet_get_limits(const toliman_planet *planets, const double *periods, size_t count,
                                         double probability, toliman_planet_limit *limits) noexcept {
    return call(planets, "planets", [&](auto &self) {
        required_array(periods, count, sizeof *periods, "periods");
        if (!(probability > 0 && probability < 1))
            fail(Status::argument, "{probability} = %g: must be in (0, 1)", probability);
        if (count == 0)
            return;
        const StructArray<toliman_planet_limit> out(limits, "limits");
        const std::vector<planet::Limit> found =
            planet::limits_of(self.result, self.recovery(), {periods, periods + count}, probability);
        for (size_t i = 0; i < count; i++) {
            toliman_planet_limit limit = {};
            TOLIMAN_COPY(limit, found[i], period, upper, detectable);
            TOLIMAN_COPY(limit, found[i], upper_mass_a, upper_mass_b, detectable_mass_a, detectable_mass_b);
            out.put(i, limit);
        }
    });
}

toliman_status toliman_planet_inject(const toliman_planet *planets, const toliman_planet_cell *cell,
                                     uint32_t *detected) noexcept {
    return guard([&] {
        required(detected, "detected");
        const Use use(planets, "planets");
        const auto known = copied(&required(cell, "cell"), "cell");
        if (known.is_circular != 0 && known.is_circular != 1)
            fail(Status::argument, "{cell->is_circular} = %d: must be 0 or 1", known.is_circular);
        if (known.count > kMostInjections)
            fail(Status::argument, "{cell->count} = %u: must be at most %u", known.count, kMostInjections);
        planet::InjectionCell injected = {};
        TOLIMAN_COPY(injected, known, star, period_min, period_max, size_min, size_max, is_circular, count, seed);
        in_struct("cell->", [&] { planet::check(use->result, injected); });
        *detected = static_cast<uint32_t>(use->recovery().inject(injected, use->result.settings.units));
    });
}

} // extern "C"
