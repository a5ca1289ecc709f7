/* Tests times of FITS headers: one table of headers with the middle of their exposure, computed by hand from the FITS
 * Standard 4.0, section 9, and by astropy 5.2 where the time is a day; one table of headers that are refused. */
#include <inttypes.h>

#include <toliman/ingest.h>

#include "assert_close.h"

#define NOON 1835524837  /* 2028-03-01T12:00:00 UTC, TAI in s */
#define START 1835526933 /* 2028-03-01T12:34:56 UTC */
#define MIDDLE (START + 1800)

#define DATE "'2028-03-01T12:34:56'"
#define DAY "'2028-03-01'"
#define CLOCK "'12:34:56'"
#define END "'2028-03-01T13:34:56'"

static toliman_status read(const toliman_ingest_header *given, toliman_ingest_header_time *time) {
    toliman_ingest_header header = *given;
    header.struct_size = sizeof header;
    *time = (toliman_ingest_header_time)TOLIMAN_INGEST_HEADER_TIME_INIT;
    return toliman_ingest_read_header(&header, NULL, 0, 0, time);
}

TEST(times) {
    const struct {
        toliman_ingest_header header;
        double tai_s, exposure_s;
        const char *rule; /* its beginning */
    } cases[] = {
        /* any start with any length */
        {{.date_obs = DATE, .xposure = "3600.0"}, MIDDLE, 3600, "DATE-OBS + XPOSURE/2 in UTC, as TIMESYS is missing"},
        {{.date_obs = DATE, .exptime = "3.6D3"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2"},
        {{.date_obs = DATE, .exposure = "3600"}, MIDDLE, 3600, "DATE-OBS + EXPOSURE/2"},
        {{.date_obs = DATE, .telapse = "3600"}, MIDDLE, 3600, "DATE-OBS + TELAPSE/2"},
        {{.mjd_beg = "61831.5", .exptime = "3600"}, NOON + 1800, 3600, "MJD-BEG + EXPTIME/2"},
        {{.mjd_obs = "61831.5", .xposure = "3600"}, NOON + 1800, 3600, "MJD-OBS + XPOSURE/2"},
        {{.date_beg = DATE, .xposure = "3600"}, MIDDLE, 3600, "DATE-BEG + XPOSURE/2"},
        {{.date_beg = DATE, .exptime = "0"}, START, 0, "DATE-BEG + EXPTIME/2"},
        {{.date_beg = DATE, .exptime = "1.5"}, START + 0.75, 1.5, "DATE-BEG + EXPTIME/2"},
        /* time of day in another keyword */
        {{.date_obs = DAY, .time_obs = CLOCK, .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + TIME-OBS + EXPTIME/2"},
        {{.date_obs = DAY, .ut = "'12:34:56.00'", .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + UT + EXPTIME/2"},
        {{.date_obs = DAY, .utc_obs = CLOCK, .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + UTC-OBS + EXPTIME/2"},
        {{.date_obs = DAY, .utc_obs = "'9:34:56'", .exptime = "3600"}, MIDDLE - 10800, 3600, "DATE-OBS + UTC-OBS"},
        {{.date_obs = DATE, .utc_obs = DATE, .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2"},
        {{.date_obs = DAY, .ut = "'2028-03-01 12:34:56'", .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + UT"},
        {{.date_obs = "'2028-061'", .time_obs = CLOCK, .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + TIME-OBS"},
        {{.date_beg = DAY, .time_beg = CLOCK, .date_end = DAY, .time_end = "'13:34:56'"},
         MIDDLE,
         3600,
         "the middle of DATE-BEG + TIME-BEG and DATE-END + TIME-END in UTC"},
        {{.date_obs = DATE, .time_obs = CLOCK, .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2"},
        /* ends and middles */
        {{.date_beg = DATE, .date_end = END}, MIDDLE, 3600, "the middle of DATE-BEG and DATE-END in UTC"},
        {{.date_obs = DATE, .date_end = END}, MIDDLE, 3600, "the middle of DATE-OBS and DATE-END in UTC"},
        {{.mjd_beg = "61831.5", .mjd_end = "61831.75"}, NOON + 10800, 21600, "the middle of MJD-BEG and MJD-END"},
        {{.date_end = END, .xposure = "3600"}, MIDDLE, 3600, "DATE-END - XPOSURE/2"},
        {{.date_avg = DATE}, START, 0, "DATE-AVG in UTC"},
        {{.mjd_avg = "61831.5", .date_obs = "'2028-03-01T11:30:00'", .exptime = "3600"}, NOON, 3600, "MJD-AVG in UTC"},
        {{.date_avg = DAY, .time_avg = CLOCK}, START, 0, "DATE-AVG + TIME-AVG in UTC"},
        {{.date_avg = "'2028-03-01T13:00:00'", .date_beg = DATE, .date_end = END}, NOON + 3600, 3600, "DATE-AVG"},
        /* keywords that agree within half an exposure and their last digit */
        {{.date_obs = DATE, .mjd_obs = "61831.5243", .exptime = "0.01"}, START + 0.005, 0.01, "DATE-OBS + EXPTIME/2"},
        {{.mjd_obs = "61831.524259259259", .date_obs = DATE, .exptime = "3600"}, MIDDLE, 3600, "MJD-OBS + EXPTIME/2"},
        {{.date_obs = DAY, .mjd_obs = "61831.5", .exptime = "3600"}, NOON + 1800, 3600, "MJD-OBS + EXPTIME/2"},
        {{.date_obs = DATE, .date_beg = "'2028-03-01T12:50:00'", .exptime = "3600"},
         1835527837 + 1800,
         3600,
         "DATE-BEG"},
        {{.date_beg = DATE, .xposure = "3600", .exptime = "2400.1"}, MIDDLE, 3600, "DATE-BEG + XPOSURE/2"},
        {{.date_beg = DATE, .date_end = END, .telapse = "3600", .xposure = "100"},
         MIDDLE,
         3600,
         "DATE-BEG + TELAPSE/2"},
        {{.date_obs = DATE, .date_avg = "'2028-03-01T12:35:00'"}, START + 4, 0, "DATE-AVG"}, /* of unknown length */
        /* forms of dates, and scales */
        {{.date_obs = "'2028-03-01 12:34:56'", .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS"},
        {{.date_obs = "'2028-03-01T12:34:56Z'", .exptime = "3600", .timesys = "'UTC'"}, MIDDLE, 3600, "DATE-OBS"},
        {{.date_obs = "'2028-061T12:34:56+00:00'", .exptime = "3600"}, MIDDLE, 3600, "DATE-OBS"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'UTC(NIST)'"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2 in UTC"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'utc(ptb)  '"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2 in UTC"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'GMT'"}, MIDDLE, 3600, "DATE-OBS + EXPTIME/2 in GMT"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'TAI'"}, MIDDLE - 37, 3600, "DATE-OBS + EXPTIME/2 in TAI"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "IAT"}, MIDDLE - 37, 3600, "DATE-OBS + EXPTIME/2 in IAT"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'TT(BIPM)'"}, MIDDLE - 69.184, 3600, "DATE-OBS"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'TDT'"}, MIDDLE - 69.184, 3600, "DATE-OBS"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'ET'"}, MIDDLE - 69.184, 3600, "DATE-OBS"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'TDB'"},
         MIDDLE - 69.184,
         3600,
         "DATE-OBS + EXPTIME/2 in TDB"},
        {{.date_obs = DATE, .exptime = "3600", .timesys = "'GPS'"}, MIDDLE - 18, 3600, "DATE-OBS"},
        {{.date_obs = DATE, .xposure = "3600", .timeunit = "'s'", .trefpos = "'TOPOCENTER'"}, MIDDLE, 3600, "DATE-OBS"},
        /* what is missing is assumed */
        {{.date_obs = DATE}, START, 0, "DATE-OBS, taken as mid-exposure as its length is missing, in UTC, as TIMESYS"},
        {{.mjd_beg = "61831.5", .timesys = "'UTC'"},
         NOON,
         0,
         "MJD-BEG, taken as mid-exposure as its length is missing, in"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_ingest_header_time time;
        assert_ok(read(&cases[i].header, &time));
        const int64_t expected = (int64_t)cases[i].tai_s * 1000000000 +
                                 (int64_t)((cases[i].tai_s - (double)(int64_t)cases[i].tai_s) * 1e6 + 0.5) * 1000;
        const int64_t error = time.tai_ns - expected;
        const int64_t limit = cases[i].header.mjd_obs != NULL && strlen(cases[i].header.mjd_obs) > 15 ? 100000 : 0;
        if (error > limit || error < -limit || time.exposure_s != cases[i].exposure_s)
            fail_msg("case %zu (%s): %" PRId64 " ns off, %g s", i, time.rule, error, time.exposure_s);
        if (strncmp(time.rule, cases[i].rule, strlen(cases[i].rule)) != 0)
            fail_msg("case %zu: \"%s\" is not \"%s\"", i, time.rule, cases[i].rule);
        const int is_assumed = cases[i].header.timesys == NULL || strstr(time.rule, "missing") != NULL;
        assert_int_equal(time.flags & TOLIMAN_INGEST_ASSUMED, is_assumed ? TOLIMAN_INGEST_ASSUMED : 0);
    }
}

/* promise: contradicting-headers-are-refused */
TEST(refused) {
    const struct {
        toliman_ingest_header header;
        const char *field, *other; /* other: what it contradicts */
    } cases[] = {                  /* contradictions name both */
                 {{.date_obs = DATE, .mjd_obs = "61832.5243", .exptime = "3600"}, "DATE-OBS", "MJD-OBS"},
                 {{.date_obs = DATE, .mjd_obs = "61831.5", .exptime = "3600"}, "MJD-OBS", "DATE-OBS"},
                 {{.date_beg = DATE, .date_obs = "'2028-03-01T13:06:00'", .exptime = "3600"}, "DATE-BEG", "DATE-OBS"},
                 {{.date_avg = DATE, .date_obs = "'2028-03-01T12:35:56'", .exptime = "3600"}, "DATE-AVG", "DATE-OBS"},
                 {{.date_avg = DATE, .mjd_end = "61830.5"}, "DATE-AVG", "MJD-END"},
                 {{.date_beg = DATE, .date_end = "'2028-03-01T12:34:50'"}, "DATE-BEG", "DATE-END"},
                 {{.date_beg = DATE, .date_end = "'2028-03-01T14:34:56'", .xposure = "3600"}, "DATE-BEG", "DATE-END"},
                 {{.date_beg = DATE, .xposure = "3600", .exptime = "60"}, "XPOSURE", "EXPTIME"},
                 {{.date_beg = DATE, .exptime = "46", .exposure = "0.000046"}, "EXPTIME", "EXPOSURE"},
                 {{.date_beg = DATE, .telapse = "60", .xposure = "3600"}, "TELAPSE", "XPOSURE"},
                 {{.date_obs = DATE, .time_obs = "'22:34:56'", .exptime = "10"}, "DATE-OBS", "DATE-OBS + TIME-OBS"},
                 {{.date_obs = DAY, .time_obs = CLOCK, .ut = "'10:34:56'"}, "DATE-OBS + TIME-OBS", "DATE-OBS + UT"},
                 {{.date_obs = "'2028-03-03'", .mjd_obs = "61831.5", .exptime = "3600"}, "MJD-OBS", "DATE-OBS"},
                 {{.date_avg = DATE, .mjd_avg = "61831.5"}, "MJD-AVG", "DATE-AVG"},
                 {{.date_obs = DAY, .ut = CLOCK, .timesys = "'TAI'"}, "UT", "TIMESYS"},
                 /* a bare date */
                 {{.date_obs = DAY, .exptime = "3600"}, "DATE-OBS", ""},
                 {{.date_avg = "2028-061"}, "DATE-AVG", ""},
                 {{.date_beg = DAY, .date_end = "'2028-03-02'"}, "DATE-BEG", ""},
                 /* malformed values */
                 {{.mjd_avg = "NaN"}, "MJD-AVG", ""},
                 {{.mjd_avg = "'60000'"}, "MJD-AVG", ""},
                 {{.mjd_end = "x", .date_obs = DATE, .exptime = "1"}, "MJD-END", ""},
                 {{.date_avg = "'2028-03-01Z'"}, "DATE-AVG", ""},
                 {{.date_avg = "'01/03/28'"}, "DATE-AVG", ""},
                 {{.date_avg = ""}, "DATE-AVG", ""},
                 {{.date_avg = "''"}, "DATE-AVG", ""},
                 {{.date_avg = "'2028-03-01T12:00:00Z'", .timesys = "'TAI'"}, "DATE-AVG", ""},
                 {{.date_avg = "'2028-03-01T12:00:00+02:00'"}, "DATE-AVG", ""},
                 {{.date_obs = DAY, .time_obs = "12.5"}, "TIME-OBS", ""},
                 {{.date_obs = DAY, .ut = "'12:34'"}, "UT", ""},
                 {{.date_obs = DAY, .ut = "'2028-03-02T12:34:56'"}, "UT", "DATE-OBS"},
                 {{.date_obs = DAY, .ut = DAY}, "UT", "DATE-OBS"},
                 {{.date_obs = DAY, .time_obs = "'123:34:56'"}, "TIME-OBS", ""},
                 {{.mjd_beg = "60000", .xposure = "-1E-9"}, "XPOSURE", ""},
                 {{.mjd_beg = "60000", .xposure = "1000000000.1"}, "XPOSURE", ""},
                 {{.mjd_beg = "60000", .telapse = "1e300"}, "TELAPSE", ""},
                 {{.date_obs = DATE, .exptime = "NaN"}, "EXPTIME", ""},
                 {{.date_beg = "'1972-01-01T00:00:00'", .date_end = "'2028-03-01T00:00:00'"}, "DATE-BEG", ""},
                 {{.mjd_avg = "60000", .timesys = "'UT1'"}, "TIMESYS", ""},
                 {{.mjd_avg = "60000", .timesys = "'UTC(NIST'"}, "TIMESYS", ""},
                 {{.mjd_avg = "60000", .timesys = "'TCB'"}, "TIMESYS", ""},
                 {{.mjd_avg = "60000", .timesys = "' TAI'"}, "TIMESYS", ""},
                 {{.mjd_avg = "60000", .timesys = ""}, "TIMESYS", ""},
                 {{.date_obs = DATE, .xposure = "0.04", .timeunit = "'d'"}, "TIMEUNIT", ""},
                 {{.date_obs = DATE, .exptime = "1", .trefpos = "'BARYCENTER'"}, "TREFPOS", ""}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_ingest_header_time time;
        assert_refused(read(&cases[i].header, &time), TOLIMAN_E_FORMAT, cases[i].field);
        assert_non_null(strstr(toliman_last_error(), cases[i].other));
        assert_int_equal(time.tai_ns, 0);
    }
    toliman_ingest_header_time time;
    const toliman_ingest_header late = {.mjd_avg = "2460000.5"}, none = {.exposure = "46 us", .time_obs = CLOCK};
    assert_refused(read(&late, &time), TOLIMAN_E_RANGE, "MJD-AVG");
    assert_refused(read(&none, &time), TOLIMAN_E_NOT_FOUND, "header");
    assert_invalid(toliman_ingest_read_header(NULL, NULL, 0, 0, &time), "header");
    toliman_ingest_header header = {.struct_size = sizeof header, .date_avg = DATE};
    assert_invalid(toliman_ingest_read_header(&header, NULL, 0, 0, NULL), "time");
}

/* From `expires` on leap seconds are not known; only UTC has them. */
TEST(expiry) {
    const toliman_leap_second table[1] = {{sizeof table[0], 10, 41317}};
    toliman_ingest_header header = TOLIMAN_INGEST_HEADER_INIT;
    toliman_ingest_header_time time = TOLIMAN_INGEST_HEADER_TIME_INIT;
    header.date_avg = "'2017-01-01T00:00:00'";
    header.timesys = "UTC";
    for (int64_t expires = 57754; expires <= 57755; expires++) { /* the day itself, and the next one */
        assert_ok(toliman_ingest_read_header(&header, table, 1, expires, &time));
        assert_int_equal(time.tai_ns, 1483228810000000000);
        assert_int_equal(time.flags, expires == 57754 ? TOLIMAN_INGEST_EXPIRED : 0);
    }
    header.date_avg = "2016-12-31T23:59:59.999999999";
    assert_ok(toliman_ingest_read_header(&header, table, 1, 57754, &time));
    assert_int_equal(time.flags, 0);
    header.timesys = "TT";
    assert_ok(toliman_ingest_read_header(&header, table, 1, 41318, &time));
    assert_int_equal(time.flags, 0);
}

RUN_TESTS(NULL, NULL)
