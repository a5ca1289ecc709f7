// Times on the command line: dates, Modified Julian Days or Julian Days of a time scale.
#pragma once
#include "common/common.hpp"

#include <CLI/App.hpp>

#include <toliman/ingest.h>

namespace cli {

struct SkyTimeOptions {
    std::vector<std::string> times;
    std::string file, from, to, scale = "utc";
    std::optional<double> every; // days
};

// Adds --times, --times-file, --from, --to, --every and --scale.
void add_sky_times(CLI::App &command, SkyTimeOptions &options);

// Reads one time. `where` precedes the message of a Failure. scale: TOLIMAN_INGEST_SCALE_...
int64_t read_time(const std::string &where, const std::string &text, int32_t scale,
                  const std::vector<toliman_leap_second> &leap_seconds);

// Reads the time of an option --epoch: a date or day of UTC, or a whole number of at least 1e9, TAI in ns.
int64_t read_epoch(const std::string &where, const std::string &text,
                   const std::vector<toliman_leap_second> &leap_seconds);

struct SkyTime {
    std::string text; // in the time scale of the options
    int64_t tai_ns;
};

// Throws Failure for bad times, or if there are none.
std::vector<SkyTime> sky_times(const SkyTimeOptions &options, const std::vector<toliman_leap_second> &leap_seconds);

} // namespace cli
