#include "series/reduction.hpp"

#include <algorithm>
#include <cmath>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

constexpr double kLongestExposure = 400 * 86400.0; // s, of the library's predictions
constexpr double kSharedTime = 0.05;               // of two exposures, that inaccurate times may have
constexpr double kFarScale = 0.01; // relative difference of measured and predicted separations that is reported

double exposure_of(const ReductionOptions &options) {
    const double exposure = options.exposure.value_or(0);
    if (options.exposure && !(exposure > 0 && exposure <= kLongestExposure))
        throw Failure(kExitUsage, formatted("--exposure %g: must be in (0, %g] s", exposure, kLongestExposure));
    return exposure;
}

std::vector<int64_t> intervals_of(const std::vector<int64_t> &middles, double exposure) {
    const int64_t length = std::llround(exposure * 1e9);
    std::vector<int64_t> intervals;
    for (const int64_t middle : middles) {
        intervals.push_back(middle - length / 2);
        intervals.push_back(intervals.back() + length);
    }
    return intervals;
}

// Values of the series in arcsec.
std::vector<double> scaled(const std::vector<double> &values, double plate_scale) {
    std::vector<double> arcsec = values;
    for (double &value : arcsec)
        value *= plate_scale;
    return arcsec;
}

void check_separations(const Series &series, const std::vector<double> &arcsec) {
    for (size_t i = 0; i < arcsec.size(); i++)
        if (!(arcsec[i] > 0 && std::isfinite(arcsec[i])))
            malformed(series.name,
                      formatted("sample %zu: y = %g: must be a measured separation, above 0", i + 1, series.y[i]));
}

void reduce_all(const Measured &measured, const std::vector<double> &arcsec, const toliman_sky *sky,
                std::vector<double> &reduced, std::vector<toliman_sky_prediction> &seen, size_t &unreduced) {
    const toliman_status status = toliman_sky_reduce(sky, measured.intervals.data(), nullptr, arcsec.data(),
                                                     arcsec.size(), reduced.data(), seen.data(), &unreduced);
    const toliman::error error(status);
    if (status == TOLIMAN_E_ARGUMENT && error.field() == "intervals") { // exposures that cannot be reduced
        if (measured.exposures.empty())
            malformed(measured.series.name, error.what());
        throw Failure(kExitUsage, measured.exposures + ": " + kOrbitExposure);
    }
    if (status == TOLIMAN_E_ARGUMENT && error.field() == "separations_arcsec")
        malformed(measured.series.name,
                  std::string(error.what()).substr(error.field().size() + 2) + " See --plate-scale");
    toliman::check(status);
}

// Adds the values that sample i of a series has in its columns.
void add_row(const Nuisance &from, size_t i, Nuisance &to) {
    for (size_t c = 0; c < from.columns.size(); c++)
        to.columns[c].values.push_back(from.columns[c].values[i]);
}

void warn_left_out(const Measurements &kept, size_t all, const ReductionOptions &options, const toliman_sky *sky,
                   Progress &progress) {
    if (kept.unreduced == 0)
        return;
    if (kept.unreduced == all)
        malformed(kept.reduced.name,
                  "the observer is not known for the time of any sample: " + options.observer.coverage(sky));
    progress.warn(formatted("%zu of %zu samples are left out, as the observer is not known for their times: ",
                            kept.unreduced, all) +
                  options.observer.coverage(sky));
}

// A wrong unit of --exposure. Samples may be in any order; several may share an exposure.
void warn_of_overlap(const Measured &measured, double exposure, Progress &progress) {
    std::vector<size_t> order(measured.series.t.size());
    for (size_t i = 0; i < order.size(); i++)
        order[i] = i;
    const auto start = [&](size_t i) { return measured.intervals[2 * i]; };
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return start(a) < start(b); });
    for (size_t i = 1; i < order.size(); i++) {
        const double step = static_cast<double>(start(order[i]) - start(order[i - 1])) / 1e9;
        if (!(step > 0 && step < (1 - kSharedTime) * exposure))
            continue;
        progress.warn(formatted("%s: samples %zu and %zu are %g s apart, and their exposures overlap: must be in s",
                                measured.exposures.c_str(), order[i - 1] + 1, order[i] + 1, step));
        return;
    }
}

