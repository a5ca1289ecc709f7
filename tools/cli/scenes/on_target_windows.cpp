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

} // namespace cli
