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

namespace {

bool known(double error) noexcept {
    return std::isfinite(error) && error > 0;
}

} // namespace

int decimals_of(double error, int least) {
    constexpr int most = 15, unknown = 2;
    return known(error) ? std::clamp(1 - exponent_of(error, 2), least, most) : std::max(least, unknown);
}

std::string text_with_error(double value, double error) {
    constexpr int plain = 5, most = 15; // decimal exponents below -plain or above `most` are printed as such
    char text[80];
    if (std::isnan(error) || !std::isfinite(value))
        std::snprintf(text, sizeof text, "%.6g", value);
    else if (!known(error))
        std::snprintf(text, sizeof text, "%.6g +- %.2g", value, error);
    else if (const int first = exponent_of(std::max(std::fabs(value), error), 2); first < -plain || first > most)
        std::snprintf(text, sizeof text, "%.*e +- %.1e",
                      std::clamp(exponent_of(value, 2) - exponent_of(error, 2) + 1, 0, most), value, error);
    else
        std::snprintf(text, sizeof text, "%.*f +- %.*f", decimals_of(error, 0), value, decimals_of(error, 0), error);
    return text;
}

} // namespace cli
