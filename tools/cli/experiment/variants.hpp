// Variants of a scene, each with one difference, for the tables of `experiment`.
#pragma once
#include <string>
#include <vector>

#include "common/json.hpp"
#include "scenes/scene.hpp"

namespace cli {

// Pointing jitter of 1e-3 px and flux jitter of 1e-4, rms per frame.
constexpr char kJitter[] = R"({"systematics": {"pointing_rms_px": 0.001, "flux_rms": 0.0001}})";
// Fluxes and shifts projected out of the estimators.
constexpr char kProjected[] = R"({"preprocess": {"project": ["flux_a", "flux_b", "shift_x", "shift_y"]}})";

class SceneVariants {
  public:
    // Throws Failure unless the scene has two stars.
    explicit SceneVariants(const Scene &scene);

    // Both stars equally bright: the mean of their photons if the scene gives photons, otherwise relative fluxes of 1.
    std::string equal_stars() const;
    std::string defocused(double waves_rms) const; // of the middle wavelength
    // Stars at other positions: the star without signal moved away by separation_px, both stars shifted along a row by
    // shift_px, and pixels larger on the sky by `scale`.
    std::string moved(double separation_px, double shift_px, double scale) const;

    // With merge patches, such as those above.
    std::string with(const std::vector<std::string> &patches) const;

  private:
    JsonTree json_;
    double wavelength_nm_; // the middle one
    double pixel_scale_arcsec_;
    toliman_sim_offsets offsets_ = toliman::sized<toliman_sim_offsets>();
};

} // namespace cli
