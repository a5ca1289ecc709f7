#include <cstring>

#include "optics/light.hpp"
#include "sky/system.hpp"

using namespace toliman;
using namespace toliman::optics;

extern "C" {

void shim_alpha_cen(double date, double *separation_arcsec, double *position_angle_deg) {
    const sky::OrbitPosition position = sky::position_on_orbit(sky::alpha_cen().value.orbit, date);
    *separation_arcsec = position.separation_arcsec();
    *position_angle_deg = position.position_angle_deg();
}

// {Ax, Ay, Bx, By} of a scene, `days` after its time 0.
void shim_offsets(const char *json, double days, double *offsets_px) {
    const Scene scene = read_scene(json, "scene", ".");
    const Offsets offsets = orbit_offsets_at(scene, make_light(scene), days);
    std::memcpy(offsets_px, offsets.data(), sizeof offsets);
}
}
