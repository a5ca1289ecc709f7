// include/toliman/bank.h
#include <toliman/bank.h>

#include "api/cae_choices.hpp"
#include "api/common.hpp"
#include "api/fit_values.hpp"
#include "api/handles.hpp"
#include "api/journal.hpp"
#include "api/pixel_frames.hpp"
#include "api/track_estimators.hpp"
#include "backend/file.hpp"
#include "bank/weights.hpp"
#include "frame/estimates.hpp"
#include "optics/light.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

// Of the training of a network of layout `flight`, on one core of a 2020s server; of others in proportion to the
// pixels.
constexpr double kStepSeconds = 1.25e-3;

// last_days: of the scene's frames.
bank::Options options_of(const toliman_bank_options &given, size_t rows, size_t cols, double last_days) {
    bank::Options options;
    options.layout = &layout_of(given.layout, rows, cols);
    const bool preset = given.first_days == 0 && given.last_days == 0;
    options.first_days = given.first_days;
    options.last_days = preset ? last_days : given.last_days;
    if (options.last_days < options.first_days)
        fail(Status::argument, "{options->last_days} = %g: must be at least first_days = %g", options.last_days,
             options.first_days);
    TOLIMAN_COPY(options, given, spacing_px, places, steps, seed);
    return options;
}

toliman_bank_result public_result(const bank::Estimate &estimate) {
    toliman_bank_result out = {};
    TOLIMAN_COPY(out, estimate, flags, displacement_px, separation_px, sigma_px, efficiency, distance_px, network);
    set_frame_goodness(estimate.goodness, out);
    return out;
}

// The networks of a bank are trained on the images of one scene.
void check_single(const toliman_fit &fit, const char *name) {
    if (fit.fit.count() > 1)
        fail(Status::unsupported, "{%s}: has %zu windows: a bank needs the fit of one scene", name, fit.fit.count());
}

std::vector<uint8_t> bytes_of(const toliman_bank *handle, int32_t encoding) {
    const Use use(handle, "bank");
    return bank::to_bytes(use->bank, kEncodings.to_enum_or(encoding, cae::Encoding::float32, "encoding"));
}

} // namespace

void toliman::api::check_fit(const toliman_bank &bank, const toliman_fit &fit, const char *name) {
    check_single(fit, "fit");
    if (bank.bank.fit_digest() != fit.fit.digest())
        fail(Status::mismatch,
             "{%s} was made for another fit: scene, free parameters and capture_px must be those of the fit with "
             "which it was made",
             name);
}

toliman_status toliman_bank_plan(const toliman_sim *sim, const toliman_bank_options *given,
                                 toliman_bank_plan_info *out) noexcept {
    return query(sim, "sim", out, [&](auto &self, auto &info) {
        const Scene &scene = self.simulator.scene();
        const optics::Light &light = self.simulator.light();
        if (scene.stars.size() < 2)
            fail(Status::unsupported, "%s: {stars}: a bank needs two stars", scene.source.c_str());
        const size_t rows = scene.detector.rows, cols = scene.detector.cols;
        const bank::Options options = options_of(accept(given, "options"), rows, cols, longest_days(scene.cadence));
        const cae::Layout &layout = *options.layout;
        const auto dates = bank::dates_of(options.first_days, options.last_days, options.spacing_px, [&](double days) {
            const optics::Offsets place = optics::unobserved_offsets_at(scene, light, days);
            return std::array<double, 2>{place[1][0] - place[0][0], place[1][1] - place[0][1]};
        });
        bank::check_size(rows, cols, dates.size(), options);
        info.dates = static_cast<int64_t>(dates.size());
        info.places = options.places * options.places;
        info.networks = info.dates * info.places;
        TOLIMAN_COPY(info, options, first_days, last_days);
        info.bytes_float32 = static_cast<uint64_t>(info.networks) * bank::weight_bytes(layout, cae::Encoding::float32);
        info.bytes_half = static_cast<uint64_t>(info.networks) * bank::weight_bytes(layout, cae::Encoding::fp16);
        const double pixels = static_cast<double>(layout.pixels()) / static_cast<double>(cae::kFlight.pixels());
        double steps = 0;
        for (size_t i = 0; i < static_cast<size_t>(info.networks); i++)
            steps += bank::course_of(i, dates.size(), options).steps;
        info.train_s = kStepSeconds * pixels * steps;
    });
}

