// Reduces the separations of encoded frames to the orbit of a binary: `encode --fit SCENE --system SYSTEM`.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "frames/encoder.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

struct FrameReductionOptions {
    void add_to(CLI::App &command);

    std::optional<std::string> system, epoch; // no reduction without a system; the date of the scene without an epoch
    ObserverOptions observer;
    std::optional<double> plate_scale; // arcsec per px; otherwise that of the scene
};

// Adds the columns mjd, factor, geometric_arcsec and reduced_px to those of `encoder`, which must be that of a fit. The
// others are as without this. Throws Failure if the scene has no date or bad options were given.
std::unique_ptr<Encoder> make_reducing_encoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options,
                                               const Estimator &estimator, Progress &progress);

} // namespace cli
