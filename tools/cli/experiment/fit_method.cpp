#include "experiment/fit_method.hpp"

#include <cmath>
#include <utility>

#include "common/library.hpp"
#include "common/parallel.hpp"

namespace cli {

namespace {

toliman_fit_prediction prediction_at(double time_days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = time_days;
    return prediction;
}

} // namespace

FitMethod::FitMethod(const Scene &scene)
    : fit_(toliman::make<toliman::frame_fit>(toliman_fit_create, scene.sim.get(), nullptr)) {}

void FitMethod::push(const double *images, const double *times_days, size_t count) {
    const toliman_image image = plain_image(images);
    std::vector<toliman_fit_prediction> predictions;
    for (size_t i = 0; i < count; i++)
        predictions.push_back(prediction_at(times_days[i]));
    results_.resize(results_.size() + count, toliman::sized<toliman_fit_result>());
    toliman::check(
        toliman_fit_frames(fit_.get(), &image, count, predictions.data(), 0, &results_[results_.size() - count]));
}

std::vector<double> FitMethod::series() {
    std::vector<double> values;
    for (const toliman_fit_result &result : results())
        values.push_back(result.displacement_px);
    return values;
}

std::vector<toliman_fit_result> FitMethod::results() {
    return std::exchange(results_, {});
}

std::vector<double> FitMethod::bounds_px(const std::vector<double> &times_days) const {
    const auto parameters = static_cast<size_t>(toliman_fit_parameter_count(fit_.get()));
    std::vector<double> bounds(times_days.size());
    run_parallel(bounds.size(), [&](size_t i) {
        const toliman_fit_prediction prediction = prediction_at(times_days[i]);
        std::vector<double> covariance(parameters * parameters);
        toliman::check(toliman_fit_predict(fit_.get(), &prediction, nullptr, 0, nullptr, covariance.data()));
        bounds[i] = std::sqrt(covariance[0]); // of the separation, the first parameter
    });
    return bounds;
}

} // namespace cli
