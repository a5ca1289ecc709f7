// Tracker: frames in any order, with duplicates and damage -> the periodogram of all valid frames, bit-identical for
// every order of arrival. Frames are evaluated (evaluation.hpp), then registered (registry.hpp) by their records
// (records.hpp).
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "period/stream/stream.hpp"
#include "track/checkpoint.hpp"
#include "track/evaluation.hpp"
#include "track/interval_records.hpp"
#include "track/plan.hpp"
#include "track/records.hpp"
#include "track/registry.hpp"

namespace toliman::track {

// A state folder, with the files that are read before the ledger, to which a writer may be appending.
struct StateFolder {
    std::unique_ptr<Store> store; // NULL: all in memory
    Access access = Access::write;
    bool rebuild = false; // recompute the sums, with the plan's grid and clock
    std::optional<Setup> setup;
    std::optional<Loaded> loaded;
    bool has_checkpoint = false; // the file exists, valid or not
    bool is_rewritten = false;   // the ledger was, to reduce its frames again: there is no checkpoint of it
    Log log;                     // receives warnings of damage that is repaired or ignored
};
// Reads a folder; with Access::write locks its ledger. A setup that does not match the terms belongs to another folder
// and is ignored. Status::mismatch for a ledger with other terms.
StateFolder open_state_folder(std::unique_ptr<Store> store, Access access, const Terms &terms);
// Whether a tracker has begun to record frames there. False also for the header of a ledger that a tracker left before
// it wrote its setup. Status::format if the ledger is missing although other files exist.
bool has_state(Store &store);

// Time series of the accepted frames: times in the grid's unit from its reference, values, sigmas; rows of the columns.
struct Series {
    std::vector<double> t, y, sigma, rows;
};

// A session and region with its counts; empty names if unknown.
struct NamedStream {
    StreamCount count;
    Names::Stream name;
};

class Tracker {
  public:
    static constexpr size_t kBatch = Evaluation::kBatch; // maximum number of frames per push

    // Creates a folder or resumes from it. `sums` must be empty; it receives the sums of the folder's frames and must
    // outlive the tracker. Without an estimator, frames can only be merged. Status::mismatch if the folder has other
    // terms or, without rebuild, another grid, clock or reference. To rebuild with `reduce` reduces all frames again.
    Tracker(Plan plan, Estimate estimate, StateFolder folder, period::Stream &sums);
    Tracker(const Tracker &) = delete; // its parts refer to each other
    Tracker &operator=(const Tracker &) = delete;

    // Estimates on all workers, then registers the frames in order. With one worker, frames without intervals that are
    // not reduced allocate nothing. On an exception the first `done` frames are registered, the others are not.
    void push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done);
    // Merges the records of another folder as if its frames had been pushed here; records merged before are not counted
    // again. Status::mismatch for other terms. With salvage, damaged records are skipped. Returns the number of lost
    // records.
    uint64_t merge(Store &other, bool salvage);
    // Writes all records and syncs them (as Sync specifies).
    void commit() { records_.commit(); }
    // Commits, syncs the ledger and writes a checkpoint, so that resuming is fast.
    void save();

    // Visits the records of the ledger in order of arrival, at most `most` from number `first`, each with its current
    // verdict. Without a folder there are records of accepted frames and outliers only.
    using EachFrame = std::function<void(const Record &, const Outcome &)>;
    void visit(uint64_t first, uint64_t most, const EachFrame &each) const;

    // Returns the on-target intervals that came with the frame of a record, pairs (start, end) in s; empty without.
    // Status::lost if their records are damaged or missing. Only with a folder.
    std::vector<double> intervals_of(uint64_t number) const { return records_.intervals_of(number); }

    // Returns the samples in the sums, sorted by time.
    Series series() const;

    const Plan &plan() const noexcept { return plan_; }
    const Counts &counts() const noexcept { return registry_.counts(); }
    // The chi-square above which frames are misfits, and the median of those of all valid frames.
    double chi_limit() const noexcept { return registry_.chi_limit(); }
    double chi_median() const noexcept { return registry_.chi_median(); }
    // As it is, or would be, in the folder.
    Setup setup() const {
        Setup setup = plan_;
        setup.grid = registry_.sums().grid();
        setup.salt = records_.salt();
        return setup;
    }
    int64_t expected() const noexcept { return registry_.streams().expected(); }
    size_t stream_count() const noexcept { return registry_.streams().count(); }
    std::vector<NamedStream> streams() const;                              // sorted by name
    const Columns &columns() const noexcept { return records_.columns(); } // of the ledger
    uint64_t records() const noexcept { return records_.count(); }
    uint64_t committed() const noexcept { return records_.committed(); }

  private:
    void open(StateFolder &folder);
    void read_ledger(const StateFolder &folder);
    void reduce_again(StateFolder &folder);
    void refuse_reduced_records() const;
    void adopt_columns(const LedgerFile &file);
    void resume_from_checkpoint(StateFolder &folder);
    void check_setup(const StateFolder &folder) const;
    void warn_of_damage(const StateFolder &folder) const;
    std::vector<uint8_t> checkpoint() const;
    // How to read the records of another ledger.
    struct Foreign {
        Arrangement arrange;
        IntervalCollector intervals;
        bool is_known; // the reference to which its frames are reduced; false: its setup is lost
        Record record(const Record &found) const noexcept;
    };
    Foreign foreign(const Columns &columns, bool is_known) const;
    void merge_all_records(Store &other, const std::optional<Loaded> &loaded, bool is_known);
    bool has_all_sums(const Ledger &theirs, const std::optional<Loaded> &loaded) const;
    uint64_t merge_salvaged_records(const LedgerFile &file, const Checkpoint &point, bool is_known);
    bool merge_record(const Record &found, const Foreign &from, bool is_new);
    void merge_names(const Names &names);

    Plan plan_;
    Records records_;
    Registry registry_;
    Evaluation evaluation_;
};

} // namespace toliman::track
