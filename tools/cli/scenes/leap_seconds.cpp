#include "scenes/leap_seconds.hpp"

#include <CLI/App.hpp>

#include "scenes/dates.hpp"

namespace cli {

LeapSeconds::LeapSeconds(const std::string &path) {
    const char *const name = path.empty() ? nullptr : path.c_str();
    size_t count = 0;
    toliman::check_asked(toliman_ingest_read_leap_seconds(name, nullptr, 0, &count, nullptr));
    rows.assign(count, toliman::sized<toliman_leap_second>());
    toliman::check(toliman_ingest_read_leap_seconds(name, rows.data(), count, &count, &expires));
    rows.resize(count);
}

void warn_of_expiry(const CLI::App &command, Progress &progress) {
    static bool warned = false;
    const CLI::Option *const option = command.get_option_no_throw("--leap-seconds");
    const std::string file = option != nullptr && option->count() > 0 ? option->as<std::string>() : "";
    const int64_t last = toliman_ingest_last_utc_day();
    if (last == 0 || warned)
        return;
    const int64_t expires = LeapSeconds(file).expires;
    if (last < expires || std::exchange(warned, true))
        return;
    progress.warn("dates of UTC up to " + mjd_day(static_cast<double>(last)) +
                  " were converted, but leap seconds are known only before " + mjd_day(static_cast<double>(expires)) +
                  ": " +
                  (option != nullptr ? "--leap-seconds FILE reads a newer leap-seconds.list of the IERS"
                                     : "a newer version of ERFA has newer ones"));
}

} // namespace cli
