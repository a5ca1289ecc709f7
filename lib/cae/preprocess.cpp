#include "cae/preprocess.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "cae/layout.hpp"
#include "kernels/narrow.hpp"
#include "kernels/project.hpp"
#include "kernels/residual.hpp"

namespace toliman::cae {

namespace {

constexpr double kLeastLeft = 1e-5; // of the derivative's length; float32 rounding would make 0.6 % of it

// First row (or column) of a crop centred on `centre`, inside 0 ... size.
size_t crop_start(double centre, size_t size) {
    const double start = std::floor(centre - (static_cast<double>(kSide) - 1) / 2 + 0.5);
    return static_cast<size_t>(std::clamp(start, 0.0, static_cast<double>(size - kSide)));
}

void crop_about_barycentre(const FrameModel &model, Preprocess &out) {
    double light = 0, row_moment = 0, col_moment = 0;
    for (size_t r = 0; r < model.rows; r++)
        for (size_t c = 0; c < model.cols; c++) {
            const double counts = model.reference[r * model.cols + c] - model.background;
            light += counts;
            row_moment += counts * static_cast<double>(r);
            col_moment += counts * static_cast<double>(c);
        }
    if (!(light > 0))
        fail(Status::scene, "%s: the reference frame holds no light", model.source.c_str());
    out.crop_row = crop_start(row_moment / light, model.rows);
    out.crop_col = crop_start(col_moment / light, model.cols);
}

Buffer<double> crop(const FrameModel &model, const Buffer<double> &image, const Preprocess &at) {
    Buffer<double> out(kPixels);
    for (size_t r = 0; r < kSide; r++)
        std::copy_n(&image[(at.crop_row + r) * model.cols + at.crop_col], kSide, &out[r * kSide]);
    return out;
}

void round_to_float(Buffer<double> &plane) {
    for (double &value : plane)
        value = static_cast<double>(kernels::to_float32(value));
}

// float32 alone would be 60 counts off at 1e9, two thousandths of a sigma; the sum of two is off by 4e-6 counts.
void round_to_two_floats(Buffer<double> &plane) {
    for (double &value : plane) {
        const double high = static_cast<double>(kernels::to_float32(value));
        value = high + static_cast<double>(kernels::to_float32(value - high));
    }
}

// What the nuisances leave of the derivative must stand above the rounding of their float32 planes.
void check_signal(const Preprocess &preprocess, const std::string &source) {
    Buffer<double> target = preprocess.target;
    const auto [before, left] =
        kernels::project_out_twice(preprocess.units.data(), preprocess.projected, kPixels, target.data());
    if (!(left > kLeastLeft * before))
        fail(Status::scene,
             "%s: {preprocess.project}: the scene tells nothing of the separation: %g of the information of %g px^-2 a "
             "frame is left after it",
             source.c_str(), before > 0 ? left / before * left / before : 0, before * before);
}

} // namespace

Preprocess Preprocess::from_model(const FrameModel &model, Input input) {
    if (model.rows < kSide || model.cols < kSide)
        fail(Status::unsupported, "%s: {detector.shape} = [%zu, %zu]: the network takes at least %zu px either way",
             model.source.c_str(), model.rows, model.cols, kSide);
    if (model.projected.size() > kMaxProjected)
        fail(Status::unsupported, "%s: {preprocess.project}: %zu names: at most %zu can be projected out",
             model.source.c_str(), model.projected.size(), kMaxProjected);
    if (input != Input::whitened && !model.projected.empty())
        fail(Status::unsupported, "%s: {preprocess.project}: only whitened input can be projected",
             model.source.c_str());
    Preprocess out;
    out.input = input;
    out.rows = model.rows;
    out.cols = model.cols;
    out.crb_px = model.crb_px;
    out.scene_digest = model.scene_digest;
    crop_about_barycentre(model, out);
    out.reference = crop(model, model.reference, out);
    round_to_two_floats(out.reference);
    out.variance = crop(model, model.variance, out);
    round_to_float(out.variance);

    out.units.resize(model.projected.size() * kPixels);
    for (size_t k = 0; k < model.projected.size(); k++) {
        const Buffer<double> image = crop(model, model.projected[k].image, out);
        kernels::whiten(image.data(), out.variance.data(), kPixels, &out.units[k * kPixels]);
    }
    out.projected = kernels::orthonormalise(out.units.data(), model.projected.size(), kPixels);
    out.units.resize(out.projected * kPixels);
    out.target = crop(model, model.derivative, out);
    kernels::whiten(out.target.data(), out.variance.data(), kPixels, out.target.data());
    check_signal(out, model.source);

    round_to_float(out.units);
    kernels::project_out(out.units.data(), out.projected, kPixels, out.target.data());
    round_to_float(out.target);
    out.derive();
    return out;
}

void Preprocess::derive() {
    target_square = kernels::residual_kernels().inner(target.data(), target.data(), kPixels);
    offset = reference;
    factor.assign(kPixels, 1.0);
    if (input == Input::whitened)
        return kernels::whiten(factor.data(), variance.data(), kPixels, factor.data());
    if (input == Input::residual) {
        const double sum = std::accumulate(variance.begin(), variance.end(), 0.0);
        factor.assign(kPixels, 1 / std::sqrt(sum / static_cast<double>(kPixels)));
    } else {
        const auto [darkest, brightest] = std::minmax_element(reference.begin(), reference.end());
        const double low = *darkest, range = *brightest - low;
        offset.assign(kPixels, low);
        factor.assign(kPixels, range > 0 ? 1 / range : 1);
    }
}

Preprocess Preprocess::with_input_scale(double scale) const {
    Preprocess out = *this;
    out.input_scale = scale;
    return out;
}

void Preprocess::apply(ImageView<const double> frame, Buffer<double> &residual, float *out, size_t stride) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    residual.resize(projected > 0 ? kPixels : 0);
    for (size_t r = 0; r < kSide; r++) {
        const double *counts = frame.row(crop_row + r) + crop_col;
        const size_t at = r * kSide;
        const bool finite = projected > 0 ? kernel.residual(counts, &offset[at], &factor[at], kSide, &residual[at])
                                          : kernel.scaled_residual(counts, &offset[at], &factor[at], input_scale, kSide,
                                                                   out + r * stride);
        for (size_t c = 0; !finite && c < kSide; c++)
            if (!std::isfinite(counts[c]))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", crop_row + r, crop_col + c,
                     counts[c]);
    }
    if (projected == 0)
        return;
    kernel.project_out(units.data(), projected, kPixels, residual.data());
    for (size_t r = 0; r < kSide; r++)
        for (size_t c = 0; c < kSide; c++)
            out[r * stride + c] = static_cast<float>(input_scale * residual[r * kSide + c]);
}

