// Method: the light of the stars adds up, and both pass the same optics, so that the image of a star at x is the image
// of the star at the centre, shifted by x. An image has no spatial frequency above f_c = D p/lambda_min cycles per
// pixel: it is determined by samples at distances below 1/(2 f_c), and interpolated with a window of T samples per axis
// (kernels/shift.hpp). The filter that integrates over pixels (pixel.cpp) also divides by the window's transform.
// plan.cpp chooses the distance of the samples and T. Derivatives by the place are those of the window, exact
// derivatives of the interpolated image.
// Measured on 256 x 256 pixels of 0.375" (f_c = 0.43), both stars with both slopes, one core with AVX-512, against a
// propagation (error of the image over its peak, of the slope over its largest pixel):
//   window, 2 samples per px, T = 8     0.8 ms   1.1e-8, 2.4e-7
//                             T = 10    0.8 ms   1.1e-10, 1.7e-9
//                             T = 12    0.9 ms   8.5e-13, 2.5e-11
//                             T = 14    1.1 ms   7e-14, 1.6e-13
//   window, 1 sample per px,  T = 20    0.9 ms   but dividing by its transform amplifies rounding by 2e5
//   Fourier shift on a padded grid of 320 x 320: 1.3 ms for six inverse transforms, without phases; an error of 1e-9 px
//   remains unless the edges of the image are tapered
// The interpolation is linear in the samples: its adjoint spreads weights of pixels over the samples, axis by axis in
// reverse order, with the same weights of the window.
// A Taylor expansion about places along the orbit needs a propagation every 0.3 px.
#include "optics/atlas.hpp"

#include <algorithm>
#include <cmath>

#include "backend/fft.hpp"
#include "base/error.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kVector = 8; // numbers

} // namespace

Plan plan_around(const Plan &plan, const std::array<double, 2> &reach) {
    Plan around = plan;
    around.pixels = atlas_grid(plan, reach);
    around.half_band = plan.atlas.half_band;
    around.filter = plan.atlas.filter;
    around.smear_filter = plan.atlas.smear_filter;
    return around;
}

Atlas::Atlas(const Scene &scene, const Pupil &pupil, const Plan &plan, const Light &light, const Offsets &reach,
             const Draw &draw)
    : rows_(plan.pixels.rows), cols_(plan.pixels.cols), oversampling_(plan.atlas.oversampling),
      window_(plan.atlas.blur.window) {
    for (size_t star = 0; star < scene.stars.size(); star++)
        stars_.push_back(sample(scene, pupil, plan, light, star, reach[star], draw));
}

Atlas::Star Atlas::sample(const Scene &scene, const Pupil &pupil, const Plan &plan, const Light &light, size_t star,
                          const std::array<double, 2> &reach, const Draw &draw) const {
    const Plan around = plan_around(plan, reach);
    Light centred = light;
    centred.offset_px = {};
    const Imager imager(scene, pupil, around, plan.workers);
    const size_t rows = around.pixels.rows, cols = around.pixels.cols, part = cols / oversampling_ + 1 + kVector;
    Star made = {{}, rows, cols, part};
    for (const Buffer<double> &image : draw(around, imager, centred, star))
        made.planes.push_back(samples_of(made, image));
    return made;
}

// Calls visit(index in the image, index in the plane).
template <class Visit> void Atlas::for_each_sample(const Star &star, Visit visit) const {
    for (size_t row = 0; row < star.rows; row++)
        for (size_t col = 0; col < star.cols; col++)
            visit(row * star.cols + col, (row * oversampling_ + col % oversampling_) * star.part + col / oversampling_);
}

// A sample holds the light of its own small area.
Buffer<double> Atlas::samples_of(const Star &star, const Buffer<double> &image) const {
    const double area = static_cast<double>(oversampling_ * oversampling_);
    Buffer<double> samples(star.rows * oversampling_ * star.part);
    for_each_sample(star, [&](size_t from, size_t to) { samples[to] = area * image[from]; });
    return samples;
}

