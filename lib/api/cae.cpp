// include/toliman/cae.h: unwrap, call, convert.
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <toliman/cae.h>

#include "api/bytes_out.hpp"
#include "api/guard.hpp"
#include "api/handles.hpp"
#include "backend/file.hpp"
#include "cae/network.hpp"
#include "cae/tied.hpp"
#include "cae/weights.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_cae {
    cae::Network network;
};

namespace {

constexpr size_t kOldestOptions = sizeof(toliman_cae_train_options);
constexpr size_t kOldestSaveOptions = sizeof(toliman_cae_save_options);
constexpr size_t kOldestTraining = sizeof(toliman_cae_training);
constexpr size_t kOldestInfo = sizeof(toliman_cae_info);

toliman_cae_train_options default_options() noexcept {
    toliman_cae_train_options options = {};
    options.struct_size = sizeof options;
    return options;
}

cae::TrainOptions known_options(const toliman_cae_train_options *given) {
    const toliman_cae_train_options options = accept(given, default_options(), "options", kOldestOptions);
    if (!(options.learning_rate >= 0 && options.learning_rate <= 1))
        fail(Status::argument, "options->learning_rate = %g: must be in [0, 1], 0 for the default",
             options.learning_rate);
    cae::TrainOptions known;
    known.steps = options.steps != 0 ? options.steps : known.steps;
    known.learning_rate = options.learning_rate != 0 ? options.learning_rate : known.learning_rate;
    known.progress = {options.progress, options.progress_data};
    return known;
}

cae::Encoding known_encoding(int32_t code, const char *name) {
    if (code < 0 || code >= static_cast<int32_t>(cae::kEncodings))
        fail(Status::argument, "options->%s = %d: must be 0 (float32), 1 (bf16) or 2 (fp16)", name, code);
    return static_cast<cae::Encoding>(code);
}

toliman_cae_save_options default_save_options() noexcept {
    toliman_cae_save_options options = {};
    options.struct_size = sizeof options;
    return options;
}

std::vector<uint8_t> blob_of(const toliman_cae *cae, const toliman_cae_save_options *given) {
    const cae::Network &network = required(cae, "cae").network;
    const toliman_cae_save_options options = accept(given, default_save_options(), "options", kOldestSaveOptions);
    return cae::to_blob(network, {known_encoding(options.weights_encoding, "weights_encoding"),
                                  known_encoding(options.planes_encoding, "planes_encoding")});
}

ImageView<const double> frame_of(const cae::Network &network, const double *counts, size_t stride) {
    const cae::Preprocess &preprocess = network.preprocess();
    return {required_image(counts, stride, preprocess.cols, "counts"), preprocess.rows, preprocess.cols, stride};
}

void give_image(const Buffer<double> &from, double *image, size_t stride) {
    for (size_t r = 0; r < cae::kSide; r++)
        std::copy_n(&from[r * cae::kSide], cae::kSide, image + r * stride);
}

void give(cae::Network &&network, toliman_cae **out) {
    *out = std::make_unique<toliman_cae>(toliman_cae{std::move(network)}).release();
}

} // namespace

extern "C" {

toliman_status toliman_cae_create(const toliman_sim *sim, uint64_t seed, toliman_cae **out) noexcept {
    return guard([&] {
        const auto &simulator = required(sim, "sim").simulator;
        required(out, "out");
        give(cae::untrained_network(cae::Preprocess::from_model(simulator.frame_model()), seed), out);
    });
}

void toliman_cae_destroy(toliman_cae *cae) noexcept {
    delete cae;
}

void toliman_cae_train_options_init(toliman_cae_train_options *options) noexcept {
    if (options != nullptr)
        *options = default_options();
}

toliman_status toliman_cae_train(toliman_cae *cae, const toliman_cae_train_options *options,
                                 toliman_cae_training *report) noexcept {
    return guard([&] {
        cae::Network &network = required(cae, "cae").network;
        const cae::TrainOptions known = known_options(options);
        if (report != nullptr)
            check_struct_size("report", report->struct_size, kOldestTraining, sizeof *report);
        cae::Training training = {};
        network = cae::train_tied(network, known, training);
        if (report != nullptr)
            deliver(toliman_cae_training{sizeof *report, known.steps, training.loss, training.cosine}, report, "report",
                    kOldestTraining);
    });
}

toliman_status toliman_cae_get_info(const toliman_cae *cae, toliman_cae_info *out) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        const cae::Preprocess &preprocess = network.preprocess();
        toliman_cae_info info = {};
        info.trained = network.trained();
        info.layout = cae::kFlight.name;
        info.layout_hash = cae::layout_hash(cae::kFlight);
        info.scene_digest = preprocess.scene_digest;
        info.parameters = cae::kParameters;
        info.rows = static_cast<int64_t>(preprocess.rows);
        info.cols = static_cast<int64_t>(preprocess.cols);
        info.crop_row = static_cast<int64_t>(preprocess.crop_row);
        info.crop_col = static_cast<int64_t>(preprocess.crop_col);
        info.projected = static_cast<uint32_t>(preprocess.projected);
        info.crb_px = preprocess.crb_px;
        info.cosine = network.cosine();
        info.input_scale = preprocess.input_scale;
        deliver(info, out, "out", kOldestInfo);
    });
}

