// Method: every nuisance image of the frame is a combination of the stars' derivative images along (a) and across (c)
// the binary's axis, whose unit vector is (x, y):
//     shift x = x d/da - y d/dc,   shift y = y d/da + x d/dc,
//     roll about the frame's centre, for a star at (u, v): -v shift x + u shift y,
// so that none of them needs a propagation of its own. Focus and scale come from propagate().
#include "optics/images.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace toliman::optics {

namespace {

constexpr double kMostNegative = 10;     // stated errors, of negative light
constexpr double kMostBrightening = 1.1; // of the brightest pixel, by a displacement that an expansion covers

double largest(const Buffer<double> &image) {
    return *std::max_element(image.begin(), image.end());
}

Buffer<double> sum(const Buffer<double> &a, const Buffer<double> &b) {
    Buffer<double> result = a;
    for (size_t i = 0; i < b.size(); i++)
        result[i] += b[i];
    return result;
}

void check_signal(const Scene &scene, const Buffer<double> &by_displacement) {
    const bool changes = std::any_of(by_displacement.begin(), by_displacement.end(), [](double d) { return d != 0; });
    if (scene.signal.amplitude_px != 0 && !changes)
        fail(Status::scene, "%s: {signal}: the motion of star %c changes no pixel of the frame", scene.source.c_str(),
             scene.signal.star == 0 ? 'A' : 'B');
}

// Variance of a frame: Poisson (the expected electrons) plus read noise and rounding. The floor only avoids a division
// by zero in pixels without light; where the image vanishes, so does its derivative.
Buffer<double> variance_of(const DetectorStages &detector, const Buffer<double> &image) {
    const double floor = 1e-12 * largest(image), added = detector.added_variance_e2();
    Buffer<double> variance = image;
    for (double &value : variance)
        value = std::max(value + added, floor);
    return variance;
}

// image += a_weight a + b_weight b
void add(double a_weight, const Buffer<double> &a, double b_weight, const Buffer<double> &b, Buffer<double> &image) {
    image.resize(a.size());
    for (size_t i = 0; i < a.size(); i++)
        image[i] += a_weight * a[i] + b_weight * b[i];
}

// Adds a star's share to the frame's nuisance images.
void add_nuisances(const StarImages &star, const Light &light, size_t number, Disturbed &images) {
    const double x = light.axis[0], y = light.axis[1];
    const auto &offset = light.offset_px[number];
    const Buffer<double> &along = star.at(1, 0), &across = star.at(0, 1);
    add(x, along, -y, across, images.shift_x);
    add(y, along, x, across, images.shift_y);
    // The sky rolls: the stars move, but the orientation of their diffraction patterns is fixed by the telescope.
    add(offset[0] * y - offset[1] * x, along, offset[0] * x + offset[1] * y, across, images.roll);
    images.focus = sum(star.focus, images.focus);
    images.scale = sum(star.scale, images.scale);
}

} // namespace

Images::Images(const Scene &scene, const Pupil &pupil, const Imager &imager, const Plan &plan,
               const DetectorStages &detector, Light &light, const Progress &progress, size_t order)
    : scene_(scene), pupil_(pupil), imager_(imager), plan_(plan), detector_(detector), light_(light) {
    const size_t stars = scene.stars.size();
    StarImages images[2];
    for (size_t s = 0; s < stars; s++) {
        const ImageRequest request = {s == scene.signal.star ? order : 0, 0, false, false};
        images[s] = imager.images(light, s, 0, request, [&](double fraction) {
            progress.report("propagate", (static_cast<double>(s) + fraction) / static_cast<double>(stars));
        });
        star_[s] = std::move(images[s].derivatives[0].image);
    }
    both_ = sum(star_[0], star_[1]);
    const double peak = largest(both_);
    if (!(peak > 0) || !std::isfinite(peak))
        fail(Status::scene, "%s: no light falls on the detector", scene.source.c_str());
    if (scene.cadence.peak_photons > 0) {
        factor_ = scene.cadence.peak_photons / peak;
        scale_light(light, factor_);
    }
    for (double &value : both_)
        value *= factor_;
    peak_photons_ = largest(both_);
    const double darkest = *std::min_element(both_.begin(), both_.end()) / peak_photons_,
                 error = plan.filter.error + plan.spectrum_error + kRounding;
    if (!(darkest >= -kMostNegative * error))
        fail(Status::internal, "%s: the darkest pixel expects %g of the brightest: the stated error is %g",
             scene.source.c_str(), darkest, error);
    total_photons_ = std::accumulate(both_.begin(), both_.end(), 0.0);
    detector.collect(both_);
    for (double &value : both_)
        value += detector.dark_e();
    for (Buffer<double> &star : star_)
        finish(star);
    // A displacement brightens a pixel by a few per cent, and systematics at most double it. Frames are checked, too.
    const double brightest = kMostBrightening * largest(both_),
                 limit = kMostPhotons / (scene.systematics.any() ? 2 : 1);
    if (!(brightest <= limit))
        fail(Status::scene, "%s: {cadence}: the brightest pixel expects up to %g electrons: must be at most %g",
             scene.source.c_str(), brightest, limit);
    if (!(brightest <= detector.readout().most_charge()))
        fail(Status::scene,
             "%s: {detector}: the brightest pixel expects up to %g electrons: nonlinearity_per_e and "
             "brighter_fatter_px2_per_e are approximations up to %g",
             scene.source.c_str(), brightest, detector.readout().most_charge());
    variance_ = variance_of(detector, both_);
    for (const size_t pixel : scene.detector.bad_pixels)
        variance_[pixel] = std::numeric_limits<double>::infinity();
    if (order > 0)
        set_motion(images[scene.signal.star]);
}

