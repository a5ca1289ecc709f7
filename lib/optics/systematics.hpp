// Systematics of one frame (pointing, roll, scale, focus, flux, background), and the weighted sum of images that models
// them.
#pragma once
#include <array>
#include <vector>

#include "optics/propagate.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

// The systematics of one frame.
struct Disturbances {
    double pointing_px[2], roll_rad, scale, focus_nm, flux[2], background_photons;
};

// Draws those of frame k: each is its rms times a normal variate of (seed, k), plus its drift times `days`.
Disturbances draw(const Systematics &systematics, uint64_t seed, uint64_t k, double days) noexcept;

// Shift [x, y] (px) of a star from `offset`: its own displacement along the axis, then the roll about the frame's
// centre (from x towards y), then the pointing.
std::array<double, 2> shift_of(const Disturbances &disturbances, const std::array<double, 2> &offset,
                               const double *axis, double displacement_px) noexcept;

// A weighted image.
struct Term {
    const double *image;
    double weight;
};

// Appends the terms of order 1 and up of a star's Taylor expansion at `shift`, times its relative flux. The caller adds
// order 0, the star's image. The derivatives are along and across `axis`.
void add_position_terms(const std::vector<Derivative> &derivatives, const double *axis,
                        const std::array<double, 2> &shift, double flux, std::vector<Term> &terms);

// image = max(0, offset + sum of the terms).
void sum_terms(const std::vector<Term> &terms, double offset, size_t pixels, double *image) noexcept;

} // namespace toliman::optics
