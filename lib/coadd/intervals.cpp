// Method: a sorted list. An exposure joins all intervals that it touches, so that intervals are the connected parts of
// the exposures, each made longer by the pause.
#include "coadd/intervals.hpp"

#include <algorithm>

namespace toliman::coadd {

void Intervals::touched(int64_t start, int64_t end, int64_t pause, size_t &first, size_t &behind) const noexcept {
    first = 0;
    while (first < count_ && all_[first].end + pause < start)
        first++;
    behind = first;
    while (behind < count_ && all_[behind].start <= end + pause)
        behind++;
}

bool Intervals::accepts(int64_t start, int64_t end, int64_t pause) const noexcept {
    size_t first, behind;
    touched(start, end, pause, first, behind);
    return count_ < kMostIntervals || behind > first;
}

void Intervals::add(int64_t start, int64_t end, int64_t pause) noexcept {
    size_t first, behind;
    touched(start, end, pause, first, behind);
    if (behind == first) {
        std::move_backward(all_.begin() + first, all_.begin() + count_, all_.begin() + count_ + 1);
        all_[first] = {start, end};
        count_++;
        return;
    }
    all_[first] = {std::min(start, all_[first].start), std::max(end, all_[behind - 1].end)};
    std::move(all_.begin() + behind, all_.begin() + count_, all_.begin() + first + 1);
    count_ -= behind - first - 1;
}

void Intervals::save(ByteWriter &out) const {
    out.u64(count_);
    for (size_t i = 0; i < kMostIntervals; i++) {
        out.i64(i < count_ ? all_[i].start : 0);
        out.i64(i < count_ ? all_[i].end : 0);
    }
}

void Intervals::load(ByteReader &in) {
    const uint64_t count = in.u64();
    if (count > kMostIntervals)
        fail(Status::format, "state of a sum: %llu intervals: at most %zu", static_cast<unsigned long long>(count),
             kMostIntervals);
    count_ = static_cast<size_t>(count);
    for (size_t i = 0; i < kMostIntervals; i++) {
        Interval &interval = all_[i];
        interval.start = in.i64();
        interval.end = in.i64();
        const bool good = i < count_ ? interval.start < interval.end && (i == 0 || all_[i - 1].end < interval.start)
                                     : interval.start == 0 && interval.end == 0;
        if (!good)
            fail(Status::format, "state of a sum: interval %zu from %lld to %lld ns: must follow those before", i,
                 static_cast<long long>(interval.start), static_cast<long long>(interval.end));
    }
}

} // namespace toliman::coadd
