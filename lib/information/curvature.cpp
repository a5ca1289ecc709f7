// Method: the frame is propagated with the parameter changed by +h and by -h,
//     1/2 d^2 I/dp^2 = (I(+h) + I(-h) - 2 I(0))/(2 h^2).
// Each h changes the image by 1e-5 to 1e-3 of its peak, so that h^2 is far above the rounding of the images, 1e-15, and
// the fourth derivative that the difference contains is below 1e-4 of the second. Pupil, light and detector are changed
// after the scene has been read, so that fluxes stay and nothing is scaled to the peak again.
#include "information/curvature.hpp"

#include <cmath>

#include "kernels/blackbody.hpp"
#include "scene/geometry.hpp"
#include "scene/instrument.hpp"

namespace toliman::information {

namespace {

using namespace optics;
using Kind = Parameter::Kind;

// What an image depends on.
struct Model {
    Scene scene;
    Pupil pupil;
    Light light;
    Plan plan;
};

// The step h, in the parameter's unit; 0 where there is none.
double step_of(Kind kind) noexcept {
    switch (kind) {
    case Kind::shift_x:
    case Kind::shift_y:
        return 1e-3;
    case Kind::roll:
    case Kind::position_angle:
    case Kind::scale:
    case Kind::anisotropy:
    case Kind::shear:
        return 1e-5;
    case Kind::focus:
    case Kind::zernike:
        return 1;
    case Kind::temperature_a:
    case Kind::temperature_b:
        return 10;
    case Kind::wavelength:
        return 0.1;
    default:
        return 0;
    }
}

// A spectral mode at equal flux has a second order, a multiple of its first, which the fit removes.
bool is_linear(Kind kind) noexcept {
    return kind == Kind::flux_a || kind == Kind::flux_b || kind == Kind::background || kind == Kind::spectrum_a ||
           kind == Kind::spectrum_b;
}

// Rotates an offset about a centre, from x towards y.
void rotate(std::array<double, 2> &offset, const std::array<double, 2> &centre, double angle) noexcept {
    const double x = offset[0] - centre[0], y = offset[1] - centre[1];
    offset = {centre[0] + x * std::cos(angle) - y * std::sin(angle),
              centre[1] + x * std::sin(angle) + y * std::cos(angle)};
}

void change_positions(Kind kind, double by, Model &model) noexcept {
    Light &light = model.light;
    for (auto &offset : light.offset_px) {
        offset[0] += kind == Kind::shift_x ? by : 0;
        offset[1] += kind == Kind::shift_y ? by : 0;
        if (kind == Kind::roll)
            rotate(offset, {0, 0}, by);
    }
    if (kind == Kind::position_angle)
        rotate(light.offset_px[1], light.offset_px[0], by);
}

void change_detector(Kind kind, double by, Model &model) noexcept {
    Detector &detector = model.scene.detector;
    const Geometry before = geometry_of(detector);
    const double stretch = kind == Kind::scale ? 1 + by : 1;
    detector.pixel_scale_arcsec /= stretch;
    detector.scale_anisotropy += kind == Kind::anisotropy ? by : 0;
    detector.shear += kind == Kind::shear ? by : 0;
    const auto move = [&](auto &px) {
        const auto angle = before.to_angle(stretch * px[0], stretch * px[1]);
        const auto moved = geometry_of(detector).to_pixels(angle[0], angle[1]);
        std::copy(moved.begin(), moved.end(), &px[0]);
    };
    for (auto &offset : model.light.offset_px)
        move(offset);
    move(model.light.dispersion);
    model.plan.pixels = grid_of(detector);
}

// At equal flux.
void change_temperature(size_t star, double by, Model &model) noexcept {
    const double temperature = temperature_of(model.scene, star);
    std::vector<double> &photons = model.light.photons[star];
    double before = 0, after = 0;
    for (size_t i = 0; i < photons.size(); i++) {
        const double wavelength = model.light.wavelength_m[i];
        before += model.light.before_qe(star, i);
        photons[i] *= kernels::blackbody_photons(wavelength, temperature + by) /
                      kernels::blackbody_photons(wavelength, temperature);
        after += model.light.before_qe(star, i);
    }
    for (double &value : photons)
        value *= before / after;
}

void change_opd(int noll, double by, Pupil &pupil) {
    const Mode mode = zernike_mode(pupil, noll);
    for (size_t i = 0; i < mode.opd_m.size(); i++)
        pupil.opd_m[i] += by * mode.opd_m[i];
}

void change(Parameter parameter, double by, Model &model) {
    switch (parameter.kind) {
    case Kind::focus:
        return change_opd(4, by, model.pupil);
    case Kind::zernike:
        return change_opd(parameter.number, by, model.pupil);
    case Kind::scale:
    case Kind::anisotropy:
    case Kind::shear:
        return change_detector(parameter.kind, by, model);
    case Kind::temperature_a:
    case Kind::temperature_b:
        return change_temperature(parameter.kind == Kind::temperature_b ? 1 : 0, by, model);
    case Kind::wavelength:
        for (double &wavelength : model.light.wavelength_m)
            wavelength += by * 1e-9;
        return;
    default:
        return change_positions(parameter.kind, by, model);
    }
}

// sum += weight times the expected electrons of the model's stars
void add_frame(const Model &model, const DetectorStages &detector, double weight, Buffer<double> &sum) {
    const Imager imager(model.scene, model.pupil, model.plan, model.plan.workers);
    for (size_t star = 0; star < model.scene.stars.size(); star++) {
        StarImages images = imager.images(model.light, star, 0, {});
        Buffer<double> &image = images.derivatives[0].image;
        detector.collect(image);
        for (size_t i = 0; i < sum.size(); i++)
            sum[i] += weight * image[i];
    }
}

} // namespace

std::optional<Buffer<double>> half_curvature(const optics::Simulator &simulator, Parameter parameter) {
    if (is_linear(parameter.kind))
        return Buffer<double>();
    const double step = step_of(parameter.kind);
    if (step == 0 || simulator.plan().engine == EngineKind::padded_fft)
        return std::nullopt;
    const Model model = {simulator.scene(), simulator.pupil(), simulator.light(), simulator.plan()};
    const double weight = 1 / (2 * step * step);
    Buffer<double> sum = simulator.images().both();
    for (double &value : sum)
        value = -2 * weight * (value - simulator.detector().dark_e());
    for (const double by : {step, -step}) {
        Model changed = model;
        change(parameter, by, changed);
        add_frame(changed, simulator.detector(), weight, sum);
    }
    return sum;
}

} // namespace toliman::information
