// Method: each derivative is exact, of one of four kinds.
//     pupil     A mode Z of the OPD adds the field (2 pi i/lambda) Z E, a motion of the mask the derivative of E:
//               dI = 2 Re(conj F dF), one more transform per wavelength.
//     place     Shear and anisotropy of the detector, jitter and position angle are combinations of the image's
//               derivatives by the star's position. A Gaussian blur of covariance q obeys the heat equation:
//               dI/dq_xx = 1/2 d^2 I/dx^2, dI/dq_xy = d^2 I/dx dy. Smear takes the second derivative along its path
//               through a filter of its own (smear.cpp).
//     spectrum  The image is linear in the photons w_i of the wavelengths. With r_i = d log s_i of the spectrum s, at
//               equal flux, dw_i = w_i (r_i - sum w r/sum w).
//     wavelength  F at the pixel u, of a star at o, depends on k = 2 pi/lambda by k (OPD + x (o - u)), and I has the
//               factor k^2. With the images J of the photons w/lambda, J_k by the OPD's part,
//                   dI/dlambda = -2 J - (o - u) dJ/do - J_k = dJ/dscale - o dJ/do - J_k,
//               where d/dscale is about the axis. In a sidelobe o = o_c + d (lambda - lambda_c): the terms in
//               lambda - lambda_c and d dI/do together are lambda_c d dJ/do.
#include "optics/derivatives.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "optics/nodes.hpp"
#include "optics/readout.hpp"
#include "optics/spectrum.hpp"

