// The template estimator: weighted least squares of a frame's residual on the separation derivative.
#pragma once
#include "base/view.hpp"
#include "frame/bad_pixels.hpp"
#include "frame/detector_window.hpp"
#include "frame/frame_model.hpp"
#include "frame/pixel.hpp"

namespace toliman::linear {

// Working memory of one thread: TemplateEstimator::work().
struct TemplateWork {
    Buffer<double> residual; // whitened; [rows*cols], rounded up
    Buffer<double> repaired; // [rows][cols], of frames with bad pixels; allocated for the first one
};

// Estimates the displacement from a frame (method: template.cpp). Const calls may run on several threads.
class TemplateEstimator {
  public:
    // Status::scene if the derivative lies in the span of the nuisance images.
    explicit TemplateEstimator(const FrameModel &model);

    TemplateWork work() const;
    // Estimated displacement (px) of a frame of the model's shape, without its bad pixels (frame/bad_pixels.hpp) that
    // are beyond 6 standard deviations of the reference, too. *goodness, unless NULL: of the fit of derivative and
    // nuisances; chi_square is +infinity on overflow. window: of the frame, if it is known.
    double estimate(ImageView<const double> counts, TemplateWork &work, FrameGoodness *goodness,
                    const std::optional<DetectorWindow> &window = {}) const;

    // The same for many frames: values [count], and goodness [count] unless NULL.
    void estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                       FrameGoodness *goodness) const;

    // FNV-1a of everything that determines the estimates.
    uint64_t digest() const noexcept;

    // Standard deviation of an estimate (px): the Cramer-Rao bound with the nuisances free.
    double sigma_px() const noexcept { return sigma_px_; }

    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }

  private:
    // Of a residual that is fitted: the sum of squares, the largest magnitude and, if a pixel is far, the largest
    // excess_of().
    struct Fitted {
        double square, most, excess;
    };
    double freedom(size_t bad_pixels) const noexcept {
        return static_cast<double>(noise_.used - bad_pixels - rank_ - 1);
    }
    double value_of(ImageView<const double> counts, double *residual, size_t stride, double &most) const;
    Fitted fit(bool far, Buffer<double> &residual) const;
    bool repair(ImageView<const double> counts, TemplateWork &work, BadPixels &bad, Fitted &fitted,
                double &value) const;
    bool lower(const BadPixels &bad, TemplateWork &work) const;
    FrameGoodness goodness_of(const Fitted &fitted, size_t bad_pixels, bool repairable) const noexcept;

    size_t rows_, cols_;
    Buffer<double> reference_;
    Buffer<double> filter_; // px per count
    Buffer<double> inverse_sigma_;
    PixelNoise noise_;
    std::optional<DetectorWindow> window_;
    KnownBadPixels known_bad_;
    size_t rank_, padded_; // independent nuisances; pixels rounded up to a multiple of 16
    Buffer<double> units_; // [rank + 1][padded], orthonormal basis of the whitened nuisance images, then the whitened
                           // derivative orthogonal to them; 0 beyond the pixels
    double sigma_px_;
};

} // namespace toliman::linear
