// Method: the amplitudes are the coordinates, along the axis A -> B and away from the observer, of the vectors a P
// towards periastron and a Q, 90 deg ahead, of the planet's orbit about its star:
//     u = a (P_n, Q_n),    v = a (P_z, Q_z).
// As P and Q have length 1 and are orthogonal, the third coordinates m of a P and a Q follow: with the sums
// s = u_0^2 + v_0^2, t = u_1^2 + v_1^2 and d = u_0 u_1 + v_0 v_1,
//     m_0^2 = a^2 - s,    m_1^2 = a^2 - t,    m_0 m_1 = -d,
// so that a^2 is the larger eigenvalue of the matrix (s d, d t). The signs of m are not known: the mirror image of the
// orbit in the plane of axis and line of sight gives the same data. In the convention of double stars (i below 90 deg:
// position angles increase; at the ascending node the planet recedes) v = a sin i (sin w, cos w), and the node is
// cos w P - sin w Q.
#include "planet/orientation.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

namespace toliman::planet {

Orientation orientation_of(const Series &series, const Planet &planet) noexcept {
    const Amplitudes &c = planet.amplitudes;
    if (!series.has_velocities())
        return {amplitude_of(c), NAN, NAN};
    const double side = planet.orbit.star == 0 ? 1 : -1; // the separation follows the planet of A, and star B
    const size_t away = series.amplitudes() - 2;
    const double u[] = {side * c[0], side * c[1]}, v[] = {side * c[away], side * c[away + 1]};
    const double s = u[0] * u[0] + v[0] * v[0], t = u[1] * u[1] + v[1] * v[1], d = u[0] * u[1] + v[0] * v[1];
    const double axis = std::sqrt((s + t) / 2 + std::hypot((s - t) / 2, d));
    const double receding = std::hypot(v[0], v[1]);
    const double node = receding > 0 ? (v[1] * u[0] - v[0] * u[1]) / (receding * axis) : 0;
    return {axis, std::asin(std::min(receding / axis, 1.0)) * 180 / kPi,
            std::acos(std::clamp(node, -1.0, 1.0)) * 180 / kPi};
}

} // namespace toliman::planet
