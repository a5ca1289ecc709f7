// Images of a run's scene for its report: pupil, point spread functions, noise-free and noisy frame.
#pragma once
#include <string>
#include <vector>

#include "common/json.hpp"
#include "run/reconstructions.hpp"
#include "scenes/scene.hpp"

namespace cli {

// An array [..][rows][cols] and the coordinates of its pixels in axis_unit: pixel [i][j] is at (first_x + j step,
// first_y + i step).
struct RunImage {
    std::string what, unit, axis_unit = "px";
    std::vector<size_t> shape;
    double first_x = 0, first_y = 0, step = 1;
    double min_nm, max_nm; // wavelengths; NaN for the pupil
    std::vector<double> values;
    std::string reason = {}; // of values that are all NaN; "" otherwise
};

// File names of the images, in the order of run_images and add_reconstructions.
constexpr const char *kRunImages[] = {"pupil_amplitude.npy", "pupil_opd.npy",     "psf_600nm.npy",
                                      "psf_550-600nm.npy",   "psf_500-700nm.npy", "expected.npy",
                                      "frame.npy",           "difference.npy",    "frames.npy",
                                      "reconstructions.npy", "residuals.npy"};
constexpr size_t kExpectedImage = 5; // index of "expected"

// All images but the last three. `telescope` is that of the scene.
std::vector<RunImage> run_images(const Scene &scene, const cJSON *telescope, uint64_t seed);
// Moves the last three images from the reconstructions.
void add_reconstructions(const Scene &scene, Reconstructions &from, std::vector<RunImage> &images);

const char *unit_of(const toliman_sim_info &info);

} // namespace cli
