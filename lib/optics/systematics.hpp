// What disturbs the telescope from frame to frame, and the frame that comes of it.
#pragma once
#include <array>
#include <vector>

#include "optics/propagate.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

// Of one frame.
struct Disturbances {
    double pointing_px[2], roll_rad, scale, focus_nm, flux[2];
};

// Those of frame k of a seed at a time: each rms times its own normal variate, and its drift.
Disturbances draw(const Systematics &systematics, uint64_t seed, uint64_t k, double days) noexcept;

// How far [x, y] px a star at offset, displaced along the axis, stands from there: the sky turns about the frame's
// centre, from x towards y, and then shifts.
std::array<double, 2> move_of(const Disturbances &disturbances, const std::array<double, 2> &offset, const double *axis,
                              double displacement_px) noexcept;

// A weighted image.
struct Term {
    const double *image;
    double weight;
};

// Adds the Taylor series of a star of that relative flux at its new place, all but the star's image itself.
void add_places(const std::vector<Derivative> &places, const double *axis, const std::array<double, 2> &move,
                double flux, std::vector<Term> &terms);

// image = offset + sum of the terms, not below 0.
void add_up(const std::vector<Term> &terms, double offset, size_t pixels, double *image) noexcept;

} // namespace toliman::optics
