// include/toliman/ingest.h: clock tables, leap seconds, dates, times of FITS headers
#include <toliman/ingest.h>

#include "api/common.hpp"

#include <string_view>

#include "api/header_keys.hpp"
#include "api/times.hpp"
#include "ingest/clock_table.hpp"
#include "ingest/header_time.hpp"
#include "ingest/on_target_table.hpp"
#include "ingest/time_scale.hpp"

using namespace toliman;
using namespace toliman::api;
using ingest::Scale;

extern "C" {

toliman_status toliman_ingest_read_clock(const char *path, int64_t *clock, size_t capacity, size_t *count,
                                         toliman_log_fn log, void *log_data) noexcept {
    return guard([&] {
        required(path, "path");
        const Output<int64_t> result(clock, "clock", capacity, count, 2);
        const std::vector<ingest::ClockPair> pairs = ingest::read_clock_table(path, {log, log_data});
        int64_t *next = result.resize(pairs.size(), "clock pairs");
        for (const ingest::ClockPair &pair : pairs) {
            *next++ = pair.camera_ns;
            *next++ = pair.tai_ns;
        }
    });
}

toliman_status toliman_ingest_read_on_target(const char *path, const toliman_leap_second *leap_seconds,
                                             size_t leap_second_count, int64_t *intervals, size_t capacity,
                                             size_t *count) noexcept {
    return guard([&] {
        required(path, "path");
        const Output<int64_t> result(intervals, "intervals", capacity, count, 2);
        const std::vector<ingest::OnTargetWindow> windows =
            ingest::read_on_target(path, leap_seconds_of(leap_seconds, leap_second_count, "leap_seconds"));
        int64_t *next = result.resize(windows.size(), "windows");
        for (const ingest::OnTargetWindow &window : windows) {
            *next++ = window.start_ns;
            *next++ = window.end_ns;
        }
    });
}

toliman_status toliman_ingest_read_leap_seconds(const char *path, toliman_leap_second *table, size_t capacity,
                                                size_t *count, int64_t *expires) noexcept {
    return guard([&] {
        const StructOutput<toliman_leap_second> result(table, "table", capacity, count);
        const erfa::LeapSecondTable list = path != nullptr ? ingest::read_leap_seconds(path) : erfa::leap_seconds();
        result.write(list.rows.size(), "rows", [&](size_t i) {
            return toliman_leap_second{0, list.rows[i].tai_utc, list.rows[i].day};
        });
        if (expires != nullptr)
            *expires = list.expires;
    });
}

int64_t toliman_ingest_last_utc_day(void) noexcept {
    return ingest::last_day_of_utc();
}

toliman_status toliman_ingest_parse_time(const char *text, int32_t format, int32_t scale,
                                         const toliman_leap_second *table, size_t count, int64_t *tai_ns) noexcept {
    return guard([&] {
        required(text, "text");
        const ingest::TimeFormat known_format = kFormats.to_enum(format, "format");
        const Scale known_scale = kScales.to_enum(scale, "scale");
        const ingest::LeapSeconds leap_seconds = leap_seconds_of(table, count, "table");
        required(tai_ns, "tai_ns") = ingest::parse_time(text, known_format, known_scale, leap_seconds);
    });
}

toliman_status toliman_ingest_read_header(const toliman_ingest_header *header, const toliman_leap_second *table,
                                          size_t count, int64_t expires, toliman_ingest_header_time *time) noexcept {
    return guard([&] {
        required(header, "header");
        const toliman_ingest_header given = copied(header, "header");
        const ingest::LeapSeconds leap_seconds = leap_seconds_of(table, count, "table");
        const ingest::Keywords value_of = [&given](const char *key) {
            for (const auto &[name, member] : kHeaderKeys)
                if (std::string_view(key) == name)
                    return given.*member;
            fail(Status::internal, "header keyword %s", key);
        };
        const ingest::HeaderTime found =
            ingest::header_time(value_of, leap_seconds, count > 0 ? expires : erfa::leap_seconds().expires);
        toliman_ingest_header_time result = {};
        result.flags = (found.assumed ? TOLIMAN_INGEST_ASSUMED : 0) | (found.expired ? TOLIMAN_INGEST_EXPIRED : 0);
        result.tai_ns = found.tai_ns;
        put_text(found.rule, result.rule);
        result.exposure_s = static_cast<double>(found.length_ns) / 1e9;
        deliver(result, time, "time");
    });
}

toliman_status toliman_ingest_convert_times(const int64_t *times, size_t count, int32_t scale,
                                            const toliman_leap_second *table, size_t rows, int64_t *tai_ns) noexcept {
    return guard([&] {
        required_array(times, count, sizeof *times, "times");
        required_array(tai_ns, count, sizeof *tai_ns, "tai_ns");
        const Scale known_scale = kScales.to_enum(scale, "scale");
        const ingest::LeapSeconds leap_seconds = leap_seconds_of(table, rows, "table");
        for (size_t i = 0; i < count; i++)
            if (!ingest::to_tai(times[i], known_scale, leap_seconds))
                fail(Status::range, "{times[%zu]} = %lld ns: must be from %s to 2099-12-31", i,
                     static_cast<long long>(times[i]), ingest::first_date(known_scale));
        std::transform(times, times + count, tai_ns,
                       [&](int64_t ns) { return *ingest::to_tai(ns, known_scale, leap_seconds); });
    });
}

} // extern "C"
