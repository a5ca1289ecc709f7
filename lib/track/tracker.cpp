// Method: event sourcing. The ledger holds one record per decision about a frame and is the truth; index, counts and
// sums are derived from it.
// Order independence: the sums are exact (period/stream/stream.cpp), and the verdict of a frame depends on its bytes
// and on those of frames with the same key only. Two payloads of one key quarantine the key, and the accepted sample is
// retracted exactly, so that it does not matter which payload came first.
// Atomicity: a record is appended before index, counts and sums change; a failure before that leaves them unchanged.
// Threads: workers validate and estimate frames in parallel. Registration is sequential, so that threads change no bit.
#include "track/tracker.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <new>
#include <tuple>
#include <utility>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::track {

namespace {

// Whether the exception in flight is a shortage of memory.
bool is_short_of_memory() noexcept {
    try {
        throw;
    } catch (const std::bad_alloc &) {
        return true;
    } catch (const Error &error) {
        return error.status() == Status::memory;
    } catch (...) {
        return false;
    }
}

constexpr std::chrono::seconds kCommitInterval{1}; // of records that wait for a full group
constexpr size_t kSpans = 64;                      // of a frame, for which memory is reserved

} // namespace

Tracker::Tracker(Plan plan, Estimate estimate, StateFolder folder, period::Stream &sums)
    : plan_(std::move(plan)), estimate_(std::move(estimate)), store_(std::move(folder.store)), access_(folder.access),
      index_(plan_.capacity), limit_(bin_of(chi_limit())), streams_(plan_.capacity), sums_(sums),
      columns_(plan_.columns), goodness_(columns_), arrange_(columns_, columns_) {
    images_.resize(plan_.workers * plan_.terms.geometry.out_rows * plan_.terms.geometry.out_cols);
    jobs_.resize(kBatch);
    on_target_.resize(plan_.workers);
    for (OnTarget &one : on_target_)
        one.spans.reserve(kSpans);
    if (store_) {
        open(folder);
        return;
    }
    memory_.reserve(static_cast<size_t>(plan_.capacity) * record_size(columns_.count())); // no page is touched yet
    if (plan_.reference.is_given())
        reducer_.emplace(columns_, plan_.reference, plan_.errors, "options->values");
}

std::optional<period::Sample> Tracker::sample_of(const Record &record, Row &row) const noexcept {
    const std::optional<int64_t> tai_ns = plan_.clock.tai_ns(record.camera_ns);
    const double value = value_of(record);
    if (record.kind != Kind::accepted || !tai_ns || !(std::fabs(value) <= plan_.terms.value_limit))
        return std::nullopt;
    period::Sample sample = sums_.sample_ns(*tai_ns, value, record.sigma);
    if (reducer_) {
        row = reducer_->row(record);
        sample.columns = row.data();
    }
    return sums_.covers(sample) ? std::optional(sample) : std::nullopt;
}

// Unless it is a misfit.
FrameState Tracker::state_of(const Record &record) const noexcept {
    if (record.kind == Kind::accepted && std::isnan(value_of(record)))
        return FrameState::unreduced;
    Row row;
    return sample_of(record, row) ? FrameState::accepted : FrameState::outlier;
}

int64_t &Tracker::count_of(FrameState state) noexcept {
    return state == FrameState::accepted    ? counts_.accepted
           : state == FrameState::unreduced ? counts_.unreduced
           : state == FrameState::misfit    ? counts_.misfit
                                            : counts_.outlier;
}

void Tracker::count_repeats(int64_t count) noexcept {
    counts_.received += count;
    counts_.repeated += count;
    unrecorded_repeats_ += count;
}

// Appends a mark with the number of repeated frames so far: these have no records of their own.
void Tracker::record_repeats() {
    if (!ledger_ || unrecorded_repeats_ == 0 || records() == LedgerFile::kMaxRecords)
        return;
    ledger_->check();
    MergeMark &own = merged_.at(salt_);
    const int64_t repeats = std::min(own.repeats + unrecorded_repeats_, kMaxRepeats);
    const MergeMark mark = {salt_, static_cast<int64_t>(records()), repeats, ledger_->chain_before(records())};
    ledger_->append(to_record(mark, plan_.terms.sigma, columns_.empty()));
    own = mark;
    unrecorded_repeats_ = 0;
}

