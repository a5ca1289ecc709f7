#include "series/reduction.hpp"

#include <numeric>

#include "options/command.hpp"
#include "scenes/exposures.hpp"
#include "scenes/observer_options.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

const std::map<std::string, ValueUnit> &known_units() {
    static const std::map<std::string, ValueUnit> units = {{"", {}},
                                                           {"arcsec", {"arcsec", 1, false}},
                                                           {"mas", {"mas", 1e-3, false}},
                                                           {"uas", {"uas", 1e-6, false}},
                                                           {"deg", {"deg", 3600, false}},
                                                           {"px", {"px", 0, false}},
                                                           {"m/s", {"m/s", 1, true}},
                                                           {"km/s", {"km/s", 1000, true}},
                                                           {"cm/s", {"cm/s", 1e-2, true}}};
    return units;
}

// The unit that the file states, if it has a factor.
std::string stated_unit(const toliman_measure *series) {
    const std::string name = info_of(series).unit_name;
    return known_units().count(name) > 0 ? name : "";
}

constexpr double kLongestExposure = 400 * 86400.0;         // s, of the library's predictions
constexpr double kSharedTime = 0.05;                       // of two exposures, that inaccurate times may have
constexpr double kSecondsPerDay = 86400, kShortest = 1e-3; // s
constexpr double kFarScale = 0.01; // relative difference of measured and predicted separations that is reported

// Exposures of the samples; counts: on-target intervals of each; empty: one each, start and end of the exposure.
struct Exposures {
    std::vector<int64_t> intervals; // [sum of counts][2], start and end, TAI ns
    std::vector<size_t> counts;
};

std::vector<int64_t> tai_of(const toliman_measure *series) {
    const toliman_measure_info info = info_of(series);
    if (info.time_scale == 0)
        malformed(info.name, "times are plain numbers: must be dates, Modified Julian Days or Julian Days "
                             "(--time-format mjd or jd)");
    std::vector<int64_t> times(static_cast<size_t>(info.n));
    toliman::check(toliman_measure_get_times(series, times.data(), times.size()));
    return times;
}

// Those within the windows of --on-target, if it is given.
Exposures exposures_of(const toliman_measure *series, const ReductionOptions &options) {
    const std::vector<int64_t> middles = tai_of(series);
    const int64_t length = std::llround(options.exposure.value_or(0) * 1e9);
    const std::vector<TargetWindow> windows =
        options.on_target.empty() ? std::vector<TargetWindow>()
                                  : read_on_target(options.on_target, LeapSeconds(options.observer.leap_seconds()));
    Exposures exposures;
    for (const int64_t middle : middles) {
        std::vector<int64_t> parts = {middle - length / 2, middle - length / 2 + length};
        if (!options.on_target.empty()) {
            parts = parts_of(windows, parts[0], parts[1]);
            exposures.counts.push_back(parts.size() / 2);
        }
        exposures.intervals.insert(exposures.intervals.end(), parts.begin(), parts.end());
        if (parts.empty())
            malformed(name_of(series),
                      formatted("sample %zu: no window of --on-target %s is in its exposure of %g s",
                                exposures.counts.size(), options.on_target.c_str(), *options.exposure));
    }
    return exposures;
}

// An error of the library about the exposures or the values, with the option that would admit them.
[[noreturn]] void refuse(const toliman::error &error, const std::string &name, const ReductionOptions &options) {
    if (error.status() == TOLIMAN_E_ARGUMENT && error.field() == "intervals") {
        if (options.of_folder)
            malformed(name, error.what());
        throw Failure(kExitUsage, options.exposures() + ": " + kOrbitExposure + " without --on-target");
    }
    if (error.status() == TOLIMAN_E_ARGUMENT && error.field() == "y")
        malformed(name, error.detail().substr(2) + " See --plate-scale");
    throw error;
}

// A wrong unit of --exposure. Samples may be in any order; several may share an exposure.
void warn_of_overlap(const std::vector<double> &days, const ReductionOptions &options, Progress &progress) {
    std::vector<size_t> order(days.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return days[a] < days[b]; });
    for (size_t i = 1; i < order.size(); i++) {
        const double step = (days[order[i]] - days[order[i - 1]]) * kSecondsPerDay;
        if (!(step > kShortest && step < (1 - kSharedTime) * *options.exposure))
            continue;
        progress.warn(formatted("%s: samples %zu and %zu are %.6g s apart, and their exposures overlap: must be in s",
                                options.exposures().c_str(), order[i - 1] + 1, order[i] + 1, step));
        return;
    }
}