double Preprocess::chi_square(ImageView<const double> frame, Buffer<double> &residual) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    if (projected == 0) { // else it is as apply() left it
        residual.resize(kPixels);
        for (size_t r = 0; r < kSide; r++) {
            const double *counts = frame.row(crop_row + r) + crop_col;
            for (size_t c = 0; c < kSide; c++)
                residual[r * kSide + c] = counts[c] - reference[r * kSide + c];
        }
        kernels::whiten(residual.data(), variance.data(), kPixels, residual.data());
    }
    const double along = target_square > 0 ? kernel.inner(target.data(), residual.data(), kPixels) : 0;
    const double left = kernel.inner(residual.data(), residual.data(), kPixels) -
                        (target_square > 0 ? along / target_square * along : 0);
    if (!std::isfinite(left))
        return std::numeric_limits<double>::infinity();
    return std::max(left, 0.0) / static_cast<double>(kPixels - projected - (target_square > 0 ? 1 : 0));
}

uint64_t Preprocess::digest() const noexcept {
    uint64_t hash = fnv1a(with_bits<uint64_t>(input_scale), kFnvOffset);
    for (const size_t number : {rows, cols, crop_row, crop_col, projected, static_cast<size_t>(input)})
        hash = fnv1a(number, hash);
    for (const Buffer<double> *plane : {&reference, &variance, &units})
        hash = fnv1a(*plane, hash);
    return hash;
}

void Preprocess::to_counts(double *image) const noexcept {
    for (size_t i = 0; i < kPixels; i++)
        image[i] = offset[i] + image[i] / factor[i];
}

} // namespace toliman::cae
