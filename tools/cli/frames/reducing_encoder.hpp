// Reduces the separations of encoded frames to the orbit of a binary: `encode --fit SCENE --system SYSTEM`.
#pragma once
#include "frames/encoder.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

struct FrameReductionOptions {
    void add_to(CLI::App &command);
    // Takes what is not given from the scene of a fit: time 0, observer, and the system of an observer that is known.
    // What differs from the scene is reported. Throws Failure for options that need a system.
    void use_scene(const Estimator &estimator, Notes &notes);

    std::optional<std::string> system, epoch; // no reduction without a system
    ObserverOptions observer;
    std::optional<double> plate_scale;   // arcsec per px; otherwise that of the scene
    std::optional<int64_t> time_zero_ns; // TAI of time 0 of the scene, after use_scene
};

// Adds the columns mjd, factor, geometric_arcsec and reduced_px to those of `encoder`, which must be that of a fit
// whose time 0 is known. The others are as without this. Throws Failure for bad options.
std::unique_ptr<Encoder> make_reducing_encoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options,
                                               const Estimator &estimator, Progress &progress);

} // namespace cli
