#include "track/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::track {

namespace {

constexpr std::chrono::seconds kLongestWait{1};

uint64_t key_of(const Record &record) noexcept {
    return key_digest(record.stream, record.frame_id);
}

} // namespace

Tracker::Tracker(Plan plan, Estimate estimate, Place place, period::Stream &sums)
    : plan_(std::move(plan)), estimate_(std::move(estimate)), store_(std::move(place.store)), access_(place.access),
      index_(plan_.capacity), streams_(plan_.capacity), sums_(sums) {
    plan_.terms.check();
    if (plan_.group < 1 || plan_.group > 65536)
        fail(Status::argument, "group = %zu: must be in [1, 65536]", plan_.group);
    images_.resize(plan_.workers * plan_.terms.geometry.out_rows * plan_.terms.geometry.out_cols);
    jobs_.resize(kBatch);
    if (!store_) {
        memory_.resize(static_cast<size_t>(plan_.capacity));
        return;
    }
    if (access_ == Access::write && store_->size(Ledger::kName) < 0 && store_->size(Checkpoint::kName) >= 0)
        fail(Status::format, "%s: missing, though the checkpoint of one is there", store_->path(Ledger::kName).c_str());
    Ledger::Held held;
    if (place.loaded && !place.rebuild)
        held = {place.loaded->checkpoint.salt, place.loaded->checkpoint.lines};
    ledger_.emplace(*store_, access_, plan_.terms, plan_.group, plan_.sync, held,
                    [this](const Record &record, uint64_t line) { note(record, line); });
    const bool fits = place.loaded && place.loaded->checkpoint.salt == ledger_->salt();
    if (fits)
        count_repeats(place.loaded->checkpoint.repeats);
    if (fits && !place.rebuild) {
        take_up(*place.loaded);
        return;
    }
    sum_up(0);
    if (access_ == Access::write)
        save(); // readers find the grid there
}

// The checkpoint's sums and the lines behind them.
void Tracker::take_up(const Loaded &loaded) {
    const Checkpoint &point = loaded.checkpoint;
    const std::string path = store_->path(Checkpoint::kName);
    if (point.lines > ledger_->count() || point.chain != ledger_->chain_before(point.lines))
        fail(Status::format,
             "%s: made of %llu lines, the ledger has %llu or others: lines were lost; rebuild to go on with what is "
             "left",
             path.c_str(), static_cast<unsigned long long>(point.lines),
             static_cast<unsigned long long>(ledger_->count()));
    if (loaded.sums.grid().digest() != sums_.grid().digest())
        fail(Status::mismatch, "%s: made on another grid of frequencies: rebuild it", path.c_str());
    if (!(point.clock.points() == plan_.clock.points()))
        fail(Status::mismatch, "%s: made with another clock: rebuild it", path.c_str());
    sums_ = loaded.sums;
    sum_up(point.lines);
}

// Pushes what is accepted of the lines from `first` on, and takes back what earlier ones brought and these deny. Frames
// that are quarantined by now are never pushed.
void Tracker::sum_up(uint64_t first) {
    ledger_->visit(first, [&](const Record &record, uint64_t line) {
        const Seen *seen = record.kind == Kind::rejected ? nullptr : index_.find(key_of(record));
        if (record.kind == Kind::accepted && seen->fate() == Fate::accepted) {
            const period::Sample sample = sample_of(record);
            try {
                sums_.check(sample, -1);
            } catch (const Error &error) {
                fail(error.status(), "%s: line %llu: %s", store_->path(Ledger::kName).c_str(),
                     static_cast<unsigned long long>(line), error.what());
            }
            sums_.push(sample);
        }
        if (record.kind == Kind::quarantined && seen->line() < first) {
            const Record denied = ledger_->read(seen->line());
            if (denied.kind == Kind::accepted)
                sums_.retract(sample_of(denied));
        }
    });
}

period::Sample Tracker::sample_of(const Record &record) const {
    return sums_.sample_ns(plan_.clock.tai_ns(record.camera_ns), record.value, record.sigma);
}

void Tracker::count_repeats(int64_t count) noexcept {
    counts_.received += count;
    counts_.repeated += count;
    unwritten_repeats_ += count;
}

