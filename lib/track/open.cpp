// Tracker: creates a folder or resumes from it (recovery), and warns of damage.
// Method: write-ahead log with checkpoint. Resuming reads the whole ledger into index and counts, loads the sums from
// the checkpoint and pushes the records after it. Samples in the checkpoint whose keys a later record quarantines are
// retracted. If the sums then have another number of samples than frames are accepted, they are recomputed from the
// ledger.
// A lost or damaged checkpoint costs time, never a frame, but without it a ledger truncated at a record boundary is not
// detected.
// Order of writes: the setup before the checkpoint computed with it, the ledger fsync'ed before the checkpoint that
// counts it. A rebuild that reduces the frames again replaces ledger and setup as one (setup.cpp).
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "track/rewrite.hpp"
#include "track/tracker.hpp"

namespace toliman::track {

namespace {

// The ledger is the first file of a folder: if it is missing although another one exists, it was lost.
void check_not_lost(Store &store) {
    for (const char *name : {Checkpoint::kName, Setup::kName, Names::kName})
        if (store.size(name) >= 0 && store.size(LedgerFile::kName) < 0)
            fail(Status::format,
                 "{%s}: is missing although %s exists: the records of its frames are lost; push all frames again into "
                 "a new folder",
                 store.path(LedgerFile::kName).c_str(), name);
}

// What a writer that was killed has left. Only the holder of the lock calls it.
void discard_temporaries(Store &store) {
    std::vector<std::string> names = {Setup::kNewName}; // of a rebuild without its ledger
    for (const char *name : {LedgerFile::kName, Checkpoint::kName, Setup::kName, Setup::kNewName, Names::kName})
        names.push_back(temporary_of(name));
    for (const std::string &name : names)
        if (store.size(name) >= 0)
            store.discard(name);
}

} // namespace

bool has_state(Store &store) {
    check_not_lost(store);
    return store.size(LedgerFile::kName) >= 0 &&
           (store.size(Setup::kName) >= 0 || LedgerFile(store).size() != LedgerFile(store).header_size());
}

StateFolder open_state_folder(std::unique_ptr<Store> store, Access access, const Terms &terms) {
    StateFolder folder;
    folder.access = access;
    folder.store = std::move(store);
    if (access == Access::write)
        folder.store->lock(LedgerFile::kName);
    if (folder.store->size(LedgerFile::kName) >= 0)
        LedgerFile(*folder.store).check_terms(terms);
    folder.setup = load_setup(*folder.store);
    if (folder.setup && for_terms(folder.setup->grid, terms).digest() != folder.setup->grid.digest())
        folder.setup.reset();
    folder.has_checkpoint = folder.store->size(Checkpoint::kName) >= 0;
    folder.loaded = load_checkpoint(*folder.store);
    return folder;
}

// Readers, and trackers that only merge, need not name the estimator's values.
void Tracker::adopt_columns(const LedgerFile &file) {
    const std::string there = file.columns().further(), here = plan_.columns.further();
    if ((evaluation_.has_estimator() || !here.empty()) && there != here)
        fail(Status::mismatch, "{%s}: written with values \"%s\", this tracker has \"%s\"", file.path().c_str(),
             there.c_str(), here.c_str());
    records_.set_columns(file.columns());
    registry_.set_columns();
    evaluation_.set_columns(file.columns());
}

// A changed setup is written before the sums computed with it, but after memory for these is allocated.
void Tracker::open(StateFolder &folder) {
    const bool writing = records_.access() == Access::write;
    Store &store = *records_.store();
    check_not_lost(store);
    if (writing && store.size(LedgerFile::kName) < 0)
        LedgerFile::begin(store, plan_.terms, plan_.columns);
    check_setup(folder);
    adopt_columns(LedgerFile(store));
    if (folder.rebuild && plan_.reduce)
        reduce_again(folder);
    if (writing) {
        settle_setup(store);
        discard_temporaries(store);
    }
    read_ledger(folder);
    if (!folder.setup && !plan_.reference.is_given())
        refuse_reduced_records();
    records_.open_names();
    records_.names()->visit([this](uint64_t stream, const Names::Stream &) { registry_.streams().set_named(stream); });
    warn_of_damage(folder);
    resume_from_checkpoint(folder);
    period::Stream &sums = registry_.sums();
    const bool whole = sums.totals().count == counts().accepted;
    if (!whole) {
        folder.loaded.reset();
        sums.reset();
        registry_.push_accepted_from(0);
    }
    const bool changed = !folder.setup || folder.setup->digest() != setup().digest();
    if (!writing || (whole && !changed && folder.loaded))
        return;
    const std::vector<uint8_t> bytes = checkpoint();
    if (changed)
        replace_whole(store, Setup::kName, to_bytes(setup()));
    records_.sync_ledger();
    replace_whole(store, Checkpoint::kName, bytes);
}

// The limit of misfits where the checkpoint was written tells which frames its sums contain.
void Tracker::read_ledger(const StateFolder &folder) {
    const LedgerFile file(*records_.store());
    adopt_columns(file);
    if (plan_.reference.is_given())
        registry_.set_reducer(file.path());
    const Checkpoint none, &point = folder.loaded ? folder.loaded->checkpoint : none;
    registry_.begin_reading(file.count());
    records_.open(file.salt(), {point.salt, point.records, point.chain}, [&](const Record &record, uint64_t number) {
        if (number == point.records)
            registry_.mark_checkpoint();
        registry_.count_read(record, number);
    });
    if (records_.count() <= point.records)
        registry_.mark_checkpoint();
    registry_.mark_misfits();
}

// The checkpoint of the old ledger says nothing about the new one, but its sums are still there after a crash.
void Tracker::reduce_again(StateFolder &folder) {
    const Checkpoint none, &point = folder.loaded ? folder.loaded->checkpoint : none;
    const bool is_same = folder.setup && folder.setup->clock.points() == plan_.clock.points();
    const bool keep = is_same && folder.setup->reference.system == plan_.reference.system &&
                      folder.setup->reference.in_orbit == plan_.reference.in_orbit;
    if (folder.setup && folder.setup->reference.in_orbit && !plan_.reference.in_orbit)
        folder.log.warn("%s: was reduced for an observer in orbit, and is now reduced for one at the Earth's centre",
                        records_.path("").c_str());
    rewrite_ledger(*records_.store(), plan_.terms, setup(), plan_.reduce, keep,
                   {point.salt, point.records, point.chain}, folder.log);
    folder.loaded.reset();
    folder.has_checkpoint = false;
    folder.is_rewritten = true;
}

void Tracker::resume_from_checkpoint(StateFolder &folder) {
    if (folder.loaded && folder.loaded->checkpoint.salt != records_.salt())
        folder.loaded.reset();
    if (!folder.loaded)
        return;
    const Checkpoint &point = folder.loaded->checkpoint;
    registry_.count_repeats(unrecorded_repeats(point, records_.last_merge_of(records_.salt())));
    if (folder.rebuild || point.setup != setup().digest() ||
        folder.loaded->sums.grid().digest() != registry_.sums().grid().digest())
        return;
    registry_.sums() = std::move(folder.loaded->sums);
    registry_.push_accepted_from(point.records);
    registry_.push_changed(point.records);
}

// If the setup is lost, the values would otherwise count as not reduced, also those that wait for an observer file.
void Tracker::refuse_reduced_records() const {
    const size_t factor = columns().find(name_of(OwnColumn::factor));
    if (factor == columns().count())
        return;
    records_.visit(0, records_.count(), [&](const Record &record, uint64_t) {
        const bool was_reduced =
            record.reason != Reason::none || std::isfinite(with_bits<double>(record.cells[factor]));
        if (record.kind == Kind::accepted && was_reduced)
            fail(Status::argument,
                 "{options->reduction.sky} is NULL: %s, which stores the system, is missing or damaged: give the "
                 "system with "
                 "which the frames were reduced",
                 records_.path(Setup::kName).c_str());
    });
}

void Tracker::check_setup(const StateFolder &folder) const {
    if (!folder.setup)
        return;
    const std::string path = records_.path(Setup::kName);
    check_timing(folder.setup->timing, plan_.timing, path);
    const bool is_same_clock = folder.setup->clock.points() == plan_.clock.points();
    if (folder.rebuild && plan_.reference.is_given() && !plan_.reduce && !is_same_clock)
        fail(Status::argument,
             "{options->reduction.sky} is NULL: another clock changes the times for which the frames of %s are "
             "reduced: must be their system and observer",
             records_.path("").c_str());
    if (folder.rebuild)
        return;
    check_reference(folder.setup->reference, plan_.reference, path);
    if (folder.setup->grid.digest() != registry_.sums().grid().digest())
        fail(Status::mismatch,
             "{%s}: has another frequency grid, time offset, unit or nuisance functions: rebuild to change it",
             path.c_str());
    if (!is_same_clock)
        fail(Status::mismatch, "{%s}: has another clock: rebuild to change it", path.c_str());
    if (folder.setup->chi_limit != plan_.chi_limit)
        fail(Status::mismatch, "{%s}: has another limit of chi-square: rebuild to change it", path.c_str());
}

// Damage that is repaired or ignored may be the first sign of a failing disk.
void Tracker::warn_of_damage(const StateFolder &folder) const {
    const std::string point = records_.path(Checkpoint::kName);
    const char *const recomputed =
        "the sums are computed again from the ledger; records missing at its end are not detected";
    warn_of_torn(*records_.ledger(), records_.path(LedgerFile::kName), records_.access(), folder.log);
    if (folder.has_checkpoint && !folder.loaded)
        folder.log.warn("%s: is damaged: %s", point.c_str(), recomputed);
    else if (folder.loaded && folder.loaded->checkpoint.salt != records_.salt())
        folder.log.warn("%s: belongs to another ledger: %s", point.c_str(), recomputed);
    else if (records_.count() > 0 && !folder.loaded && !folder.is_rewritten &&
             records_.store()->size(Checkpoint::kName) < 0)
        folder.log.warn("%s: is missing: %s", point.c_str(), recomputed);
    const std::vector<StreamCount> streams = registry_.streams().all();
    const auto named = std::count_if(streams.begin(), streams.end(), [](const StreamCount &one) { return one.named; });
    if (static_cast<size_t>(named) < streams.size())
        folder.log.warn(
            "%s: is damaged or incomplete: the names of %zu of %zu sessions and regions are unknown until one of "
            "their frames is pushed again",
            records_.path(Names::kName).c_str(), streams.size() - static_cast<size_t>(named), streams.size());
}

} // namespace toliman::track
