// The computation of `run`: scene -> frames -> latents -> period, with all controls.
#pragma once
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "experiment/reconstructions.hpp"
#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace cli {

// The scatter of one estimator and the periodogram of its values.
struct Outcome {
    double sigma_px = 0; // over frames without signal
    toliman_period_peak peak = {};
    std::vector<double> power;
};

struct Timings {
    double setup = 0, train = 0, simulate = 0, encode = 0, period = 0, controls = 0, images = 0, total = 0;
};

struct Pipeline {
    uint64_t seed = 0;
    FrequencyGrid grid = {};
    toliman_cae_training training = {};
    double decoder_cosine = 0, decoder_gain = 0; // of (decode(z) - decode(0))/z against the whitened derivative
    Reconstructions reconstructions;
    size_t control_frames = 0;
    double efficiency = 0; // of the latent; NaN if the frames lack the photon noise that the bound assumes
    Outcome latent, estimate, untrained, no_signal; // `estimate` is the template's
    Outcome truth;                          // of the true displacements; peak of period and power 0 without signal
    std::vector<double> latents, estimates; // of the frames with signal
    double false_alarm_power = 0;           // power_at_fap_1e_3
    std::vector<double> losses;             // of training, after each step
    std::vector<unsigned char> weights;     // of the trained network, a TLMW
    Timings timings;
};

// Training uses no frames, and the control frames have numbers beyond the cadence: no noise is used twice.
Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, uint64_t seed, double setup_seconds,
                      Progress &progress);

} // namespace cli
