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

constexpr size_t kStep = 16; // of the residual kernels' sums

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
    const auto [before, left] = kernels::project_out_twice(units.data(), rank, pixels, filter_.data());
    if (left == 0)
        fail(Status::scene,
             "%s: {preprocess.project}: the scene tells nothing of the separation: nothing of the information of %g "
             "px^-2 "
             "a frame is left after it",
             model.source.c_str(), before * before);

    for (size_t i = 0; i < pixels; i++)
        filter_[i] /= std::sqrt(model.variance[i]) * left * left;
    sigma_px_ = 1 / left;
}

double TemplateEstimator::estimate(ImageView<const double> counts) const {
    Buffer<double> residual(reference_.size());
    return estimate(counts, residual.data());
}

double TemplateEstimator::estimate(ImageView<const double> counts, double *residual) const {
    for (size_t r = 0; r < rows_; r++) {
        const double *row = counts.row(r), *reference = reference_.data() + r * cols_;
        for (size_t c = 0; c < cols_; c++) {
            if (!std::isfinite(row[c]))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", r, c, row[c]);
            residual[r * cols_ + c] = row[c] - reference[c];
        }
    }
    return kernels::dot(filter_.data(), residual, reference_.size());
}

double TemplateEstimator::estimate(ImageView<const double> counts, Buffer<double> &scratch, double *square) const {
    scratch.resize(padded_);
    const double value = estimate(counts, scratch.data());
    if (square != nullptr)
        *square = chi_square(counts, value, scratch);
    return value;
}

void TemplateEstimator::estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                                      double *chi_square) const {
    toliman::estimate_many<Buffer<double>>(frames, count, workers, values, chi_square,
                                           [this](ImageView<const double> counts, Buffer<double> &scratch,
                                                  double *square) { return estimate(counts, scratch, square); });
}

// The value's component along the derivative of unit length is value/sigma_px.
double TemplateEstimator::chi_square(ImageView<const double> counts, double value, Buffer<double> &scratch) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    const size_t pixels = reference_.size();
    scratch.resize(padded_);
    for (size_t r = 0; r < rows_; r++)
        kernel.residual(counts.row(r), &reference_[r * cols_], &inverse_sigma_[r * cols_], cols_, &scratch[r * cols_]);
    std::fill(scratch.begin() + static_cast<ptrdiff_t>(pixels), scratch.end(), 0.0);
    kernel.project_out(units_.data(), rank_, padded_, scratch.data());
    const double component = value / sigma_px_;
    const double left = kernel.inner(scratch.data(), scratch.data(), padded_) - component * component;
    if (!std::isfinite(left))
        return std::numeric_limits<double>::infinity();
    return std::max(left, 0.0) / static_cast<double>(pixels - rank_ - 1);
}

uint64_t TemplateEstimator::digest() const noexcept {
    return fnv1a(filter_, fnv1a(reference_, fnv1a(rows_, fnv1a(cols_, kFnvOffset))));
}

} // namespace toliman::linear