const Motion &Images::motion() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!motion_)
        propagate(true, false);
    return *motion_;
}

const Disturbed &Images::disturbed() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!disturbed_)
        propagate(!motion_, true);
    return *disturbed_;
}

const Buffer<double> &Images::derivative(Parameter parameter) const {
    prepare(computed_with(scene_, parameter));
    const std::lock_guard<std::mutex> lock(mutex_);
    return derivatives_.at(parameter); // stays in place when others are added
}

void Images::prepare(const std::vector<Parameter> &parameters) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<Parameter> missing;
    for (const Parameter parameter : parameters)
        if (has_own_derivative(parameter) && derivatives_.count(parameter) == 0)
            missing.push_back(parameter);
    if (missing.empty())
        return;
    const MemoryScope scope(memory_);
    const auto of_light = std::stable_partition(missing.begin(), missing.end(),
                                                [](Parameter parameter) { return !Readout::has(parameter.kind); });
    for (auto parameter = of_light; parameter != missing.end(); ++parameter)
        derivatives_.emplace(*parameter, detector_.readout().derivative(parameter->kind, both_, detector_.dark_e()));
    missing.erase(of_light, missing.end());
    std::vector<Buffer<double>> images = derivatives(scene_, pupil_, plan_, imager_, light_, missing);
    for (size_t i = 0; i < missing.size(); i++) {
        finish(images[i]);
        derivatives_.emplace(missing[i], std::move(images[i]));
    }
}

Buffer<double> Images::opd_gradient(Buffer<double> weights) const {
    if (plan_.engine == EngineKind::padded_fft)
        fail(Status::unsupported, "%s: gradient by the OPD: the padded FFT does not compute it", scene_.source.c_str());
    const MemoryScope scope(memory_);
    for (double &weight : weights)
        weight *= factor_;
    detector_.spread(weights.data());
    Buffer<double> gradient(pupil_.samples * pupil_.samples);
    for (size_t s = 0; s < scene_.stars.size(); s++)
        gradient = sum(gradient, imager_.opd_gradient(light_, s, weights));
    return gradient;
}

void Images::propagate(bool motion, bool disturbed) const {
    const MemoryScope scope(memory_);
    Disturbed by_others;
    for (size_t s = 0; s < scene_.stars.size(); s++) {
        const bool moves = motion && s == scene_.signal.star;
        if (!moves && !disturbed)
            continue;
        const ImageRequest request = {moves ? plan_.order + 1 : 1, disturbed ? size_t{1} : 0, disturbed, false};
        StarImages star = imager_.images(light_, s, 0, request);
        if (disturbed)
            add_nuisances(star, light_, s, by_others);
        if (moves)
            set_motion(star);
    }
    if (!disturbed)
        return;
    for (Buffer<double> *image :
         {&by_others.shift_x, &by_others.shift_y, &by_others.roll, &by_others.scale, &by_others.focus})
        finish(*image);
    by_others.background.assign(both_.size(), 1.0);
    detector_.collect(by_others.background);
    disturbed_ = std::move(by_others);
}

void Images::set_motion(StarImages &star) const {
    Motion motion;
    for (Derivative &derivative : star.derivatives)
        if (derivative.along > 0 && derivative.across == 0)
            finish(motion.emplace_back(std::move(derivative.image)));
    check_signal(scene_, motion.front());
    motion_ = std::move(motion);
}

// From propagated photons to expected electrons.
void Images::finish(Buffer<double> &image) const {
    for (double &value : image)
        value *= factor_;
    detector_.collect(image);
}

const Buffer<double> &image_of(const Images &images, Parameter parameter) {
    using Kind = Parameter::Kind;
    switch (parameter.kind) {
    case Kind::separation:
        return images.motion()[0];
    case Kind::flux_a:
        return images.star(0);
    case Kind::flux_b:
        return images.star(1);
    case Kind::shift_x:
        return images.disturbed().shift_x;
    case Kind::shift_y:
        return images.disturbed().shift_y;
    case Kind::roll:
        return images.disturbed().roll;
    case Kind::scale:
        return images.disturbed().scale;
    case Kind::focus:
        return images.disturbed().focus;
    case Kind::background:
        return images.disturbed().background;
    default:
        return images.derivative(parameter);
    }
}

} // namespace toliman::optics
