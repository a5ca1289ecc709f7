// C interface of the interpolation from every other sample.
#include <algorithm>
#include <cmath>

#include "optics/atlas.hpp"
#include "optics/nodes.hpp"
#include "optics/simulator.hpp"

using namespace toliman;

namespace {

struct HalfBandImages {
    HalfBandImages(const optics::Outline &outline, const optics::Plan &plan) {
        const optics::Mode mode = optics::zernike_mode(outline.pupil, 7);
        optics::Light light = plan.nodes ? optics::project_on_nodes(outline.light, plan.wavelengths) : outline.light;
        light.offset_px = {};
        const std::vector<std::vector<double>> spectra = {light.photons[0]};
        optics::ImageRequest request;
        request.plane = 2;
        request.focus = request.geometry = true;
        request.modes = {&mode};
        const optics::Imager imager(outline.scene, outline.pupil, plan, 2);
        optics::StarImages made = std::move(imager.images_of_spectra(light, spectra, request)[0]);
        for (optics::Derivative &derivative : made.derivatives)
            images.push_back(std::move(derivative.image));
        for (Buffer<double> *image : {&made.focus, &made.scale, &made.shear, &made.modes[0]})
            images.push_back(std::move(*image));
        Buffer<double> weights(images.back().size());
        for (size_t i = 0; i < weights.size(); i++) {
            weights[i] = std::sin(0.1 + 1.7 * static_cast<double>(i * i % 1013));
            forward += weights[i] * images.back()[i];
        }
        const Buffer<double> gradient = imager.opd_gradient_of_spectra(light, spectra, {weights});
        for (size_t cell = 0; cell < gradient.size(); cell++)
            adjoint += gradient[cell] * mode.opd_m[cell];
    }
    std::vector<Buffer<double>> images;
    double forward = 0, adjoint = 0; // the sum of weights times the derivative by the OPD
};

} // namespace

extern "C" {

size_t shim_half_band(double cutoff, double accuracy) {
    return optics::make_half_band(cutoff, accuracy).size();
}

// The sparse grid of a dense one.
void shim_sparse_size(double cutoff, double accuracy, size_t rows, size_t cols, size_t *sparse_rows,
                      size_t *sparse_cols) {
    const optics::Grid grid = optics::sparse_grid({rows, cols, 1e-6L}, optics::make_half_band(cutoff, accuracy));
    *sparse_rows = grid.rows;
    *sparse_cols = grid.cols;
}

// adjoint: from the dense grid to the sparse one.
void shim_half_band_apply(double cutoff, double accuracy, size_t rows, size_t cols, int adjoint, const double *from,
                          size_t count, double *to) {
    const optics::Grid dense = {rows, cols, 1e-6L};
    const optics::HalfBand weights = optics::make_half_band(cutoff, accuracy);
    const Buffer<double> in(from, from + count);
    const Buffer<double> out =
        adjoint != 0 ? optics::spread(in, dense, weights) : optics::interpolated(in, dense, weights);
    std::copy(out.begin(), out.end(), to);
}

// The images of star A of a scene around its own place, with derivatives by position, focus, scale, shear and an OPD,
// from all samples and from every other one: the largest differences over the largest value of each of ten images, and
// the relative difference of the derivative by the OPD and its adjoint. Returns the number of weights.
size_t shim_half_band_images(const char *scene_json, double accuracy, double *difference) {
    const optics::Outline outline = optics::outline_of(std::string(scene_json), "scene", ".", {});
    optics::Plan plan = optics::plan_around(outline.plan, {4, 4});
    const HalfBandImages every(outline, plan);
    plan.half_band = optics::make_half_band(plan.atlas.cutoff, accuracy);
    const HalfBandImages other(outline, plan);
    for (size_t i = 0; i < every.images.size(); i++) {
        double largest = 0, worst = 0;
        for (size_t pixel = 0; pixel < every.images[i].size(); pixel++) {
            largest = std::max(largest, std::fabs(every.images[i][pixel]));
            worst = std::max(worst, std::fabs(every.images[i][pixel] - other.images[i][pixel]));
        }
        difference[i] = worst / largest;
    }
    difference[every.images.size()] = std::fabs(other.forward - other.adjoint) / std::fabs(other.forward);
    return plan.half_band.size();
}
}
