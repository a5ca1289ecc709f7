// Method: weighted least squares. With sigma the standard deviation of each pixel, r = (frame - reference) / sigma the
// whitened residual and w = (d reference / d separation) / sigma made orthogonal to the whitened nuisance images,
//     estimate = <w, r> / <w, w>,   sigma_px = 1 / |w|.
// It is unbiased, insensitive to the nuisances, and has the least variance of all linear unbiased estimators
// (Gauss-Markov); to first order in the displacement it reaches the Cramer-Rao bound (measured 6.11e-6 px against
// 6.07e-6). Because w is orthogonal to the nuisances, they need not be fitted: one dot product with the filter
// w / (sigma |w|^2) estimates a frame. Dot products are compensated (kernels/project.hpp), because the signal is 1e-6
// of a pixel.
// Bad pixels are those of the residual after the fit of nuisances and derivative. Their counts are replaced by what the
// fit to all other pixels predicts (frame/deleted_residuals.hpp), so that the estimate is that of the other pixels
// alone, exactly.
#include "linear/template.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "frame/deleted_residuals.hpp"
#include "frame/estimates.hpp"
#include "kernels/project.hpp"
#include "kernels/residual.hpp"

namespace toliman::linear {

namespace {

constexpr size_t kStep = 16; // the residual kernels take multiples of this

} // namespace

TemplateEstimator::TemplateEstimator(const FrameModel &model)
    : rows_(model.rows), cols_(model.cols), reference_(model.reference), filter_(model.reference.size()),
      inverse_sigma_(model.reference.size(), 1.0), noise_(model.reference, model.variance), window_(model.window),
      known_bad_(model.rows, model.cols, model.variance, model.window),
      padded_((reference_.size() + kStep - 1) / kStep * kStep) {
    const size_t pixels = reference_.size(), nuisances = model.projected.size();
    Buffer<double> units(checked_product(nuisances, pixels, "projected images"));
    for (size_t k = 0; k < nuisances; k++)
        kernels::whiten(model.projected[k].image.data(), model.variance.data(), pixels, units.data() + k * pixels);
    const size_t rank = rank_ = kernels::orthonormalise(units.data(), nuisances, pixels);
    kernels::whiten(inverse_sigma_.data(), model.variance.data(), pixels, inverse_sigma_.data());
    units_.resize(checked_product(rank + 1, padded_, "projected images"));
    for (size_t k = 0; k < rank; k++)
        std::copy_n(&units[k * pixels], pixels, &units_[k * padded_]);

    kernels::whiten(model.derivative.data(), model.variance.data(), pixels, filter_.data());
    const auto [before, remaining] = kernels::project_out_twice(units.data(), rank, pixels, filter_.data());
    if (remaining == 0)
        fail(Status::scene,
             "%s: {preprocess.project}: the projection leaves no information about the separation: 0 of %g px^-2 "
             "per frame",
             model.source.c_str(), before * before);

    for (size_t i = 0; i < pixels; i++) {
        units_[rank * padded_ + i] = filter_[i] / remaining;
        filter_[i] /= std::sqrt(model.variance[i]) * remaining * remaining;
    }
    sigma_px_ = 1 / remaining;
}

TemplateWork TemplateEstimator::work() const {
    return {Buffer<double>(padded_), {}};
}

// The estimate of all pixels, and the residual against the reference: row r begins at residual + r stride. *most: its
// largest magnitude.
double TemplateEstimator::value_of(ImageView<const double> counts, double *residual, size_t stride,
                                   double &most) const {
    const kernels::ProjectKernels &project = kernels::project_kernels();
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    kernels::Dot dot;
    most = 0;
    for (size_t r = 0; r < rows_; r++) {
        const double *row = counts.row(r), *const expected = &reference_[r * cols_];
        const bool finite = project.add_difference(row, expected, &filter_[r * cols_], cols_, dot);
        for (size_t c = 0; !finite && c < cols_; c++)
            if (!std::isfinite(row[c]))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", r, c, row[c]);
        kernel.residual(row, expected, &inverse_sigma_[r * cols_], cols_, residual + r * stride);
        most = kernel.magnitude(residual + r * stride, cols_, most);
    }
    return dot.total();
}

// Fits a whole residual, whose rows follow each other. far: whether the excess is needed.
TemplateEstimator::Fitted TemplateEstimator::fit(bool far, Buffer<double> &residual) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    Fitted fitted = {};
    std::fill(residual.begin() + static_cast<ptrdiff_t>(reference_.size()), residual.end(), 0.0);
    kernel.project_out(units_.data(), rank_ + 1, padded_, residual.data());
    fitted.square = kernel.inner(residual.data(), residual.data(), padded_);
    if (far)
        kernel.largest(residual.data(), noise_.tail.data(), reference_.size(), &fitted.most, &fitted.excess);
    else
        fitted.most = kernel.magnitude(residual.data(), reference_.size(), 0);
    return fitted;
}

