// Scenes that differ from a given one in one thing: what `experiment` tries the methods on.
#pragma once
#include <string>

#include "common/json.hpp"
#include "scenes/scene.hpp"

namespace cli {

class SceneVariants {
  public:
    // A scene of two stars; a Failure for any other.
    explicit SceneVariants(const Scene &scene);

    // Both stars as bright: the mean of their photons where the scene gives these, else relative fluxes of 1.
    std::string equal_stars() const;
    // Common pointing of 1e-3 px and fluxes of 1e-4, rms a frame; and with estimators blind to fluxes and shifts.
    std::string disturbed(bool projected) const;
    std::string projected() const;
    std::string defocused(double waves_rms) const; // of the middle wavelength
    // Stars elsewhere: the one without signal farther off, both shifted along the rows, pixels that see more of the
    // sky.
    std::string moved(double separation_px, double shift_px, double scale) const;

  private:
    JsonTree json_;
    double wavelength_nm_; // the middle one
    toliman_sim_offsets offsets_ = toliman::sized<toliman_sim_offsets>();
};

} // namespace cli
