#include "scenes/on_target_windows.hpp"

namespace cli {

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

} // namespace cli