double mean_of(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// A wrong unit or plate scale.
void warn_far(const toliman_measure *reduced, Progress &progress) {
    const double measured = mean_of(values_of(reduced, "separation_arcsec")),
                 predicted = mean_of(values_of(reduced, "geometric_arcsec"));
    if (!(std::fabs(measured / predicted - 1) <= kFarScale))
        progress.warn(
            formatted("the mean measured separation is %.4g arcsec, that on the orbit %.4g arcsec: are system, "
                      "unit and --plate-scale right?",
                      measured, predicted));
}

// hypotheses: NULL for the goodness only.
toliman_sky_diagnosis diagnose(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                               toliman_sky_hypothesis *hypotheses) {
    auto result = toliman::sized<toliman_sky_diagnosis>();
    toliman::check(toliman_sky_diagnose(sky, measured, scale_sigma, &result, hypotheses));
    return result;
}

} // namespace

ValueUnit unit_of(const std::string &name, const std::optional<double> &plate_scale) {
    ValueUnit unit = known_units().at(name);
    if (name == "px" && !plate_scale)
        throw Failure(kExitUsage, "--unit px: needs --plate-scale");
    if (name == "px")
        unit.factor = plate_scale_of(plate_scale, 1);
    else if (plate_scale)
        throw Failure(kExitUsage, "--plate-scale: needs --unit px, --system or a state folder");
    return unit;
}

ValueUnit unit_of(const std::string &option, const toliman_measure *series, const std::optional<double> &plate_scale) {
    const std::string stated = stated_unit(series);
    if (!stated.empty() && !option.empty() && option != stated)
        throw Failure(kExitUsage, "--unit " + option + ": " + name_of(series) + " states that y is in " + stated);
    return unit_of(!option.empty() || (stated == "px" && !plate_scale) ? option : stated, plate_scale);
}

ValueUnit unit_of_separations(const toliman_measure *series, const ReductionOptions &options) {
    const std::string stated = stated_unit(series);
    if (stated.empty() || (stated == "px" && options.plate_scale))
        return unit_of(options.plate_scale ? "px" : "arcsec", options.plate_scale);
    if (known_units().at(stated).is_velocity)
        malformed(name_of(series), "y is in " + stated + ": must be measured separations");
    if (stated == "px" || options.plate_scale)
        throw Failure(kExitUsage, std::string("--plate-scale: ") +
                                      (options.plate_scale ? "must not be given: " : "must be given: ") +
                                      name_of(series) + " states that y is in " + stated);
    return unit_of(stated, std::nullopt);
}

void ReductionOptions::add_to(CLI::App &command, CLI::Option *needed) {
    observer.add_to(command);
    add_option(&command, "--plate-scale", plate_scale, "ARCSEC_PER_PX");
    CLI::Option *const length = add_option(&command, "--exposure", exposure, "SECONDS");
    add_option(&command, "--on-target", on_target, "FILE")->needs(length);
    if (needed != nullptr)
        for (const char *name : {"--observer", "--altitude", "--plate-scale", "--exposure", "--on-target"})
            command.get_option(name)->needs(needed);
}

void ReductionOptions::set(Json &json) const {
    observer.set(json);
    json.set("plate_scale_arcsec", plate_scale, "exposure_s", exposure);
}

std::string ReductionOptions::exposures() const {
    return exposure ? formatted("--exposure %g", *exposure) : "--exposure not given";
}

toliman::measurements separations_of(const toliman_measure *series, const ReductionOptions &options) {
    if (options.exposure && !(*options.exposure > 0 && *options.exposure <= kLongestExposure))
        throw Failure(kExitUsage,
                      formatted("--exposure %g: must be in (0, %g] s", *options.exposure, kLongestExposure));
    auto data = toliman::sized<toliman_measure_data>();
    data.kind = TOLIMAN_MEASURE_SEPARATION;
    data.unit = unit_of_separations(series, options).factor;
    const std::vector<double> separations = values_of(series, "y");
    for (size_t i = 0; i < separations.size(); i++)
        if (!(separations[i] > 0))
            malformed(name_of(series),
                      formatted("sample %zu: y = %g: must be a measured separation, above 0", i + 1, separations[i]));
    const Exposures exposures = exposures_of(series, options);
    data.intervals = exposures.intervals.data();
    data.interval_counts = exposures.counts.empty() ? nullptr : exposures.counts.data();
    return changed(series, data);
}

