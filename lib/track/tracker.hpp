// Tracker: frames in any order, with duplicates and damage -> the periodogram of all valid frames, bit-identical for
// every order of arrival.
#pragma once
#include <array>
#include <chrono>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "period/stream/stream.hpp"
#include "track/checkpoint.hpp"
#include "track/clock.hpp"
#include "track/frame.hpp"
#include "track/identity.hpp"
#include "track/interval_records.hpp"
#include "track/ledger.hpp"
#include "track/misfit.hpp"
#include "track/names.hpp"
#include "track/reduction.hpp"
#include "track/setup.hpp"
#include "track/streams.hpp"
#include "track/terms.hpp"

namespace toliman::track {

enum class Verdict : int32_t {
    accepted = 0,
    duplicate = 1,
    quarantined = 2,
    outlier = 3,
    rejected = 4,
    unreduced = 5,
    misfit = 6
};

struct Outcome {
    Verdict verdict = Verdict::rejected;
    Flaw flaw; // rejected and unreduced frames only
    int64_t tai_ns = 0;
    double value = 0;        // frames with a value: reduced if frames are; unreduced frames: that of the estimator
    Goodness goodness;       // of these frames
    uint32_t bad_pixels = 0; // left out of the estimate
    double sigma = 0;        // of the value
};

// Result of an estimator for one image.
struct Estimated {
    double value = std::numeric_limits<double>::quiet_NaN();
    double sigma = 0;                                             // 0: the frame's sigma
    double chi_square = std::numeric_limits<double>::quiet_NaN(); // per pixel, against its model
    double chi_square_sigma = std::numeric_limits<double>::quiet_NaN();
    double largest_residual = std::numeric_limits<double>::quiet_NaN();
    uint32_t bad_pixels = 0;
    uint32_t flags = 0;
    // Further values and covariances, in the order of Columns; as many as the plan declares columns for.
    std::array<double, kMaxFurther> further = {};
};

inline uint64_t key_of(const Record &record) noexcept {
    return key_digest(record.stream, record.frame_id);
}

// Estimator: computes the value of an image, which it may overwrite. Each worker calls it for one frame at a time. An
// exception, a value that is not finite or a sigma outside the terms' range rejects the frame.
using Estimate =
    std::function<void(double *image, const Frame &frame, int64_t tai_ns, unsigned worker, Estimated &estimated)>;

// Called for a frame that is a misfit, before it is recorded. Returns whether `other` is to be tried in its place: the
// same frame with other pixels, which stay valid until the push ends.
using Retry = std::function<bool(const Frame &frame, const Outcome &outcome, Frame &other)>;

struct Plan {
    int64_t capacity = 0; // frames
    Terms terms;
    Columns columns; // of a new ledger; an existing ledger keeps its own
    Clock clock;
    Timing timing;
    Reference reference;  // of the values in the sums
    OrbitErrors errors;   // columns of the sums
    double chi_limit = 0; // above it, frames are misfits; 0: from the median of all
    ModelVerdict model = {};
    Retry retry;   // may be empty
    Reduce reduce; // with a reference: needed to push frames, and to rebuild
    unsigned workers = 1;
    size_t group = 64; // records per write and fsync
    Sync sync = Sync::group;
};

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

// A key is counted once in accepted, unreduced, outlier, misfit or quarantined. received = accepted + unreduced +
// outlier + misfit + quarantined + repeated + all rejected.
struct Counts {
    int64_t received = 0, accepted = 0, unreduced = 0, outlier = 0, misfit = 0, quarantined = 0, repeated = 0,
            rejected[kReasons] = {};
    int64_t dropped = 0; // by the camera, as reported by these except quarantined frames
};

// Time series of the accepted frames: times in the grid's unit from its reference, values, sigmas; rows of the columns.
struct Series {
    std::vector<double> t, y, sigma, rows;
};

// A session and region with its counts; empty names if unknown.
struct NamedStream {
    StreamCount count;
    std::string session, roi;
};

class Tracker {
  public:
    static constexpr size_t kBatch = 256; // maximum number of frames per push

