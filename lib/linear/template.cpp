#include "linear/template.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "kernels/project.hpp"

namespace toliman::linear {

TemplateEstimator::TemplateEstimator(const FrameModel &model)
    : rows_(model.rows), cols_(model.cols), reference_(model.reference), filter_(model.reference.size()) {
    const size_t pixels = reference_.size(), nuisances = model.projected.size();
    Buffer<double> units(checked_product(nuisances, pixels, "projected images"));
    for (size_t k = 0; k < nuisances; k++)
        kernels::whiten(model.projected[k].image.data(), model.variance.data(), pixels, units.data() + k * pixels);
    const size_t rank = kernels::orthonormalise(units.data(), nuisances, pixels);

    kernels::whiten(model.derivative.data(), model.variance.data(), pixels, filter_.data());
    const auto [before, left] = kernels::project_out_twice(units.data(), rank, pixels, filter_.data());
    if (left == 0)
        fail(
            Status::scene,
            "%s: preprocess.project: the scene tells nothing of the separation: nothing of the information of %g px^-2 "
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
                fail(Status::argument, "counts[%zu][%zu] = %g: must be finite", r, c, row[c]);
            residual[r * cols_ + c] = row[c] - reference[c];
        }
    }
    return kernels::dot(filter_.data(), residual, reference_.size());
}

uint64_t TemplateEstimator::digest() const noexcept {
    return fnv1a(filter_, fnv1a(reference_, fnv1a(rows_, fnv1a(cols_, kFnvOffset))));
}

} // namespace toliman::linear
