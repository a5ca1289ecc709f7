// A binary star: orbit, place, motion and masses, with their errors.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sky/orbit.hpp"

namespace toliman::sky {

// Place and motion of the barycentre.
struct Barycentre {
    double ra_deg, dec_deg, epoch;      // ICRS, at this Julian year
    double pm_ra_mas_yr, pm_dec_mas_yr; // proper motion; that in right ascension times cos(declination)
    double parallax_mas;
    double radial_velocity_km_s; // of the motion: kinematic
};

struct Masses {
    double a_sun, b_sun;
};

// All numbers of a system.
struct Elements {
    Orbit orbit;
    Barycentre barycentre;
    Masses masses;
};

// The measurements to which an orbit was refitted.
struct Refitted {
    double first, last; // dates, Julian years
};

struct System {
    std::string name;
    Elements value;
    Elements sigma; // standard deviations; 0 = not known
    std::optional<Refitted> refit = std::nullopt;
};

// Dates of measurements, at least one.
Refitted dates_of(const std::vector<int64_t> &tai_ns);

// Whether the orbit was refitted to measurements of these dates. It has then absorbed a part of the signals in them,
// and its errors are no priors for them: the data would be used twice.
bool is_refitted_to(const System &system, const Refitted &dates) noexcept;

// Alpha Centauri AB: Akeson et al. 2021, AJ 162, 14.
const System &alpha_cen();

} // namespace toliman::sky
