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

// TAI of time 0 of the scene of a fit: its date, or that of --epoch. Throws Failure if there are both or none.
int64_t time_zero_of(const FrameReductionOptions &options, const Estimator &estimator);

// Adds the columns mjd, factor, geometric_arcsec and reduced_px to those of `encoder`, which must be that of a fit
// whose time 0 is known. The others are as without this. Throws Failure for bad options.
std::unique_ptr<Encoder> make_reducing_encoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options,
                                               const Estimator &estimator, Progress &progress);

} // namespace cli
