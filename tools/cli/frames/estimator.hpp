// The estimator of a command: a network (--weights), the template of a scene (--template), its fit (--fit), or a bank
// of networks that follow the fit (--fit and --weights).
#pragma once
#include "frames/network.hpp"
#include "frames/scene_fit.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

struct EstimatorOptions {
    void add_to(CLI::App &command);
    void check() const; // of what needs no file
    bool has_scene() const { return !scene.empty() || !fit.empty(); }
    std::string weights, scene, fit, free, bad_pixels;
    bool self_by_default = false; // frees "self" with a calibrated scene, unless there are weights
};

// One of them. It must outlive a tracker that uses it.
struct Estimator {
    Estimator() = default;
    // Reads the files that were given.
    Estimator(const EstimatorOptions &given, Progress &progress);

    std::optional<Network> network;
    toliman::linear_estimator linear;
    toliman::frame_fit fit;
    toliman::network_bank bank;    // fully trained, for the fit, which is also there
    int64_t rows = 0, cols = 0;    // of its images
    std::vector<double> times;     // days, of the frames of a fit's scene
    std::string lacks;             // Scene::lacks_for_real_frames() of a fit's scene, uncalibrated and without a bank
    SceneDefaults scene;           // of the scene of a fit or template
    double cadence_days = 0;       // span of its cadence
    uint32_t bit_depth = 0;        // of its detector, 0: unknown
    int64_t time_zero_ns = 0;      // TAI of time 0 of a scene whose stars move, else 0
    double pixel_scale_arcsec = 0; // of a fit's scene
    bool moves = false;            // the stars of a fit's scene do
    std::string renewal;           // until when the bank can be used and how to train the next; "" if stars do not move

  private:
    void use_scene(const Scene &made); // of a fit or template
    void set_fit(const EstimatorOptions &given, Progress &progress);
};

} // namespace cli
