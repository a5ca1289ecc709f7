// A mask as the set of cells where a smooth height is positive, and its softened form, which has a gradient.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/buffer.hpp"

namespace toliman::mask {

// Of the heights under a rotation of the pupil by 180 degrees: none, equal, or of opposite sign.
enum class Symmetry { none, even, odd };

class LevelSet {
  public:
    // points: control points per axis, over the whole aperture. smoothing: standard deviation of the Gaussian that
    // interpolates between them, in their distances. fine: cells of the mask per axis, a multiple of coarse. open
    // [fine] [fine]: above 0 in cells that transmit light.
    LevelSet(size_t points, double smoothing, size_t fine, size_t coarse, const Buffer<double> &open,
             Symmetry symmetry);

    size_t points() const noexcept { return points_; }

    // Sets the heights of the control points [points][points], made symmetric. Returns their rms over the open cells,
    // which must not be 0 for what follows.
    double set(const Buffer<double> &heights);

    // Fraction of each coarse cell that is covered, [coarse][coarse]: the mean over its fine cells of the sigmoid of
    // slope times the height, which is scaled to an rms of 1 over the open cells.
    Buffer<double> covered(double slope) const;

    // The derivative of a function by the heights, from that by covered(slope).
    Buffer<double> gradient(double slope, const Buffer<double> &by_covered) const;

    // 1 where the height is positive, [fine][fine].
    Buffer<uint8_t> cells() const;

  private:
    // Weights of the control points first ... first + taps - 1 along one axis, for a row of fine cells.
    struct Row {
        size_t first;
        std::vector<double> weights;
    };
    void impose_symmetry(Buffer<double> &heights) const;

    size_t points_, fine_, coarse_;
    Symmetry symmetry_;
    Buffer<double> open_;
    size_t open_cells_ = 0;
    std::vector<Row> rows_;
    Buffer<double> height_; // of the fine cells, before the scaling
    double rms_ = 1;
};

} // namespace toliman::mask
