// Method: ERFA keeps its table of leap seconds in global variables, which it initialises at the first use without a
// lock. The table is therefore read once, under the lock of a static variable, and never replaced: eraSetLeapSeconds
// would change it for the whole process. Reference: Essential Routines for Fundamental Astronomy,
// https://github.com/liberfa/erfa.
#include "backend/erfa.hpp"

#include <algorithm>
#include <cmath>

#include <erfa.h>
#include <erfaextra.h>

namespace toliman::erfa {

namespace {

constexpr int kFirstYear = 1972; // earlier, TAI - UTC was not a whole number of seconds
constexpr int kLastYear = 2099;
constexpr int kDubious = 6;          // years from the release of a version to the first one that it calls dubious
constexpr double kJ2000 = 2451545.0; // JD

std::vector<LeapSecond> read_rows() {
    eraLEAPSECOND *rows = nullptr;
    const int count = eraGetLeapSeconds(&rows);
    std::vector<LeapSecond> table;
    for (int i = 0; i < count; i++)
        if (const auto day = day_of(rows[i].iyear, rows[i].month, 1); day && rows[i].iyear >= kFirstYear)
            table.push_back({*day, static_cast<int32_t>(rows[i].delat)});
    return table;
}

int first_dubious_year() noexcept {
    int year = kFirstYear;
    for (double seconds = 0; year <= kLastYear && eraDat(year, 1, 1, 0, &seconds) == 0;)
        year++;
    return year;
}

} // namespace

std::optional<int64_t> day_of(int year, int month, int day) noexcept {
    double zero = 0, days = 0;
    if (eraCal2jd(year, month, day, &zero, &days) != 0)
        return std::nullopt;
    return static_cast<int64_t>(days);
}

const LeapSecondTable &leap_seconds() {
    static const int dubious = first_dubious_year();
    static const LeapSecondTable table = {read_rows(), *day_of(dubious, 1, 1), *day_of(dubious - kDubious, 1, 1)};
    return table;
}

EarthState earth_state(double days) noexcept {
    double heliocentric[2][3], barycentric[2][3];
    eraEpv00(kJ2000, days, heliocentric, barycentric);
    EarthState state;
    std::copy_n(heliocentric[0], 3, state.from_sun.begin());
    std::copy_n(barycentric[0], 3, state.from_barycentre.begin());
    std::copy_n(barycentric[1], 3, state.velocity.begin());
    return state;
}

double tdb_minus_tt(double days) noexcept {
    return eraDtdb(kJ2000, days, 0, 0, 0, 0);
}

// The functions of ERFA do not change their arguments, but are not declared so.
Vector deflect_by_sun(const Vector &star, const Vector &from_sun, double distance) noexcept {
    Vector p = star, e = from_sun, bent;
    eraLdsun(p.data(), e.data(), distance, bent.data());
    double length = 0;
    eraPn(bent.data(), &length, bent.data());
    return bent;
}

Vector aberrate(const Vector &star, const Vector &velocity, double distance) noexcept {
    Vector p = star, v = velocity, seen;
    const double squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    eraAb(p.data(), v.data(), distance, std::sqrt(1 - squared), seen.data());
    return seen;
}

double separation(const Vector &a, const Vector &b) noexcept {
    Vector from = a, to = b;
    return eraSepp(from.data(), to.data());
}

double position_angle(const Vector &a, const Vector &b) noexcept {
    Vector from = a, to = b;
    return eraPap(from.data(), to.data());
}

} // namespace toliman::erfa
