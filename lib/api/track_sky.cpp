// Adapts a system and observer to the reduction of a tracker's frames.
#include <algorithm>
#include <vector>

#include "api/sky_handle.hpp"
#include "base/error.hpp"
#include "scene/system.hpp"

namespace toliman::api {

namespace {

constexpr int64_t kLongestUnlistedNs = 600'000'000'000; // longer exposures are sums of shorter ones

// An observer in orbit is not where it was in the middle of an exposure: the time on target must be known.
bool is_on_target_known(const track::OnTarget &on_target, const sky::Observer &observer) noexcept {
    const track::Span &first = on_target.spans.front();
    const int64_t length = first.end_ns - first.start_ns;
    return observer.kind() == sky::Observer::Kind::earth || on_target.listed ||
           (length > 0 && length <= kLongestUnlistedNs);
}

track::Reason reduce(const sky::Predictor &predictor, const track::OnTarget &on_target, track::Reduction &reduction) {
    if (!is_on_target_known(on_target, predictor.observer()))
        return track::Reason::no_intervals;
    std::vector<sky::Interval> intervals;
    intervals.reserve(on_target.spans.size());
    for (const track::Span &span : on_target.spans)
        intervals.push_back({span.start_ns, span.end_ns});
    try {
        const sky::Prediction mean = predictor.mean(intervals);
        reduction.factor = mean.factor;
        reduction.geometric_arcsec = mean.geometric_arcsec;
        std::copy_n(mean.partials, track::kPartials, reduction.partials);
        return track::Reason::none;
    } catch (const Error &error) {
        if (error.status() != Status::range && error.status() != Status::argument)
            throw;
        return track::Reason::no_orbit;
    }
}

} // namespace

SkySource sky_source(const toliman_sky &sky) {
    static_assert(track::kPartials == sky::kElements);
    const sky::Predictor &predictor = *sky.predictor;
    return {system_json(predictor.system()),
            [&predictor](const track::OnTarget &on_target, track::Reduction &reduction) {
                return reduce(predictor, on_target, reduction);
            }};
}

} // namespace toliman::api
