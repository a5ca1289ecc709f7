#include "optics/images.hpp"

#include <algorithm>
#include <cmath>

#include "optics/propagate.hpp"

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
    double most = 0;
    for (size_t i = 0; i < images.both.size(); i++)
        most = std::max(most, images.both[i] +
                                  kLargestDisplacement * (std::fabs(images.separation[i]) +
                                                          kLargestDisplacement * std::fabs(images.curvature[i])));
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

} // namespace

Images make_images(const Scene &scene, const Pupil &pupil, Light &light, unsigned workers, const Progress &progress) {
    const size_t stars = scene.stars.size();
    StarImages star[2];
    for (size_t s = 0; s < stars; s++)
        star[s] = propagate(scene, pupil, light, s, 0, s == scene.signal.star ? Detail::curvature : Detail::gradient,
                            workers, [&](double fraction) {
                                progress.report("propagate",
                                                (static_cast<double>(s) + fraction) / static_cast<double>(stars));
                            });
    const StarImages &moving = star[scene.signal.star];
    Images images;
    images.both = sum(star[0].image, star[1].image);
    images.shift_x = sum(star[0].dx, star[1].dx);
    images.shift_y = sum(star[0].dy, star[1].dy);
    images.separation.resize(moving.image.size());
    for (size_t i = 0; i < images.separation.size(); i++)
        images.separation[i] = light.axis[0] * moving.dx[i] + light.axis[1] * moving.dy[i];
    images.curvature = moving.curvature;
    images.star[0] = std::move(star[0].image);
    images.star[1] = std::move(star[1].image);

    const double peak = largest(images.both);
    if (!(peak > 0) || !std::isfinite(peak))
        fail(Status::scene, "%s: no light falls on the detector", scene.source.c_str());
    if (scene.cadence.peak_photons > 0) {
        const double factor = scene.cadence.peak_photons / peak;
        scale_light(light, factor);
        for (Buffer<double> *image : {&images.star[0], &images.star[1], &images.both, &images.separation,
                                      &images.curvature, &images.shift_x, &images.shift_y})
            scale(*image, factor);
    }
    check_brightness(scene, images);
    images.variance = variance_of(scene, images.both);
    return images;
}

} // namespace toliman::optics
