// Method: the records are copied one by one into a temporary file, which replaces the ledger when it is complete and
// durable. Each record states that all before it are durable, which is true once the file has its name.
#include "track/rewrite.hpp"

#include <cmath>

#include "track/interval_records.hpp"

namespace toliman::track {

namespace {

class Rewriter {
  public:
    Rewriter(const Columns &from, const Setup &setup, const Reduce &reduce, bool keep)
        : columns_(from.further(), true, from.parameters()), arrange_(from, columns_), collector_(from), setup_(setup),
          reduce_(reduce), keep_(keep) {}

    const Columns &columns() const noexcept { return columns_; }

    // Appends the records of the new ledger that stand for an old one.
    void operator()(const Record &old, double sigma, LedgerWriter &writer) {
        if (old.kind == Kind::intervals)
            return collector_.add(old);
        Record record = old;
        record.cells = arrange_(old.cells);
        bool lost = false;
        const std::vector<double> intervals = collector_.of(old, lost);
        if (old.kind == Kind::accepted || old.kind == Kind::outlier)
            reduce(intervals, lost, record);
        else
            clear_reduction(columns_, record);
        for (const Record &part :
             interval_records(record, intervals.data(), intervals.size() / 2, columns_.count(), sigma))
            writer.append(part);
        writer.append(record);
    }

  private:
    void reduce(const std::vector<double> &intervals, bool lost, Record &record) {
        const auto cell = [&](OwnColumn column) -> uint64_t & { return record.cells[static_cast<size_t>(column)]; };
        if (lost)
            mark_lost_intervals(columns_, record);
        const double own = with_bits<double>(cell(OwnColumn::exposure_s));
        const double exposure_s = own > 0 ? own : setup_.timing.exposure_s;
        Reduction reduction;
        const Reason reason = lost ? Reason::no_intervals
                              : find_on_target(record.camera_ns, exposure_s, intervals.data(), intervals.size() / 2,
                                               setup_.clock, on_target_)
                                  ? reduce_(on_target_, reduction)
                                  : Reason::no_orbit;
        const bool is_reduced = std::isfinite(with_bits<double>(cell(OwnColumn::factor)));
        if (reason != Reason::none && keep_ && is_reduced)
            return;
        record.reason = record.kind == Kind::accepted ? reason : Reason::none;
        store(reason == Reason::none ? &reduction : nullptr, record.cells);
    }

    Columns columns_;
    Arrangement arrange_;
    IntervalCollector collector_;
    const Setup &setup_;
    const Reduce &reduce_;
    bool keep_;
    OnTarget on_target_;
};

} // namespace

void warn_of_torn(const Ledger &ledger, const std::string &path, Access access, const Log &log) {
    if (ledger.torn() > 0)
        log.warn("%s: %llu bytes after %llu valid records are incomplete and were %s, as after a crash or by a "
                 "failing disk: push their frames again",
                 path.c_str(), static_cast<unsigned long long>(ledger.torn()),
                 static_cast<unsigned long long>(ledger.count()), access == Access::write ? "removed" : "ignored");
}

void rewrite_ledger(Store &store, const Terms &terms, Setup setup, const Reduce &reduce, bool keep, CheckpointMark mark,
                    const Log &log) {
    const Ledger old(store, Access::write, terms, 1, Sync::none, mark, [](const Record &, uint64_t) {});
    warn_of_torn(old, store.path(LedgerFile::kName), Access::write, log);
    Rewriter rewrite(old.columns(), setup, reduce, keep);
    Reducer(rewrite.columns(), setup.reference, setup.errors,
            store.path(LedgerFile::kName)); // refuses before anything is written
    LedgerWriter writer(store, terms, rewrite.columns());
    old.visit(0, old.count(), [&](const Record &record, uint64_t) {
        if (record.kind != Kind::merged || record.stream != old.salt())
            return rewrite(record, terms.sigma, writer);
        MergeMark own = merge_mark_of(record); // of the repeats of this ledger itself
        own.salt = writer.salt();
        own.records = static_cast<int64_t>(writer.count());
        own.chain = writer.chain();
        writer.append(to_record(own, terms.sigma, rewrite.columns().empty()));
    });
    setup.salt = writer.salt();
    replace_whole(store, Setup::kNewName, to_bytes(setup));
    writer.finish();
}

} // namespace toliman::track
