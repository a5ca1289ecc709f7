// The computation of `run`: scene -> frames -> latents -> period, with all controls.
#pragma once
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "experiment/controls.hpp"
#include "experiment/reconstructions.hpp"
#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace cli {

// The scatter of one estimator and the periodogram of its values.
struct Outcome {
    double sigma_px = NAN; // over frames without signal; NaN without controls
    toliman_period_peak peak = {};
    std::vector<double> power;
    double power_at_fap_1e_3 = 0;
};

struct Timings {
    double setup = 0, train = 0, simulate = 0, encode = 0, period = 0, controls = 0, images = 0, total = 0;
};

struct RunOptions {
    uint64_t seed;
    Controls controls;
};

struct Pipeline {
    uint64_t seed = 0;
    Controls controls = Controls::full;
    bool photon_noise = false; // the frames have the photon noise that the Cramer-Rao bound assumes
    FrequencyGrid grid = {};
    toliman_cae_training training = {};
    double decoder_cosine = 0, decoder_gain = 0; // of (decode(z) - decode(0))/z against the whitened derivative
    Reconstructions reconstructions;
    size_t control_frames = 0;
    double efficiency = NAN;                        // of the latent; NaN without photon noise and without controls
    Outcome latent, estimate, untrained, no_signal; // `estimate` is the template's; the last two are of the controls
    Outcome truth;                          // of the true displacements; peak of period and power 0 without signal
    std::vector<double> latents, estimates; // of the frames with signal
    std::vector<double> losses;             // of training, after each step
    std::vector<unsigned char> weights;     // of the trained network, a TLMW
    Timings timings;
};

// Training uses no frames, and the control frames have numbers beyond the cadence: no noise is used twice. Training
// runs on one thread, and while_training() on another at the same time.
Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, const RunOptions &options, double setup_seconds,
                      const std::function<void()> &while_training, Progress &progress);

} // namespace cli
