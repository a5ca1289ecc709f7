/* Tests dates, Julian days, leap seconds and clock tables against constants of astropy, long division and gmtime. */
#include <inttypes.h>
#include <time.h>

#include <toliman/ingest.h>

#include "test_folder.h"
#include "uniform.h"

static const int64_t kSecond = 1000000000, kDay = 86400 * (int64_t)1000000000;

static char folder[256], path[300];

static int set_up(void **unused) {
    (void)unused;
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/table", folder);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    remove_folder(folder);
    return 0;
}

static void write_file(const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static int64_t parsed(const char *text, int32_t format, int32_t scale) {
    int64_t tai_ns = -1;
    assert_ok(toliman_ingest_parse_time(text, format, scale, NULL, 0, &tai_ns));
    return tai_ns;
}

static int64_t converted(int64_t ns, int32_t scale) {
    int64_t tai_ns = -1;
    assert_ok(toliman_ingest_convert_times(&ns, 1, scale, NULL, 0, &tai_ns));
    return tai_ns;
}

enum {
    ISO = TOLIMAN_INGEST_FORMAT_ISO,
    MJD = TOLIMAN_INGEST_FORMAT_MJD,
    JD = TOLIMAN_INGEST_FORMAT_JD,
    UTC = TOLIMAN_INGEST_SCALE_UTC,
    TAI = TOLIMAN_INGEST_SCALE_TAI,
    TT = TOLIMAN_INGEST_SCALE_TT,
    TDB = TOLIMAN_INGEST_SCALE_TDB,
    GPS = TOLIMAN_INGEST_SCALE_GPS
};

/* Time(text, scale=..., format=...).tai of astropy 5.2; GPS = TAI - 19 s and TDB = TT by definition. */
static void constants(void **unused) {
    (void)unused;
    const struct {
        const char *text;
        int32_t format, scale;
        int64_t tai_ns;
    } cases[] = {
        {"2028-03-01T12:00:00", ISO, UTC, 1835524837000000000},
        {"2028-03-01T12:00:00Z", ISO, UTC, 1835524837000000000},
        {"2028-03-01T12:00:00", ISO, TAI, 1835524800000000000},
        {"2028-03-01T12:00:00", ISO, TT, 1835524767816000000},
        {"2028-03-01T12:00:00", ISO, TDB, 1835524767816000000},
        {"2028-03-01T12:00:00", ISO, GPS, 1835524819000000000},
        {"2016-12-31T23:59:59", ISO, UTC, 1483228835000000000},
        {"2016-12-31T23:59:60", ISO, UTC, 1483228836000000000},
        {"2016-12-31T23:59:60.5", ISO, UTC, 1483228836500000000},
        {"2016-12-31T23:59:60.9999999999", ISO, UTC, 1483228836999999999},
        {"2017-01-01", ISO, UTC, 1483228837000000000},
        {"2017-01-01T00:00:00.", ISO, UTC, 1483228837000000000},
        {"57753.5", MJD, UTC, 1483185636500000000}, /* of a day of 86,401 s */
        {"57753.25", MJD, TAI, 1483164000000000000},
        {"+5.775325E4", MJD, TAI, 1483164000000000000},
        {"577532.5d-1", MJD, TAI, 1483164000000000000},
        {"0.000005775325e+10", MJD, TAI, 1483164000000000000},
        {"60000.123456789", MJD, TT, 1677293834482569600},
        {"2457754.25", JD, UTC, 1483207236750000000},
        {"2457754.25", JD, TT, 1483207167816000000},
        {"2457754.25", JD, GPS, 1483207219000000000},
        {"1972-01-01", ISO, UTC, 63072010000000000},
        {"1958-01-01", ISO, TAI, -378691200000000000},
        {"2436204.5", JD, TAI, -378691200000000000},
        {"2099-12-31T23:59:59.999999999", ISO, UTC, 4102444836999999999},
        {"88068.99999999999999999999", MJD, TAI, 4102444800000000000},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (parsed(cases[i].text, cases[i].format, cases[i].scale) != cases[i].tai_ns)
            fail_msg("%s: %" PRId64, cases[i].text, parsed(cases[i].text, cases[i].format, cases[i].scale));
    }
}

/* Writes whole + ns/86400e9 with 20 digits after the point, by long division, rounded down. */
static void print_day(char *text, size_t size, int64_t whole, int64_t ns) {
    int at = snprintf(text, size, "%" PRId64 ".", whole);
    for (int i = 0; i < 20; i++) {
        ns *= 10;
        text[at++] = (char)('0' + ns / kDay);
        ns %= kDay;
    }
    text[at] = '\0';
}

static void every_nanosecond_is_exact(void **unused) {
    (void)unused;
    uint64_t random = 1;
    for (int i = 0; i < 20000; i++) {
        const int64_t days = -4383 + (int64_t)(uniform(&random) * 51865); /* 1958 to 2099 */
        const int64_t ns = (int64_t)(uniform(&random) * (double)kDay);
        const time_t second = (time_t)(days * 86400 + ns / kSecond);
        struct tm date;
        char text[80];
        assert_non_null(gmtime_r(&second, &date));
        const size_t length = strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &date);
        snprintf(text + length, sizeof text - length, ".%09" PRId64, ns % kSecond);
        assert_int_equal(parsed(text, ISO, TAI), days * kDay + ns);
        assert_int_equal(converted(days * kDay + ns, TAI), days * kDay + ns);
        assert_int_equal(converted(days * kDay + ns, TT), parsed(text, ISO, TT));
        assert_int_equal(converted(days * kDay + ns, GPS), parsed(text, ISO, GPS));
        if (days >= 730)
            assert_int_equal(converted(days * kDay + ns, UTC), parsed(text, ISO, UTC));
        print_day(text, sizeof text, 40587 + days, ns);
        assert_int_equal(parsed(text, MJD, TAI), days * kDay + ns);
        const int64_t later = ns + kDay / 2; /* a Julian Day begins at noon */
        print_day(text, sizeof text, 2440587 + days + later / kDay, later % kDay);
        assert_int_equal(parsed(text, JD, TAI), days * kDay + ns);
    }
}

