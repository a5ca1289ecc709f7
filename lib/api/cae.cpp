// include/toliman/cae.h. Training replaces the handle's immutable network only after it has succeeded; its state is
// kept in the handle, so that a cancelled training can be resumed.
#include <toliman/cae.h>

#include "api/cae_choices.hpp"
#include "api/common.hpp"
#include "api/frames_goodness.hpp"
#include "api/handles.hpp"
#include "api/pixel_frames.hpp"
#include "backend/file.hpp"
#include "cae/network.hpp"
#include "cae/tied.hpp"
#include "cae/unsupervised.hpp"
#include "cae/weights.hpp"
#include "information/scene_model.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

template <class T> T or_default(T value, T otherwise) noexcept {
    return value != 0 ? value : otherwise;
}

constexpr Choice<cae::Input> kInputs = {TOLIMAN_CAE_INPUT_WHITENED, TOLIMAN_CAE_INPUT_RAW, "TOLIMAN_CAE_INPUT_..."};
constexpr Choice<cae::Centre> kCentres = {TOLIMAN_CAE_CENTRE_SCENE, TOLIMAN_CAE_CENTRE_IMAGE, "TOLIMAN_CAE_CENTRE_..."};
constexpr Choice<cae::Mode> kModes = {TOLIMAN_CAE_MODE_TIED, TOLIMAN_CAE_MODE_UNSUPERVISED, "TOLIMAN_CAE_MODE_..."};

toliman_cae_train_options known_train_options(const toliman_cae_train_options *given) {
    toliman_cae_train_options options = accept(given, "options");
    if (options.loss_count > 0)
        required(options.losses, "options->losses");
    return options;
}

// Runs work on the state of the last training if it has the same options and is not beyond `until`, else on a new one.
// If the new one fails before its first step or epoch, the last state is restored.
template <class Work> void resume_training(toliman_cae &cae, const cae::Course &course, uint32_t until, Work work) {
    std::optional<cae::Training> last;
    if (!cae.training || !(cae.training->course == course) || cae.training->done > until) {
        last = std::exchange(cae.training, cae::Training(cae.network.layout()));
        cae.training->course = course;
    }
    try {
        work(*cae.training);
    } catch (...) {
        if (cae.training->done == 0)
            cae.training = std::move(last);
        throw;
    }
}

// State of the last training; NULL if there is nothing to resume.
const cae::Training *training_of(const toliman_cae &cae) noexcept {
    return cae.training && cae.training->done > 0 ? &*cae.training : nullptr;
}

// The options of a training; all 0 for NULL.
toliman_cae_train_options resumable_of(const cae::Training *training) noexcept {
    toliman_cae_train_options options = {};
    if (training == nullptr)
        return options;
    const cae::Course &course = training->course;
    options.mode = kModes.to_constant(course.mode);
    options.steps = course.mode == cae::Mode::unsupervised ? training->done : static_cast<uint32_t>(course.total);
    TOLIMAN_COPY(options, course, learning_rate, validation, batch);
    options.frame_count = course.frames;
    return options;
}

toliman_cae_training train_tied(toliman_cae &cae, const toliman_cae_train_options &options) {
    cae::TiedOptions known;
    known.steps = options.steps;
    known.learning_rate = or_default(options.learning_rate, known.learning_rate);
    known.progress = {options.progress, options.progress_data};
    known.losses = {options.losses, options.loss_count};
    toliman_cae_training report = {};
    resume_training(cae, known.course(), known.steps, [&](cae::Training &state) {
        cae.network = cae::train_tied(cae.network, known, state);
        report.loss = state.loss;
    });
    report.steps = known.steps;
    report.cosine = cae.network.cosine();
    return report;
}

cae::FrameSource frame_source(const toliman_cae_train_options &options) {
    required(reinterpret_cast<const void *>(options.frames), "options->frames");
    return [call = options.frames, data = options.frames_data](size_t first, size_t count, double *counts) {
        const toliman_status status = in_callback("frames", [&] { return call(first, count, counts, data); });
        if (status != TOLIMAN_OK)
            fail(static_cast<Status>(status), "{frames} %zu to %zu: the frames callback returned %s", first,
                 first + count - 1, toliman_constant_name(status));
    };
}

