// The computation of `run`: scene -> frames -> values -> period, with all controls, and the folder of its results.
#pragma once
#include "run/estimators.hpp"

namespace cli {

struct Timings {
    double setup = 0, train = 0, simulate = 0, encode = 0, fit = 0, period = 0, controls = 0, total = 0;
};

struct RunOptions {
    uint64_t seed;
    Controls controls;
};

class Pipeline {
  public:
    uint64_t seed = 0;
    Controls controls = Controls::full;
    bool photon_noise = false; // the frames have the photon noise that the Cramer-Rao bound assumes
    FrequencyGrid grid = {};
    size_t control_frames = 0;
    std::optional<NetworkOutcome> network; // if the stars are at rest
    std::optional<FitOutcome> fit;         // if the stars move
    std::optional<BankOutcome> bank;       // the same, where there can be a bank
    Outcome truth;                         // of the true displacements; peak of period and power 0 without signal
    Timings timings;

    // The result of the run: that of the network; if the stars move, of the bank or else the fit.
    const Outcome &result() const noexcept { return network ? network->latent : following().signal; }
    const Outcome &no_signal() const noexcept { return network ? network->no_signal : following().no_signal; }
    double efficiency() const noexcept { return network ? network->efficiency : following().efficiency; }

  private:
    const FollowOutcome &following() const noexcept { return bank ? static_cast<const FollowOutcome &>(*bank) : *fit; }
};

// Training uses no frames, and the control frames have noise of their own: no noise is used twice.
Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, const RunOptions &options, double setup_seconds,
                      Progress &progress);

// Everything that a run writes.
struct RunFiles {
    const Scene &scene;
    const std::string &scene_text;
    double rotation_deg; // position angle of the detector's +y axis
    const Cadence &cadence;
    const Pipeline &pipeline;
};

// Opens every file before the computation, so that an unwritable folder fails at once.
void open_files(OutputFolder &folder);
// Returns the text of result.json, schema toliman-run/2.
std::string write(OutputFolder &folder, const RunFiles &files);

} // namespace cli
