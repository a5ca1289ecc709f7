// A binary star: orbit, place, motion and masses, with their errors.
#pragma once
#include <string>

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

struct System {
    std::string name;
    Elements value;
    Elements sigma; // standard deviations; 0 = not known
};

// Alpha Centauri AB: Akeson et al. 2021, AJ 162, 14.
const System &alpha_cen();

} // namespace toliman::sky
