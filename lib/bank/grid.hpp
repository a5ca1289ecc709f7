// Dates and sub-pixel places for which the networks of a bank are made.
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace toliman::bank {

struct Date {
    double days, first, last; // the date of the networks; those for which they are the nearest
};

// Place of B minus that of A at a time in days, px.
using Difference = std::function<std::array<double, 2>(double days)>;

// Dates between which the difference changes by at most spacing_px, so that it is within spacing_px/2 of that of a date
// at all times from first to last. A single one if it does not change.
std::vector<Date> dates_of(double first, double last, double spacing_px, const Difference &difference);

// Shift of the scene's centre along one axis at place i of `places`: in [-0.5, 0.5) px.
constexpr double shift_of(size_t i, size_t places) noexcept {
    return (static_cast<double>(i) + 0.5) / static_cast<double>(places) - 0.5;
}

} // namespace toliman::bank
