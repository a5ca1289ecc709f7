#include "optics/systematics.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/poisson.hpp"

namespace toliman::optics {

namespace {

enum Draw { pointing_x, pointing_y, roll, scale, focus, flux_a, flux_b, draws };

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
            {value(systematics.flux, flux_a), value(systematics.flux, flux_b)}};
}

std::array<double, 2> move_of(const Disturbances &disturbances, const std::array<double, 2> &offset, const double *axis,
                              double displacement_px) noexcept {
    const double sine = std::sin(disturbances.roll_rad), half = std::sin(0.5 * disturbances.roll_rad);
    const double less_one = -2 * half * half; // of the cosine
    const double own_x = displacement_px * axis[0], own_y = displacement_px * axis[1];
    const double x = offset[0] + own_x, y = offset[1] + own_y;
    return {disturbances.pointing_px[0] + own_x + less_one * x - sine * y,
            disturbances.pointing_px[1] + own_y + less_one * y + sine * x};
}

void add_places(const std::vector<Derivative> &places, const double *axis, const std::array<double, 2> &move,
                double flux, std::vector<Term> &terms) {
    const double along = move[0] * axis[0] + move[1] * axis[1], across = move[1] * axis[0] - move[0] * axis[1];
    // Those of the highest order first: they are the smallest.
    for (size_t i = places.size(); i-- > 0;)
        terms.push_back({places[i].image.data(), flux * power_over_factorial(along, places[i].along) *
                                                     power_over_factorial(across, places[i].across)});
}

// Over stretches that stay in the cache.
void add_up(const std::vector<Term> &terms, double offset, size_t pixels, double *image) noexcept {
    constexpr size_t stretch = 1024;
    for (size_t first = 0; first < pixels; first += stretch) {
        const size_t count = std::min(stretch, pixels - first);
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
