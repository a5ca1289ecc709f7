// Ledger open for appending: an append-only log of what was decided about every frame, in order of arrival.
#pragma once
#include <cstdint>

#include "base/buffer.hpp"
#include "track/ledger_file.hpp"

namespace toliman::track {

// Durability: when records are fsync'ed. A frame is acknowledged once its record is.
enum class Sync { group, frame, none };

// Position of a checkpoint in the ledger with this salt: number of records counted, and checksum of the last one.
struct CheckpointMark {
    uint64_t salt = 0, records = 0;
    uint32_t chain = 0;
};

class Ledger {
  public:
    // Opens the ledger in the store, which must be locked for writing, and passes every valid record to `each`. With
    // Access::write, an incomplete tail, as a crash leaves it, is removed. Before that fails with Status::mismatch for
    // other terms, Status::lost if a durable record is damaged or a record that the checkpoint counts is missing, and
    // Status::format for a damaged header or an impossible record.
    Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, CheckpointMark mark,
           const EachRecord &each);

    // Passes the records from number `first` to `each`, at most `most`.
    void visit(uint64_t first, uint64_t most, const EachRecord &each) const;

    // Fails with Status::write after a failed write, with Status::lost if the file was removed, renamed, replaced or
    // changed by another program.
    void check() const;
    // Appends a record; commits when the group is full. Does not allocate.
    void append(const Record &record);
    // Checks the file, writes all records and syncs them unless Sync::none. After a failed write nothing can be
    // appended.
    void commit();
    // Likewise, and syncs in any case.
    void sync();
    Record read(uint64_t number) const;

    uint64_t count() const noexcept { return written_ + waiting_; }
    // Number of acknowledged records (with Sync::none: written). With Access::read: records known to be fsync'ed from
    // the ledger and the checkpoint.
    uint64_t committed() const noexcept { return access_ == Access::read ? synced_ : written_; }
    const Columns &columns() const noexcept { return file_.columns(); }
    uint64_t salt() const noexcept { return file_.salt(); } // unique to this file
    // Number of bytes after the last valid record when the ledger was opened.
    uint64_t torn() const noexcept { return torn_; }
    // Checksum of the record before `number`; of the header for 0.
    uint32_t chain_before(uint64_t number) const;

  private:
    void recover(CheckpointMark mark, const EachRecord &each);
    LedgerFile::Tail find_end(const EachRecord &each);
    void check_checkpoint_mark(CheckpointMark mark) const;
    void rewrite_unsynced(uint64_t first);
    uint64_t visit_kept(uint64_t first, uint64_t end, const EachRecord &each) const;
    void check_not_failed() const;
    void write(uint64_t records);
    void raw_record(uint64_t number, uint8_t *bytes) const;

    Store &store_;
    Access access_;
    Sync sync_;
    LedgerFile file_;
    Buffer<uint8_t> group_; // records not yet written
    // With Access::read: the records that were valid when the ledger was opened, unless they take more than 1 GiB.
    std::vector<uint8_t> kept_;
    uint64_t written_ = 0, synced_ = 0, waiting_ = 0, torn_ = 0;
    uint32_t chain_ = 0;
    bool failed_ = false;
};

} // namespace toliman::track
