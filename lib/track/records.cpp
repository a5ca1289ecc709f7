// Method: write-ahead log. The ledger holds one record per decision about a frame; index, counts and sums are derived
// from it.
#include "track/records.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "track/interval_records.hpp"

namespace toliman::track {

namespace {

constexpr std::chrono::seconds kCommitInterval{1}; // of records that wait for a full group

} // namespace

Records::Records(const Plan &plan, std::unique_ptr<Store> store, Access access)
    : plan_(plan), store_(std::move(store)), access_(access), columns_(plan.columns) {
    if (!store_) // no page is touched yet
        memory_.reserve(static_cast<size_t>(plan_.capacity) * record_size(columns_.count()));
}

void Records::open(uint64_t salt, CheckpointMark mark, const EachRecord &each) {
    salt_ = salt;
    marks_[salt_].salt = salt_;
    ledger_.emplace(*store_, access_, plan_.terms, plan_.group, plan_.sync, mark, each);
}

void Records::open_names() {
    names_.emplace(*store_);
    if (access_ == Access::write)
        names_->begin();
}

uint64_t Records::append(const Record &record) {
    if (ledger_) {
        ledger_->append(record);
        return ledger_->count() - 1;
    }
    if (record.kind == Kind::accepted || record.kind == Kind::outlier) {
        memory_.resize(memory_.size() + record_size(columns_.count()));
        to_bytes(record, columns_.count(), 0, 0, &memory_[memory_.size() - record_size(columns_.count())]);
    }
    return count() - 1;
}

Record Records::read(uint64_t number) const {
    if (ledger_)
        return ledger_->read(number);
    Record record;
    uint32_t synced, chain = 0;
    from_bytes(memory_.data() + number * record_size(columns_.count()), columns_.count(), record, synced, chain);
    return record;
}

void Records::visit(uint64_t first, uint64_t most, const EachRecord &each) const {
    if (ledger_)
        return ledger_->visit(first, most, each);
    for (uint64_t number = first; number < count() && number - first < most; number++)
        each(read(number), number);
}

std::vector<double> Records::intervals_of(uint64_t number) const {
    if (!ledger_)
        fail(Status::state, "a tracker in memory keeps no intervals");
    const size_t column = columns_.find(name_of(OwnColumn::intervals)), pairs = columns_.count() / 2;
    const Record frame = ledger_->read(number);
    const auto count = column < columns_.count() ? static_cast<int64_t>(frame.cells[column]) : 0;
    const uint64_t parts = count > 0 ? (static_cast<uint64_t>(count) + pairs - 1) / pairs : 0;
    IntervalCollector collector(columns_);
    for (uint64_t part = number - std::min(parts, number); part < number; part++)
        if (const Record record = ledger_->read(part); record.kind == Kind::intervals)
            collector.add(record);
    bool lost = false;
    std::vector<double> intervals = collector.of(frame, lost);
    if (lost && frame.kind != Kind::intervals)
        fail(Status::lost, "{%s}: record %llu: its on-target intervals are lost",
             store_->path(LedgerFile::kName).c_str(), static_cast<unsigned long long>(number));
    return intervals;
}

MergeMark Records::last_merge_of(uint64_t salt) const noexcept {
    const auto found = marks_.find(salt);
    if (found != marks_.end())
        return found->second;
    MergeMark none;
    none.salt = salt;
    return none;
}

// Appends a mark with the number of repeated frames so far: these have no records of their own.
void Records::record_repeats() {
    if (!ledger_ || unrecorded_repeats_ == 0 || count() == LedgerFile::kMaxRecords)
        return;
    ledger_->check();
    MergeMark &own = marks_.at(salt_);
    const int64_t repeats = std::min(own.repeats + unrecorded_repeats_, kMaxRepeats);
    const MergeMark mark = {salt_, static_cast<int64_t>(count()), repeats, ledger_->chain_before(count())};
    ledger_->append(to_record(mark, plan_.terms.sigma, columns_.empty()));
    own = mark;
    unrecorded_repeats_ = 0;
}

void Records::check_writable() const {
    if (access_ == Access::read)
        fail(Status::state, "{%s}: opened read-only", store_->path("").c_str());
}

bool Records::has_uncommitted() const noexcept {
    return ledger_ && (count() > committed() || unrecorded_repeats_ > 0);
}

void Records::begin_waiting() noexcept {
    if (!has_uncommitted())
        oldest_ = std::chrono::steady_clock::now();
}

void Records::commit_if_due() {
    if (has_uncommitted() && std::chrono::steady_clock::now() - oldest_ >= kCommitInterval)
        commit();
}

void Records::commit() {
    check_writable();
    record_repeats();
    if (ledger_)
        ledger_->commit();
}

} // namespace toliman::track
