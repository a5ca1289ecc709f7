// The estimators that follow moving stars, on the frames of a run: the fit of the forward model and, where there can be
// one, a bank of networks.
#pragma once
#include "run/outcome.hpp"
#include "scenes/scene.hpp"

namespace cli {

// An estimator of moving stars. Lost frames did not converge.
struct FollowOutcome {
    Outcome signal, no_signal;
    // 1 over the root mean square of value over bound in frames without signal; NaN without controls and photon noise.
    double efficiency = NAN;
};

struct FitOutcome : FollowOutcome {
    double bound_px = NAN; // Cramer-Rao bound with the same parameters free, root mean square over the frames
    double chi_square = NAN, iterations = NAN; // means over the frames that converged
    size_t lost = 0;
};

struct BankOutcome : FollowOutcome {
    toliman_bank_info info = {};
    std::vector<double> efficiencies;                     // of the frames, as computed from their states; NaN: lost
    double least_efficiency = NAN, mean_efficiency = NAN; // of these
    double least_cosine = NAN;                            // of the networks' gradients and the ideal ones
    std::vector<unsigned char> weights;                   // file of the bank
};

class FitRun {
  public:
    // Throws toliman::error if the scene has no fit. The bank is made with initial weights of this seed.
    FitRun(const Scene &scene, uint64_t seed);

    bool has_bank() const noexcept { return static_cast<bool>(bank_); }
    // Trains the bank; does nothing without one.
    void train(Progress &progress);
    // Adds the next frames.
    void push(const double *images, const double *times_days, size_t count);
    // After the frames of the cadence, which have these times.
    void end_frames(const std::vector<double> &times_days);
    // After the frames without signal, of which frame k has time k modulo the length of the cadence.
    void end_controls(bool photon_noise);
    // Whether there are values enough to search them for a period.
    bool has_series() const;
    FitOutcome outcome;
    BankOutcome bank_outcome;

  private:
    void end_frames(const std::vector<toliman_bank_result> &estimates);
    void end_controls(std::vector<double> values, bool photon_noise, FollowOutcome &of) const;

    std::vector<double> bounds_px(const std::vector<double> &times_days) const;

    toliman::frame_fit fit_;
    toliman::network_bank bank_; // null if there can be none
    std::vector<toliman_fit_result> results_;
    std::vector<toliman_bank_result> estimates_;
    std::vector<double> bounds_px_; // of the frames of the cadence
};

} // namespace cli
