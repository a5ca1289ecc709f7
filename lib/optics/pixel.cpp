// Method: an image has no spatial frequency above f_c = D p/lambda_min cycles per pixel, so that a pixel's transfer
// function matters for |f| <= f_c only. The integral over a square pixel and a Gaussian blur of sigma s multiply the
// spectrum, along each axis, by H(f) = sinc(f) exp(-2 pi^2 s^2 f^2), a filter along that axis (line_filter.hpp).
// Binning an oversampled image is avoided: its error is of second order in the sample spacing. Point sampling in place
// of the integral is wrong by 2.6e-2 (measured).
// A covariance q = xy of the jitter multiplies the spectrum by exp(-4 pi^2 q f_x f_y), which no product of two filters
// has. It is expanded in products (Mehler 1866),
//     H = sum over m of (-sign q)^m g_m(f_x) g_m(f_y),   g_m(f) = H_0(f) (2 pi sqrt|q| f)^m / sqrt(m!),
// each g_m a filter along its axis, antisymmetric for odd m. No term exceeds (q^2 / (xx yy))^(m/2), so nothing cancels;
// the terms end where their product is below the accuracy.
// Motion within an exposure multiplies it by a sum of cos(2 pi f . a) over displacements a (smear.cpp): cosines and
// sines along both axes, symmetric and antisymmetric filters,
//     cos(2 pi f . a) = cos(2 pi f_x a_x) cos(2 pi f_y a_y) - sin(2 pi f_x a_x) sin(2 pi f_y a_y),
// times those of pixel and jitter; along an axis the whole sum is one filter.
// Error, relative to the peak of the blurred image: of the transfer functions, e_x + e_y, and of rounding. Both passes
// amplify that of the samples, 1e-16 of the peak, which is random: by the root of the sum of their squared taps. 1e-15
// times the product of both roots bounds the largest of many pixels.
#include "optics/pixel.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

