// Values of a frame and their covariance as the cells of a tracker's record, and what fits and banks have in common.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "fit/fit.hpp"
#include "track/plan.hpp"

namespace toliman::estimate {

// Stores the second and later of values[count], then the upper triangle of covariance[count][count] without its first
// element, which is sigma^2. Returns the place of the parameters.
inline double *store_further(const double *values, const double *covariance, size_t count,
                             track::Estimated &estimated) noexcept {
    double *at = std::copy(values + 1, values + count, estimated.further.begin());
    for (size_t i = 0; i < count; i++)
        at = std::copy(covariance + i * count + std::max<size_t>(i, 1), covariance + (i + 1) * count, at);
    return at;
}

inline void store_goodness(const FrameGoodness &goodness, track::Estimated &estimated) noexcept {
    estimated.chi_square = goodness.chi_square;
    estimated.chi_square_sigma = goodness.sigma;
    estimated.largest_residual = goodness.largest;
    estimated.bad_pixels = static_cast<uint32_t>(goodness.bad_pixels);
}

// Frames over years of an orbit have other standard deviations than the scene's frame at time 0, and networks larger
// ones than fits. The tracker allows 1 to 32 times its own.
constexpr double kSigmaShare = 0.5;

// Some parameters of a fitted frame: number rows[i] of its result becomes value i.
template <size_t N> struct FittedValues {
    FittedValues(const fit::Result &result, size_t n, const size_t (&rows)[N]) noexcept {
        for (size_t i = 0; i < N; i++) {
            values[i] = result.values[rows[i]];
            for (size_t j = 0; j < N; j++)
                covariance[i][j] = result.covariance[rows[i] * n + rows[j]];
        }
    }
    double values[N], covariance[N][N];
};

// The prediction for a frame at this TAI, in a scene whose time 0 is TAI time_offset_ns.
inline fit::Prediction prediction_at(int64_t tai_ns, int64_t time_offset_ns) noexcept {
    constexpr double kDayNs = 86400e9;
    fit::Prediction prediction;
    prediction.days = static_cast<double>(static_cast<long double>(tai_ns) - time_offset_ns) / kDayNs;
    return prediction;
}

// The parameters of a fit that its values do not contain: those after the places of the stars, from the fluxes on.
constexpr size_t kPlaces = 4;
static_assert(fit::kMostParameters - kPlaces <= track::kMaxParameters);

inline std::string parameters_of(const fit::Fit &fit) {
    std::string names;
    for (size_t i = kPlaces; i < fit.parameters().size(); i++)
        names += (names.empty() ? "" : " ") + name_of(fit.parameters()[i]);
    return names;
}

// Stores values, covariances and parameters of a fit with n parameters.
template <size_t N>
void store_fitted(const FittedValues<N> &fitted, const fit::Result &result, size_t n,
                  track::Estimated &estimated) noexcept {
    double *const at = store_further(fitted.values, fitted.covariance[0], N, estimated);
    std::copy(result.values + kPlaces, result.values + n, at);
}

} // namespace toliman::estimate
