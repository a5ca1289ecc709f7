// The set of frames that components are computed from: residuals from the reference, binned, whitened and projected.
#pragma once
#include <cstddef>
#include <functional>

#include "base/buffer.hpp"
#include "base/view.hpp"
#include "frame/frame_model.hpp"
#include "frame/pixel.hpp"

namespace toliman::linear {

struct Preparation {
    bool raw = false;    // residual counts, neither whitened nor projected
    size_t bin = 1;      // side of the blocks of pixels that are summed first; divides rows and cols
    size_t capacity = 0; // frames
};

// Residuals are stored as float32. This is sufficient because the reference is subtracted first: the relative rounding
// error is at most 2^-24, or 6e-8 sigma for a residual of 1 sigma, while a displacement of 1e-6 px changes a pixel of
// 1e9 counts by 3e-3 sigma.
class Residuals {
  public:
    // Allocates all memory. Status::argument for a bin that does not divide the frame.
    Residuals(const FrameModel &model, const Preparation &preparation);

    // Adds a frame of the model's shape. Status::argument for a count that is not finite, Status::range for a residual
    // beyond float32, Status::capacity when full; on failure nothing changes. Never allocates memory.
    void push(ImageView<const double> counts);

    // Adds many frames: all of them or, on failure, none.
    void push_many(const PixelFrames &frames, size_t count);

    // Gram matrix [frames][frames]: inner products of the residuals minus their mean, in double. The same bits for any
    // number of workers. `after_own` as in run_jobs().
    Buffer<double> gram(unsigned workers, const std::function<void(double)> &after_own) const;

    // Amplitude (px) of a sinusoid above which the leading principal component of the frames pushed so far correlates
    // with it: crb_px (4 (pixels - projected) / frames)^(1/4), the spiked covariance threshold. +infinity without
    // frames; NaN for raw residuals, whose noise differs from pixel to pixel.
    double threshold_px() const noexcept;

    const Preparation &preparation() const noexcept { return preparation_; }
    size_t rows() const noexcept { return rows_; } // of the frames
    size_t cols() const noexcept { return cols_; }
    size_t pixels() const noexcept { return pixels_; } // after binning
    size_t projected() const noexcept { return projected_; }
    size_t frames() const noexcept { return values_.size() / pixels_; }
    // Cramer-Rao bound of the binned pixels with the projected images free; NaN if raw.
    double crb_px() const noexcept { return crb_px_; }

  private:
    Buffer<double> binned(const Buffer<double> &image) const;
    void whiten(const FrameModel &model);
    Buffer<double> mean() const;

    Preparation preparation_;
    size_t rows_, cols_, pixels_, projected_ = 0;
    double crb_px_;
    Buffer<double> reference_;     // [rows][cols]
    Buffer<double> inverse_sigma_; // [pixels]; empty when raw
    Buffer<double> units_;         // [projected][pixels], orthonormal basis of the whitened nuisance images
    Buffer<double> scratch_;       // [pixels], the frame being pushed
    Buffer<float> values_;         // [frames][pixels]
};

} // namespace toliman::linear
