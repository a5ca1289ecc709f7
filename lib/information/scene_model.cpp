#include "information/scene_model.hpp"

#include "information/dependence.hpp"
#include "information/information.hpp"

namespace toliman::information {

// Images in the frame's unit; the bound, in px, does not depend on the unit.
FrameModel model_of(const optics::Simulator &simulator, const Log &log) {
    using optics::Quantity;
    const Scene &scene = simulator.scene();
    const optics::DetectorStages &detector = simulator.detector();
    const optics::Images &images = simulator.images();
    FrameModel model;
    model.source = scene.source;
    model.rows = scene.detector.rows;
    model.cols = scene.detector.cols;
    model.reference = detector.in_counts(images.both(), Quantity::frame);
    model.background = detector.counts_of(detector.dark_e());
    model.variance = detector.in_counts(images.variance(), Quantity::variance);
    model.derivative = detector.in_counts(images.motion()[0], Quantity::derivative);
    images.prepare(scene.projected);
    for (const Parameter parameter : scene.projected)
        model.projected.push_back(
            {name_of(parameter), detector.in_counts(image_of(images, parameter), Quantity::derivative)});
    model.crb_px = bound_with(simulator.bound_images(), scene.projected);
    model.scene_digest = scene.digest;
    model.window = scene.detector.window;
    warn_of_dependence(model, log);
    return model;
}

} // namespace toliman::information