static void leap_seconds(void **unused) {
    (void)unused;
    size_t count = 0, again = 0;
    int64_t expires = 0;
    assert_ok(toliman_ingest_read_leap_seconds(NULL, NULL, 0, &count, &expires));
    assert_true(expires > 61000);
    toliman_leap_second table[100] = {TOLIMAN_LEAP_SECOND_INIT};
    assert_in_range(count, 28, 99);
    assert_fails(toliman_ingest_read_leap_seconds(NULL, table, count - 1, &again, NULL), TOLIMAN_E_CAPACITY,
                 "capacity");
    assert_int_equal(again, 0);
    assert_ok(toliman_ingest_read_leap_seconds(NULL, table, count, &again, NULL));
    assert_true(again == count && table[0].mjd == 41317 && table[0].tai_utc_s == 10);
    assert_true(table[27].mjd == 57754 && table[27].tai_utc_s == 37);
    for (size_t i = 1; i < count; i++) {
        char last[40];
        const int64_t start = (table[i].mjd - 40587) * kDay + table[i].tai_utc_s * kSecond;
        const time_t second = (time_t)((table[i].mjd - 40588) * 86400);
        struct tm date;
        assert_non_null(gmtime_r(&second, &date));
        assert_true(strftime(last, sizeof last, "%Y-%m-%dT23:59:60.999999999", &date) > 0);
        assert_int_equal(parsed(last, ISO, UTC), start - 1);
        assert_int_equal(converted((table[i].mjd - 40587) * kDay, UTC), start);
        assert_int_equal(converted((table[i].mjd - 40587) * kDay - 1, UTC), start - kSecond - 1);
        int64_t by_table = 0;
        assert_ok(toliman_ingest_parse_time(last, ISO, UTC, table, count, &by_table));
        assert_int_equal(by_table, start - 1);
        assert_fails(toliman_ingest_parse_time(last, ISO, UTC, table, i, &by_table), TOLIMAN_E_FORMAT,
                     "no such second");
    }
}

