// Tracker: a folder is begun, or taken up, and what is damaged in it is told.
#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "track/tracker.hpp"

namespace toliman::track {

Place open_place(std::unique_ptr<Store> store, Access access, const Terms &terms) {
    Place place;
    place.access = access;
    place.store = std::move(store);
    if (access == Access::write)
        place.store->lock(LedgerFile::kName);
    if (place.store->size(LedgerFile::kName) >= 0)
        LedgerFile(*place.store).check_terms(terms);
    place.setup = load_setup(*place.store);
    if (place.setup && for_terms(place.setup->grid, terms).digest() != place.setup->grid.digest())
        place.setup.reset();
    place.has_checkpoint = place.store->size(Checkpoint::kName) >= 0;
    place.loaded = load_checkpoint(*place.store);
    return place;
}

// The ledger is the first file of a folder, so that where it is missing beside any other it was lost.
void Tracker::begin_ledger() {
    for (const char *name : {Checkpoint::kName, Setup::kName, Names::kName})
        if (store_->size(name) >= 0)
            fail(
                Status::format,
                "{%s}: is missing, though %s is there: what it knew of its frames is lost; give all frames again, into "
                "a new folder",
                store_->path(LedgerFile::kName).c_str(), name);
    LedgerFile::begin(*store_, plan_.terms, plan_.columns);
}

// A reader, and who only merges, may know nothing of the estimator's values.
void Tracker::take_columns(const LedgerFile &file) {
    const std::string there = file.columns().further(), here = plan_.columns.further();
    if ((estimate_ || !here.empty()) && there != here)
        fail(Status::mismatch, "{%s}: made with values \"%s\", here \"%s\"", file.path().c_str(), there.c_str(),
             here.c_str());
    columns_ = file.columns();
    arrange_ = Arrangement(plan_.columns, columns_);
}

// A changed setup is there before sums that were made with it, but not before there is memory for these.
void Tracker::open(Place &place) {
    const bool writing = access_ == Access::write;
    if (writing && store_->size(LedgerFile::kName) < 0)
        begin_ledger();
    check_setup(place);
    const LedgerFile file(*store_);
    take_columns(file);
    const Checkpoint none, &point = place.loaded ? place.loaded->checkpoint : none;
    salt_ = file.salt();
    merged_[salt_].salt = salt_;
    ledger_.emplace(*store_, access_, plan_.terms, plan_.group, plan_.sync, Held{point.salt, point.lines, point.chain},
                    [this](const Record &record, uint64_t line) { note(record, line); });
    names_.emplace(*store_);
    if (writing)
        names_->begin();
    names_->visit([this](uint64_t stream, const std::string &, const std::string &) { streams_.set_named(stream); });
    tell_damage(place);
    take_checkpoint(place);
    const bool whole = sums_.totals().count == counts_.accepted;
    if (!whole) {
        place.loaded.reset();
        sums_.reset();
        sum_up(0);
    }
    const bool changed = !place.setup || place.setup->digest() != setup().digest();
    if (!writing || (whole && !changed && place.loaded))
        return;
    const std::vector<uint8_t> sums = checkpoint();
    if (changed)
        replace_whole(*store_, Setup::kName, to_bytes(setup()));
    ledger_->sync();
    replace_whole(*store_, Checkpoint::kName, sums);
}

void Tracker::take_checkpoint(Place &place) {
    if (place.loaded && place.loaded->checkpoint.salt != salt_)
        place.loaded.reset();
    if (!place.loaded)
        return;
    const Checkpoint &point = place.loaded->checkpoint;
    count_repeats(unrecorded_repeats(point, merged_.at(salt_)));
    if (place.rebuild || point.setup != setup().digest() || place.loaded->sums.grid().digest() != sums_.grid().digest())
        return;
    sums_ = std::move(place.loaded->sums);
    sum_up(point.lines);
}

void Tracker::check_setup(const Place &place) const {
    if (place.rebuild || !place.setup)
        return;
    const std::string path = store_->path(Setup::kName);
    if (place.setup->grid.digest() != sums_.grid().digest())
        fail(Status::mismatch, "{%s}: of another grid of frequencies, time offset or unit: rebuild for this one",
             path.c_str());
    if (!(place.setup->clock.points() == plan_.clock.points()))
        fail(Status::mismatch, "{%s}: of another clock: rebuild for this one", path.c_str());
}

// Pushes what is accepted of the lines from `first` on, and takes back what earlier ones brought and these deny. Frames
// that are quarantined by now are never pushed.
void Tracker::sum_up(uint64_t first) {
    ledger_->visit(first, ledger_->count(), [&](const Record &record, uint64_t) {
        if (record.kind != Kind::accepted && record.kind != Kind::quarantined)
            return;
        const Seen &seen = *index_.find(key_of(record));
        if (record.kind == Kind::accepted && seen.fate() == Fate::accepted)
            sums_.push(*sample_of(record));
        if (record.kind == Kind::quarantined && seen.line() < first)
            if (const auto sample = sample_of(ledger_->read(seen.line())))
                sums_.retract(*sample);
    });
}

// The first sign of a disk that fails, and what it costs.
void Tracker::tell_damage(const Place &place) const {
    const std::string point = store_->path(Checkpoint::kName);
    const char *const anew = "the sums are computed again from the ledger; records missing at its end are not detected";
    if (ledger_->torn() > 0)
        place.log.warn("%s: %llu bytes behind %llu whole records are not whole and are %s, as after a crash or by a "
                       "failing disk: give their frames again",
                       store_->path(LedgerFile::kName).c_str(), static_cast<unsigned long long>(ledger_->torn()),
                       static_cast<unsigned long long>(ledger_->count()),
                       access_ == Access::write ? "cut off" : "ignored");
    if (place.has_checkpoint && !place.loaded)
        place.log.warn("%s: is damaged: %s", point.c_str(), anew);
    else if (place.loaded && place.loaded->checkpoint.salt != salt_)
        place.log.warn("%s: is of another ledger: %s", point.c_str(), anew);
    else if (ledger_->count() > 0 && !place.loaded && store_->size(Checkpoint::kName) < 0)
        place.log.warn("%s: is missing: %s", point.c_str(), anew);
    const std::vector<StreamCount> streams = streams_.all();
    const auto named = std::count_if(streams.begin(), streams.end(), [](const StreamCount &one) { return one.named; });
    if (static_cast<size_t>(named) < streams.size())
        place.log.warn("%s: is damaged or incomplete: the names of %zu of %zu sessions and regions are not known "
                       "until a frame of theirs comes again",
                       store_->path(Names::kName).c_str(), streams.size() - static_cast<size_t>(named), streams.size());
}

} // namespace toliman::track
