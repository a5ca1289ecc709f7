/* ingest.h: clock tables, on-target windows, leap seconds, dates */
#include <string.h>

#include "leap_second_rows.h"
#include "scenario.h"

enum { ROWS = 2, LEAP_SECONDS = 28 };

static const char kClock[] = "clock", kList[] = "list", kWindows[] = "windows";

static void put_clock(void) {
    static const char text[] = "camera_ns,tai_ns\n0,5\n1000,2005\n";
    write_file(kClock, text, sizeof text - 1);
}

static void put_windows(void) {
    static const char text[] = "start_utc,end_utc\n2016-12-31T23:59:59,2017-01-01T00:00:00\n"
                               "2017-001T00:00:00,2017-001T00:00:01\n";
    write_file(kWindows, text, sizeof text - 1);
}

static void put_list(void) {
    static const char text[] = "#@ 3928521600\n" LEAP_SECOND_ROWS LAST_LEAP_SECOND;
    write_file(kList, text, sizeof text - 1);
}

static void ignore_text(int32_t level, const char *text, void *user_data) {
    (void)level, (void)text, (void)user_data;
}

static toliman_status read_clock(attempt *a) {
    return toliman_ingest_read_clock(in_folder(kClock), (int64_t *)(a->out + 8), ROWS, (size_t *)a->out, ignore_text,
                                     NULL);
}

/* A capacity that is too small: the number of rows is the only output. */
static toliman_status read_small(attempt *a) {
    size_t count = 0;
    const toliman_status status =
        toliman_ingest_read_clock(in_folder(kClock), (int64_t *)(a->out + 8), 1, &count, NULL, NULL);
    must(count == (status == TOLIMAN_E_CAPACITY ? ROWS : 0), "number of clock pairs");
    return status;
}

static toliman_status read_windows(attempt *a) {
    return toliman_ingest_read_on_target(in_folder(kWindows), NULL, 0, (int64_t *)(a->out + 8), ROWS, (size_t *)a->out);
}

static toliman_status read_few_windows(attempt *a) {
    size_t count = 0;
    const toliman_status status =
        toliman_ingest_read_on_target(in_folder(kWindows), NULL, 0, (int64_t *)(a->out + 8), 1, &count);
    must(count == (status == TOLIMAN_E_CAPACITY ? ROWS : 0), "number of windows");
    return status;
}

static toliman_status read_leap_seconds(attempt *a) {
    toliman_leap_second table[LEAP_SECONDS] = {TOLIMAN_LEAP_SECOND_INIT};
    const toliman_status status = toliman_ingest_read_leap_seconds(in_folder(kList), table, LEAP_SECONDS,
                                                                   (size_t *)a->out, (int64_t *)(a->out + 8));
    must(table[1].tai_utc_s == (status == TOLIMAN_OK ? 11 : 0), "rows of a call that failed");
    return status;
}

static toliman_status known_leap_seconds(attempt *a) {
    toliman_leap_second table[64] = {TOLIMAN_LEAP_SECOND_INIT};
    return toliman_ingest_read_leap_seconds(NULL, table, 64, (size_t *)a->out, (int64_t *)(a->out + 8));
}

static toliman_status parse_time(attempt *a) {
    return toliman_ingest_parse_time("2016-12-31T23:59:60.5", TOLIMAN_INGEST_FORMAT_ISO, TOLIMAN_INGEST_SCALE_UTC, NULL,
                                     0, (int64_t *)a->out);
}

static toliman_status last_utc_day(attempt *a) {
    must(toliman_ingest_last_utc_day() >= 0 && a != NULL, "last_utc_day");
    return TOLIMAN_OK;
}

static toliman_status read_header(attempt *a) {
    toliman_ingest_header header = TOLIMAN_INGEST_HEADER_INIT;
    header.date_obs = "'2016-12-31'";
    header.time_obs = "'23:59:60.5'";
    header.exptime = "2.5";
    header.timesys = "'UTC'";
    return toliman_ingest_read_header(&header, NULL, 0, 0, (void *)a->out);
}

static toliman_status convert_times(attempt *a) {
    const toliman_leap_second table[ROWS] = {{sizeof table[0], 10, 41317}, {0, 11, 41499}};
    const int64_t times[2] = {1500000000000000000, 1600000000000000000};
    return toliman_ingest_convert_times(times, 2, TOLIMAN_INGEST_SCALE_UTC, table, ROWS, (int64_t *)a->out);
}

static const scenario all[] = {
    {.function = "toliman_ingest_read_clock", .call = read_clock, .stage = put_clock},
    {.function = "toliman_ingest_read_clock",
     .variant = "too many pairs",
     .call = read_small,
     .stage = put_clock,
     .refused = TOLIMAN_E_CAPACITY},
    {.function = "toliman_ingest_read_on_target", .call = read_windows, .stage = put_windows},
    {.function = "toliman_ingest_read_on_target",
     .variant = "too many windows",
     .call = read_few_windows,
     .stage = put_windows,
     .refused = TOLIMAN_E_CAPACITY},
    {.function = "toliman_ingest_read_leap_seconds", .call = read_leap_seconds, .stage = put_list},
    {.function = "toliman_ingest_read_leap_seconds", .variant = "of ERFA", .call = known_leap_seconds},
    {.function = "toliman_ingest_parse_time", .call = parse_time},
    {.function = "toliman_ingest_last_utc_day", .call = last_utc_day},
    {.function = "toliman_ingest_read_header", .call = read_header, .struct_size = sizeof(toliman_ingest_header_time)},
    {.function = "toliman_ingest_convert_times", .call = convert_times},
};
SCENARIO_LIST(ingest_time_scenarios, all);
