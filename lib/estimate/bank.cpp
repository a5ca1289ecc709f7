// Covariances: the network's estimate does not change with the other parameters, in first order. With the efficient
// estimate of a parameter it then has the same covariance as the efficient estimate of the separation, an element of
// the inverse Fisher matrix; only its own variance is larger. Reference: C. R. Rao, Linear Statistical Inference,
// section 5a.

#include "base/error.hpp"
#include "estimate/estimators.hpp"
#include "estimate/values.hpp"

namespace toliman::estimate {

namespace {

constexpr char kBankValues[] = "separation_px x_px y_px fit_separation_px";
constexpr size_t kBankRows[] = {0, 0, 2, 3, 0}; // parameters of the value and of these

// At its place. The tracker allows a sigma that is 16 times that of the fit at time 0.
constexpr double kLeastEfficiency = 0.5;

void check_efficiency(const bank::Bank &bank) {
    const auto &networks = bank.networks();
    for (size_t i = 0; i < networks.size(); i++) {
        const double efficiency = networks[i].cosine * networks[i].response.share;
        if (!(efficiency >= kLeastEfficiency))
            fail(Status::argument,
                 "{options->estimator.bank}: network %zu of %zu has an efficiency of %.3g at its place: must be "
                 "trained, to at "
                 "least %g",
                 i, networks.size(), efficiency, kLeastEfficiency);
    }
}

void store_bank(const bank::Estimate &estimate, const fit::Result &result, size_t n, track::Estimated &estimated) {
    if ((estimate.flags & bank::not_fitted) != 0)
        return;
    estimated.value = estimate.displacement_px;
    estimated.sigma = estimate.sigma_px;
    store_goodness(result.goodness, estimated);
    estimated.flags = result.flags + kBankFlags * estimate.flags;
    FittedValues fitted(result, n, kBankRows);
    fitted.values[1] = estimate.separation_px;
    for (size_t i = 0; i < 2; i++) // value and separation_px
        for (size_t j = 0; j < 2; j++)
            fitted.covariance[i][j] = estimate.sigma_px * estimate.sigma_px;
    store_fitted(fitted, result, n, estimated);
}

} // namespace

track::Source of_bank(const bank::Bank &bank, BankWorks &works, const fit::Windows &windows, FitWorks &fit_works,
                      int64_t time_offset_ns) {
    const fit::Fit &fit = windows.first();
    check_efficiency(bank);
    return {fit.rows(),
            fit.cols(),
            kSigmaShare * fit.sigma_px(),
            bank.digest(), // includes that of the fit
            kBankValues,
            [=, &works, &fit_works, &bank, &fit](double *image, const track::Frame &frame, int64_t tai_ns, unsigned,
                                                 track::Estimated &estimated) {
                FitWorks::Lease fit_work(fit_works);
                BankWorks::Lease work(works);
                fit::Prediction prediction = prediction_at(tai_ns, time_offset_ns);
                prediction.window = frame.image_window;
                prediction.may_lack_observer = frame.is_reduced;
                const bank::Estimate estimate =
                    bank.estimate(fit, {image, fit.rows(), fit.cols(), fit.cols()}, prediction, *fit_work, *work);
                store_bank(estimate, (*work).fitted, fit.parameters().size(), estimated);
            },
            fit.pixel_scale_arcsec(),
            model_verdict_of(windows),
            parameters_of(fit)};
}

} // namespace toliman::estimate
