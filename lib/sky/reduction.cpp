// Method: reduced = s/F - g, where s is the measured separation, F = apparent/geometric and g the geometric separation,
// both of means over the on-target intervals. Subtracting the predicted apparent separation instead would leave an
// annual wave where the elements are wrong (refit.cpp).
//
// The velocity of an observer in orbit changes the separation of alpha Centauri by 205 to 257 uas every 97 minutes. The
// prediction for the middle of an exposure then differs from the mean over it by 0.18 uas in 120 s and 4.4 uas in 600
// s. A longer exposure is a sum of several, between which the telescope points elsewhere: the mean from start to end
// differs from that over the true intervals by up to 245 uas. Neither is replaced by a guess.
#include "sky/reduction.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <limits>

#include "base/error.hpp"

namespace toliman::sky {

namespace {

constexpr uint64_t kLongest = 600000000000; // ns, of an exposure without on-target intervals

Reduced not_covered() {
    Reduced out = {kNaN, {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, {}}};
    std::fill(std::begin(out.seen.partials), std::end(out.seen.partials), kNaN);
    return out;
}

} // namespace

std::string why_unknown(const Observer &observer, const Exposure &exposure) {
    if (observer.kind() == Observer::Kind::earth || exposure.intervals.size() != 1)
        return "";
    const auto [start_ns, end_ns] = exposure.intervals.front();
    if (start_ns == end_ns)
        return "zero length: must be start and end of the exposure for an observer in orbit";
    const uint64_t length = static_cast<uint64_t>(end_ns) - static_cast<uint64_t>(start_ns);
    if (exposure.on_target || start_ns > end_ns || length <= kLongest)
        return "";
    char text[100];
    std::snprintf(text, sizeof text, "%.6g s: must be on-target intervals above 600 s for an observer in orbit",
                  static_cast<double>(length) * 1e-9);
    return text;
}

ExposureMean mean_over(const Predictor &predictor, const Exposure &exposure) {
    using Outcome = ExposureMean::Outcome;
    if (std::string why = why_unknown(predictor.observer(), exposure); !why.empty())
        return {Outcome::unknown, {}, std::move(why)};
    try {
        return {Outcome::known, predictor.mean(exposure.intervals), ""};
    } catch (const NoState &) {
        return {Outcome::no_state, {}, ""};
    }
}

Reduced reduce(const Predictor &predictor, const Exposure &exposure, double separation_arcsec) {
    const ExposureMean mean = mean_over(predictor, exposure);
    switch (mean.outcome) {
    case ExposureMean::Outcome::unknown:
        fail(Status::argument, "{intervals}: %s", mean.why.c_str());
    case ExposureMean::Outcome::no_state:
        return not_covered();
    case ExposureMean::Outcome::known:
        break;
    }
    return {separation_arcsec / mean.seen.factor - mean.seen.geometric_arcsec, mean.seen};
}

} // namespace toliman::sky
