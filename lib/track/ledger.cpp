// Method: write-ahead log with group commit. A group of records is written and fsync'ed together, since an fsync takes
// milliseconds. Each record states how many records were durable when it was written.
// Recovery: a crash may lose unsynced records, in any order, but no durable one. Reading stops at the first invalid
// record. If a valid later record states that this one was durable, the disk has lost data: opening fails instead of
// discarding the records after it. Otherwise the tail is a torn write and is removed. A ledger shorter than its
// checkpoint counts was truncated.
// Readers keep the records that they have checked: a summary visits them ten times, and to check a million again would
// take a third of a second each time.
// Tested by simulated power cuts that drop, reorder and tear unsynced writes (tests/fault/test_power_cut.cpp).
#include "track/ledger.hpp"

#include <algorithm>
#include <cstring>

#include "base/bytes.hpp"

namespace toliman::track {

namespace {

constexpr const char *kName = LedgerFile::kName;
constexpr uint64_t kMostKept = uint64_t{1} << 30; // bytes

} // namespace

Ledger::Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, CheckpointMark mark,
               const EachRecord &each)
    : store_(store), access_(access), sync_(sync), file_(store),
      group_((sync == Sync::frame ? 1 : group) * file_.record_size()) {
    file_.check_terms(terms);
    recover(mark, each);
}

void Ledger::recover(CheckpointMark mark, const EachRecord &each) {
    const LedgerFile::Tail tail = find_end(each);
    check_checkpoint_mark(mark);
    const uint64_t size = file_.size(), end = file_.offset_of(written_);
    torn_ = size > end ? size - end : 0;
    chain_ = tail.chain;
    if (access_ == Access::read) {
        synced_ = std::max<uint64_t>(tail.synced, mark.salt == salt() ? mark.records : 0);
        return;
    }
    if (torn_ > 0)
        store_.truncate(kName, end);
    rewrite_unsynced(tail.synced);
    synced_ = written_;
}

// Scans for the end of the valid records. A concurrent writer may remove a torn tail and append meanwhile: a reader
// scans again as long as that makes progress.
LedgerFile::Tail Ledger::find_end(const EachRecord &each) {
    LedgerFile::Tail tail = file_.start();
    const bool is_kept = access_ == Access::read && file_.size() <= kMostKept;
    if (is_kept)
        kept_.reserve(file_.size());
    for (bool again = false;; again = true) {
        const uint64_t before = written_, records = file_.count();
        written_ = file_.scan(written_, records, tail, each, is_kept ? &kept_ : nullptr);
        if (written_ >= records || !file_.was_durable(written_))
            return tail;
        if (access_ == Access::write || (again && written_ == before))
            file_.fail_at(written_, Status::lost,
                          "is damaged, but later ones are valid: the disk lost acknowledged data; merge with salvage "
                          "recovers the remaining records into a new folder");
    }
}

void Ledger::check_checkpoint_mark(CheckpointMark mark) const {
    if (mark.salt != salt())
        return;
    if (written_ < mark.records)
        fail(Status::lost,
             "{%s}: %llu valid records, but the checkpoint counts %llu: records were lost; merge with salvage recovers "
             "the remaining records into a new folder",
             file_.path().c_str(), static_cast<unsigned long long>(written_),
             static_cast<unsigned long long>(mark.records));
    if (chain_before(mark.records) != mark.chain)
        fail(Status::format, "{%s}: the first %llu records are not those that the checkpoint counts",
             file_.path().c_str(), static_cast<unsigned long long>(mark.records));
}

// Rewrites and syncs the records that are not known to be durable. Records that could be read may exist in the page
// cache only, and after a failed fsync the kernel marks their pages clean, so that another fsync alone would not write
// them.
void Ledger::rewrite_unsynced(uint64_t first) {
    std::vector<uint8_t> chunk(LedgerFile::kChunk * file_.record_size());
    for (uint64_t number = first; number < written_; number += LedgerFile::kChunk) {
        const size_t size = std::min<uint64_t>(LedgerFile::kChunk, written_ - number) * file_.record_size();
        read_all(store_, kName, file_.offset_of(number), chunk.data(), size);
        store_.write(kName, file_.offset_of(number), chunk.data(), size);
    }
    store_.sync(kName);
}

void Ledger::visit(uint64_t first, uint64_t most, const EachRecord &each) const {
    if (first >= count())
        return;
    const uint64_t end = first + std::min(most, count() - first);
    uint64_t number = visit_kept(first, end, each);
    if (number == end)
        return;
    LedgerFile::Tail tail = {chain_before(number), 0};
    number = file_.scan(number, std::min(end, written_), tail, each);
    if (number < std::min(end, written_))
        file_.fail_at(number, Status::format, "is damaged");
    for (; number < end; number++)
        each(read(number), number);
}

// Returns the number of the first record that was not kept, or `end`.
uint64_t Ledger::visit_kept(uint64_t first, uint64_t end, const EachRecord &each) const {
    const size_t size = file_.record_size();
    const uint64_t last = std::min(end, kept_.size() / size);
    for (; first < last; first++)
        each(decoded(kept_.data() + first * size, columns().count()), first);
    return first;
}

void Ledger::check_not_failed() const {
    if (failed_)
        fail(Status::write, "{%s}: an earlier write failed: reopen the folder", file_.path().c_str());
}

void Ledger::append(const Record &record) {
    check_not_failed();
    if (count() == LedgerFile::kMaxRecords)
        fail(Status::capacity, "{%s}: is full: holds 2^29 records", file_.path().c_str());
    const uint32_t chain = to_bytes(record, columns().count(), static_cast<uint32_t>(synced_), chain_,
                                    group_.data() + waiting_ * file_.record_size());
    if ((waiting_ + 1) * file_.record_size() == group_.size()) {
        check();
        write(waiting_ + 1);
    } else {
        waiting_++;
    }
    chain_ = chain;
}

void Ledger::commit() {
    check();
    if (waiting_ > 0)
        write(waiting_);
}

// Fails if another program changed the file: a writer that the lock does not exclude, as after a copy of the folder
// replaced it, would overwrite these records, and records written to an unlinked file are lost.
void Ledger::check() const {
    check_not_failed();
    store_.check_unchanged(kName, file_.offset_of(written_));
}

void Ledger::sync() {
    commit();
    if (synced_ == written_)
        return;
    failed_ = true;
    store_.sync(kName);
    failed_ = false;
    synced_ = written_;
}

// Writes the group and empties it.
void Ledger::write(uint64_t records) {
    failed_ = true; // the state of the file after a failed write or fsync is unknown
    store_.write(kName, file_.offset_of(written_), group_.data(), records * file_.record_size());
    if (sync_ != Sync::none)
        store_.sync(kName);
    failed_ = false;
    written_ += records;
    waiting_ = 0;
    if (sync_ != Sync::none)
        synced_ = written_;
}

void Ledger::raw_record(uint64_t number, uint8_t *bytes) const {
    if (number >= written_)
        std::memcpy(bytes, group_.data() + (number - written_) * file_.record_size(), file_.record_size());
    else
        file_.read(number, bytes);
}

uint32_t Ledger::chain_before(uint64_t number) const {
    if (number == 0)
        return file_.start().chain;
    uint8_t bytes[kMaxRecordSize];
    raw_record(number - 1, bytes);
    return file_.checksum_in(bytes);
}

Record Ledger::read(uint64_t number) const {
    uint8_t bytes[kMaxRecordSize];
    LedgerFile::Tail tail = {chain_before(number), 0};
    raw_record(number, bytes);
    return file_.record(bytes, number, tail);
}

} // namespace toliman::track
