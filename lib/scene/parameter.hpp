// The parameters of the forward model that an estimator may not know: names, units and scopes. Each has a derivative
// image (optics/derivatives.hpp) and can be projected out (preprocess.project).
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace toliman {

// What a unit change of each does to a frame: include/toliman/sim_derivative.h.
struct Parameter {
    enum class Kind {
        separation,
        position_angle,
        shift_x,
        shift_y,
        roll,
        flux_a,
        flux_b,
        background,
        scale,
        anisotropy,
        shear,
        focus,
        zernike,
        mask_rotation,
        mask_shift_x,
        mask_shift_y,
        jitter_xx,
        jitter_yy,
        jitter_xy,
        temperature_a,
        temperature_b,
        spectrum_a,
        spectrum_b,
        wavelength,
        diffusion,
        transfer_smear,
        brighter_fatter,
        interpixel_capacitance,
        nonlinearity,
        flat,
        smear,
    };
    Kind kind = Kind::separation;
    int number = 0; // of a Zernike polynomial or spectral mode, else 0

    bool operator==(const Parameter &other) const noexcept { return kind == other.kind && number == other.number; }
    bool operator<(const Parameter &other) const noexcept {
        return kind != other.kind ? kind < other.kind : number < other.number;
    }
};

constexpr int kFirstZernike = 5, kLastZernike = 36, kSpectralModes = 11;

// A quantity of one frame varies from frame to frame; one of the instrument is the same in all.
enum class Scope { frame, instrument };

std::string name_of(Parameter parameter);
const char *unit_of(Parameter parameter) noexcept;
Scope scope_of(Parameter parameter) noexcept;

// The names that preprocess.project takes: all but the separation, and flat, which has an image for each pixel.
constexpr const char kProjectable[] =
    "flux_a flux_b shift_x shift_y roll scale focus background position_angle anisotropy shear zernike_5 "
    "zernike_6 zernike_7 zernike_8 zernike_9 zernike_10 zernike_11 zernike_12 zernike_13 zernike_14 "
    "zernike_15 zernike_16 zernike_17 zernike_18 zernike_19 zernike_20 zernike_21 zernike_22 zernike_23 "
    "zernike_24 zernike_25 zernike_26 zernike_27 zernike_28 zernike_29 zernike_30 zernike_31 zernike_32 "
    "zernike_33 zernike_34 zernike_35 zernike_36 mask_rotation mask_shift_x mask_shift_y jitter_xx "
    "jitter_yy jitter_xy temperature_a temperature_b spectrum_a_1 spectrum_a_2 spectrum_a_3 spectrum_a_4 "
    "spectrum_a_5 spectrum_a_6 spectrum_a_7 spectrum_a_8 spectrum_a_9 spectrum_a_10 spectrum_a_11 "
    "spectrum_b_1 spectrum_b_2 spectrum_b_3 spectrum_b_4 spectrum_b_5 spectrum_b_6 spectrum_b_7 "
    "spectrum_b_8 spectrum_b_9 spectrum_b_10 spectrum_b_11 wavelength diffusion transfer_smear "
    "brighter_fatter interpixel_capacitance nonlinearity smear";

// Their number; all of them, in a fixed order; and the one with this name.
size_t parameter_count() noexcept;
const std::vector<Parameter> &all_parameters();
std::optional<Parameter> parameter_named(const std::string &name);

} // namespace toliman
