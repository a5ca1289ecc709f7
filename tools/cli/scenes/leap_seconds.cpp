#include "scenes/leap_seconds.hpp"

#include <toliman/toliman.hpp>

namespace cli {

LeapSeconds::LeapSeconds(const std::string &path) {
    const char *const name = path.empty() ? nullptr : path.c_str();
    size_t count = 0;
    toliman::check(toliman_ingest_read_leap_seconds(name, nullptr, 0, &count, nullptr));
    rows.assign(count, toliman::sized<toliman_leap_second>());
    toliman::check(toliman_ingest_read_leap_seconds(name, rows.data(), count, &count, &expires));
    rows.resize(count);
}

} // namespace cli
