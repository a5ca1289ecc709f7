#include "track/tracker.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::track {

namespace {

constexpr std::chrono::seconds kLongestWait{1};

} // namespace

Tracker::Tracker(Plan plan, Estimate estimate, Place place, period::Stream &sums)
    : plan_(std::move(plan)), estimate_(std::move(estimate)), store_(std::move(place.store)), access_(place.access),
      index_(plan_.capacity), streams_(plan_.capacity), sums_(sums), columns_(plan_.columns),
      arrange_(columns_, columns_) {
    images_.resize(plan_.workers * plan_.terms.geometry.out_rows * plan_.terms.geometry.out_cols);
    jobs_.resize(kBatch);
    if (store_)
        open(place);
    else
        memory_.resize(static_cast<size_t>(plan_.capacity) * line_size(columns_.count()));
}

std::optional<period::Sample> Tracker::sample_of(const Record &record) const noexcept {
    const std::optional<int64_t> tai_ns = plan_.clock.tai_ns(record.camera_ns);
    if (record.kind != Kind::accepted || !tai_ns)
        return std::nullopt;
    const period::Sample sample = sums_.sample_ns(*tai_ns, record.value, record.sigma);
    return sums_.covers(sample) ? std::optional(sample) : std::nullopt;
}

void Tracker::count_repeats(int64_t count) noexcept {
    counts_.received += count;
    counts_.repeated += count;
    unrecorded_repeats_ += count;
}

// Frames that came again have no record of their own: one counts all of them so far.
void Tracker::record_repeats() {
    if (!ledger_ || unrecorded_repeats_ == 0 || lines() == LedgerFile::kMostLines)
        return;
    ledger_->check();
    Merged &own = merged_.at(salt_);
    const int64_t repeats = std::min(own.repeats + unrecorded_repeats_, kMostRepeats);
    const Merged mark = {salt_, static_cast<int64_t>(lines()), repeats, ledger_->chain_before(lines())};
    ledger_->append(to_record(mark, plan_.terms.sigma, columns_.empty()));
    own = mark;
    unrecorded_repeats_ = 0;
}

void Tracker::note(const Record &record, uint64_t line) {
    if (record.kind == Kind::merged)
        return take_merged(merged_of(record));
    if (record.kind == Kind::rejected)
        counts_.rejected[static_cast<size_t>(record.reason)]++;
    else if (record.kind == Kind::quarantined)
        note_denial(record, line);
    else
        note_frame(record, line);
    counts_.received++;
}

// A good frame whose time has no place in these sums is an outlier: with another clock it may come in.
void Tracker::note_frame(const Record &record, uint64_t line) {
    index_.check_room();
    streams_.check_room(record.stream);
    const bool accepted = sample_of(record).has_value();
    if (index_.find(key_of(record)) != nullptr)
        fail(Status::format, "{%s}: line %llu holds a frame that is there already",
             store_->path(LedgerFile::kName).c_str(), static_cast<unsigned long long>(line));
    index_.add(key_of(record), record.content, line, accepted ? Fate::accepted : Fate::outlier);
    streams_.add(record.stream, record.frame_id);
    (accepted ? counts_.accepted : counts_.outlier)++;
    counts_.dropped += record.dropped;
}

void Tracker::note_denial(const Record &record, uint64_t line) {
    const Seen *seen = index_.find(key_of(record));
    if (seen == nullptr || seen->fate() == Fate::quarantined)
        fail(Status::format, "{%s}: line %llu denies a frame that is not there",
             store_->path(LedgerFile::kName).c_str(), static_cast<unsigned long long>(line));
    (seen->fate() == Fate::accepted ? counts_.accepted : counts_.outlier)--;
    counts_.quarantined++;
    counts_.repeated++;
    counts_.dropped -= record.dropped;
    index_.quarantine(*seen);
}

Merged Tracker::merged_before(uint64_t salt) const noexcept {
    const auto found = merged_.find(salt);
    if (found != merged_.end())
        return found->second;
    Merged none;
    none.salt = salt;
    return none;
}

void Tracker::take_merged(const Merged &merged) {
    const int64_t repeats = merged.repeats - merged_before(merged.salt).repeats;
    if (counts_.repeated + repeats > 2 * kMostRepeats)
        fail(Status::format, "{%s}: impossible counts of merged lines", store_->path(LedgerFile::kName).c_str());
    merged_[merged.salt] = merged; // before anything changes, as it takes memory
    counts_.received += repeats;
    counts_.repeated += repeats;
}

// In memory what is no frame's own needs no line.
uint64_t Tracker::write_line(const Record &record) {
    if (ledger_) {
        ledger_->append(record);
        return ledger_->count() - 1;
    }
    if (record.kind == Kind::accepted || record.kind == Kind::outlier)
        to_bytes(record, columns_.count(), 0, 0, memory_.data() + in_memory_++ * line_size(columns_.count()));
    return in_memory_ - 1;
}

Record Tracker::read_line(uint64_t number) const {
    if (ledger_)
        return ledger_->read(number);
    Record record;
    uint32_t synced, chain = 0;
    from_bytes(memory_.data() + number * line_size(columns_.count()), columns_.count(), record, synced, chain);
    return record;
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
        return;
    }
    const Estimated &found = job.estimated;
    if (!std::isfinite(found.value)) {
        outcome.flaw = {Reason::estimate, 0, 0, found.value};
    } else if (found.sigma != 0 && !terms.allows_sigma(found.sigma)) {
        outcome.flaw = {Reason::estimate, 0, 0, found.sigma};
    } else {
        outcome.value = found.value;
        outcome.chi_square = found.chi_square;
    }
}

