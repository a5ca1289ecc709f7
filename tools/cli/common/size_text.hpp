// Formats sizes in bytes.
#pragma once
#include <cstdio>
#include <string>

namespace cli {

// In B, kB, MB, GB or TB (powers of 1000) with three digits: "524 kB", "10.5 TB".
inline std::string size_text(double bytes) {
    const char *const units[] = {"B", "kB", "MB", "GB", "TB"};
    size_t unit = 0;
    for (; unit < 4 && bytes >= 999.5; unit++)
        bytes /= 1000;
    const int decimals = unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2;
    char text[64];
    std::snprintf(text, sizeof text, "%.*f %s", decimals, bytes, units[unit]);
    return text;
}

} // namespace cli
