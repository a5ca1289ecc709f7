// Method: with counts n, reference frame m, variance v and an orthonormal basis u_k of the whitened nuisance images,
//     r = (n - m)/sqrt(v),    input = input_scale (r - sum_k <u_k, r> u_k)
// over a crop centred on the barycentre of the reference, or moved with the light of each frame. After
// whitening every pixel has unit noise, so that the best linear estimate of a small displacement is the inner product
// with the whitened derivative image (matched filter). Projecting the nuisances (fluxes, common shift, ...) out makes
// the latent insensitive to them to first order; the price is the larger Cramer-Rao bound with these parameters free.
//
// Precision: the residual is formed in double, and only the residual is rounded to float32, so that the rounding is
// relative to the noise, not to the counts. float32 values near 1e9 counts are 64 counts apart, and a rounded reference
// would shift every latent by the same error. The reference is therefore stored as the sum of two float32. The
// projection is computed in double from the rounded residual. What the rounding of a component leaves lies along the
// basis, to which the target is orthogonal.
#include "cae/preprocess.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "cae/layout.hpp"
#include "frame/deleted_residuals.hpp"
#include "kernels/half_precision.hpp"
#include "kernels/project.hpp"
#include "kernels/residual.hpp"

namespace toliman::cae {

namespace {

constexpr double kLittle = 0.05; // standard deviations of a pixel

// Smallest remainder of the derivative, as a fraction of its norm. float32 rounding of the planes is 0.6 % of it.
constexpr double kMinRemainder = 1e-5;

// First row (or column) of a crop centred on `centre` that lies within 0 ... size.
size_t crop_start(double centre, size_t size, size_t side) {
    const double start = std::floor(centre - (static_cast<double>(side) - 1) / 2 + 0.5);
    return static_cast<size_t>(std::clamp(start, 0.0, static_cast<double>(size - side)));
}

// Barycentre of the counts above the background; none without light.
std::optional<Barycentre> barycentre_of(const ImageView<const double> &image, double background) {
    double flux = 0, row_moment = 0, col_moment = 0;
    for (size_t r = 0; r < image.rows; r++)
        for (size_t c = 0; c < image.cols; c++) {
            const double counts = image.row(r)[c] - background;
            flux += counts;
            row_moment += counts * static_cast<double>(r);
            col_moment += counts * static_cast<double>(c);
        }
    if (!(flux > 0))
        return {};
    return Barycentre{row_moment / flux, col_moment / flux};
}

constexpr int kMostMoves = 16; // of a crop to the light

// The start of a crop that follows the light: moved by whole pixels, but not beyond the frame.
size_t moved_start(size_t start, double by, size_t most) {
    return static_cast<size_t>(std::clamp(static_cast<double>(start) + std::round(by), 0.0, static_cast<double>(most)));
}

void crop_about_barycentre(const FrameModel &model, Preprocess &out) {
    const std::optional<Barycentre> light =
        barycentre_of({model.reference.data(), model.rows, model.cols, model.cols}, model.background);
    if (!light)
        fail(Status::scene, "%s: the reference frame has no counts above the background", model.source.c_str());
    out.crop_row = crop_start(light->row, model.rows, out.side);
    out.crop_col = crop_start(light->col, model.cols, out.side);
}

Buffer<double> crop(const FrameModel &model, const Buffer<double> &image, const Preprocess &at) {
    Buffer<double> out(at.pixels());
    for (size_t r = 0; r < at.side; r++)
        std::copy_n(&image[(at.crop_row + r) * model.cols + at.crop_col], at.side, &out[r * at.side]);
    return out;
}

void round_to_float(Buffer<double> &plane) {
    for (double &value : plane)
        value = static_cast<double>(kernels::to_float32(value));
}

// A single float32 is up to 32 counts off near 1e9 counts, a thousandth of the photon noise; the sum of two is within
// 4e-6 counts.
void round_to_two_floats(Buffer<double> &plane) {
    for (double &value : plane) {
        const double high = static_cast<double>(kernels::to_float32(value));
        value = high + static_cast<double>(kernels::to_float32(value - high));
    }
}

// Numbers from a frame's residual to the next frame's. A multiple of a page would put equal rows of all frames into the
// same few lines of the cache.
constexpr size_t residual_stride(size_t pixels) noexcept {
    return pixels + 320;
}

// The part of the derivative that is orthogonal to the nuisances must exceed the rounding of their float32 planes.
void check_signal(const Preprocess &preprocess, const std::string &source) {
    Buffer<double> target = preprocess.target;
    const auto [before, after] = kernels::project_out_twice(preprocess.nuisance_basis.data(), preprocess.projected,
                                                            target.size(), target.data());
    if (!(after > kMinRemainder * before))
        fail(Status::scene,
             "%s: {preprocess.project}: the projection leaves no information about the separation: %g of %g px^-2 per "
             "frame",
             source.c_str(), before > 0 ? after / before * after / before : 0, before * before);
}

// Fails with the first non-finite count of some rows of a crop.
void refuse_non_finite(const Crop &crop, size_t first_row, size_t rows) {
    for (size_t r = first_row; r < first_row + rows; r++)
        for (size_t c = 0; c < crop.counts.cols; c++)
            if (const double count = crop.counts.row(r)[c]; !std::isfinite(count))
                fail(Status::argument, "{counts[%zu][%zu]} = %g: must be finite", crop.row + r, crop.col + c, count);
}

} // namespace

Preprocess Preprocess::from_model(const FrameModel &model, const Layout &layout, Input input, Centre centre) {
    const size_t side = layout.side;
    if (model.rows < side || model.cols < side)
        fail(Status::unsupported,
             "%s: {detector.shape} = [%zu, %zu]: must be at least [%zu, %zu] px for a network of layout %s",
             model.source.c_str(), model.rows, model.cols, side, side, layout.name);
    if (input != Input::whitened && !model.projected.empty())
        fail(Status::unsupported,
             "%s: {preprocess.project}: must be empty for %s input: only whitened input can be projected",
             model.source.c_str(), name_of(input));
    if (centre == Centre::image && model.rows == side && model.cols == side)
        fail(Status::unsupported,
             "%s: {detector.shape} = [%zu, %zu]: must exceed [%zu, %zu] px for a crop that follows the image",
             model.source.c_str(), model.rows, model.cols, side, side);
    const auto is_bad = [](double value) { return !std::isfinite(value); };
    if (centre == Centre::image && std::any_of(model.variance.begin(), model.variance.end(), is_bad))
        fail(Status::unsupported,
             "%s: {detector.bad_pixels}: not available for a crop that follows the image: they would move in it",
             model.source.c_str());
    Preprocess out;
    out.side = side;
    out.input = input;
    out.centre = centre;
    out.background = centre == Centre::image ? model.background : 0;
    out.rows = model.rows;
    out.cols = model.cols;
    out.crb_px = model.crb_px;
    out.scene_digest = model.scene_digest;
    crop_about_barycentre(model, out);
    if (model.window)
        out.window = DetectorWindow{model.window->row + static_cast<int64_t>(out.crop_row),
                                    model.window->col + static_cast<int64_t>(out.crop_col)};
    out.reference = crop(model, model.reference, out);
    round_to_two_floats(out.reference);
    out.variance = crop(model, model.variance, out);
    round_to_float(out.variance);

    const size_t pixels = out.pixels();
    out.nuisance_basis.resize(model.projected.size() * pixels);
    for (size_t k = 0; k < model.projected.size(); k++) {
        const Buffer<double> image = crop(model, model.projected[k].image, out);
        kernels::whiten(image.data(), out.variance.data(), pixels, &out.nuisance_basis[k * pixels]);
    }
    out.projected = kernels::orthonormalise(out.nuisance_basis.data(), model.projected.size(), pixels);
    out.nuisance_basis.resize(out.projected * pixels);
    out.target = crop(model, model.derivative, out);
    kernels::whiten(out.target.data(), out.variance.data(), pixels, out.target.data());
    check_signal(out, model.source);

    round_to_float(out.nuisance_basis);
    kernels::project_out(out.nuisance_basis.data(), out.projected, pixels, out.target.data());
    round_to_float(out.target);
    out.derive();
    return out;
}

void Preprocess::derive() {
    const size_t pixels = this->pixels();
    basis.resize(nuisance_basis.size());
    for (size_t k = 0; k < projected; k++)
        for (size_t r = 0; r < side; r++)
            std::transform(&nuisance_basis[k * pixels + r * side], &nuisance_basis[k * pixels + r * side] + side,
                           &basis[(r * projected + k) * side], kernels::to_float32);
    target32.assign(target.begin(), target.end());
    target_most = 0;
    for (const double value : target)
        target_most = std::fmax(target_most, std::fabs(value));
    target_square = kernels::residual_kernels().inner(target.data(), target.data(), pixels);
    if (centre == Centre::image) {
        const std::optional<Barycentre> light = barycentre_of({reference.data(), side, side, side}, background);
        if (!light)
            fail(Status::format,
                 "weights blob: the reference image has no light above the background of %g counts per pixel",
                 background);
        barycentre = *light;
    }
    noise = PixelNoise(reference, variance);
    known_bad = KnownBadPixels(side, side, variance, window);
    tail.assign(noise.tail.begin(), noise.tail.end());
    whitening.assign(pixels, 1.0);
    kernels::whiten(whitening.data(), variance.data(), pixels, whitening.data());
    offset = reference;
    factor = whitening;
    if (input == Input::residual) {
        const double sum = std::accumulate(variance.begin(), variance.end(), 0.0,
                                           [](double all, double one) { return all + (std::isfinite(one) ? one : 0); });
        factor.assign(pixels, 1 / std::sqrt(sum / static_cast<double>(noise.used)));
    } else if (input == Input::raw) {
        const auto [darkest, brightest] = std::minmax_element(reference.begin(), reference.end());
        const double low = *darkest, range = *brightest - low;
        offset.assign(pixels, low);
        factor.assign(pixels, range > 0 ? 1 / range : 1);
    }
    for (size_t i = 0; noise.used < pixels && i < pixels; i++)
        if (!std::isfinite(variance[i]))
            factor[i] = 0;
}

Preprocess Preprocess::with_input_scale(double scale) const {
    Preprocess out = *this;
    out.input_scale = scale;
    return out;
}

void Preprocess::Work::reserve(size_t pixels, size_t frames) {
    stride = residual_stride(pixels);
    if (residual.size() < frames * stride)
        residual.resize(frames * stride);
}

// The light at the edges leaves a crop that is off, and other light enters it: its barycentre is moved by a little less
// than the light. A few moves bring it there.
Crop Preprocess::crop_of(const ImageView<const double> &frame) const {
    Crop crop = crop_at(frame, crop_row, crop_col);
    for (int move = 0; centre == Centre::image && move < kMostMoves; move++) {
        const std::optional<Barycentre> light = barycentre_of(crop.counts, background);
        if (!light || !std::isfinite(light->row) || !std::isfinite(light->col)) {
            refuse_non_finite(crop, 0, side);
            fail(Status::argument, "{counts}: has no light above the background of %g counts per pixel", background);
        }
        const size_t row = moved_start(crop.row, light->row - barycentre.row, rows - side),
                     col = moved_start(crop.col, light->col - barycentre.col, cols - side);
        if (row == crop.row && col == crop.col)
            break;
        crop = crop_at(frame, row, col);
    }
    return crop;
}

void Preprocess::start(const Crop *crops, size_t count, Work &work) const {
    std::fill_n(work.most, count, 0.0f);
    if (projected == 0)
        return;
    work.reserve(pixels(), count);
    const double *counts[kTogether] = {};
    float *vectors[kTogether] = {}, *components[kTogether] = {};
    for (size_t f = 0; f < count; f++) {
        counts[f] = crops[f].counts.row(0);
        vectors[f] = &work.residual[f * work.stride];
        components[f] = work.component[f];
    }
    if (!kernels::residual_kernels().components(projected_rows(), count, counts, crops[0].counts.stride, vectors,
                                                components))
        for (size_t f = 0; f < count; f++)
            refuse_non_finite(crops[f], 0, side);
}

void Preprocess::band(const Crop *crops, size_t count, size_t first_row, Work &work, float *const *bands,
                      size_t stride) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    float *vectors[kTogether] = {}, *components[kTogether] = {};
    for (size_t f = 0; projected > 0 && f < count; f++) {
        vectors[f] = &work.residual[f * work.stride];
        components[f] = work.component[f];
    }
    for (size_t i = 0, r = first_row; i < kBand; i++, r++) {
        float *out[kTogether];
        for (size_t f = 0; f < count; f++)
            out[f] = bands[f] + i * stride;
        if (projected > 0)
            kernel.project_row(projected_rows(), count, components, r, vectors, out);
        for (size_t f = 0; f < count; f++) {
            const double *const counts = crops[f].counts.row(r);
            const float *residual = out[f]; // times input_scale
            float whitened[kLargestSide];
            if (projected == 0 &&
                !kernel.scaled_residual(counts, &offset[r * side], &factor[r * side], input_scale, side, out[f]))
                refuse_non_finite(crops[f], r, 1);
            if (input != Input::whitened) {
                kernel.scaled_residual(counts, &reference[r * side], &whitening[r * side], input_scale, side, whitened);
                residual = whitened;
            }
            work.most[f] = kernel.magnitude_float(residual, side, work.most[f]);
        }
    }
}

