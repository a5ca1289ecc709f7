// Method: the disturbed image of a star is its two-dimensional Taylor expansion in the shift (a along, c across the
// binary's axis),
//     I(a, c) = sum over i + j <= n of a^i/i! c^j/j! d^(i+j) I / da^i dc^j,
// with derivative images propagated once. One weighted sum of images then makes the whole frame, with flux, scale and
// focus. Products of scale or focus with the other disturbances are omitted (estimated by plan.cpp as
// scale_focus_error). The variates are counter-based, keyed by (seed, k): frame k has the same systematics in any
// order of evaluation.
#include "optics/systematics.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/poisson.hpp"

namespace toliman::optics {

namespace {

// Numbers of the variates: append new ones.
enum Draw { pointing_x, pointing_y, roll, scale, focus, flux_a, flux_b, background, draws };

// x^n / n!
double power_over_factorial(double x, size_t n) noexcept {
    double value = 1;
    for (size_t i = 1; i <= n; i++)
        value *= x / static_cast<double>(i);
    return value;
}

} // namespace

Disturbances draw(const Systematics &systematics, uint64_t seed, uint64_t k, double days) noexcept {
    double normals[draws];
    kernels::poisson_kernels().gaussian(draws, 0, {seed, k, kernels::kStreamSystematics}, normals);
    const auto value = [&](const Disturbance &disturbance, Draw which) {
        return disturbance.rms * normals[which] + disturbance.drift_per_day * days;
    };
    return {{value(systematics.pointing_px, pointing_x), value(systematics.pointing_px, pointing_y)},
            value(systematics.roll_rad, roll),
            value(systematics.scale, scale),
            value(systematics.focus_nm, focus),
            {value(systematics.flux, flux_a), value(systematics.flux, flux_b)},
            value(systematics.background_photons, background)};
}

std::array<double, 2> shift_of(const Disturbances &disturbances, const std::array<double, 2> &offset,
                               const double *axis, double displacement_px) noexcept {
    const double sine = std::sin(disturbances.roll_rad), half = std::sin(0.5 * disturbances.roll_rad);
    const double cosine_minus_1 = -2 * half * half; // without cancellation at small rolls
    const double wobble_x = displacement_px * axis[0], wobble_y = displacement_px * axis[1];
    const double x = offset[0] + wobble_x, y = offset[1] + wobble_y;
    return {disturbances.pointing_px[0] + wobble_x + cosine_minus_1 * x - sine * y,
            disturbances.pointing_px[1] + wobble_y + cosine_minus_1 * y + sine * x};
}

void add_position_terms(const std::vector<Derivative> &derivatives, const double *axis,
                        const std::array<double, 2> &shift, double flux, std::vector<Term> &terms) {
    const double along = shift[0] * axis[0] + shift[1] * axis[1], across = shift[1] * axis[0] - shift[0] * axis[1];
    // Highest orders first, so that the smallest terms are summed first.
    for (size_t i = derivatives.size(); i-- > 0;)
        terms.push_back({derivatives[i].image.data(), flux * power_over_factorial(along, derivatives[i].along) *
                                                          power_over_factorial(across, derivatives[i].across)});
}

// Block by block, so that the partial sums stay in the cache.
void sum_terms(const std::vector<Term> &terms, double offset, size_t pixels, double *image) noexcept {
    constexpr size_t block = 1024;
    for (size_t first = 0; first < pixels; first += block) {
        const size_t count = std::min(block, pixels - first);
        double *const sum = image + first;
        std::fill_n(sum, count, 0.0);
        for (const Term &term : terms)
            for (size_t i = 0; i < count; i++)
                sum[i] += term.weight * term.image[first + i];
        for (size_t i = 0; i < count; i++)
            sum[i] = std::max(0.0, offset + sum[i]);
    }
}

} // namespace toliman::optics
