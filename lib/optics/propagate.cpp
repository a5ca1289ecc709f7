#include "optics/propagate.hpp"

#include <cmath>

#include "base/workers.hpp"
#include "kernels/field.hpp"
#include "optics/matrix_dft.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kChunks = 8; // of the wavelengths; fixed, so that sums have one order on any number of workers
constexpr long double kPi = 3.14159265358979323846264338327950288L;

// The work of one thread: memory for the fields of one wavelength and the images that they add to.
class Chunk {
  public:
    Chunk(const Scene &scene, const Pupil &pupil, const Light &light, size_t star, double displacement_px,
          Detail detail);
    void add(size_t wavelength);
    StarImages take() noexcept { return std::move(images_); }

  private:
    void tilt(long double offset_px, long double step, Buffer<double> &cycles) const noexcept;
    void focus(size_t derivative, Plane &pupil_plane) noexcept {
        dft_.transform(pupil_plane.field(), focal_[derivative].field());
    }
    kernels::Field focal(size_t derivative) noexcept { return focal_[derivative].field(); }

    const Scene &scene_;
    const Pupil &pupil_;
    const Light &light_;
    size_t star_, pixels_;
    Detail detail_;
    long double offset_[2]; // px; long double, since 1e-10 px beside 40 px would lose 7e-15
    Buffer<double> tilt_x_, tilt_y_;
    Plane field_, derivative_;
    std::vector<Plane> focal_; // of E, dE/dx, dE/dy, d2E along the axis, as far as needed
    MatrixDft dft_;
    StarImages images_;
};

Chunk::Chunk(const Scene &scene, const Pupil &pupil, const Light &light, size_t star, double displacement_px,
             Detail detail)
    : scene_(scene), pupil_(pupil), light_(light), star_(star), pixels_(scene.detector.rows * scene.detector.cols),
      detail_(detail), tilt_x_(pupil.samples), tilt_y_(pupil.samples), field_(pupil.samples * pupil.samples),
      derivative_(pupil.samples * pupil.samples), dft_(pupil.samples, scene.detector.rows, scene.detector.cols) {
    for (size_t axis = 0; axis < 2; axis++)
        offset_[axis] = light.offset_px[star][axis] + static_cast<long double>(displacement_px) * light.axis[axis];
    for (size_t i = 0; i < (detail == Detail::image ? 1 : detail == Detail::gradient ? 3 : 4); i++)
        focal_.emplace_back(pixels_);
    images_.image.resize(pixels_);
    if (detail != Detail::image) {
        images_.dx.resize(pixels_);
        images_.dy.resize(pixels_);
    }
    if (detail == Detail::curvature)
        images_.curvature.resize(pixels_);
}

// Phase of each pupil column (or row) that puts a star at the offset, reduced to half a cycle.
void Chunk::tilt(long double offset_px, long double step, Buffer<double> &cycles) const noexcept {
    const long double centre = 0.5L * static_cast<long double>(cycles.size() - 1);
    for (size_t i = 0; i < cycles.size(); i++) {
        const long double phase = (static_cast<long double>(i) - centre) * offset_px * step;
        cycles[i] = static_cast<double>(phase - std::rint(phase));
    }
}

void Chunk::add(size_t wavelength) {
    const double photons = light_.photons[star_][wavelength];
    if (photons == 0)
        return;
    const long double lambda = light_.wavelength_m[wavelength];
    const long double pixel = scene_.detector.pixel_scale_arcsec * kPi / 648000;
    const long double step = scene_.telescope.aperture_m * pixel / (static_cast<long double>(pupil_.samples) * lambda);
    const double weight = static_cast<double>(photons * step * step / pupil_.area);

    dft_.set_step(step);
    tilt(offset_[0], step, tilt_x_);
    tilt(offset_[1], step, tilt_y_);
    kernels::pupil_field(pupil_.amplitude.data(), pupil_.opd_m.data(), pupil_.samples, static_cast<double>(1 / lambda),
                         tilt_x_.data(), tilt_y_.data(), field_.field());
    focus(0, field_);
    kernels::add_intensity(focal(0), pixels_, weight, images_.image.data());
    if (detail_ == Detail::image)
        return;

    const double slope = static_cast<double>(2 * kPi * step);
    kernels::tilt_derivative(field_.field(), pupil_.samples, slope, 0, derivative_.field());
    focus(1, derivative_);
    kernels::add_derivative(focal(0), focal(1), pixels_, weight, images_.dx.data());
    kernels::tilt_derivative(field_.field(), pupil_.samples, 0, slope, derivative_.field());
    focus(2, derivative_);
    kernels::add_derivative(focal(0), focal(2), pixels_, weight, images_.dy.data());
    if (detail_ == Detail::gradient)
        return;

    const double *axis = light_.axis;
    kernels::tilt_derivative(field_.field(), pupil_.samples, slope * axis[0], slope * axis[1], derivative_.field());
    kernels::tilt_derivative(derivative_.field(), pupil_.samples, slope * axis[0], slope * axis[1],
                             derivative_.field());
    focus(3, derivative_);
    kernels::add_curvature(focal(0), focal(1), focal(2), focal(3), axis[0], axis[1], pixels_, weight,
                           images_.curvature.data());
}

void add(const Buffer<double> &part, Buffer<double> &sum) {
    for (size_t i = 0; i < part.size(); i++)
        sum[i] += part[i];
}

} // namespace

StarImages propagate(const Scene &scene, const Pupil &pupil, const Light &light, size_t star, double displacement_px,
                     Detail detail, unsigned workers, const std::function<void(double)> &done) {
    const size_t count = light.wavelength_m.size();
    std::vector<StarImages> parts(std::min(count, kChunks));
    run_jobs(
        workers, parts.size(),
        [&](size_t part) {
            Chunk chunk(scene, pupil, light, star, displacement_px, detail);
            for (size_t i = part; i < count; i += parts.size())
                chunk.add(i);
            parts[part] = chunk.take();
        },
        done);
    StarImages sum = std::move(parts[0]);
    for (size_t part = 1; part < parts.size(); part++) {
        add(parts[part].image, sum.image);
        add(parts[part].dx, sum.dx);
        add(parts[part].dy, sum.dy);
        add(parts[part].curvature, sum.curvature);
    }
    return sum;
}

} // namespace toliman::optics
