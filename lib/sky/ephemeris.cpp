#include "sky/ephemeris.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "ingest/epoch.hpp"
#include "sky/ephemeris_table.hpp"
#include "sky/horizons.hpp"
#include "sky/interpolation.hpp"
#include "sky/oem.hpp"
#include "sky/oem_xml.hpp"

namespace toliman::sky {

namespace {

constexpr size_t kLargestFile = size_t{256} << 20;

} // namespace

Ephemeris::Ephemeris(std::string source, std::vector<Segment> segments)
    : source_(std::move(source)), segments_(std::move(segments)) {}

State Ephemeris::at(int64_t tai_ns) const {
    try {
        return known_state(tai_ns);
    } catch (const Error &error) {
        throw NoState(error);
    }
}

State Ephemeris::known_state(int64_t tai_ns) const {
    const auto later = [](int64_t wanted, const Segment &segment) { return wanted < segment.first_ns; };
    const auto after = std::upper_bound(segments_.begin(), segments_.end(), tai_ns, later);
    const bool follows = after != segments_.begin(), precedes = after != segments_.end();
    if (follows && precedes && tai_ns > (after - 1)->last_ns)
        fail(Status::range, "{%s}: %s TAI is between segments, of which one ends at %s and the next begins at %s",
             source_.c_str(), ingest::date_text(tai_ns).c_str(), ingest::date_text((after - 1)->last_ns).c_str(),
             ingest::date_text(after->first_ns).c_str());
    if (!follows || tai_ns > (after - 1)->last_ns)
        fail(Status::range, "{%s}: %s TAI: must be from %s to %s, the times of the states", source_.c_str(),
             ingest::date_text(tai_ns).c_str(), ingest::date_text(segments_.front().first_ns).c_str(),
             ingest::date_text(segments_.back().last_ns).c_str());
    const Interpolated found = interpolate(*(after - 1), tai_ns);
    if (!(found.doubt_m_s <= kMostDoubt))
        fail(
            Status::range,
            "{%s}: %s TAI: the states there are %.6g s apart: the velocity is uncertain by more than 1 m/s; must be at "
            "most 300 s apart in a low orbit",
            source_.c_str(), ingest::date_text(tai_ns).c_str(), found.step_s);
    return found.state;
}

bool Ephemeris::covers(int64_t tai_ns) const noexcept {
    const auto later = [](int64_t wanted, const Segment &segment) { return wanted < segment.first_ns; };
    const auto after = std::upper_bound(segments_.begin(), segments_.end(), tai_ns, later);
    return after != segments_.begin() && tai_ns <= (after - 1)->last_ns;
}

void Ephemeris::check_interval(int64_t start_ns, int64_t end_ns) const {
    int64_t covered = start_ns;
    for (const Segment &segment : segments_)
        if (segment.first_ns <= covered && segment.last_ns >= covered)
            covered = segment.last_ns;
    if (covered >= end_ns && start_ns >= segments_.front().first_ns)
        return;
    try {
        fail(Status::range, "{%s}: the interval from %s to %s TAI is not covered by the states from %s on",
             source_.c_str(), ingest::date_text(start_ns).c_str(), ingest::date_text(end_ns).c_str(),
             ingest::date_text(covered).c_str());
    } catch (const Error &error) {
        throw NoState(error);
    }
}

Ephemeris read_ephemeris(const std::string &path, const ingest::LeapSeconds &leap_seconds, const Log &log) {
    ingest::TextLines lines(path, kLargestFile);
    if (ingest::TextLines::trimmed(lines.rest()).substr(0, 1) == "<")
        lines = key_values_of_xml(path.c_str(), ingest::TextLines::trimmed(lines.rest()));
    const bool has_mark = is_horizons(lines.rest());
    std::string_view first;
    while (first.empty() && lines.next(first)) {
    }
    if (first.substr(0, 6) == "CCSDS_")
        return {path, read_oem(lines, first, leap_seconds, log)};
    return {path, has_mark ? read_horizons(lines, first, leap_seconds, log)
                           : read_ephemeris_table(lines, first, leap_seconds, log)};
}

} // namespace toliman::sky
