// Clock: camera nanoseconds -> TAI nanoseconds by linear interpolation in a table, in exact integer arithmetic.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace toliman::track {

struct ClockPoint {
    int64_t camera_ns, tai_ns;
    bool operator==(const ClockPoint &other) const noexcept {
        return camera_ns == other.camera_ns && tai_ns == other.tai_ns;
    }
};

class Clock {
  public:
    // No points: TAI equals the camera's time. One: a constant offset. Two or more: camera and TAI times must both
    // increase (Status::argument); before the first and after the last point the nearest segment is extrapolated.
    explicit Clock(std::vector<ClockPoint> points = {});
    // Returns none if the result does not fit in 64 bits.
    std::optional<int64_t> tai_ns(int64_t camera_ns) const noexcept;
    const std::vector<ClockPoint> &points() const noexcept { return points_; }

  private:
    std::vector<ClockPoint> points_;
};

} // namespace toliman::track
