// Separation of a binary as an observer sees it.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "sky/earth.hpp"
#include "sky/observer.hpp"
#include "sky/system.hpp"

namespace toliman::sky {

// Effects that a prediction may leave out.
enum Effect : uint32_t {
    kEarthAberration = 1,      // the Earth's velocity
    kSpacecraftAberration = 2, // the observer's velocity relative to the Earth
    kParallax = 4,             // the observer's place in the solar system
    kRoemer = 8,               // light time from there to the barycentre of the solar system
    kLightTime = 16,           // each star at the time at which its light left it
    kRadialMotion = 32,        // of the barycentre of the system
    kTransverseMotion = 64,
    kDeflection = 128, // of light by the Sun
    kEveryEffect = 255,
};

struct Prediction {
    double separation_arcsec, position_angle_deg; // apparent; of B from A, ICRS
    double geometric_arcsec, geometric_angle_deg; // on the orbit, at the barycentric time
    double factor;                                // apparent separation over geometric separation
    double barycentric_offset_s; // TDB at which the light passes the barycentre of the solar system, minus TAI
    double approach_m_s;         // velocity of the observer towards the system
    double sun_angle_deg;        // between the system and the Sun
    double partials[kElements];  // of the apparent separation, over factor; arcsec per unit of the element
};

// On-target intervals of an exposure, TAI.
struct Interval {
    int64_t start_ns, end_ns;
    bool operator==(const Interval &other) const noexcept {
        return start_ns == other.start_ns && end_ns == other.end_ns;
    }
};

// Any number of threads may use one object.
class Predictor {
  public:
    // without: effects to leave out.
    Predictor(const System &system, Observer observer, uint32_t without = 0);
    // Another system, for the observer and the effects of `other`.
    Predictor(const System &system, const Predictor &other);
    // Another observer, for the system and the effects of `other`.
    Predictor(const Predictor &other, Observer observer);

    // Status::range outside 1900 to 2100, and as Ephemeris::at.
    Prediction at(int64_t tai_ns) const;
    // Mean over the intervals, weighted with their lengths; factor: ratio of the means.
    Prediction mean(const std::vector<Interval> &intervals) const;

    const System &system() const noexcept { return system_; }
    const Observer &observer() const noexcept { return observer_; }
    uint32_t without() const noexcept { return without_; }
    const Earth &earth() const noexcept { return *earth_; }
    // FNV-1a hash of all numbers on which predictions depend.
    uint64_t digest(bool with_states = true) const;

  private:
    struct Axes {
        erfa::Vector away, east, north; // at the catalogue's place of the barycentre
    };

    void prepare() noexcept;
    bool has(Effect effect) const noexcept { return (without_ & effect) == 0; }
    erfa::Vector barycentre(double year) const noexcept;
    erfa::Vector star(size_t which, double year) const noexcept;
    erfa::Vector seen_star(size_t which, double year, const erfa::Vector &from) const noexcept;
    erfa::Vector turn(const erfa::Vector &a, const erfa::Vector &b, double angle) const noexcept;

    System system_;
    Observer observer_;
    uint32_t without_;
    Axes axes_;
    double distance_;     // of the barycentre at the epoch, au
    erfa::Vector motion_; // of the barycentre, au per Julian year
    std::shared_ptr<const Earth> earth_;
};

// Warns that predictions are for the Earth's centre.
void warn_of_centre(const Predictor &predictor, const Log &log);

} // namespace toliman::sky