Buffer<double> Atlas::samples_of(size_t star, const Buffer<double> &image) const {
    return samples_of(stars_[star], image);
}

Buffer<double> Atlas::image_weights(size_t star, const Buffer<double> &samples) const {
    const double area = static_cast<double>(oversampling_ * oversampling_);
    Buffer<double> image(stars_[star].rows * stars_[star].cols);
    for_each_sample(stars_[star], [&](size_t to, size_t from) { image[to] = area * samples[from]; });
    return image;
}

Atlas Atlas::scaled(double factor) const {
    Atlas made = *this;
    for (Star &star : made.stars_)
        for (Buffer<double> &plane : star.planes)
            for (double &sample : plane)
                sample *= factor;
    return made;
}

// Two planes at once, as real and imaginary part. The inverse transform is the conjugate of that of the conjugate.
Atlas Atlas::filtered(const Transfer &transfer, double factor) const {
    Atlas made = *this;
    size_t side = 0;
    for (const Star &star : stars_)
        side = std::max({side, star.rows, star.cols});
    side = fft::fast_size(side);
    const double step = static_cast<double>(oversampling_) / static_cast<double>(side);
    const auto frequency = [&](size_t k) {
        return step * (k < side / 2 ? static_cast<double>(k) : static_cast<double>(k) - static_cast<double>(side));
    };
    Buffer<std::complex<double>> factors(side * side);
    for (size_t y = 0; y < side; y++)
        for (size_t x = 0; x < side; x++)
            factors[y * side + x] = transfer(frequency(x), frequency(y)) * (factor / static_cast<double>(side * side));
    fft::Square square(side);
    std::complex<double> *const data = square.data();
    for (Star &star : made.stars_)
        for (size_t first = 0; first < star.planes.size(); first += 2) {
            Buffer<double> &real = star.planes[first],
                           &other = star.planes[std::min(first + 1, star.planes.size() - 1)];
            std::fill_n(data, side * side, 0);
            const auto at = [&](size_t image) { return image / star.cols * side + image % star.cols; };
            for_each_sample(star, [&](size_t from, size_t to) { data[at(from)] = {real[to], other[to]}; });
            square.transform();
            for (size_t i = 0; i < side * side; i++)
                data[i] = std::conj(data[i] * factors[i]);
            square.transform();
            for_each_sample(star, [&](size_t from, size_t to) {
                other[to] = -data[at(from)].imag();
                real[to] = data[at(from)].real();
            });
        }
    return made;
}

bool Atlas::covers(size_t star, long double x, long double y) const noexcept {
    const size_t half = window_.taps / 2;
    const auto within = [this, half](size_t samples, size_t pixels, long double place) {
        const auto step = static_cast<long double>(oversampling_);
        const long double first = 0.5L * static_cast<long double>(samples - 1) -
                                  step * (0.5L * static_cast<long double>(pixels - 1) + std::fabs(place));
        return first >= static_cast<long double>(half);
    };
    return within(stars_[star].cols, cols_, x) && within(stars_[star].rows, rows_, y);
}

Atlas::Place Atlas::place(size_t star, long double x, long double y, size_t orders) const noexcept {
    Place place;
    const auto along = [&](size_t samples, size_t pixels, long double at, double *weights) {
        const auto step = static_cast<long double>(oversampling_);
        const long double first =
            0.5L * static_cast<long double>(samples - 1) - step * (0.5L * static_cast<long double>(pixels - 1) + at);
        const long double sample = std::floor(first);
        window_.weights(static_cast<double>(first - sample), orders, weights);
        double factor = 1; // derivatives by the star's place in px instead of the fraction
        for (size_t order = 1; order < orders; order++) {
            factor *= -static_cast<double>(oversampling_);
            for (size_t tap = 0; tap < window_.taps; tap++)
                weights[order * kernels::kMostTaps + tap] *= factor;
        }
        return static_cast<size_t>(sample) + 1 - window_.taps / 2;
    };
    place.col = along(stars_[star].cols, cols_, x, place.x[0]);
    place.row = along(stars_[star].rows, rows_, y, place.y[0]);
    return place;
}

