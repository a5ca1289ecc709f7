// The ledger: what became of every frame, in the order of arrival; lines are only ever added (lib/FORMATS.md "TLML").
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "backend/store.hpp"
#include "track/record.hpp"
#include "track/terms.hpp"

namespace toliman::track {

// When lines are brought to the disk; until then a frame is not acknowledged.
enum class Sync { group, frame, none };

class Ledger {
  public:
    static constexpr const char *kName = "ledger.tlml";
    static constexpr uint64_t kMostRecords = uint64_t{1} << 30;

    using Each = std::function<void(const Record &, uint64_t number)>;

    // Takes up the ledger in the store, or begins one on these terms, and hands every line that is whole to each. What
    // a crash tore off behind the last one is cut away, when writing. Status::mismatch for other terms, Status::format
    // for a header or a line that is damaged though the disk had it.
    // Lines that a checkpoint holds of the ledger with this salt must all be whole: Status::format before anything is
    // cut.
    struct Held {
        uint64_t salt = 0, lines = 0;
    };
    Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, Held held, const Each &each);
    static Terms terms_in(Store &store); // of the ledger there

    // Lines from `first` on once more.
    void visit(uint64_t first, const Each &each);

    // Adds a line; commits when the group is full. Allocates nothing.
    void append(const Record &record);
    // Brings all lines to the disk, as sync says. After a failure the ledger takes no more (Status::write).
    void commit();
    // The same whatever sync says.
    void sync();
    Record read(uint64_t number);

    uint64_t count() const noexcept { return written_ + waiting_; }
    uint64_t committed() const noexcept { return written_; } // acknowledged, as far as sync goes
    uint64_t salt() const noexcept { return salt_; }         // of this file alone
    // Checksum of the line before `number`, or of the header.
    uint32_t chain_before(uint64_t number);

  private:
    struct Header {
        uint64_t salt;
        Terms terms;
        uint32_t checksum;
    };
    static Header read_header(Store &store);
    void begin(const Terms &terms);
    void check_header(const Terms &terms);
    // What the last line that was scanned says.
    struct Tail {
        uint32_t chain, synced;
    };
    uint64_t scan(uint64_t first, uint64_t end, Tail &tail, const Each &each);
    void recover(Held held, const Each &each);
    void write_anew(uint64_t first);
    bool damaged_inside(uint64_t lines);
    void check_alive() const;
    void write(uint64_t lines);
    void line(uint64_t number, uint8_t *bytes);

    Store &store_;
    Access access_;
    Sync sync_;
    std::vector<uint8_t> group_; // lines that are not written
    uint64_t salt_ = 0, written_ = 0, synced_ = 0, waiting_ = 0;
    uint32_t header_chain_ = 0, chain_ = 0;
    bool failed_ = false;
};

} // namespace toliman::track
