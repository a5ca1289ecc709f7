// Method: peaks of a series of length T are about 1/T wide, so a step of df = 0.1/T samples each peak about ten times
// (VanderPlas 2018, ApJS 236, 16, section 7.1, recommends five or more). f0 = 1.5/T is the lowest frequency whose
// sinusoid a floating mean does not absorb. The last frequency follows from the differences of the times
// (sampling.hpp). The median step alone does not suit uneven times: one visit every 7 nights hid periods below 14 d,
// and three exposures per night needed 2.6e6 frequencies. A search takes 7 to 14 ns per sample and frequency: the
// limits below are 30 MB and about 40 s. References are subtracted so that the fixed-point sums keep their digits, and
// the bounds leave a margin where further samples are expected: a bound that is too large costs digits, one that is too
// small refuses a sample.
#include "period/suggest.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/robust.hpp"
#include "period/sampling.hpp"

namespace toliman::period {

namespace {

constexpr double kMaxFrequencies = 131072; // 30 MB of sums
constexpr double kMaxTerms = 0x1p32;       // samples times frequencies
constexpr double kMinFrequencies = 1024;   // also for more than 2^22 samples
// Further samples may have sigmas smaller or larger, and values with a spread larger, by these factors.
constexpr double kSigmaMarginBelow = 8, kSigmaMarginAbove = 4;
constexpr double kValueMargin = 0x1p20;
constexpr double kLargestSuggestedRatio = 0.9 * kMaxSigmaRatio; // of sigmas, with a margin to the limit
constexpr double kMinBound = 1e-99, kMaxBound = 1e99;

void check_finite(const double *numbers, size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (!std::isfinite(numbers[i]))
            fail(Status::argument, "sample %zu: {%s} = %g: must be finite", i, name, numbers[i]);
}

Cadence cadence_for(const Samples &samples, double mission_span) {
    Cadence cadence = {0, 1, 1};
    if (samples.count > 0)
        cadence = cadence_of(std::vector<double>(samples.t, samples.t + samples.count));
    if (!(cadence.step > 0))
        fail(Status::state, "{t}: must have at least two distinct times");
    cadence.span = std::max(cadence.span, mission_span);
    if (!(cadence.span > 0))
        fail(Status::state, "{n} = 0: must be at least 1 without mission_span");
    return cadence;
}

void set_frequencies(Grid &grid, const Cadence &cadence, size_t samples) {
    const double most =
        std::clamp(kMaxTerms / static_cast<double>(std::max<size_t>(samples, 1)), kMinFrequencies, kMaxFrequencies);
    grid.f0 = 1.5 / cadence.span;
    grid.df = 0.1 / cadence.span;
    const double count = std::fmax(1, std::floor((0.5 / cadence.finest - grid.f0) / grid.df * kRounding) + 1);
    grid.nf = static_cast<int64_t>(std::fmin(count, std::floor(most)));
}

void set_values(Grid &grid, const double *y, size_t count, bool more_to_come) {
    const auto [least, greatest] = std::minmax_element(y, y + count);
    const double spread = *greatest - *least;
    grid.value_offset = median({y, y + count});
    const double bound = std::exp2(std::ceil(std::log2(spread > 0 ? spread : 1.0))) * (more_to_come ? kValueMargin : 1);
    grid.value_bound = std::clamp(bound, kMinBound, kMaxBound);
}

void set_sigmas(Grid &grid, const double *sigma, size_t count, bool more_to_come) {
    const auto [least, largest] = std::minmax_element(sigma, sigma + count);
    if (!(*least > 0))
        fail(Status::argument, "sample %zu: {sigma} = %g: must be above 0", static_cast<size_t>(least - sigma), *least);
    grid.sigma_floor = more_to_come
                           ? std::min(*least, std::max(*least / kSigmaMarginBelow, *largest / kLargestSuggestedRatio))
                           : *least;
    grid.sigma_ceiling =
        more_to_come
            ? std::max(*largest, std::min(*largest * kSigmaMarginAbove, grid.sigma_floor * kLargestSuggestedRatio))
            : *largest;
}

} // namespace

Grid suggest_bounds(const Samples &samples, double mission_span) {
    if (!(mission_span >= 0 && std::isfinite(mission_span)))
        fail(Status::argument, "{mission_span} = %g: must be finite and at least 0", mission_span);
    check_finite(samples.t, samples.count, "t");
    Grid grid;
    grid.f0 = grid.df = 1;
    grid.nf = 1;
    grid.double_limb_sums = true;
    if (samples.count == 0)
        return grid;
    const bool more_to_come = mission_span > 0;
    grid.time_offset = *std::min_element(samples.t, samples.t + samples.count);
    if (samples.y != nullptr) {
        check_finite(samples.y, samples.count, "y");
        set_values(grid, samples.y, samples.count, more_to_come);
    }
    if (samples.sigma != nullptr) {
        check_finite(samples.sigma, samples.count, "sigma");
        set_sigmas(grid, samples.sigma, samples.count, more_to_come);
        grid.check();
    }
    return grid;
}

Grid suggest(const Samples &samples, double mission_span) {
    Grid grid = suggest_bounds(samples, mission_span);
    set_frequencies(grid, cadence_for(samples, mission_span), samples.count);
    return grid;
}

} // namespace toliman::period
