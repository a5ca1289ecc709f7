// C interface of the atlas, its adjoint, and of images propagated at a place.
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "optics/atlas.hpp"
#include "optics/simulator.hpp"

using namespace toliman;
using namespace toliman::optics;

namespace {

struct Case {
    explicit Case(const char *json) : outline(outline_of(std::string(json), "scene", ".", {})) {
        outline.light.axis[0] = 1; // derivatives by x and y
        outline.light.axis[1] = 0;
    }
    Outline outline;
    Offsets reach = {};
    std::unique_ptr<Atlas> atlas;
};

Planes image_and_focus(const Plan &, const Imager &imager, const Light &light, size_t star) {
    ImageRequest request;
    request.plane = 1;
    request.focus = true;
    StarImages images = imager.images(light, star, 0, request);
    Planes planes;
    planes.push_back(std::move(images.derivatives[0].image));
    planes.push_back(std::move(images.focus));
    return planes;
}

} // namespace

extern "C" void *shim_atlas_make(const char *json, double reach_x, double reach_y, double *error, size_t *shape) {
    auto made = std::make_unique<Case>(json);
    const Outline &outline = made->outline;
    made->reach = {{{reach_x, reach_y}, {reach_x, reach_y}}};
    made->atlas = std::make_unique<Atlas>(outline.scene, outline.pupil, outline.plan, outline.light, made->reach,
                                          image_and_focus);
    error[0] = outline.plan.atlas.error;
    error[1] = outline.plan.filter.error;
    shape[0] = outline.plan.pixels.rows;
    shape[1] = outline.plan.pixels.cols;
    return made.release();
}

extern "C" void shim_atlas_destroy(void *made) {
    delete static_cast<Case *>(made);
}

extern "C" int shim_atlas_covers(const void *made, size_t star, double x, double y) {
    return static_cast<const Case *>(made)->atlas->covers(star, x, y) ? 1 : 0;
}

// Image, x, y, xx, xy, yy of a plane, as many as the orders imply.
extern "C" void shim_atlas_images(const void *made, size_t star, size_t plane, double x, double y, size_t orders,
                                  double *const *images) {
    const Atlas &atlas = *static_cast<const Case *>(made)->atlas;
    const Atlas::Place place = atlas.place(star, x, y, orders);
    Buffer<double> scratch(atlas.scratch_size());
    for (size_t r = 0; r < static_cast<const Case *>(made)->outline.plan.pixels.rows; r++) {
        double *rows[6];
        for (size_t i = 0; i < orders * (orders + 1) / 2; i++)
            rows[i] = images[i] + r * atlas.cols();
        atlas.row(star, plane, place, r, orders, rows, scratch.data());
    }
}

// The first plane again, as an image that the atlas does not keep: its error against shim_atlas_images() over its
// largest pixel. And of the adjoint: sum over pixels of weights times the interpolated image `samples` of random
// numbers, minus the sum over the image of its adjoint, over the sum of absolute values.
extern "C" void shim_atlas_adjoint(const void *made, size_t star, double x, double y, double (*random)(void),
                                   double *errors) {
    const Atlas &atlas = *static_cast<const Case *>(made)->atlas;
    const Plan around =
        plan_around(static_cast<const Case *>(made)->outline.plan, static_cast<const Case *>(made)->reach[star]);
    const Atlas::Place place = atlas.place(star, x, y, 1);
    const size_t rows = static_cast<const Case *>(made)->outline.plan.pixels.rows, cols = atlas.cols();
    Buffer<double> scratch(atlas.scratch_size()), image(around.pixels.rows * around.pixels.cols), row(cols),
        weights(cols), kept(cols);
    for (double &value : image)
        value = random();
    const Buffer<double> samples = atlas.samples_of(star, image);
    Buffer<double> adjoint(samples.size());
    double by_pixels = 0, by_samples = 0, size = 0, difference = 0, largest = 0;
    double *const out[] = {kept.data()};
    for (size_t r = 0; r < rows; r++) {
        atlas.row(star, 0, place, r, 1, out, scratch.data());
        atlas.row_of_samples(star, atlas.plane(star, 0), place, r, row.data(), scratch.data());
        for (size_t c = 0; c < cols; c++) {
            difference = std::max(difference, std::fabs(row[c] - kept[c]));
            largest = std::max(largest, std::fabs(kept[c]));
        }
        atlas.row_of_samples(star, samples, place, r, row.data(), scratch.data());
        for (size_t c = 0; c < cols; c++) {
            weights[c] = random();
            by_pixels += weights[c] * row[c];
            size += std::fabs(weights[c] * row[c]);
        }
        atlas.spread(star, weights.data(), place, r, adjoint, scratch.data());
    }
    const Buffer<double> of_image = atlas.image_weights(star, adjoint);
    for (size_t i = 0; i < image.size(); i++)
        by_samples += of_image[i] * image[i];
    errors[0] = difference / largest;
    errors[1] = std::fabs(by_pixels - by_samples) / size;
}

// The same by propagation at the place; the last is the derivative by focus.
extern "C" void shim_atlas_propagated(const void *made, size_t star, double x, double y, double *const *images) {
    const Outline &outline = static_cast<const Case *>(made)->outline;
    const Imager imager(outline.scene, outline.pupil, outline.plan, 1);
    Light light = outline.light;
    light.offset_px[star] = {x, y};
    ImageRequest request;
    request.plane = 2;
    request.focus = true;
    const StarImages at = imager.images(light, star, 0, request);
    const Buffer<double> *const in_order[] = {&at.at(0, 0), &at.at(1, 0), &at.at(0, 1), &at.at(2, 0),
                                              &at.at(1, 1), &at.at(0, 2), &at.focus};
    for (size_t i = 0; i < 7; i++)
        std::copy(in_order[i]->begin(), in_order[i]->end(), images[i]);
}
