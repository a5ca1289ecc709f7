// Tracker: lines of other folders.
#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "track/tracker.hpp"

namespace toliman::track {

namespace {

// No number of theirs is lost in silence.
void check_columns(const LedgerFile &file, const Columns &here) {
    for (const Column &column : file.columns().all()) {
        const size_t at = here.find(column.name);
        if (at == here.count() || here.all()[at].type != column.type)
            fail(Status::mismatch, "{%s}: made with the column %s, which this tracker's ledger does not have",
                 file.path().c_str(), column.name.c_str());
    }
}

Record arranged(Record record, const Arrangement &arrange) noexcept {
    record.cells = arrange(record.cells);
    return record;
}

} // namespace

uint64_t Tracker::merge(Store &other, bool salvage) {
    check_writable();
    const std::optional<Loaded> loaded = load_checkpoint(other); // before the ledger, to which its writer may be adding
    const Checkpoint none, &point = loaded ? loaded->checkpoint : none;
    const LedgerFile file(other);
    file.check_terms(plan_.terms);
    if (ledger_ && file.salt() == ledger_->salt())
        fail(Status::argument, "{%s}: the tracker's own, or a copy of it", file.path().c_str());
    check_columns(file, columns_);
    uint64_t lost = 0;
    if (salvage)
        lost = merge_whole_lines(file, point);
    else
        merge_all_lines(other, point);
    if (names_)
        take_names(Names(other));
    commit();
    return lost;
}

// All lines are looked at each time, as frames are known by themselves; only counts ask what was merged before.
void Tracker::merge_all_lines(Store &other, const Checkpoint &point) {
    const Ledger theirs(other, Access::read, plan_.terms, 1, Sync::none, {point.salt, point.lines, point.chain},
                        [](const Record &, uint64_t) {});
    const std::string path = other.path(LedgerFile::kName);
    const Arrangement arrange(theirs.columns(), columns_);
    const Merged before = merged_before(theirs.salt());
    const auto lines = static_cast<uint64_t>(before.lines);
    const bool goes_on = lines <= theirs.count() && theirs.chain_before(lines) == before.chain;
    const uint64_t counted = goes_on ? lines : 0;
    std::map<uint64_t, Merged> counted_there; // repeats of theirs, and of what was merged there
    theirs.visit(0, theirs.count(), [&](const Record &record, uint64_t number) {
        if (record.kind == Kind::merged)
            counted_there[record.stream] = merged_of(record);
        else if (!merge_line(arranged(record, arrange), number >= counted))
            fail(Status::format, "{%s}: line %llu denies a frame that is not there", path.c_str(),
                 static_cast<unsigned long long>(number));
    });
    Merged merged = {theirs.salt(), static_cast<int64_t>(theirs.count()), 0, theirs.chain_before(theirs.count())};
    merged.repeats = point.salt == theirs.salt() ? unrecorded_repeats(point, counted_there[theirs.salt()]) : 0;
    for (const auto &[salt, there] : counted_there)
        merged.repeats = std::min(merged.repeats + there.repeats, 2 * kMostRepeats);
    merged.repeats = std::max(merged.repeats, before.repeats);
    if (merged.repeats > kMostRepeats || counts_.repeated + merged.repeats - before.repeats > 2 * kMostRepeats)
        fail(Status::format, "{%s}: impossible counts of frames that came again", path.c_str());
    if (merged.lines == before.lines && merged.chain == before.chain && merged.repeats == before.repeats)
        return;
    const Record mark = to_record(merged, plan_.terms.sigma, columns_.empty());
    note(mark, write_line(mark));
}

uint64_t Tracker::merge_whole_lines(const LedgerFile &file, const Checkpoint &point) {
    const Arrangement arrange(file.columns(), columns_);
    const uint64_t lost = file.salvage([&](const Record &found, uint64_t) {
        const Record record = arranged(found, arrange);
        if (record.kind == Kind::merged || merge_line(record, true))
            return;
        Record stand_in = record; // for the line that it denies, which is lost: a frame that came with two contents
        stand_in.kind = Kind::outlier;
        stand_in.dropped = 0;
        take_in(stand_in);
        merge_line(record, true);
    });
    const uint64_t lines = file.count();
    return lost + (point.salt == file.salt() && point.lines > lines ? point.lines - lines : 0);
}

// is_new: not counted by an earlier merge. False for a line that denies a frame which is not there.
bool Tracker::merge_line(const Record &theirs, bool is_new) {
    if (theirs.kind == Kind::rejected) {
        if (is_new)
            note(theirs, write_line(theirs));
        return true;
    }
    const Seen *seen = index_.find(key_of(theirs));
    if (seen == nullptr && theirs.kind == Kind::quarantined)
        return false;
    if (seen == nullptr) {
        Record record = theirs;
        record.tai_ns = plan_.clock.tai_ns(record.camera_ns).value_or(record.tai_ns);
        take_in(record);
        return true;
    }
    const bool denies = theirs.kind == Kind::quarantined || seen->content != theirs.content;
    if (denies && seen->fate() != Fate::quarantined)
        deny(*seen, theirs);
    else if (is_new)
        count_repeats(1);
    return true;
}

void Tracker::take_names(const Names &names) {
    names.visit([this](uint64_t stream, const std::string &session, const std::string &roi) {
        if (streams_.find(stream).empty() || streams_.is_named(stream))
            return;
        names_->add(stream, session, roi);
        streams_.set_named(stream);
    });
}

} // namespace toliman::track