namespace toliman::optics {

namespace {

constexpr double kMaxCutoff = 0.4;  // cycles per sample; filters stay short up to here
constexpr size_t kMaxTerms = 256;   // of the expansion in the covariance
constexpr size_t kSteps = 200;      // of an integral over the band
constexpr double kTermShare = 0.25; // of the accuracy, for each filter of the expansion
constexpr double kSumShare = 0.4;   // of the accuracy, for each of the two sums of a path

// out[i] = sum over k of taps[|k|] in[i step + k stride], with the sign of k for an odd filter.
void filter_line(const double *in, size_t stride, size_t step, const LineFilter &line, size_t count,
                 double *out) noexcept {
    for (size_t i = 0; i < count; i++)
        out[i] = line.taps[0] * in[i * step];
    for (size_t k = 1; k < line.taps.size(); k++) {
        const double tap = line.taps[k], *const before = in - k * stride, *const after = in + k * stride;
        if (line.odd)
            for (size_t i = 0; i < count; i++)
                out[i] += tap * (after[i * step] - before[i * step]);
        else
            for (size_t i = 0; i < count; i++)
                out[i] += tap * (before[i * step] + after[i * step]);
    }
}

// The adjoint along a line: adds in[i] times the taps to out.
void spread_line(const double *in, size_t stride, size_t step, const LineFilter &line, size_t count, double *out,
                 size_t out_stride) noexcept {
    const std::vector<double> &taps = line.taps;
    for (size_t i = 0; i < count; i++) {
        double *const middle = out + i * step * out_stride;
        const double value = in[i * stride];
        middle[0] += taps[0] * value;
        for (size_t k = 1; k < taps.size(); k++) {
            middle[k * out_stride] += taps[k] * value;
            *(middle - k * out_stride) += (line.odd ? -taps[k] : taps[k]) * value;
        }
    }
}

// The share of a star's peak that the blur leaves along one axis: the mean of exp(-2 pi^2 s^2 f^2) over the band,
// weighted by the transfer function of a slit. An image with more structure keeps more.
double peak_left(const Blur &blur, double variance, double cutoff) noexcept {
    double sum = 0;
    for (size_t i = 0; i < kSteps; i++) {
        const double part = (static_cast<double>(i) + 0.5) / kSteps, spread = kPi * blur.pixel * cutoff * part;
        sum += 2.0 / kSteps * (1 - part) * std::exp(-2 * variance * spread * spread);
    }
    return sum;
}

// Of the samples, amplified by both filters.
double rounding(const std::array<LineFilter, 2> &term) noexcept {
    return kSampleRounding * term[0].gain * term[1].gain;
}

// The same that motion along a path leaves.
double peak_left(const Path &path, double pixel, double cutoff) noexcept {
    double sum = path.nodes.empty() ? 1 : 0, weights = sum;
    for (const Path::Node &node : path.nodes) {
        const double phase = kPi * pixel * cutoff * node.at; // of a slit: sinc^2
        sum += node.weight * (phase != 0 ? std::pow(std::sin(phase) / phase, 2) : 1);
        weights += node.weight;
    }
    return sum / weights;
}

// Filters along x and y, and the weight of their product.
struct PathPart {
    LinePath x, y;
    double weight = 1;
};

std::vector<PathPart> parts_of(const Path &path) {
    if (path.nodes.empty())
        return {PathPart()};
    if (path.y == 0)
        return {{{path.nodes}, {}, 1}};
    if (path.x == 0)
        return {{{}, {path.nodes}, 1}};
    std::vector<PathPart> parts;
    for (const auto &[at, weight] : path.nodes)
        for (const bool odd : {false, true})
            if (!odd || at != 0)
                parts.push_back({{{{at * path.x, 1}}, odd}, {{{at * path.y, 1}}, odd}, weight});
    return parts;
}

// Appends the product of two filters.
void add(LineFilter along_x, LineFilter along_y, double factor, PixelFilter &filter) {
    for (double &tap : along_y.taps)
        tap *= factor;
    along_y.gain *= std::fabs(factor);
    filter.terms.push_back({std::move(along_x), std::move(along_y)});
    filter.error += rounding(filter.terms.back());
}

// Appends the terms m = 1, 2, ... of the expansion in the covariance, until they are within the accuracy.
void add_terms(double cutoff, const Blur &blur, const PathPart &part, double accuracy, PixelFilter &filter) {
    const Jitter &jitter = blur.jitter;
    double last = 1;
    for (size_t m = 1; m <= kMaxTerms; m++) {
        const TransferFunction x(blur, jitter.xx, m, part.x, filter.oversampling),
            y(blur, jitter.yy, m, part.y, filter.oversampling);
        const double size_x = x.largest(cutoff), size_y = y.largest(cutoff), size = size_x * size_y;
        if (size <= kTermShare * accuracy * (1 - size / last) || m == kMaxTerms) {
            filter.error += part.weight * size / std::max(1 - size / last, 1.0 / kMaxTerms); // as a geometric series
            return;
        }
        last = size;
        LineFilter along_x = make_line(x, cutoff, kTermShare * accuracy / std::max(size_y, 1.0)),
                   along_y = make_line(y, cutoff, kTermShare * accuracy / std::max(size_x, 1.0));
        filter.error += part.weight * (along_x.error * size_y + along_y.error * size_x) / 2;
        const bool negative = m % 2 == 1 && jitter.xy < 0; // the product of two odd filters has the factor i^2 = -1
        add(std::move(along_x), std::move(along_y), negative ? -part.weight : part.weight, filter);
    }
}

// Appends the filters of a part of the path, each within `share` of an accuracy.
void add_part(double cutoff, const Blur &blur, const PathPart &part, double share, double accuracy,
              PixelFilter &filter) {
    const auto line = [&](double variance, const LinePath &path) {
        return make_line(TransferFunction(blur, variance, 0, path, filter.oversampling), cutoff, share * accuracy);
    };
    LineFilter along_x = line(blur.jitter.xx, part.x), along_y = line(blur.jitter.yy, part.y);
    filter.error += part.weight * std::max(along_x.error, along_y.error);
    add(std::move(along_x), std::move(along_y), part.weight, filter);
    if (blur.jitter.xy != 0)
        add_terms(cutoff, blur, part, accuracy, filter);
}

} // namespace

size_t PixelFilter::margin() const noexcept {
    size_t longest = 1;
    for (const auto &term : terms)
        longest = std::max({longest, term[0].taps.size(), term[1].taps.size()});
    return longest - 1;
}

size_t PixelFilter::taps() const noexcept {
    size_t sum = 0;
    for (const auto &term : terms)
        sum += term[0].taps.size() + term[1].taps.size();
    return sum;
}

PixelFilter make_filter(double cutoff, const Blur &blur, double accuracy) {
    PixelFilter filter;
    if (!blur.any())
        return filter;
    filter.oversampling = static_cast<size_t>(std::max(1.0, std::ceil(cutoff / kMaxCutoff)));
    const double fine = cutoff / static_cast<double>(filter.oversampling),
                 left = peak_left(blur, blur.jitter.xx, cutoff) * peak_left(blur, blur.jitter.yy, cutoff) *
                        peak_left(blur.path, blur.pixel, cutoff);
    for (const PathPart &part : parts_of(blur.path))
        add_part(fine, blur, part, blur.jitter.xy != 0 ? kTermShare : 1,
                 (blur.path.nodes.empty() ? 1 : kSumShare) * left * accuracy, filter);
    filter.error = (filter.error + blur.path.error) / left;
    return filter;
}

Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept {
    const auto samples = [&](size_t n) { return (n - 1) * filter.oversampling + 1 + 2 * filter.margin(); };
    Grid grid = pixels;
    grid.rows = samples(pixels.rows);
    grid.cols = samples(pixels.cols);
    grid.pitch_rad /= filter.oversampling;
    return grid;
}

Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter) {
    const Grid grid = sampling_grid(pixels, filter);
    const size_t margin = filter.margin(), step = filter.oversampling;
    Buffer<double> rows(grid.rows * pixels.cols), result(pixels.rows * pixels.cols), sums(pixels.cols);
    for (const auto &[along_x, along_y] : filter.terms) {
        for (size_t row = 0; row < grid.rows; row++)
            filter_line(samples.data() + row * grid.cols + margin, 1, step, along_x, pixels.cols,
                        rows.data() + row * pixels.cols);
        for (size_t row = 0; row < pixels.rows; row++) {
            filter_line(rows.data() + (margin + row * step) * pixels.cols, pixels.cols, 1, along_y, pixels.cols,
                        sums.data());
            for (size_t col = 0; col < pixels.cols; col++)
                result[row * pixels.cols + col] += sums[col];
        }
    }
    return result;
}

Buffer<double> spread(const Buffer<double> &weights, const Grid &pixels, const PixelFilter &filter) {
    const Grid grid = sampling_grid(pixels, filter);
    const size_t margin = filter.margin(), step = filter.oversampling;
    Buffer<double> samples(grid.rows * grid.cols);
    for (const auto &[along_x, along_y] : filter.terms) {
        Buffer<double> rows(grid.rows * pixels.cols);
        for (size_t col = 0; col < pixels.cols; col++)
            spread_line(weights.data() + col, pixels.cols, step, along_y, pixels.rows,
                        rows.data() + margin * pixels.cols + col, pixels.cols);
        for (size_t row = 0; row < grid.rows; row++)
            spread_line(rows.data() + row * pixels.cols, 1, step, along_x, pixels.cols,
                        samples.data() + row * grid.cols + margin, 1);
    }
    return samples;
}

} // namespace toliman::optics
