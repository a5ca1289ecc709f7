// Errors of two ways to displace a star: interpolation of an oversampled image, and the simulator's Taylor expansion.
#pragma once
#include <vector>

#include "common/json.hpp"
#include "scenes/scene.hpp"

namespace cli {

// Errors of the image of one displacement: the largest error of a pixel, divided by the largest change of a pixel that
// the displacement causes.
struct DisplacementErrors {
    double displacement_px = 0;
    double linear = 0, cubic = 0; // interpolated images, of a star that is a third of a pixel off the grid
    double linear_change = 0, cubic_change = 0; // interpolated image less that without the displacement
    double taylor = 0;
};

// For displacements of 1e-2, 1e-3 ... 1e-6 px, by the telescope of a scene in a band of wavelengths. Empty if the
// library refuses a star with this pupil and these pixels, a fifth of those of the scene.
std::vector<DisplacementErrors> displacement_errors(const std::string &path, const cJSON *telescope, double min_nm,
                                                    double max_nm, double pixel_scale_arcsec);

} // namespace cli
