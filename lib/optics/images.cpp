// Method: every nuisance image of the frame is a combination of the stars' derivative images along (a) and across (c)
// the binary's axis, whose unit vector is (x, y):
//     shift x = x d/da - y d/dc,   shift y = y d/da + x d/dc,
//     roll about the frame's centre, for a star at (u, v): -v shift x + u shift y,
// so that none of them needs a propagation of its own. Focus and scale come from propagate().
#include "optics/images.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace toliman::optics {

namespace {

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

// Calls change(image) for each image that is proportional to the stars' light.
template <class Change> void for_each(Images &images, Change change) {
    for (Buffer<double> *image : {&images.star[0], &images.star[1], &images.both, &images.shift_x, &images.shift_y,
                                  &images.roll, &images.scale, &images.focus, &images.focus_curve})
        change(*image);
    for (Buffer<double> &image : images.motion)
        change(image);
    for (std::vector<Derivative> &position_derivatives : images.position_derivatives)
        for (Derivative &derivative : position_derivatives)
            change(derivative.image);
}

// Bounds the brightest pixel at any allowed displacement, by the expansion to second order. Systematics at most double
// it.
void check_brightness(const Scene &scene, const Images &images) {
    const double reach = kLargestDisplacement, limit = kMostPhotons / (scene.systematics.any() ? 2 : 1);
    double most = 0;
    for (size_t i = 0; i < images.both.size(); i++)
        most = std::max(most, images.both[i] +
                                  reach * (std::fabs(images.motion[0][i]) + reach * std::fabs(images.motion[1][i])));
    if (!(most <= limit))
        fail(Status::scene, "%s: {cadence}: the brightest pixel expects up to %g photons: must be at most %g",
             scene.source.c_str(), most, limit);
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
void add_nuisances(const StarImages &star, const Light &light, size_t number, Images &images) {
    const double x = light.axis[0], y = light.axis[1];
    const auto &offset = light.offset_px[number];
    const Buffer<double> &along = star.at(1, 0), &across = star.at(0, 1);
    add(x, along, -y, across, images.shift_x);
    add(y, along, x, across, images.shift_y);
    // The sky rolls: the stars move, but the orientation of their diffraction patterns is fixed by the telescope.
    add(offset[0] * y - offset[1] * x, along, offset[0] * x + offset[1] * y, across, images.roll);
    images.focus = sum(star.focus, images.focus);
    images.focus_curve = sum(star.focus_curve, images.focus_curve);
    images.scale = sum(star.scale, images.scale);
}

} // namespace

Images make_images(const Scene &scene, const Imager &imager, const Plan &plan, const DetectorStages &detector,
                   Light &light, const Progress &progress) {
    const size_t stars = scene.stars.size();
    Images images;
    for (size_t s = 0; s < stars; s++) {
        const bool moves = s == scene.signal.star;
        const ImageRequest request = {moves ? plan.order + 1 : 1,
                                      plan.anchors > 0 ? 1 : std::max<size_t>(1, plan.place_order), true,
                                      scene.systematics.focus_nm.any()};
        StarImages star = imager.images(light, s, 0, request, [&](double fraction) {
            progress.report("propagate", (static_cast<double>(s) + fraction) / static_cast<double>(stars));
        });
        add_nuisances(star, light, s, images);
        if (plan.place_order > 0 && plan.anchors == 0)
            for (const Derivative &derivative : star.derivatives)
                if (derivative.along + derivative.across > 0 &&
                    derivative.along + derivative.across <= plan.place_order)
                    images.position_derivatives[s].push_back(derivative);
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
        for_each(images, [factor](Buffer<double> &image) { scale(image, factor); });
    }
    images.peak_photons = largest(images.both);
    images.total_photons = std::accumulate(images.both.begin(), images.both.end(), 0.0);
    for_each(images, [&](Buffer<double> &image) { detector.apply_response(image); });
    detector.apply_response(images.background);
    for (double &value : images.both)
        value += detector.dark_e();
    check_brightness(scene, images);
    images.variance = variance_of(detector, images.both);
    return images;
}

} // namespace toliman::optics
