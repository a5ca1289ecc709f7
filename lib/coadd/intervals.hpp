// Intervals of time that cover all exposures of a sum.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/bytes.hpp"

namespace toliman::coadd {

constexpr size_t kMostIntervals = 64; // as many as a line of a side file has

class Intervals {
  public:
    // Whether add() has place for an exposure.
    bool accepts(int64_t start, int64_t end, int64_t pause) const noexcept;
    // Adds an exposure, ns; exposures that are less than `pause` apart are in one interval. The result does not depend
    // on the order.
    void add(int64_t start, int64_t end, int64_t pause) noexcept;
    void clear() noexcept { count_ = 0; }

    struct Interval {
        int64_t start, end;
    };
    size_t count() const noexcept { return count_; }
    const Interval &operator[](size_t i) const noexcept { return all_[i]; }
    int64_t first() const noexcept { return all_[0].start; }
    int64_t last() const noexcept { return all_[count_ - 1].end; }
    void save(ByteWriter &out) const;
    void load(ByteReader &in);

  private:
    void touched(int64_t start, int64_t end, int64_t pause, size_t &first, size_t &behind) const noexcept;

    std::array<Interval, kMostIntervals> all_ = {};
    size_t count_ = 0;
};

} // namespace toliman::coadd
