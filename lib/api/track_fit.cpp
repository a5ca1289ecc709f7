// Adapts a fit to the signature that the tracker's workers call. The tracker reaches it by a pointer in the fit, so
// that a statically linked program without fits needs neither these files nor FFTW.
#include <cmath>
#include <iterator>

#include "api/track_estimators.hpp"

namespace toliman::api {

namespace {

// Frames over years of an orbit have other standard deviations than the scene's frame at time 0. The tracker allows 1
// to 32 times its own.
constexpr double kSigmaShare = 0.5;
constexpr char kValues[] = "separation_px,x_px,y_px";

// The value is the separation minus its prediction, so that it has the variance of the separation.
void store_fit(const fit::Result &result, size_t n, track::Estimated &estimated) {
    constexpr size_t rows[] = {0, 0, 2, 3}; // parameters of value, separation_px, x_px, y_px
    if ((result.flags & fit::not_converged) != 0)
        return;
    estimated.value = result.displacement_px;
    estimated.sigma = std::sqrt(result.covariance[0]);
    estimated.chi_square = result.chi_square;
    estimated.flags = result.flags;
    size_t at = 0;
    for (size_t i = 1; i < std::size(rows); i++)
        estimated.further[at++] = result.values[rows[i]];
    for (size_t i = 0; i < std::size(rows); i++)
        for (size_t j = i > 0 ? i : 1; j < std::size(rows); j++)
            estimated.further[at++] = result.covariance[rows[i] * n + rows[j]];
}

} // namespace

Source fit_source(const toliman_fit &handle, int64_t time_offset_ns) {
    constexpr double kDayNs = 86400e9;
    const fit::Fit &fit = handle.fit;
    return {
        fit.rows(),
        fit.cols(),
        kSigmaShare * fit.sigma_px(),
        fit.digest(),
        kValues,
        [=, &handle, &fit](double *image, const track::Frame &, int64_t tai_ns, unsigned, track::Estimated &estimated) {
            WorkPool<fit::FitWork>::Lease work(handle.works);
            fit::Prediction prediction;
            prediction.days = static_cast<double>(static_cast<long double>(tai_ns) - time_offset_ns) / kDayNs;
            fit::Result result;
            fit.frame({image, fit.rows(), fit.cols(), fit.cols()}, prediction, *work, result);
            store_fit(result, fit.parameters().size(), estimated);
        }};
}

} // namespace toliman::api
