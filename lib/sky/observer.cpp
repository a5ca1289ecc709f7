// Method: a sun-synchronous circular orbit of radius a has the mean motion n = sqrt(GM/a^3), and the inclination i at
// which the Earth's flattening turns its plane once per year,
//     cos i = -rate 2 a^2/(3 J2 R^2 n).
// The node is at the mean Sun's right ascension plus (node_hours - 12)/24 of a turn. Reference: Vallado, Fundamentals
// of Astrodynamics and Applications, ch. 11.
#include "sky/observer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/constants.hpp"
#include "base/hash.hpp"
#include "sky/time.hpp"

namespace toliman::sky {

namespace {

constexpr double kFlattening = 1.0826e-3;  // J2
constexpr double kTropicalYear = 365.2422; // days
constexpr double kMeanSun = 280.46;        // deg, at J2000.0

// Right ascension of the mean Sun, turns.
double mean_sun(double days) noexcept {
    return days / kTropicalYear + kMeanSun / 360;
}

State on_circle(const CircularOrbit &orbit, int64_t tai_ns) noexcept {
    const double days = terrestrial_days(tai_ns), radius = kEarthRadius + orbit.altitude_km * 1e3;
    const double motion = std::sqrt(kEarthGm / radius) / radius, rate = 2 * kPi / (kTropicalYear * kSecondsPerDay);
    const double flat = -rate * 2 * radius * radius / (3 * kFlattening * kEarthRadius * kEarthRadius * motion);
    const double lift = std::sqrt((1 - flat) * (1 + flat));
    const double turns = mean_sun(days) + (orbit.node_hours - 12) / 24;
    const double node = 2 * kPi * (turns - std::floor(turns));
    const double revolutions = days * kSecondsPerDay * motion / (2 * kPi);
    const double angle = 2 * kPi * (revolutions - std::floor(revolutions));
    const auto turned = [&](double along, double across, double out[3]) {
        out[0] = along * std::cos(node) - across * flat * std::sin(node);
        out[1] = along * std::sin(node) + across * flat * std::cos(node);
        out[2] = across * lift;
    };
    State state;
    turned(radius * std::cos(angle), radius * std::sin(angle), state.position_m);
    turned(-radius * motion * std::sin(angle), radius * motion * std::cos(angle), state.velocity_m_s);
    state.velocity_m_s[0] -= rate * state.position_m[1]; // the plane turns
    state.velocity_m_s[1] += rate * state.position_m[0];
    return state;
}

void turn(const Matrix &matrix, double vector[3]) noexcept {
    const double old[3] = {vector[0], vector[1], vector[2]};
    for (size_t i = 0; i < 3; i++)
        vector[i] = matrix[3 * i] * old[0] + matrix[3 * i + 1] * old[1] + matrix[3 * i + 2] * old[2];
}

OrbitShape shape_of(const State &state, int64_t tai_ns) noexcept {
    const double *const r = state.position_m, *const v = state.velocity_m_s;
    const double normal[3] = {r[1] * v[2] - r[2] * v[1], r[2] * v[0] - r[0] * v[2], r[0] * v[1] - r[1] * v[0]};
    const double distance = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    const double axis = 1 / (2 / distance - (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / kEarthGm);
    const auto within = [](double turns, double whole) { return whole * (turns - std::floor(turns)); };
    const double node = std::atan2(normal[0], -normal[1]) / (2 * kPi); // turns
    OrbitShape out = {};
    out.inclination_deg = std::atan2(std::hypot(normal[0], normal[1]), normal[2]) / kDegree;
    out.node_deg = within(node, 360);
    out.node_hours = within(node - mean_sun(terrestrial_days(tai_ns)) + 0.5, 24);
    out.period_minutes = 2 * kPi * axis * std::sqrt(axis / kEarthGm) / 60;
    return out;
}

} // namespace

OrbitShape Observer::shape() const {
    if (kind_ == Kind::earth)
        return {};
    if (kind_ == Kind::circular) {
        OrbitShape shape = shape_of(at(0), 0);
        shape.node_deg = 0;
        shape.altitude_km[0] = shape.altitude_km[1] = orbit_.altitude_km;
        return shape;
    }
    const Segment &first = ephemeris_->segments().front();
    OrbitShape shape = shape_of(first.states.front(), first.tai_ns.front());
    double least = HUGE_VAL, most = 0;
    for (const Segment &segment : ephemeris_->segments())
        for (const State &state : segment.states) {
            const double *const r = state.position_m;
            const double distance = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
            least = std::min(least, distance);
            most = std::max(most, distance);
        }
    shape.altitude_km[0] = (least - kEarthRadius) / 1000;
    shape.altitude_km[1] = (most - kEarthRadius) / 1000;
    return shape;
}

Observer Observer::turned(const Matrix &matrix) const {
    Observer other = *this;
    other.turn_ = matrix;
    return other;
}

bool Observer::covers(int64_t tai_ns) const noexcept {
    return kind_ != Kind::ephemeris || ephemeris_->covers(tai_ns);
}

uint64_t Observer::digest(uint64_t hash, bool with_states) const {
    hash = fnv1a(static_cast<uint64_t>(kind_), hash);
    if (turn_)
        hash = fnv1a(*turn_, hash);
    if (kind_ == Kind::circular)
        hash = fnv1a(std::array<double, 2>{orbit_.altitude_km, orbit_.node_hours}, hash);
    if (kind_ != Kind::ephemeris || !with_states)
        return hash;
    for (const Segment &segment : ephemeris_->segments()) {
        hash = fnv1a(std::array<int64_t, 2>{segment.first_ns, segment.last_ns}, hash);
        hash = fnv1a(segment.tai_ns, hash);
        hash = fnv1a(segment.states, hash);
    }
    return hash;
}

State Observer::at(int64_t tai_ns) const {
    State state = untouched(tai_ns);
    if (turn_) {
        turn(*turn_, state.position_m);
        turn(*turn_, state.velocity_m_s);
    }
    return state;
}

State Observer::untouched(int64_t tai_ns) const {
    switch (kind_) {
    case Kind::earth:
        return {};
    case Kind::circular:
        return on_circle(orbit_, tai_ns);
    case Kind::ephemeris:
        break;
    }
    return ephemeris_->at(tai_ns);
}

} // namespace toliman::sky
