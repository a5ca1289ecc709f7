// Method: with the image S of a star and its derivatives by scale (C, about the star) and focus (F, FF), the light of a
// star of relative flux change f at the place x of the frame is
//     (1 + f) (S + scale C + focus F + focus^2/2 FF)(pixel - x),
// interpolated from the atlas. The place holds the whole motion, the stretch of the frame about its centre included, so
// that all products with a shift are exact. Omitted: scale^2/2, focus^3/6 and scale focus (plan.cpp,
// scale_focus_error). The second order of focus is needed because a mask may leave the image no first-order dependence
// on focus. A star outside the atlas, beyond 4 sigma of the systematics, is propagated at its place.
#include "optics/moved.hpp"

#include <algorithm>

namespace toliman::optics {

namespace {

// The images that the systematics of a scene need, with their derivatives by scale about the star.
Planes planes_of(const Systematics &systematics, const Imager &imager, const Light &light, size_t star) {
    ImageRequest request;
    request.focus = systematics.scale.any() || systematics.focus_nm.any();
    request.plane = request.focus ? 1 : 0;
    request.focus_curve = systematics.focus_nm.any();
    StarImages images = imager.images(light, star, 0, request);
    Planes planes;
    planes.push_back(std::move(images.derivatives[0].image));
    if (systematics.scale.any()) {
        const auto &[x, y] = light.offset_px[star];
        const double along = x * light.axis[0] + y * light.axis[1], across = y * light.axis[0] - x * light.axis[1];
        for (size_t i = 0; i < images.scale.size(); i++) // from scale about the centre of the frame
            images.scale[i] -= along * images.at(1, 0)[i] + across * images.at(0, 1)[i];
        planes.push_back(std::move(images.scale));
    }
    if (systematics.focus_nm.any()) {
        planes.push_back(std::move(images.focus));
        planes.push_back(std::move(images.focus_curve));
    }
    return planes;
}

// Of these images, for a star of this flux.
std::vector<double> weights_of(const Systematics &systematics, const Disturbances &disturbances, double flux) {
    std::vector<double> weights = {flux};
    if (systematics.scale.any())
        weights.push_back(flux * disturbances.scale);
    if (systematics.focus_nm.any()) {
        weights.push_back(flux * disturbances.focus_nm);
        weights.push_back(0.5 * flux * disturbances.focus_nm * disturbances.focus_nm);
    }
    return weights;
}

} // namespace

const Atlas &MovedStars::atlas() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!atlas_) {
        const MemoryScope scope(memory_);
        atlas_ = std::make_unique<Atlas>(scene_, pupil_, plan_, light_, plan_.atlas.reach,
                                         [this](const Plan &, const Imager &imager, const Light &light, size_t star) {
                                             return planes_of(scene_.systematics, imager, light, star);
                                         });
    }
    return *atlas_;
}

void MovedStars::add_interpolated(size_t star, const Place &place, const std::vector<double> &weights,
                                  double *image) const {
    const Atlas &known = atlas();
    const Atlas::Place among = known.place(star, place[0], place[1], 1);
    const size_t cols = known.cols();
    Buffer<double> row(cols), scratch(known.scratch_size());
    for (size_t r = 0; r < plan_.pixels.rows; r++) {
        known.row(star, weights, among, r, row.data(), scratch.data());
        for (size_t i = 0; i < cols; i++)
            image[r * cols + i] += row[i];
    }
}

void MovedStars::add_propagated(size_t star, const Place &place, const std::vector<double> &weights,
                                double *image) const {
    Light light = light_;
    for (size_t i = 0; i < 2; i++)
        light.offset_px[star][i] = static_cast<double>(place[i]);
    const Planes planes = planes_of(scene_.systematics, imager_, light, star);
    for (size_t plane = planes.size(); plane-- > 0;) // the smallest terms first
        for (size_t i = 0; i < planes[plane].size(); i++)
            image[i] += weights[plane] * planes[plane][i];
}

void MovedStars::expect(double displacement_px, const Disturbances &disturbances, double days, double *image) const {
    const Offsets offsets = offsets_at(scene_, light_, days);
    const auto axis = axis_of(scene_, offsets);
    const size_t pixels = plan_.pixels.rows * plan_.pixels.cols;
    std::fill_n(image, pixels, disturbances.background_photons);
    for (size_t star = 0; star < scene_.stars.size(); star++) {
        const double wobble = star == scene_.signal.star ? displacement_px : 0;
        const Place place = place_of(disturbances, offsets[star], axis.data(), wobble);
        const std::vector<double> weights = weights_of(scene_.systematics, disturbances, 1 + disturbances.flux[star]);
        const bool interpolated = plan_.frames == Frames::atlas && atlas().covers(star, place[0], place[1]);
        interpolated ? add_interpolated(star, place, weights, image) : add_propagated(star, place, weights, image);
    }
    detector_.collect(image);
    for (size_t i = 0; i < pixels; i++)
        image[i] = std::max(0.0, image[i] + detector_.dark_e());
}

} // namespace toliman::optics
