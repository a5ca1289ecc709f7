// From a frame of counts to what the network sees, in double until the last step.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/frame_model.hpp"
#include "base/view.hpp"

namespace toliman::cae {

constexpr size_t kMaxProjected = 8;

// What becomes of counts: the whitened residual (counts - reference)/sigma of each pixel, less the projected nuisances;
// the residual over the frame's mean sigma; or the counts scaled so that the reference spans 0 to 1.
enum class Input : uint32_t { whitened = 0, residual = 1, raw = 2 };
constexpr const char *name_of(Input input) noexcept {
    return input == Input::whitened ? "whitened" : input == Input::residual ? "residual" : "raw";
}

// The planes are held in double but take only values that the weights blob can hold: float32, the reference the sum of
// two. So a network computes the same before saving and after loading.
struct Preprocess {
    size_t rows = 0, cols = 0;         // of a frame
    size_t crop_row = 0, crop_col = 0; // first of the 256x256 crop
    size_t projected = 0;              // nuisance images
    Input input = Input::whitened;
    double input_scale = 1; // a matter of the training
    double crb_px = 0;
    uint64_t scene_digest = 0;
    Buffer<double> reference;      // expected counts
    Buffer<double> variance;       // of the counts, > 0
    Buffer<double> target;         // whitened, projected derivative, sigmas of a pixel per px
    Buffer<double> units;          // [projected][pixels], whitened nuisance images, orthonormal
    Buffer<double> offset, factor; // derived: input = (counts - offset) factor, before the projection
    double target_square = 0;      // derived: |target|^2

    // Crop about the light's barycentre of the reference. Status::unsupported for frames below 256x256 and for a
    // projection of what is not whitened, Status::scene when nothing of the derivative is left beside the nuisances.
    static Preprocess from_model(const FrameModel &model, Input input);

    // Sets what follows from the other planes.
    void derive();

    Preprocess with_input_scale(double scale) const;

    // input_scale times the input, [256 rows][stride], from the crop of a frame. scratch, kept from frame to frame,
    // saves an allocation. Status::argument for a non-finite count.
    void apply(ImageView<const double> frame, Buffer<double> &scratch, float *out, size_t stride) const;

    // Mean square per degree of freedom of what reference, nuisances and derivative leave of the whitened residual r of
    // the crop, whatever the input is: |r - sum_k <u_k, r> u_k - <t, r> t/|t|^2|^2/(pixels - projected - 1); +infinity
    // where it overflows. Of the frame that was applied last, with its scratch.
    double chi_square(ImageView<const double> frame, Buffer<double> &scratch) const;

    // FNV-1a of what makes the input.
    uint64_t digest() const noexcept;

    // Counts [pixels] of an input that is not yet scaled, in place; the inverse of apply but for the projection.
    void to_counts(double *image) const noexcept;
};

} // namespace toliman::cae