void Tracker::count_record(const Record &record, uint64_t number) {
    if (record.kind == Kind::intervals)
        return;
    if (record.kind == Kind::merged)
        return count_merge_mark(merge_mark_of(record));
    if (record.kind == Kind::rejected)
        counts_.rejected[static_cast<size_t>(record.reason)]++;
    else if (record.kind == Kind::quarantined)
        count_quarantine(record, number);
    else
        count_frame(record, number);
    counts_.received++;
}

// A valid frame whose time the sums do not cover counts as an outlier: with another grid or clock it may be accepted.
void Tracker::count_frame(const Record &record, uint64_t number) {
    index_.check_capacity();
    streams_.check_capacity(record.stream);
    const ChiBin chi_square = chi_square_of(record);
    const FrameState state = chi_square > limit_ ? FrameState::misfit : state_of(record);
    if (index_.find(key_of(record)) != nullptr)
        fail(Status::format, "{%s}: record %llu: duplicate frame", store_->path(LedgerFile::kName).c_str(),
             static_cast<unsigned long long>(number));
    index_.add(key_of(record), record.content, number, state, chi_square);
    streams_.add(record.stream, record.frame_id);
    count_of(state)++;
    counts_.dropped += record.dropped;
}

void Tracker::count_quarantine(const Record &record, uint64_t number) {
    const KnownFrame *known = index_.find(key_of(record));
    if (known == nullptr || known->state() == FrameState::quarantined)
        fail(Status::format, "{%s}: record %llu: quarantines an unknown frame", store_->path(LedgerFile::kName).c_str(),
             static_cast<unsigned long long>(number));
    count_of(known->state())--;
    counts_.quarantined++;
    counts_.repeated++;
    counts_.dropped -= record.dropped;
    index_.set_state(*known, FrameState::quarantined);
}

MergeMark Tracker::last_merge_of(uint64_t salt) const noexcept {
    const auto found = merged_.find(salt);
    if (found != merged_.end())
        return found->second;
    MergeMark none;
    none.salt = salt;
    return none;
}

void Tracker::count_merge_mark(const MergeMark &merged) {
    const int64_t repeats = merged.repeats - last_merge_of(merged.salt).repeats;
    if (counts_.repeated + repeats > 2 * kMaxRepeats)
        fail(Status::format, "{%s}: impossible counts of merged records", store_->path(LedgerFile::kName).c_str());
    merged_[merged.salt] = merged; // first, since it may run out of memory
    counts_.received += repeats;
    counts_.repeated += repeats;
}

// Returns the number of the record. Without a ledger only records of accepted frames and outliers are kept.
uint64_t Tracker::append_record(const Record &record) {
    if (ledger_) {
        ledger_->append(record);
        return ledger_->count() - 1;
    }
    if (record.kind == Kind::accepted || record.kind == Kind::outlier) {
        memory_.resize(memory_.size() + record_size(columns_.count()));
        to_bytes(record, columns_.count(), 0, 0, &memory_[memory_.size() - record_size(columns_.count())]);
    }
    return records() - 1;
}

Record Tracker::read_record(uint64_t number) const {
    if (ledger_)
        return ledger_->read(number);
    Record record;
    uint32_t synced, chain = 0;
    from_bytes(memory_.data() + number * record_size(columns_.count()), columns_.count(), record, synced, chain);
    return record;
}

// Runs in a worker: identifies a frame and, unless it is a duplicate, validates and estimates it.
void Tracker::evaluate(const Frame &frame, Job &job, unsigned worker) noexcept {
    job = Job();
    job.stream = stream_digest(frame.session, frame.roi);
    job.content = content_of(frame);
    const KnownFrame *known = index_.find(key_digest(job.stream, frame.frame_id));
    if (known == nullptr || known->content != job.content)
        validate_and_estimate(frame, job, worker);
}