    // Creates a folder or resumes from it. `sums` must be empty; it receives the sums of the folder's frames and must
    // outlive the tracker. Without an estimator, frames can only be merged. Status::mismatch if the folder has other
    // terms or, without rebuild, another grid, clock or reference. To rebuild with `reduce` reduces all frames again.
    Tracker(Plan plan, Estimate estimate, StateFolder folder, period::Stream &sums);

    // Estimates on all workers, then registers the frames in order. With one worker, frames without intervals that are
    // not reduced allocate nothing. On an exception the first `done` frames are registered, the others are not.
    void push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done);
    // Merges the records of another folder as if its frames had been pushed here; records merged before are not counted
    // again. Status::mismatch for other terms. With salvage, damaged records are skipped. Returns the number of lost
    // records.
    uint64_t merge(Store &other, bool salvage);
    // Writes all records and syncs them (as Sync specifies).
    void commit();
    // Commits, syncs the ledger and writes a checkpoint, so that resuming is fast.
    void save();

    // Visits the records of the ledger in order of arrival, at most `most` from number `first`, each with its current
    // verdict. Without a folder there are records of accepted frames and outliers only.
    using EachFrame = std::function<void(const Record &, const Outcome &)>;
    void visit(uint64_t first, uint64_t most, const EachFrame &each) const;

    // Returns the on-target intervals that came with the frame of a record, pairs (start, end) in s; empty without.
    // Status::lost if their records are damaged or missing. Only with a folder.
    std::vector<double> intervals_of(uint64_t number) const;

    // Returns the samples in the sums, sorted by time.
    Series series() const;

    const Plan &plan() const noexcept { return plan_; }
    const Counts &counts() const noexcept { return counts_; }
    // The chi-square above which frames are misfits, and the median of those of all valid frames.
    double chi_limit() const noexcept { return chi_squares_.limit(plan_.chi_limit); }
    double chi_median() const noexcept { return chi_squares_.median(); }
    int64_t expected() const noexcept { return streams_.expected(); }
    size_t stream_count() const noexcept { return streams_.count(); }
    std::vector<NamedStream> streams() const;                    // sorted by name
    const Columns &columns() const noexcept { return columns_; } // of the ledger
    uint64_t records() const noexcept {
        return ledger_ ? ledger_->count() : memory_.size() / record_size(columns_.count());
    }
    uint64_t committed() const noexcept { return ledger_ ? ledger_->committed() : records(); }

