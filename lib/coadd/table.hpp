// Images of the stars and their slopes at all places on a grid of sub-pixel steps, in 16-bit integers.
#pragma once
#include <cmath>
#include <vector>

#include "base/buffer.hpp"
#include "fit/fit.hpp"
#include "kernels/coadd.hpp"

namespace toliman::coadd {

// A place on the grid, in steps from the predicted place.
struct Cell {
    int x = 0, y = 0;
    bool operator==(const Cell &other) const noexcept { return x == other.x && y == other.y; }
};

class Table {
  public:
    // For places of the stars up to `range` whole pixels from the predicted ones along x and y, `steps` per pixel.
    Table(const fit::Fit &fit, const fit::Prediction &prediction, int range, int steps, unsigned workers,
          const Progress &progress);

    Cell nearest(double x, double y) const noexcept {
        return {static_cast<int>(std::lround(x * steps_)), static_cast<int>(std::lround(y * steps_))};
    }
    double place(int steps) const noexcept { return static_cast<double>(steps) / steps_; }
    int steps() const noexcept { return steps_; }
    double range() const noexcept { return range_; } // px
    bool covers(const Cell &cell) const noexcept {
        return std::abs(cell.x) <= range_ * steps_ && std::abs(cell.y) <= range_ * steps_;
    }
    // The images of a place that is covered.
    kernels::CoaddModel model(const Cell &cell) const noexcept;

    double most_photons() const noexcept; // of a pixel in any image
    size_t bytes() const noexcept { return values_.size() * sizeof values_[0]; }

  private:
    void draw(const fit::Fit &fit, const double *values, size_t phase, fit::Work &work, Buffer<double> &scratch);
    uint16_t *image(size_t phase, size_t which) noexcept { return &values_[(phase * 3 + which) * rows_ * stride_]; }

    int range_, steps_;
    size_t rows_, cols_, stride_;                  // of an image: those of a frame, and `range` more on each side
    std::vector<float> light_scale_, slope_scale_; // of each phase
    UnsetBuffer<uint16_t> values_;                 // [steps^2][light, slope_x, slope_y][rows][stride]
};

} // namespace toliman::coadd
