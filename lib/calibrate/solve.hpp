// The step to the maximum of the likelihood, and the covariance there, from the normal equations of all frames.
#pragma once
#include <memory>

#include "calibrate/joint.hpp"

namespace toliman::calibrate {

// The prior's part of the sum of squares.
double prior_cost(const Problem &problem, const Point &point);

struct Step {
    Point change;       // without a map
    double largest = 0; // of a parameter of the instrument, in standard deviations
    bool solvable = false;
};

// The Levenberg-Marquardt step with this damping, 0 = Gauss-Newton. Jitter remains possible: scene/instrument.hpp.
Step step_from(const Problem &problem, const Point &point, const Linearisation &normal, double damping);

// The normal equations with each frame's own parameters eliminated, for many right-hand sides.
class Solver {
  public:
    Solver(const Problem &problem, const Linearisation &normal);
    ~Solver();

    bool solvable() const noexcept;
    // The solution for these gradients of the frames [frame][kOwn + n], and with `point` the gradient of the prior
    // there.
    Point solve(const std::vector<Buffer<double>> &gradients, const Point *point) const;

  private:
    struct Equations;
    const Problem &problem_;
    std::unique_ptr<Equations> equations_;
};

// By how much a whole step lowers the sum of squared residuals over their variances, and of the prior, if the model is
// linear; 0 where the equations have no solution. The blocks may be those of other windows.
double gain_of_step(const Problem &problem, const Point &point, const Linearisation &normal);

// Covariances at a point.
struct Uncertainty {
    Buffer<double> instrument;                          // [windows * n][windows * n]
    std::vector<std::array<double, kOwn * kOwn>> alone; // of each frame's own parameters, the instrument known
    std::vector<std::array<double, kOwn * kOwn>> whole; // with the instrument's uncertainty
    bool solvable = false;
};
Uncertainty uncertainty_of(const Problem &problem, const Linearisation &normal);

} // namespace toliman::calibrate