toliman_status toliman_bank_create(const toliman_fit *fit, const toliman_bank_options *options,
                                   toliman_bank **out) noexcept {
    return guard([&] {
        const toliman_bank_options known = accept(options, "options");
        const MemoryScope scope(memory_of(known.allocator));
        const Use use(fit, "fit");
        toliman_bank *&made = required(out, "out");
        check_single(*fit, "fit");
        const fit::Fit &single = use->fit.first();
        const bank::Options known_options = options_of(known, single.rows(), single.cols(), single.last_days());
        made = new toliman_bank{{}, bank::Bank(single, known_options), known.threads, bank_source};
    });
}

void toliman_bank_destroy(toliman_bank *bank) noexcept {
    destroy(bank);
}

toliman_status toliman_bank_train(toliman_bank *handle, const toliman_fit *fit,
                                  const toliman_bank_train_options *options) noexcept {
    return call(handle, "bank", [&](auto &self) {
        const Use model(fit, "fit");
        check_fit(self, *fit, "bank");
        const toliman_bank_train_options known = accept(options, "options");
        std::optional<Journal> journal;
        open_journal(journal, known.journal, "BANK", [&] { return self.bank.inputs(); });
        self.bank.train(model->fit.first(), known.threads, {known.progress, known.progress_data},
                        journal ? &*journal : nullptr);
    });
}

toliman_status toliman_bank_get_info(const toliman_bank *handle, toliman_bank_info *out) noexcept {
    return query(handle, "bank", out, [&](auto &self, auto &info) {
        const bank::Bank &bank = self.bank;
        const bank::Options &options = bank.options();
        info.networks = static_cast<int64_t>(bank.networks().size());
        info.trained_networks = static_cast<int64_t>(bank.trained());
        info.dates = static_cast<int64_t>(bank.dates().size());
        info.places = options.places * options.places;
        TOLIMAN_COPY(info, options, steps, first_days, last_days, spacing_px, seed);
        info.rows = static_cast<int64_t>(bank.rows());
        info.cols = static_cast<int64_t>(bank.cols());
        info.layout = options.layout->name;
        info.fit_digest = bank.fit_digest();
        info.digest = bank.digest();
    });
}

toliman_status toliman_bank_get_network(const toliman_bank *handle, int64_t index, toliman_bank_network *out) noexcept {
    return query(handle, "bank", out, [&](auto &self, auto &found) {
        const auto &networks = self.bank.networks();
        const bank::Network &network = networks[required_index(index, networks.size(), "index")];
        const bank::Date &date = self.bank.dates()[network.date];
        found.trained = network.trained() ? 1 : 0;
        found.days = date.days;
        found.first_days = date.first;
        found.last_days = date.last;
        found.x_px = network.shift_px[0];
        found.y_px = network.shift_px[1];
        found.cosine = network.cosine;
    });
}

