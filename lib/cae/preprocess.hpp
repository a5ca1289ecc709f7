// Preprocessing: from a frame of counts to the network's input. Double precision until the last step.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/buffer.hpp"
#include "base/view.hpp"
#include "cae/layout.hpp"
#include "frame/bad_pixels.hpp"
#include "frame/detector_window.hpp"
#include "frame/frame_model.hpp"
#include "kernels/residual.hpp"

namespace toliman::cae {

constexpr size_t kTogether = kernels::kMaxTogether, kBand = 32; // frames and rows that are processed together
static_assert(kFlight.side % kBand == 0 && kCore.side % kBand == 0);
static_assert(kMaxProjected <= kernels::kMaxPlanes);

// Network input derived from the counts:
//   whitened  residual (counts - reference)/sigma per pixel, with the nuisance images projected out
//   residual  (counts - reference)/sigma, with one sigma, the root of the mean variance over the crop
//   raw       counts scaled so that the reference spans 0 to 1
enum class Input : uint32_t { whitened = 0, residual = 1, raw = 2 };
constexpr const char *name_of(Input input) noexcept {
    return input == Input::whitened ? "whitened" : input == Input::residual ? "residual" : "raw";
}

// Place of the crop in a frame:
//   scene  always that of the reference
//   image  moved by whole pixels until its barycentre is that of the reference, to half a pixel
enum class Centre : uint32_t { scene = 0, image = 1 };

// Barycentre of the light of a crop, px from its first pixel.
struct Barycentre {
    double row = 0, col = 0;
};

// Part of a frame that is the network's input: [side][side].
struct Crop {
    ImageView<const double> counts;
    size_t row, col; // of its first pixel in the frame
};

// Parameters of the preprocessing. The planes are stored as double, but rounded to what the weights blob can represent:
// float32, and for the reference the sum of two float32. A network therefore computes the same bits before saving and
// after loading.
struct Preprocess {
    size_t side = 0;                   // rows and columns of the crop
    size_t rows = 0, cols = 0;         // size of a frame
    size_t crop_row = 0, crop_col = 0; // first row and column of the reference's crop
    Centre centre = Centre::scene;
    double background = 0; // Centre::image: counts per pixel of the reference that are not light
    size_t projected = 0;  // number of nuisance images
    Input input = Input::whitened;
    double input_scale = 1; // set by the training mode
    double crb_px = 0;      // Cramer-Rao bound of the separation, with exactly the projected nuisances free
    uint64_t scene_digest = 0;
    std::optional<DetectorWindow> window; // of the crop, if that of the scene is known
    Buffer<double> reference;             // expected counts
    Buffer<double> variance;              // variance of the counts, > 0
    Buffer<double> target;                // whitened, projected derivative image, in sigmas per px of separation
    Buffer<double> nuisance_basis;        // [projected][pixels], orthonormal basis of the whitened nuisance images
    Buffer<float> basis;                  // derived: [side][projected][side], nuisance_basis as float32, which is exact
    Buffer<float> target32;               // derived: target as float32, which is exact
    Buffer<double> whitening;             // derived: 1/sqrt(variance)
    Buffer<double> offset, factor;        // derived: input = (counts - offset) factor, before the projection
    double target_square = 0;             // derived: |target|^2
    double target_most = 0;               // derived: the largest |target| of a pixel
    PixelNoise noise;                     // derived: of the pixels
    KnownBadPixels known_bad;             // derived: of the crop
    Buffer<float> tail;                   // derived: noise.tail
    Barycentre barycentre;                // derived: of the reference, with Centre::image

    size_t pixels() const noexcept { return side * side; }

    // Preprocessing of a scene for a layout, with the crop centred on the barycentre of the reference's flux.
    // Status::unsupported for frames below the layout's side, for a projection without whitened input, and for
    // Centre::image without pixels around the crop. Status::scene if the nuisances explain the whole derivative, so
    // that no information about the separation remains.
    static Preprocess from_model(const FrameModel &model, const Layout &layout, Input input, Centre centre);