// A frame is not rejected because memory is short: the push fails instead.
void Tracker::validate_and_estimate(const Frame &frame, Job &job, unsigned worker) {
    Outcome &outcome = job.outcome;
    const Terms &terms = plan_.terms;
    double *image = images_.data() + worker * terms.geometry.out_rows * terms.geometry.out_cols;
    outcome.flaw = check_and_bin(frame, terms.geometry, image);
    if (outcome.flaw.reason != Reason::none)
        return;
    const std::optional<int64_t> tai_ns = plan_.clock.tai_ns(frame.camera_ns);
    if (!tai_ns || !sums_.covers(sums_.sample_ns(*tai_ns, 0, terms.sigma))) {
        outcome.flaw.reason = Reason::clock;
        return;
    }
    outcome.tai_ns = *tai_ns;
    try {
        estimate_(image, frame, *tai_ns, worker, job.estimated);
    } catch (...) {
        outcome.flaw.reason = Reason::estimate;
        if (is_short_of_memory())
            job.failure = std::current_exception();
        return;
    }
    const Estimated &found = job.estimated;
    const double measured = plan_.reduce ? found.further[plan_.columns.find(kMeasured) - plan_.columns.own()] : 0;
    if (!std::isfinite(found.value) || !std::isfinite(measured)) {
        outcome.flaw = {Reason::estimate, 0, 0, std::isfinite(found.value) ? measured : found.value};
    } else if (found.sigma != 0 && !terms.allows_sigma(found.sigma)) {
        outcome.flaw = {Reason::estimate, 0, 0, found.sigma};
    } else {
        outcome.value = found.value;
        outcome.goodness = goodness_of(found.chi_square, found.chi_square_sigma, found.largest_residual, kFrameSigmas);
        outcome.bad_pixels = found.bad_pixels;
        if (plan_.reduce)
            reduce(frame, job, worker);
    }
}

void Tracker::reduce(const Frame &frame, Job &job, unsigned worker) noexcept try {
    OnTarget &on_target = on_target_[worker];
    const double exposure_s = frame.exposure_s > 0 ? frame.exposure_s : plan_.timing.exposure_s;
    const bool fits =
        find_on_target(frame.camera_ns, exposure_s, frame.intervals, frame.interval_count, plan_.clock, on_target);
    job.unreduced = fits ? plan_.reduce(on_target, job.reduction) : Reason::no_orbit;
} catch (...) {
    job.failure = std::current_exception();
}

// Cells in the order of the plan's columns.
Cells Tracker::cells_of(const Frame &frame, const Job &job) const noexcept {
    Cells cells = plan_.columns.empty();
    const auto cell = [&](OwnColumn column) -> uint64_t & { return cells[static_cast<size_t>(column)]; };
    cell(OwnColumn::exposure_s) = with_bits<uint64_t>(frame.exposure_s);
    cell(OwnColumn::shift_s) = with_bits<uint64_t>(mean_shift_s(frame));
    cell(OwnColumn::window_row) = static_cast<uint64_t>(frame.window_row);
    cell(OwnColumn::window_col) = static_cast<uint64_t>(frame.window_col);
    if (job.outcome.flaw.reason != Reason::none)
        return cells;
    cell(OwnColumn::intervals) = frame.interval_count;
    if (plan_.reduce)
        store(job.unreduced == Reason::none ? &job.reduction : nullptr, cells);
    cell(OwnColumn::chi_square) = with_bits<uint64_t>(job.estimated.chi_square);
    cell(OwnColumn::chi_square_sigma) = with_bits<uint64_t>(job.estimated.chi_square_sigma);
    cell(OwnColumn::largest_residual) = with_bits<uint64_t>(job.estimated.largest_residual);
    cell(OwnColumn::bad_pixels) = job.estimated.bad_pixels;
    cell(OwnColumn::flags) = job.estimated.flags;
    const size_t own = plan_.columns.own();
    for (size_t i = own; i < plan_.columns.count(); i++)
        cells[i] = with_bits<uint64_t>(job.estimated.further[i - own]);
    return cells;
}

Record Tracker::record_of(const Frame &frame, const Job &job) const noexcept {
    Record record;
    record.stream = job.stream;
    record.content = job.content;
    record.frame_id = frame.frame_id;
    record.camera_ns = frame.camera_ns;
    record.tai_ns = job.outcome.tai_ns;
    record.value = job.outcome.value;
    record.reason = job.outcome.flaw.reason;
    record.sigma = frame.sigma != 0 ? frame.sigma : plan_.terms.sigma;
    if (record.reason == Reason::none && job.estimated.sigma != 0)
        record.sigma = job.estimated.sigma;
    record.cells = arrange_(cells_of(frame, job));
    record.dropped = frame.dropped;
    const bool is_limited = !plan_.reduce; // otherwise the reduced value is: sample_of()
    record.kind = record.reason != Reason::none                                     ? Kind::rejected
                  : is_limited && std::fabs(record.value) > plan_.terms.value_limit ? Kind::outlier
                                                                                    : Kind::accepted;
    if (record.kind == Kind::accepted)
        record.reason = job.unreduced;
    return record;
}

