// Frames in any order, some twice, some damaged -> the periodogram of those that can be trusted, the same bits whatever
// the order.
#pragma once
#include <array>
#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "period/stream.hpp"
#include "track/checkpoint.hpp"
#include "track/clock.hpp"
#include "track/frame.hpp"
#include "track/identity.hpp"
#include "track/ledger.hpp"
#include "track/names.hpp"
#include "track/setup.hpp"
#include "track/streams.hpp"
#include "track/terms.hpp"

namespace toliman::track {

enum class Verdict : int32_t { accepted = 0, duplicate = 1, quarantined = 2, outlier = 3, rejected = 4 };

struct Outcome {
    Verdict verdict = Verdict::rejected;
    Flaw flaw; // of rejected frames
    int64_t tai_ns = 0;
    double value = 0;                                             // of accepted frames and outliers
    double chi_square = std::numeric_limits<double>::quiet_NaN(); // per pixel, of the same; NaN: not known
};

// What an estimator finds in an image.
struct Estimated {
    double value = std::numeric_limits<double>::quiet_NaN();
    double sigma = 0;                                             // 0: the frame's
    double chi_square = std::numeric_limits<double>::quiet_NaN(); // per pixel, against its model
    uint32_t flags = 0;
    // Its further values and their covariances, in the order of Columns; as many as the plan's columns have.
    std::array<double, kMostFurther> further = {};
};

inline uint64_t key_of(const Record &record) noexcept {
    return key_digest(record.stream, record.frame_id);
}

// From an image, of this frame and time, to what it says; it may use the image as it likes. A worker calls it for one
// frame at a time; an exception, a value that is not finite and a sigma that the terms do not allow reject the frame.
using Estimate =
    std::function<void(double *image, const Frame &frame, int64_t tai_ns, unsigned worker, Estimated &estimated)>;

struct Plan {
    int64_t capacity = 0; // frames
    Terms terms;
    Columns columns; // that a new ledger declares; one that is there keeps its own
    Clock clock;
    unsigned workers = 1;
    size_t group = 64; // lines that are brought to the disk together
    Sync sync = Sync::group;
};

// Where the files are, and what of them was read before the ledger: a writer may be adding to that.
struct Place {
    std::unique_ptr<Store> store; // none: all in memory
    Access access = Access::write;
    bool rebuild = false; // sums anew, on the plan's grid and clock
    std::optional<Setup> setup;
    std::optional<Loaded> loaded;
    bool has_checkpoint = false; // whole or not
    Log log;                     // of damage that costs nothing, or only what it says
};
// Locks the ledger for writing. A setup that does not fit the terms is another folder's and left out. Status::mismatch
// for a ledger on other terms.
Place open_place(std::unique_ptr<Store> store, Access access, const Terms &terms);

// Keys are counted once. received = accepted + outlier + quarantined + repeated + all rejected.
struct Counts {
    int64_t received = 0, accepted = 0, outlier = 0, quarantined = 0, repeated = 0, rejected[kReasons] = {};
    int64_t dropped = 0; // by the camera, before frames that are in
};

// Times in the grid's unit from its reference, values and their sigmas.
struct Series {
    std::vector<double> t, y, sigma;
};

// Names are empty where they are not known.
struct NamedStream {
    StreamCount count;
    std::string session, roi;
};

class Tracker {
  public:
    static constexpr size_t kBatch = 256; // frames, the most of one push

    // Takes up what the place holds; sums, which are empty, become those of its frames and must outlive the tracker. No
    // estimate: frames come by merging only. Status::mismatch if it was made on other terms or, without rebuild, with
    // another grid or clock.
    Tracker(Plan plan, Estimate estimate, Place place, period::Stream &sums);

    // Estimates on all workers, then settles one frame after the other; allocates nothing with one worker. Where it
    // fails, frames before `done` are in and that one is not.
    void push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done);
    // All lines of another folder that did not come before, as if their frames had come here. Status::mismatch for
    // other terms. Salvage leaves out what is damaged; returns how many lines are lost.
    uint64_t merge(Store &other, bool salvage);
    // Brings all lines to the disk.
    void commit();
    // The same and the sums, so that taking up is quick.
    void save();

