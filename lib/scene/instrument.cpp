#include "scene/instrument.hpp"

#include <algorithm>
#include <cmath>

namespace toliman {

namespace {

using Kind = Parameter::Kind;

constexpr double kTableTemperature[2] = {5790, 5260}; // K, of tables that name none: alpha Centauri A and B
constexpr double kNanometre = 1e-9;
constexpr int kFocus = 4;                                                                // Noll's number
constexpr double kMostDistortion = 0.1, kLeastTemperature = 100, kMostTemperature = 1e6; // ranges of scene files
constexpr double kMostModes = 0.99; // sum of their coefficients, so that the spectrum remains positive

size_t star_of(Kind kind) noexcept {
    return kind == Kind::temperature_b || kind == Kind::spectrum_b ? 1 : 0;
}

// Coefficient of a Zernike polynomial (m), summed over the terms that name it.
double zernike_of(const Scene &scene, int noll) noexcept {
    double rms_m = 0;
    for (const ZernikeTerm &term : scene.telescope.zernikes)
        rms_m += term.noll == noll ? term.rms_m : 0;
    return rms_m;
}

void add_zernike(Scene &scene, int noll, double rms_m) {
    std::vector<ZernikeTerm> &terms = scene.telescope.zernikes;
    const auto found =
        std::find_if(terms.begin(), terms.end(), [=](const ZernikeTerm &term) { return term.noll == noll; });
    if (found != terms.end())
        found->rms_m += rms_m;
    else
        terms.push_back({noll, rms_m});
}

double mode_of(const Scene &scene, size_t star, int number) noexcept {
    const std::vector<double> &modes = scene.stars[star].spectrum.modes;
    const auto i = static_cast<size_t>(number - 1);
    return i < modes.size() ? modes[i] : 0;
}

void add_mode(Scene &scene, size_t star, int number, double change) {
    std::vector<double> &modes = scene.stars[star].spectrum.modes;
    modes.resize(std::max(modes.size(), static_cast<size_t>(number)));
    modes[static_cast<size_t>(number - 1)] += change;
}

// A table is multiplied by the ratio of two black bodies, that of the star and that of the table.
void add_temperature(Scene &scene, size_t star, double change) {
    Spectrum &spectrum = scene.stars[star].spectrum;
    if (spectrum.kind == Spectrum::Kind::blackbody) {
        spectrum.temperature_k += change;
        return;
    }
    const double before = temperature_of(scene, star);
    if (spectrum.table_temperature_k == 0)
        spectrum.table_temperature_k = before;
    spectrum.star_temperature_k = before + change;
}

// The member that a parameter of the detector, the mask or the jitter adds to.
double *member_of(Scene &scene, Kind kind) noexcept {
    switch (kind) {
    case Kind::anisotropy:
        return &scene.detector.scale_anisotropy;
    case Kind::shear:
        return &scene.detector.shear;
    case Kind::mask_rotation:
        return &scene.telescope.mask.rotation_deg;
    case Kind::mask_shift_x:
        return &scene.telescope.mask.shift_m[0];
    case Kind::mask_shift_y:
        return &scene.telescope.mask.shift_m[1];
    case Kind::jitter_xx:
        return &scene.systematics.jitter.xx;
    case Kind::jitter_yy:
        return &scene.systematics.jitter.yy;
    case Kind::jitter_xy:
        return &scene.systematics.jitter.xy;
    case Kind::diffusion:
        return &scene.detector.diffusion_px2;
    case Kind::transfer_smear:
        return &scene.detector.transfer_smear;
    case Kind::brighter_fatter:
        return &scene.detector.brighter_fatter_px2_per_e;
    case Kind::interpixel_capacitance:
        return &scene.detector.interpixel_capacitance;
    case Kind::nonlinearity:
        return &scene.detector.nonlinearity_per_e;
    default:
        return nullptr;
    }
}

double value_of(const Scene &scene, Parameter parameter) {
    switch (parameter.kind) {
    case Kind::focus:
        return zernike_of(scene, kFocus) / kNanometre;
    case Kind::zernike:
        return zernike_of(scene, parameter.number) / kNanometre;
    case Kind::temperature_a:
    case Kind::temperature_b:
        return temperature_of(scene, star_of(parameter.kind));
    case Kind::spectrum_a:
    case Kind::spectrum_b:
        return mode_of(scene, star_of(parameter.kind), parameter.number);
    default: {
        Scene copy = scene;
        const double *const member = member_of(copy, parameter.kind);
        return member != nullptr ? *member : 0;
    }
    }
}

} // namespace

const char *why_not_adjustable(Parameter parameter) noexcept {
    switch (parameter.kind) {
    case Kind::roll:
    case Kind::position_angle:
        return "roll of the spacecraft and position angle cannot be told apart, and the places of the stars are free";
    case Kind::wavelength:
        return "a common change of all wavelengths cannot be told from scale";
    case Kind::smear:
        return "differs from frame to frame: the fit of a frame determines it";
    case Kind::separation:
    case Kind::shift_x:
    case Kind::shift_y:
    case Kind::flux_a:
    case Kind::flux_b:
    case Kind::background:
        return "is always free in each frame";
    case Kind::flat:
        return "is a number for each pixel: a map of the pixels' response finds them";
    default:
        return nullptr;
    }
}

void adjust(Scene &scene, Parameter parameter, double change) {
    switch (parameter.kind) {
    case Kind::scale: // a stretched image has finer pixels
        scene.detector.pixel_scale_arcsec /= 1 + change;
        break;
    case Kind::focus:
        add_zernike(scene, kFocus, change * kNanometre);
        break;
    case Kind::zernike:
        add_zernike(scene, parameter.number, change * kNanometre);
        break;
    case Kind::temperature_a:
    case Kind::temperature_b:
        add_temperature(scene, star_of(parameter.kind), change);
        break;
    case Kind::spectrum_a:
    case Kind::spectrum_b:
        add_mode(scene, star_of(parameter.kind), parameter.number, change);
        break;
    default:
        if (double *const member = member_of(scene, parameter.kind); member != nullptr)
            *member += change;
    }
}

double change_of(const Scene &scene, const Scene &nominal, Parameter parameter) {
    if (parameter.kind == Kind::scale)
        return nominal.detector.pixel_scale_arcsec / scene.detector.pixel_scale_arcsec - 1;
    return value_of(scene, parameter) - value_of(nominal, parameter);
}

double temperature_of(const Scene &scene, size_t star) noexcept {
    const Spectrum &spectrum = scene.stars[star].spectrum;
    if (spectrum.kind == Spectrum::Kind::blackbody)
        return spectrum.temperature_k;
    return spectrum.star_temperature_k != 0 ? spectrum.star_temperature_k : kTableTemperature[star];
}

bool is_readable(const Scene &scene) noexcept {
    const Detector &detector = scene.detector;
    const Mask &mask = scene.telescope.mask;
    const Jitter &jitter = scene.systematics.jitter;
    const auto within = [](double value, double most) { return std::fabs(value) <= most; };
    bool readable = detector.pixel_scale_arcsec > 0 && within(detector.scale_anisotropy, kMostDistortion) &&
                    within(detector.shear, kMostDistortion) && within(mask.rotation_deg, 360) &&
                    within(mask.shift_m[0], 0.1) && within(mask.shift_m[1], 0.1) && within(jitter.xx, 100) &&
                    within(jitter.yy, 100) && within(jitter.xy, 100) && within(detector.diffusion_px2, 100) &&
                    within(detector.transfer_smear, 0.1) && within(detector.interpixel_capacitance, 0.05) &&
                    within(detector.brighter_fatter_px2_per_e, 1) && within(detector.nonlinearity_per_e, 1);
    for (const ZernikeTerm &term : scene.telescope.zernikes)
        readable &= within(term.rms_m, 1e-3);
    for (size_t star = 0; star < scene.stars.size(); star++) {
        readable &= temperature_of(scene, star) >= kLeastTemperature && temperature_of(scene, star) <= kMostTemperature;
        double sum = 0; // no factor of the spectrum is below 1 minus this
        for (const double mode : scene.stars[star].spectrum.modes)
            sum += std::fabs(mode);
        readable &= sum < kMostModes;
    }
    return readable;
}

// The eigenvalues of the covariance are m +- d; a negative one becomes 0. m - d may be 0 where a variance is below 0 by
// a rounding error.
bool make_possible(Jitter &jitter) noexcept {
    const double m = 0.5 * (jitter.xx + jitter.yy), h = 0.5 * (jitter.xx - jitter.yy), d = std::hypot(h, jitter.xy);
    if (m - d >= 0 && jitter.xx >= 0 && jitter.yy >= 0)
        return false;
    const double large = std::fmax(m + d, 0), half = 0.5 * large, part = d > 0 ? half / d : 0;
    jitter = {std::fmax(half + part * h, 0), std::fmax(half - part * h, 0), part * jitter.xy};
    return true;
}

Jitter blur_of(const Scene &scene) noexcept {
    Jitter blur = scene.systematics.jitter;
    blur.xx += scene.detector.diffusion_px2;
    blur.yy += scene.detector.diffusion_px2;
    if (scene.detector.diffusion_px2 != 0)
        make_possible(blur);
    return blur;
}

} // namespace toliman
