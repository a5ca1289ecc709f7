// What may be wrong with the times of measurements and the axes of an observer.
#pragma once
#include <string>
#include <vector>

#include "sky/observer.hpp"

namespace toliman::sky {

constexpr Matrix kSameAxes = {1, 0, 0, 0, 1, 0, 0, 0, 1};

// The truth, as measurements and observer should have been: the times are earlier by late_s, and the states of the
// observer are multiplied by a matrix.
struct Change {
    double late_s = 0;
    Matrix axes = kSameAxes;
};

// Right-handed rotation about an axis, 0 = x.
Matrix rotation(size_t axis, double radians) noexcept;

// Axes that an observer may have instead of those of the ICRS.
struct Axes {
    Matrix matrix; // from them to those of the ICRS
    std::string text;
};

// Exchanged and reversed axes, the ecliptic, and those of date; simple ones first. days: TT since J2000.0, of the date.
std::vector<Axes> wrong_axes(double days);

// "TAI taken for UTC": the mistake by which times are late by this many seconds; "" if there is none. sigma_s: its
// standard deviation. exposure_s: length of the exposures, 0 if they differ.
std::string mistake_of(double late_s, double sigma_s, double exposure_s);

} // namespace toliman::sky
