// What stands in a ledger, line by line, on standard output.
#pragma once
#include <functional>
#include <vector>

#include <toliman/toliman.hpp>

namespace cli {

// A session whose name is not known has # and its digest in place of it, and an empty region.
std::vector<toliman_track_stream> streams_of(const toliman::tracker &tracker);
// Every line, in the order of arrival.
void for_lines(const toliman::tracker &tracker, const std::function<void(const toliman_track_record &line)> &work);
// Of a line, in units of unit_ns of TAI since offset_ns.
double time_of(const toliman_track_record &line, int64_t offset_ns, double unit_ns);
// One line of JSON each, schema toliman-record/1.
void print_records(const toliman::tracker &tracker);
// CSV t,y,sigma of what is in the periodogram; t in units of unit_ns of TAI since offset_ns.
void print_series(const toliman::tracker &tracker, int64_t offset_ns, double unit_ns);
// CSV session,roi,first,last of frame ids that are missing between others.
void print_missing(const toliman::tracker &tracker);

} // namespace cli
