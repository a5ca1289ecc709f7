#include "information/scene_model.hpp"

#include "base/error.hpp"
#include "information/dependence.hpp"
#include "information/information.hpp"

namespace toliman::information {

// Images in the frame's unit; the bound, in px, does not depend on the unit.
FrameModel model_of(const optics::Simulator &simulator, const Log &log) {
    using optics::Quantity;
    const Scene &scene = simulator.scene();
    const optics::DetectorStages &detector = simulator.detector();
    const optics::Images &images = simulator.images();
    if (scene.detector.window && !scene.detector.response.empty())
        fail(Status::unsupported,
             "%s: {detector.response}: an estimator that is trained cannot follow it to frames of another window: use "
             "a fit, or remove detector.window",
             scene.source.c_str());
    FrameModel model;
    model.source = scene.source;
    model.rows = scene.detector.rows;
    model.cols = scene.detector.cols;
    const auto derivative = [&](const Buffer<double> &image) {
        return detector.in_counts(Quantity::derivative, images.both(), image);
    };
    model.reference = detector.in_counts(images.both());
    model.background = detector.counts_of(detector.dark_e());
    model.variance = detector.in_counts(Quantity::variance, images.both(), images.variance());
    model.derivative = derivative(images.motion()[0]);
    images.prepare(scene.projected);
    for (const Parameter parameter : scene.projected)
        model.projected.push_back({name_of(parameter), derivative(image_of(images, parameter))});
    model.crb_px = bound_with(simulator.bound_images(), scene.projected);
    model.scene_digest = scene.digest;
    model.window = scene.detector.window;
    warn_of_dependence(model, log);
    return model;
}

} // namespace toliman::information
