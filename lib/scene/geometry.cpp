#include "scene/geometry.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman {

Geometry geometry_of(const Detector &detector) noexcept {
    return {1 + detector.scale_anisotropy, detector.shear, 1 - detector.scale_anisotropy};
}

double pixels_along_axis(const Scene &scene) noexcept {
    const Geometry geometry = geometry_of(scene.detector);
    const Binary &binary = scene.binary;
    if (geometry.xx == 1 && geometry.yx == 0) // exact
        return 1;
    if (scene.stars.size() == 2 && !binary.by_offsets) {
        const double angle = (binary.position_angle_deg - scene.detector.rotation_deg) * kPi / 180;
        const auto pixels = geometry.to_pixels(-std::sin(angle), std::cos(angle));
        return std::hypot(pixels[0], pixels[1]);
    }
    const double *offset = binary.offsets_px;
    const double x = scene.stars.size() == 2 ? offset[2] - offset[0] : 1,
                 y = scene.stars.size() == 2 ? offset[3] - offset[1] : 0;
    const auto angle = geometry.to_angle(x, y);
    return std::hypot(x, y) / std::hypot(angle[0], angle[1]);
}

} // namespace toliman
