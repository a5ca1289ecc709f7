// The fit of a scene's forward model to each frame, alone or with a bank of networks, as methods of `experiment` and
// `run`.
#pragma once
#include <vector>

#include "common/terminal.hpp"
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

  protected:
    toliman::frame_fit fit_;
    std::vector<toliman_fit_result> results_;
};

// The networks of a bank, with the fit of each frame.
class BankMethod : public FitMethod {
  public:
    // For the dates of the scene's frames, untrained; seed: of the initial weights.
    BankMethod(const Scene &scene, uint64_t seed);
    void train(toliman_progress_fn progress, void *progress_data);

    void push(const double *images, const double *times_days, size_t count) override;
    std::vector<double> series() override; // latents
    // As results(), of the networks.
    std::vector<toliman_bank_result> estimates();
    const toliman_bank *bank() const noexcept { return bank_.get(); }

  private:
    toliman::network_bank bank_;
    std::vector<toliman_bank_result> estimates_;
};

template <class Result> std::vector<double> displacements(const std::vector<Result> &results) {
    std::vector<double> values;
    values.reserve(results.size());
    for (const Result &result : results)
        values.push_back(result.displacement_px);
    return values;
}

} // namespace cli
