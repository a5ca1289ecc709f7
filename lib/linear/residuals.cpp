// Method: blocks of bin x bin pixels are summed, and each sum is whitened as one pixel: x = (sum of counts - sum of
// the reference)/sqrt(sum of the variances). Nuisance images are binned and whitened likewise, orthonormalised, and
// projected out of every frame: x <- x - sum_k <u_k, x> u_k. The bound of a binned frame is 1/|g - P g|, as in
// information/information.cpp, with the binned and whitened derivative g.
// Why: binning first reduces the noise dimension p and with it the threshold of PCA, crb sqrt(2 sqrt(p/N)). Residuals
// are stored as float32: 6e-8 of a residual of order 1, against raw counts of 1e9 that would lose the signal.
#include "linear/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "kernels/project.hpp"

namespace toliman::linear {

namespace {

// Adds one row of pixels to a row of blocks, out [cols/bin]; value(c) is that of column c.
template <class Value> void add_row(size_t cols, size_t bin, double *out, Value value) {
    for (size_t c = 0; c < cols; c += bin, out++)
        for (size_t i = 0; i < bin; i++)
            *out += value(c + i);
}

} // namespace

Residuals::Residuals(const FrameModel &model, const Preparation &preparation)
    : preparation_(preparation), rows_(model.rows), cols_(model.cols),
      pixels_(model.rows * model.cols / (preparation.bin * preparation.bin)),
      crb_px_(std::numeric_limits<double>::quiet_NaN()), reference_(model.reference) {
    if (rows_ % preparation.bin != 0 || cols_ % preparation.bin != 0)
        fail(Status::argument, "{options->bin} = %zu: must divide the frame's %zu rows and %zu columns",
             preparation.bin, rows_, cols_);
    if (!preparation.raw)
        whiten(model);
    scratch_.resize(pixels_);
    values_.reserve(checked_product(preparation.capacity, pixels_, "frames"));
}

Buffer<double> Residuals::binned(const Buffer<double> &image) const {
    Buffer<double> out(pixels_);
    for (size_t r = 0; r < rows_; r++)
        add_row(cols_, preparation_.bin, &out[r / preparation_.bin * (cols_ / preparation_.bin)],
                [&](size_t c) { return image[r * cols_ + c]; });
    return out;
}

// A block of pixels is whitened as one larger pixel: the variance of its sum is the sum of the pixels' variances.
void Residuals::whiten(const FrameModel &model) {
    const Buffer<double> variance = binned(model.variance);
    inverse_sigma_.assign(pixels_, 1.0);
    kernels::whiten(inverse_sigma_.data(), variance.data(), pixels_, inverse_sigma_.data());

    units_.resize(checked_product(model.projected.size(), pixels_, "projected images"));
    for (size_t k = 0; k < model.projected.size(); k++)
        kernels::whiten(binned(model.projected[k].image).data(), variance.data(), pixels_, &units_[k * pixels_]);
    projected_ = kernels::orthonormalise(units_.data(), model.projected.size(), pixels_);
    units_.resize(projected_ * pixels_);

    Buffer<double> signal = binned(model.derivative);
    kernels::whiten(signal.data(), variance.data(), pixels_, signal.data());
    crb_px_ = 1 / kernels::project_out_twice(units_.data(), projected_, pixels_, signal.data()).after;
}

void Residuals::push(ImageView<const double> counts) {
    if (frames() == preparation_.capacity)
        fail(Status::capacity, "{capacity} = %zu: %zu frames have been pushed, no more can be added",
             preparation_.capacity, frames());
    std::fill(scratch_.begin(), scratch_.end(), 0.0);
    for (size_t r = 0; r < rows_; r++) {
        const double *const row = counts.row(r), *const reference = &reference_[r * cols_];
        for (size_t c = 0; c < cols_; c++)
            if (!std::isfinite(row[c]))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", r, c, row[c]);
        add_row(cols_, preparation_.bin, &scratch_[r / preparation_.bin * (cols_ / preparation_.bin)],
                [&](size_t c) { return row[c] - reference[c]; });
    }
    if (!preparation_.raw) {
        for (size_t p = 0; p < pixels_; p++)
            scratch_[p] *= inverse_sigma_[p];
        kernels::project_out(units_.data(), projected_, pixels_, scratch_.data());
    }
    for (const double value : scratch_)
        if (!(std::fabs(value) <= std::numeric_limits<float>::max()))
            fail(Status::range, "{counts} differ from the scene's reference by %g: must be at most %g%s", value,
                 static_cast<double>(std::numeric_limits<float>::max()), preparation_.raw ? "" : " sigmas");
    values_.resize(values_.size() + pixels_);
    std::transform(scratch_.begin(), scratch_.end(), values_.end() - static_cast<ptrdiff_t>(pixels_),
                   [](double value) { return static_cast<float>(value); });
}

void Residuals::push_many(const PixelFrames &images, size_t count) {
    if (count > preparation_.capacity - frames())
        fail(Status::capacity, "{count} = %zu: must be at most %zu: %zu of %zu frames have been pushed", count,
             preparation_.capacity - frames(), frames(), preparation_.capacity);
    const size_t before = values_.size();
    Buffer<double> converted;
    try {
        for (size_t i = 0; i < count; i++)
            in_frame(i, [&] { push(images.frame(i, converted)); });
    } catch (...) {
        values_.resize(before);
        throw;
    }
}

double Residuals::threshold_px() const noexcept {
    const double per_frame = static_cast<double>(pixels_ - projected_) / static_cast<double>(frames());
    return crb_px_ * std::sqrt(2 * std::sqrt(per_frame));
}

} // namespace toliman::linear
