// Errors of the reconstructions of a run's frames by the network.
#pragma once
#include <cstdint>
#include <vector>

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

} // namespace cli
