// include/toliman/linear.h
#include <toliman/linear.h>

#include "api/common.hpp"
#include "api/frames_goodness.hpp"
#include "api/handles.hpp"
#include "api/pixel_frames.hpp"
#include "information/scene_model.hpp"

using namespace toliman;
using namespace toliman::api;

toliman_status toliman_linear_create(const toliman_sim *sim, const toliman_linear_options *options,
                                     toliman_linear **out) noexcept {
    return guard([&] {
        const toliman_linear_options known = accept(options, "options");
        const MemoryScope scope(memory_of(known.allocator));
        const Use use(sim, "sim");
        const auto &simulator = use->simulator;
        toliman_linear *&made = required(out, "out");
        made =
            new toliman_linear{{},
                               linear::TemplateEstimator(information::model_of(simulator, {known.log, known.log_data})),
                               known.threads};
    });
}

void toliman_linear_destroy(toliman_linear *linear) noexcept {
    destroy(linear);
}

toliman_status toliman_linear_encode(const toliman_linear *handle, const toliman_image *image, size_t count,
                                     double *values_px, toliman_frame_goodness *goodness) noexcept {
    return call(handle, "linear", [&](auto &self) {
        const linear::TemplateEstimator &estimator = self.estimator;
        if (count == 0)
            return;
        const PixelFrames frames = frames_of(image, count, estimator.rows(), estimator.cols());
        required(values_px, "values_px");
        FramesGoodness out(goodness, count);
        if (count == 1) {
            Buffer<double> converted;
            WorkPool<linear::TemplateWork>::Lease work(self.works);
            *values_px = estimator.estimate(frames.frame(0, converted), *work, out.found(), frames.window(0));
        } else
            estimator.estimate_many(frames, count, self.threads, values_px, out.found());
        out.deliver();
    });
}

toliman_status toliman_linear_get_sigma(const toliman_linear *handle, double *sigma_px) noexcept {
    return guard([&] {
        const double sigma = Use(handle, "linear")->estimator.sigma_px();
        required(sigma_px, "sigma_px") = sigma;
    });
}
