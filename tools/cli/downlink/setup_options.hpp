// Options of `track`, `rebuild` and `merge` for a state folder: grid, trend, clock, time stamps; of the first two also
// for the reduction of separations.
#pragma once
#include "common/common.hpp"
#include "scenes/observer_options.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

// Sets the order of the trend, 0 for the mean alone.
void set_trend(toliman_track_options &how, int32_t order);

// Options for grid, trend, clock and time stamps.
class SetupOptions {
  public:
    void add_to(CLI::App &command);
    // The path of a leap-seconds.list for --epoch; empty: the table of the library.
    void set_leap_seconds(const std::string &path) { leap_seconds_ = path; }
    bool has_grid() const { return !grid_.empty() || mission_days_; }
    void use_days(double days) { mission_days_ = days; } // without a grid
    bool has_clock() const { return !clock_.empty(); }
    bool has_timing() const { return !stamp_.empty() || exposure_s_; }
    bool has_trend() const { return trend_.has_value(); }
    // All that a folder must be given if its setup is lost: nothing is guessed, as frames that arrive again with other
    // times are quarantined.
    bool is_complete() const { return has_grid() && has_clock() && !stamp_.empty(); }
    // Sets what was given. The pairs of the clock remain in this object. Warnings about the clock go to `progress`.
    void set(toliman_track_options &how, Progress &progress);
    // Reports an epoch and an exposure that differ from those of the scene, 0 for none.
    void compare(const SceneDefaults &scene, int64_t time_zero_ns, const toliman_track_options &how,
                 Notes &notes) const;
    bool has_exposure() const { return exposure_s_.has_value(); }
    // Throws Failure if the options are not complete, for a folder whose setup is lost.
    void check_complete(const std::string &folder) const;
    // Grid, epoch and clock as they were given: " --grid 1e-3:1e-5:5000 --clock clock.csv".
    std::string text() const;

  private:
    std::string grid_, clock_, stamp_, chi_limit_, leap_seconds_;
    std::optional<std::string> epoch_;
    std::optional<double> mission_days_, exposure_s_;
    std::optional<int32_t> trend_;
    std::vector<int64_t> pairs_;
};

// Options of `track` and `rebuild` for the reduction of separations: system, observer and plate scale.
class ReferenceOptions {
  public:
    void add_to(CLI::App &command);
    void check() const; // of what needs no file
    bool given() const { return !system_.empty() || observer_.given() || plate_scale_ || scale_sigma_; }
    bool has_system() const { return !system_.empty(); }
    // Takes what is not given from the scene: the observer, and for a new folder the system of an observer that is
    // known.
    void use_scene(const SceneDefaults &scene, const std::optional<toliman_track_options> &made, Notes &notes);
    // Opens the system for the observer, and sets both and the plate scale. made: the settings of the folder if it
    // exists; a folder with a system provides it. The predictor remains in this object.
    void set(toliman_track_options &how, const std::optional<toliman_track_options> &made, Progress &progress);
    // " --system alpha-cen --observer spacecraft.oem", as given.
    std::string text() const;
    // The orbit in the observer file, in words; "" without a file.
    std::string orbit() const;
    // "spacecraft.oem has states from ... to ... TAI"; "" without a file.
    std::string coverage() const;
    void set_leap_seconds(const std::string &path) { observer_.set_leap_seconds(path); }

  private:
    std::string system_;
    bool has_observer_ = false; // of the scene
    ObserverOptions observer_;
    std::optional<double> plate_scale_, scale_sigma_;
    toliman::sky_predictor sky_;
};

} // namespace cli
