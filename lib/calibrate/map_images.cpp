// Method: an OPD dz adds the field (2 pi i/lambda) E dz to the pupil field E, whose transform G changes the image by
// 2 Re(conj(F) G). This is linear in dz: the product of the derivatives by all cells, which form a matrix of the number
// of pixels times that of cells, with a vector costs two transforms per wavelength, and that with its adjoint two more
// (optics/gradient.cpp). Both stars have them in common.
#include "calibrate/map_images.hpp"

#include "optics/nodes.hpp"

namespace toliman::calibrate {

namespace {

optics::Light light_of(const optics::Outline &outline, const optics::Plan &plan) {
    optics::Light light = plan.nodes ? optics::project_on_nodes(outline.light, plan.wavelengths) : outline.light;
    light.offset_px = {};
    return light;
}

} // namespace

MapImages::MapImages(const optics::Outline &outline, const Planes &planes)
    : atlas_(planes.atlas()), plan_(optics::plan_around(planes.plan(), planes.reach())),
      light_(light_of(outline, plan_)), spectra_{light_.photons[0], light_.photons[1]},
      imager_(outline.scene, outline.pupil, plan_, plan_.workers) {}

StarSamples MapImages::images_of(const Buffer<double> &opd_m) const {
    optics::Mode mode;
    mode.opd_m = opd_m;
    optics::ImageRequest request;
    request.modes.push_back(&mode);
    const std::vector<optics::StarImages> images = imager_.images_of_spectra(light_, spectra_, request);
    return {atlas_.samples_of(0, images[0].modes[0]), atlas_.samples_of(1, images[1].modes[0])};
}

Buffer<double> MapImages::gradient_of(const StarSamples &weights) const {
    return imager_.opd_gradient_of_spectra(light_, spectra_,
                                           {atlas_.image_weights(0, weights[0]), atlas_.image_weights(1, weights[1])});
}

} // namespace toliman::calibrate
