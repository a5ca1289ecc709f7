// The computation of `run`: scene -> frames -> values -> period, with all controls, and the folder of its results.
#pragma once
#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace cli {

// The values of one estimator in a run, their scatter and periodogram.
struct Outcome {
    std::vector<double> values; // of the first frames of the cadence; NaN: the frame gave none
    double sigma_px = NAN;      // over frames without signal; NaN without controls
    toliman_period_peak peak = {};
    std::vector<double> power;
    double power_at_fap_1e_3 = 0;
};

// Errors of the reconstructions of a run's frames by the network.
struct Reconstructions {
    size_t validation_frames = 0;                 // the first frames, over which the means are taken
    double mmse = 0, mssim = 0, photon_floor = 0; // means
    // Of the residuals (frame - reconstruction)/sigma, where sigma is that of the Cramer-Rao bound: mean and mean
    // square of a pixel, mean product of two pixels adjacent in a row. White noise has 0, 1, 0.
    double residual_mean = 0, residual_square = 0, residual_product = 0;
};

struct NetworkOutcome {
    toliman_cae_training training = {};
    double decoder_cosine = 0, decoder_gain = 0; // of (decode(z) - decode(0))/z against the whitened derivative
    Reconstructions reconstructions;
    double efficiency = NAN;                            // of the latent; NaN without controls and photon noise
    Outcome latent, template_fit, untrained, no_signal; // the last two are of the controls
    std::vector<double> losses;                         // of training, after each step
    std::vector<unsigned char> weights;                 // of the trained network, a TLMW
};

// An estimator of moving stars. Lost frames did not converge.
struct FollowOutcome {
    Outcome signal, no_signal;
    // 1 over the root mean square of value over bound in frames without signal; NaN without controls and photon noise.
    double efficiency = NAN;
};

struct FitOutcome : FollowOutcome {
    double bound_px = NAN; // Cramer-Rao bound with the same parameters free, root mean square over the frames
    double chi_square = NAN, iterations = NAN; // means over the frames that converged
    size_t lost = 0;
};

struct BankOutcome : FollowOutcome {
    toliman_bank_info info = {};
    std::vector<double> efficiencies;                     // of the frames, as computed from their states; NaN: lost
    double least_efficiency = NAN, mean_efficiency = NAN; // of these
    double least_cosine = NAN;                            // of the networks' gradients and the ideal ones
    std::vector<unsigned char> weights;                   // file of the bank
};

struct Timings {
    double setup = 0, train = 0, simulate = 0, encode = 0, fit = 0, period = 0, controls = 0, total = 0;
};

// How much is computed of frames without signal, by --controls.
enum class Controls { none, quick, full };

std::string name_of(Controls controls);
void add_controls(CLI::App &command, Controls &controls);

struct RunOptions {
    uint64_t seed;
    Controls controls;
};

class Pipeline {
  public:
    RunOptions options = {0, Controls::full};
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
