// Time scales of the sky, from TAI in nanoseconds since 1970-01-01T00:00:00 TAI.
#pragma once
#include <cstdint>

namespace toliman::sky {

constexpr double kSecondsPerDay = 86400;
constexpr int64_t kNsPerSecond = 1000000000, kNsPerDay = 86400 * kNsPerSecond;
constexpr int64_t kTtMinusTaiNs = 32184000000;
constexpr int64_t kJ2000Ns = 946728000 * kNsPerSecond; // 2000-01-01T12:00:00 since 1970-01-01T00:00:00, of any scale

// Days of TT since J2000.0, exact to 1e-12 days.
inline double terrestrial_days(int64_t tai_ns) noexcept {
    const int64_t ns = tai_ns + (kTtMinusTaiNs - kJ2000Ns), day = ns / kNsPerDay;
    return static_cast<double>(day) + static_cast<double>(ns - day * kNsPerDay) / static_cast<double>(kNsPerDay);
}

} // namespace toliman::sky
