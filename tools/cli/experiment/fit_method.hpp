// The fit of a scene's forward model to each frame, as a method of `experiment` and `run`.
#pragma once
#include <vector>

#include "experiment/methods.hpp"

namespace cli {

class FitMethod : public Method {
  public:
    explicit FitMethod(const Scene &scene);

    void push(const double *images, const double *times_days, size_t count) override;
    std::vector<double> series() override; // change of the separation from that of the scene, px
    // Returns the results for all frames since the last call of results() or series(), and forgets them.
    std::vector<toliman_fit_result> results();
    // Standard deviations of the values that noise alone causes in frames at these times: Cramer-Rao bounds with
    // places, fluxes and background free, px.
    std::vector<double> bounds_px(const std::vector<double> &times_days) const;

  private:
    toliman::frame_fit fit_;
    std::vector<toliman_fit_result> results_;
};

} // namespace cli