/* A table of the caller, with the first negative leap second. */
static void tables_of_the_caller(void **unused) {
    (void)unused;
    toliman_leap_second table[3] = {{sizeof table[0], 10, 41317}, {0, 11, 41499}, {0, 10, 62502}};
    int64_t ns = 0, times[2] = {(62502 - 40587) * kDay - 1, (62502 - 40587) * kDay};
    assert_ok(toliman_ingest_parse_time("2029-12-31T23:59:58.999999999", ISO, UTC, table, 3, &ns));
    assert_int_equal(ns, (62502 - 40587) * kDay + 10 * kSecond - 1);
    assert_fails(toliman_ingest_parse_time("2029-12-31T23:59:59", ISO, UTC, table, 3, &ns), TOLIMAN_E_FORMAT,
                 "no such second");
    assert_ok(toliman_ingest_convert_times(times, 2, UTC, table, 3, times)); /* in place */
    assert_int_equal(times[0], (62502 - 40587) * kDay + 11 * kSecond - 1);
    assert_int_equal(times[1], (62502 - 40587) * kDay + 10 * kSecond);
    assert_ok(toliman_ingest_parse_time("2029-12-31T23:59:59", ISO, TAI, table, 3, &ns)); /* not used */
    table[2].tai_utc_s = 13;
    assert_fails(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 3, &ns), TOLIMAN_E_ARGUMENT, "table[2]");
    table[2] = (toliman_leap_second){0, 12, 41499};
    assert_fails(toliman_ingest_convert_times(times, 2, UTC, table, 3, times), TOLIMAN_E_ARGUMENT, "table[2]");
    table[0].tai_utc_s = 11;
    assert_fails(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 1, &ns), TOLIMAN_E_ARGUMENT, "table[0]");
    table[0].struct_size = 4;
    assert_fails(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 1, &ns), TOLIMAN_E_ARGUMENT, "struct_size");
}