toliman_status toliman_bank_encode(const toliman_bank *handle, const toliman_fit *fit, const toliman_image *image,
                                   size_t count, const toliman_fit_prediction *predictions,
                                   toliman_bank_result *results, toliman_fit_result *fitted) noexcept {
    return call(handle, "bank", [&](auto &self) {
        const Use model(fit, "fit");
        check_fit(self, *fit, "bank");
        if (count == 0)
            return;
        const bank::Bank &bank = self.bank;
        const PixelFrames frames = frames_of(image, count, bank.rows(), bank.cols());
        const StructArray<toliman_bank_result> out(results, "results");
        const Predictions given(predictions);
        std::optional<StructArray<toliman_fit_result>> fits;
        if (fitted != nullptr)
            fits.emplace(fitted, "fitted");
        struct Work {
            explicit Work(const toliman_fit &fit, const toliman_bank &bank) : of_fit(fit.works), of_bank(bank.works) {}
            WorkPool<fit::FitWork>::Lease of_fit;
            WorkPool<bank::BankWork>::Lease of_bank;
        };
        const auto encode = [&](const ImageView<const double> &frame, size_t i, Work &work) {
            const fit::Prediction prediction = of_one_frame(given.at(i), "predictions");
            return public_result(bank.estimate(model->fit.first(), frame, in_window(prediction, frames.window(i)),
                                               *work.of_fit, *work.of_bank));
        };
        const auto fit_of = [&](Work &work) {
            return public_result((*work.of_bank).fitted, model->fit.first().parameters().size());
        };
        if (count == 1) {
            Buffer<double> converted;
            Work work(*fit, self);
            out.put(0, encode(frames.frame(0, converted), 0, work));
            if (fits)
                fits->put(0, fit_of(work));
            return;
        }
        Buffer<toliman_bank_result> found(count); // so that nothing is written if a frame fails
        Buffer<toliman_fit_result> found_fits(fits ? count : 0);
        for_groups(
            frames, count, 1, self.threads, [&] { return Work(*fit, self); },
            [&](const ImageView<const double> *frame, size_t i, size_t, Work &work) {
                found[i] = encode(*frame, i, work);
                if (fits)
                    found_fits[i] = fit_of(work);
            });
        for (size_t i = 0; i < count; i++) {
            out.put(i, found[i]);
            if (fits)
                fits->put(i, found_fits[i]);
        }
    });
}

toliman_status toliman_bank_predict(const toliman_bank *handle, const toliman_fit *fit,
                                    const toliman_fit_prediction *prediction, toliman_bank_result *out) noexcept {
    return call(handle, "bank", [&](auto &self) {
        const Use model(fit, "fit");
        check_fit(self, *fit, "bank");
        WorkPool<fit::FitWork>::Lease fit_work(model->works);
        WorkPool<bank::BankWork>::Lease work(self.works);
        deliver(public_result(self.bank.predict(
                    model->fit.first(), of_one_frame(prediction_of(prediction), "prediction"), *fit_work, *work)),
                out, "out");
    });
}

toliman_status toliman_bank_get_renewal(const toliman_bank *handle, const toliman_fit *fit, double least_efficiency,
                                        double *days) noexcept {
    return call(handle, "bank", [&](auto &self) {
        const Use model(fit, "fit");
        check_fit(self, *fit, "bank");
        if (!(least_efficiency > 0 && least_efficiency < 1))
            fail(Status::argument, "{least_efficiency} = %g: must be in (0, 1)", least_efficiency);
        required(days, "days");
        WorkPool<fit::FitWork>::Lease fit_work(model->works);
        WorkPool<bank::BankWork>::Lease work(self.works);
        *days = self.bank.renewal(model->fit.first(), least_efficiency, *fit_work, *work);
    });
}

toliman_status toliman_bank_save(const toliman_bank *bank, int32_t encoding, void *bytes, size_t capacity,
                                 size_t *needed) noexcept {
    return guard([&] { deliver_bytes(bytes_of(bank, encoding), bytes, capacity, needed); });
}

toliman_status toliman_bank_load(const void *bytes, size_t size, const toliman_load_options *options,
                                 toliman_bank **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(bytes, "bytes");
        toliman_bank *&made = required(out, "out");
        made = new toliman_bank{{}, bank::from_bytes(bytes, size), threads_of(options), bank_source};
    });
}

toliman_status toliman_bank_save_file(const toliman_bank *bank, int32_t encoding, const char *path) noexcept {
    return guard([&] {
        const std::vector<uint8_t> bytes = bytes_of(bank, encoding);
        file::replace(&required(path, "path"), bytes.data(), bytes.size());
    });
}

toliman_status toliman_bank_load_file(const char *path, const toliman_load_options *options,
                                      toliman_bank **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(path, "path");
        toliman_bank *&made = required(out, "out");
        const std::vector<uint8_t> bytes = file::read(path, bank::most_bytes());
        in_file(path, [&] {
            made = new toliman_bank{{}, bank::from_bytes(bytes.data(), bytes.size()), threads_of(options), bank_source};
        });
    });
}
