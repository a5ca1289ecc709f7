// include/toliman/components.h
#include <toliman/components.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/pixel_frames.hpp"
#include "base/workers.hpp"
#include "information/scene_model.hpp"
#include "linear/components.hpp"
#include "linear/residuals.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_components : Handle<toliman_components> {
    static constexpr char kType[] = "toliman_components";
    linear::Residuals residuals;
    Buffer<double> gram = {}; // inner products of all frames; empty until the first training after a push
    linear::Components trained = {};
};

namespace {

constexpr uint32_t kMostFrames = 16384; // 16384^2 products of 8 bytes are 2 GiB

linear::Preparation preparation_of(const toliman_components_options &options, int64_t cadence) {
    const int64_t capacity = options.capacity != 0 ? options.capacity : cadence;
    if (capacity < 2 || capacity > kMostFrames)
        fail(Status::argument, "{options->capacity} = 0: the scene's cadence has %lld frames: must be in [2, %u]",
             static_cast<long long>(capacity), kMostFrames);
    return {options.raw != 0, options.bin, static_cast<size_t>(capacity)};
}

toliman_components_train_options known_options(const toliman_components_train_options *given) {
    auto options = accept(given, "options");
    return options;
}

linear::DictionaryOptions dictionary_of(const toliman_components_train_options &options, const Progress &progress) {
    linear::DictionaryOptions known;
    known.count = options.components;
    TOLIMAN_COPY(known, options, lambda, iterations, seed);
    known.progress = progress;
    return known;
}

} // namespace

extern "C" {

toliman_status toliman_components_create(const toliman_sim *sim, const toliman_components_options *options,
                                         toliman_components **out) noexcept {
    return call(sim, "sim", [&](auto &self) {
        const auto &simulator = self.simulator;
        toliman_components *&made = required(out, "out");
        const auto known = accept(options, "options");
        const linear::Preparation preparation = preparation_of(known, simulator.scene().cadence.frames);
        const MemoryScope scope(memory_of(known.allocator));
        const Log log = preparation.raw ? Log() : Log{known.log, known.log_data}; // raw counts are not projected
        made = new toliman_components{{}, linear::Residuals(information::model_of(simulator, log), preparation)};
    });
}

void toliman_components_destroy(toliman_components *components) noexcept {
    destroy(components);
}

toliman_status toliman_components_push(toliman_components *handle, const toliman_image *image, size_t count) noexcept {
    return call(handle, "components", [&](auto &self) {
        linear::Residuals &residuals = self.residuals;
        if (count == 0)
            return;
        residuals.push_many(frames_of(image, count, residuals.rows(), residuals.cols()), count);
        self.gram.clear();
        self.trained = {};
    });
}

toliman_status toliman_components_train(toliman_components *handle, const toliman_components_train_options *options,
                                        toliman_components_training *report) noexcept {
    return call(handle, "components", [&](auto &self) {
        const linear::Residuals &residuals = self.residuals;
        const toliman_components_train_options known = known_options(options);
        if (report != nullptr)
            check_struct_size("report", *report);
        if (residuals.frames() <= known.components)
            fail(Status::state, "%u components need at least %u frames, %zu were pushed", known.components,
                 known.components + 1, residuals.frames());

        const Progress progress{known.progress, known.progress_data};
        if (self.gram.empty())
            self.gram = residuals.gram(worker_count(known.threads),
                                       [&](double fraction) { progress.report("products", fraction); });
        self.trained = known.method == TOLIMAN_COMPONENTS_PCA
                           ? linear::principal_components(residuals.frames(), self.gram, known.components)
                           : linear::sparse_dictionary(residuals.frames(), self.gram, residuals.pixels(),
                                                       dictionary_of(known, progress));
        const linear::Components &trained = self.trained;
        if (report != nullptr)
            deliver(toliman_components_training{sizeof *report, static_cast<uint32_t>(trained.iterations),
                                                trained.converged ? 1 : 0, 0, trained.objective},
                    report, "report");
    });
}

toliman_status toliman_components_get_series(const toliman_components *handle, int64_t component, double *values,
                                             double *share) noexcept {
    return call(handle, "components", [&](auto &self) {
        const linear::Components &trained = self.trained;
        if (trained.frames == 0)
            fail(Status::state, "components: not trained, or not since the last push");
        const size_t at = required_index(component, trained.share.size(), "component");
        if (values != nullptr)
            std::copy_n(&trained.series[at * trained.frames], trained.frames, values);
        if (share != nullptr)
            *share = trained.share[at];
    });
}

toliman_status toliman_components_get_info(const toliman_components *handle, toliman_components_info *out) noexcept {
    return query(handle, "components", out, [&](auto &self, auto &info) {
        const linear::Residuals &residuals = self.residuals;
        TOLIMAN_COPY(info, residuals.preparation(), raw, bin, capacity);
        info.projected = static_cast<uint32_t>(residuals.projected());
        info.frames = static_cast<int64_t>(residuals.frames());
        info.pixels = static_cast<int64_t>(residuals.pixels());
        info.components = static_cast<int64_t>(self.trained.share.size());
        info.crb_px = residuals.crb_px();
        info.threshold_px = residuals.threshold_px();
    });
}

} // extern "C"
