// From a frame of counts to the residual that the network sees, in double until the last step.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/frame_model.hpp"
#include "base/view.hpp"

namespace toliman::cae {

constexpr size_t kMaxProjected = 8;

// The planes are held in double but take only values that the weights blob can hold: float32, the reference the sum of
// two. So a network computes the same before saving and after loading.
struct Preprocess {
    size_t rows = 0, cols = 0;         // of a frame
    size_t crop_row = 0, crop_col = 0; // first of the 256x256 crop
    size_t projected = 0;              // nuisance images
    double input_scale = 1e-3;         // keeps the network's ELUs in their linear part
    double crb_px = 0;
    uint64_t scene_digest = 0;
    Buffer<double> reference;     // expected counts
    Buffer<double> variance;      // of the counts, > 0
    Buffer<double> target;        // whitened, projected derivative, sigmas of a pixel per px
    Buffer<double> units;         // [projected][pixels], whitened nuisance images, orthonormal
    Buffer<double> inverse_sigma; // 1/sqrt(variance), derived

    // Crop about the light's barycentre of the reference. Status::unsupported for frames below 256x256,
    // Status::scene when nothing of the derivative is left beside the nuisances.
    static Preprocess from_model(const FrameModel &model);

    // Sets what follows from the other planes.
    void derive();

    // Whitened, projected residual of the crop, out [pixels]. Status::argument for a non-finite count.
    void residual(ImageView<const double> frame, double *out) const;
};

} // namespace toliman::cae
