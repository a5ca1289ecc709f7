// C interface of the gradient by the OPD of several images at once, and of one after the other.
#include <string>

#include "optics/nodes.hpp"
#include "optics/simulator.hpp"

using namespace toliman;
using namespace toliman::optics;

// Both stars at (x, y) px, with weights [2][pixels]. Returned: joint, single [N][N], the latter the sum of the stars.
extern "C" void shim_joint_gradient(const char *json, double x, double y, unsigned workers, const double *weights,
                                    double *joint, double *single) {
    const Outline outline = outline_of(std::string(json), "scene", ".", {});
    const Imager imager(outline.scene, outline.pupil, outline.plan, workers);
    Light light = outline.light;
    light.offset_px = {{{x, y}, {x, y}}};
    const size_t pixels = outline.plan.pixels.rows * outline.plan.pixels.cols;
    std::vector<Buffer<double>> of_stars;
    for (size_t star = 0; star < 2; star++)
        of_stars.emplace_back(weights + star * pixels, weights + (star + 1) * pixels);
    const Light nodes = outline.plan.nodes ? project_on_nodes(light, outline.plan.wavelengths) : light;
    const Buffer<double> both = imager.opd_gradient_of_spectra(nodes, {nodes.photons[0], nodes.photons[1]}, of_stars);
    const Buffer<double> a = imager.opd_gradient(light, 0, of_stars[0]), b = imager.opd_gradient(light, 1, of_stars[1]);
    for (size_t i = 0; i < both.size(); i++) {
        joint[i] = both[i];
        single[i] = a[i] + b[i];
    }
}
