// From the pupil to a star's image in all its light, with exact derivatives by its place and by focus.
#pragma once
#include <functional>
#include <vector>

#include "base/buffer.hpp"
#include "optics/light.hpp"
#include "optics/pupil.hpp"

namespace toliman::optics {

// The pixels on which images are computed, symmetric about the axis.
struct Grid {
    size_t rows, cols;
    long double pitch_rad; // double would put the edge of a frame 1e-14 px off
};

// Derivatives by a star's place that are asked for: all along light.axis up to order `along`, and all of order <= `plane`
// along and across it.
struct Wanted {
    size_t along = 0, plane = 0;
    bool focus = false; // also the derivatives by defocus and by a stretch of the image
};

// Expected photons per pixel [rows][cols], per px^(along + across); across is along turned from x towards y.
struct Derivative {
    size_t along, across;
    Buffer<double> image;
};

struct StarImages {
    std::vector<Derivative> derivatives; // the first is the image itself
    Buffer<double> focus;                // per nm rms of defocus (Noll's fourth)
    Buffer<double> scale;                // by a stretch of the image about the axis, relative

    const Buffer<double> &at(size_t along, size_t across) const noexcept;
};

// Images of star 0 (A) or 1 (B) moved by displacement_px along light.axis; offsets of light are in units of the grid's
// pitch. `done` hears the fraction on the caller's thread and may throw. The bits do not depend on workers.
StarImages propagate(const Pupil &pupil, const Light &light, const Grid &grid, size_t star, double displacement_px,
                     const Wanted &wanted, unsigned workers, const std::function<void(double)> &done = nullptr);

} // namespace toliman::optics
