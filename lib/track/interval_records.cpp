// Format: a frame with n intervals is preceded by records of kind intervals. Each bears the key and the content of the
// frame, in tai_ns the number of intervals before its own, and pairs (start, end) as f64 in its columns.
// Why: records keep one size, one chain of checksums and one recovery. A crash between them leaves intervals without a
// frame, which count for nothing.
#include "track/interval_records.hpp"

#include <algorithm>

namespace toliman::track {

namespace {

bool is_same_frame(const Record &a, const Record &b) noexcept {
    return a.stream == b.stream && a.frame_id == b.frame_id && a.content == b.content;
}

} // namespace

std::vector<Record> interval_records(const Record &frame, const double *intervals, size_t count, size_t columns,
                                     double sigma) {
    const size_t pairs = columns / 2;
    std::vector<Record> records;
    for (size_t first = 0; first < count; first += pairs) {
        Record part;
        part.kind = Kind::intervals;
        part.stream = frame.stream;
        part.frame_id = frame.frame_id;
        part.content = frame.content;
        part.camera_ns = frame.camera_ns;
        part.tai_ns = static_cast<int64_t>(first);
        part.sigma = sigma;
        part.cells = {};
        for (size_t i = 0; i < 2 * std::min(pairs, count - first); i++)
            part.cells[i] = with_bits<uint64_t>(intervals[2 * first + i]);
        records.push_back(part);
    }
    return records;
}

void mark_lost_intervals(const Columns &columns, Record &record) noexcept {
    const size_t column = columns.find(name_of(OwnColumn::intervals));
    if (column < columns.count())
        record.cells[column] = static_cast<uint64_t>(kLostIntervals);
}

IntervalCollector::IntervalCollector(const Columns &columns)
    : columns_(columns.count()), count_(columns.find(name_of(OwnColumn::intervals))),
      shift_(columns.find(name_of(OwnColumn::shift_s))) {}

void IntervalCollector::add(const Record &part) {
    if (part.tai_ns == 0 || !is_same_frame(part, last_) || part.tai_ns != static_cast<int64_t>(intervals_.size() / 2)) {
        intervals_.clear();
        last_ = part;
        if (part.tai_ns != 0)
            return; // an earlier part is lost
    }
    for (size_t i = 0; i < columns_ / 2 * 2; i++)
        intervals_.push_back(with_bits<double>(part.cells[i]));
}

// A ledger of an earlier version tells only by the shift of the mean time that there were intervals.
std::vector<double> IntervalCollector::of(const Record &frame, bool &lost) const {
    const bool has_count = count_ < columns_;
    const int64_t count = has_count ? static_cast<int64_t>(frame.cells[count_]) : 0;
    lost = count < 0 || (!has_count && shift_ < columns_ && with_bits<double>(frame.cells[shift_]) != 0);
    if (lost || count == 0)
        return {};
    lost = !is_same_frame(frame, last_) || intervals_.size() / 2 < static_cast<size_t>(count);
    return lost ? std::vector<double>() : std::vector<double>(intervals_.begin(), intervals_.begin() + 2 * count);
}

} // namespace toliman::track
