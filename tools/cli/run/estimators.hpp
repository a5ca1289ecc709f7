// The estimators of a run on its frames: for stars at rest the network, the template and the untrained network; for
// moving stars the fit of the forward model and, where there can be one, a bank of networks.
#pragma once
#include "common/interface.hpp"
#include "run/pipeline.hpp"

namespace cli {

// Adds outcomes and times to the results of the run.
class Estimators : public Interface {
  public:
    virtual void train() = 0;
    // Adds the next frames of the cadence, the first of which is frame `at`.
    virtual void push(size_t at, const double *images, size_t count) = 0;
    virtual void end_frames() {}
    // The same for frames without signal: frame k has time k modulo the length of the cadence.
    virtual void push_control(size_t at, const double *images, size_t count) = 0;
    virtual void end_controls() = 0;
    // Throws Failure if there are not values enough to search them for a period.
    virtual void require_series() const {}
};

// Those that scene and result.options need. All arguments must outlive them.
std::unique_ptr<Estimators> make_estimators(const Scene &scene, const Cadence &cadence, Pipeline &result,
                                            Progress &progress);

} // namespace cli
