/* Tests dates, Julian days, leap seconds and clock tables against constants of astropy, long division and gmtime. */
#include <inttypes.h>
#include <pthread.h>
#include <time.h>

#include <toliman/ingest.h>

#include "leap_second_rows.h"
#include "test_folder.h"
#include "uniform.h"

static const int64_t kSecond = 1000000000, kDay = 86400 * (int64_t)1000000000;

static char folder[256], path[300];

FIXTURE(set_up) {
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/table", folder);
    return 0;
}

FIXTURE(tear_down) {
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

/* A thread has the days that it converted itself. */
static void *convert_alone(void *unused) {
    int64_t ns = 0;
    assert_int_equal(toliman_ingest_last_utc_day(), 0);
    assert_ok(toliman_ingest_parse_time("70000", MJD, UTC, NULL, 0, &ns));
    assert_int_equal(toliman_ingest_last_utc_day(), 70000);
    return unused;
}

/* Only days of UTC count, also of a table of the caller; the first test of this program. */
TEST(latest_day_of_utc) {
    const toliman_leap_second table[1] = {{sizeof table[0], 10, 41317}};
    int64_t ns = 0, time = (62000 - 40587) * kDay;
    assert_int_equal(toliman_ingest_last_utc_day(), 0);
    parsed("88000", MJD, TAI);
    converted(1, TT);
    assert_int_equal(toliman_ingest_last_utc_day(), 0);
    parsed("2028-03-01T23:59:59Z", ISO, UTC);
    assert_int_equal(toliman_ingest_last_utc_day(), 61831);
    parsed("60000", MJD, UTC);
    assert_int_equal(toliman_ingest_last_utc_day(), 61831);
    assert_ok(toliman_ingest_convert_times(&time, 1, UTC, table, 1, &ns));
    assert_int_equal(toliman_ingest_last_utc_day(), 62000);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, convert_alone, NULL), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_int_equal(toliman_ingest_last_utc_day(), 62000);
}

/* Time(text, scale=..., format=...).tai of astropy 5.2; GPS = TAI - 19 s and TDB = TT by definition. */
/* promise: dates-are-exact */
TEST(constants) {
    const struct {
        const char *text;
        int32_t format, scale;
        int64_t tai_ns;
    } cases[] = {{"2028-03-01T12:00:00", ISO, UTC, 1835524837000000000},
                 {"2028-03-01T12:00:00Z", ISO, UTC, 1835524837000000000},
                 {"2028-03-01T12:00:00+00:00", ISO, UTC, 1835524837000000000},
                 {"2028-03-01T12:00:00-00:00", ISO, UTC, 1835524837000000000},
                 {"2028-03-01 12:00:00+0000", ISO, UTC, 1835524837000000000},
                 {"2028-03-01 12:00:00.000-00", ISO, UTC, 1835524837000000000},
                 {"2028-03-01 12:00:00", ISO, UTC, 1835524837000000000},
                 {"2028-061T12:00:00", ISO, UTC, 1835524837000000000},
                 {"2028-061 12:00:00.Z", ISO, UTC, 1835524837000000000},
                 {"2028-061", ISO, TAI, 1835481600000000000},
                 {"2016-366T23:59:60", ISO, UTC, 1483228836000000000},
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
                 {"88068.99999999999999999999", MJD, TAI, 4102444800000000000}};
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

/* promise: dates-are-exact */
TEST(every_nanosecond_is_exact) {
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

TEST(leap_seconds) {
    size_t count = 0, again = 0;
    int64_t expires = 0;
    assert_asks(toliman_ingest_read_leap_seconds(NULL, NULL, 0, &count, &expires));
    assert_true(expires == 0);
    toliman_leap_second table[100] = {TOLIMAN_LEAP_SECOND_INIT};
    assert_in_range(count, 28, 99);
    assert_refused(toliman_ingest_read_leap_seconds(NULL, table, count - 1, &again, NULL), TOLIMAN_E_CAPACITY,
                   "capacity");
    assert_true(again == count && table[0].mjd == 0);
    assert_ok(toliman_ingest_read_leap_seconds(NULL, table, count, &again, &expires));
    assert_true(expires > 61000);
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
        assert_refused(toliman_ingest_parse_time(last, ISO, UTC, table, i, &by_table), TOLIMAN_E_FORMAT, "text");
    }
}

/* A table of the caller, with the first negative leap second. */
TEST(tables_of_the_caller) {
    toliman_leap_second table[3] = {{sizeof table[0], 10, 41317}, {0, 11, 41499}, {0, 10, 62502}};
    int64_t ns = 0, times[2] = {(62502 - 40587) * kDay - 1, (62502 - 40587) * kDay};
    assert_ok(toliman_ingest_parse_time("2029-12-31T23:59:58.999999999", ISO, UTC, table, 3, &ns));
    assert_int_equal(ns, (62502 - 40587) * kDay + 10 * kSecond - 1);
    assert_refused(toliman_ingest_parse_time("2029-12-31T23:59:59", ISO, UTC, table, 3, &ns), TOLIMAN_E_FORMAT, "text");
    assert_ok(toliman_ingest_convert_times(times, 2, UTC, table, 3, times)); /* in place */
    assert_int_equal(times[0], (62502 - 40587) * kDay + 11 * kSecond - 1);
    assert_int_equal(times[1], (62502 - 40587) * kDay + 10 * kSecond);
    assert_ok(toliman_ingest_parse_time("2029-12-31T23:59:59", ISO, TAI, table, 3, &ns)); /* not used */
    table[2].tai_utc_s = 13;
    assert_invalid(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 3, &ns), "table[2]");
    table[2] = (toliman_leap_second){0, 12, 41499};
    assert_invalid(toliman_ingest_convert_times(times, 2, UTC, table, 3, times), "table[2]");
    table[0].tai_utc_s = 11;
    assert_invalid(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 1, &ns), "table[0]");
    table[0].struct_size = 4;
    assert_invalid(toliman_ingest_parse_time("2029-12-31", ISO, UTC, table, 1, &ns), "table->struct_size");
}

