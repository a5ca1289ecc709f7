// Reconstructions of a run's frames by the network: their errors, and a few random frames as examples.
#pragma once
#include <cstdint>
#include <vector>

#include "scenes/scene.hpp"

namespace cli {

constexpr size_t kNetworkSide = 256; // rows and columns of the network's images
constexpr size_t kSamples = 5;       // random frames

struct Reconstructions {
    size_t crop_row = 0, crop_col = 0;            // first row and column of the crop
    size_t validation_frames = 0;                 // the first frames, over which the means are taken
    double mmse = 0, mssim = 0, photon_floor = 0; // means
    // Of the residuals (frame - reconstruction)/sigma, where sigma is that of the Cramer-Rao bound: mean and mean
    // square of a pixel, mean product of two pixels adjacent in a row. White noise has 0, 1, 0.
    double residual_mean = 0, residual_square = 0, residual_product = 0;
    std::vector<size_t> samples;                            // frame numbers, ascending
    std::vector<double> frames, reconstructions, residuals; // [samples][256][256]; frames are cropped
};

class Reconstructor {
  public:
    // Chooses one random frame from each fifth of `total` frames by the seed; at least kSamples frames.
    Reconstructor(const Scene &scene, const toliman::autoencoder &cae, uint64_t seed, size_t total);

    // Reconstructs those of frames first ... first + count - 1 that belong to the validation frames or the samples.
    // Frames come in order.
    void take(size_t first, const double *images, size_t count);
    Reconstructions &&result() { return std::move(result_); }

  private:
    using Image = std::vector<double>;
    Image cropped(const double *image) const;
    struct Reconstruction {
        size_t k = 0; // number of the frame
        Image frame, image, residual;
        double mmse = 0, mssim = 0, photon_floor = 0;
    };
    void reconstruct(const double *image, Reconstruction &result) const;
    void add(const Reconstruction &one);
    void add_residual(const Image &residual);
    bool is_sample(size_t k) const;

    const Scene &scene_;
    const toliman::autoencoder &cae_;
    Image sigma_;
    Reconstructions result_;
};

} // namespace cli