Reduced reduce(const toliman_measure *measured, const ReductionOptions &options, const toliman_sky *sky,
               double scale_sigma, bool with_functions, Progress &progress) {
    const std::string name = name_of(measured);
    auto how = toliman::sized<toliman_sky_reduce_options>();
    how.flags = with_functions ? 0 : TOLIMAN_SKY_NO_FUNCTIONS;
    how.scale_sigma = scale_sigma;
    how.log = [](int32_t, const char *text, void *user_data) { // only of the functions
        static_cast<Progress *>(user_data)->warn(std::string(text) + " (--trend)");
    };
    how.log_data = &progress;
    toliman_measure *made = nullptr;
    const toliman_status status = toliman_sky_reduce(sky, measured, &how, &made);
    if (status == TOLIMAN_E_RANGE && toliman_last_error_field() == std::string("measured"))
        malformed(name, "the observer is not known for the time of any sample: " + options.observer.coverage(sky));
    if (status != TOLIMAN_OK)
        refuse(toliman::error(status), name, options);
    toliman::measurements reduced(made);
    const int64_t all = info_of(measured).n, left_out = info_of(reduced.get()).left_out - info_of(measured).left_out;
    if (options.exposure)
        warn_of_overlap(values_of(measured, "t"), options, progress);
    if (left_out > 0)
        progress.warn(formatted("%lld of %lld samples are left out, as the observer is not known for their times: ",
                                static_cast<long long>(left_out), static_cast<long long>(all)) +
                      options.observer.coverage(sky));
    warn_far(reduced.get(), progress);
    return {std::move(reduced), left_out};
}

void refuse_refitted(const toliman_measure *reduced, const std::string &name, const std::string &cure) {
    if (info_of(reduced).is_refitted != 0)
        throw Failure(kExitUsage, name +
                                      ": its orbit was refitted to measurements of these dates and has absorbed a part "
                                      "of planets with long periods: " +
                                      cure);
}

ReductionNote reduce_to_orbit(const std::string &system, const ReductionOptions &options, double scale_sigma,
                              bool with_functions, toliman::measurements &series, Progress &progress) {
    const auto sky = options.observer.predictor(system, 0, progress);
    const toliman::measurements measured = separations_of(series.get(), options);
    Reduced reduced = reduce(measured.get(), options, sky.get(), scale_sigma, with_functions, progress);
    refuse_refitted(reduced.series.get(), "--system " + system, "give the system file before the refit");
    series = std::move(reduced.series);
    Json json("system", system);
    options.set(json);
    json.set("unreduced", reduced.left_out, "diagnosis",
             diagnosis_of(measured.get(), sky.get(), scale_sigma, progress));
    return {json, system + " seen from: " + options.observer.text() +
                      formatted("; %lld samples left out", static_cast<long long>(reduced.left_out))};
}

std::optional<Json> diagnosis_of(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                                 Progress &progress) {
    if (info_of(measured).is_weighted == 0 ||
        diagnose(measured, sky, scale_sigma, nullptr).goodness != TOLIMAN_GOODNESS_POOR)
        return std::nullopt;
    std::vector<toliman_sky_hypothesis> hypotheses(TOLIMAN_SKY_HYPOTHESES, toliman::sized<toliman_sky_hypothesis>());
    const toliman_sky_diagnosis found = diagnose(measured, sky, scale_sigma, hypotheses.data());
    if (found.cause == TOLIMAN_SKY_CAUSE_NONE)
        return std::nullopt;
    const toliman_sky_hypothesis &cause = hypotheses[static_cast<size_t>(found.cause - TOLIMAN_SKY_CAUSE_TIME)];
    const std::string text = cause.text;
    progress.warn(text + (text.back() == '?' ? "" : ".") +
                  formatted(" The residuals about the orbit have a chi-square of %.3g per "
                            "degree of freedom; %.3g if this is true",
                            found.chi_square, cause.chi_square));
    return Json("cause", toliman_constant_name(found.cause), "text", cause.text, "value", cause.value, "sigma",
                cause.sigma, "chi_square_before", found.chi_square, "chi_square", cause.chi_square, "significance",
                cause.significance);
}

} // namespace cli
