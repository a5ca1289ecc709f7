// The error budget of a scene: which unknown parameters limit the separation, and by how much.
#pragma once
#include <cmath>
#include <vector>

#include "optics/simulator.hpp"
#include "scene/parameter.hpp"

namespace toliman::information {

// The displacement due to an Earth, the yardstick of a budget.
struct Earth {
    double px = 0;         // NaN if unknown
    const char *from = ""; // where it comes from; static text
};
// In this order: that of the scene's planet; of an Earth where alpha Centauri A or B receive its irradiance, 1.23 or
// 0.71 au, if the scene has the star's mass and distance; the amplitude of the scene's signal.
Earth earth_of(const Scene &scene);

// Angle along the binary's axis.
double uas_per_px(const Scene &scene) noexcept;

// Standard deviation of the separation, px. Infinite if nothing of the signal is left.
struct BoundOfFrames {
    double one = 0;    // of one frame
    double shared = 0; // of each of K frames that share the instrument's parameters
};
// With these parameters free.
BoundOfFrames bound_of_frames(const optics::Simulator &simulator, const std::vector<Parameter> &free, double frames);

// A named set of free parameters.
struct BudgetStep {
    const char *name;
    std::vector<Parameter> free; // those of which the scene has a derivative
};
std::vector<BudgetStep> budget_steps(const optics::Simulator &simulator);

// The weighted least-squares fit of the separation together with free parameters.
struct BudgetFit {
    Buffer<double> weights;           // their product with a whitened residual is the separation; empty if degenerate
    std::vector<double> deviation;    // of each free parameter; NaN if it depends on those before it
    std::vector<double> correlations; // [free + 1][free + 1] of the separation, then the free parameters; NaN likewise
};
BudgetFit fit_of(const optics::Images &images, const std::vector<Parameter> &free);

struct BudgetRow {
    Parameter parameter;
    bool free = false;
    double bias_px = 0;      // not free: error of the estimated separation per unit; else NaN
    double curvature_px = 0; // free: error per unit^2 that the fit leaves; NaN if not known

    // The amount of the parameter with this effect; infinite without an effect.
    double amount(double effect_px) const noexcept {
        return free ? std::sqrt(effect_px / std::fabs(curvature_px)) : effect_px / std::fabs(bias_px);
    }
};
// The free parameters in the order given, then the others; last `flat`, whose bias is a standard deviation: that of
// independent responses.
std::vector<BudgetRow> budget_rows(const optics::Simulator &simulator, const std::vector<Parameter> &free,
                                   const std::vector<Parameter> &others, const BudgetFit &fit);

// The parameters other than the separation and these of which the scene has a derivative. low_orders: of the Zernike
// polynomials those up to Noll 11, of the spectral modes those up to 2.
std::vector<Parameter> others_than(const optics::Simulator &simulator, const std::vector<Parameter> &free,
                                   bool low_orders);

} // namespace toliman::information
