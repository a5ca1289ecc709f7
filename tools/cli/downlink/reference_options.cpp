#include "downlink/reference_options.hpp"

#include "common/failure.hpp"
#include "common/text.hpp"
#include "downlink/state_folder.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

// The system of a folder, JSON text.
std::string system_of(const std::string &folder, Progress &progress) {
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    return info_of(tracker).system;
}

} // namespace

void ReferenceOptions::add_to(CLI::App &command) {
    add_option(&command, "--system", system_, "SYSTEM",
               "reduce separations to the orbit of alpha-cen or of a system file; default: that of the folder");
    observer_.add_to(command, ObserverOptions::Times::given_elsewhere);
    add_option(&command, "--plate-scale", plate_scale_, "ARCSEC",
               "arcsec per pixel of the reduction; default: that of the folder; for a new folder, that of the scene");
    command
        .add_option("--scale-sigma", scale_sigma_,
                    "standard deviation of the relative error of the plate scale; default: that of the folder; for a "
                    "new folder, 0")
        ->check(CLI::Range(0.0, 0.999));
}

void ReferenceOptions::check() const {
    observer_.check();
    if (plate_scale_)
        plate_scale_of(plate_scale_, 0);
}

void ReferenceOptions::use_scene(const SceneDefaults &scene, const std::optional<toliman_track_options> &made,
                                 Notes &notes) {
    const bool is_reduced = made && made->reduction.plate_scale_arcsec > 0;
    if (!given() && made && !is_reduced)
        return;
    observer_.use_scene(scene, notes);
    has_observer_ = scene.has_observer;
    system_ = system_or_that_of(scene, system_, !is_reduced && (observer_.given() || has_observer_), notes);
}

void ReferenceOptions::set(toliman_track_options &how, const std::optional<toliman_track_options> &made,
                           Progress &progress) {
    const bool is_reduced = made && made->reduction.plate_scale_arcsec > 0;
    if (!given() && !is_reduced)
        return;
    if (system_.empty() && !is_reduced)
        throw Failure(kExitUsage, (observer_.given() ? "--observer and --altitude"
                                   : plate_scale_    ? "--plate-scale"
                                                     : "--scale-sigma") +
                                      std::string(": need --system"));
    if (system_.empty() && !observer_.given() && !has_observer_)
        throw Failure(kExitUsage,
                      std::string(how.folder) +
                          ": its separations are reduced: give the orbit of the spacecraft, --observer FILE");
    sky_ = observer_.predictor(system_.empty() ? system_of(how.folder, progress) : system_, 0, progress);
    how.reduction.sky = sky_.get();
    if (plate_scale_)
        how.reduction.plate_scale_arcsec = plate_scale_of(plate_scale_, 0);
    how.reduction.scale_sigma = scale_sigma_.value_or(how.reduction.scale_sigma);
}

std::string ReferenceOptions::text() const {
    return (system_.empty() ? "" : " --system " + system_) + observer_.options() +
           (plate_scale_ ? formatted(" --plate-scale %.17g", *plate_scale_) : "") +
           (scale_sigma_ ? formatted(" --scale-sigma %.17g", *scale_sigma_) : "");
}

std::string ReferenceOptions::orbit() const {
    return sky_ ? observer_.orbit(sky_.get()) : "";
}

std::string ReferenceOptions::coverage() const {
    return sky_ && observer_.is_file() ? observer_.coverage(sky_.get()) : "";
}

} // namespace cli