// Decides on the verdict of an evaluated frame. Its record is appended before anything else changes.
void Tracker::register_frame(const Record &record, const Frame &frame, Outcome &outcome) {
    if (record.kind == Kind::rejected) {
        outcome.verdict = Verdict::rejected;
        return count_record(record, append_record(record));
    }
    const KnownFrame *known = index_.find(key_of(record));
    if (known == nullptr) {
        add_frame(record, frame.intervals, frame.interval_count);
        const Outcome estimated = outcome; // not in the record of every ledger
        outcome = outcome_of(record);
        outcome.goodness = estimated.goodness;
        outcome.bad_pixels = estimated.bad_pixels;
        return;
    }
    const bool quarantined = known->state() == FrameState::quarantined;
    if (!quarantined && known->content != record.content) {
        outcome.verdict = Verdict::quarantined;
        return quarantine(*known, record);
    }
    outcome.verdict = quarantined ? Verdict::quarantined : Verdict::duplicate;
    count_repeats(1);
}

// Returns the current outcome of a record: that of its key, which may have been quarantined since.
Outcome Tracker::outcome_of(const Record &record) const {
    Outcome outcome;
    outcome.flaw.reason = record.reason;
    outcome.tai_ns = plan_.clock.tai_ns(record.camera_ns).value_or(record.tai_ns);
    outcome.value = record.value;
    if (record.kind != Kind::accepted && record.kind != Kind::outlier && record.kind != Kind::quarantined)
        return outcome;
    outcome.goodness = goodness_.goodness(record.cells);
    outcome.bad_pixels = goodness_.bad_pixels(record.cells);
    outcome.sigma = record.sigma;
    if (const double value = value_of(record); std::isfinite(value))
        outcome.value = value;
    switch (index_.find(key_of(record))->state()) {
    case FrameState::accepted:
        outcome.verdict = Verdict::accepted;
        break;
    case FrameState::unreduced:
        outcome.verdict = Verdict::unreduced;
        break;
    case FrameState::outlier:
        outcome.verdict = Verdict::outlier;
        break;
    case FrameState::misfit:
        outcome.verdict = Verdict::misfit;
        break;
    default:
        outcome.verdict = Verdict::quarantined;
    }
    return outcome;
}

void Tracker::visit(uint64_t first, uint64_t most, const EachFrame &each) const {
    const Cells empty = columns_.empty();
    const auto visit_one = [&](const Record &record, uint64_t) {
        if (record.kind != Kind::intervals)
            return each(record, outcome_of(record));
        Record part = record; // whose cells are intervals
        part.cells = empty;
        each(part, outcome_of(part));
    };
    if (ledger_)
        return ledger_->visit(first, most, visit_one);
    for (uint64_t number = first; number < records() && number - first < most; number++)
        visit_one(read_record(number), number);
}

std::vector<double> Tracker::intervals_of(uint64_t number) const {
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

void Tracker::check_writable() const {
    if (access_ == Access::read)
        fail(Status::state, "{%s}: opened read-only", store_->path("").c_str());
}

void Tracker::push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done) {
    done = 0;
    check_writable();
    if (!estimate_)
        fail(Status::state, "created without an estimator: only merging is possible");
    std::atomic<size_t> next{0}; // dynamic: slower workers process fewer frames
    const auto evaluate_next = [&](size_t worker) noexcept {
        for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;)
            evaluate(frames[i], jobs_[i], static_cast<unsigned>(worker));
    };
    const auto workers = static_cast<unsigned>(std::min<size_t>(plan_.workers, count));
    if (workers > 1)
        run_jobs(workers, workers, evaluate_next);
    else
        evaluate_next(0);
    for (; done < count; done++) {
        if (jobs_[done].failure)
            std::rethrow_exception(std::exchange(jobs_[done].failure, nullptr));
        if (!has_uncommitted())
            oldest_ = std::chrono::steady_clock::now();
        Frame frame = frames[done];
        retry(frame, jobs_[done]);
        outcomes[done] = jobs_[done].outcome;
        const Record record = record_of(frame, jobs_[done]);
        const bool unnamed = names_ && record.kind != Kind::rejected && !streams_.is_named(record.stream);
        if (unnamed)
            names_->add(record.stream, frame.session, frame.roi);
        register_frame(record, frame, outcomes[done]);
        if (unnamed)
            streams_.set_named(record.stream);
    }
    if (has_uncommitted() && std::chrono::steady_clock::now() - oldest_ >= kCommitInterval)
        commit();
}

