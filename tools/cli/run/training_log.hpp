// The log of an unsupervised training: one line per epoch and, every ten epochs, the false alarm probability of its
// latents.
#pragma once
#include "common/common.hpp"
#include "scenes/scene.hpp"

namespace cli {

class TrainingLog {
  public:
    // training_seed: of the noise of the training frames. epochs: those of the training that is resumed; the lines of
    // an earlier log up to this epoch are kept. Throws Failure if the file exists and is not a log.
    TrainingLog(const std::string &path, const Scene &scene, uint64_t training_seed, uint32_t epochs);

    // Adds the line of the random weights, epoch 0, and writes the file.
    void add_untrained(const toliman_cae *network);

    // Adds the line of an epoch and writes the file. Returns whether the epoch has false alarm probabilities.
    bool add(const toliman_cae *network, const toliman_cae_training &result, bool last);

  private:
    std::string faps_of(const toliman_cae *network) const;
    double log10_fap(const toliman_cae *network, uint64_t seed, const double *displacements) const;
    void write() const;

    std::string path_;
    const Scene &scene_;
    Cadence cadence_;
    uint64_t training_seed_;
    std::vector<std::string> lines_;
};

} // namespace cli
