#include "scenes/exposures.hpp"

namespace cli {

namespace {

int64_t ns_of(double seconds) {
    return std::llround(seconds * 1e9);
}

} // namespace

Exposures::Exposures(const SceneDefaults &scene) : path_(scene.path), length_ns_(ns_of(scene.exposure_s)) {
    for (const double seconds : scene.on_target_s)
        from_start_.push_back(ns_of(seconds));
    if (scene.on_target_file.empty())
        return;
    size_t count = 0;
    const auto read = [&](int64_t *intervals) {
        return toliman_ingest_read_on_target(scene.on_target_file.c_str(), nullptr, 0, intervals, count, &count);
    };
    toliman::check_asked(read(nullptr));
    windows_.resize(2 * count);
    toliman::check(read(windows_.data()));
}

std::vector<int64_t> Exposures::at(int64_t middle_ns) const {
    int64_t start = 0, end = 0;
    if (__builtin_sub_overflow(middle_ns, length_ns_ / 2, &start) || __builtin_add_overflow(start, length_ns_, &end))
        malformed(path_, formatted("a frame at %lld ns of TAI: its exposure must be within 64 bits",
                                   static_cast<long long>(middle_ns)));
    std::vector<int64_t> intervals;
    for (const int64_t time : from_start_)
        intervals.push_back(start + time);
    for (size_t i = 0; i < windows_.size(); i += 2)
        if (windows_[i + 1] > start && windows_[i] < end)
            intervals.insert(intervals.end(), {std::max(windows_[i], start), std::min(windows_[i + 1], end)});
    return has_intervals() ? intervals : std::vector<int64_t>{start, end};
}

} // namespace cli
