// Method: each frame is fitted at its time in the scene. The efficiency compares each value of a frame without signal
// with the Cramer-Rao bound at this time, because the bound changes with the places of the stars.
#include "experiment/fit_run.hpp"

#include <algorithm>

#include "frames/frame_loop.hpp"

namespace cli {

namespace {

bool is_series(const std::vector<double> &values) {
    constexpr int fewest = 5;
    return std::count_if(values.begin(), values.end(), [](double value) { return !std::isnan(value); }) >= fewest;
}

} // namespace

bool FitRun::has_series() const {
    return is_series(outcome.signal.values) &&
           (outcome.no_signal.values.empty() || is_series(outcome.no_signal.values));
}

void FitRun::end_frames(const std::vector<double> &times_days) {
    const std::vector<toliman_fit_result> results = method_.results();
    std::vector<double> chi_squares, iterations;
    for (const toliman_fit_result &result : results) {
        outcome.signal.values.push_back(result.displacement_px);
        if ((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0)
            continue;
        chi_squares.push_back(result.chi_square);
        iterations.push_back(result.iterations);
    }
    outcome.lost = results.size() - chi_squares.size();
    outcome.chi_square = mean(chi_squares);
    outcome.iterations = mean(iterations);
    bounds_px_ = method_.bounds_px(times_days);
    std::vector<double> variances;
    for (const double bound : bounds_px_)
        variances.push_back(bound * bound);
    outcome.bound_px = std::sqrt(mean(variances));
}

void FitRun::end_controls(bool photon_noise) {
    Outcome &control = outcome.no_signal;
    control.values = method_.series();
    std::vector<double> known, squared_ratios;
    for (size_t k = 0; k < control.values.size(); k++) {
        if (std::isnan(control.values[k]))
            continue;
        known.push_back(control.values[k]);
        const double ratio = control.values[k] / bounds_px_[k % bounds_px_.size()];
        squared_ratios.push_back(ratio * ratio);
    }
    control.sigma_px = outcome.signal.sigma_px = deviation(known);
    if (photon_noise)
        outcome.efficiency = 1 / std::sqrt(mean(squared_ratios));
    control.values.resize(std::min(control.values.size(), bounds_px_.size()));
}

} // namespace cli
