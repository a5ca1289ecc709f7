// Method: linear interpolation in 128-bit integers, rounded once to the nearest nanosecond. Doubles would resolve times
// since 1970 to 256 ns only. Integer arithmetic gives the same TAI, and hence the same sums, on every machine. Segments
// of at most 2^62 ns keep all products below 2^127; the elapsed time is split into whole segments and a remainder for
// extrapolation.
#include "track/clock.hpp"

#include <algorithm>
#include <utility>

#include "base/error.hpp"

namespace toliman::track {

namespace {

__extension__ using Quad = __int128;

// a/b rounded to nearest, ties away from zero; b > 0.
Quad rounded_ratio(Quad a, Quad b) noexcept {
    const Quad half = b / 2;
    return a >= 0 ? (a + half) / b : -((-a + half) / b);
}

} // namespace

Clock::Clock(std::vector<ClockPoint> points) : points_(std::move(points)) {
    constexpr Quad kLongest = Quad{1} << 62; // ns, 146 years
    for (size_t i = 1; i < points_.size(); i++) {
        const ClockPoint &point = points_[i], &before = points_[i - 1];
        const Quad camera = static_cast<Quad>(point.camera_ns) - before.camera_ns;
        const Quad tai = static_cast<Quad>(point.tai_ns) - before.tai_ns;
        if (camera <= 0 || tai <= 0 || camera > kLongest || tai > kLongest)
            fail(Status::argument,
                 "{clock}: point %zu (camera %lld ns, TAI %lld ns): must follow the point before by 1 to 2^62 ns", i,
                 static_cast<long long>(point.camera_ns), static_cast<long long>(point.tai_ns));
    }
    // A table that changes nothing is equivalent to none.
    const auto same = [](const ClockPoint &point) { return point.camera_ns == point.tai_ns; };
    if (std::all_of(points_.begin(), points_.end(), same))
        points_.clear();
}

std::optional<int64_t> Clock::tai_ns(int64_t camera_ns) const noexcept {
    if (points_.empty())
        return camera_ns;
    const auto later = [](int64_t time, const ClockPoint &point) { return time < point.camera_ns; };
    const auto after = std::upper_bound(points_.begin(), points_.end(), camera_ns, later) - points_.begin();
    const auto segments = static_cast<std::ptrdiff_t>(points_.size()) - 1;
    const auto segment = static_cast<size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, segments > 0 ? segments - 1 : 0));
    const ClockPoint &from = points_[segment];
    const Quad elapsed = static_cast<Quad>(camera_ns) - from.camera_ns;
    Quad moved = elapsed;
    if (segments > 0) {
        const ClockPoint &to = points_[segment + 1];
        const Quad camera = static_cast<Quad>(to.camera_ns) - from.camera_ns;
        const Quad tai = static_cast<Quad>(to.tai_ns) - from.tai_ns;
        const Quad whole = elapsed / camera, rest = elapsed % camera;
        moved = whole * tai + rounded_ratio(rest * tai, camera);
    }
    const Quad result = from.tai_ns + moved;
    if (result > INT64_MAX || result < INT64_MIN)
        return std::nullopt;
    return static_cast<int64_t>(result);
}

} // namespace toliman::track
