// Records of a tracker: the ledger and the files next to it or, without a folder, memory. They are the truth.
#pragma once
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/buffer.hpp"
#include "track/ledger.hpp"
#include "track/names.hpp"
#include "track/plan.hpp"

namespace toliman::track {

class Records {
  public:
    // The plan must outlive the object. store NULL: in memory, for as many frames as the plan has.
    Records(const Plan &plan, std::unique_ptr<Store> store, Access access);
    Records(const Records &) = delete;
    Records &operator=(const Records &) = delete;

    // With a folder: opens the ledger with this salt and passes its records to `each`; then the names.
    void open(uint64_t salt, CheckpointMark mark, const EachRecord &each);
    void open_names();

    Store *store() const noexcept { return store_.get(); } // NULL in memory
    std::string path(const char *name) const { return store_->path(name); }
    Access access() const noexcept { return access_; }
    const Columns &columns() const noexcept { return columns_; } // of the ledger
    void set_columns(const Columns &columns) { columns_ = columns; }
    const Ledger *ledger() const noexcept { return ledger_ ? &*ledger_ : nullptr; }
    Names *names() noexcept { return names_ ? &*names_ : nullptr; }
    const Names *names() const noexcept { return names_ ? &*names_ : nullptr; }
    uint64_t count() const noexcept {
        return ledger_ ? ledger_->count() : memory_.size() / record_size(columns_.count());
    }
    uint64_t committed() const noexcept { return ledger_ ? ledger_->committed() : count(); }
    uint64_t salt() const noexcept { return salt_; } // of the ledger; 0 without
    void check_writable() const;

    // Returns the number of the record. Without a ledger only records of accepted frames and outliers are kept.
    uint64_t append(const Record &record);
    Record read(uint64_t number) const;
    void visit(uint64_t first, uint64_t most, const EachRecord &each) const;
    // The on-target intervals that came with the frame of a record.
    std::vector<double> intervals_of(uint64_t number) const;

    // The latest mark of each ledger that was merged; the own one counts repeats.
    MergeMark last_merge_of(uint64_t salt) const noexcept; // zero counts if there was none
    void set_mark(const MergeMark &mark) { marks_[mark.salt] = mark; }
    // Repeated frames have no records of their own: a mark with their number is appended by a commit.
    void add_repeats(int64_t count) noexcept { unrecorded_repeats_ += count; }
    int64_t unrecorded_repeats() const noexcept { return unrecorded_repeats_; }
    void record_repeats();

    // Notes the time unless something waits to be committed already; commits what has waited for long.
    void begin_waiting() noexcept;
    void commit_if_due();
    // Writes all records and syncs them (as Sync specifies).
    void commit();
    // Syncs the ledger, in any case, and the names.
    void sync_ledger() { ledger_->sync(); }
    void sync_names() { names_->sync(); }

  private:
    bool has_uncommitted() const noexcept; // records or repeats

    const Plan &plan_;
    std::unique_ptr<Store> store_;
    Access access_;
    Columns columns_;
    std::optional<Ledger> ledger_;
    std::optional<Names> names_; // with a folder, as the ledger
    uint64_t salt_ = 0;
    std::map<uint64_t, MergeMark> marks_;          // by salt
    int64_t unrecorded_repeats_ = 0;               // not yet counted by the ledger
    Buffer<uint8_t> memory_;                       // without a ledger: records of accepted frames and outliers
    std::chrono::steady_clock::time_point oldest_; // time of the first uncommitted record
};

} // namespace toliman::track
