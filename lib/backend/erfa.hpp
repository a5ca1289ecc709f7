// ERFA: calendar, leap seconds, the Earth's motion, and what bends light. Calendar days are Modified Julian Days.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace toliman::erfa {

// Day of a date of the Gregorian calendar; empty if the date does not exist.
std::optional<int64_t> day_of(int year, int month, int day) noexcept;

struct LeapSecond {
    int64_t day;     // from 0 h UTC of this day on,
    int32_t tai_utc; // TAI - UTC, s
};

struct LeapSecondTable {
    std::vector<LeapSecond> rows; // from 1972 on
    int64_t expires;              // first day of the years that ERFA calls dubious: leap seconds may be missing
    int64_t complete;             // before this day no leap second is missing
};

// The table that is built into ERFA, read at the first call. eraSetLeapSeconds does not change it afterwards.
const LeapSecondTable &leap_seconds();

using Vector = std::array<double, 3>;

constexpr double kAstronomicalUnit = 149597870700.0; // m
constexpr double kLightSpeed = 299792458.0;          // m/s

// The Earth's centre along the axes of the ICRS, au and au per day of TDB.
struct EarthState {
    Vector from_sun, from_barycentre, velocity; // the last relative to the barycentre of the solar system
};
// days: TDB since J2000.0 (JD 2451545.0), of the years 1900 to 2100. Within 13 km and 5 mm/s of DE405.
EarthState earth_state(double days) noexcept;
// TDB - TT at the Earth's centre, s.
double tdb_minus_tt(double days) noexcept;

// Unit vector towards a star after the deflection of its light by the Sun. from_sun: of the observer, unit vector;
// distance: of the observer from the Sun, au.
Vector deflect_by_sun(const Vector &star, const Vector &from_sun, double distance) noexcept;
// Unit vector towards a star as an observer sees it who moves with this velocity, in units of the speed of light.
Vector aberrate(const Vector &star, const Vector &velocity, double distance) noexcept;
// Angle between two directions, and position angle of the second seen from the first, north through east; rad.
double separation(const Vector &a, const Vector &b) noexcept;
double position_angle(const Vector &a, const Vector &b) noexcept;

} // namespace toliman::erfa
