// Where the camera is: the Earth's centre, or a spacecraft on a computed or a circular orbit.
#pragma once
#include <memory>

#include "sky/ephemeris.hpp"

namespace toliman::sky {

// Sun-synchronous circular orbit, for simulations.
struct CircularOrbit {
    double altitude_km = 600;
    double node_hours = 18; // local mean time at the ascending node: 18 or 6 = above the terminator
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

    uint64_t digest(uint64_t hash) const; // continues an FNV-1a hash

    // Relative to the Earth's centre. Status::range as Ephemeris::at.
    State at(int64_t tai_ns) const;

  private:
    Kind kind_ = Kind::earth;
    CircularOrbit orbit_;
    std::shared_ptr<const Ephemeris> ephemeris_;
};

} // namespace toliman::sky
