// The estimators of a run on its frames: for stars at rest the network, the template and the untrained network; for
// moving stars the fit of the forward model and, where there can be one, a bank of networks.
#pragma once
#include <CLI/App.hpp>

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

// How much is computed of frames without signal, by --controls.
enum class Controls { none, quick, full };

std::string name_of(Controls controls);
void add_controls(CLI::App &command, Controls &controls);

// Errors of the reconstructions of a run's frames by the network.
struct Reconstructions {
    size_t validation_frames = 0;                 // the first frames, over which the means are taken
    double mmse = 0, mssim = 0, photon_floor = 0; // means
    // Of the residuals (frame - reconstruction)/sigma, where sigma is that of the Cramer-Rao bound: mean and mean
    // square of a pixel, mean product of two pixels adjacent in a row. White noise has 0, 1, 0.
    double residual_mean = 0, residual_square = 0, residual_product = 0;
};

class Reconstructor {
  public:
    // For a run of `total` frames.
    Reconstructor(const Scene &scene, const toliman::autoencoder &cae, size_t total);

    // Reconstructs those of frames first ... first + count - 1 that are validation frames. Frames come in order.
    void take(size_t first, const double *images, size_t count);
    const Reconstructions &result() const noexcept { return result_; }

  private:
    using Image = std::vector<double>;
    Image cropped(const double *image) const;
    struct Reconstruction {
        Image residual;
        double mmse = 0, mssim = 0, photon_floor = 0;
    };
    void reconstruct(const double *image, Reconstruction &result) const;
    void add(const Reconstruction &one);
    void add_residual(const Image &residual);

    const Scene &scene_;
    const toliman::autoencoder &cae_;
    size_t side_, crop_row_, crop_col_; // rows and columns of the crop; its first row and column
    Image sigma_;
    Reconstructions result_;
};

struct NetworkOutcome {
    toliman_cae_training training = {};
    double decoder_cosine = 0, decoder_gain = 0; // of (decode(z) - decode(0))/z against the whitened derivative
    Reconstructions reconstructions;
    double efficiency = NAN;                            // of the latent; NaN without controls and photon noise
    Outcome latent, template_fit, untrained, no_signal; // the last two are of the controls
    std::vector<double> losses;                         // of training, after each step
    std::vector<unsigned char> weights;                 // of the trained network, a TLMW
    double encode_seconds = 0, reference_seconds = 0;   // of the frames; the latter of template and untrained network
};

// For stars at rest.
class NetworkRun {
  public:
    // Without controls there is no untrained network. frames: number of frames of the cadence.
    NetworkRun(const Scene &scene, uint64_t seed, size_t frames, Controls controls, Progress &progress);

    void train();
    // Adds the next frames of the cadence, the first of which is frame `at`.
    void push(size_t at, const double *images, size_t count);
    void end_frames();
    // The same for frames without signal, numbered from 0.
    void push_control(size_t at, const double *images, size_t count);
    void end_controls(bool photon_noise);
    NetworkOutcome outcome;

  private:
    void inspect_decoder();

    const Scene &scene_;
    size_t frames_;
    Progress &progress_;
    toliman_cae_options options_;
    toliman::autoencoder cae_, untrained_;
    toliman::linear_estimator template_;
    std::vector<double> template_controls_, untrained_controls_; // values of frames without signal
    Reconstructor reconstructor_;
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

class FitRun {
  public:
    // Throws toliman::error if the scene has no fit. The bank is made with initial weights of this seed.
    FitRun(const Scene &scene, uint64_t seed);

    bool has_bank() const noexcept { return static_cast<bool>(bank_); }
    // Trains the bank; does nothing without one.
    void train(Progress &progress);
    // Adds the next frames.
    void push(const double *images, const double *times_days, size_t count);
    // After the frames of the cadence, which have these times.
    void end_frames(const std::vector<double> &times_days);
    // After the frames without signal, of which frame k has time k modulo the length of the cadence.
    void end_controls(bool photon_noise);
    // Whether there are values enough to search them for a period.
    bool has_series() const;
    FitOutcome outcome;
    BankOutcome bank_outcome;

  private:
    void end_frames(const std::vector<toliman_bank_result> &estimates);
    void end_controls(std::vector<double> values, bool photon_noise, FollowOutcome &of) const;

    std::vector<double> bounds_px(const std::vector<double> &times_days) const;

    toliman::frame_fit fit_;
    toliman::network_bank bank_; // null if there can be none
    std::vector<toliman_fit_result> results_;
    std::vector<toliman_bank_result> estimates_;
    std::vector<double> bounds_px_; // of the frames of the cadence
};

} // namespace cli
