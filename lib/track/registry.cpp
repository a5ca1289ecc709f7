// Order independence: the sums are exact (period/stream/stream.cpp), and the verdict of a frame depends on its bytes
// and on those of frames with the same key only. Two payloads of one key quarantine the key, and the accepted sample is
// retracted exactly, so that it does not matter which payload came first.
// Atomicity: a record is appended before index, counts and sums change; a failure before that leaves them unchanged.
#include "track/registry.hpp"

#include <cmath>

#include "base/error.hpp"

namespace toliman::track {

Registry::Registry(const Plan &plan, Records &records, period::Stream &sums)
    : plan_(plan), records_(records), sums_(sums), index_(plan.capacity), streams_(plan.capacity),
      limit_(bin_of(chi_limit())), goodness_(records.columns()) {}

void Registry::set_columns() {
    goodness_ = GoodnessColumns(records_.columns());
}

void Registry::set_reducer(const std::string &ledger) {
    reducer_.emplace(records_.columns(), plan_.reference, plan_.errors, ledger);
}

bool Registry::knows(uint64_t key, uint32_t content) const noexcept {
    const KnownFrame *known = index_.find(key);
    return known != nullptr && known->content == content;
}

bool Registry::covers(int64_t tai_ns) const noexcept {
    return sums_.covers(sums_.sample_ns(tai_ns, 0, plan_.terms.sigma));
}

std::optional<period::Sample> Registry::sample_of(const Record &record, Row &row) const noexcept {
    const std::optional<int64_t> tai_ns = plan_.clock.tai_ns(record.camera_ns);
    const double value = value_of(record);
    if (record.kind != Kind::accepted || !tai_ns || !(std::fabs(value) <= plan_.terms.value_limit))
        return std::nullopt;
    period::Sample sample = sums_.sample_ns(*tai_ns, value, record.sigma);
    if (reducer_) {
        row = reducer_->row(record);
        sample.columns = row.data();
    }
    return sums_.covers(sample) ? std::optional(sample) : std::nullopt;
}

// Unless it is a misfit.
FrameState Registry::state_of(const Record &record) const noexcept {
    if (record.kind == Kind::accepted && std::isnan(value_of(record)))
        return FrameState::unreduced;
    Row row;
    return sample_of(record, row) ? FrameState::accepted : FrameState::outlier;
}

int64_t &Registry::count_of(FrameState state) noexcept {
    return state == FrameState::accepted    ? counts_.accepted
           : state == FrameState::unreduced ? counts_.unreduced
           : state == FrameState::misfit    ? counts_.misfit
                                            : counts_.outlier;
}

void Registry::count_repeats(int64_t count) noexcept {
    counts_.received += count;
    counts_.repeated += count;
    records_.add_repeats(count);
}

void Registry::count_record(const Record &record, uint64_t number) {
    if (record.kind == Kind::intervals)
        return;
    if (record.kind == Kind::merged)
        return count_merge_mark(merge_mark_of(record));
    if (record.kind == Kind::rejected)
        counts_.rejected[static_cast<size_t>(record.reason)]++;
    else if (record.kind == Kind::quarantined)
        count_quarantine(record, number);
    else
        count_frame(record, number);
    counts_.received++;
}

// A valid frame whose time the sums do not cover counts as an outlier: with another grid or clock it may be accepted.
void Registry::count_frame(const Record &record, uint64_t number) {
    index_.check_capacity();
    streams_.check_capacity(record.stream);
    const ChiBin chi_square = chi_square_of(record);
    const FrameState state = chi_square > limit_ ? FrameState::misfit : state_of(record);
    if (index_.find(key_of(record)) != nullptr)
        fail(Status::format, "{%s}: record %llu: duplicate frame", records_.path(LedgerFile::kName).c_str(),
             static_cast<unsigned long long>(number));
    index_.add(key_of(record), record.content, number, state, chi_square);
    if (number < states_.size())
        states_[number] = state;
    streams_.add(record.stream, record.frame_id);
    count_of(state)++;
    counts_.dropped += record.dropped;
}

void Registry::count_quarantine(const Record &record, uint64_t number) {
    const KnownFrame *known = index_.find(key_of(record));
    if (known == nullptr || known->state() == FrameState::quarantined)
        fail(Status::format, "{%s}: record %llu: quarantines an unknown frame",
             records_.path(LedgerFile::kName).c_str(), static_cast<unsigned long long>(number));
    count_of(known->state())--;
    counts_.quarantined++;
    counts_.repeated++;
    counts_.dropped -= record.dropped;
    set_state(*known, FrameState::quarantined);
}

void Registry::count_merge_mark(const MergeMark &merged) {
    const int64_t repeats = merged.repeats - records_.last_merge_of(merged.salt).repeats;
    if (counts_.repeated + repeats > 2 * kMaxRepeats)
        fail(Status::format, "{%s}: impossible counts of merged records", records_.path(LedgerFile::kName).c_str());
    records_.set_mark(merged); // first, since it may run out of memory
    counts_.received += repeats;
    counts_.repeated += repeats;
}

void Registry::register_frame(const Record &record, const Frame &frame, Outcome &outcome) {
    if (record.kind == Kind::rejected) {
        outcome.verdict = Verdict::rejected;
        return count_record(record, records_.append(record));
    }
    const KnownFrame *known = index_.find(key_of(record));
    if (known == nullptr) {
        add_frame(record, frame.intervals, frame.interval_count);
        const Outcome estimated = outcome; // not in the record of every ledger
        outcome = outcome_of(record, records_.count() - 1);
        outcome.goodness = estimated.goodness;
        outcome.bad_pixels = estimated.bad_pixels;
        return;
    }
    const bool quarantined = known->state() == FrameState::quarantined;
    if (!quarantined && known->content != record.content) {
        outcome.verdict = Verdict::quarantined;
        return quarantine(*known, record);
    }
    outcome.verdict = quarantined ? Verdict::quarantined : Verdict::duplicate;
    count_repeats(1);
}

void Registry::set_state(const KnownFrame &known, FrameState state) noexcept {
    index_.set_state(known, state);
    if (known.record() < states_.size())
        states_[known.record()] = state;
}

Outcome Registry::outcome_of(const Record &record, uint64_t number) const {
    Outcome outcome;
    outcome.flaw.reason = record.reason;
    outcome.tai_ns = plan_.clock.tai_ns(record.camera_ns).value_or(record.tai_ns);
    outcome.value = record.value;
    if (record.kind != Kind::accepted && record.kind != Kind::outlier && record.kind != Kind::quarantined)
        return outcome;
    outcome.goodness = goodness_.goodness(record.cells);
    outcome.bad_pixels = goodness_.bad_pixels(record.cells);
    outcome.sigma = record.sigma;
    if (const double value = value_of(record); std::isfinite(value))
        outcome.value = value;
    switch (record.kind != Kind::quarantined && number < states_.size() ? states_[number]
                                                                        : index_.find(key_of(record))->state()) {
    case FrameState::accepted:
        outcome.verdict = Verdict::accepted;
        break;
    case FrameState::unreduced:
        outcome.verdict = Verdict::unreduced;
        break;
    case FrameState::outlier:
        outcome.verdict = Verdict::outlier;
        break;
    case FrameState::misfit:
        outcome.verdict = Verdict::misfit;
        break;
    default:
        outcome.verdict = Verdict::quarantined;
    }
    return outcome;
}

} // namespace toliman::track