// A wrong unit or plate scale.
void warn_far(const Measurements &kept, Progress &progress) {
    const auto count = static_cast<double>(kept.separations.size());
    double measured = 0, predicted = 0;
    for (size_t i = 0; i < kept.separations.size(); i++) {
        measured += kept.separations[i];
        predicted += kept.predictions[i].geometric_arcsec;
    }
    if (!(std::fabs(measured / predicted - 1) <= kFarScale))
        progress.warn(
            formatted("the mean measured separation is %.4g arcsec, that on the orbit %.4g arcsec: are system, "
                      "unit and --plate-scale right?",
                      measured / count, predicted / count));
}

} // namespace

void ReductionOptions::add_to(CLI::App &command, CLI::Option *needed) {
    observer.add_to(command);
    add_option(&command, "--plate-scale", plate_scale, "ARCSEC_PER_PX",
               "separations are in px of this size; default: in arcsec");
    add_option(&command, "--exposure", exposure, "SECONDS",
               "length of each exposure, whose middle is t; needed with an observer in orbit");
    if (needed != nullptr)
        for (const char *name : {"--observer", "--altitude", "--plate-scale", "--exposure"})
            command.get_option(name)->needs(needed);
}

void ReductionOptions::set(Json &json) const {
    observer.set(json);
    json.set("plate_scale_arcsec", plate_scale, "exposure_s", exposure);
}

Measured measured_of(const Series &series, const ReductionOptions &options) {
    const double exposure = exposure_of(options);
    return {series, intervals_of(tai_of(series), exposure), plate_scale_of(options.plate_scale, 1),
            options.exposure ? formatted("--exposure %g", exposure) : "--exposure not given"};
}

Measurements reduce(const Measured &measured, const ReductionOptions &options, const toliman_sky *sky,
                    Progress &progress) {
    const Series &series = measured.series;
    const double plate_scale = measured.plate_scale;
    const std::vector<double> separations = scaled(series.y, plate_scale), sigmas = scaled(series.sigma, plate_scale);
    check_separations(series, separations);
    const size_t count = series.t.size();
    std::vector<double> reduced(count);
    std::vector<toliman_sky_prediction> seen(count, toliman::sized<toliman_sky_prediction>());
    Measurements kept = {};
    reduce_all(measured, separations, sky, reduced, seen, kept.unreduced);
    kept.reduced.name = series.name;
    kept.reduced.time_scale = series.time_scale;
    kept.reduced.time_format = series.time_format;
    kept.reduced.nuisance = series.nuisance;
    for (NuisanceColumn &column : kept.reduced.nuisance.columns)
        column.values.clear();
    for (size_t i = 0; i < count; i++) {
        if (std::isnan(reduced[i]))
            continue;
        kept.reduced.t.push_back(series.t[i]);
        kept.reduced.y.push_back(reduced[i] / plate_scale);
        kept.intervals.insert(kept.intervals.end(), {measured.intervals[2 * i], measured.intervals[2 * i + 1]});
        kept.separations.push_back(separations[i]);
        kept.reduced.position_angle_deg.push_back(seen[i].geometric_angle_deg);
        kept.predictions.push_back(seen[i]);
        add_row(series.nuisance, i, kept.reduced.nuisance);
        if (series.sigma.empty())
            continue;
        kept.reduced.sigma.push_back(series.sigma[i] / seen[i].factor);
        kept.sigmas.push_back(sigmas[i]);
    }
    if (options.exposure)
        warn_of_overlap(measured, *options.exposure, progress);
    warn_left_out(kept, count, options, sky, progress);
    warn_far(kept, progress);
    return kept;
}

} // namespace cli