void Tracker::note(const Record &record, uint64_t line) {
    if (record.kind == Kind::rejected) {
        counts_.rejected[static_cast<size_t>(record.reason)]++;
    } else if (record.kind != Kind::quarantined) {
        index_.check_room();
        streams_.check_room(record.stream);
        const bool accepted = record.kind == Kind::accepted;
        if (index_.find(key_of(record)) != nullptr)
            fail(Status::format, "%s: line %llu holds a frame that is there already",
                 store_->path(Ledger::kName).c_str(), static_cast<unsigned long long>(line));
        index_.add(key_of(record), record.content, line, accepted ? Fate::accepted : Fate::outlier);
        streams_.add(record.stream, record.frame_id);
        (accepted ? counts_.accepted : counts_.outlier)++;
        counts_.dropped += record.dropped;
    } else {
        const Seen *seen = index_.find(key_of(record));
        if (seen == nullptr || seen->fate() == Fate::quarantined)
            fail(Status::format, "%s: line %llu denies a frame that is not there", store_->path(Ledger::kName).c_str(),
                 static_cast<unsigned long long>(line));
        (seen->fate() == Fate::accepted ? counts_.accepted : counts_.outlier)--;
        counts_.quarantined++;
        counts_.repeated++;
        counts_.dropped -= record.dropped;
        index_.quarantine(*seen);
    }
    counts_.received++;
}

// In memory what is no frame's own needs no line.
uint64_t Tracker::write_line(const Record &record) {
    if (ledger_) {
        ledger_->append(record);
        return ledger_->count() - 1;
    }
    if (record.kind == Kind::accepted || record.kind == Kind::outlier)
        memory_[in_memory_++] = record;
    return in_memory_ - 1;
}

Record Tracker::read_line(uint64_t number) {
    return ledger_ ? ledger_->read(number) : memory_[number];
}

// By a worker: identity and, unless it is known, what there is to say of a frame.
void Tracker::look_at(const Frame &frame, Job &job, unsigned worker) noexcept {
    job = Job();
    job.stream = stream_digest(frame.session, frame.roi);
    job.content = content_of(frame);
    const Seen *seen = index_.find(key_digest(job.stream, frame.frame_id));
    if (seen == nullptr || seen->content != job.content)
        judge(frame, job, worker);
}

void Tracker::judge(const Frame &frame, Job &job, unsigned worker) {
    Outcome &outcome = job.outcome;
    const Terms &terms = plan_.terms;
    double *image = images_.data() + worker * terms.geometry.out_rows * terms.geometry.out_cols;
    outcome.flaw = take(frame, terms.geometry, image);
    if (outcome.flaw.reason != Reason::none)
        return;
    try {
        outcome.tai_ns = plan_.clock.tai_ns(frame.camera_ns);
        sums_.check(sums_.sample_ns(outcome.tai_ns, 0, terms.sigma), -1);
    } catch (const Error &) {
        outcome.flaw.reason = Reason::clock;
        return;
    }
    try {
        outcome.value = estimate_(image, worker);
    } catch (...) {
        outcome.flaw.reason = Reason::estimate;
        return;
    }
    if (!std::isfinite(outcome.value))
        outcome.flaw = {Reason::estimate, 0, 0, std::exchange(outcome.value, 0)};
}

Record Tracker::record_of(const Frame &frame, const Job &job) const noexcept {
    Record record;
    record.stream = job.stream;
    record.content = job.content;
    record.frame_id = frame.frame_id;
    record.camera_ns = frame.camera_ns;
    record.tai_ns = job.outcome.tai_ns;
    record.value = job.outcome.value;
    record.sigma = plan_.terms.sigma;
    record.reason = job.outcome.flaw.reason;
    record.dropped = static_cast<uint16_t>(std::clamp<int64_t>(frame.dropped, 0, UINT16_MAX));
    record.kind = record.reason != Reason::none                       ? Kind::rejected
                  : std::fabs(record.value) > plan_.terms.value_limit ? Kind::outlier
                                                                      : Kind::accepted;
    return record;
}

