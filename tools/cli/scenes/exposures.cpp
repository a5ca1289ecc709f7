#include "scenes/exposures.hpp"

namespace cli {

namespace {

int64_t ns_of(double seconds) {
    return std::llround(seconds * 1e9);
}

} // namespace

std::vector<TargetWindow> read_on_target(const std::string &path, const LeapSeconds &leap_seconds) {
    size_t count = 0;
    const auto read = [&](int64_t *intervals) {
        return toliman_ingest_read_on_target(path.c_str(), leap_seconds.rows.data(), leap_seconds.rows.size(),
                                             intervals, count, &count);
    };
    toliman::check_asked(read(nullptr));
    std::vector<int64_t> times(2 * count);
    toliman::check(read(times.data()));
    std::vector<TargetWindow> windows(count);
    for (size_t i = 0; i < count; i++)
        windows[i] = {times[2 * i], times[2 * i + 1]};
    return windows;
}

std::vector<int64_t> parts_of(const std::vector<TargetWindow> &windows, int64_t start_ns, int64_t end_ns) {
    std::vector<int64_t> parts;
    auto window = std::partition_point(windows.begin(), windows.end(),
                                       [&](const TargetWindow &one) { return one.end_ns <= start_ns; });
    for (; window != windows.end() && window->start_ns < end_ns; ++window)
        parts.insert(parts.end(), {std::max(start_ns, window->start_ns), std::min(end_ns, window->end_ns)});
    return parts;
}

SceneExposures::SceneExposures(const SceneDefaults &scene) : path_(scene.path), length_ns_(ns_of(scene.exposure_s)) {
    for (const double seconds : scene.on_target_s)
        from_start_.push_back(ns_of(seconds));
    if (!scene.on_target_file.empty())
        windows_ = read_on_target(scene.on_target_file, LeapSeconds());
}

std::vector<int64_t> SceneExposures::at(int64_t middle_ns) const {
    int64_t start = 0, end = 0;
    if (__builtin_sub_overflow(middle_ns, length_ns_ / 2, &start) || __builtin_add_overflow(start, length_ns_, &end))
        malformed(path_, formatted("a frame at %lld ns of TAI: its exposure must be within 64 bits",
                                   static_cast<long long>(middle_ns)));
    if (!has_intervals())
        return {start, end};
    std::vector<int64_t> intervals = parts_of(windows_, start, end);
    for (const int64_t time : from_start_)
        intervals.push_back(start + time);
    return intervals;
}

} // namespace cli