  private:
    // Result of a worker for one frame.
    struct Job {
        uint64_t stream = 0;
        uint32_t content = 0;
        Outcome outcome;
        Estimated estimated;
        Reason unreduced = Reason::none;
        Reduction reduction;
        std::exception_ptr failure; // of the reduction: no memory
    };
    void open(StateFolder &folder);
    void reduce_again(StateFolder &folder);
    void refuse_reduced_records() const;
    void adopt_columns(const LedgerFile &file);
    void resume_from_checkpoint(StateFolder &folder);
    void check_setup(const StateFolder &folder) const;
    void warn_of_damage(const StateFolder &folder) const;
    void push_accepted_from(uint64_t first);
    std::vector<uint8_t> checkpoint() const;
    void merge_names(const Names &names);
    void count_merge_mark(const MergeMark &merged);
    MergeMark last_merge_of(uint64_t salt) const noexcept; // zero counts if there was none
    // How to read the records of another ledger.
    struct Foreign {
        Arrangement arrange;
        IntervalCollector intervals;
        bool is_known; // the reference to which its frames are reduced; false: its setup is lost
        Record record(const Record &found) const noexcept;
    };
    Foreign foreign(const Columns &columns, bool is_known) const;
    void merge_all_records(Store &other, const Checkpoint &point, bool is_known);
    uint64_t merge_salvaged_records(const LedgerFile &file, const Checkpoint &point, bool is_known);
    bool merge_record(const Record &found, const Foreign &from, bool is_new);
    Setup setup() const {
        return {sums_.grid(), plan_.clock,  plan_.timing,    plan_.reference,
                salt_,        plan_.errors, plan_.chi_limit, plan_.model};
    }
    void evaluate(const Frame &frame, Job &job, unsigned worker) noexcept;
    void validate_and_estimate(const Frame &frame, Job &job, unsigned worker);
    void reduce(const Frame &frame, Job &job, unsigned worker) noexcept;
    void retry(Frame &frame, Job &job);
    Cells cells_of(const Frame &frame, const Job &job) const noexcept;
    Record record_of(const Frame &frame, const Job &job) const noexcept;
    void register_frame(const Record &record, const Frame &frame, Outcome &outcome);
    void add_frame(const Record &record, const double *intervals = nullptr, size_t interval_count = 0);
    void quarantine(const KnownFrame &known, Record record);
    void count_repeats(int64_t count) noexcept;
    void record_repeats();
    bool has_uncommitted() const noexcept;                    // records or repeats
    void count_record(const Record &record, uint64_t number); // updates index and counts
    void count_frame(const Record &record, uint64_t number);
    void count_quarantine(const Record &record, uint64_t number);
    // A frame whose state changes with the limit, and its sample if it enters or leaves the sums.
    struct Change {
        uint64_t key;
        FrameState state;
        std::optional<period::Sample> sample;
        Row row;
    };
    class LimitChange;                                         // limit.cpp
    ChiBin chi_square_of(const Record &record) const noexcept; // that counts for the limit
    std::vector<Change> changes_to(ChiBin limit) const;
    void apply(const std::vector<Change> &changes) noexcept;
    void count_chi_square(const Record &record) noexcept; // of the ledger, before the record is counted
    void mark_misfits() noexcept;
    void push_changed(uint64_t first);
    uint64_t append_record(const Record &record); // returns its number
    Record read_record(uint64_t number) const;
    Outcome outcome_of(const Record &record) const;
    void check_writable() const;
    // Value of a record in the sums; NaN if it is not reduced.
    double value_of(const Record &record) const noexcept { return reducer_ ? reducer_->value(record) : record.value; }
    FrameState state_of(const Record &record) const noexcept;
    int64_t &count_of(FrameState state) noexcept;
    // Returns the sample of a record, whose columns are in `row`; none unless the frame was accepted, is reduced, and
    // the sums cover it.
    std::optional<period::Sample> sample_of(const Record &record, Row &row) const noexcept;

    Plan plan_;
    Estimate estimate_;
    std::unique_ptr<Store> store_;
    Access access_;
    FrameIndex index_;
    ChiSquares chi_squares_;
    ChiBin limit_;                 // the highest bin of frames that are not misfits
    ChiBin limit_before_ = kNoBin; // when the checkpoint was written
    Streams streams_;
    period::Stream &sums_;
    std::optional<Ledger> ledger_;
    std::optional<Names> names_;           // with a folder, as the ledger
    std::map<uint64_t, MergeMark> merged_; // by salt, the latest mark of each ledger; the own one counts repeats
    uint64_t salt_ = 0;                    // of the own ledger
    Columns columns_;
    GoodnessColumns goodness_;
    Arrangement arrange_;             // plan's columns -> columns_
    std::optional<Reducer> reducer_;  // with a reference
    std::vector<OnTarget> on_target_; // of each worker
    Buffer<uint8_t> memory_;          // without a ledger: records of accepted frames and outliers
    Buffer<double> images_;           // [workers][out_rows * out_cols]
    std::vector<Job> jobs_;
    Counts counts_;
    int64_t unrecorded_repeats_ = 0;               // not yet counted by the ledger
    std::chrono::steady_clock::time_point oldest_; // time of the first uncommitted record
};

} // namespace toliman::track
