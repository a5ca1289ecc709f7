// The template estimator: weighted least squares of a frame's residual on the separation derivative.
#pragma once
#include "base/buffer.hpp"
#include "base/frame_model.hpp"
#include "base/pixel.hpp"
#include "base/view.hpp"

namespace toliman::linear {

// With w the derivative over each pixel's sigma, made orthogonal to the whitened nuisance images, and r the residual
// over sigma, the estimate is <w, r> / <w, w>. It is unbiased, blind to the nuisances, and of least variance among the
// linear ones (Gauss-Markov). Const calls may run on several threads.
class TemplateEstimator {
  public:
    // Status::scene when nothing of the derivative is left beside the nuisances.
    explicit TemplateEstimator(const FrameModel &model);

    // Displacement (px) that the counts show; they have the model's shape.
    double estimate(ImageView<const double> counts) const;
    // The same without an allocation where scratch has room for scratch_size() numbers, and chi_square unless NULL.
    double estimate(ImageView<const double> counts, Buffer<double> &scratch, double *chi_square) const;
    size_t scratch_size() const noexcept { return padded_; }

    // The same of many frames, and chi_square [count] of each unless NULL.
    void estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                       double *chi_square) const;

    // Mean square per degree of freedom of what the fit of derivative and nuisances leaves of the whitened residual,
    // |r - sum_k <u_k, r> u_k - value w|^2/(pixels - nuisances - 1), of counts with that value; +infinity where it
    // overflows. Its relative error is 1e-12 |r|^2/(what is left).
    double chi_square(ImageView<const double> counts, double value, Buffer<double> &scratch) const;

    // FNV-1a of the numbers that make the values.
    uint64_t digest() const noexcept;

    // Its standard deviation (px): the Cramer-Rao bound with the nuisances free.
    double sigma_px() const noexcept { return sigma_px_; }

    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }

  private:
    double estimate(ImageView<const double> counts, double *residual) const;

    size_t rows_, cols_;
    Buffer<double> reference_;
    Buffer<double> filter_; // px per count
    Buffer<double> inverse_sigma_;
    size_t rank_, padded_; // of nuisances; pixels up to a multiple of 16
    Buffer<double> units_; // [rank][padded], whitened nuisance images, orthonormal, 0 beyond the pixels
    double sigma_px_;
};

} // namespace toliman::linear
