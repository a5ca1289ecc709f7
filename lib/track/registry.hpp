// Registry of the frames of a tracker: which are known, their verdicts and counts, and their sums. All is derived from
// the records; a record is appended before anything else changes.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "period/stream/stream.hpp"
#include "track/identity.hpp"
#include "track/misfit.hpp"
#include "track/plan.hpp"
#include "track/records.hpp"
#include "track/streams.hpp"

namespace toliman::track {

inline uint64_t key_of(const Record &record) noexcept {
    return key_digest(record.stream, record.frame_id);
}

// A key is counted once in accepted, unreduced, outlier, misfit or quarantined. received = accepted + unreduced +
// outlier + misfit + quarantined + repeated + all rejected.
struct Counts {
    int64_t received = 0, accepted = 0, unreduced = 0, outlier = 0, misfit = 0, quarantined = 0, repeated = 0,
            rejected[kReasons] = {};
    int64_t dropped = 0; // by the camera, as reported by these except quarantined frames
};

class Registry {
  public:
    // All arguments must outlive the object. `sums` receives the samples of the accepted frames.
    Registry(const Plan &plan, Records &records, period::Stream &sums);
    Registry(const Registry &) = delete;
    Registry &operator=(const Registry &) = delete;

    // Takes the columns of the records; then, with a reference, how to reduce them. `ledger` names them in errors.
    void set_columns();
    void set_reducer(const std::string &ledger);

    // Whether a frame with this key and content is known.
    bool knows(uint64_t key, uint32_t content) const noexcept;
    const KnownFrame *find(uint64_t key) const noexcept { return index_.find(key); }
    // Whether the sums cover a frame of this time.
    bool covers(int64_t tai_ns) const noexcept;
    bool is_misfit(double chi_square) const noexcept { return bin_of(chi_square) > limit_; }
    // Returns the current outcome of a record and its number: that of its key, which may have been quarantined since.
    Outcome outcome_of(const Record &record, uint64_t number) const;
    // Returns the sample of a record, whose columns are in `row`; none unless the frame was accepted, is reduced, and
    // the sums cover it.
    std::optional<period::Sample> sample_of(const Record &record, Row &row) const noexcept;

    // Decides on the verdict of an evaluated frame. Its record is appended before anything else changes.
    void register_frame(const Record &record, const Frame &frame, Outcome &outcome);
    void add_frame(const Record &record, const double *intervals = nullptr, size_t interval_count = 0);
    void quarantine(const KnownFrame &known, Record record);
    void count_repeats(int64_t count) noexcept;
    void count_record(const Record &record, uint64_t number); // updates index and counts

    // While the ledger is read: counts its records without a limit of misfits; then marks these. mark_checkpoint() is
    // called where the checkpoint was written.
    void begin_reading(uint64_t records);
    void count_read(const Record &record, uint64_t number);
    void mark_checkpoint() noexcept { limit_before_ = bin_of(chi_limit()); }
    void mark_misfits() noexcept;
    // Pushes the accepted frames of the records from number `first`, and retracts the samples of earlier records whose
    // keys these quarantine. Frames of keys that are quarantined now are never pushed.
    void push_accepted_from(uint64_t first);
    // Until settle(), samples of added frames are not pushed. settle() pushes them, or adds `theirs`, the sums
    // of a ledger whose frames were added and that were computed with this setup, if these are the same samples. After
    // a failure they still wait.
    void begin_waiting() noexcept { waiting_from_ = records_.count(); }
    void settle(const period::Stream *theirs = nullptr);
    // Frames of the first `first` records that have entered or left the sums by the limit since the checkpoint.
    void push_changed(uint64_t first);

    const Counts &counts() const noexcept { return counts_; }
    double chi_limit() const noexcept { return chi_squares_.limit(plan_.chi_limit); }
    double chi_median() const noexcept { return chi_squares_.median(); }
    period::Stream &sums() noexcept { return sums_; }
    const period::Stream &sums() const noexcept { return sums_; }
    Streams &streams() noexcept { return streams_; }
    const Streams &streams() const noexcept { return streams_; }

  private:
    void count_frame(const Record &record, uint64_t number);
    void count_quarantine(const Record &record, uint64_t number);
    void count_merge_mark(const MergeMark &merged);
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
    // Value of a record in the sums; NaN if it is not reduced.
    double value_of(const Record &record) const noexcept { return reducer_ ? reducer_->value(record) : record.value; }
    FrameState state_of(const Record &record) const noexcept;
    void set_state(const KnownFrame &known, FrameState state) noexcept;
    int64_t &count_of(FrameState state) noexcept;

    const Plan &plan_;
    Records &records_;
    period::Stream &sums_;
    FrameIndex index_;
    // Of the frames of the records that were read, by number: the slots of the index are all over the memory.
    std::vector<FrameState> states_;
    Streams streams_;
    Counts counts_;
    ChiSquares chi_squares_;
    ChiBin limit_;                 // the highest bin of frames that are not misfits
    ChiBin limit_before_ = kNoBin; // when the checkpoint was written
    GoodnessColumns goodness_;
    std::optional<Reducer> reducer_; // with a reference
    // Number of the first record whose sample waits for settle(), and how many do.
    std::optional<uint64_t> waiting_from_;
    int64_t waiting_ = 0;
};

} // namespace toliman::track
