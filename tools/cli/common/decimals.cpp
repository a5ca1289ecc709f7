#include "common/decimals.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace cli {

int exponent_of(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*e", digits - 1, value);
    return std::atoi(std::strchr(text, 'e') + 1);
}

int decimals_of(double error, int least) {
    constexpr int most = 15;
    return std::isfinite(error) && error > 0 ? std::clamp(1 - exponent_of(error, 2), least, most) : least;
}

} // namespace cli