cae::UnsupervisedOptions unsupervised_options(const toliman_cae_train_options &options) {
    if (options.frame_count < 2 || options.frame_count > cae::kMostFrames)
        fail(Status::argument, "{options->frame_count} = %llu: must be in [2, %llu]",
             static_cast<unsigned long long>(options.frame_count), static_cast<unsigned long long>(cae::kMostFrames));
    if (options.validation >= options.frame_count)
        fail(Status::argument, "{options->validation} = %llu: must be below frame_count = %llu",
             static_cast<unsigned long long>(options.validation), static_cast<unsigned long long>(options.frame_count));
    cae::UnsupervisedOptions known;
    known.epochs = options.steps;
    known.batch = options.batch;
    known.workers = options.threads;
    known.learning_rate = or_default(options.learning_rate, known.learning_rate);
    known.frames = options.frame_count;
    known.validation = or_default<size_t>(options.validation, std::max<size_t>((known.frames + 5) / 10, 1));
    known.progress = {options.progress, options.progress_data};
    known.losses = {options.losses, options.loss_count};
    return known;
}

toliman_cae_training result_of(const cae::Training &state, const cae::Quality &quality) {
    toliman_cae_training result = {};
    result.struct_size = sizeof result;
    TOLIMAN_COPY(result, state, steps, loss, validation_loss);
    result.epochs = state.done;
    TOLIMAN_COPY(result, quality, mmse, mssim, photon_floor);
    return result;
}

toliman_cae_training train_unsupervised(toliman_cae &cae, const toliman_cae_train_options &options) {
    cae::UnsupervisedOptions known = unsupervised_options(options);
    const cae::FrameSource frames = frame_source(options);
    const auto quality_of = [&](const cae::Network &network) {
        cae::UnsupervisedOptions quiet = known;
        quiet.progress = {};
        return cae::validate(network, options.epoch != nullptr ? quiet : known, frames);
    };
    toliman_cae_training result = {};
    if (options.epoch != nullptr)
        known.epoch = [&](const cae::Training &state) {
            const toliman_cae so_far = {{}, cae::trained_network(cae.network, state), state, cae.threads};
            result = result_of(state, quality_of(so_far.network));
            if (in_callback("epoch", [&] { return options.epoch(&so_far, &result, options.epoch_data); }) != 0)
                fail(Status::cancelled, "epoch %u: cancelled by the epoch callback", state.done);
        };
    resume_training(cae, known.course(), known.epochs, [&](cae::Training &state) {
        cae::train_unsupervised(cae.network, known, frames, state);
        cae::Network trained = cae::trained_network(cae.network, state);
        if (result.epochs != state.done)
            result = result_of(state, quality_of(trained));
        cae.network = std::move(trained);
    });
    return result;
}

std::vector<uint8_t> blob_of(const toliman_cae *cae, const toliman_cae_save_options *given) {
    const Use use(cae, "cae");
    const cae::Network &network = use->network;
    const toliman_cae_save_options options = accept(given, "options");
    return cae::to_blob(network,
                        {kEncodings.to_enum(options.weights_encoding), kEncodings.to_enum(options.planes_encoding)},
                        options.with_training != 0 ? training_of(*cae) : nullptr);
}

void store_network(cae::Blob &&blob, uint32_t threads, toliman_cae **out) {
    *out = new toliman_cae{{}, std::move(blob.network), std::move(blob.training), threads};
}

} // namespace

extern "C" {

toliman_status toliman_cae_create(const toliman_sim *sim, uint64_t seed, const toliman_cae_options *options,
                                  toliman_cae **out) noexcept {
    return call(sim, "sim", [&](auto &self) {
        const auto &simulator = self.simulator;
        const toliman_cae_options known = accept(options, "options");
        const Detector &detector = simulator.scene().detector;
        const cae::Layout &layout = layout_of(known.layout, detector.rows, detector.cols);
        required(out, "out");
        const MemoryScope scope(memory_of(known.allocator));
        store_network({cae::untrained_network(layout,
                                              cae::Preprocess::from_model(
                                                  information::model_of(simulator, {known.log, known.log_data}), layout,
                                                  kInputs.to_enum(known.input), kCentres.to_enum(known.centre)),
                                              seed),
                       std::nullopt},
                      known.threads, out);
    });
}

void toliman_cae_destroy(toliman_cae *cae) noexcept {
    destroy(cae);
}

toliman_status toliman_cae_train(toliman_cae *cae, const toliman_cae_train_options *options,
                                 toliman_cae_training *report) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const toliman_cae_train_options known = known_train_options(options);
        if (report != nullptr)
            check_struct_size("report", *report);
        const toliman_cae_training training =
            known.mode == TOLIMAN_CAE_MODE_TIED ? train_tied(self, known) : train_unsupervised(self, known);
        if (report != nullptr)
            deliver(training, report, "report");
    });
}

