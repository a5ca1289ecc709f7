#include "optics/images.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::optics {

namespace {

constexpr double kMostPhotons = 1e12; // a pixel: the Poisson generator's range

double largest(const Buffer<double> &image) {
    return *std::max_element(image.begin(), image.end());
}

void scale(Buffer<double> &image, double factor) {
    for (double &value : image)
        value *= factor;
}

Buffer<double> sum(const Buffer<double> &a, const Buffer<double> &b) {
    Buffer<double> result = a;
    for (size_t i = 0; i < b.size(); i++)
        result[i] += b[i];
    return result;
}

// What the scene's displacements can make of the brightest pixel.
void check_brightness(const Scene &scene, const Images &images) {
    const double reach = kLargestDisplacement;
    double most = 0;
    for (size_t i = 0; i < images.both.size(); i++)
        most = std::max(most, images.both[i] +
                                  reach * (std::fabs(images.motion[0][i]) + reach * std::fabs(images.motion[1][i])));
    if (!(most <= kMostPhotons))
        fail(Status::scene, "%s: cadence: the brightest pixel expects up to %g photons: at most %g are allowed",
             scene.source.c_str(), most, kMostPhotons);
}

// Photons and read noise. The floor only keeps pixels without light from a division by zero: where the image vanishes,
// so does its derivative.
Buffer<double> variance_of(const Scene &scene, const Buffer<double> &image) {
    const double floor = 1e-12 * largest(image);
    Buffer<double> variance = image;
    for (double &value : variance)
        value = std::max(value + scene.noise.read_e * scene.noise.read_e, floor);
    return variance;
}

// image += a_weight a + b_weight b
void add(double a_weight, const Buffer<double> &a, double b_weight, const Buffer<double> &b, Buffer<double> &image) {
    image.resize(a.size());
    for (size_t i = 0; i < a.size(); i++)
        image[i] += a_weight * a[i] + b_weight * b[i];
}

// Adds what the star's place and focus do to the whole frame.
void add_nuisances(const StarImages &star, const Light &light, size_t number, Images &images) {
    const double x = light.axis[0], y = light.axis[1];
    const auto &offset = light.offset_px[number];
    const Buffer<double> &along = star.at(1, 0), &across = star.at(0, 1);
    add(x, along, -y, across, images.shift_x);
    add(y, along, x, across, images.shift_y);
    // The sky turns, the pattern of each star stays as the telescope makes it.
    add(offset[0] * y - offset[1] * x, along, offset[0] * x + offset[1] * y, across, images.roll);
    images.focus = sum(star.focus, images.focus);
    images.scale = sum(star.scale, images.scale);
}

} // namespace

Images make_images(const Scene &scene, const Imager &imager, const Plan &plan, Light &light, const Progress &progress) {
    const size_t stars = scene.stars.size();
    Images images;
    for (size_t s = 0; s < stars; s++) {
        const bool moves = s == scene.signal.star;
        const Wanted wanted = {moves ? plan.order + 1 : 1, 1, true};
        StarImages star = imager.images(light, s, 0, wanted, [&](double fraction) {
            progress.report("propagate", (static_cast<double>(s) + fraction) / static_cast<double>(stars));
        });
        add_nuisances(star, light, s, images);
        for (Derivative &derivative : star.derivatives)
            if (moves && derivative.along > 0 && derivative.across == 0)
                images.motion.push_back(std::move(derivative.image));
        images.star[s] = std::move(star.derivatives[0].image);
    }
    images.both = sum(images.star[0], images.star[1]);
    images.background.assign(images.both.size(), 1.0);

    const double peak = largest(images.both);
    if (!(peak > 0) || !std::isfinite(peak))
        fail(Status::scene, "%s: no light falls on the detector", scene.source.c_str());
    if (scene.cadence.peak_photons > 0) {
        const double factor = scene.cadence.peak_photons / peak;
        scale_light(light, factor);
        for (Buffer<double> *image : {&images.star[0], &images.star[1], &images.both, &images.shift_x, &images.shift_y,
                                      &images.roll, &images.scale, &images.focus})
            scale(*image, factor);
        for (Buffer<double> &image : images.motion)
            scale(image, factor);
    }
    check_brightness(scene, images);
    images.variance = variance_of(scene, images.both);
    return images;
}

} // namespace toliman::optics