TEST(malformed_texts) {
    const struct {
        int32_t format, scale;
        const char *texts[20];
    } cases[] = {
        {ISO,
         UTC,
         {"", "2028", "2028-3-1", "2028-13-01", "2027-02-29", "1900-02-29", "2028-00-01", "2028-01-00", "31/12/99",
          "2028-01-01T12:00", "2028-01-01T24:00:00", "2028-01-01T12:60:00", "2028-01-01  12:00:00",
          "2028-01-01T12:00:61", "2016-12-31T22:59:60", "2017-12-31T23:59:60", "2028-01-01T12:00:00.1.2",
          "2028-01-01T12:00:00,5", "2028-01-01T12:00:00ZZ"}},
        {ISO, TAI, {"2016-12-31T23:59:60", "2028-01-01T12:00:00Z", "2028-01-01Z", "Z", "2028-01-01T12:00:00+00:00"}},
        {ISO,
         UTC,
         {"2027-366", "2028-367", "2028-000", "2028-0611", "2028-61T12:00:00", "2028-061t12:00:00", "2028-061T",
          "2028-03-01T12:00:00+01:00", "2028-061 12:00:00.5-0530", "2028-03-01T12:00:00+00:0", "2028-03-01+00:00",
          "2028-03-01T12:00:00 UTC", "2028-03-01T12:00:00z", "2028-03-01\t12:00:00", "2028-03-01 ",
          "2028-03-01T12:00:00Z+00:00"}},
        {MJD,
         TAI,
         {"", ".", "-", "NaN", "inf", "60000,5", "60000.5.5", "60000E", "60000e+", "60000e1x", " 60000", "0x10"}},
        {JD, TT, {"", "2028-01-01", "2460000.5 "}}};
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

TEST(range_ends) {
    const struct {
        const char *text;
        int32_t format, scale;
    } cases[] = {{"1957-12-31T23:59:59.999999999", ISO, TAI},
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
                 {"999999999999999999999999999", MJD, TAI}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int64_t tai_ns = -7;
        assert_refused(toliman_ingest_parse_time(cases[i].text, cases[i].format, cases[i].scale, NULL, 0, &tai_ns),
                       TOLIMAN_E_RANGE, "text");
        assert_int_equal(tai_ns, -7);
    }
    int64_t times[4] = {1, 2, INT64_MIN, INT64_MAX}, tai_ns[4] = {-7, -7, -7, -7};
    assert_refused(toliman_ingest_convert_times(times, 4, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "times[2]");
    assert_refused(toliman_ingest_convert_times(times, 1, UTC, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "times[0]");
    assert_int_equal(tai_ns[0], -7);
    assert_int_equal(converted(-4383 * kDay, TT), -4383 * kDay - 32184000000);
    times[0] = -4383 * kDay - 1;
    assert_refused(toliman_ingest_convert_times(times, 1, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "times[0]");
    times[0] = 47482 * kDay;
    assert_refused(toliman_ingest_convert_times(times, 1, TAI, NULL, 0, tai_ns), TOLIMAN_E_RANGE, "times[0]");
    assert_ok(toliman_ingest_convert_times(NULL, 0, TAI, NULL, 0, NULL));
}

TEST(wrong_arguments) {
    int64_t ns = 0;
    size_t count = 0;
    toliman_leap_second row = TOLIMAN_LEAP_SECOND_INIT;
    assert_invalid(toliman_ingest_parse_time(NULL, ISO, UTC, NULL, 0, &ns), "text");
    assert_invalid(toliman_ingest_parse_time("2028-01-01", UTC, UTC, NULL, 0, &ns), "format");
    assert_invalid(toliman_ingest_parse_time("2028-01-01", ISO, ISO, NULL, 0, &ns), "scale");
    assert_invalid(toliman_ingest_parse_time("2028-01-01", ISO, UTC, NULL, 1, &ns), "table");
    assert_invalid(toliman_ingest_parse_time("2028-01-01", ISO, UTC, NULL, 0, NULL), "tai_ns");
    assert_invalid(toliman_ingest_convert_times(NULL, 1, UTC, NULL, 0, &ns), "times");
    assert_invalid(toliman_ingest_convert_times(&ns, 1, UTC, NULL, 0, NULL), "tai_ns");
    assert_invalid(toliman_ingest_convert_times(&ns, 1, 0, NULL, 0, &ns), "scale");
    assert_invalid(toliman_ingest_read_leap_seconds(NULL, NULL, 0, NULL, NULL), "count");
    assert_invalid(toliman_ingest_read_leap_seconds(NULL, NULL, 5, &count, NULL), "table");
    row.struct_size = 1000;
    assert_invalid(toliman_ingest_read_leap_seconds(NULL, &row, 1, &count, NULL), "table->struct_size");
    assert_invalid(toliman_ingest_read_clock(NULL, NULL, 0, &count, NULL, NULL), "path");
    assert_invalid(toliman_ingest_read_clock("x", NULL, 1, &count, NULL, NULL), "clock");
    assert_invalid(toliman_ingest_read_clock("x", NULL, 0, NULL, NULL, NULL), "count");
}

#define ROWS LEAP_SECOND_ROWS
#define LIST "#@ 3991593600 # expiry\n\n# comment\n" ROWS "\r\n3692217600\t37 # 1 Jan 2017"
/* The hash of these numbers by hashlib. */
#define SEALED "#$\t3960835200\n#@\t3991593600\n#hash of what follows\n" ROWS "3692217600 37\n"
#define HASH "#h 49db2447 571e5e1b 2f002a53 9c8da8e4 39b8e49e"

/* promise: leap-seconds-are-verified */
TEST_WITH(leap_second_files, set_up, tear_down) {
    const char *const good[] = {LIST, LIST "\n", SEALED HASH};
    toliman_leap_second table[30] = {TOLIMAN_LEAP_SECOND_INIT};
    size_t count = 0;
    int64_t expires = 0;
    for (size_t i = 0; i < 3; i++) {
        write_file(good[i]);
        assert_ok(toliman_ingest_read_leap_seconds(path, table, 30, &count, &expires));
        assert_true(count == 28 && table[0].mjd == 41317 && table[1].mjd == 41499 && table[1].tai_utc_s == 11);
        assert_true(table[27].mjd == 57754 && table[27].tai_utc_s == 37);
        assert_int_equal(expires, 15020 + 3991593600 / 86400);
    }
    write_file(LIST "\n3976214400 38\n"); /* 2026-01-01, after the release of the table */
    assert_ok(toliman_ingest_read_leap_seconds(path, table, 30, &count, NULL));
    assert_true(count == 29 && table[28].mjd == 61041 && table[28].tai_utc_s == 38);
    const char *const bad[][2] = {
        {"", "is empty"},
        {"# nothing\n", "contains no leap seconds"},
        {"2272060800 10\n", "expiry"},
        {"#@ 2272060800\n2272060800 10\n", "expiry"},
        {"#@ x\n2272060800 10\n", "table:1: "},
        {LIST "\nx\n", "table:33: "},
        {LIST "\n3724012801 12\n", "table:33: "},
        {LIST "\n-9223372036854775808 12\n", "table:33: "},
        {LIST "\n99999999999999999999 12\n", "table:33: "},
        {LIST "\n3724012800\n", "table:33: "},
        {LIST "\n3724012800 38 39\n", "table:33: "},
        {LIST "\n3724012800 38x\n", "table:33: "},
        {LIST "\n3724012800 99999999999\n", "table:33: "},
        {LIST "\n3724012800 39\n", "table:33: "},
        {LIST "\n3724012800 37\n", "table:33: "},
        {LIST "\n3692217600 38\n", "table:33: "},
        {"2272060800 9\n", "table:1: "},
        {"2287785600 10\n", "table:1: "},
        {"#@ 3991593600\n" ROWS "3692217600 3", "table:29: "}, /* truncated in its last number */
        {"#@ 3991593600\n" ROWS, " 36 s on MJD 57754: "},
        {"#@ 3991593600\n" ROWS "3692217600 35\n", " 35 s on MJD 57754: "},
        {"#@ 3991593600\n" ROWS "3692304000 37\n", " 36 s on MJD 57754: "},
        {LIST "\n3724012800 38\n", " 38 s on MJD 58122: "},
        {"#@ 3928521600\n2272060800 10\n2287785600 11\n", " 11 s on MJD 41683: "},
        {SEALED, "(#h)"},
        {SEALED "3976214400 38\n" HASH, "(#h)"},
        {"#$ 3960835201\n" LIST "\n" HASH, "(#h)"},
        {LIST "\n" HASH, "(#h)"},
        {SEALED "#h 49db2447 571e5e1b 2f002a53 9c8da8e4", "table:32: "},
        {SEALED "#h 49db2447 571e5e1b 2f002a53 9c8da8e4 39b8e49g", "table:32: "},
        {SEALED HASH " 1", "table:32: "}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_file(bad[i][0]);
        count = 77;
        assert_fails(toliman_ingest_read_leap_seconds(path, NULL, 0, &count, &expires), TOLIMAN_E_FORMAT, bad[i][1]);
        assert_string_equal(toliman_last_error_field(), path);
        assert_int_equal(count, 77);
    }
    assert_refused(toliman_ingest_read_leap_seconds(folder, NULL, 0, &count, NULL), TOLIMAN_E_NOT_FOUND, folder);
}

static void keep_warning(int32_t level, const char *text, void *user_data) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    char *kept = user_data;
    assert_int_equal(kept[0], '\0'); /* only one */
    snprintf(kept, 300, "%s", text);
}

TEST_WITH(clock_tables, set_up, tear_down) {
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
        assert_asks(toliman_ingest_read_clock(path, NULL, 0, &points, NULL, NULL));
        assert_int_equal(points, 2);
        points = 77;
        assert_refused(toliman_ingest_read_clock(path, clock, 1, &points, NULL, NULL), TOLIMAN_E_CAPACITY, "capacity");
        assert_true(points == 2 && clock[1] == 0);
        assert_ok(toliman_ingest_read_clock(path, clock, 2, &points, keep_warning, warning));
        assert_true(clock[0] == 0 && clock[1] == 5 && clock[2] == 1000 && clock[3] == 1005);
        assert_string_equal(warning, "");
    }
    const char *const bad[][2] = {{"", "is empty"},
                                  {"# y\n", "contains no pair"},
                                  {"camera_ns,tai_ns\n", "contains no pair"},
                                  {"\ntai_ns,camera_ns\n0,5\n", "table:2: "},
                                  {"#\nns,tai_ns\n0,5\n", "table:2: "},
                                  {"# y\ncamera_s,tai_s\n0,5\n", "table:2: "},
                                  {"\n,\n", "table:2: "},
                                  {"0,5\ncamera_ns,tai_ns\n", "table:2: "},
                                  {"0,5\n6\n", "table:2: "},
                                  {"0,5,7\n", "table:1: "},
                                  {"0,1e9\n", "table:1: "},
                                  {"0,9223372036854775808\n", "table:1: "},
                                  {"# y\n0,5\n\n7,5\n", "table:4: "},
                                  {"5,1\n5,2\n", "table:2: "},
                                  {"5,1\n4,2\n", "table:2: "},
                                  {"-4611686018427387904,0\n1,9\n", "2^62 ns"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t points = 77;
        write_file(bad[i][0]);
        assert_fails(toliman_ingest_read_clock(path, NULL, 0, &points, NULL, NULL), TOLIMAN_E_FORMAT, bad[i][1]);
        assert_string_equal(toliman_last_error_field(), path);
        assert_int_equal(points, 77);
    }
    size_t points = 0;
    assert_refused(toliman_ingest_read_clock("/none/clock.csv", NULL, 0, &points, NULL, NULL), TOLIMAN_E_NOT_FOUND,
                   "/none/clock.csv");
}

TEST_WITH(rates_of_clocks, set_up, tear_down) {
    const struct {
        int64_t last; /* of 1,000,000 ns */
        const char *odd;
    } cases[] = {{1989000, "table:3"}, {1991000, "table:4"}, {2009000, "table:4"}, {2011000, "table:3"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[200], warning[300] = "";
        size_t points = 0;
        snprintf(text, sizeof text, "0,0\n1000000,1000000\n2000000,%" PRId64 "\n3000000,9000000000\n", cases[i].last);
        write_file(text);
        assert_asks(toliman_ingest_read_clock(path, NULL, 0, &points, keep_warning, warning));
        assert_int_equal(points, 4);
        assert_non_null(strstr(warning, cases[i].odd));
        assert_non_null(strstr(warning, "both columns must be in ns"));
    }
}

RUN_TESTS(NULL, NULL)
