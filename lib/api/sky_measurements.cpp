#include "api/sky_measurements.hpp"

#include "api/guard.hpp"
#include "ingest/nanoseconds.hpp"

namespace toliman::api {

namespace {

std::vector<sky::Interval> intervals_of(const int64_t *intervals, size_t count) {
    std::vector<sky::Interval> given(count);
    for (size_t i = 0; i < count; i++)
        given[i] = {intervals[2 * i], intervals[2 * i + 1]};
    return given;
}

} // namespace

std::vector<sky::Exposure> exposures_of(const int64_t *intervals, const size_t *interval_counts, size_t count) {
    required_array(intervals, count, 2 * sizeof *intervals, "intervals");
    std::vector<sky::Exposure> exposures;
    for (size_t i = 0; i < count; i++) {
        const size_t own = interval_counts != nullptr ? interval_counts[i] : 1;
        exposures.push_back({intervals_of(intervals, own), interval_counts != nullptr});
        intervals += 2 * own;
    }
    return exposures;
}

void check_exposures(const std::vector<sky::Exposure> &exposures) {
    std::vector<int64_t> starts;
    for (const sky::Exposure &exposure : exposures)
        if (!exposure.intervals.empty())
            starts.push_back(exposure.intervals.front().start_ns);
    ingest::check_nanoseconds("intervals", starts.data(), starts.size());
}

double known_scale_sigma(double scale_sigma) {
    if (!(scale_sigma >= 0 && scale_sigma < 1))
        fail(Status::argument, "{scale_sigma} = %g: must be in [0, 1)", scale_sigma);
    return scale_sigma;
}

} // namespace toliman::api