    // Computes the derived members from the others. Status::format for Centre::image without light.
    void derive();

    Preprocess with_input_scale(double scale) const;

    // Crop of a frame. Centre::image: Status::argument for a non-finite count and for a crop without light.
    Crop crop_of(const ImageView<const double> &frame) const;

    // Working memory of frames that are preprocessed together; reuse it to avoid allocations.
    struct Work {
        Buffer<float> residual; // of each frame, [pixels]: whitened, with the nuisances projected out; if none are, of
                                // frames that may have bad pixels only
        float component[kTogether][kernels::kMaxPlanes];
        float most[kTogether]; // of each frame, the largest |residual| in the bands so far, times input_scale
        size_t stride = 0;     // numbers from a frame's residual to the next frame's
        void reserve(size_t pixels, size_t frames);
    };

    // The input of `count` crops, at most kTogether, of equal stride: start() once, then band() for each band of kBand
    // rows from the first on, which writes input_scale times the input of crop f to bands[f] [kBand][stride]. Frames
    // that are processed together share the reading of the planes. Status::argument for a non-finite count.
    void start(const Crop *crops, size_t count, Work &work) const;
    void band(const Crop *crops, size_t count, size_t first_row, Work &work, float *const *rows, size_t stride) const;

    // The whole input of a frame: out [side][side].
    void apply(ImageView<const double> frame, Work &work, float *out) const;

    // Fit of nuisances u_k and target t to the whitened residual r of a crop, for any input.
    struct Fitted {
        double displacement; // <t, r>/|t|^2, px
        double square;       // |r - sum_k <u_k, r> u_k - displacement t|^2
        float most, excess;  // the largest magnitude of its pixels, to 0.05, and the largest excess_of(); without
                             // `pixels` 0
    };
    // Of the crop, number i of those that were processed together. Call it after all bands. pixels: whether
    // add_bad_pixels() or lower() follow; needed if may_have_bad_pixels().
    Fitted fit(const Crop &crop, size_t i, bool pixels, Work &work) const;
    // Reduced chi-square, square / (pixels - projected - 1), +infinity if it overflows, and what follows from it.
    FrameGoodness goodness(const Fitted &fitted, size_t bad_pixels, bool few_bad) const noexcept;
    // Whether a pixel of crop i is far off before the fit of the target.
    bool may_have_bad_pixels(size_t i, const Work &work) const noexcept {
        return static_cast<double>(work.most[i]) > kBadPixelSigmas * input_scale;
    }
    // Adds the bad pixels of crop i, as far as they are found at once.
    BadPixels::Found add_bad_pixels(size_t i, const Fitted &fitted, const Work &work, BadPixels &bad) const noexcept;
    // Replaces counts [pixels] of the bad pixels by those that the fit to the other pixels predicts. *largest: by how
    // many standard deviations at most. False if the other pixels do not determine the fit.
    bool lower(size_t i, const Fitted &fitted, const Work &work, const BadPixels &bad, double *counts,
               double &largest) const noexcept;

    // FNV-1a of everything that determines the input.
    uint64_t digest() const noexcept;

    // Converts an input without input_scale to counts [pixels], in place: the inverse of apply() without the
    // projection.
    void to_counts(double *image) const noexcept;

  private:
    Crop crop_at(const ImageView<const double> &frame, size_t row, size_t col) const noexcept {
        return {{frame.row(row) + col, side, side, frame.stride}, row, col};
    }
    double freedom(size_t bad_pixels) const noexcept {
        return static_cast<double>(noise.used - bad_pixels - projected - (target_square > 0 ? 1 : 0));
    }
    double residual_of(size_t i, size_t pixel, const Fitted &fitted, const Work &work) const noexcept;
    kernels::ProjectedRows projected_rows() const noexcept {
        return {side, side, projected, offset.data(), factor.data(), basis.data(), input_scale};
    }
};

} // namespace toliman::cae
