// Cramer-Rao bounds of the separation measured in one frame.
#pragma once
#include <mutex>
#include <optional>

#include "optics/simulator.hpp"

namespace toliman::information {

// Standard deviations in px; infinity where the separation is degenerate with the free nuisances.
struct Bounds {
    double alone = 0;      // all nuisances known
    double flux_shift = 0; // both fluxes and the common shift free
    double marginal = 0;   // all eight nuisances free
    double projected = 0;  // exactly those of the scene's preprocess.project free
};

// The free nuisances of these sets, as far as the scene has the stars.
std::vector<Parameter> fluxes_and_shift(const Scene &scene);
std::vector<Parameter> eight_nuisances(const Scene &scene);

// The bound (px) with these nuisances free; infinity if nothing of the signal is left.
double bound_with(const optics::Images &images, const std::vector<Parameter> &free);

// Mean |gradient|^2 of the stars' light over the square of its mean, px^-2, from the exact derivatives by a shift.
double gradient_energy(const optics::Images &images);

// The bounds of all four sets of free nuisances.
Bounds bound(const Scene &scene, const optics::Images &images);

// The bounds of one simulator, computed by the first call. Calls may run on several threads.
class KnownBounds {
  public:
    const Bounds &of(const optics::Simulator &simulator) const;

  private:
    mutable std::mutex mutex_;
    mutable std::optional<Bounds> bounds_;
};

} // namespace toliman::information