toliman_status toliman_cae_get_info(const toliman_cae *cae, toliman_cae_train_options *resumable,
                                    toliman_cae_info *out) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const cae::Network &network = self.network;
        const cae::Preprocess &preprocess = network.preprocess();
        toliman_cae_info info = {};
        info.trained = network.trained() ? 1 : 0;
        info.layout = network.layout().name;
        info.layout_hash = cae::layout_hash(network.layout());
        info.input = kInputs.to_constant(preprocess.input);
        TOLIMAN_COPY(info, preprocess, scene_digest, rows, cols, crop_row, crop_col);
        TOLIMAN_COPY(info, preprocess, projected, crb_px, input_scale, side);
        info.parameters = network.layout().parameters();
        info.cosine = network.cosine();
        info.seed = network.seed();
        info.centre = kCentres.to_constant(preprocess.centre);
        if (resumable != nullptr)
            check_struct_size("resumable", *resumable);
        deliver(info, out, "out");
        if (resumable != nullptr)
            deliver(resumable_of(training_of(self)), resumable, "resumable");
    });
}

toliman_status toliman_cae_encode(const toliman_cae *cae, const toliman_image *image, size_t count, double *latents_px,
                                  toliman_frame_goodness *goodness) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const cae::Network &network = self.network;
        if (count == 0)
            return;
        const PixelFrames frames = frames_of(image, count, network.preprocess().rows, network.preprocess().cols);
        required(latents_px, "latents_px");
        FramesGoodness out(goodness, count);
        if (count == 1) {
            Buffer<double> converted;
            WorkPool<cae::Workspace>::Lease work(self.works);
            *latents_px = network.encode(frames.frame(0, converted), *work, out.found(), frames.window(0));
        } else
            network.encode_many(frames, count, self.threads, latents_px, out.found());
        out.deliver();
    });
}

toliman_status toliman_cae_decode(const toliman_cae *cae, double latent_px, double *image, size_t stride) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const cae::Network &network = self.network;
        const size_t side = network.layout().side;
        required_image(image, stride, side, "image");
        Buffer<double> output(side * side);
        network.decode(latent_px, output.data());
        copy_rows(output.data(), side, side, image, stride);
    });
}

toliman_status toliman_cae_get_target(const toliman_cae *cae, double *image, size_t stride) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const cae::Network &network = self.network;
        const size_t side = network.layout().side;
        copy_rows(network.preprocess().target.data(), side, side, required_image(image, stride, side, "image"), stride);
    });
}

toliman_status toliman_cae_reconstruct(const toliman_cae *cae, const double *counts, size_t counts_stride,
                                       double *image, size_t stride, double *mmse, double *mssim,
                                       double *photon_floor) noexcept {
    return call(cae, "cae", [&](auto &self) {
        const cae::Network &network = self.network;
        const cae::Preprocess &preprocess = network.preprocess();
        const ImageView<const double> frame = {required_image(counts, counts_stride, preprocess.cols, "counts"),
                                               preprocess.rows, preprocess.cols, counts_stride};
        const size_t side = preprocess.side;
        required_image(image, stride, side, "image");
        Buffer<double> output(side * side);
        network.reconstruct(frame, output.data());
        const bool compare = mmse != nullptr || mssim != nullptr || photon_floor != nullptr;
        const cae::Quality quality = compare ? cae::quality(network, frame, output.data()) : cae::Quality{};
        copy_rows(output.data(), side, side, image, stride);
        if (mmse != nullptr)
            *mmse = quality.mmse;
        if (mssim != nullptr)
            *mssim = quality.mssim;
        if (photon_floor != nullptr)
            *photon_floor = quality.photon_floor;
    });
}

toliman_status toliman_cae_save(const toliman_cae *cae, const toliman_cae_save_options *options, void *bytes,
                                size_t capacity, size_t *needed) noexcept {
    return guard([&] { deliver_bytes(blob_of(cae, options), bytes, capacity, needed); });
}

toliman_status toliman_cae_load(const void *bytes, size_t size, const toliman_load_options *options,
                                toliman_cae **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(bytes, "bytes");
        required(out, "out");
        store_network(cae::from_blob(bytes, size), threads_of(options), out);
    });
}

toliman_status toliman_cae_save_file(const toliman_cae *cae, const toliman_cae_save_options *options,
                                     const char *path) noexcept {
    return guard([&] {
        const std::vector<uint8_t> bytes = blob_of(cae, options);
        file::replace(&required(path, "path"), bytes.data(), bytes.size());
    });
}

toliman_status toliman_cae_load_file(const char *path, const toliman_load_options *options,
                                     toliman_cae **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(path, "path");
        required(out, "out");
        const std::vector<uint8_t> bytes = file::read(path, cae::kMaxBlob);
        in_file(path, [&] { store_network(cae::from_blob(bytes.data(), bytes.size()), threads_of(options), out); });
    });
}

} // extern "C"
