// The template estimator: weighted least squares of a frame's residual on the separation derivative.
#pragma once
#include "base/buffer.hpp"
#include "base/frame_model.hpp"
#include "base/pixel.hpp"
#include "base/view.hpp"

namespace toliman::linear {

// Estimates the displacement from a frame (method: template.cpp). Const calls may run on several threads.
class TemplateEstimator {
  public:
    // Status::scene if the derivative lies in the span of the nuisance images.
    explicit TemplateEstimator(const FrameModel &model);

    // Estimated displacement (px) of a frame of the model's shape.
    double estimate(ImageView<const double> counts) const;
    // The same, and *chi_square unless NULL. Allocates nothing if scratch has a capacity of scratch_size() numbers.
    double estimate(ImageView<const double> counts, Buffer<double> &scratch, double *chi_square) const;
    size_t scratch_size() const noexcept { return padded_; }

    // The same for many frames: values [count], and chi_square [count] unless NULL.
    void estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                       double *chi_square) const;

    // Reduced chi-square of the fit of derivative and nuisances to counts whose estimate is `value`,
    // |r - sum_k <u_k, r> u_k - value w|^2 / (pixels - nuisances - 1), r the whitened residual, u_k the orthonormal
    // whitened nuisances and w the whitened derivative orthogonal to them; +infinity on overflow. Relative error: 1e-12
    // times |r|^2 over the numerator.
    double chi_square(ImageView<const double> counts, double value, Buffer<double> &scratch) const;

    // FNV-1a of everything that determines the estimates.
    uint64_t digest() const noexcept;

    // Standard deviation of an estimate (px): the Cramer-Rao bound with the nuisances free.
    double sigma_px() const noexcept { return sigma_px_; }

    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }

  private:
    size_t rows_, cols_;
    Buffer<double> reference_;
    Buffer<double> filter_; // px per count
    Buffer<double> inverse_sigma_;
    size_t rank_, padded_; // independent nuisances; pixels rounded up to a multiple of 16
    Buffer<double> units_; // [rank][padded], orthonormal basis of the whitened nuisance images, 0 beyond the pixels
    double sigma_px_;
};

} // namespace toliman::linear
