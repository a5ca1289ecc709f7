// Method: event sourcing. The records hold one entry per decision about a frame and are the truth; index, counts and
// sums are derived from them.
// Threads: workers evaluate frames in parallel. Registration is sequential, so that threads change no bit.
#include "track/tracker.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "base/error.hpp"

namespace toliman::track {

Tracker::Tracker(Plan plan, Estimate estimate, StateFolder folder, period::Stream &sums)
    : plan_(std::move(plan)), records_(plan_, std::move(folder.store), folder.access), registry_(plan_, records_, sums),
      evaluation_(plan_, std::move(estimate), registry_) {
    if (records_.store() != nullptr)
        open(folder);
    else if (plan_.reference.is_given())
        registry_.set_reducer("options->values");
}

void Tracker::push(const Frame *frames, size_t count, Outcome *outcomes, size_t &done) {
    done = 0;
    records_.check_writable();
    if (!evaluation_.has_estimator())
        fail(Status::state, "created without an estimator: only merging is possible");
    registry_.settle();
    evaluation_.run(frames, count);
    for (; done < count; done++) {
        Job &job = evaluation_.result(done);
        records_.begin_waiting();
        Frame frame = frames[done];
        evaluation_.retry(frame, job);
        outcomes[done] = job.outcome;
        const Record record = evaluation_.record_of(frame, job);
        const bool unnamed = records_.names() != nullptr && record.kind != Kind::rejected &&
                             !registry_.streams().is_named(record.stream);
        if (unnamed)
            records_.names()->add(record.stream, frame.session, frame.roi, frame.restarts);
        registry_.register_frame(record, frame, outcomes[done]);
        if (unnamed)
            registry_.streams().set_named(record.stream);
    }
    records_.commit_if_due();
}

void Tracker::visit(uint64_t first, uint64_t most, const EachFrame &each) const {
    const Cells empty = columns().empty();
    records_.visit(first, most, [&](const Record &record, uint64_t number) {
        if (record.kind != Kind::intervals)
            return each(record, registry_.outcome_of(record, number));
        Record part = record; // whose cells are intervals
        part.cells = empty;
        each(part, registry_.outcome_of(part, number));
    });
}

// Sorted, so that results do not depend on the order of arrival.
Series Tracker::series() const {
    std::vector<std::pair<period::Sample, Row>> samples;
    samples.reserve(static_cast<size_t>(counts().accepted));
    visit(0, records(), [&](const Record &record, const Outcome &outcome) {
        Row row = {};
        if (outcome.verdict == Verdict::accepted)
            samples.emplace_back(*registry_.sample_of(record, row), row);
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
    for (const StreamCount &count : registry_.streams().all())
        known[count.digest].count = count;
    if (const Names *const names = records_.names())
        names->visit([&](uint64_t digest, const Names::Stream &name) {
            const auto found = known.find(digest);
            if (found != known.end())
                found->second.name = name;
        });
    std::vector<NamedStream> streams;
    streams.reserve(known.size());
    for (auto &[digest, stream] : known)
        streams.push_back(std::move(stream));
    std::stable_sort(streams.begin(), streams.end(), [](const NamedStream &a, const NamedStream &b) {
        return std::tie(a.name.session, a.name.roi, a.name.restarts) <
               std::tie(b.name.session, b.name.roi, b.name.restarts);
    });
    return streams;
}

std::vector<uint8_t> Tracker::checkpoint() const {
    Checkpoint point;
    const Ledger &ledger = *records_.ledger();
    point.salt = ledger.salt();
    point.records = ledger.count();
    point.chain = ledger.chain_before(point.records);
    point.setup = setup().digest();
    point.repeats = records_.unrecorded_repeats();
    return to_bytes(point, registry_.sums());
}

void Tracker::save() {
    records_.check_writable();
    if (records_.ledger() == nullptr)
        return;
    registry_.settle();
    records_.ledger()->check();
    records_.record_repeats();
    const std::vector<uint8_t> sums = checkpoint(); // first, since it may run out of memory
    records_.sync_ledger();                         // before the checkpoint: it must not count records that may be lost
    records_.sync_names();
    replace_whole(*records_.store(), Checkpoint::kName, sums);
}

} // namespace toliman::track
