// On-target intervals of a frame, in records that precede its own.
#pragma once
#include <cstddef>
#include <vector>

#include "track/columns.hpp"
#include "track/record.hpp"

namespace toliman::track {

// Records of the intervals, pairs (start, end) in s, for a ledger with this number of columns. `frame`: the record that
// will follow.
std::vector<Record> interval_records(const Record &frame, const double *intervals, size_t count, size_t columns,
                                     double sigma);

// States in the record of a frame that it came with intervals, which are lost.
void mark_lost_intervals(const Columns &columns, Record &record) noexcept;

// Collects the intervals of each frame from the records of a ledger, in order.
class IntervalCollector {
  public:
    explicit IntervalCollector(const Columns &columns);
    void add(const Record &part); // of kind intervals
    // The intervals of a frame; empty if it came without. Sets `lost` if the frame came with intervals that are lost.
    std::vector<double> of(const Record &frame, bool &lost) const;

  private:
    size_t columns_, count_, shift_; // number of columns; indices of those columns
    Record last_;                    // frame of the collected parts
    std::vector<double> intervals_;
};

} // namespace toliman::track