namespace toliman::optics {

namespace {

using Kind = Parameter::Kind;

constexpr size_t kModesAtOnce = 8; // of one propagation, which holds their fields and pupil planes

bool is_mask_motion(Kind kind) noexcept {
    return kind == Kind::mask_rotation || kind == Kind::mask_shift_x || kind == Kind::mask_shift_y;
}

bool is_place(Kind kind) noexcept {
    return kind == Kind::position_angle || kind == Kind::anisotropy || kind == Kind::shear || kind == Kind::jitter_xx ||
           kind == Kind::jitter_yy || kind == Kind::jitter_xy || kind == Kind::diffusion;
}

// sum += weight image
void add(double weight, const Buffer<double> &image, Buffer<double> &sum) {
    sum.resize(image.size());
    for (size_t i = 0; i < image.size(); i++)
        sum[i] += weight * image[i];
}

// Second derivatives by the star's place: weights of d^2/dx^2, d^2/dx dy and d^2/dy^2.
struct Curvature {
    double xx, xy, yy;
};

// Adds a star's share to that sum. d/dx = x d/da - y d/dc and d/dy = y d/da + x d/dc, applied twice.
void add_curvature(const StarImages &star, const Light &light, const Curvature &by, Buffer<double> &sum) {
    const double x = light.axis[0], y = light.axis[1];
    add(by.xx * x * x + by.xy * x * y + by.yy * y * y, star.at(2, 0), sum);
    add(2 * (by.yy - by.xx) * x * y + by.xy * (x * x - y * y), star.at(1, 1), sum);
    add(by.xx * y * y - by.xy * x * y + by.yy * x * x, star.at(0, 2), sum);
}

// Adds a star's share to the derivative by a parameter of kind `place`. (x, y) is the axis of the position derivatives.
void add_place(const StarImages &star, const Light &light, size_t number, Kind kind, Buffer<double> &sum) {
    const double x = light.axis[0], y = light.axis[1];
    if (kind == Kind::anisotropy)
        return add(1, star.anisotropy, sum);
    if (kind == Kind::shear)
        return add(1, star.shear, sum);
    if (kind == Kind::position_angle) { // B moves across its separation from A, from x towards y
        const double u = light.offset_px[1][0] - light.offset_px[0][0],
                     v = light.offset_px[1][1] - light.offset_px[0][1];
        add(number == 1 ? -v * x + u * y : 0, star.at(1, 0), sum);
        return add(number == 1 ? v * y + u * x : 0, star.at(0, 1), sum);
    }
    if (kind == Kind::diffusion) { // in x and in y
        add(0.5, star.at(2, 0), sum);
        return add(0.5, star.at(0, 2), sum);
    }
    add_curvature(
        star, light,
        {kind == Kind::jitter_xx ? 0.5 : 0, kind == Kind::jitter_xy ? 1.0 : 0, kind == Kind::jitter_yy ? 0.5 : 0}, sum);
}

// Adds a star's share to the derivative by the square of the length of the scene's smear.
void add_smear(const Scene &scene, const Plan &plan, const Imager &imager, const Light &light, size_t star,
               Buffer<double> &sum) {
    Plan along_path = plan;
    along_path.filter = plan.smear_filter;
    ImageRequest request;
    request.plane = 2;
    const StarImages images = imager.with_plan(along_path).images(light, star, 0, request);
    const double angle = scene.systematics.smear->angle_deg * kPi / 180, x = std::cos(angle), y = std::sin(angle);
    add_curvature(images, light, {x * x, 2 * x * y, y * y}, sum);
}

// Logarithmic derivative of the spectrum at each wavelength.
std::vector<double> spectral_rate(const Scene &scene, const Light &light, Parameter parameter) {
    std::vector<double> rate;
    const size_t star = star_of_spectrum(parameter.kind);
    const bool temperature = parameter.kind == Kind::temperature_a || parameter.kind == Kind::temperature_b;
    for (const double wavelength_m : light.wavelength_m)
        rate.push_back(temperature ? temperature_rate(scene, star, wavelength_m)
                                   : mode_rate(scene, star, parameter.number, wavelength_m));
    return rate;
}

// A spectral mode multiplies the spectrum by a polynomial, which shifts its Chebyshev moments by as many orders.
Light on_nodes(const Light &light, const Plan &plan) {
    const size_t count = plan.wavelengths + kSpectralModes;
    return plan.nodes && count < light.wavelength_m.size() ? project_on_nodes(light, count) : light;
}

// Adds a star's share to the derivative by a common shift of all wavelengths, per nm towards longer ones.
void add_wavelength(const Plan &plan, const Imager &imager, const Light &light, size_t star, Buffer<double> &sum) {
    Light over_wavelength = light;
    std::vector<double> &photons = over_wavelength.photons[star];
    for (size_t i = 0; i < photons.size(); i++)
        photons[i] *= 1e-9 / light.wavelength_m[i];
    Mode mode;
    mode.of_wavenumber = true;
    ImageRequest request;
    request.plane = 1;
    request.focus = true; // and scale
    request.modes = {&mode};
    const StarImages images = imager.images_of_samples(on_nodes(over_wavelength, plan), star, 0, request);
    const double x = light.centre_m * light.dispersion[0] - light.offset_px[star][0],
                 y = light.centre_m * light.dispersion[1] - light.offset_px[star][1];
    add(1, images.scale, sum);
    add(x * light.axis[0] + y * light.axis[1], images.at(1, 0), sum);
    add(y * light.axis[0] - x * light.axis[1], images.at(0, 1), sum);
    add(-1, images.modes[0], sum);
}

} // namespace

bool is_mode(Kind kind) noexcept {
    return kind == Kind::zernike || is_mask_motion(kind);
}

size_t star_of_spectrum(Kind kind) noexcept {
    if (kind == Kind::temperature_a || kind == Kind::spectrum_a)
        return 0;
    return kind == Kind::temperature_b || kind == Kind::spectrum_b ? 1 : 2;
}

Mode mode_of(const Scene &scene, const Pupil &pupil, Parameter parameter) {
    switch (parameter.kind) {
    case Kind::mask_rotation:
        return mask_mode(scene, pupil, MaskMotion::rotation);
    case Kind::mask_shift_x:
        return mask_mode(scene, pupil, MaskMotion::shift_x);
    case Kind::mask_shift_y:
        return mask_mode(scene, pupil, MaskMotion::shift_y);
    case Kind::focus:
        return zernike_mode(pupil, 4);
    default:
        return zernike_mode(pupil, parameter.number);
    }
}

Light changed_spectrum(const Scene &scene, const Light &light, Parameter parameter) {
    const size_t star = star_of_spectrum(parameter.kind);
    Light changed = light;
    std::vector<double> &photons = changed.photons[star];
    const std::vector<double> rate = spectral_rate(scene, light, parameter);
    double total = 0, mean = 0;
    for (size_t i = 0; i < photons.size(); i++) {
        const double before = light.before_qe(star, i); // the flux that does not change
        total += before;
        mean += before * rate[i];
    }
    mean /= total;
    for (size_t i = 0; i < photons.size(); i++)
        photons[i] *= rate[i] - mean;
    return changed;
}

bool has_own_derivative(Parameter parameter) noexcept {
    return is_mode(parameter.kind) || is_place(parameter.kind) || star_of_spectrum(parameter.kind) < 2 ||
           parameter.kind == Kind::wavelength || parameter.kind == Kind::smear || Readout::has(parameter.kind);
}

const char *why_no_derivative(const Scene &scene, const Plan &plan, Parameter parameter) noexcept {
    const size_t star = star_of_spectrum(parameter.kind);
    const Mask &mask = scene.telescope.mask;
    const bool two = scene.stars.size() == 2;
    if (!two && (parameter.kind == Kind::flux_b || star == 1 || parameter.kind == Kind::position_angle))
        return "the scene has star A only";
    if (is_mask_motion(parameter.kind) && (mask.kind != Mask::Kind::spiral || mask.edges != Mask::Edges::area))
        return "needs a spiral mask with mask.edges = \"area\"";
    if (parameter.kind == Kind::flat)
        return "is a number for each pixel";
    if (Readout::has(parameter.kind))
        return nullptr;
    if (parameter.kind == Kind::smear && !scene.systematics.smear)
        return "needs systematics.smear";
    if (has_own_derivative(parameter) && plan.engine == EngineKind::padded_fft)
        return "the padded FFT does not compute it";
    if (star < 2 && scene.stars[star].spectrum.kind == Spectrum::Kind::lines)
        return "the spectrum consists of lines";
    if (star < 2 && (!scene.band || !(scene.band->max_nm > scene.band->min_nm)))
        return "needs a band of several wavelengths";
    return nullptr;
}

void check_parameter(const Scene &scene, const Plan &plan, Parameter parameter) {
    if (const char *const why = why_no_derivative(scene, plan, parameter))
        fail(Status::unsupported, "%s: derivative by %s: %s", scene.source.c_str(), name_of(parameter).c_str(), why);
}

std::vector<Parameter> computed_with(const Scene &scene, Parameter parameter) {
    if (!is_place(parameter.kind))
        return {parameter};
    std::vector<Parameter> together;
    for (const Parameter other : all_parameters())
        if (is_place(other.kind) && (other.kind != Kind::position_angle || scene.stars.size() == 2))
            together.push_back(other);
    return together;
}

std::vector<Buffer<double>> derivatives(const Scene &scene, const Pupil &pupil, const Plan &plan, const Imager &imager,
                                        const Light &light, const std::vector<Parameter> &parameters) {
    std::vector<Buffer<double>> sums(parameters.size());
    std::vector<size_t> of_pupil;
    bool place = false;
    for (size_t p = 0; p < parameters.size(); p++) {
        check_parameter(scene, plan, parameters[p]);
        place |= is_place(parameters[p].kind);
        if (is_mode(parameters[p].kind))
            of_pupil.push_back(p);
    }
    for (size_t first = 0; first < of_pupil.size(); first += kModesAtOnce) {
        std::vector<Mode> modes;
        for (size_t i = first; i < std::min(first + kModesAtOnce, of_pupil.size()); i++)
            modes.push_back(mode_of(scene, pupil, parameters[of_pupil[i]]));
        ImageRequest request;
        for (const Mode &mode : modes)
            request.modes.push_back(&mode);
        for (size_t star = 0; star < scene.stars.size(); star++) {
            const StarImages images = imager.images(light, star, 0, request);
            for (size_t i = 0; i < modes.size(); i++)
                add(1, images.modes[i], sums[of_pupil[first + i]]);
        }
    }
    for (size_t star = 0; star < scene.stars.size(); star++) {
        StarImages at_place;
        if (place) {
            ImageRequest request;
            request.plane = 2;
            request.geometry = true;
            at_place = imager.images(light, star, 0, request);
        }
        for (size_t p = 0; p < parameters.size(); p++) {
            const Kind kind = parameters[p].kind;
            if (is_place(kind))
                add_place(at_place, light, star, kind, sums[p]);
            else if (star_of_spectrum(kind) == star)
                add(1,
                    imager.images_of_samples(on_nodes(changed_spectrum(scene, light, parameters[p]), plan), star, 0, {})
                        .at(0, 0),
                    sums[p]);
            else if (kind == Kind::smear)
                add_smear(scene, plan, imager, light, star, sums[p]);
            else if (kind == Kind::wavelength)
                add_wavelength(plan, imager, light, star, sums[p]);
        }
    }
    return sums;
}

} // namespace toliman::optics
