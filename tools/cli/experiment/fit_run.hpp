// The fit of the forward model on the frames of a run.
#pragma once

#include "experiment/fit_method.hpp"
#include "experiment/outcome.hpp"

namespace cli {

// Lost frames did not converge; means are over the others.
struct FitOutcome {
    Outcome signal, no_signal;
    double bound_px = NAN; // Cramer-Rao bound with the same parameters free, root mean square over the frames
    // 1 over the root mean square of value over bound in frames without signal; NaN without controls and photon noise.
    double efficiency = NAN;
    double chi_square = NAN, iterations = NAN; // means
    size_t lost = 0;
};

class FitRun {
  public:
    // Throws toliman::error if the scene has no fit.
    explicit FitRun(const Scene &scene) : method_(scene) {}

    // Adds the next frames.
    void push(const double *images, const double *times_days, size_t count) { method_.push(images, times_days, count); }
    // After the frames of the cadence, which have these times.
    void end_frames(const std::vector<double> &times_days);
    // After the frames without signal, of which frame k has time k modulo the length of the cadence.
    void end_controls(bool photon_noise);
    // Whether there are values enough to search them for a period.
    bool has_series() const;
    FitOutcome outcome;

  private:
    FitMethod method_;
    std::vector<double> bounds_px_; // of the frames of the cadence
};

} // namespace cli
