// Parallax and masses of the stars of a binary.
#pragma once
#include <string>

namespace cli {

struct StarData {
    double parallax_arcsec = 0;
    double mass_sun[2] = {}; // of A and B
};                           // 0 = unknown

// system: as that of toliman_sky_create.
StarData stars_of(const std::string &system);

} // namespace cli
