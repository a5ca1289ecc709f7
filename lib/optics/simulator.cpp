#include "optics/simulator.hpp"

#include <algorithm>
#include <cmath>

#include "backend/file.hpp"
#include "backend/json.hpp"
#include "base/workers.hpp"
#include "kernels/poisson.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;

std::string folder_of(const std::string &path) {
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : path.substr(0, slash);
}

} // namespace

Simulator::Simulator(const std::string &json, const std::string &source, const std::string &folder,
                     const Settings &settings)
    : scene_(read_scene(json, source, folder)), pupil_(make_pupil(scene_)), light_(make_light(scene_)),
      workers_(worker_count(settings.workers)),
      images_(make_images(scene_, pupil_, light_, workers_, settings.progress)), bounds_(bound(scene_, images_)) {
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
                          source.c_str(), scene_.accuracy, truncation_);
}

// Light enough for finite whitened images, and a signal that shows in them.
void Simulator::check_use() const {
    const double peak = *std::max_element(images_.both.begin(), images_.both.end());
    if (!(peak >= kFewestPhotons))
        fail(Status::scene, "%s: cadence: the brightest pixel expects %g photons: must be at least %g",
             scene_.source.c_str(), peak, kFewestPhotons);
    if (scene_.signal.amplitude_px != 0 && !std::isfinite(bounds_.alone))
        fail(Status::scene, "%s: signal: star %c's motion changes no pixel of the frame", scene_.source.c_str(),
             scene_.signal.star == 0 ? 'A' : 'B');
}

// The first term that the series leaves out is d^3/6 I3. Its largest pixel against the signal's is measured on exact
// images at +-h, where (I(h) - I(-h))/2 - h I1 = h^3/6 I3 + O(h^5), and scaled to the largest displacement.
double Simulator::predict_truncation() const {
    const double reach = std::max(max_displacement_, -min_displacement_), h = kLargestDisplacement;
    if (reach == 0)
        return 0;
    const size_t star = scene_.signal.star;
    const StarImages ahead = optics::propagate(scene_, pupil_, light_, star, h, Detail::image, workers_);
    const StarImages behind = optics::propagate(scene_, pupil_, light_, star, -h, Detail::image, workers_);
    double error = 0, signal = 0;
    for (size_t i = 0; i < pixels(); i++) {
        error = std::max(error, std::fabs((ahead.image[i] - behind.image[i]) / 2 - h * images_.separation[i]));
        signal = std::max(signal, std::fabs(h * images_.separation[i]));
    }
    return error / signal * (reach / h) * (reach / h);
}

double Simulator::time_days(int64_t k) const noexcept {
    return static_cast<double>(k) * scene_.cadence.interval_days;
}

double Simulator::displacement_px(int64_t k) const noexcept {
    const Signal &signal = scene_.signal;
    if (signal.amplitude_px == 0)
        return 0;
    const double cycles = std::fmod(time_days(k), signal.period_days) / signal.period_days;
    return signal.amplitude_px * std::sin(2 * kPi * cycles + signal.phase_rad);
}

void Simulator::propagate(double displacement_px, double *image) const {
    const size_t moving = scene_.signal.star;
    const StarImages moved =
        optics::propagate(scene_, pupil_, light_, moving, displacement_px, Detail::image, workers_);
    const Buffer<double> &still = images_.star[1 - moving];
    for (size_t i = 0; i < pixels(); i++)
        image[i] = moved.image[i] + (still.empty() ? 0 : still[i]);
}

void Simulator::expect(double displacement_px, double *image) const noexcept {
    const double d = displacement_px, curved = 0.5 * d * d;
    // Where the light all but vanishes the cut series may fall below zero.
    for (size_t i = 0; i < pixels(); i++)
        image[i] = std::max(0.0, images_.both[i] + (d * images_.separation[i] + curved * images_.curvature[i]));
}

void Simulator::frame(double displacement_px, uint64_t seed, int64_t k, double *scratch, double *image) const noexcept {
    const auto number = static_cast<uint64_t>(k);
    expect(displacement_px, scene_.noise.photon ? scratch : image);
    if (scene_.noise.photon)
        kernels::poisson_kernels().poisson(scratch, pixels(), 0, {seed, number, kernels::kStreamPhotons}, image);
    if (scene_.noise.read_e == 0)
        return;
    kernels::poisson_kernels().gaussian(pixels(), 0, {seed, number, kernels::kStreamReadout}, scratch);
    for (size_t i = 0; i < pixels(); i++)
        image[i] += scene_.noise.read_e * scratch[i];
}

FrameModel Simulator::frame_model() const {
    FrameModel model;
    model.rows = scene_.detector.rows;
    model.cols = scene_.detector.cols;
    model.reference = images_.both;
    model.variance = images_.variance;
    model.derivative = images_.separation;
    for (const Nuisance nuisance : scene_.projected)
        model.projected.push_back({name_of(nuisance), image_of(images_, nuisance)});
    model.crb_px = bounds_.projected;
    model.scene_digest = scene_.digest;
    return model;
}

Simulator open_scene(const std::string &path, const Settings &settings) {
    const std::vector<uint8_t> bytes = file::read(path, json::kLargestText);
    return Simulator(std::string(bytes.begin(), bytes.end()), path, folder_of(path), settings);
}

} // namespace toliman::optics
