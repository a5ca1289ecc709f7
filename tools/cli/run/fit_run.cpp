// Method: each frame is fitted at its time in the scene, alone or with the networks of a bank. The efficiency compares
// each value of a frame without signal with the Cramer-Rao bound at this time, because the bound changes with the
// places of the stars.
#include "run/fit_run.hpp"

#include <iterator>

#include "common/parallel.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr uint32_t kBankSteps = 300; // as many as those of a single network; 600 would gain 0.3 % of efficiency

bool is_series(const std::vector<double> &values) {
    constexpr int fewest = 5;
    return std::count_if(values.begin(), values.end(), [](double value) { return !std::isnan(value); }) >= fewest;
}

// Not in frames that are too small, nor for an orbit of more dates than a bank can have.
bool can_have_bank(const Scene &scene) {
    auto plan = toliman::sized<toliman_bank_plan_info>();
    return toliman_bank_plan(scene.sim.get(), nullptr, &plan) == TOLIMAN_OK;
}

toliman_fit_prediction prediction_at(double time_days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = time_days;
    return prediction;
}

// Appends `count` structs with their size set; returns the first.
template <class T> T *append(std::vector<T> &structs, size_t count) {
    structs.resize(structs.size() + count, toliman::sized<T>());
    return &structs[structs.size() - count];
}

template <class Result> std::vector<double> displacements(const std::vector<Result> &results) {
    std::vector<double> values;
    values.reserve(results.size());
    for (const Result &result : results)
        values.push_back(result.displacement_px);
    return values;
}

} // namespace

FitRun::FitRun(const Scene &scene, uint64_t seed) {
    const toliman_sim *const sim = scene.sim.get();
    fit_ = toliman::make<toliman::frame_fit>(toliman_fit_create, &sim, nullptr, size_t{1}, nullptr);
    if (!can_have_bank(scene))
        return;
    auto options = toliman::sized<toliman_bank_options>();
    options.steps = kBankSteps;
    options.seed = seed;
    bank_ = toliman::make<toliman::network_bank>(toliman_bank_create, fit_.get(), &options);
}

void FitRun::train(Progress &progress) {
    const toliman_bank *const bank = bank_.get();
    if (bank == nullptr)
        return;
    auto options = toliman::sized<toliman_bank_train_options>();
    options.progress = Progress::callback;
    options.progress_data = &progress;
    toliman::check(toliman_bank_train(bank_.get(), fit_.get(), &options));
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

void FitRun::push(const double *images, const double *times_days, size_t count) {
    const toliman_image image = plain_image(images);
    std::vector<toliman_fit_prediction> predictions;
    std::transform(times_days, times_days + count, std::back_inserter(predictions), prediction_at);
    toliman_fit_result *const results = append(results_, count);
    toliman::check(bank_ ? toliman_bank_encode(bank_.get(), fit_.get(), &image, count, predictions.data(),
                                               append(estimates_, count), results)
                         : toliman_fit_frame(fit_.get(), &image, count, predictions.data(), results, nullptr, nullptr));
}

// Standard deviations of the values that noise alone causes in frames at these times: Cramer-Rao bounds with places,
// fluxes and background free, px.
std::vector<double> FitRun::bounds_px(const std::vector<double> &times_days) const {
    const auto parameters =
        static_cast<size_t>(toliman::result<toliman_fit_info>(toliman_fit_get_info, fit_.get()).parameters);
    std::vector<double> bounds(times_days.size());
    run_parallel(bounds.size(), [&](size_t i) {
        const toliman_fit_prediction prediction = prediction_at(times_days[i]);
        std::vector<double> covariance(parameters * parameters);
        toliman::check(toliman_fit_predict(fit_.get(), &prediction, nullptr, 0, nullptr, covariance.data()));
        bounds[i] = std::sqrt(covariance[0]); // of the separation, the first parameter
    });
    return bounds;
}

bool FitRun::has_series() const {
    return is_series(outcome.signal.values) &&
           (outcome.no_signal.values.empty() || is_series(outcome.no_signal.values));
}

void FitRun::end_frames(const std::vector<double> &times_days) {
    const std::vector<toliman_fit_result> results = std::exchange(results_, {});
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
    if (bank_)
        end_frames(std::exchange(estimates_, {}));
    bounds_px_ = bounds_px(times_days);
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
    if (bank_)
        end_controls(displacements(estimates_), photon_noise, bank_outcome);
    end_controls(displacements(results_), photon_noise, outcome);
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
