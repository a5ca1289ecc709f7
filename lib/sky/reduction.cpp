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
#include <cstring>
#include <iterator>
#include <limits>

#include "base/error.hpp"

namespace toliman::sky {

namespace {

constexpr uint64_t kLongest = 600000000000; // ns, of an exposure without on-target intervals
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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
        return "zero length: must be from start to end of the exposure, as the observer is in orbit: the prediction "
               "for its middle is wrong by 0.18 uas in 120 s, 4.4 uas in 600 s and up to 245 uas in a day";
    const uint64_t length = static_cast<uint64_t>(end_ns) - static_cast<uint64_t>(start_ns);
    if (exposure.on_target || start_ns > end_ns || length <= kLongest)
        return "";
    return "longer than 600 s: must be the on-target intervals, as the observer is in orbit: the mean over the whole "
           "exposure is wrong by up to 245 uas";
}

Reduced reduce(const Predictor &predictor, const Exposure &exposure, double separation_arcsec) {
    if (const std::string why = why_unknown(predictor.observer(), exposure); !why.empty())
        fail(Status::argument, "{intervals}: %s", why.c_str());
    try {
        const Prediction seen = predictor.mean(exposure.intervals);
        return {separation_arcsec / seen.factor - seen.geometric_arcsec, seen};
    } catch (const Error &error) { // field: "time" outside the years of predictions, else the name of the file
        const bool by_file = error.status() == Status::range && predictor.observer().ephemeris() != nullptr;
        if (!by_file || std::strcmp(error.field(), "time") == 0)
            throw;
        return not_covered();
    }
}

} // namespace toliman::sky
