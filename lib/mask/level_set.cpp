// Method: the heights h of the fine cells are h = W t W^T, t the heights of the control points and W the Gaussian
// weights of an axis. With g = h/rms over the open cells, c = 1/(1 + exp(-slope g)) is the fraction that each covers.
// Why: the smoothing bounds the size of features from below, and growing slopes turn grey cells to 0 or 1 without a
// jump. Reference: van Dijk et al. 2013, Struct. Multidiscip. Optim. 48, 437 (level sets in topology optimisation).
#include "mask/level_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace toliman::mask {

namespace {

constexpr double kReach = 6; // of the Gaussian, in standard deviations: 1e-8

double sigmoid(double x) noexcept {
    return 1 / (1 + std::exp(-x));
}

} // namespace

LevelSet::LevelSet(size_t points, double smoothing, size_t fine, size_t coarse, const Buffer<double> &open,
                   Symmetry symmetry)
    : points_(points), fine_(fine), coarse_(coarse), symmetry_(symmetry), open_(open), height_(fine * fine) {
    for (const double value : open)
        open_cells_ += value > 0 ? 1 : 0;
    const double reach = kReach * smoothing;
    for (size_t i = 0; i < fine; i++) {
        const double at =
            (static_cast<double>(i) + 0.5) / static_cast<double>(fine) * static_cast<double>(points) - 0.5;
        const auto first = static_cast<size_t>(std::max(0.0, std::ceil(at - reach)));
        const auto end = std::min(points, static_cast<size_t>(std::floor(at + reach)) + 1);
        Row row = {first, {}};
        double sum = 0;
        for (size_t j = first; j < end; j++) {
            const double distance = (at - static_cast<double>(j)) / smoothing;
            row.weights.push_back(std::exp(-0.5 * distance * distance));
            sum += row.weights.back();
        }
        for (double &weight : row.weights)
            weight /= sum;
        rows_.push_back(std::move(row));
    }
}

// Rotation by 180 degrees reverses the order of the control points.
void LevelSet::impose_symmetry(Buffer<double> &heights) const {
    if (symmetry_ == Symmetry::none)
        return;
    const double sign = symmetry_ == Symmetry::even ? 1 : -1;
    for (size_t i = 0, j = heights.size() - 1; i <= j && j < heights.size(); i++, j--) {
        const double value = 0.5 * (heights[i] + sign * heights[j]);
        heights[i] = value;
        heights[j] = sign * value;
    }
}

double LevelSet::set(const Buffer<double> &heights) {
    Buffer<double> symmetric = heights, middle(fine_ * points_);
    impose_symmetry(symmetric);
    for (size_t y = 0; y < fine_; y++)
        for (size_t j = 0; j < rows_[y].weights.size(); j++)
            for (size_t x = 0; x < points_; x++)
                middle[y * points_ + x] += rows_[y].weights[j] * symmetric[(rows_[y].first + j) * points_ + x];
    std::fill(height_.begin(), height_.end(), 0.0);
    for (size_t y = 0; y < fine_; y++)
        for (size_t x = 0; x < fine_; x++)
            for (size_t j = 0; j < rows_[x].weights.size(); j++)
                height_[y * fine_ + x] += rows_[x].weights[j] * middle[y * points_ + rows_[x].first + j];
    double square = 0;
    for (size_t i = 0; i < height_.size(); i++)
        square += open_[i] > 0 ? height_[i] * height_[i] : 0;
    rms_ = std::sqrt(square / static_cast<double>(open_cells_));
    return rms_;
}

Buffer<double> LevelSet::covered(double slope) const {
    const size_t ratio = fine_ / coarse_;
    const double share = 1 / static_cast<double>(ratio * ratio);
    Buffer<double> covered(coarse_ * coarse_);
    for (size_t i = 0; i < height_.size(); i++)
        covered[i / fine_ / ratio * coarse_ + i % fine_ / ratio] += share * sigmoid(slope * height_[i] / rms_);
    return covered;
}

// With G_i the derivative by the height h_i at a fixed rms, and d rms/dh_i = h_i/(n rms) in the n open cells, that with
// the rms is G_i - h_i (sum over j of G_j h_j)/(n rms^2). That by the control points is its product with W^T and W.
Buffer<double> LevelSet::gradient(double slope, const Buffer<double> &by_covered) const {
    const size_t ratio = fine_ / coarse_;
    const double share = 1 / static_cast<double>(ratio * ratio);
    Buffer<double> by_height(fine_ * fine_);
    double along = 0; // sum of the derivative by g times h
    for (size_t i = 0; i < by_height.size(); i++) {
        const double c = sigmoid(slope * height_[i] / rms_);
        by_height[i] = share * slope * c * (1 - c) * by_covered[i / fine_ / ratio * coarse_ + i % fine_ / ratio] / rms_;
        along += by_height[i] * height_[i];
    }
    const double scale = along / (rms_ * rms_ * static_cast<double>(open_cells_));
    for (size_t i = 0; i < by_height.size(); i++)
        by_height[i] -= open_[i] > 0 ? scale * height_[i] : 0;
    Buffer<double> middle(fine_ * points_), gradient(points_ * points_);
    for (size_t y = 0; y < fine_; y++)
        for (size_t x = 0; x < fine_; x++)
            for (size_t j = 0; j < rows_[x].weights.size(); j++)
                middle[y * points_ + rows_[x].first + j] += rows_[x].weights[j] * by_height[y * fine_ + x];
    for (size_t y = 0; y < fine_; y++)
        for (size_t j = 0; j < rows_[y].weights.size(); j++)
            for (size_t x = 0; x < points_; x++)
                gradient[(rows_[y].first + j) * points_ + x] += rows_[y].weights[j] * middle[y * points_ + x];
    impose_symmetry(gradient);
    return gradient;
}

Buffer<uint8_t> LevelSet::cells() const {
    Buffer<uint8_t> cells(height_.size());
    for (size_t i = 0; i < cells.size(); i++)
        cells[i] = height_[i] > 0 ? 1 : 0;
    return cells;
}

} // namespace toliman::mask