void Preprocess::apply(ImageView<const double> frame, Work &work, float *out) const {
    const Crop crop = crop_of(frame);
    start(&crop, 1, work);
    for (size_t r = 0; r < side; r += kBand) {
        float *const rows_of_band = out + r * side;
        band(&crop, 1, r, work, &rows_of_band, side);
    }
}

// With projected planes, band() has written the residual. The largest pixels are those that band() found, unless the
// target changes them.
Preprocess::Fitted Preprocess::fit(const Crop &crop, size_t i, bool pixels, Work &work) const {
    const kernels::ResidualKernels &kernel = kernels::residual_kernels();
    const auto whiten = [&](size_t r, float *row) {
        kernel.scaled_residual(crop.counts.row(r), &reference[r * side], &whitening[r * side], 1, side, row);
    };
    double along = 0, square = 0;
    for (size_t r = 0; r < side; r++) {
        float whitened[kLargestSide];
        const float *residual = whitened;
        if (projected > 0)
            residual = &work.residual[i * work.stride + r * side];
        else
            whiten(r, whitened);
        along += kernel.inner_float(&target32[r * side], residual, side);
        square += kernel.inner_float(residual, residual, side);
    }
    Fitted fitted = {target_square > 0 ? along / target_square : 0, square, 0, 0};
    fitted.square -= fitted.displacement * along;
    if (!pixels && std::fabs(fitted.displacement) * target_most <= kLittle) {
        fitted.most = work.most[i] / static_cast<float>(input_scale);
        return fitted;
    }
    work.reserve(side * side, i + 1);
    float *const all = &work.residual[i * work.stride];
    for (size_t r = 0; projected == 0 && r < side; r++)
        whiten(r, all + r * side);
    kernel.largest_float(all, static_cast<float>(fitted.displacement), target32.data(), tail.data(), side * side,
                         &fitted.most, &fitted.excess);
    return fitted;
}

