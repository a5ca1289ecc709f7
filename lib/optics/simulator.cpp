#include "optics/simulator.hpp"

#include <algorithm>
#include <cmath>

#include "backend/file.hpp"
#include "backend/json.hpp"
#include "base/workers.hpp"
#include "optics/remarks.hpp"
#include "optics/wobble.hpp"

namespace toliman::optics {

namespace {

std::string folder_of(const std::string &path) {
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : path.substr(0, slash);
}

} // namespace

Outline outline_of(const std::string &json, const std::string &source, const std::string &folder,
                   const Settings &settings) {
    Outline outline;
    outline.scene = read_scene(json, source, folder);
    outline.pupil = make_pupil(outline.scene, outline.scene.telescope.pupil_samples);
    outline.light = make_light(outline.scene);
    outline.plan =
        make_plan(outline.scene, outline.pupil, outline.light, settings.engine, worker_count(settings.workers));
    return outline;
}

Outline outline_of(const std::string &path, const Settings &settings) {
    const std::vector<uint8_t> bytes = file::read(path, json::kLargestText);
    return outline_of(std::string(bytes.begin(), bytes.end()), path, folder_of(path), settings);
}

Simulator::Simulator(Outline outline, const Settings &settings)
    : scene_(std::move(outline.scene)), pupil_(std::move(outline.pupil)), light_(std::move(outline.light)),
      plan_(std::move(outline.plan)), imager_(scene_, pupil_, plan_, worker_count(settings.workers)), detector_(scene_),
      anchors_(scene_, imager_, plan_, detector_, light_),
      images_(make_images(scene_, imager_, plan_, detector_, light_, settings.progress)),
      bounds_(bound(scene_, images_)) {
    check_use();
    min_displacement_ = max_displacement_ = displacement_px(0);
    for (int64_t k = 0; k < scene_.cadence.frames; k++) {
        const double displacement = displacement_px(k);
        min_displacement_ = std::min(min_displacement_, displacement);
        max_displacement_ = std::max(max_displacement_, displacement);
    }
    truncation_ = predict_truncation();
    if (truncation_ > scene_.accuracy)
        settings.log.warn("%s: accuracy = %g: the signal's series is expected to be off by %.2g of the signal",
                          scene_.source.c_str(), scene_.accuracy, truncation_);
    remark(scene_, light_, plan_, settings.log);
    detector_.warn(images_.both, "", scene_.source, settings.log);
}

// Light enough for finite whitened images, and a signal that shows in them.
void Simulator::check_use() const {
    const double peak = images_.peak_photons;
    if (!(peak >= kFewestPhotons))
        fail(Status::scene, "%s: {cadence}: the brightest pixel expects %g photons: must be at least %g",
             scene_.source.c_str(), peak, kFewestPhotons);
    if (scene_.signal.amplitude_px != 0 && !std::isfinite(bounds_.alone))
        fail(Status::scene, "%s: {signal}: star %c's motion changes no pixel of the frame", scene_.source.c_str(),
             scene_.signal.star == 0 ? 'A' : 'B');
}

// The first term that the series leaves out, at its largest pixel and displacement, against the signal's largest.
double Simulator::predict_truncation() const {
    if (plan_.exact_frames)
        return 0;
    const double reach = std::max(max_displacement_, -min_displacement_);
    const auto largest = [](const Buffer<double> &image) {
        double size = 0;
        for (const double value : image)
            size = std::max(size, std::fabs(value));
        return size;
    };
    double factor = 1; // d^n / (n + 1)!
    for (size_t n = 1; n <= plan_.order; n++)
        factor *= reach / static_cast<double>(n + 1);
    const double signal = largest(images_.motion.front());
    return signal > 0 ? factor * largest(images_.motion.back()) / signal : 0;
}

double Simulator::time_days(int64_t k) const noexcept {
    const Cadence &cadence = scene_.cadence;
    if (cadence.times_days.empty())
        return static_cast<double>(k) * cadence.interval_days;
    return cadence.times_days[std::min(static_cast<size_t>(k), cadence.times_days.size() - 1)];
}

double Simulator::displacement_px(int64_t k) const noexcept {
    return optics::displacement_px(scene_.signal, time_days(k));
}

Buffer<double> Simulator::star_at(const Light &light, size_t star, double displacement_px) const {
    StarImages images = imager_.images(light, star, displacement_px, Wanted());
    detector_.collect(images.derivatives[0].image);
    return std::move(images.derivatives[0].image);
}

void Simulator::propagate(double displacement_px, double *image) const {
    const size_t moving = scene_.signal.star;
    const Buffer<double> moved = star_at(light_, moving, displacement_px);
    const Buffer<double> &still = images_.star[1 - moving];
    for (size_t i = 0; i < pixels(); i++)
        image[i] = std::max(0.0, moved[i] + (still.empty() ? 0 : still[i]) + detector_.dark_e());
}

// Horner's rule, over stretches that stay in the cache.
void Simulator::expect(double displacement_px, double *image) const noexcept {
    constexpr size_t stretch = 1024;
    for (size_t first = 0; first < pixels(); first += stretch) {
        const size_t count = std::min(stretch, pixels() - first);
        double *const sum = image + first;
        std::copy_n(images_.motion[plan_.order - 1].data() + first, count, sum);
        for (size_t n = plan_.order - 1; n > 0; n--) {
            const double *const term = images_.motion[n - 1].data() + first;
            const double factor = displacement_px / static_cast<double>(n + 1);
            for (size_t i = 0; i < count; i++)
                sum[i] = term[i] + factor * sum[i];
        }
        // Where the light all but vanishes the cut series may fall below zero.
        for (size_t i = 0; i < count; i++)
            sum[i] = std::max(0.0, images_.both[first + i] + displacement_px * sum[i]);
    }
}

// Places and fluxes exactly or by the series of both stars' places, about time 0 or the anchor of the time; scale to
// first order, focus to second.
void Simulator::expect_disturbed(double displacement_px, const Disturbances &disturbances, double days,
                                 double *image) const {
    const Offsets offsets = scene_.binary.moving ? offsets_at(scene_, light_, days) : light_.offset_px;
    const auto axis = axis_of(scene_, offsets);
    const std::shared_ptr<const Anchor> anchor = plan_.anchors > 0 ? anchors_.near(days) : nullptr;
    const Offsets &from = anchor ? anchor->offset_px : light_.offset_px;
    std::vector<Term> terms;
    const auto add_shapes = [&](const Buffer<double> &scale, const Buffer<double> &focus, const Buffer<double> &curve) {
        if (disturbances.scale != 0)
            terms.push_back({scale.data(), disturbances.scale});
        if (disturbances.focus_nm == 0)
            return;
        // A mask may leave no slope at the best focus.
        terms.push_back({curve.data(), 0.5 * disturbances.focus_nm * disturbances.focus_nm});
        terms.push_back({focus.data(), disturbances.focus_nm});
    };
    if (anchor)
        add_shapes(anchor->scale, anchor->focus, anchor->focus_curve);
    else if (!plan_.exact_frames)
        add_shapes(images_.scale, images_.focus, images_.focus_curve);
    const bool shaped = disturbances.scale != 0 || disturbances.focus_nm != 0;
    StarImages anew[2];
    for (size_t star = 0; star < scene_.stars.size(); star++) {
        const double own = star == scene_.signal.star ? displacement_px : 0;
        const double flux = 1 + disturbances.flux[star];
        auto move = move_of(disturbances, offsets[star], axis.data(), own);
        for (size_t i = 0; i < 2; i++)
            move[i] += offsets[star][i] - from[star][i];
        if (plan_.exact_frames) {
            Light light = light_;
            for (size_t i = 0; i < 2; i++)
                light.offset_px[star][i] += move[i];
            anew[star] = imager_.images(light, star, 0, shaped ? Wanted{0, 1, true, true} : Wanted());
            for (Buffer<double> *part :
                 {&anew[star].derivatives[0].image, &anew[star].scale, &anew[star].focus, &anew[star].focus_curve})
                detector_.collect(*part);
            add_shapes(anew[star].scale, anew[star].focus, anew[star].focus_curve);
            terms.push_back({anew[star].at(0, 0).data(), flux});
        } else {
            add_places(anchor ? anchor->places[star] : images_.places[star], light_.axis, move, flux, terms);
            terms.push_back({(anchor ? anchor->star[star] : images_.star[star]).data(), flux});
        }
    }
    add_up(terms, detector_.dark_e(), pixels(), image);
}

void Simulator::frame(double displacement_px, uint64_t seed, int64_t k, double *scratch, double *image) const {
    const auto number = static_cast<uint64_t>(k);
    const double days = time_days(k % scene_.cadence.frames);
    if (scene_.systematics.any() || scene_.binary.moving)
        expect_disturbed(displacement_px, draw(scene_.systematics, seed, number, days), days, scratch);
    else if (plan_.exact_frames)
        propagate(displacement_px, scratch);
    else
        expect(displacement_px, scratch);
    const double most = *std::max_element(scratch, scratch + pixels());
    if (!(most <= kMostPhotons))
        fail(Status::range, "frame %lld: a pixel expects %g electrons: at most %g are allowed",
             static_cast<long long>(k), most, kMostPhotons);
    detector_.detect(seed, number, scratch, image);
}

// In the frame's own unit; the bound is the same in any.
FrameModel Simulator::frame_model() const {
    FrameModel model;
    model.source = scene_.source;
    model.rows = scene_.detector.rows;
    model.cols = scene_.detector.cols;
    model.reference = detector_.in_counts(images_.both, Quantity::frame);
    model.background = detector_.counts_of(detector_.dark_e());
    model.variance = detector_.in_counts(images_.variance, Quantity::variance);
    model.derivative = detector_.in_counts(images_.motion[0], Quantity::derivative);
    for (const Nuisance nuisance : scene_.projected)
        model.projected.push_back(
            {name_of(nuisance), detector_.in_counts(image_of(images_, nuisance), Quantity::derivative)});
    model.crb_px = bounds_.projected;
    model.scene_digest = scene_.digest;
    return model;
}

} // namespace toliman::optics