static void malformed_texts(void **unused) {
    (void)unused;
    const struct {
        int32_t format, scale;
        const char *texts[20];
    } cases[] = {
        {ISO,
         UTC,
         {"", "2028", "2028-3-1", "2028-13-01", "2027-02-29", "1900-02-29", "2028-00-01", "2028-01-00", "31/12/99",
          "2028-01-01T12:00", "2028-01-01T24:00:00", "2028-01-01T12:60:00", "2028-01-01 12:00:00",
          "2028-01-01T12:00:61", "2016-12-31T22:59:60", "2017-12-31T23:59:60", "2028-01-01T12:00:00.1.2",
          "2028-01-01T12:00:00,5", "2028-01-01T12:00:00ZZ"}},
        {ISO, TAI, {"2016-12-31T23:59:60", "2028-01-01T12:00:00Z", "2028-01-01Z", "Z"}},
        {MJD,
         TAI,
         {"", ".", "-", "NaN", "inf", "60000,5", "60000.5.5", "60000E", "60000e+", "60000e1x", " 60000", "0x10"}},
        {JD, TT, {"", "2028-01-01", "2460000.5 "}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (size_t k = 0; k < 20 && cases[i].texts[k] != NULL; k++) {
            int64_t tai_ns = -7;
            const toliman_status status =
                toliman_ingest_parse_time(cases[i].texts[k], cases[i].format, cases[i].scale, NULL, 0, &tai_ns);
            if (status != TOLIMAN_E_FORMAT || tai_ns != -7)
                fail_msg("\"%s\" is accepted", cases[i].texts[k]);
            assert_string_equal(toliman_last_error_field(), "text");
        }
}

static void range_ends(void **unused) {
    (void)unused;
    const struct {
        const char *text;
        int32_t format, scale;
    } cases[] = {
        {"1957-12-31T23:59:59.999999999", ISO, TAI},
        {"1971-12-31T23:59:59", ISO, UTC},
        {"2100-01-01", ISO, TT},
        {"0000-01-01", ISO, TAI},
        {"9999-12-31", ISO, TAI},
        {"36203.999999999", MJD, TAI},
        {"88069", MJD, TAI},
        {"41316.999", MJD, UTC},
        {"2436204.49999", JD, TAI},
        {"2488069.5", JD, TAI},
        {"-60000", MJD, TAI},
        {"1e99999999", MJD, TAI},
        {"60000", JD, TAI},
        {"-1e-99999", MJD, TAI},
        {"1e-30", JD, TAI},
        {"999999999999999999999999999", MJD, TAI},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int64_t tai_ns = -7;
        assert_fails(toliman_ingest_parse_time(cases[i].text, cases[i].format, cases[i].scale, NULL, 0, &tai_ns),
                     TOLIMAN_E_RANGE, "text = ");
        assert_int_equal(tai_ns, -7);
    }
    int64_t times[4] = {1, 2, INT64_MIN, INT64_MAX}, tai_ns[4] = {-7, -7, -7, -7};
    assert_fails(toliman_ingest_convert_times(times, 4, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "times[2]");
    assert_fails(toliman_ingest_convert_times(times, 1, UTC, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "1972-01-01");
    assert_int_equal(tai_ns[0], -7);
    assert_int_equal(converted(-4383 * kDay, TT), -4383 * kDay - 32184000000);
    times[0] = -4383 * kDay - 1;
    assert_fails(toliman_ingest_convert_times(times, 1, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "1958-01-01");
    times[0] = 47482 * kDay;
    assert_fails(toliman_ingest_convert_times(times, 1, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "2099-12-31");
    assert_ok(toliman_ingest_convert_times(NULL, 0, TAI, NULL, 0, NULL));
}

static void wrong_arguments(void **unused) {
    (void)unused;
    int64_t ns = 0;
    size_t count = 0;
    toliman_leap_second row = TOLIMAN_LEAP_SECOND_INIT;
    assert_fails(toliman_ingest_parse_time(NULL, ISO, UTC, NULL, 0, &ns), TOLIMAN_E_ARGUMENT, "text");
    assert_fails(toliman_ingest_parse_time("2028-01-01", UTC, UTC, NULL, 0, &ns), TOLIMAN_E_ARGUMENT, "format");
    assert_fails(toliman_ingest_parse_time("2028-01-01", ISO, ISO, NULL, 0, &ns), TOLIMAN_E_ARGUMENT, "scale");
    assert_fails(toliman_ingest_parse_time("2028-01-01", ISO, UTC, NULL, 1, &ns), TOLIMAN_E_ARGUMENT, "table");
    assert_fails(toliman_ingest_parse_time("2028-01-01", ISO, UTC, NULL, 0, NULL), TOLIMAN_E_ARGUMENT, "tai_ns");
    assert_fails(toliman_ingest_convert_times(NULL, 1, UTC, NULL, 0, &ns), TOLIMAN_E_ARGUMENT, "times");
    assert_fails(toliman_ingest_convert_times(&ns, 1, UTC, NULL, 0, NULL), TOLIMAN_E_ARGUMENT, "tai_ns");
    assert_fails(toliman_ingest_convert_times(&ns, 1, 0, NULL, 0, &ns), TOLIMAN_E_ARGUMENT, "scale");
    assert_fails(toliman_ingest_read_leap_seconds(NULL, NULL, 0, NULL, NULL), TOLIMAN_E_ARGUMENT, "count");
    assert_fails(toliman_ingest_read_leap_seconds(NULL, NULL, 5, &count, NULL), TOLIMAN_E_ARGUMENT, "table");
    row.struct_size = 1000;
    assert_fails(toliman_ingest_read_leap_seconds(NULL, &row, 1, &count, NULL), TOLIMAN_E_ARGUMENT, "struct_size");
    assert_fails(toliman_ingest_read_clock(NULL, NULL, 0, &count, NULL, NULL), TOLIMAN_E_ARGUMENT, "path");
    assert_fails(toliman_ingest_read_clock("x", NULL, 1, &count, NULL, NULL), TOLIMAN_E_ARGUMENT, "clock");
    assert_fails(toliman_ingest_read_clock("x", NULL, 0, NULL, NULL, NULL), TOLIMAN_E_ARGUMENT, "points");
}

#define LIST "#@ 3928521600 # expiry\n\n# comment\n2272060800\t10 # 1 Jan 1972\r\n 2287785600 11\n"

static void leap_second_files(void **unused) {
    (void)unused;
    toliman_leap_second table[2] = {TOLIMAN_LEAP_SECOND_INIT};
    size_t count = 0;
    int64_t expires = 0;
    write_file(LIST);
    assert_ok(toliman_ingest_read_leap_seconds(path, table, 2, &count, &expires));
    assert_true(count == 2 && table[0].mjd == 41317 && table[1].mjd == 41499 && table[1].tai_utc_s == 11);
    assert_int_equal(expires, 15020 + 3928521600 / 86400);
    const char *const bad[][2] = {
        {"", "is empty"},
        {"# nothing\n", "contains no leap seconds"},
        {"2272060800 10\n", "expiry"},
        {"#@ 2272060800\n2272060800 10\n", "expiry"},
        {"#@ x\n2272060800 10\n", "table:1: must begin with the seconds"},
        {LIST "x\n", "table:6: must begin with the seconds"},
        {LIST "2303683201 12\n", "table:6: must begin with the seconds"},
        {LIST "-9223372036854775808 12\n", "table:6: must begin with the seconds"},
        {LIST "99999999999999999999 12\n", "table:6: must begin with the seconds"},
        {LIST "2303683200\n", "table:6: must be the seconds since 1900-01-01 and TAI - UTC"},
        {LIST "2303683200 12 13\n", "table:6: must be the seconds"},
        {LIST "2303683200 12x\n", "table:6: must be the seconds"},
        {LIST "2303683200 99999999999\n", "table:6: must be the seconds"},
        {LIST "2303683200 13\n", "table:6: must be 10 s on MJD 41317 (1972-01-01) in the first row"},
        {LIST "2303683200 11\n", "table:6: must be"},
        {LIST "2287785600 12\n", "table:6: must be"},
        {"2272060800 9\n", "table:1: must be 10 s on MJD 41317"},
        {"2287785600 10\n", "table:1: must be 10 s on MJD 41317"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_file(bad[i][0]);
        count = 77;
        assert_fails(toliman_ingest_read_leap_seconds(path, NULL, 0, &count, &expires), TOLIMAN_E_FORMAT, bad[i][1]);
        assert_string_equal(toliman_last_error_field(), path);
        assert_int_equal(count, 77);
    }
    assert_fails(toliman_ingest_read_leap_seconds(folder, NULL, 0, &count, NULL), TOLIMAN_E_NOT_FOUND, folder);
}

static void keep_warning(int32_t level, const char *text, void *user_data) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    char *kept = user_data;
    assert_int_equal(kept[0], '\0'); /* only one */
    snprintf(kept, 300, "%s", text);
}

static void clock_tables(void **unused) {
    (void)unused;
    const char *const texts[] = {
        "# x\n\n  # y\ncamera_ns, tai_ns\n0,5 # z\n# between\n 1000,1005\n",
        "0,5\r\n1000,1005\r\n",
        "camera_ns,tai_ns\n0,5\n1000,1005",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        int64_t clock[4] = {0};
        size_t points = 0;
        char warning[300] = "";
        write_file(texts[i]);
        assert_ok(toliman_ingest_read_clock(path, NULL, 0, &points, NULL, NULL));
        assert_int_equal(points, 2);
        points = 77;
        assert_fails(toliman_ingest_read_clock(path, clock, 1, &points, NULL, NULL), TOLIMAN_E_CAPACITY,
                     "capacity = 1");
        assert_int_equal(points, 77);
        assert_ok(toliman_ingest_read_clock(path, clock, 2, &points, keep_warning, warning));
        assert_true(clock[0] == 0 && clock[1] == 5 && clock[2] == 1000 && clock[3] == 1005);
        assert_string_equal(warning, "");
    }
    const char *const header = "table:2: the header must be camera_ns,tai_ns";
    const char *const bad[][2] = {
        {"", "is empty"},
        {"# y\n", "contains no pair"},
        {"camera_ns,tai_ns\n", "contains no pair"},
        {"\ntai_ns,camera_ns\n0,5\n", header},
        {"#\nns,tai_ns\n0,5\n", header},
        {"# y\ncamera_s,tai_s\n0,5\n", header},
        {"\n,\n", header},
        {"0,5\ncamera_ns,tai_ns\n", "table:2: must be camera_ns,tai_ns"},
        {"0,5\n6\n", "table:2: must be"},
        {"0,5,7\n", "table:1: must be"},
        {"0,1e9\n", "table:1: must be"},
        {"0,9223372036854775808\n", "table:1: must be"},
        {"# y\n0,5\n\n7,5\n", "table:4: 7,5: must exceed the pair before, 0,5,"},
        {"5,1\n5,2\n", "table:2: 5,2"},
        {"5,1\n4,2\n", "table:2: 4,2"},
        {"-4611686018427387904,0\n1,9\n", "by 2^62 ns at most"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t points = 77;
        write_file(bad[i][0]);
        assert_fails(toliman_ingest_read_clock(path, NULL, 0, &points, NULL, NULL), TOLIMAN_E_FORMAT, bad[i][1]);
        assert_string_equal(toliman_last_error_field(), path);
        assert_int_equal(points, 77);
    }
    size_t points = 0;
    assert_fails(toliman_ingest_read_clock("/none/clock.csv", NULL, 0, &points, NULL, NULL), TOLIMAN_E_NOT_FOUND,
                 "/none/clock.csv");
}

static toliman_ingest_header_time time_of(const toliman_ingest_header *header) {
    toliman_ingest_header_time time = TOLIMAN_INGEST_HEADER_TIME_INIT;
    assert_ok(toliman_ingest_read_header(header, NULL, 0, 0, &time));
    return time;
}

/* Each keyword goes before those after it, and half of its exposure is added; times of astropy 5.2. */
static void times_of_headers(void **unused) {
    (void)unused;
    toliman_ingest_header header = TOLIMAN_INGEST_HEADER_INIT;
    header.date_obs = "'2029-05-05T00:00:00'";
    header.mjd_obs = "57753.25";
    header.mjd_beg = "57753.5";
    header.date_avg = "2028-03-01T12:00:00";
    header.mjd_avg = "+5.775325D4";
    header.xposure = "1.0D1";
    header.exptime = "0.3";
    header.timesys = "' tai'";
    toliman_ingest_header_time time = TOLIMAN_INGEST_HEADER_TIME_INIT;
    assert_fails(toliman_ingest_read_header(&header, NULL, 0, 0, &time), TOLIMAN_E_FORMAT, "TIMESYS");
    header.timesys = "'tai     '";
    const struct {
        const char **spent; /* keyword that the next case lacks */
        const char *rule;
        int64_t tai_ns;
    } cases[] = {
        {&header.mjd_avg, "MJD-AVG in TAI", 1483164000000000000},
        {&header.date_avg, "DATE-AVG in TAI", 1835524800000000000},
        {&header.xposure, "MJD-BEG + XPOSURE/2 in TAI", 1483185605000000000},
        {&header.mjd_obs, "MJD-OBS + EXPTIME/2 in TAI", 1483164000150000000},
        {&header.exptime, "DATE-OBS + EXPTIME/2 in TAI", 1872633600150000000},
        {&header.mjd_beg, "MJD-BEG, taken as mid-exposure as XPOSURE is missing, in TAI", 1483185600000000000},
        {&header.date_obs, "DATE-OBS, taken as mid-exposure as EXPTIME is missing, in TAI", 1872633600000000000},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        time = time_of(&header);
        assert_string_equal(time.rule, cases[i].rule);
        assert_int_equal(time.tai_ns, cases[i].tai_ns);
        assert_int_equal(time.flags, i < 5 ? 0 : TOLIMAN_INGEST_ASSUMED);
        *cases[i].spent = NULL;
    }
    assert_fails(toliman_ingest_read_header(&header, NULL, 0, 0, &time), TOLIMAN_E_NOT_FOUND, "has no time");
    assert_fails(toliman_ingest_read_header(NULL, NULL, 0, 0, &time), TOLIMAN_E_ARGUMENT, "header");
    header.mjd_avg = "57753";
    assert_fails(toliman_ingest_read_header(&header, NULL, 0, 0, NULL), TOLIMAN_E_ARGUMENT, "time");
}

/* TIMESYS is UTC if it is missing; from `expires` on leap seconds are not known. */
static void scales_of_headers(void **unused) {
    (void)unused;
    const toliman_leap_second table[1] = {{sizeof table[0], 10, 41317}};
    toliman_ingest_header header = TOLIMAN_INGEST_HEADER_INIT;
    toliman_ingest_header_time time = TOLIMAN_INGEST_HEADER_TIME_INIT;
    header.date_avg = "'2017-01-01'";
    time = time_of(&header);
    assert_int_equal(time.tai_ns, 1483228837000000000);
    assert_int_equal(time.flags, TOLIMAN_INGEST_ASSUMED);
    assert_string_equal(time.rule, "DATE-AVG in UTC, as TIMESYS is missing");
    header.timesys = "UTC";
    for (int64_t expires = 57754; expires <= 57755; expires++) { /* the day itself, and the next one */
        assert_ok(toliman_ingest_read_header(&header, table, 1, expires, &time));
        assert_int_equal(time.tai_ns, 1483228810000000000);
        assert_int_equal(time.flags, expires == 57754 ? TOLIMAN_INGEST_EXPIRED : 0);
    }
    header.date_avg = "2016-12-31T23:59:59.999999999";
    assert_ok(toliman_ingest_read_header(&header, table, 1, 57754, &time));
    assert_int_equal(time.flags, 0);
    const struct {
        const char *name;
        int64_t behind; /* TAI - scale, ns */
    } scales[] = {
        {"IAT", 0}, {"tt", -32184000000}, {"TT(TAI)", -32184000000}, {"TDT", -32184000000}, {"'GPS'", 19000000000}};
    header.date_avg = "2028-03-01T12:00:00";
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        header.timesys = scales[i].name;
        assert_ok(toliman_ingest_read_header(&header, table, 1, 41318, &time));
        assert_int_equal(time.tai_ns, 1835524800000000000 + scales[i].behind);
        assert_int_equal(time.flags, 0); /* only UTC has leap seconds */
    }
}

static void bad_headers(void **unused) {
    (void)unused;
    const struct {
        toliman_ingest_header header;
        toliman_status status;
        const char *field, *text;
    } cases[] = {
        {{.mjd_avg = "NaN"}, TOLIMAN_E_FORMAT, "MJD-AVG", "a Modified Julian Day"},
        {{.mjd_avg = "2460000.5"}, TOLIMAN_E_RANGE, "MJD-AVG", "to 2099-12-31"},
        {{.mjd_avg = "'60000'"}, TOLIMAN_E_FORMAT, "MJD-AVG", "a Modified Julian Day"},
        {{.date_avg = "'2028-03-01Z'"}, TOLIMAN_E_FORMAT, "DATE-AVG", "YYYY-MM-DD"},
        {{.date_avg = "2028-03-01T12:00:00Z"}, TOLIMAN_E_FORMAT, "DATE-AVG", "without a Z"},
        {{.date_avg = ""}, TOLIMAN_E_FORMAT, "DATE-AVG", "YYYY-MM-DD"},
        {{.date_avg = "''"}, TOLIMAN_E_FORMAT, "DATE-AVG", "YYYY-MM-DD"},
        {{.mjd_beg = "60000", .xposure = "-1E-9"}, TOLIMAN_E_FORMAT, "XPOSURE", "from 0 to 1e9 s"},
        {{.mjd_beg = "60000", .xposure = "1000000000.1"}, TOLIMAN_E_FORMAT, "XPOSURE", "from 0 to 1e9 s"},
        {{.mjd_beg = "60000", .xposure = "1e300"}, TOLIMAN_E_FORMAT, "XPOSURE", "from 0 to 1e9 s"},
        {{.date_obs = "2028-03-01", .exptime = "NaN"}, TOLIMAN_E_FORMAT, "EXPTIME", "from 0 to 1e9 s"},
        {{.mjd_avg = "60000", .timesys = "'TDB'"}, TOLIMAN_E_FORMAT, "TIMESYS", "UTC, TAI, TT, TDT, IAT or GPS"},
        {{.mjd_avg = "60000", .timesys = ""}, TOLIMAN_E_FORMAT, "TIMESYS", "UTC, TAI, TT, TDT, IAT or GPS"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_ingest_header header = cases[i].header;
        toliman_ingest_header_time time = TOLIMAN_INGEST_HEADER_TIME_INIT;
        header.struct_size = sizeof header;
        assert_fails(toliman_ingest_read_header(&header, NULL, 0, 0, &time), cases[i].status, cases[i].text);
        assert_string_equal(toliman_last_error_field(), cases[i].field);
        assert_int_equal(time.tai_ns, 0);
    }
}

static void rates_of_clocks(void **unused) {
    (void)unused;
    const struct {
        int64_t last; /* of 1,000,000 ns */
        const char *odd;
    } cases[] = {{1989000, "table:3"}, {1991000, "table:4"}, {2009000, "table:4"}, {2011000, "table:3"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[200], warning[300] = "";
        size_t points = 0;
        snprintf(text, sizeof text, "0,0\n1000000,1000000\n2000000,%" PRId64 "\n3000000,9000000000\n", cases[i].last);
        write_file(text);
        assert_ok(toliman_ingest_read_clock(path, NULL, 0, &points, keep_warning, warning));
        assert_int_equal(points, 4);
        assert_non_null(strstr(warning, cases[i].odd));
        assert_non_null(strstr(warning, "both columns must be in ns"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constants),
        cmocka_unit_test(every_nanosecond_is_exact),
        cmocka_unit_test(leap_seconds),
        cmocka_unit_test(tables_of_the_caller),
        cmocka_unit_test(malformed_texts),
        cmocka_unit_test(range_ends),
        cmocka_unit_test(wrong_arguments),
        cmocka_unit_test(times_of_headers),
        cmocka_unit_test(scales_of_headers),
        cmocka_unit_test(bad_headers),
        cmocka_unit_test_setup_teardown(leap_second_files, set_up, tear_down),
        cmocka_unit_test_setup_teardown(clock_tables, set_up, tear_down),
        cmocka_unit_test_setup_teardown(rates_of_clocks, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
