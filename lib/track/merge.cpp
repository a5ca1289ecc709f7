// Tracker: merges the records of another folder.
// Method: frames are identified by their keys, so that every record is examined on each merge and known frames are
// skipped. Only counts of frames without records (repeats) and of rejected frames depend on what was merged before: a
// mark per foreign ledger, by its salt, holds the number of records and repeats already counted and the checksum of the
// last record. If that checksum no longer matches, all records count as new.
// Sums are exact, so that those of the other checkpoint are added as they are if all of its frames are new here: a
// million samples would take seconds.
// Salvage reads every record that is valid by itself and skips the others.
#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "track/tracker.hpp"

namespace toliman::track {

namespace {

// Fails if the other ledger has a column that this one lacks: its numbers would be dropped silently. Parameters serve
// trends alone; ledgers of version 0.2 have none.
void check_columns(const LedgerFile &file, const Columns &here) {
    for (const Column &column : file.columns().all()) {
        if (column.role == ColumnRole::parameter)
            continue;
        const size_t at = here.find(column.name);
        if (at == here.count() || here.all()[at].type != column.type)
            fail(Status::mismatch, "{%s}: has the column %s, which this tracker's ledger does not have",
                 file.path().c_str(), column.name.c_str());
    }
}

void check_same_setup(const Setup &theirs, const Plan &plan, const std::string &path) {
    check_timing(theirs.timing, plan.timing, path);
    check_reference(theirs.reference, plan.reference, path);
    if (plan.reference.is_given() && !(theirs.clock.points() == plan.clock.points()))
        fail(Status::mismatch, "{%s}: its frames are reduced for the times of another clock", path.c_str());
}

} // namespace

Tracker::Foreign Tracker::foreign(const Columns &columns, bool is_known) const {
    return {Arrangement(columns, records_.columns()), IntervalCollector(columns), is_known};
}

// In the columns of this ledger.
Record Tracker::Foreign::record(const Record &found) const noexcept {
    Record record = found;
    record.cells = arrange(found.cells);
    return record;
}

uint64_t Tracker::merge(Store &other, bool salvage) {
    records_.check_writable();
    registry_.settle();
    const std::optional<Loaded> loaded =
        load_checkpoint(other); // before the ledger, to which a writer may be appending
    const LedgerFile file(other);
    file.check_terms(plan_.terms);
    if (records_.ledger() != nullptr && file.salt() == records_.salt())
        fail(Status::argument, "{%s}: is the tracker's own ledger, or a copy of it", file.path().c_str());
    check_columns(file, columns());
    const std::optional<Setup> theirs = load_setup(other);
    if (theirs)
        check_same_setup(*theirs, plan_, other.path(Setup::kName));
    uint64_t lost = 0;
    if (salvage)
        lost = merge_salvaged_records(file, loaded ? loaded->checkpoint : Checkpoint(), theirs.has_value());
    else
        merge_all_records(other, loaded, theirs.has_value());
    if (records_.names() != nullptr)
        merge_names(Names(other));
    records_.commit();
    return lost;
}

// Whether the sums of a checkpoint are those of its whole ledger, computed with this tracker's setup.
bool Tracker::has_all_sums(const Ledger &theirs, const std::optional<Loaded> &loaded) const {
    return loaded && loaded->checkpoint.salt == theirs.salt() && loaded->checkpoint.records == theirs.count() &&
           loaded->checkpoint.setup == setup().digest() &&
           loaded->sums.grid().digest() == registry_.sums().grid().digest();
}

// Merges an undamaged ledger.
void Tracker::merge_all_records(Store &other, const std::optional<Loaded> &loaded, bool is_known) {
    const Checkpoint none, &point = loaded ? loaded->checkpoint : none;
    const Ledger theirs(other, Access::read, plan_.terms, 1, Sync::none, {point.salt, point.records, point.chain},
                        [](const Record &, uint64_t) {});
    const std::string path = other.path(LedgerFile::kName);
    Foreign from = foreign(theirs.columns(), is_known);
    const MergeMark before = records_.last_merge_of(theirs.salt());
    const auto records = static_cast<uint64_t>(before.records);
    const bool is_continuation = records <= theirs.count() && theirs.chain_before(records) == before.chain;
    const uint64_t counted = is_continuation ? records : 0;
    std::map<uint64_t, MergeMark> counted_there; // the other ledger's own repeats, and those of ledgers merged into it
    registry_.begin_waiting();
    try {
        theirs.visit(0, theirs.count(), [&](const Record &record, uint64_t number) {
            if (record.kind == Kind::merged)
                counted_there[record.stream] = merge_mark_of(record);
            else if (record.kind == Kind::intervals)
                from.intervals.add(record);
            else if (!merge_record(record, from, number >= counted))
                fail(Status::format, "{%s}: record %llu: quarantines an unknown frame", path.c_str(),
                     static_cast<unsigned long long>(number));
        });
        registry_.settle(has_all_sums(theirs, loaded) ? &loaded->sums : nullptr);
    } catch (...) {
        try {
            registry_.settle();
        } catch (...) { // the next call does it
        }
        throw;
    }
    MergeMark merged = {theirs.salt(), static_cast<int64_t>(theirs.count()), 0, theirs.chain_before(theirs.count())};
    merged.repeats = point.salt == theirs.salt() ? unrecorded_repeats(point, counted_there[theirs.salt()]) : 0;
    for (const auto &[salt, there] : counted_there)
        merged.repeats = std::min(merged.repeats + there.repeats, 2 * kMaxRepeats);
    merged.repeats = std::max(merged.repeats, before.repeats);
    if (merged.repeats > kMaxRepeats || counts().repeated + merged.repeats - before.repeats > 2 * kMaxRepeats)
        fail(Status::format, "{%s}: impossible counts of repeated frames", path.c_str());
    if (merged.records == before.records && merged.chain == before.chain && merged.repeats == before.repeats)
        return;
    const Record mark = to_record(merged, plan_.terms.sigma, columns().empty());
    registry_.count_record(mark, records_.append(mark));
}

uint64_t Tracker::merge_salvaged_records(const LedgerFile &file, const Checkpoint &point, bool is_known) {
    Foreign from = foreign(file.columns(), is_known);
    const uint64_t lost = file.salvage([&](const Record &found, uint64_t) {
        if (found.kind == Kind::intervals)
            from.intervals.add(found);
        if (found.kind == Kind::intervals || found.kind == Kind::merged || merge_record(found, from, true))
            return;
        // The record of the quarantined frame is lost: an outlier in its place keeps the key known and out of the sums.
        Record stand_in = from.record(found);
        stand_in.kind = Kind::outlier;
        stand_in.dropped = 0;
        registry_.add_frame(stand_in);
        merge_record(found, from, true);
    });
    const uint64_t records = file.count();
    return lost + (point.salt == file.salt() && point.records > records ? point.records - records : 0);
}

// is_new: not counted by an earlier merge. Returns false for a record that quarantines an unknown frame.
bool Tracker::merge_record(const Record &found, const Foreign &from, bool is_new) {
    const Record theirs = from.record(found);
    if (theirs.kind == Kind::rejected) {
        if (is_new)
            registry_.count_record(theirs, records_.append(theirs));
        return true;
    }
    const KnownFrame *known = registry_.find(key_of(theirs));
    if (known == nullptr && theirs.kind == Kind::quarantined)
        return false;
    if (known == nullptr) {
        Record record = theirs;
        if (!from.is_known && columns().is_reduced())
            forget_reduction(columns(), record);
        record.tai_ns = plan_.clock.tai_ns(record.camera_ns).value_or(record.tai_ns);
        bool lost = false;
        const std::vector<double> intervals = from.intervals.of(found, lost);
        if (lost)
            mark_lost_intervals(columns(), record);
        registry_.add_frame(record, intervals.data(), intervals.size() / 2);
        return true;
    }
    registry_.settle(); // the sums of the other checkpoint may contain this frame
    const bool conflicts = theirs.kind == Kind::quarantined || known->content != theirs.content;
    if (conflicts && known->state() != FrameState::quarantined)
        registry_.quarantine(*known, theirs);
    else if (is_new)
        registry_.count_repeats(1);
    return true;
}

void Tracker::merge_names(const Names &names) {
    names.visit([this](uint64_t stream, const Names::Stream &name) {
        Streams &streams = registry_.streams();
        if (streams.find(stream).empty() || streams.is_named(stream))
            return;
        records_.names()->add(stream, name.session, name.roi, name.restarts);
        streams.set_named(stream);
    });
}

} // namespace toliman::track
