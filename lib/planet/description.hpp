// The numbers by which people describe an orbit.
#pragma once
#include <array>

#include "planet/joint_fit.hpp"

namespace toliman::planet {

// Period, eccentricity, periastron in deg, epoch about the time reference, amplitude.
constexpr size_t kDescribed = 5;
using Description = std::array<double, kDescribed>;
Description describe(const Planet &planet) noexcept;

// Standard errors of the description of a planet, whose changes are the last ones of the design.
Description errors_of(const Series &series, const Planet &planet, const Design &design, size_t first, size_t all);

// Share of the squared signal that the functions of the design leave.
double power_left(const Series &series, const Design &design, const Planet &planet);

} // namespace toliman::planet