toliman_status toliman_cae_encode(const toliman_cae *cae, const double *counts, size_t stride,
                                  double *latent_px) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        required(latent_px, "latent_px");
        *latent_px = network.encode(frame_of(network, counts, stride));
    });
}

toliman_status toliman_cae_encode_many(const toliman_cae *cae, const double *counts, size_t count, uint32_t threads,
                                       double *latents_px) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        if (count == 0)
            return;
        network.encode_many(&required(counts, "counts"), count, threads, &required(latents_px, "latents_px"));
    });
}

toliman_status toliman_cae_decode(const toliman_cae *cae, double latent_px, double *image, size_t stride) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        required_image(image, stride, cae::kSide, "image");
        Buffer<double> painted(cae::kPixels);
        network.decode(latent_px, painted.data());
        give_image(painted, image, stride);
    });
}

toliman_status toliman_cae_get_target(const toliman_cae *cae, double *image, size_t stride) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        give_image(network.preprocess().target, required_image(image, stride, cae::kSide, "image"), stride);
    });
}

toliman_status toliman_cae_reconstruct(const toliman_cae *cae, const double *counts, size_t counts_stride,
                                       double *image, size_t stride, double *mmse, double *mssim,
                                       double *photon_floor) noexcept {
    return guard([&] {
        const cae::Network &network = required(cae, "cae").network;
        const ImageView<const double> frame = frame_of(network, counts, counts_stride);
        required_image(image, stride, cae::kSide, "image");
        Buffer<double> painted(cae::kPixels);
        network.reconstruct(frame, painted.data());
        const bool compare = mmse != nullptr || mssim != nullptr || photon_floor != nullptr;
        const cae::Quality quality = compare ? cae::quality(network, frame, painted.data()) : cae::Quality{};
        give_image(painted, image, stride);
        if (mmse != nullptr)
            *mmse = quality.mmse;
        if (mssim != nullptr)
            *mssim = quality.mssim;
        if (photon_floor != nullptr)
            *photon_floor = quality.photon_floor;
    });
}

void toliman_cae_save_options_init(toliman_cae_save_options *options) noexcept {
    if (options != nullptr)
        *options = default_save_options();
}

toliman_status toliman_cae_save(const toliman_cae *cae, const toliman_cae_save_options *options, void *bytes,
                                size_t capacity, size_t *needed) noexcept {
    return guard([&] { deliver_bytes(blob_of(cae, options), bytes, capacity, needed); });
}

toliman_status toliman_cae_load(const void *bytes, size_t size, toliman_cae **out) noexcept {
    return guard([&] {
        required(bytes, "bytes");
        required(out, "out");
        give(cae::from_blob(bytes, size), out);
    });
}

toliman_status toliman_cae_save_file(const toliman_cae *cae, const toliman_cae_save_options *options,
                                     const char *path) noexcept {
    return guard([&] {
        const std::vector<uint8_t> bytes = blob_of(cae, options);
        file::replace(&required(path, "path"), bytes.data(), bytes.size());
    });
}

toliman_status toliman_cae_load_file(const char *path, toliman_cae **out) noexcept {
    return guard([&] {
        required(path, "path");
        required(out, "out");
        const std::vector<uint8_t> bytes = file::read(path, cae::kMaxBlob);
        in_file(path, [&] { give(cae::from_blob(bytes.data(), bytes.size()), out); });
    });
}

} // extern "C"
