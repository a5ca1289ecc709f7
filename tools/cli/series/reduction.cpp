#include "series/reduction.hpp"

#include <algorithm>
#include <cmath>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

constexpr double kLongestExposure = 400 * 86400.0; // s, of the library's predictions
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

// An exposure that the library refuses is that of all samples, so the message names the option.
[[noreturn]] void refuse_exposure(const toliman::error &error, const ReductionOptions &options) {
    const std::string why = error.what(), field = "intervals: ";
    const std::string given =
        options.exposure ? formatted("--exposure %g: ", *options.exposure) : "--exposure not given: ";
    throw Failure(kExitUsage, given + why.substr(why.find(field) + field.size()));
}

void reduce_all(const Measurements &all, const ReductionOptions &options, const toliman_sky *sky,
                std::vector<double> &reduced, std::vector<toliman_sky_prediction> &seen, size_t &unreduced) {
    try {
        toliman::check(toliman_sky_reduce(sky, all.intervals.data(), nullptr, all.separations.data(),
                                          all.separations.size(), reduced.data(), seen.data(), &unreduced));
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_ARGUMENT || error.field() != "intervals")
            throw;
        refuse_exposure(error, options);
    }
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

// A wrong unit or plate scale.
void warn_far(const Measurements &kept, const std::vector<double> &geometric, Progress &progress) {
    double measured = 0, predicted = 0;
    for (size_t i = 0; i < geometric.size(); i++) {
        measured += kept.separations[i];
        predicted += geometric[i];
    }
    if (!(std::fabs(measured / predicted - 1) <= kFarScale))
        progress.warn(formatted(
            "the mean measured separation is %.4g arcsec, that on the orbit %.4g arcsec: are system, "
            "unit and --plate-scale right?",
            measured / static_cast<double>(geometric.size()), predicted / static_cast<double>(geometric.size())));
}

} // namespace

void ReductionOptions::add_to(CLI::App &command, CLI::Option *needed) {
    observer.add_to(command);
    add_option(&command, "--plate-scale", plate_scale, "ARCSEC_PER_PX",
               "separations are in px of this size; default: in arcsec");
    add_option(&command, "--exposure", exposure, "SECONDS",
               "length of each exposure, whose middle is t; needed with an observer in orbit");
    if (needed != nullptr)
        for (const char *name : {"--observer", "--altitude", "--leap-seconds", "--plate-scale", "--exposure"})
            command.get_option(name)->needs(needed);
}

void ReductionOptions::set(Json &json) const {
    observer.set(json);
    json.set("plate_scale_arcsec", plate_scale, "exposure_s", exposure);
}

Measurements reduce(const Series &series, const ReductionOptions &options, const toliman_sky *sky, Progress &progress) {
    const double plate_scale = plate_scale_of(options.plate_scale, 1), exposure = exposure_of(options);
    Measurements all = {series, intervals_of(tai_of(series), exposure), scaled(series.y, plate_scale),
                        scaled(series.sigma, plate_scale), 0};
    check_separations(series, all.separations);
    const size_t count = series.t.size();
    std::vector<double> reduced(count), geometric;
    std::vector<toliman_sky_prediction> seen(count, toliman::sized<toliman_sky_prediction>());
    Measurements kept = {};
    reduce_all(all, options, sky, reduced, seen, kept.unreduced);
    kept.reduced.name = series.name;
    kept.reduced.time_scale = series.time_scale;
    for (size_t i = 0; i < count; i++) {
        if (std::isnan(reduced[i]))
            continue;
        kept.reduced.t.push_back(series.t[i]);
        kept.reduced.y.push_back(reduced[i] / plate_scale);
        kept.intervals.insert(kept.intervals.end(), {all.intervals[2 * i], all.intervals[2 * i + 1]});
        kept.separations.push_back(all.separations[i]);
        geometric.push_back(seen[i].geometric_arcsec);
        if (series.sigma.empty())
            continue;
        kept.reduced.sigma.push_back(series.sigma[i] / seen[i].factor);
        kept.sigmas.push_back(all.sigmas[i]);
    }
    warn_left_out(kept, count, options, sky, progress);
    warn_far(kept, geometric, progress);
    return kept;
}

} // namespace cli
