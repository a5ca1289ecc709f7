// The network on the frames of a run, and what it is compared with: the template and the untrained network.
#pragma once
#include <vector>

#include "common/terminal.hpp"
#include "run/controls.hpp"
#include "run/outcome.hpp"
#include "run/reconstructions.hpp"

namespace cli {

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
