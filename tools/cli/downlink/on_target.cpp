// Method: the windows are converted from TAI to the camera clock once, by the inverse of the clock table: straight
// lines, with the nearest one beyond both ends. The intervals of a frame are part of its content, so that they must be
// the same on every machine: the conversion is exact in 128-bit integers, rounded down to a nanosecond, and seconds are
// the quotient of two numbers that are exact. A binary search finds the windows of a frame.
#include "downlink/on_target.hpp"

#include "scenes/exposures.hpp"

namespace cli {

namespace {

__extension__ using Wide = __int128;

constexpr double kMostCut = 0.2;   // of exposures, whose successors may be lost
constexpr double kLeastTime = 0.9; // of the shortest time of another exposure in the windows

struct ClockPair {
    int64_t camera_ns, tai_ns;
};

// The nearest number of 64 bits.
int64_t clamped(Wide ns) {
    return static_cast<int64_t>(std::clamp<Wide>(ns, INT64_MIN, INT64_MAX));
}

// Rounded down, for a positive divisor.
Wide quotient(Wide dividend, Wide divisor) {
    const Wide towards_zero = dividend / divisor;
    return towards_zero - (dividend % divisor < 0 ? 1 : 0);
}

// Pairs are at most 2^62 apart, and two times 2^64: the product has at most 127 bits.
int64_t camera_time(int64_t tai_ns, const std::vector<ClockPair> &clock) {
    if (clock.empty())
        return tai_ns;
    const auto later = [](int64_t time, const ClockPair &pair) { return time < pair.tai_ns; };
    const auto after = std::upper_bound(clock.begin(), clock.end(), tai_ns, later) - clock.begin();
    const auto last = static_cast<std::ptrdiff_t>(clock.size()) - 1;
    const auto segment = std::clamp<std::ptrdiff_t>(after - 1, 0, std::max<std::ptrdiff_t>(last - 1, 0));
    const ClockPair &from = clock[static_cast<size_t>(segment)];
    Wide elapsed = Wide{tai_ns} - from.tai_ns;
    if (last > 0) {
        const ClockPair &to = clock[static_cast<size_t>(segment) + 1];
        elapsed = quotient(elapsed * (Wide{to.camera_ns} - from.camera_ns), Wide{to.tai_ns} - from.tai_ns);
    }
    return clamped(from.camera_ns + elapsed);
}

// Of its exposure, whose middle may be any number of 64 bits.
Wide start_of(const toliman_frame &frame) {
    return Wide{frame.camera_ns} - std::llround(frame.exposure_s * 5e8);
}

Wide end_of(const toliman_frame &frame) {
    return start_of(frame) + std::llround(frame.exposure_s * 1e9);
}

} // namespace

OnTarget::OnTarget(const std::string &path, const LeapSeconds &leap_seconds) : path_(path) {
    for (const TargetWindow &window : read_on_target(path, leap_seconds))
        windows_.push_back({window.start_ns, window.end_ns, false, false});
}

void OnTarget::set_clock(const toliman_track_options &settings, const std::string &scene) {
    exposure_s_ = settings.frames.exposure_s;
    scene_ = scene;
    if (!(exposure_s_ > 0))
        throw Failure(kExitUsage, "--on-target " + path_ +
                                      ": needs the length of an exposure: give a new folder with --exposure SECONDS");
    std::vector<ClockPair> clock(settings.clock.count);
    for (size_t i = 0; i < clock.size(); i++)
        clock[i] = {settings.clock.pairs[2 * i], settings.clock.pairs[2 * i + 1]};
    for (Window &window : windows_)
        window = {camera_time(window.start_ns, clock), camera_time(window.end_ns, clock), false, false};
}

// Frames come with the time that the windows leave them.
void OnTarget::mark_cut(const toliman_frame &frame) {
    const Wide start = start_of(frame), end = end_of(frame);
    const bool begins = windows_.front().start_ns > start && windows_.front().start_ns < end;
    const bool ends = windows_.back().end_ns > start && windows_.back().end_ns < end;
    double seconds = 0;
    for (size_t i = 0; i < frame.interval_count; i++)
        seconds += frame.intervals[2 * i + 1] - frame.intervals[2 * i];
    if (!begins && !ends) {
        least_s_ = seconds > 0 ? std::min(least_s_, seconds) : least_s_;
        return;
    }
    if (!cut_.empty() && seconds >= cut_s_)
        return;
    cut_s_ = seconds;
    cut_ = path_ + (begins ? ": begins" : ": ends") + " in the exposure of frame " + std::to_string(frame.frame_id) +
           " of session " + frame.session + ": the time " + (begins ? "before its first" : "after its last") +
           " window counts as off target";
}

// The telescope need not point at the stars until the end of the last exposure.
void OnTarget::warn_of_cut(Progress &progress) const {
    if (!cut_.empty() && std::isfinite(least_s_) && cut_s_ < kLeastTime * least_s_)
        progress.warn(cut_);
}

void OnTarget::mark_end(const toliman_frame &frame) {
    const Wide start = start_of(frame), end = end_of(frame);
    const auto before = [](const Window &window, Wide time) { return window.end_ns <= time; };
    const auto first = std::lower_bound(windows_.begin(), windows_.end(), start, before);
    const auto last = std::lower_bound(windows_.begin(), windows_.end(), end, before);
    if (first != windows_.end() && first->start_ns < start)
        first->is_continued = true;
    for (auto window = first; window != last; ++window)
        window->is_continued = window->is_continued || window->start_ns >= start;
    const bool ends_inside = last != windows_.end() && last->start_ns < end;
    if (last - first + (ends_inside ? 1 : 0) < 2)
        return; // one window
    sums_++;
    if (last == windows_.end())
        return;
    Wide pause = 0;
    for (auto window = first + 1; window != last; ++window)
        pause = std::max(pause, Wide{window->start_ns} - (window - 1)->end_ns);
    if (ends_inside || Wide{last->start_ns} - (last - 1)->end_ns <= pause)
        last->is_cut = true;
}

// The exposure of a scene without on-target intervals may be the time on target alone, which is shorter than the time
// from start to end: such an exposure is accepted only without any pause.
void OnTarget::check_length(const toliman_frame &frame) const {
    const Wide start = start_of(frame), end = end_of(frame);
    const auto inside = [&](const Window &window) { return window.start_ns <= start && window.end_ns >= end; };
    const auto touches = [&](const Window &window) { return window.start_ns < end && window.end_ns > start; };
    if (std::any_of(windows_.begin(), windows_.end(), inside) ||
        std::none_of(windows_.begin(), windows_.end(), touches))
        return;
    throw Failure(kExitUsage,
                  "--on-target " + path_ + ": the exposure of frame " + std::to_string(frame.frame_id) +
                      formatted(", %g s by cadence.exposure_s of ", frame.exposure_s) + scene_ +
                      ", is not inside one window: give a new folder with --exposure SECONDS, the time from "
                      "the start to the end of an exposure, or a scene with cadence.on_target_s");
}

void OnTarget::conclude(Progress &progress) const {
    warn_of_cut(progress);
    const auto cut = std::count_if(windows_.begin(), windows_.end(),
                                   [](const Window &window) { return window.is_cut && !window.is_continued; });
    if (static_cast<double>(cut) > kMostCut * static_cast<double>(sums_))
        progress.warn(path_ + ": the telescope still points at the stars after the end of " + std::to_string(cut) +
                      " of " + std::to_string(sums_) + " exposures: is --exposure right?");
}

bool OnTarget::limit(toliman_frame &frame, std::vector<double> &intervals) {
    if (!(frame.exposure_s > 0))
        frame.exposure_s = exposure_s_;
    if (!scene_.empty() && frame.exposure_s == exposure_s_ && frame.interval_count == 0)
        check_length(frame);
    mark_end(frame);
    const double whole[] = {0, frame.exposure_s};
    const double *const own = frame.interval_count > 0 ? frame.intervals : whole;
    const auto seconds = [start = start_of(frame)](int64_t ns) { return static_cast<double>(ns - start) / 1e9; };
    for (size_t i = 0; i < std::max<size_t>(frame.interval_count, 1); i++) {
        const double from = own[2 * i], to = own[2 * i + 1];
        auto window = std::partition_point(windows_.begin(), windows_.end(),
                                           [&](const Window &each) { return seconds(each.end_ns) <= from; });
        for (; window != windows_.end() && seconds(window->start_ns) < to; ++window) {
            const double start = std::max(from, seconds(window->start_ns)), end = std::min(to, seconds(window->end_ns));
            if (start < end)
                intervals.insert(intervals.end(), {start, end});
        }
    }
    frame.intervals = intervals.data();
    frame.interval_count = intervals.size() / 2;
    mark_cut(frame);
    return !intervals.empty();
}

std::string OnTarget::complaint(const toliman_frame &frame) const {
    const int64_t start = clamped(start_of(frame)), end = clamped(end_of(frame));
    return "no window of " + path_ + " contains on-target time of frame " + std::to_string(frame.frame_id) +
           ", exposed from " + std::to_string(start) + " to " + std::to_string(end) + " ns of camera time";
}

} // namespace cli
