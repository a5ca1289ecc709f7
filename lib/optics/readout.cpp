// Method: with Lc the sum over the four neighbours of a pixel of their charge minus its own (a neighbour beyond the
// edge of the frame has the pixel's own charge, so that none is lost),
//     smear     c + s times the sum of c over the column: the shift of a frame to its store moves each pixel past all
//               others of its column, s = time of one row over the exposure
//     exchange  c + a/4 L(c^2): brighter-fatter. Charge flows from full pixels to their neighbours as in a blur of
//               variance a c, which is the flux a/2 c dc between pixels
//     couple    c + k Lc: capacitance between pixels, a kernel of (k, 1 - 4 k, k); noise is coupled, too
//     bend      c - b c^2: non-linearity
// in this order; Poisson noise comes after the smear, read noise after the bend. A frame of n coadds has a/n and b/n.
// Inverse: b from the quadratic equation, the others by fixed-point iteration c <- y - (step(c) - c), which converges
// as (8 k)^i and (2 a c)^i, until nothing changes by 1e-15 of the largest value. Corrected in this way, charges are
// again independent Poisson numbers, so that estimators see an ideal detector. Brighter-fatter is the nearest-neighbour
// form of its flux in Antilogus et al. 2014, JINST 9 C03048; coupling: Moore et al. 2004, Proc. SPIE 5167, 204.
#include "optics/readout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/hash.hpp"
#include "frame/bad_pixels.hpp"

