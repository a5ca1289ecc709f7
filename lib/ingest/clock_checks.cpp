// Method: the usual step is the median of the steps between neighbouring valid lines, which a few jumps do not change.
// A jump is a step back, a repeated time, or a step over kLargestStep usual ones per line. A frame that arrives after a
// later one of its session steps back in time and number, and is left out. The host clock has a delay of up to
// kLargestDelay and its own rate; a larger difference between both clocks shows a wrong unit or a restart.
#include "ingest/clock_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/text.hpp"

namespace toliman::ingest {

namespace {

constexpr double kLargestStep = 1000;  // usual steps
constexpr double kLargestDelay = 1;    // s, of a frame on its way to the host
constexpr double kLargestDrift = 0.01; // of one clock against the other
constexpr double kSharedTime = 0.05;   // of two exposures, that inaccurate time stamps may have

double step_ns(const SideLine &before, const SideLine &after) noexcept {
    return (static_cast<double>(after.stamp_ns) - static_cast<double>(before.stamp_ns)) +
           (static_cast<double>(after.clock_shift_ns) - static_cast<double>(before.clock_shift_ns));
}

// Regions of one exposure share time and frame id.
bool repeats(const SideLine &before, const SideLine &line) noexcept {
    return step_ns(before, line) == 0 && before.frame_id != line.frame_id && before.session == line.session &&
           before.roi == line.roi;
}

// A frame that arrives after a later one.
bool is_late(const SideLine &before, const SideLine &line) noexcept {
    return before.session == line.session && line.restarts <= before.restarts && step_ns(before, line) < 0 &&
           (line.restarts < before.restarts || line.frame_id < before.frame_id);
}

} // namespace

bool advances_alike(double camera_s, double host_s) noexcept {
    const double longest = std::max(std::fabs(camera_s), std::fabs(host_s));
    return !(std::fabs(camera_s - host_s) > kLargestDelay + kLargestDrift * longest);
}

void Median::add(double value) {
    upper_.push(value);
    lower_.push(upper_.top());
    upper_.pop();
    if (lower_.size() > upper_.size()) {
        upper_.push(lower_.top());
        lower_.pop();
    }
}

void ClockChecks::count(const SideLine &line) {
    const bool is_valid = line.error.empty();
    if (is_valid && counted_)
        steps_.add(std::fabs(step_ns(*counted_, line)));
    counted_ = is_valid ? std::optional<SideLine>(line) : std::nullopt;
}

std::string ClockChecks::jump(const SideLine &line, int64_t number) const {
    if (!last_ || is_late(last_->line, line))
        return "";
    const double step = step_ns(last_->line, line), usual = steps_.value();
    if (step < 0)
        return formatted("timestamp_ns goes back by %g s", -step / 1e9);
    if (repeats(last_->line, line) && !last_stands_) // reported once
        return formatted("timestamp_ns is %lld, as in the frame before", static_cast<long long>(line.stamp_ns));
    if (usual > 0 && step > kLargestStep * usual * static_cast<double>(number - last_->number))
        return formatted("timestamp_ns advances by %g s, the median step is %g s", step / 1e9, usual / 1e9);
    return "";
}

std::string ClockChecks::drift(const SideLine &line) const {
    if (!first_)
        return "";
    const double camera = step_ns(first_->line, line) / 1e9, host = line.host_s - first_->line.host_s;
    if (advances_alike(camera, host))
        return "";
    return formatted("since line %lld timestamp_ns has advanced by %g s, host_time by %g s",
                     static_cast<long long>(first_->number), camera, host);
}

std::string ClockChecks::overlap(const SideLine &line, double exposure_s) const {
    if (!last_ || last_->line.session != line.session || last_->line.roi != line.roi)
        return "";
    const double step = step_ns(last_->line, line) / 1e9;
    if (!(step > 0 && step < (1 - kSharedTime) * exposure_s))
        return "";
    return formatted("frames %lld and %lld are %g s apart, and their exposures of %g s overlap: is the length of the "
                     "exposure in s?",
                     static_cast<long long>(last_->line.frame_id), static_cast<long long>(line.frame_id), step,
                     exposure_s);
}

void ClockChecks::pass(const SideLine &line, int64_t number) {
    if (last_ && is_late(last_->line, line))
        return;
    last_stands_ = last_ && repeats(last_->line, line);
    last_ = {line, number};
    if (!first_)
        first_ = last_;
}

} // namespace toliman::ingest
