// Residuals of measured separations about the orbit, and what the errors of the orbit leave of them.
#pragma once
#include <vector>

#include "sky/alternatives.hpp"
#include "sky/refit.hpp"

namespace toliman::sky {

// All numbers are in standard deviations of the measurements.
class Residuals {
  public:
    using Values = std::vector<double>; // one per measurement; NaN if the observer has no state for it

    // Functions that are fitted freely, in addition to the errors of the orbit: none, a mean, or all slow ones: a mean,
    // two harmonics of a year and a polynomial of order 4. Shifts of time by whole revolutions of the spacecraft change
    // the separation with a period of a year, as planets do, and shifts of the orbit change it slowly, as a wrong orbit
    // does: they must not be told by that.
    enum class Free : size_t { none = 0, mean = 1, slow = 9 };

    // Uses at most `most` measurements, evenly spread, and leaves out those for which the observer has no state.
    // scale_sigma: relative standard deviation of the plate scale. Errors as refit().
    Residuals(const Predictor &predictor, const std::vector<Measurement> &measurements, double scale_sigma,
              size_t most);

    size_t count() const noexcept { return used_.size(); }
    double exposure_s() const noexcept; // length of all exposures; 0 if they differ
    int64_t middle_ns() const noexcept; // of the times

    const Values &before() const noexcept { return before_; }
    // Residuals if the change were true.
    Values after(const Change &change) const;
    // The same from the velocities of observer and Earth alone, 50 times as fast: within 1 uas for an observer in a low
    // orbit and changes of a day, more for those without a state.
    Values estimate(const Change &change) const;
    Values scale() const; // derivative by a relative error of the plate scale, with the sign of before()

    // What the free functions and the errors of the orbit, with their priors, leave of values: one number per
    // measurement, 0 for those that are NaN in `used`, then the priors' own residuals.
    std::vector<double> rest(const Values &values, const Values &used, Free free) const;

  private:
    struct Node {
        int64_t tai_ns;
        double weight, approach_m_s; // of the spacecraft, towards the system
    };

    std::vector<Node> nodes_of(const Exposure &exposure) const;
    double spacecraft_approach(const Node &node, const Change &change) const;
    void set_slow();
    std::vector<double> basis_of(const Values &used, Free free, size_t &rank) const;

    const Predictor &predictor_;
    std::vector<Measurement> used_;
    std::vector<Prediction> seen_;
    std::vector<std::vector<Node>> nodes_;
    std::vector<double> earth_pull_; // derivative of the Earth's velocity towards the system, m/s^2
    std::vector<Values> columns_;    // effects of the standard deviations of the elements
    std::vector<Values> slow_;       // the free functions
    erfa::Vector towards_;
    Values before_;
    std::vector<double> basis_; // orthonormal, for all measurements with Free::slow
    size_t rank_ = 0;
};

} // namespace toliman::sky
