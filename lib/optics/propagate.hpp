// Propagates a star from the pupil to its polychromatic image, with exact derivatives by its position and by focus.
#pragma once
#include <functional>
#include <memory>

#include "base/buffer.hpp"
#include "optics/light.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

constexpr size_t kWavelengthChunks = 8; // fixed, so that the order of summation does not depend on the workers

// The derivatives to compute: by position, all orders up to `along` along light.axis, and all mixed orders with a total
// of at most `plane` along and across it.
struct ImageRequest {
    size_t along = 0, plane = 0;
    bool focus = false;                   // also the derivatives by defocus and by the image's scale; needs plane >= 1
    bool focus_curve = false;             // with focus: also the second derivative by defocus
    bool geometry = false;                // also the derivatives by the detector's geometry; needs plane >= 1
    std::vector<const Mode *> modes = {}; // also the derivatives by these modes of the pupil
};

// Expected photons per pixel [rows][cols], per px^(along + across). The across axis is the along axis rotated by 90 deg
// from x towards y.
struct Derivative {
    size_t along, across;
    Buffer<double> image;
};

struct StarImages {
    std::vector<Derivative> derivatives; // the first is the image itself
    Buffer<double> focus, focus_curve;   // per nm rms of defocus (Noll's fourth polynomial), and per nm^2
    Buffer<double> scale;                // per relative scale of the image about the optical axis
    Buffer<double> anisotropy, shear;    // by the detector's scale_anisotropy and shear
    std::vector<Buffer<double>> modes;   // per unit of each mode

    // The derivative of that order, which must have been requested.
    const Buffer<double> &at(size_t along, size_t across) const noexcept;
};

// Creates the transform of one thread for a number of fields on a grid.
using Engine = std::function<std::unique_ptr<Transform>(const Grid &grid, size_t fields)>;

// Images of star 0 (A) or 1 (B) displaced by displacement_px along light.axis. Offsets of light are in units of the
// grid's pitch. Calls on_progress(fraction) on the caller's thread; it may throw. The bits do not depend on workers.
StarImages propagate(const Engine &engine, const Light &light, const Grid &grid, size_t star, double displacement_px,
                     const ImageRequest &request, unsigned workers,
                     const std::function<void(double)> &on_progress = nullptr);

// The images that star 0 would have with each of these spectra, [spectrum][wavelength] in photons, instead of its own:
// they have their transforms in common.
std::vector<StarImages> propagate(const Engine &engine, const Light &light, const Grid &grid,
                                  const std::vector<std::vector<double>> &spectra, const ImageRequest &request,
                                  unsigned workers, const std::function<void(double)> &on_progress = nullptr);

} // namespace toliman::optics
