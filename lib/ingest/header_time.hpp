// Time of the first frame of a FITS file, from the keywords of its header.
#pragma once
#include <functional>
#include <string>

#include "ingest/leap_seconds.hpp"

namespace toliman::ingest {

// Text of a keyword as the header has it, nullptr if it is missing.
using Keywords = std::function<const char *(const char *key)>;

struct HeaderTime {
    int64_t tai_ns;    // middle of the exposure, if its length is known
    int64_t length_ns; // of the exposure, from its start to its end; 0: unknown
    bool assumed;      // TIMESYS or the exposure is missing
    bool expired;      // in UTC, on the day `expires` or later
    std::string rule;  // in words
};

// expires: MJD. Status::not_found without a time, Status::format and Status::range, with the keyword, for a bad one and
// for two that contradict each other.
HeaderTime header_time(const Keywords &value_of, const LeapSeconds &leap_seconds, int64_t expires);

} // namespace toliman::ingest
