// Prints and writes what a state folder contains: records of its ledger, status, results.
#pragma once
#include "downlink/folder_facts.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

// Records first, first + 1 ... of the ledger, up to `count`, and the numbers of a column of theirs.
std::vector<toliman_track_record> records_of(const toliman::tracker &tracker, int64_t first, size_t count);
// In chunks: a million records take 200 MB.
void each_record(const toliman::tracker &tracker, const std::function<void(const toliman_track_record &)> &each);
std::vector<double> column_of(const toliman::tracker &tracker, const std::string &name, int64_t first, size_t count);

// A session whose name is lost is called # and its digest; its region is "".
std::vector<toliman_track_stream> streams_of(const toliman::tracker &tracker);
// JSON lines, schema toliman-record/1.
void print_records(const toliman::tracker &tracker);
// CSV t,y,sigma of the samples in the periodogram; t in units of how.grid.unit_ns of TAI since
// how.grid.time_offset_ns.
void print_series(const toliman::tracker &tracker, const toliman_track_options &how);
// CSV session,roi,first,last,restarts of missing frame ids.
void print_missing(const toliman::tracker &tracker);

// Median sigma of the frames with a value, as their estimator gave them; nothing if there are none.
std::optional<double> median_sigma(const toliman::tracker &tracker);

// Schema toliman-track-status/2.
Json status_json(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period);

// Writes result.json (schema toliman-state/1), series.csv, periodogram.csv and, with a fit, residual_periodogram.csv,
// all or none; creates the folder.
void write_results(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period,
                   const std::string &folder);

} // namespace cli
