// Method: each frame is fitted at its time in the scene. The efficiency compares each value of a frame without signal
// with the Cramer-Rao bound at this time, because the bound changes with the places of the stars.
#include "experiment/fit_run.hpp"

#include <algorithm>
#include <utility>

#include "frames/frame_loop.hpp"

namespace cli {

namespace {

bool is_series(const std::vector<double> &values) {
    constexpr int fewest = 5;
    return std::count_if(values.begin(), values.end(), [](double value) { return !std::isnan(value); }) >= fewest;
}

// Not in frames that are too small, nor for an orbit of more dates than a bank can have.
bool can_have_bank(const Scene &scene) {
    auto plan = toliman::sized<toliman_bank_plan_info>();
    return toliman_bank_plan(scene.sim.get(), nullptr, &plan) == TOLIMAN_OK;
}

} // namespace

FitRun::FitRun(const Scene &scene, uint64_t seed) {
    if (can_have_bank(scene)) {
        auto bank = std::make_unique<BankMethod>(scene, seed);
        bank_ = bank.get();
        method_ = std::move(bank);
    } else {
        method_ = std::make_unique<FitMethod>(scene);
    }
}

void FitRun::train(Progress &progress) {
    if (bank_ == nullptr)
        return;
    bank_->train(Progress::callback, &progress);
    const toliman_bank *const bank = bank_->bank();
    bank_outcome.info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank);
    bank_outcome.least_cosine = 1;
    for (int64_t i = 0; i < bank_outcome.info.networks; i++) {
        auto network = toliman::sized<toliman_bank_network>();
        toliman::check(toliman_bank_get_network(bank, i, &network));
        bank_outcome.least_cosine = std::min(bank_outcome.least_cosine, network.cosine);
    }
    bank_outcome.weights = bytes_of([bank](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_bank_save(bank, TOLIMAN_CAE_ENCODING_FLOAT32, data, capacity, size);
    });
}

bool FitRun::has_series() const {
    return is_series(outcome.signal.values) &&
           (outcome.no_signal.values.empty() || is_series(outcome.no_signal.values));
}

void FitRun::end_frames(const std::vector<double> &times_days) {
    const std::vector<toliman_fit_result> results = method_->results();
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
    if (bank_ != nullptr)
        end_frames(bank_->estimates());
    bounds_px_ = method_->bounds_px(times_days);
    std::vector<double> variances;
    for (const double bound : bounds_px_)
        variances.push_back(bound * bound);
    outcome.bound_px = std::sqrt(mean(variances));
}

void FitRun::end_frames(const std::vector<toliman_bank_result> &estimates) {
    bank_outcome.signal.values = displacements(estimates);
    std::vector<double> known;
    for (const toliman_bank_result &estimate : estimates) {
        bank_outcome.efficiencies.push_back(estimate.efficiency);
        if (!std::isnan(estimate.efficiency))
            known.push_back(estimate.efficiency);
    }
    if (known.empty())
        return;
    bank_outcome.least_efficiency = *std::min_element(known.begin(), known.end());
    bank_outcome.mean_efficiency = mean(known);
}

void FitRun::end_controls(bool photon_noise) {
    if (bank_ != nullptr)
        end_controls(displacements(bank_->estimates()), photon_noise, bank_outcome);
    end_controls(displacements(method_->results()), photon_noise, outcome);
}

void FitRun::end_controls(std::vector<double> values, bool photon_noise, FollowOutcome &of) const {
    Outcome &control = of.no_signal;
    control.values = std::move(values);
    std::vector<double> known, squared_ratios;
    for (size_t k = 0; k < control.values.size(); k++) {
        if (std::isnan(control.values[k]))
            continue;
        known.push_back(control.values[k]);
        const double ratio = control.values[k] / bounds_px_[k % bounds_px_.size()];
        squared_ratios.push_back(ratio * ratio);
    }
    control.sigma_px = of.signal.sigma_px = deviation(known);
    if (photon_noise)
        of.efficiency = 1 / std::sqrt(mean(squared_ratios));
    control.values.resize(std::min(control.values.size(), bounds_px_.size()));
}

} // namespace cli
