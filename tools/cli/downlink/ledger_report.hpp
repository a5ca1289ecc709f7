// Prints records of a ledger.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

namespace cli {

// A session whose name is lost is called # and its digest; its region is "".
std::vector<toliman_track_stream> streams_of(const toliman::tracker &tracker);
// JSON lines, schema toliman-record/1.
void print_records(const toliman::tracker &tracker);
// CSV t,y,sigma of the samples in the periodogram, part by part; t in units of how.unit_ns of TAI since
// how.time_offset_ns.
void print_series(const toliman::tracker &tracker, const toliman_track_options &how,
                  const std::function<void(const std::string &text)> &print);
// CSV session,roi,first,last of missing frame ids.
void print_missing(const toliman::tracker &tracker);

} // namespace cli
