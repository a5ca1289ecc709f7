// The ledger: what became of every frame, in the order of arrival; lines are only ever added.
#pragma once
#include <cstdint>

#include "base/buffer.hpp"
#include "track/ledger_file.hpp"

namespace toliman::track {

// When lines are brought to the disk; until then a frame is not acknowledged.
enum class Sync { group, frame, none };

// Lines that a checkpoint holds of the ledger with this salt, and the checksum of the last of them.
struct Held {
    uint64_t salt = 0, lines = 0;
    uint32_t chain = 0;
};

class Ledger {
  public:
    // Takes up the ledger in the store, which is locked for writing, and hands every line that is whole to each. What
    // a crash tore off behind the last one is cut away, when writing. Status::mismatch for other terms; Status::format,
    // before anything is cut, for a header or a line that is damaged though the disk had it, lines that were held and
    // are lost, and lines that cannot be.
    Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, Held held, const EachLine &each);

    // Lines from `first` on once more, `most` at the most.
    void visit(uint64_t first, uint64_t most, const EachLine &each) const;

    // Status::write after a write that failed, and if the file was removed, renamed, replaced or changed by another.
    void check() const;
    // Adds a line; commits when the group is full. Allocates nothing.
    void append(const Record &record);
    // Checks, and brings all lines to the disk, as sync says. After a failed write the ledger takes no more.
    void commit();
    // The same whatever sync says.
    void sync();
    Record read(uint64_t number) const;

    uint64_t count() const noexcept { return written_ + waiting_; }
    // Acknowledged, as far as sync goes; of a ledger that is only read, those that it tells itself to be on the disk.
    uint64_t committed() const noexcept { return access_ == Access::read ? synced_ : written_; }
    const Columns &columns() const noexcept { return file_.columns(); }
    uint64_t salt() const noexcept { return file_.salt(); } // of this file alone
    // Bytes behind the last whole line when it was taken up.
    uint64_t torn() const noexcept { return torn_; }
    // Checksum of the line before `number`, or of the header.
    uint32_t chain_before(uint64_t number) const;

  private:
    void recover(Held held, const EachLine &each);
    LedgerFile::Tail find_end(const EachLine &each);
    void check_held(Held held) const;
    void write_anew(uint64_t first);
    void check_alive() const;
    void write(uint64_t lines);
    void line(uint64_t number, uint8_t *bytes) const;

    Store &store_;
    Access access_;
    Sync sync_;
    LedgerFile file_;
    Buffer<uint8_t> group_; // lines that are not written
    uint64_t written_ = 0, synced_ = 0, waiting_ = 0, torn_ = 0;
    uint32_t chain_ = 0;
    bool failed_ = false;
};

} // namespace toliman::track
