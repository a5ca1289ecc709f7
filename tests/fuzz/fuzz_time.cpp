// Clock tables, on-target windows, leap seconds and times as text, through the public functions. The first byte selects
// which.
#include <toliman/ingest.h>
// promise: parsers-are-safe

#include "fuzz.hpp"
#include "leap_second_rows.h"
#include "memory_file.hpp"

using namespace fuzz;

namespace {

// Whether a call succeeded; failures must be about the text.
bool succeeds(toliman_status status) {
    require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_RANGE, toliman_last_error());
    return status == TOLIMAN_OK;
}

// Asks for the number of rows of a table.
bool has_rows(toliman_status status) {
    return status == TOLIMAN_E_CAPACITY || succeeds(status);
}

void read_clock(const std::string &text) {
    const char *const path = path_of(text).c_str();
    size_t points = 0;
    if (!has_rows(toliman_ingest_read_clock(path, nullptr, 0, &points, nullptr, nullptr)))
        return;
    require(points > 0, "an empty clock");
    std::vector<int64_t> clock(2 * points);
    require(toliman_ingest_read_clock(path, clock.data(), points, &points, nullptr, nullptr) == TOLIMAN_OK, "again");
    for (size_t i = 2; i < clock.size(); i++)
        require(clock[i] > clock[i - 2], "a clock that does not increase");
}

void read_on_target(const std::string &text) {
    const char *const path = path_of(text).c_str();
    size_t count = 0;
    if (!has_rows(toliman_ingest_read_on_target(path, nullptr, 0, nullptr, 0, &count)))
        return;
    require(count > 0, "no windows");
    std::vector<int64_t> windows(2 * count);
    require(toliman_ingest_read_on_target(path, nullptr, 0, windows.data(), count, &count) == TOLIMAN_OK, "again");
    for (size_t i = 1; i < windows.size(); i++)
        require(i % 2 == 1 ? windows[i] > windows[i - 1] : windows[i] >= windows[i - 1], "windows that overlap");
}

// A table that is read can be used.
void read_leap_seconds(const std::string &text) {
    const char *const path = path_of(text).c_str();
    size_t count = 0;
    int64_t expires = 0, tai_ns = 0;
    if (!has_rows(toliman_ingest_read_leap_seconds(path, nullptr, 0, &count, nullptr)))
        return;
    std::vector<toliman_leap_second> table(count);
    table.at(0).struct_size = sizeof table[0];
    require(toliman_ingest_read_leap_seconds(path, table.data(), count, &count, &expires) == TOLIMAN_OK, "again");
    require(expires > table.back().mjd, "an expiry before the last leap second");
    for (const char *date : {"1972-01-01", "2016-12-31T12:00:00", "2099-12-31"})
        require(toliman_ingest_parse_time(date, TOLIMAN_INGEST_FORMAT_ISO, TOLIMAN_INGEST_SCALE_UTC, table.data(),
                                          count, &tai_ns) == TOLIMAN_OK,
                "a table that cannot be used");
}

// The same text in all formats and scales: TAI is between 1958 and 2100, and the scales keep their distances.
void read_time(const std::string &text) {
    constexpr int64_t kDay = 86400000000000, kFirst = -4384 * kDay, kEnd = 47483 * kDay;
    for (int32_t format = TOLIMAN_INGEST_FORMAT_ISO; format <= TOLIMAN_INGEST_FORMAT_JD; format++) {
        int64_t ns[5] = {};
        bool good[5] = {};
        for (int32_t k = 0; k < 5; k++) {
            good[k] = succeeds(
                toliman_ingest_parse_time(text.c_str(), format, TOLIMAN_INGEST_SCALE_UTC + k, nullptr, 0, &ns[k]));
            fuzz::accepted += good[k];
            require(!good[k] || (ns[k] >= kFirst && ns[k] < kEnd), "a time out of range");
        }
        require(good[1] == good[2] && good[1] == good[3] && good[1] == good[4], "a time in one scale only");
        require(!good[1] || (ns[2] == ns[1] - 32184000000 && ns[3] == ns[2] && ns[4] == ns[1] + 19000000000),
                "another distance of two scales");
        require(!good[0] || !good[1] || (ns[0] - ns[1] >= 10000000000 && ns[0] - ns[1] <= 38000000000),
                "impossible leap seconds");
    }
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return seeds_of({"wstart_tai_ns,end_tai_ns\n1,2 # comment\n2,1000000002\n",
                     "wend_utc,start_utc\n2028-03-01T12:00:00Z,2028-060T12:00:00\n",
                     "ccamera_ns,tai_ns\n1,2 # comment\n1000000001,1000000002\n",
                     "l#@ 3928521600\n" LEAP_SECOND_ROWS LAST_LEAP_SECOND, "t2016-12-31T23:59:60.5",
                     "t2028-03-01T12:00:00Z", "t2028-061 12:00:00+00:00", "t60000.25", "t2460000.5", "t+577539.9e-1",
                     "t1.5D+4"});
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const std::string text(reinterpret_cast<const char *>(data) + 1, size - 1);
    if (data[0] == 'c')
        read_clock(text);
    else if (data[0] == 'w')
        read_on_target(text);
    else if (data[0] == 'l')
        read_leap_seconds(text);
    else
        read_time(text);
    return 0;
}
