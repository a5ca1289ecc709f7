// The network on the frames of a run: values, reconstructions, and what it is compared with, the template and the
// untrained network.
#pragma once
#include "common/common.hpp"
#include "run/outcome.hpp"
#include "scenes/scene.hpp"

namespace cli {

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

} // namespace cli
