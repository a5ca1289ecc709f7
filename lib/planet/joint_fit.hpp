// Least squares of all planets and nuisance functions together.
#pragma once
#include <vector>

#include "planet/design.hpp"
#include "planet/signal.hpp"

namespace toliman::planet {

struct FittedPlanet {
    Planet planet;
    double scale; // standard deviation of the prior of the amplitudes
};

// Numbers of an orbit that are fitted: f, k, h.
constexpr size_t kOrbitNumbers = 3;

// Derivatives of the signal by the amplitudes, f, k and h, as functions of a fit of changes of the planet.
std::vector<Function> derivatives_of(const Series &series, const FittedPlanet &planet);

// The planet after changes of the amplitudes, f, k and h, in the order of the derivatives.
Planet changed(const Series &series, const Planet &planet, const double *changes);

// Improves the planets by Gauss-Newton steps until the sum of squares no longer falls, and returns it, with the priors.
double fit_jointly(const Series &series, double jitter, double eccentricity_max, std::vector<FittedPlanet> &planets);

// Values of the series without the signals of the planets, but that of planet `kept`, if there is one.
Buffer<double> without_planets(const Series &series, const std::vector<FittedPlanet> &planets, size_t kept);

// Functions of the series, and derivatives of the planets but `kept`.
class JointFunctions {
  public:
    JointFunctions(const Series &series, const std::vector<FittedPlanet> &planets, size_t kept);
    const std::vector<const Function *> &all() const noexcept { return all_; }

  private:
    std::vector<std::vector<Function>> derivatives_;
    std::vector<const Function *> all_;
};

} // namespace toliman::planet
