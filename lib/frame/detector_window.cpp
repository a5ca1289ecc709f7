#include "frame/detector_window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace toliman {

namespace {

std::vector<size_t> not_used(const Buffer<double> &variance) {
    std::vector<size_t> pixels;
    for (size_t i = 0; i < variance.size(); i++)
        if (!std::isfinite(variance[i]))
            pixels.push_back(i);
    return pixels;
}

} // namespace

KnownBadPixels::KnownBadPixels(size_t rows, size_t cols, std::vector<size_t> pixels,
                               const std::optional<DetectorWindow> &own)
    : rows_(rows), cols_(cols), pixels_(std::move(pixels)), own_(own) {}

KnownBadPixels::KnownBadPixels(size_t rows, size_t cols, const Buffer<double> &variance,
                               const std::optional<DetectorWindow> &own)
    : KnownBadPixels(rows, cols, own ? not_used(variance) : std::vector<size_t>(), own) {}

bool KnownBadPixels::add(const std::optional<DetectorWindow> &window, BadPixels &bad) const noexcept {
    if (!window || !move_with(*window))
        return true;
    const int64_t down = window->row - own_->row, right = window->col - own_->col;
    for (const size_t pixel : pixels_) {
        const int64_t row = static_cast<int64_t>(pixel / cols_) - down,
                      col = static_cast<int64_t>(pixel % cols_) - right;
        if (row < 0 || col < 0 || row >= static_cast<int64_t>(rows_) || col >= static_cast<int64_t>(cols_))
            continue;
        const size_t there = static_cast<size_t>(row) * cols_ + static_cast<size_t>(col);
        if (!std::binary_search(pixels_.begin(), pixels_.end(), there) && !bad.add(there))
            return false;
    }
    return true;
}

} // namespace toliman