FrameGoodness Preprocess::goodness(const Fitted &fitted, size_t bad_pixels, bool few_bad) const noexcept {
    const double left = freedom(bad_pixels);
    return frame_goodness(std::max(fitted.square, 0.0) / left,
                          chi_square_sigma(noise.used - bad_pixels, noise.inverse_counts, left),
                          static_cast<double>(fitted.most), bad_pixels, few_bad);
}

double Preprocess::residual_of(size_t i, size_t pixel, const Fitted &fitted, const Work &work) const noexcept {
    return static_cast<double>(work.residual[i * work.stride + pixel]) - fitted.displacement * target[pixel];
}

BadPixels::Found Preprocess::add_bad_pixels(size_t i, const Fitted &fitted, const Work &work,
                                            BadPixels &bad) const noexcept {
    return bad.add_largest(pixels(), fitted.square, freedom(bad.count()), [&](size_t pixel) {
        return excess_of(residual_of(i, pixel, fitted, work), noise.tail[pixel]);
    });
}

bool Preprocess::lower(size_t i, const Fitted &fitted, const Work &work, const BadPixels &bad, double *counts,
                       double &largest) const noexcept {
    const size_t pixels = this->pixels();
    const size_t columns = projected + 1;
    double units[kMostBadPixels * (kMaxProjected + 1)], residual[kMostBadPixels], deleted[kMostBadPixels];
    for (size_t b = 0; b < bad.count(); b++) {
        residual[b] = residual_of(i, bad[b], fitted, work);
        for (size_t k = 0; k < projected; k++)
            units[b * columns + k] = nuisance_basis[k * pixels + bad[b]];
        units[b * columns + projected] = target_square > 0 ? target[bad[b]] / std::sqrt(target_square) : 0;
    }
    if (!deleted_residuals(units, columns, bad.count(), residual, deleted))
        return false;
    largest = 0;
    for (size_t b = 0; b < bad.count(); b++) {
        counts[bad[b]] -= deleted[b] / whitening[bad[b]];
        largest = std::fmax(largest, std::fabs(deleted[b]));
    }
    return true;
}

// The background determines the input only where the barycentre above it moves the crop.
uint64_t Preprocess::digest() const noexcept {
    uint64_t hash = fnv1a(with_bits<uint64_t>(input_scale), kFnvOffset);
    for (const size_t number : {rows, cols, crop_row, crop_col, projected, static_cast<size_t>(input)})
        hash = fnv1a(number, hash);
    if (centre == Centre::image)
        hash = fnv1a(with_bits<uint64_t>(background), hash);
    if (window)
        hash = fnv1a(static_cast<uint64_t>(window->col), fnv1a(static_cast<uint64_t>(window->row), hash));
    for (const Buffer<double> *plane : {&reference, &variance, &nuisance_basis})
        hash = fnv1a(*plane, hash);
    return hash;
}

void Preprocess::to_counts(double *image) const noexcept {
    for (size_t i = 0; i < pixels(); i++)
        image[i] = offset[i] + (factor[i] > 0 ? image[i] / factor[i] : 0);
}

} // namespace toliman::cae
