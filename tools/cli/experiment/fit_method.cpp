#include "experiment/fit_method.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/library.hpp"
#include "common/parallel.hpp"

namespace cli {

namespace {

constexpr uint32_t kBankSteps = 300; // as many as those of a single network; 600 would gain 0.3 % of efficiency

toliman_fit_prediction prediction_at(double time_days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = time_days;
    return prediction;
}

std::vector<toliman_fit_prediction> predictions_at(const double *times_days, size_t count) {
    std::vector<toliman_fit_prediction> predictions;
    std::transform(times_days, times_days + count, std::back_inserter(predictions), prediction_at);
    return predictions;
}

// Appends `count` structs with their size set; returns the first.
template <class T> T *append(std::vector<T> &structs, size_t count) {
    structs.resize(structs.size() + count, toliman::sized<T>());
    return &structs[structs.size() - count];
}

toliman::network_bank bank_of(const toliman_fit *fit, uint64_t seed) {
    auto options = toliman::sized<toliman_bank_options>();
    options.steps = kBankSteps;
    options.seed = seed;
    return toliman::make<toliman::network_bank>(toliman_bank_create, fit, &options);
}

} // namespace

FitMethod::FitMethod(const Scene &scene) {
    const toliman_sim *const sim = scene.sim.get();
    fit_ = toliman::make<toliman::frame_fit>(toliman_fit_create, &sim, nullptr, size_t{1}, nullptr);
}

void FitMethod::push(const double *images, const double *times_days, size_t count) {
    const toliman_image image = plain_image(images);
    toliman::check(toliman_fit_frame(fit_.get(), &image, count, predictions_at(times_days, count).data(),
                                     append(results_, count), nullptr, nullptr));
}

std::vector<double> FitMethod::series() {
    return displacements(results());
}

std::vector<toliman_fit_result> FitMethod::results() {
    return std::exchange(results_, {});
}

std::vector<double> FitMethod::bounds_px(const std::vector<double> &times_days) const {
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

BankMethod::BankMethod(const Scene &scene, uint64_t seed) : FitMethod(scene), bank_(bank_of(fit_.get(), seed)) {}

void BankMethod::train(toliman_progress_fn progress, void *progress_data) {
    auto options = toliman::sized<toliman_bank_train_options>();
    options.progress = progress;
    options.progress_data = progress_data;
    toliman::check(toliman_bank_train(bank_.get(), fit_.get(), &options));
}

void BankMethod::push(const double *images, const double *times_days, size_t count) {
    const toliman_image image = plain_image(images);
    toliman_fit_result *const fitted = append(results_, count);
    toliman::check(toliman_bank_encode(bank_.get(), fit_.get(), &image, count, predictions_at(times_days, count).data(),
                                       append(estimates_, count), fitted));
}

std::vector<double> BankMethod::series() {
    results_.clear();
    return displacements(estimates());
}

std::vector<toliman_bank_result> BankMethod::estimates() {
    return std::exchange(estimates_, {});
}

} // namespace cli