// Replaces a misfit by the frame that the caller gives for it, unless that is one, too.
void Tracker::retry(Frame &frame, Job &job) {
    const auto is_misfit = [this](const Job &one) {
        return one.outcome.flaw.reason == Reason::none && bin_of(one.outcome.goodness.chi_square) > limit_;
    };
    Frame other = frame;
    if (!plan_.retry || !is_misfit(job) || !plan_.retry(frame, job.outcome, other))
        return;
    const auto second = std::make_unique<Job>();
    evaluate(other, *second, 0);
    if (second->failure)
        std::rethrow_exception(second->failure);
    if (second->outcome.flaw.reason != Reason::none || is_misfit(*second))
        return;
    frame = other;
    job = *second;
}

bool Tracker::has_uncommitted() const noexcept {
    return ledger_ && (records() > committed() || unrecorded_repeats_ > 0);
}

// Sorted, so that results do not depend on the order of arrival.
Series Tracker::series() const {
    std::vector<std::pair<period::Sample, Row>> samples;
    samples.reserve(static_cast<size_t>(counts_.accepted));
    visit(0, records(), [&](const Record &record, const Outcome &outcome) {
        Row row = {};
        if (outcome.verdict == Verdict::accepted)
            samples.emplace_back(*sample_of(record, row), row);
    });
    std::sort(samples.begin(), samples.end(), [](const auto &first, const auto &second) {
        const auto &[a, row_a] = first;
        const auto &[b, row_b] = second;
        return std::tie(a.t_high, a.t_low, a.y, a.sigma, row_a) < std::tie(b.t_high, b.t_low, b.y, b.sigma, row_b);
    });
    Series series;
    for (std::vector<double> *column : {&series.t, &series.y, &series.sigma})
        column->reserve(samples.size());
    const auto columns = static_cast<std::ptrdiff_t>(plan_.errors.count());
    for (const auto &[sample, row] : samples) {
        series.t.push_back(sample.t_high);
        series.y.push_back(sample.y);
        series.sigma.push_back(sample.sigma);
        series.rows.insert(series.rows.end(), row.begin(), row.begin() + columns);
    }
    return series;
}

std::vector<NamedStream> Tracker::streams() const {
    std::map<uint64_t, NamedStream> known;
    for (const StreamCount &count : streams_.all())
        known[count.digest].count = count;
    if (names_)
        names_->visit([&](uint64_t stream, const std::string &session, const std::string &roi) {
            const auto found = known.find(stream);
            if (found != known.end())
                found->second = {found->second.count, session, roi};
        });
    std::vector<NamedStream> streams;
    streams.reserve(known.size());
    for (auto &[digest, stream] : known)
        streams.push_back(std::move(stream));
    std::stable_sort(streams.begin(), streams.end(), [](const NamedStream &a, const NamedStream &b) {
        return std::tie(a.session, a.roi) < std::tie(b.session, b.roi);
    });
    return streams;
}

void Tracker::commit() {
    check_writable();
    record_repeats();
    if (ledger_)
        ledger_->commit();
}

std::vector<uint8_t> Tracker::checkpoint() const {
    Checkpoint point;
    point.salt = ledger_->salt();
    point.records = ledger_->count();
    point.chain = ledger_->chain_before(point.records);
    point.setup = setup().digest();
    point.repeats = unrecorded_repeats_;
    return to_bytes(point, sums_);
}

void Tracker::save() {
    check_writable();
    if (!ledger_)
        return;
    ledger_->check();
    record_repeats();
    const std::vector<uint8_t> sums = checkpoint(); // first, since it may run out of memory
    ledger_->sync();                                // before the checkpoint: it must not count records that may be lost
    names_->sync();
    replace_whole(*store_, Checkpoint::kName, sums);
}

} // namespace toliman::track