namespace toliman::optics {

namespace {

using Kind = Parameter::Kind;

constexpr int kMostIterations = 100;
constexpr double kStill = 1e-15;      // of the largest value
constexpr double kMostExchange = 0.2; // px^2, variance of the brightest pixel: the iteration converges

// out += factor L(image)
void add_laplacian(const double *image, size_t rows, size_t cols, double factor, double *out) noexcept {
    for (size_t r = 0; r < rows; r++) {
        const double *const here = image + r * cols, *const above = image + (r == 0 ? 0 : r - 1) * cols,
                            *const below = image + (r + 1 == rows ? r : r + 1) * cols;
        double *const sum = out + r * cols;
        for (size_t c = 0; c < cols; c++)
            sum[c] += factor * (above[c] + below[c] - 2 * here[c]);
        for (size_t c = 1; c < cols; c++) {
            const double flow = factor * (here[c] - here[c - 1]);
            sum[c] -= flow;
            sum[c - 1] += flow;
        }
    }
}

Buffer<double> copy_of(const double *image, size_t pixels) {
    return Buffer<double>(image, image + pixels);
}

} // namespace

Readout::Readout(const Scene &scene)
    : rows_(scene.detector.rows), cols_(scene.detector.cols), smear_(scene.detector.transfer_smear),
      exchange_(scene.detector.brighter_fatter_px2_per_e), couple_(scene.detector.interpixel_capacitance),
      curve_(scene.detector.nonlinearity_per_e), frames_(static_cast<double>(scene.detector.coadds)) {}

Readout Readout::of_frames(double frames) const {
    Readout sum = *this;
    sum.frames_ *= frames;
    return sum;
}

uint64_t Readout::digest(uint64_t hash) const noexcept {
    return any() || smears() ? fnv1a(std::array<double, 5>{smear_, exchange_, couple_, curve_, frames_}, hash) : hash;
}

void Readout::add_smear(double *light) const {
    if (!smears())
        return;
    Buffer<double> sums(cols_);
    for (size_t i = 0; i < rows_ * cols_; i++)
        sums[i % cols_] += light[i];
    for (size_t i = 0; i < rows_ * cols_; i++)
        light[i] += smear_ * sums[i % cols_];
}

void Readout::exchange(double *charge) const {
    if (exchange_ == 0)
        return;
    Buffer<double> square(rows_ * cols_);
    for (size_t i = 0; i < square.size(); i++)
        square[i] = charge[i] * charge[i];
    add_laplacian(square.data(), rows_, cols_, exchange_factor() / 4, charge);
}

void Readout::couple(size_t rows, size_t cols, double *charge) const {
    if (couple_ != 0)
        add_laplacian(copy_of(charge, rows * cols).data(), rows, cols, couple_, charge);
}

void Readout::bend(double *charge) const noexcept {
    for (size_t i = 0; bends() && i < rows_ * cols_; i++)
        charge[i] = bent(charge[i]);
}

void Readout::read(double *charge) const {
    exchange(charge);
    couple(charge);
    bend(charge);
}

double Readout::straight(double electrons) const noexcept {
    return 2 * electrons / (1 + std::sqrt(std::max(0.0, 1 - 4 * curve() * electrons)));
}

// Solves step(c) = image for c.
template <class Step> void Readout::invert(double *image, const Step &step) const {
    const size_t pixels = rows_ * cols_;
    Buffer<double> value = copy_of(image, pixels), next(pixels);
    for (int i = 0; i < kMostIterations; i++) {
        std::copy(value.begin(), value.end(), next.begin());
        step(next.data());
        double moved = 0, largest = 0;
        for (size_t k = 0; k < pixels; k++) {
            const double change = image[k] - next[k];
            value[k] += change;
            moved = std::max(moved, std::fabs(change));
            largest = std::max(largest, std::fabs(value[k]));
        }
        if (!(moved > kStill * largest))
            break;
    }
    std::copy(value.begin(), value.end(), image);
}

void Readout::undo_bend(double *electrons) const noexcept {
    for (size_t i = 0; bends() && i < rows_ * cols_; i++)
        electrons[i] = straight(electrons[i]);
}

void Readout::undo_coupling(double *electrons) const {
    if (couple_ != 0)
        invert(electrons, [this](double *image) { couple(image); });
}

void Readout::undo_exchange(double *electrons) const {
    if (exchange_ != 0)
        invert(electrons, [this](double *image) { exchange(image); });
}

void Readout::undo_counts(double e_per_count, double bias, double limit, double *counts) const {
    const size_t pixels = rows_ * cols_;
    if (!any() || !std::all_of(counts, counts + pixels, [](double count) { return std::isfinite(count); }))
        return;
    std::vector<size_t> saturated;
    for (size_t i = 0; i < pixels; i++) {
        counts[i] = (counts[i] - bias) * e_per_count;
        if (counts[i] >= (1 - kStill) * bent(limit))
            saturated.push_back(i);
    }
    undo_bend(counts);
    undo_coupling(counts);
    for (size_t i = 0; i < pixels; i++)
        if (counts[i] > limit) { // and more than the exchange can be inverted for
            saturated.push_back(i);
            counts[i] = limit;
        }
    undo_exchange(counts);
    for (const size_t pixel : saturated)
        visit_mixed(pixel, rows_, cols_, mixes(), [&](size_t i) { counts[i] = std::max(counts[i], limit); });
    for (size_t i = 0; i < pixels; i++)
        counts[i] = counts[i] / e_per_count + bias;
}

// The products d step(c)[v] of the three steps, each at the charges after the step before.
void Readout::differentiate(const double *charge, double *image) const {
    const size_t pixels = rows_ * cols_;
    Buffer<double> at = copy_of(charge, pixels), product(pixels);
    if (exchange_ != 0) {
        for (size_t i = 0; i < pixels; i++)
            product[i] = at[i] * image[i];
        add_laplacian(product.data(), rows_, cols_, exchange_factor() / 2, image);
        exchange(at.data());
    }
    couple(image);
    couple(at.data());
    for (size_t i = 0; bends() && i < pixels; i++)
        image[i] *= 1 - 2 * curve() * at[i];
}

void Readout::undo_derivative(const double *charge, double *image) const {
    if (any())
        invert(image, [this, charge](double *trial) { differentiate(charge, trial); });
}

void Readout::adjoint(const double *charge, double *weights) const {
    const size_t pixels = rows_ * cols_;
    Buffer<double> at = copy_of(charge, pixels), sum(pixels);
    exchange(at.data());
    couple(at.data());
    for (size_t i = 0; bends() && i < pixels; i++)
        weights[i] *= 1 - 2 * curve() * at[i];
    couple(weights); // symmetric
    if (exchange_ != 0) {
        add_laplacian(weights, rows_, cols_, exchange_factor() / 2, sum.data());
        for (size_t i = 0; i < pixels; i++)
            weights[i] += charge[i] * sum[i];
    }
}

// The kernel of the coupling, squared. Infinite variances of bad pixels stay their own.
void Readout::read_variance(const double *charge, double *variance) const {
    const size_t pixels = rows_ * cols_;
    if (couple_ != 0) {
        const double middle = 1 - 4 * couple_, side = couple_ * couple_;
        Buffer<double> sum = copy_of(variance, pixels), finite = sum;
        for (double &value : finite)
            value = std::isfinite(value) ? value : 0;
        for (size_t i = 0; i < pixels; i++)
            sum[i] *= middle * middle + 4 * side;
        add_laplacian(finite.data(), rows_, cols_, side, sum.data());
        std::copy(sum.begin(), sum.end(), variance);
    }
    if (!bends())
        return;
    Buffer<double> at = copy_of(charge, pixels);
    exchange(at.data());
    couple(at.data());
    for (size_t i = 0; i < pixels; i++) {
        const double slope = 1 - 2 * curve() * at[i];
        variance[i] *= slope * slope;
    }
}

// To second order in the coupling: the inverse kernel is (1 + 4 k + 20 k^2, -k - 8 k^2, ...).
double Readout::noise_gain() const noexcept {
    const double middle = 1 + 4 * couple_ + 20 * couple_ * couple_, side = couple_ + 8 * couple_ * couple_;
    return middle * middle + 4 * side * side;
}

bool Readout::has(Kind kind) noexcept {
    return kind == Kind::transfer_smear || kind == Kind::brighter_fatter || kind == Kind::interpixel_capacitance ||
           kind == Kind::nonlinearity;
}

// The derivative of what is read, undone.
Buffer<double> Readout::derivative(Kind kind, const Buffer<double> &charge, double dark_e) const {
    const size_t pixels = rows_ * cols_;
    Buffer<double> image(pixels);
    if (kind == Kind::transfer_smear) { // of the light alone; before exchange
        Buffer<double> sums(cols_);
        for (size_t i = 0; i < pixels; i++)
            sums[i % cols_] += charge[i] - dark_e;
        for (size_t i = 0; i < pixels; i++)
            image[i] = sums[i % cols_] / (1 + smear_ * static_cast<double>(rows_));
        return image;
    }
    Buffer<double> at = charge, square(pixels);
    if (kind == Kind::brighter_fatter) {
        for (size_t i = 0; i < pixels; i++)
            square[i] = at[i] * at[i];
        add_laplacian(square.data(), rows_, cols_, 1 / (4 * frames_), image.data());
        Readout before = *this; // the exchange alone remains to be undone
        before.couple_ = before.curve_ = 0;
        before.undo_derivative(charge.data(), image.data());
        return image;
    }
    exchange(at.data());
    if (kind == Kind::interpixel_capacitance) {
        add_laplacian(at.data(), rows_, cols_, 1, image.data());
        couple(at.data());
        for (size_t i = 0; i < pixels; i++)
            image[i] *= 1 - 2 * curve() * at[i];
    } else {
        couple(at.data());
        for (size_t i = 0; i < pixels; i++)
            image[i] = -at[i] * at[i] / frames_;
    }
    undo_derivative(charge.data(), image.data());
    return image;
}

double Readout::most_charge() const noexcept {
    double most = brightest_reading();
    if (exchange_ != 0)
        most = std::min(most, kMostExchange / std::fabs(exchange_factor()));
    return most;
}

} // namespace toliman::optics