// Replaces the counts of the bad pixels by those that the fit to the others predicts; work.residual is that of the fit.
bool TemplateEstimator::lower(const BadPixels &bad, TemplateWork &work) const {
    const size_t columns = rank_ + 1;
    double units[kMostBadPixels * (kMaxProjected + 1)], residual[kMostBadPixels], deleted[kMostBadPixels];
    for (size_t i = 0; i < bad.count(); i++) {
        residual[i] = work.residual[bad[i]];
        for (size_t k = 0; k < columns; k++)
            units[i * columns + k] = units_[k * padded_ + bad[i]];
    }
    if (!deleted_residuals(units, columns, bad.count(), residual, deleted))
        return false;
    for (size_t i = 0; i < bad.count(); i++)
        work.repaired[bad[i]] -= deleted[i] / inverse_sigma_[bad[i]];
    return true;
}

// False if there are too many bad pixels.
bool TemplateEstimator::repair(ImageView<const double> counts, TemplateWork &work, BadPixels &bad, Fitted &fitted,
                               double &value) const {
    work.repaired.resize(reference_.size());
    for (size_t r = 0; r < rows_; r++)
        std::copy_n(counts.row(r), cols_, &work.repaired[r * cols_]);
    bool known = bad.count() > 0; // those are replaced before others are searched for
    for (double most;; known = false) {
        const BadPixels::Found found =
            known ? BadPixels::Found::some
                  : bad.add_largest(reference_.size(), fitted.square, freedom(bad.count()),
                                    [&](size_t i) { return excess_of(work.residual[i], noise_.tail[i]); });
        if (found == BadPixels::Found::none)
            return true;
        if (found == BadPixels::Found::too_many || !lower(bad, work))
            return false;
        value = value_of({work.repaired.data(), rows_, cols_, cols_}, work.residual.data(), cols_, most);
        fitted = fit(true, work.residual);
    }
}

FrameGoodness TemplateEstimator::goodness_of(const Fitted &fitted, size_t bad_pixels, bool repairable) const noexcept {
    const double left = freedom(bad_pixels);
    return frame_goodness(fitted.square / left, chi_square_sigma(noise_.used - bad_pixels, noise_.inverse_counts, left),
                          fitted.most, bad_pixels, repairable);
}

// Most frames need no residual: it is then overwritten row by row.
double TemplateEstimator::estimate(ImageView<const double> counts, TemplateWork &work, FrameGoodness *goodness,
                                   const std::optional<DetectorWindow> &window) const {
    double most, *const residual = work.residual.data();
    double value = value_of(counts, residual, goodness != nullptr ? cols_ : 0, most);
    BadPixels bad;
    bool repairable = known_bad_.add(window, bad);
    const bool far = most > kBadPixelSigmas || bad.count() > 0;
    if (goodness == nullptr && !far)
        return value;
    if (goodness == nullptr)
        value = value_of(counts, residual, cols_, most);
    Fitted fitted = fit(far, work.residual);
    if (repairable && (fitted.excess > kBadPixelLimit || bad.count() > 0)) {
        Fitted without = fitted;
        double repaired = value;
        repairable = repair(counts, work, bad, without, repaired);
        if (repairable) {
            fitted = without;
            value = repaired;
        }
    }
    if (!repairable)
        bad.clear();
    if (goodness != nullptr)
        *goodness = goodness_of(fitted, bad.count(), repairable);
    return value;
}

void TemplateEstimator::estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values,
                                      FrameGoodness *goodness) const {
    toliman::estimate_many(
        frames, count, 1, workers, values, goodness, [this] { return work(); },
        [this, &frames](const ImageView<const double> *frame, size_t i, size_t, TemplateWork &work, double *value,
                        FrameGoodness *of_frame) { *value = estimate(*frame, work, of_frame, frames.window(i)); });
}

uint64_t TemplateEstimator::digest() const noexcept {
    const uint64_t hash = fnv1a(filter_, fnv1a(reference_, fnv1a(rows_, fnv1a(cols_, kFnvOffset))));
    return window_ ? fnv1a(static_cast<uint64_t>(window_->row), fnv1a(static_cast<uint64_t>(window_->col), hash))
                   : hash;
}

} // namespace toliman::linear
