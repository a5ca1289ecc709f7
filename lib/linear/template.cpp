#include "linear/template.hpp"

#include <cmath>

#include "base/error.hpp"
#include "kernels/project.hpp"

namespace toliman::linear {

namespace {

// 1/sigma of each pixel. One without variance has no light either: it carries no information, not an infinity of it.
Buffer<double> inverse_sigmas(const Buffer<double> &variance) {
    Buffer<double> inverse(variance.size());
    for (size_t i = 0; i < variance.size(); i++)
        inverse[i] = variance[i] > 0 ? 1.0 / std::sqrt(variance[i]) : 0.0;
    return inverse;
}

void multiply(const Buffer<double> &factor, const double *image, double *out) {
    for (size_t i = 0; i < factor.size(); i++)
        out[i] = image[i] * factor[i];
}

} // namespace

TemplateEstimator::TemplateEstimator(const FrameModel &model)
    : rows_(model.rows), cols_(model.cols), reference_(model.reference), filter_(model.reference.size()) {
    const size_t pixels = reference_.size(), nuisances = model.projected.size();
    const Buffer<double> inverse_sigma = inverse_sigmas(model.variance);

    Buffer<double> units(checked_product(nuisances, pixels, "projected images"));
    for (size_t k = 0; k < nuisances; k++)
        multiply(inverse_sigma, model.projected[k].image.data(), units.data() + k * pixels);
    const size_t rank = kernels::orthonormalise(units.data(), nuisances, pixels);

    multiply(inverse_sigma, model.derivative.data(), filter_.data());
    const double before = kernels::dot(filter_.data(), filter_.data(), pixels);
    // Twice, as the first pass leaves its own rounding behind.
    kernels::project_out(units.data(), rank, pixels, filter_.data());
    kernels::project_out(units.data(), rank, pixels, filter_.data());
    const double information = kernels::dot(filter_.data(), filter_.data(), pixels);
    if (!(information > 1e-20 * before))
        fail(Status::scene,
             "the scene tells nothing of the separation: information %g px^-2 a frame, %g before "
             "preprocess.project",
             information, before);

    for (size_t i = 0; i < pixels; i++)
        filter_[i] *= inverse_sigma[i] / information;
    sigma_px_ = 1.0 / std::sqrt(information);
}

double TemplateEstimator::estimate(ImageView<const double> counts) const {
    Buffer<double> residual(reference_.size());
    for (size_t r = 0; r < rows_; r++) {
        const double *row = counts.row(r), *reference = reference_.data() + r * cols_;
        for (size_t c = 0; c < cols_; c++) {
            if (!std::isfinite(row[c]))
                fail(Status::argument, "counts[%zu][%zu] = %g: must be finite", r, c, row[c]);
            residual[r * cols_ + c] = row[c] - reference[c];
        }
    }
    return kernels::dot(filter_.data(), residual.data(), residual.size());
}

} // namespace toliman::linear
