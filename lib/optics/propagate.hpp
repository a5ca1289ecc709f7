// From the pupil to a star's image in all its light, with exact derivatives by its place and by focus.
#pragma once
#include <functional>
#include <memory>

#include "base/buffer.hpp"
#include "optics/light.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

constexpr size_t kWavelengthChunks = 8; // fixed, so that sums have one order on any number of workers

// Derivatives by a star's place that are asked for: all along light.axis up to order `along`, and all of order <=
// `plane` along and across it.
struct Wanted {
    size_t along = 0, plane = 0;
    bool focus = false;       // also the derivatives by defocus and by a stretch of the image
    bool focus_curve = false; // with focus: the second derivative by defocus, too
};

// Expected photons per pixel [rows][cols], per px^(along + across); across is along turned from x towards y.
struct Derivative {
    size_t along, across;
    Buffer<double> image;
};

struct StarImages {
    std::vector<Derivative> derivatives; // the first is the image itself
    Buffer<double> focus, focus_curve;   // per nm rms of defocus (Noll's fourth), and per its square
    Buffer<double> scale;                // by a stretch of the image about the axis, relative

    const Buffer<double> &at(size_t along, size_t across) const noexcept;
};

// Makes the transform of one thread for so many fields on a grid.
using Engine = std::function<std::unique_ptr<Transform>(const Grid &grid, size_t fields)>;

// Images of star 0 (A) or 1 (B) moved by displacement_px along light.axis; offsets of light are in units of the grid's
// pitch. `done` hears the fraction on the caller's thread and may throw. The bits do not depend on workers.
StarImages propagate(const Engine &engine, const Light &light, const Grid &grid, size_t star, double displacement_px,
                     const Wanted &wanted, unsigned workers, const std::function<void(double)> &done = nullptr);

} // namespace toliman::optics
