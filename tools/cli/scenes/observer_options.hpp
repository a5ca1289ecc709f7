// Options of the observer of a system: --observer, --altitude, --node and --leap-seconds.
#pragma once
#include "common/common.hpp"
#include "scenes/scene_defaults.hpp"

namespace CLI {
class App;
}

namespace cli {

// The exposures that can be reduced without on-target intervals, for messages.
inline constexpr char kOrbitExposure[] = "must be in (0, 600] s for an observer in orbit";

// The value of --plate-scale, arcsec per px, or `otherwise` if it is not given. Throws Failure for a bad one.
double plate_scale_of(const std::optional<double> &given, double otherwise);

class ObserverOptions {
  public:
    enum class Times { own, given_elsewhere };
    // times: whether the command has an option --leap-seconds of its own, which set_leap_seconds() passes on.
    void add_to(CLI::App &command, Times times = Times::own);
    void add_file_to(CLI::App &command); // --observer and --leap-seconds only
    void set_leap_seconds(const std::string &path) { leap_seconds_ = path; }
    // Where no observer is given, that of the scene becomes the observer; one that differs from it is reported.
    void use_scene(const SceneDefaults &scene, Notes &notes);
    // False for the Earth's centre.
    bool given() const noexcept { return altitude_ || file_; }
    bool is_file() const noexcept { return file_.has_value(); }
    std::string options() const; // " --observer spacecraft.oem", as given
    // The path of --leap-seconds; empty: the table of the library.
    const std::string &leap_seconds() const noexcept { return leap_seconds_; }
    // Throws Failure for bad options, as predictor() does.
    void check() const;
    // system: "alpha-cen", the path of a system file, or its JSON. without: effects to leave out, TOLIMAN_SKY_...
    toliman::sky_predictor predictor(const std::string &system, uint32_t without, Progress &progress) const;
    // "spacecraft.oem has states from 2027-01-01T00:00:00 to 2027-12-31T00:00:00 TAI"; any other observer "is known at
    // all times".
    std::string coverage(const toliman_sky *sky) const;
    // "spacecraft.oem: altitude 596 to 604 km, inclination 97.8 deg, ascending node at 18.0 h local time, 2029-01-01 to
    // 2029-03-01, 1.5 states per minute"; "" without a file.
    std::string orbit(const toliman_sky *sky) const;
    // Adds the member observer_orbit: null without a file.
    void set_orbit(Json &json, const toliman_sky *sky) const;
    // "spacecraft.oem", "circular orbit, altitude 600 km, node at 18 h", "centre of the Earth".
    std::string text() const;
    // Adds the members observer, observer_file, altitude_km and node_hours.
    void set(Json &json) const;

  private:
    std::string name() const; // of the kind of observer
    double node_hours() const;

    std::optional<std::string> file_;
    std::string leap_seconds_;
    std::optional<double> altitude_, node_;
};

} // namespace cli
