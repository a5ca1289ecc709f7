// Allowed interval of a number, with its unit.
#pragma once
#include <limits>

namespace toliman::scene {

// [low, high], or (low, high] if low is excluded.
struct Range {
    double low = 0, high = 0;
    const char *unit = ""; // "" for none
    bool low_excluded = false;
};
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr Range above(double low, double high, const char *unit = "") {
    return {low, high, unit, true};
}
constexpr Range within(double low, double high, const char *unit = "") {
    return {low, high, unit, false};
}

} // namespace toliman::scene
