// Registry: adds frames to the sums and removes them. A frame may move the median of the chi-squares and with it the
// limit of misfits (misfit.cpp), so that earlier frames enter or leave the sums. Atomicity: what will change is read
// before the record is appended; nothing fails after that.
#include <algorithm>
#include <limits>
#include <utility>

#include "track/interval_records.hpp"
#include "track/registry.hpp"
#include "track/sample_batch.hpp"

namespace toliman::track {

// A chi-square that enters or leaves the distribution, and the frames whose states follow. Undone unless it is applied.
class Registry::LimitChange {
  public:
    enum class By { adding, removing };
    LimitChange(Registry &registry, ChiBin chi_square, By by) : registry_(registry), chi_square_(chi_square), by_(by) {
        count(by_);
        limit_ = bin_of(registry_.chi_limit());
        try {
            changes_ = registry_.changes_to(limit_);
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

    bool has_changes() const noexcept { return !changes_.empty(); }
    void apply() noexcept {
        registry_.limit_ = limit_;
        registry_.apply(changes_);
        is_applied_ = true;
    }

  private:
    void count(By by) noexcept {
        by == By::adding ? registry_.chi_squares_.add(chi_square_) : registry_.chi_squares_.remove(chi_square_);
    }
    void undo() noexcept { count(by_ == By::adding ? By::removing : By::adding); }

    Registry &registry_;
    ChiBin chi_square_, limit_ = kNoBin;
    By by_;
    std::vector<Change> changes_;
    bool is_applied_ = false;
};

ChiBin Registry::chi_square_of(const Record &record) const noexcept {
    return record.kind == Kind::accepted ? bin_of(goodness_.chi_square(record.cells)) : kNoBin;
}

// The frames whose state is another with this limit.
std::vector<Registry::Change> Registry::changes_to(ChiBin limit) const {
    const auto [low, high] = std::minmax(limit_, limit);
    std::vector<Change> changes;
    if (!chi_squares_.has_between(low, high))
        return changes;
    std::vector<KnownFrame> frames;
    index_.visit_between(low, high, [&](const KnownFrame &known) { frames.push_back(known); });
    for (const KnownFrame &known : frames) {
        const Record record = records_.read(known.record());
        Change change = {known.key, limit < limit_ ? FrameState::misfit : state_of(record), std::nullopt, {}};
        change.sample = sample_of(record, change.row);
        changes.push_back(change);
    }
    return changes;
}

void Registry::apply(const std::vector<Change> &changes) noexcept {
    for (const Change &change : changes) {
        const KnownFrame &known = *index_.find(change.key);
        if (known.state() == FrameState::quarantined)
            continue;
        count_of(known.state())--;
        count_of(change.state)++;
        set_state(known, change.state);
        if (!change.sample)
            continue;
        period::Sample sample = *change.sample;
        if (reducer_)
            sample.columns = change.row.data();
        change.state == FrameState::accepted ? sums_.push(sample) : sums_.retract(sample);
    }
}

void Registry::add_frame(const Record &record, const double *intervals, size_t interval_count) {
    index_.check_capacity();
    streams_.check_capacity(record.stream);
    Row row;
    const std::optional<period::Sample> sample = sample_of(record, row);
    LimitChange limit(*this, chi_square_of(record), LimitChange::By::adding);
    if (limit.has_changes())
        settle();
    if (records_.ledger() != nullptr && records_.columns().has_intervals())
        for (const Record &part :
             interval_records(record, intervals, interval_count, records_.columns().count(), plan_.terms.sigma))
            records_.append(part);
    const uint64_t number = records_.append(record);
    limit.apply();
    count_record(record, number);
    if (!sample || chi_square_of(record) > limit_)
        return;
    if (waiting_from_)
        waiting_++;
    else
        sums_.push(*sample);
}

// Frames that wait are a set below a limit of chi-square, as those in the sums of their ledger are: equal numbers are
// the same frames. Sums of their own are added at the end, so that a failure before changes nothing.
void Registry::settle(const period::Stream *theirs) {
    if (!waiting_from_)
        return;
    if (theirs != nullptr && theirs->totals().count == waiting_) {
        sums_.merge(*theirs);
    } else {
        period::Stream own(sums_.grid());
        SampleBatch batch(own, plan_.workers);
        records_.visit(*waiting_from_, records_.count(), [&](const Record &record, uint64_t) {
            Row row;
            if (record.kind == Kind::accepted && index_.find(key_of(record))->state() == FrameState::accepted)
                batch.push(*sample_of(record, row), row);
        });
        batch.finish();
        sums_.merge(own);
    }
    waiting_from_.reset();
    waiting_ = 0;
}

void Registry::quarantine(const KnownFrame &known, Record record) {
    settle();
    const Record original = records_.read(known.record());
    const bool was_accepted = known.state() == FrameState::accepted;
    LimitChange limit(*this, index_.chi_square(known), LimitChange::By::removing);
    record.kind = Kind::quarantined;
    record.reason = Reason::none;
    record.dropped = original.dropped; // to be subtracted from the counts
    clear_reduction(records_.columns(), record);
    count_record(record, records_.append(record));
    Row row;
    if (const std::optional<period::Sample> sample = sample_of(original, row); sample && was_accepted)
        sums_.retract(*sample);
    limit.apply();
}

// While the ledger is read; quarantined frames leave the distribution.
void Registry::count_chi_square(const Record &record) noexcept {
    const KnownFrame *known = record.kind == Kind::quarantined ? index_.find(key_of(record)) : nullptr;
    chi_squares_.add(chi_square_of(record));
    if (known != nullptr && known->state() != FrameState::quarantined)
        chi_squares_.remove(index_.chi_square(*known));
}

void Registry::begin_reading(uint64_t records) {
    states_.resize(records);
    limit_ = std::numeric_limits<ChiBin>::max(); // until all frames are known
}

void Registry::count_read(const Record &record, uint64_t number) {
    count_chi_square(record);
    count_record(record, number);
}

// When the ledger has been read without a limit.
void Registry::mark_misfits() noexcept {
    limit_ = bin_of(chi_limit());
    index_.visit_between(limit_, std::numeric_limits<ChiBin>::max(), [&](const KnownFrame &known) {
        count_of(known.state())--;
        counts_.misfit++;
        set_state(known, FrameState::misfit);
    });
}

void Registry::push_changed(uint64_t first) {
    const auto [low, high] = std::minmax(limit_before_, limit_);
    index_.visit_between(low, high, [&](const KnownFrame &known) {
        Row row;
        if (known.record() >= first)
            return;
        if (const std::optional<period::Sample> sample = sample_of(records_.read(known.record()), row))
            limit_ > limit_before_ ? sums_.push(*sample) : sums_.retract(*sample);
    });
}

void Registry::push_accepted_from(uint64_t first) {
    SampleBatch batch(sums_, plan_.workers);
    records_.visit(first, records_.count(), [&](const Record &record, uint64_t) {
        if (record.kind != Kind::accepted && record.kind != Kind::quarantined)
            return;
        const KnownFrame &known = *index_.find(key_of(record));
        Row row;
        if (record.kind == Kind::accepted && known.state() == FrameState::accepted)
            batch.push(*sample_of(record, row), row);
        if (record.kind == Kind::quarantined && known.record() < first && index_.chi_square(known) <= limit_before_)
            if (const auto sample = sample_of(records_.read(known.record()), row))
                sums_.retract(*sample);
    });
    batch.finish();
}

} // namespace toliman::track
