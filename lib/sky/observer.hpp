// Where the camera is: the Earth's centre, or a spacecraft on a computed or a circular orbit.
#pragma once
#include <array>
#include <memory>
#include <optional>

#include "sky/ephemeris.hpp"

namespace toliman::sky {

// Sun-synchronous circular orbit, for simulations.
struct CircularOrbit {
    double altitude_km = 600;
    double node_hours = 18; // local mean time at the ascending node: 18 or 6 = above the terminator
};

// Rows of a matrix [3][3].
using Matrix = std::array<double, 9>;

constexpr double kEarthGm = 3.986004418e14, kEarthRadius = 6378137; // m^3/s^2, m

// An osculating orbit about the Earth.
struct OrbitShape {
    double inclination_deg, node_deg; // to the equator; right ascension of the ascending node, 0 to 360
    double node_hours;                // local mean time there, 0 to 24
    double period_minutes;            // NaN if it does not return
    double altitude_km[2];            // least and largest, of the states
};

class Observer {
  public:
    enum class Kind { earth, circular, ephemeris };

    Observer() = default; // the Earth's centre
    explicit Observer(const CircularOrbit &orbit) : kind_(Kind::circular), orbit_(orbit) {}
    explicit Observer(std::shared_ptr<const Ephemeris> ephemeris)
        : kind_(Kind::ephemeris), ephemeris_(std::move(ephemeris)) {}

    Kind kind() const noexcept { return kind_; }
    const Ephemeris *ephemeris() const noexcept { return ephemeris_.get(); }
    const CircularOrbit &orbit() const noexcept { return orbit_; }

    // Continues an FNV-1a hash. with_states: of a file.
    uint64_t digest(uint64_t hash, bool with_states) const;

    // The same observer, all positions and velocities multiplied by a matrix.
    Observer turned(const Matrix &matrix) const;
    // Whether there is a state for a time, as far as the usable times of the segments tell.
    bool covers(int64_t tai_ns) const noexcept;

    // The orbit of the first state; zeros at the Earth's centre. The node of a circular orbit, 0, follows the Sun.
    OrbitShape shape() const;

    // Relative to the Earth's centre. Status::range as Ephemeris::at.
    State at(int64_t tai_ns) const;

  private:
    State untouched(int64_t tai_ns) const; // before turning

    Kind kind_ = Kind::earth;
    CircularOrbit orbit_;
    std::shared_ptr<const Ephemeris> ephemeris_;
    std::optional<Matrix> turn_;
};

} // namespace toliman::sky