// A frame that was looked at, or a line of another ledger. Its own line is added before anything else is touched.
void Tracker::settle(const Record &record, Outcome &outcome) {
    if (record.kind == Kind::rejected) {
        outcome.verdict = Verdict::rejected;
        return note(record, write_line(record));
    }
    const Seen *seen = index_.find(key_of(record));
    if (seen == nullptr) {
        outcome.verdict = record.kind == Kind::accepted ? Verdict::accepted : Verdict::outlier;
        return take_in(record);
    }
    const bool quarantined = seen->fate() == Fate::quarantined;
    if (!quarantined && seen->content != record.content) {
        outcome.verdict = Verdict::quarantined;
        return deny(*seen, record);
    }
    outcome.verdict = quarantined ? Verdict::quarantined : Verdict::duplicate;
    count_repeats(1);
}

void Tracker::take_in(const Record &record) {
    index_.check_room();
    streams_.check_room(record.stream);
    if (record.kind != Kind::accepted)
        return note(record, write_line(record));
    const period::Sample sample = sample_of(record);
    sums_.check(sample, -1);
    note(record, write_line(record));
    sums_.push(sample);
}

void Tracker::deny(const Seen &seen, Record record) {
    const Record denied = read_line(seen.line());
    record.kind = Kind::quarantined;
    record.dropped = denied.dropped; // what is no longer counted
    note(record, write_line(record));
    if (denied.kind == Kind::accepted)
        sums_.retract(sample_of(denied));
}

void Tracker::check_writable() const {
    if (access_ == Access::read)
        fail(Status::state, "%s: opened for reading only", store_->path("").c_str());
}

void Tracker::push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done) {
    done = 0;
    check_writable();
    if (!estimate_)
        fail(Status::state, "made without an estimator: frames come by merging only");
    const auto look = [&](unsigned worker, unsigned workers) noexcept {
        for (size_t i = worker; i < count; i += workers)
            look_at(frames[i], jobs_[i], worker);
    };
    const auto workers = static_cast<unsigned>(std::min<size_t>(plan_.workers, count));
    if (workers > 1)
        run_jobs(workers, workers, [&](size_t worker) { look(static_cast<unsigned>(worker), workers); });
    else
        look(0, 1);
    for (; done < count; done++) {
        if (lines() == committed())
            oldest_ = std::chrono::steady_clock::now();
        outcomes[done] = jobs_[done].outcome;
        settle(record_of(frames[done], jobs_[done]), outcomes[done]);
    }
    if (lines() > committed() && std::chrono::steady_clock::now() - oldest_ >= kLongestWait)
        commit();
}

void Tracker::merge(Store &other) {
    check_writable();
    const std::optional<Loaded> loaded = load(other); // before the ledger, to which its writer may be adding
    Ledger::Held held;
    if (loaded)
        held = {loaded->checkpoint.salt, loaded->checkpoint.lines};
    Ledger lines(other, Access::read, plan_.terms, 1, Sync::none, held, [](const Record &, uint64_t) {});
    lines.visit(0, [&](const Record &theirs, uint64_t number) {
        Record record = theirs;
        if (record.kind == Kind::quarantined && index_.find(key_of(record)) == nullptr)
            fail(Status::format, "%s: line %llu denies a frame that is not there", other.path(Ledger::kName).c_str(),
                 static_cast<unsigned long long>(number));
        if (record.kind == Kind::accepted || record.kind == Kind::outlier)
            record.tai_ns = plan_.clock.tai_ns(record.camera_ns);
        Outcome outcome;
        settle(record, outcome);
    });
    if (loaded && loaded->checkpoint.salt == lines.salt())
        count_repeats(loaded->checkpoint.repeats);
    commit();
}

void Tracker::commit() {
    check_writable();
    if (ledger_)
        ledger_->commit();
}

void Tracker::save() {
    check_writable();
    if (!ledger_)
        return;
    ledger_->sync(); // lines that the sums hold must not be lost without them
    Checkpoint point;
    point.salt = ledger_->salt();
    point.lines = ledger_->count();
    point.chain = ledger_->chain_before(point.lines);
    point.repeats = unwritten_repeats_;
    point.clock = plan_.clock;
    track::save(*store_, point, sums_);
}

} // namespace toliman::track
