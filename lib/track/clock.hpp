// Camera nanoseconds -> TAI nanoseconds: a table of pairs, straight lines between them, exact to the rounding of the
// last nanosecond and therefore the same on every machine.
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
    // No points: TAI is the camera's time. One: a constant difference. Two and more: camera and TAI times must both
    // rise (Status::argument); before the first and after the last the nearest line goes on.
    explicit Clock(std::vector<ClockPoint> points = {});
    // None where the result does not fit in 64 bits.
    std::optional<int64_t> tai_ns(int64_t camera_ns) const noexcept;
    const std::vector<ClockPoint> &points() const noexcept { return points_; }

  private:
    std::vector<ClockPoint> points_;
};

} // namespace toliman::track
