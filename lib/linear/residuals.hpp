// The frames that components are found in: residuals against the scene's reference, binned, whitened, projected.
#pragma once
#include <cstddef>
#include <functional>

#include "base/buffer.hpp"
#include "base/frame_model.hpp"
#include "base/pixel.hpp"
#include "base/view.hpp"

namespace toliman::linear {

struct Preparation {
    bool raw = false;    // counts as they are: neither whitened nor projected
    size_t bin = 1;      // pixels a side that are summed first; divides rows and cols
    size_t capacity = 0; // frames
};

// Residuals are kept as float32, which is enough since the reference is gone: a value is off by 2^-24 of itself at
// most. At 1e9 counts a pixel whose sigma is 3e4 is off by 6e-8 sigma, while 1e-6 px move it by 3e-3.
class Residuals {
  public:
    // Takes all memory. Status::argument for a bin that does not divide the frame.
    Residuals(const FrameModel &model, const Preparation &preparation);

    // Adds a frame of the model's shape. Status::argument for a count that is not finite, Status::range for one beyond
    // float32, Status::capacity when full; nothing is changed then, and no memory taken ever.
    void push(ImageView<const double> counts);

    // The same of many frames: all of them or none.
    void push_many(const PixelFrames &frames, size_t count);

    void clear() noexcept { values_.clear(); }

    // Inner products [frames][frames] of the residuals less their mean, in double. The same bits for any `workers`.
    // `after_own` as of run_jobs().
    Buffer<double> gram(unsigned workers, const std::function<void(double)> &after_own) const;

    // The amplitude (px) of a sinusoid at which the leading principal component begins to see it, for the frames
    // pushed; +infinity without frames. NaN for raw residuals, whose noise differs from pixel to pixel.
    double threshold_px() const noexcept;

    const Preparation &preparation() const noexcept { return preparation_; }
    size_t rows() const noexcept { return rows_; } // of the frames
    size_t cols() const noexcept { return cols_; }
    size_t pixels() const noexcept { return pixels_; } // after binning
    size_t projected() const noexcept { return projected_; }
    size_t frames() const noexcept { return values_.size() / pixels_; }
    double crb_px() const noexcept {
        return crb_px_;
    } // of the binned pixels with the projected images free; NaN if raw

  private:
    Buffer<double> binned(const Buffer<double> &image) const;
    void whiten(const FrameModel &model);
    Buffer<double> mean() const;

    Preparation preparation_;
    size_t rows_, cols_, pixels_, projected_ = 0;
    double crb_px_;
    Buffer<double> reference_;     // [rows][cols]
    Buffer<double> inverse_sigma_; // [pixels]; empty when raw
    Buffer<double> units_;         // [projected][pixels], orthonormal
    Buffer<double> scratch_;       // [pixels], the frame that is being pushed
    Buffer<float> values_;         // [frames][pixels]
};

} // namespace toliman::linear
