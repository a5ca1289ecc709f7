// Options of `track` and `rebuild` for the reduction of separations: system, observer and plate scale.
#pragma once
#include <optional>
#include <string>

#include <toliman/toliman.hpp>

#include "common/terminal.hpp"
#include "scenes/observer_options.hpp"

namespace CLI {
class App;
}

namespace cli {

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