// The samples of a row that contribute to the pixels: of each part as many, one part after the other; whole vectors.
size_t Atlas::used() const noexcept {
    return (cols_ + window_.taps / oversampling_ + kVector) / kVector * kVector;
}

// Of the samples of a part that contribute to row r, tap by tap.
void Atlas::offsets_along_y(const Star &star, const Place &place, size_t r, size_t part,
                            size_t *offset) const noexcept {
    for (size_t tap = 0; tap < window_.taps; tap++)
        offset[tap] =
            ((place.row + r * oversampling_ + tap) * oversampling_ + part) * star.part + place.col / oversampling_;
}

// Of the sums along y that contribute to the pixels of a row.
void Atlas::offsets_along_x(const Place &place, size_t *offset) const noexcept {
    for (size_t tap = 0; tap < window_.taps; tap++) {
        const size_t col = place.col % oversampling_ + tap;
        offset[tap] = col % oversampling_ * used() + col / oversampling_;
    }
}

void Atlas::sum_along_y(const Star &star, const Buffer<double> &plane, const Place &place, size_t r, size_t orders,
                        double *const *lines) const noexcept {
    size_t offset[kernels::kMostTaps];
    for (size_t part = 0; part < oversampling_; part++) {
        offsets_along_y(star, place, r, part, offset);
        double *const sums[] = {lines[0] + part * used(), orders > 1 ? lines[1] + part * used() : nullptr,
                                orders > 2 ? lines[2] + part * used() : nullptr};
        kernels::shift_kernels().sum(plane.data(), offset, place.y[0], orders, window_.taps, used(), sums);
    }
}

void Atlas::sum_along_x(const double *line, const Place &place, size_t orders, double *const *out) const noexcept {
    size_t offset[kernels::kMostTaps];
    offsets_along_x(place, offset);
    kernels::shift_kernels().sum(line, offset, place.x[0], orders, window_.taps, cols_, out);
}

void Atlas::row(size_t star, size_t plane, const Place &place, size_t r, size_t orders, double *const *out,
                double *scratch) const noexcept {
    const size_t line = oversampling_ * used();
    double *const lines[] = {scratch, scratch + line, scratch + 2 * line};
    sum_along_y(stars_[star], stars_[star].planes[plane], place, r, orders, lines);
    double *const by_x[] = {out[0], orders > 1 ? out[1] : nullptr, orders > 2 ? out[3] : nullptr};
    sum_along_x(lines[0], place, orders, by_x);
    if (orders > 1) {
        double *const by_xy[] = {out[2], orders > 2 ? out[4] : nullptr};
        sum_along_x(lines[1], place, orders - 1, by_xy);
    }
    if (orders > 2)
        sum_along_x(lines[2], place, 1, out + 5);
}

void Atlas::row_of_samples(size_t star, const Buffer<double> &samples, const Place &place, size_t r, double *out,
                           double *scratch) const noexcept {
    sum_along_y(stars_[star], samples, place, r, 1, &scratch);
    sum_along_x(scratch, place, 1, &out);
}

void Atlas::spread(size_t star, const double *weights, const Place &place, size_t r, Buffer<double> &samples,
                   double *scratch) const noexcept {
    size_t offset[kernels::kMostTaps];
    std::fill_n(scratch, oversampling_ * used(), 0.0);
    offsets_along_x(place, offset);
    kernels::shift_kernels().spread(weights, offset, place.x[0], window_.taps, cols_, scratch);
    for (size_t part = 0; part < oversampling_; part++) {
        offsets_along_y(stars_[star], place, r, part, offset);
        kernels::shift_kernels().spread(scratch + part * used(), offset, place.y[0], window_.taps, used(),
                                        samples.data());
    }
}

} // namespace toliman::optics