    // Frames in the order of arrival, by lines of the ledger from `first` on, `most` at the most; their verdict is that
    // of now. In memory there are those alone that came as good ones.
    using EachFrame = std::function<void(const Record &, const Outcome &)>;
    void visit(uint64_t first, uint64_t most, const EachFrame &each) const;

    // What is in the sums, by time.
    Series series() const;

    const Plan &plan() const noexcept { return plan_; }
    const Counts &counts() const noexcept { return counts_; }
    int64_t expected() const noexcept { return streams_.expected(); }
    size_t stream_count() const noexcept { return streams_.count(); }
    std::vector<NamedStream> streams() const;                    // by their names
    const Columns &columns() const noexcept { return columns_; } // of the lines
    uint64_t lines() const noexcept { return ledger_ ? ledger_->count() : in_memory_; }
    uint64_t committed() const noexcept { return ledger_ ? ledger_->committed() : in_memory_; }

  private:
    // What a worker finds out about a frame.
    struct Job {
        uint64_t stream = 0;
        uint32_t content = 0;
        Outcome outcome;
        Estimated estimated;
    };
    void open(Place &place);
    void begin_ledger();
    void take_columns(const LedgerFile &file);
    void take_checkpoint(Place &place);
    void check_setup(const Place &place) const;
    void tell_damage(const Place &place) const;
    void sum_up(uint64_t first);
    std::vector<uint8_t> checkpoint() const;
    void take_names(const Names &names);
    void take_merged(const Merged &merged);
    Merged merged_before(uint64_t salt) const noexcept; // no lines if there was none
    void merge_all_lines(Store &other, const Checkpoint &point);
    uint64_t merge_whole_lines(const LedgerFile &file, const Checkpoint &point);
    bool merge_line(const Record &theirs, bool is_new);
    Setup setup() const { return {sums_.grid(), plan_.clock}; }
    void look_at(const Frame &frame, Job &job, unsigned worker) noexcept;
    void judge(const Frame &frame, Job &job, unsigned worker);
    Cells cells_of(const Frame &frame, const Job &job) const noexcept;
    Record record_of(const Frame &frame, const Job &job) const noexcept;
    void settle(const Record &record, Outcome &outcome);
    void take_in(const Record &record);
    void deny(const Seen &seen, Record record);
    void count_repeats(int64_t count) noexcept;
    void record_repeats();
    bool has_waiting() const noexcept;              // for the disk
    void note(const Record &record, uint64_t line); // in index and counts
    void note_frame(const Record &record, uint64_t line);
    void note_denial(const Record &record, uint64_t line);
    uint64_t write_line(const Record &record); // returns its number
    Record read_line(uint64_t number) const;
    Outcome outcome_of(const Record &record) const;
    void check_writable() const;
    // What a line brings to the sums: nothing unless it says accepted and its time has a place there.
    std::optional<period::Sample> sample_of(const Record &record) const noexcept;

    Plan plan_;
    Estimate estimate_;
    std::unique_ptr<Store> store_;
    Access access_;
    FrameIndex index_;
    Streams streams_;
    period::Stream &sums_;
    std::optional<Ledger> ledger_;
    std::optional<Names> names_;        // as the ledger
    std::map<uint64_t, Merged> merged_; // of every ledger the latest, by its salt; of the own one, what counts repeats
    uint64_t salt_ = 0;                 // of the ledger
    Columns columns_;
    Arrangement arrange_;    // of the plan's columns
    Buffer<uint8_t> memory_; // in place of a ledger, lines of frames that are in
    size_t in_memory_ = 0;
    Buffer<double> images_; // [workers][out_rows * out_cols]
    std::vector<Job> jobs_;
    Counts counts_;
    int64_t unrecorded_repeats_ = 0;               // that the ledger does not count yet
    std::chrono::steady_clock::time_point oldest_; // of the lines that wait
};

} // namespace toliman::track