// By the plan's columns.
Cells Tracker::cells_of(const Frame &frame, const Job &job) const noexcept {
    Cells cells = plan_.columns.empty();
    const auto cell = [&](Own column) -> uint64_t & { return cells[static_cast<size_t>(column)]; };
    cell(Own::exposure_s) = with_bits<uint64_t>(frame.exposure_s);
    cell(Own::shift_s) = with_bits<uint64_t>(mean_shift_s(frame));
    cell(Own::window_row) = static_cast<uint64_t>(frame.window_row);
    cell(Own::window_col) = static_cast<uint64_t>(frame.window_col);
    if (job.outcome.flaw.reason != Reason::none)
        return cells;
    cell(Own::chi_square) = with_bits<uint64_t>(job.estimated.chi_square);
    cell(Own::flags) = job.estimated.flags;
    for (size_t i = kOwn; i < plan_.columns.count(); i++)
        cells[i] = with_bits<uint64_t>(job.estimated.further[i - kOwn]);
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
    const std::optional<period::Sample> sample = sample_of(record);
    note(record, write_line(record));
    if (sample)
        sums_.push(*sample);
}

void Tracker::deny(const Seen &seen, Record record) {
    const Record denied = read_line(seen.line());
    record.kind = Kind::quarantined;
    record.dropped = denied.dropped; // what is no longer counted
    note(record, write_line(record));
    if (const std::optional<period::Sample> sample = sample_of(denied))
        sums_.retract(*sample);
}

// What a line means by now.
Outcome Tracker::outcome_of(const Record &record) const {
    Outcome outcome;
    outcome.flaw.reason = record.reason;
    outcome.value = record.value;
    outcome.tai_ns = plan_.clock.tai_ns(record.camera_ns).value_or(record.tai_ns);
    if (record.kind == Kind::rejected || record.kind == Kind::merged)
        return outcome;
    constexpr Verdict kVerdicts[] = {Verdict::rejected, Verdict::accepted, Verdict::outlier, Verdict::quarantined};
    outcome.verdict = kVerdicts[static_cast<size_t>(index_.find(key_of(record))->fate())];
    return outcome;
}

void Tracker::visit(uint64_t first, uint64_t most, const EachFrame &each) const {
    const auto give = [&](const Record &record, uint64_t) { each(record, outcome_of(record)); };
    if (ledger_)
        return ledger_->visit(first, most, give);
    for (uint64_t number = first; number < in_memory_ && number - first < most; number++)
        give(read_line(number), number);
}

void Tracker::check_writable() const {
    if (access_ == Access::read)
        fail(Status::state, "{%s}: opened for reading only", store_->path("").c_str());
}

void Tracker::push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done) {
    done = 0;
    check_writable();
    if (!estimate_)
        fail(Status::state, "made without an estimator: frames come by merging only");
    std::atomic<size_t> next{0}; // a worker that is slower takes fewer frames
    const auto look = [&](size_t worker) noexcept {
        for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;)
            look_at(frames[i], jobs_[i], static_cast<unsigned>(worker));
    };
    const auto workers = static_cast<unsigned>(std::min<size_t>(plan_.workers, count));
    if (workers > 1)
        run_jobs(workers, workers, look);
    else
        look(0);
    for (; done < count; done++) {
        if (!has_waiting())
            oldest_ = std::chrono::steady_clock::now();
        outcomes[done] = jobs_[done].outcome;
        const Record record = record_of(frames[done], jobs_[done]);
        const bool unnamed = names_ && record.kind != Kind::rejected && !streams_.is_named(record.stream);
        if (unnamed)
            names_->add(record.stream, frames[done].session, frames[done].roi);
        settle(record, outcomes[done]);
        if (unnamed)
            streams_.set_named(record.stream);
    }
    if (has_waiting() && std::chrono::steady_clock::now() - oldest_ >= kLongestWait)
        commit();
}

bool Tracker::has_waiting() const noexcept {
    return ledger_ && (lines() > committed() || unrecorded_repeats_ > 0);
}

// Sorted, so that no order of arrival changes what is made of it.
Series Tracker::series() const {
    std::vector<period::Sample> samples;
    samples.reserve(static_cast<size_t>(counts_.accepted));
    visit(0, lines(), [&](const Record &record, const Outcome &outcome) {
        if (outcome.verdict == Verdict::accepted)
            samples.push_back(*sample_of(record));
    });
    std::sort(samples.begin(), samples.end(), [](const period::Sample &a, const period::Sample &b) {
        return std::tie(a.t_high, a.t_low, a.y, a.sigma) < std::tie(b.t_high, b.t_low, b.y, b.sigma);
    });
    Series series;
    for (std::vector<double> *column : {&series.t, &series.y, &series.sigma})
        column->reserve(samples.size());
    for (const period::Sample &sample : samples) {
        series.t.push_back(sample.t_high);
        series.y.push_back(sample.y);
        series.sigma.push_back(sample.sigma);
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
    point.lines = ledger_->count();
    point.chain = ledger_->chain_before(point.lines);
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
    const std::vector<uint8_t> sums = checkpoint(); // before anything else changes, as it takes the memory
    ledger_->sync();                                // lines that the sums hold must not be lost without them
    names_->sync();
    replace_whole(*store_, Checkpoint::kName, sums);
}

} // namespace toliman::track
