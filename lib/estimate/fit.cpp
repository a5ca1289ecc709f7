#include <cmath>

#include "estimate/estimators.hpp"
#include "estimate/values.hpp"

namespace toliman::estimate {

namespace {

constexpr char kFitValues[] = "separation_px x_px y_px";
constexpr size_t kFitRows[] = {0, 0, 2, 3}; // parameters of value, separation_px, x_px, y_px

// The value is the separation minus its prediction, so that it has the variance of the separation.
void store_fit(const fit::Result &result, size_t n, track::Estimated &estimated) {
    if ((result.flags & fit::not_converged) != 0)
        return;
    estimated.value = result.displacement_px;
    estimated.sigma = std::sqrt(result.covariance[0]);
    store_goodness(result.goodness, estimated);
    estimated.flags = result.flags;
    store_fitted(FittedValues(result, n, kFitRows), result, n, estimated);
}

} // namespace

track::ModelVerdict model_verdict_of(const fit::Windows &fit) noexcept {
    track::ModelVerdict verdict;
    for (size_t i = 0; i < fit.count(); i++) {
        const std::optional<SceneCalibration> &calibration = fit.window(i).scene().calibration;
        if (!calibration)
            continue;
        const bool is_complete = calibration->complete || !calibration->stated;
        if (!verdict.is_calibrated || (verdict.is_complete && !is_complete))
            verdict.goodness = calibration->goodness;
        verdict.is_complete = verdict.is_complete && is_complete;
        verdict.is_calibrated = true;
    }
    return verdict;
}

track::Source of_fit(const fit::Windows &fit, FitWorks &works, int64_t time_offset_ns) {
    return {fit.rows(),
            fit.cols(),
            kSigmaShare * fit.first().sigma_px(),
            fit.digest(),
            kFitValues,
            [=, &works, &fit](double *image, const track::Frame &frame, int64_t tai_ns, unsigned,
                              track::Estimated &estimated) {
                FitWorks::Lease work(works);
                fit::Result result;
                fit::Prediction prediction = prediction_at(tai_ns, time_offset_ns);
                prediction.spread = frame.spread;
                prediction.window = frame.image_window;
                prediction.may_lack_observer = frame.is_reduced;
                fit.frame({image, fit.rows(), fit.cols(), fit.cols()}, prediction, *work, result);
                store_fit(result, fit.parameters().size(), estimated);
            },
            fit.first().pixel_scale_arcsec(),
            model_verdict_of(fit),
            parameters_of(fit.first())};
}

} // namespace toliman::estimate
