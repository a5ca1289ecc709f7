#include "sky/system.hpp"

using namespace toliman;

extern "C" void shim_alpha_cen(double date, double *separation_arcsec, double *position_angle_deg) {
    const sky::OrbitPosition position = sky::position_on_orbit(sky::alpha_cen().value.orbit, date);
    *separation_arcsec = position.separation_arcsec();
    *position_angle_deg = position.position_angle_deg();
}
