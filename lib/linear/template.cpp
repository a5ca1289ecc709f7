// Method: weighted least squares. With sigma the standard deviation of each pixel, r = (frame - reference) / sigma the
// whitened residual and w = (d reference / d separation) / sigma made orthogonal to the whitened nuisance images,
//     estimate = <w, r> / <w, w>,   sigma_px = 1 / |w|.
// It is unbiased, insensitive to the nuisances, and has the least variance of all linear unbiased estimators
// (Gauss-Markov); to first order in the displacement it reaches the Cramer-Rao bound (measured 6.11e-6 px against
// 6.07e-6). Because w is orthogonal to the nuisances, they need not be fitted: one dot product with the filter
// w / (sigma |w|^2) estimates a frame. Dot products are compensated (kernels/project.hpp), because the signal is 1e-6
// of a pixel.
#include "linear/template.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/estimates.hpp"
#include "base/hash.hpp"
#include "kernels/project.hpp"
#include "kernels/residual.hpp"

namespace toliman::linear {

namespace {

constexpr size_t kStep = 16; // the residual kernels take multiples of this

} // namespace

TemplateEstimator::TemplateEstimator(const FrameModel &model)
    : rows_(model.rows), cols_(model.cols), reference_(model.reference), filter_(model.reference.size()),
      inverse_sigma_(model.reference.size(), 1.0), padded_((reference_.size() + kStep - 1) / kStep * kStep) {
    const size_t pixels = reference_.size(), nuisances = model.projected.size();
    Buffer<double> units(checked_product(nuisances, pixels, "projected images"));
    for (size_t k = 0; k < nuisances; k++)
        kernels::whiten(model.projected[k].image.data(), model.variance.data(), pixels, units.data() + k * pixels);
    const size_t rank = rank_ = kernels::orthonormalise(units.data(), nuisances, pixels);
    kernels::whiten(inverse_sigma_.data(), model.variance.data(), pixels, inverse_sigma_.data());
    units_.resize(checked_product(rank, padded_, "projected images"));
    for (size_t k = 0; k < rank; k++)
        std::copy_n(&units[k * pixels], pixels, &units_[k * padded_]);

    kernels::whiten(model.derivative.data(), model.variance.data(), pixels, filter_.data());
    const auto [before, remaining] = kernels::project_out_twice(units.data(), rank, pixels, filter_.data());
    if (remaining == 0)
        fail(Status::scene,
             "%s: {preprocess.project}: the projection leaves no information about the separation: 0 of %g px^-2 "
             "per frame",
             model.source.c_str(), before * before);

    for (size_t i = 0; i < pixels; i++)
        filter_[i] /= std::sqrt(model.variance[i]) * remaining * remaining;
    sigma_px_ = 1 / remaining;
}

double TemplateEstimator::estimate(ImageView<const double> counts) const {
    const kernels::ProjectKernels &kernel = kernels::project_kernels();
    kernels::Dot dot;
    for (size_t r = 0; r < rows_; r++) {
        const double *row = counts.row(r);
        const bool finite = kernel.add_difference(row, &reference_[r * cols_], &filter_[r * cols_], cols_, dot);
        for (size_t c = 0; !finite && c < cols_; c++)
            if (!std::isfinite(row[c]))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", r, c, row[c]);
    }
    return dot.total();
}

double TemplateEstimator::estimate(ImageView<const double> counts, Buffer<double> &scratch, double *square) const {
    const double value = estimate(counts);
    if (square != nullptr)
        *square = chi_square(counts, value, scratch);
    return value;
}

void TemplateEstimator::estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                                      double *chi_square) const {
    toliman::estimate_many<Buffer<double>>(frames, count, 1, workers, values, chi_square,
                                           [this](const ImageView<const double> *frame, size_t, Buffer<double> &scratch,
                                                  double *value,
                                                  double *square) { *value = estimate(*frame, scratch, square); });
}

// The residual's component along the unit vector w/|w| is value/sigma_px; its square is subtracted from that of the
// projected residual.
double TemplateEstimator::chi_square(ImageView<const double> counts, double value, Buffer<double> &scratch) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    const size_t pixels = reference_.size();
    scratch.resize(padded_);
    for (size_t r = 0; r < rows_; r++)
        kernel.residual(counts.row(r), &reference_[r * cols_], &inverse_sigma_[r * cols_], cols_, &scratch[r * cols_]);
    std::fill(scratch.begin() + static_cast<ptrdiff_t>(pixels), scratch.end(), 0.0);
    kernel.project_out(units_.data(), rank_, padded_, scratch.data());
    const double component = value / sigma_px_;
    const double square = kernel.inner(scratch.data(), scratch.data(), padded_) - component * component;
    if (!std::isfinite(square))
        return std::numeric_limits<double>::infinity();
    return std::max(square, 0.0) / static_cast<double>(pixels - rank_ - 1);
}

uint64_t TemplateEstimator::digest() const noexcept {
    return fnv1a(filter_, fnv1a(reference_, fnv1a(rows_, fnv1a(cols_, kFnvOffset))));
}

} // namespace toliman::linear
