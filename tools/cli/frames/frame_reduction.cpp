// Method: the time of a frame, in TAI, is that of its encoder. It is the middle of the exposure, whose length and
// on-target intervals are those of the scene's cadence.
#include "frames/encoder.hpp"

#include "options/command.hpp"
#include "scenes/dates.hpp"
#include "scenes/leap_seconds.hpp"
#include "scenes/sky_times.hpp"

namespace cli {

namespace {

// Modified Julian Day of a time in ns since 1970; whole days are exact.
double mjd_of(int64_t ns) {
    constexpr int64_t kDay = 86400000000000, kMjdOf1970 = 40587;
    const int64_t days = ns / kDay;
    return static_cast<double>(kMjdOf1970 + days) + static_cast<double>(ns - days * kDay) / static_cast<double>(kDay);
}

constexpr double kFarthest = 2; // ratio of measured and predicted separations

// The exposures of a scene that an observer in orbit cannot reduce.
bool is_too_long(const SceneDefaults &scene) {
    constexpr double kLongest = 600;
    const bool in_orbit = !scene.observer_file.empty() || scene.altitude_km;
    return in_orbit && scene.on_target_s.empty() && scene.on_target_file.empty() &&
           !(scene.exposure_s > 0 && scene.exposure_s <= kLongest);
}

} // namespace

FrameReduction::FrameReduction(const FrameReductionOptions &options, const Estimator &estimator, Progress &progress)
    : options_(options), scene_(estimator.scene.path),
      plate_scale_(plate_scale_of(options.plate_scale, estimator.pixel_scale_arcsec)),
      sky_(options.observer.predictor(*options.system, 0, progress)), exposure_s_(estimator.scene.exposure_s),
      exposures_(estimator.scene) {}

int64_t FrameReduction::time_of(const Separation &measured) const {
    if (!measured.tai_ns)
        malformed(scene_, formatted("a frame at %g days: must be within 100,000 days of time 0, and within 64 bits "
                                    "of TAI in ns",
                                    measured.time_days));
    return *measured.tai_ns;
}

void FrameReduction::reduce(const Encoder &encoder, size_t count) {
    std::vector<int64_t> intervals;
    std::vector<size_t> counts, places;
    times_.clear();
    for (size_t i = 0; i < count; i++) {
        const int64_t middle = times_.emplace_back(time_of(encoder.separation(i)));
        const std::vector<int64_t> times = exposures_.at(middle);
        if (times.empty())
            continue;
        intervals.insert(intervals.end(), times.begin(), times.end());
        counts.push_back(times.size() / 2);
        places.push_back(i);
    }
    std::vector<toliman_sky_prediction> seen(places.size(), toliman::sized<toliman_sky_prediction>());
    try {
        if (!places.empty())
            toliman::check(toliman_sky_predict_mean(sky_.get(), intervals.data(),
                                                    exposures_.has_intervals() ? counts.data() : nullptr, places.size(),
                                                    seen.data()));
    } catch (
        const toliman::error &error) { // the library refuses the exposure of all frames, which is that of the scene
        if (error.status() == TOLIMAN_E_ARGUMENT && error.field() == "intervals")
            malformed(scene_, formatted("cadence.exposure_s = %g: ", exposure_s_) + kOrbitExposure +
                                  ", or with cadence.on_target_s");
        throw;
    }
    rows_.assign(count, {NAN, NAN, NAN});
    for (size_t i = 0; i < places.size(); i++)
        rows_[places[i]] = row_of(encoder.separation(places[i]).px, seen[i]);
    for (const Row &row : rows_)
        unreduced_ += std::isnan(row.factor);
    frames_ += count;
}

FrameReduction::Row FrameReduction::row_of(double px, const toliman_sky_prediction &seen) {
    const double ratio = px * plate_scale_ / seen.separation_arcsec;
    if (ratio > kFarthest || (ratio > 0 && ratio < 1 / kFarthest))
        far_++;
    return {seen.factor, seen.geometric_arcsec, px / seen.factor - seen.geometric_arcsec / plate_scale_};
}

std::string FrameReduction::line(size_t i) const {
    const Row &row = rows_[i];
    std::string columns = formatted(",%.17g", mjd_of(times_[i]));
    for (const double number : {row.factor, row.geometric_arcsec, row.reduced_px})
        columns += std::isnan(number) ? ",nan" : formatted(",%.17g", number);
    return columns;
}

void FrameReduction::end(Progress &progress) const {
    if (2 * far_ > frames_)
        progress.warn(formatted("%zu of %zu measured separations differ from those of the system by more than a factor "
                                "of 2: are system and --plate-scale right?",
                                far_, frames_));
    if (unreduced_ > 0)
        progress.warn(formatted("%zu of %zu frames are not reduced, as observer or time on target are not known: ",
                                unreduced_, frames_) +
                      options_.observer.coverage(sky_.get()));
}

void FrameReductionOptions::add_to(CLI::App &command) {
    CLI::Option *const chosen = add_option(&command, "--system", system, "SYSTEM");
    observer.add_to(command);
    add_option(&command, "--plate-scale", plate_scale, "ARCSEC_PER_PX");
    add_option(&command, "--epoch", epoch, "TIME");
    chosen->needs(command.get_option("--fit"));
}

void FrameReductionOptions::use_scene(const Estimator &estimator, Notes &notes) {
    const SceneDefaults &scene = estimator.scene;
    if (epoch)
        time_zero_ns = read_epoch("--epoch", *epoch, LeapSeconds(observer.leap_seconds()).rows);
    else if (estimator.time_zero_ns != 0)
        time_zero_ns = estimator.time_zero_ns;
    if (epoch && estimator.time_zero_ns != 0 && time_zero_ns != estimator.time_zero_ns)
        notes.push_back("--epoch " + *epoch + ": instead of binary.date of " + scene.path + ", " +
                        date_text(estimator.time_zero_ns) + " TAI");
    const bool is_asked = observer.given(), is_known = is_asked || (scene.has_observer && !is_too_long(scene));
    observer.use_scene(scene, notes);
    if (const std::string chosen = system_or_that_of(scene, system.value_or(""), is_known && !system, notes);
        !chosen.empty())
        system = chosen;
    if (!system && (is_asked || plate_scale))
        throw Failure(kExitUsage, std::string(is_asked ? "--observer and --altitude: need" : "--plate-scale: needs") +
                                      " --system, or --fit with a scene whose binary.orbit is a system");
    if (system && !time_zero_ns)
        throw Failure(kExitUsage, scene.path + ": has no moving stars with a binary.date: give time 0 by --epoch");
}

} // namespace cli
