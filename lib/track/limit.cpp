// Tracker: adds frames to the sums and removes them. A frame may move the median of the chi-squares and with it the
// limit of misfits (misfit.cpp), so that earlier frames enter or leave the sums. Atomicity: what will change is read
// before the record is appended; nothing fails after that.
#include <algorithm>
#include <utility>

#include "track/tracker.hpp"

namespace toliman::track {

// A chi-square that enters or leaves the distribution, and the frames whose states follow. Undone unless it is applied.
class Tracker::LimitChange {
  public:
    enum class By { adding, removing };
    LimitChange(Tracker &tracker, ChiBin chi_square, By by) : tracker_(tracker), chi_square_(chi_square), by_(by) {
        count(by_);
        limit_ = bin_of(tracker_.chi_limit());
        try {
            changes_ = tracker_.changes_to(limit_);
        } catch (...) {
            undo();
            throw;
        }
    }
    ~LimitChange() {
        if (!is_applied_)
            undo();
    }
    LimitChange(const LimitChange &) = delete;
    LimitChange &operator=(const LimitChange &) = delete;

    void apply() noexcept {
        tracker_.limit_ = limit_;
        tracker_.apply(changes_);
        is_applied_ = true;
    }

  private:
    void count(By by) noexcept {
        by == By::adding ? tracker_.chi_squares_.add(chi_square_) : tracker_.chi_squares_.remove(chi_square_);
    }
    void undo() noexcept { count(by_ == By::adding ? By::removing : By::adding); }

    Tracker &tracker_;
    ChiBin chi_square_, limit_ = kNoBin;
    By by_;
    std::vector<Change> changes_;
    bool is_applied_ = false;
};

ChiBin Tracker::chi_square_of(const Record &record) const noexcept {
    return record.kind == Kind::accepted ? bin_of(goodness_.chi_square(record.cells)) : kNoBin;
}

// The frames whose state is another with this limit.
std::vector<Tracker::Change> Tracker::changes_to(ChiBin limit) const {
    const auto [low, high] = std::minmax(limit_, limit);
    std::vector<Change> changes;
    if (!chi_squares_.has_between(low, high))
        return changes;
    std::vector<KnownFrame> frames;
    index_.visit_between(low, high, [&](const KnownFrame &known) { frames.push_back(known); });
    for (const KnownFrame &known : frames) {
        const Record record = read_record(known.record());
        Change change = {known.key, limit < limit_ ? FrameState::misfit : state_of(record), std::nullopt, {}};
        change.sample = sample_of(record, change.row);
        changes.push_back(change);
    }
    return changes;
}

void Tracker::apply(const std::vector<Change> &changes) noexcept {
    for (const Change &change : changes) {
        const KnownFrame &known = *index_.find(change.key);
        if (known.state() == FrameState::quarantined)
            continue;
        count_of(known.state())--;
        count_of(change.state)++;
        index_.set_state(known, change.state);
        if (!change.sample)
            continue;
        period::Sample sample = *change.sample;
        if (reducer_)
            sample.columns = change.row.data();
        change.state == FrameState::accepted ? sums_.push(sample) : sums_.retract(sample);
    }
}

void Tracker::add_frame(const Record &record, const double *intervals, size_t interval_count) {
    index_.check_capacity();
    streams_.check_capacity(record.stream);
    Row row;
    const std::optional<period::Sample> sample = sample_of(record, row);
    LimitChange limit(*this, chi_square_of(record), LimitChange::By::adding);
    if (ledger_ && columns_.has_intervals())
        for (const Record &part :
             interval_records(record, intervals, interval_count, columns_.count(), plan_.terms.sigma))
            append_record(part);
    const uint64_t number = append_record(record);
    limit.apply();
    count_record(record, number);
    if (sample && chi_square_of(record) <= limit_)
        sums_.push(*sample);
}

void Tracker::quarantine(const KnownFrame &known, Record record) {
    const Record original = read_record(known.record());
    const bool was_accepted = known.state() == FrameState::accepted;
    LimitChange limit(*this, index_.chi_square(known), LimitChange::By::removing);
    record.kind = Kind::quarantined;
    record.reason = Reason::none;
    record.dropped = original.dropped; // to be subtracted from the counts
    clear_reduction(columns_, record);
    count_record(record, append_record(record));
    Row row;
    if (const std::optional<period::Sample> sample = sample_of(original, row); sample && was_accepted)
        sums_.retract(*sample);
    limit.apply();
}

// While the ledger is read; quarantined frames leave the distribution.
void Tracker::count_chi_square(const Record &record) noexcept {
    const KnownFrame *known = record.kind == Kind::quarantined ? index_.find(key_of(record)) : nullptr;
    chi_squares_.add(chi_square_of(record));
    if (known != nullptr && known->state() != FrameState::quarantined)
        chi_squares_.remove(index_.chi_square(*known));
}

// When the ledger has been read without a limit.
void Tracker::mark_misfits() noexcept {
    limit_ = bin_of(chi_limit());
    index_.visit_between(limit_, std::numeric_limits<ChiBin>::max(), [&](const KnownFrame &known) {
        count_of(known.state())--;
        counts_.misfit++;
        index_.set_state(known, FrameState::misfit);
    });
}

// Frames of the first `first` records that have entered or left the sums by the limit since the checkpoint.
void Tracker::push_changed(uint64_t first) {
    const auto [low, high] = std::minmax(limit_before_, limit_);
    index_.visit_between(low, high, [&](const KnownFrame &known) {
        Row row;
        if (known.record() >= first)
            return;
        if (const std::optional<period::Sample> sample = sample_of(read_record(known.record()), row))
            limit_ > limit_before_ ? sums_.push(*sample) : sums_.retract(*sample);
    });
}

} // namespace toliman::track
