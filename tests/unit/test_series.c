/* Lines of a series to samples: formats, separators, names, times against constants of astropy, malformed lines. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <toliman/toliman.h>

#include "assert_close.h"

static toliman_series *made(toliman_series_options options) {
    toliman_series *series = NULL;
    options.struct_size = sizeof options;
    options.name = "rv.csv";
    assert_ok(toliman_series_create(&options, &series));
    return series;
}

static toliman_status parse(toliman_series *series, const char *line, toliman_series_sample *sample) {
    *sample = (toliman_series_sample)TOLIMAN_SERIES_SAMPLE_INIT;
    return toliman_series_parse(series, line, strlen(line), sample);
}

static toliman_series_info info_of(const toliman_series *series) {
    toliman_series_info info = TOLIMAN_SERIES_INFO_INIT;
    assert_ok(toliman_series_get_info(series, &info));
    return info;
}

static void assert_nothing(toliman_series *series, const char *line) {
    toliman_series_sample sample;
    assert_ok(parse(series, line, &sample));
    assert_int_equal(sample.found, 0);
    assert_true(sample.t == 0 && sample.y == 0 && sample.sigma == 0);
}

static void assert_sample(toliman_series *series, const char *line, double t, double y, double sigma) {
    toliman_series_sample sample;
    assert_ok(parse(series, line, &sample));
    assert_int_equal(sample.found, 1);
    if (!(sample.t == t && sample.y == y && sample.sigma == sigma))
        fail_msg("%s: %.17g, %.17g, %.17g", line, sample.t, sample.y, sample.sigma);
}

/* The lines before are valid; the last one has this status and field, and its line in
 * the message. */
static void assert_line_refused(toliman_series_options options, const char *const *lines, toliman_status status,
                                const char *field) {
    toliman_series *series = made(options);
    toliman_series_sample sample;
    int64_t count = 0;
    for (; lines[count + 1] != NULL; count++)
        assert_ok(parse(series, lines[count], &sample));
    toliman_series_sample before = TOLIMAN_SERIES_SAMPLE_INIT;
    before.t = 7;
    toliman_series_sample after = before;
    char place[20];
    snprintf(place, sizeof place, "rv.csv:%d:", (int)count + 1);
    assert_refused(toliman_series_parse(series, lines[count], strlen(lines[count]), &after), status, field);
    assert_memory_equal(place, toliman_last_error(), strlen(place));
    assert_memory_equal(&after, &before, sizeof after);
    assert_int_equal(info_of(series).lines, count + (status == TOLIMAN_E_FORMAT));
    toliman_series_destroy(series);
}

#define LINES(...) ((const char *const[]){__VA_ARGS__, NULL})
static const toliman_series_options kDefault = TOLIMAN_SERIES_OPTIONS_INIT;

static toliman_series_options columns(const char *names) {
    toliman_series_options options = kDefault;
    options.columns = names;
    return options;
}

static toliman_series_options times(int32_t format, int32_t scale) {
    toliman_series_options options = kDefault;
    options.time_format = format;
    options.time_scale = scale;
    return options;
}

TEST(separators) {
    const char *const between[] = {",", ";", " ", "\t", "  \t ", ", ", " ; "};
    for (size_t k = 0; k < 2 * sizeof between / sizeof *between; k++) {
        char line[80];
        const char *const sign = between[k / 2];
        toliman_series *series = made(kDefault);
        assert_nothing(series, "# a b; c, d\n");
        assert_nothing(series, "\n");
        assert_nothing(series, " \t\r\n");
        assert_nothing(series, "");
        snprintf(line, sizeof line, "sigma%sother%sy%st\r\n", sign, sign, sign);
        if (k % 2 != 0)
            assert_nothing(series, line);
        for (int i = 0; i < 3; i++) {
            if (k % 2 != 0)
                snprintf(line, sizeof line, "1e-3%sx%s-2.5%s%d\r\n", sign, sign, sign, i);
            else
                snprintf(line, sizeof line, "  %d%s\"-2.5\"%s+.001\n", i, sign, sign);
            assert_sample(series, line, i, -2.5, 1e-3);
        }
        assert_nothing(series, "  # the end");
        assert_int_equal(info_of(series).lines, k % 2 != 0 ? 9 : 8);
        assert_int_equal(info_of(series).time_format, 0);
        toliman_series_destroy(series);
    }
}

TEST(names) {
    toliman_series *series = made(columns("BJD, RV ,err"));
    assert_nothing(series, "\xef\xbb\xbf"
                           "RV,note,err,BJD\n");
    assert_sample(series, "5,ok,0.5,2\n", 2, 5, 0.5);
    toliman_series_destroy(series);
    series = made(columns("t,latent"));
    assert_sample(series, "{\"latent\": 4, \"sigma\": -1, \"t\": 3, \"y\": null}\n", 3, 4, 0);
    toliman_series_destroy(series);
    series = made(kDefault); /* a quoted first line is data */
    assert_sample(series, "\"1\",\"2\"\n", 1, 2, 0);
    toliman_series_destroy(series);
    assert_line_refused(columns("t,z"), LINES("t,y,sigma"), TOLIMAN_E_MISMATCH, "z");
    assert_line_refused(kDefault, LINES("# a", "when,what"), TOLIMAN_E_MISMATCH, "t");
    assert_line_refused(columns("t,y"), LINES("1,2"), TOLIMAN_E_MISMATCH, "rv.csv");
}

TEST(objects) {
    toliman_series *series = made(kDefault);
    assert_sample(series, " {\"t\": 1, \"frame\": [7], \"y\": 2, \"sigma\": 3}\n", 1, 2, 3);
    assert_sample(series, "{\"sigma\": 1e98, \"y\": -1e98, \"t\": 1e-300}", 1e-300, -1e98, 1e98);
    assert_int_equal(info_of(series).truncated, 0);
    toliman_series_destroy(series);
    const char *const first = "{\"t\": 1, \"y\": 2, \"sigma\": 3}";
    assert_line_refused(kDefault, LINES(first, "3,4"), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(kDefault, LINES("1,2", first), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(kDefault, LINES(first, "{\"t\": 1, \"y\": 2}"), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(kDefault, LINES("{\"t\": 1}"), TOLIMAN_E_FORMAT, "y");
    assert_line_refused(kDefault, LINES("{\"y\": 1}"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("{\"t\": \"1\", \"y\": 1}"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("{\"t\": 1, \"y\": \"x\"}"), TOLIMAN_E_FORMAT, "y");
    assert_line_refused(kDefault, LINES("{\"t\": 1, \"y\": 2, \"sigma\": -1}"), TOLIMAN_E_FORMAT, "sigma");
    assert_line_refused(kDefault, LINES("{\"t\": 1, \"y\": 2} 3"), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(kDefault, LINES("{\"t\": 1, \"y\": 1e999}"), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(columns("t,v"), LINES("{\"t\": 1, \"y\": 1}"), TOLIMAN_E_FORMAT, "v");
}

/* promise: bad-lines-end-no-series */
TEST(malformed) {
    const struct {
        const char *lines[3], *field;
    } cases[] = {{{"t,y", "2,three"}, "y"},
                 {{"1,1e999"}, "y"},
                 {{"nan,inf"}, "t"},
                 {{"1,2,1", "2,3,0"}, "sigma"},
                 {{"1,2,1", "2,3,1e-99"}, "sigma"},
                 {{"1,2", "-1e99,1"}, "t"},
                 {{"1,2,1", "2,3"}, "rv.csv"},
                 {{"5"}, "rv.csv"},
                 {{"1 2", "2,3"}, "rv.csv"},
                 {{"1;2", "2 3"}, "rv.csv"},
                 {{"t,y", "1;2"}, "rv.csv"},
                 {{"1 2 3", "2, 3, 4"}, "t"},
                 {{"t;y", "1.5;2,25"}, "y"},
                 {{"1,5 2,5 3"}, "y"},
                 {{"0,1", "2 ,1\t5"}, "y"},
                 {{"1,2\n3,4\n"}, "y"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_line_refused(kDefault, cases[i].lines, TOLIMAN_E_FORMAT, cases[i].field);
    toliman_series *series = made(kDefault);
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    assert_int_equal(toliman_series_parse(series, "1,2\0junk", 8, &sample), TOLIMAN_E_FORMAT);
    assert_non_null(strstr(toliman_last_error(), "rv.csv:1: y = \"2?junk\": "));
    assert_sample(series, "3 4", 3, 4, 0); /* a malformed first line fixes no format */
    assert_int_equal(info_of(series).lines, 2);
    toliman_series_destroy(series);
}

TEST(numbers) {
    toliman_series *series = made(kDefault);
    assert_sample(series, "0x1.8p3,-0X1p-2,+0x1p+1", 12, -0.25, 2);
    assert_sample(series, "1e-400,-1e-310,+1.5e+1", 0, -1e-310, 15);
    assert_sample(series, "\" 5\",.5,5.", 5, 0.5, 5);
    const char *const bad[] = {"1,2,+-5", "1,2,0x", "1,2,+", "1,1e400,1", "1,-1e400,1", "1,-inf,1", "1,1_0,1"};
    toliman_series_sample sample;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(parse(series, bad[i], &sample), TOLIMAN_E_FORMAT);
    toliman_series_destroy(series);
}

/* Far beyond the range of double, as strtod reads them: with an exponent of either sign behind many digits. */
TEST(numbers_of_any_length) {
    static const struct {
        const char *before, digit, *after;
    } kinds[] = {
        {"", '9', "e-10"},
        {"0.", '0', "1"},
        {"", '9', "."},
        {"0.", '0', "1e390"},
        {"0.", '0', "1e820"},
        {"", '9', "e-900"},
        {"00.", '0', "7e-5"},
        {"0x", 'f', "p-10"},
        {"0x0.", '0', "1p9"},
        {"0x", 'f', "p-9999"},
        {"0x1", '0', "p12"},
        {"0.", '0', "1e999999999999999999999"},
        {"1", '0', "e-999999999999999999999"},
    };
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
        for (size_t length = 1; length < 2000; length += 399) {
            char digits[2001], number[2100], line[2200];
            memset(digits, kinds[kind].digit, length);
            digits[length] = '\0';
            snprintf(number, sizeof number, "%s%s%s", kinds[kind].before, digits, kinds[kind].after);
            snprintf(line, sizeof line, "1,%s", number);
            const double expected = strtod(number, NULL);
            toliman_series *series = made(kDefault);
            if (fabs(expected) <= 1e98) {
                assert_sample(series, line, 1, expected, 0);
            } else {
                toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
                assert_int_equal(toliman_series_parse(series, line, strlen(line), &sample), TOLIMAN_E_FORMAT);
            }
            toliman_series_destroy(series);
        }
}

TEST(lengths) {
    static char line[65539];
    toliman_series *series = NULL;
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    assert_ok(toliman_series_create(NULL, &series));
    memset(line, ' ', sizeof line);
    memcpy(line + 65533, "1,2\n", 4);
    assert_ok(toliman_series_parse(series, line, 65537, &sample));
    assert_true(sample.found == 1 && sample.y == 2);
    memcpy(line + 65533, " 1,2\n", 5);
    assert_int_equal(toliman_series_parse(series, line, 65538, &sample), TOLIMAN_E_FORMAT);
    assert_string_equal(toliman_last_error(), "is longer than 65536 bytes"); /* without a name */
    assert_ok(toliman_series_parse(series, NULL, 0, &sample));
    assert_int_equal(sample.found, 0);
    toliman_series_destroy(series);
}

TEST(truncated_lines) {
    toliman_series *series = made(kDefault);
    assert_sample(series, "1,2\n", 1, 2, 0);
    assert_int_equal(info_of(series).truncated, 0);
    assert_sample(series, "2,3", 2, 3, 0);
    assert_int_equal(info_of(series).truncated, 1);
    toliman_series_destroy(series);
    toliman_series_options growing = kDefault;
    growing.flags = TOLIMAN_SERIES_GROWING;
    assert_line_refused(growing, LINES("1,2\n", "2,3"), TOLIMAN_E_FORMAT, "rv.csv");
    assert_line_refused(growing, LINES("# from now on\n", "{\"t\": 1, \"y\": 2}"), TOLIMAN_E_FORMAT, "rv.csv");
    series = made(growing);
    assert_nothing(series, "# the end");
    toliman_series_destroy(series);
}

enum {
    ISO = TOLIMAN_INGEST_FORMAT_ISO,
    MJD = TOLIMAN_INGEST_FORMAT_MJD,
    JD = TOLIMAN_INGEST_FORMAT_JD,
    UTC = TOLIMAN_INGEST_SCALE_UTC,
    TAI = TOLIMAN_INGEST_SCALE_TAI,
    TDB = TOLIMAN_INGEST_SCALE_TDB,
};

/* Time(text, scale="utc").tai.mjd of astropy 5.2; the other scales remain. */
TEST(dates_and_days) {
    const struct {
        toliman_series_options options;
        const char *names, *line;
        double t;
        int32_t format, scale;
    } cases[] = {
        {kDefault, "", "2028-03-01T12:00:00Z,1", 61831.50042824074, ISO, TAI},
        {kDefault, "t,y", "2016-12-31T23:59:60.5,1", 57754.00042245370, ISO, TAI},
        {times(0, TDB), "", "2028-03-01T12:00:00,1", 61831.5, ISO, TDB},
        {kDefault, "mjd,y", "57753.5,1", 57753.50042245370, MJD, TAI},
        {kDefault, "jd,y", "2457754.0,1", 57753.50042245370, JD, TAI},
        {times(0, TDB), "JD,y", "2457754.0,1", 57753.5, JD, TDB},
        {times(MJD, UTC), "jd,y", "57753.5,1", 57753.50042245370, MJD, TAI},
        {times(MJD, TAI), "", "57753.25,1", 57753.25, MJD, TAI},
        {kDefault, "t,y", "57753.5,1", 57753.5, 0, 0},
        {kDefault, "mjd,t,y", "9,57753.5,1", 57753.5, 0, 0},
        {kDefault, "", "{\"t\": \"2028-03-01\", \"y\": 1}", 61831.00042824074, ISO, TAI},
        {kDefault, "", "{\"jd\": \"2457754.0\", \"y\": 1}", 57753.50042245370, JD, TAI},
        {times(0, TDB), "", "{\"MJD\": 57753.5, \"y\": 1}", 57753.5, MJD, TDB},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_series *series = made(cases[i].options);
        toliman_series_sample sample;
        assert_nothing(series, cases[i].names);
        assert_ok(parse(series, cases[i].line, &sample));
        assert_true(sample.found == 1 && sample.y == 1);
        assert_close(sample.t, cases[i].t, 0, 1e-11);
        const toliman_series_info info = info_of(series);
        assert_int_equal(info.time_format, cases[i].format);
        assert_int_equal(info.time_scale, cases[i].scale);
        toliman_series_destroy(series);
    }
    toliman_series_options options = kDefault;
    options.flags = TOLIMAN_SERIES_PLAIN_TIMES;
    toliman_series *series = made(options);
    assert_nothing(series, "mjd,y");
    assert_sample(series, "5,1", 5, 1, 0);
    toliman_series_destroy(series);
    const toliman_leap_second table[] = {{sizeof table[0], 10, 41317}, {0, 11, 57754}}; /* not those of ERFA */
    options = kDefault;
    options.leap_seconds = table;
    options.leap_second_count = 2;
    series = made(options);
    assert_sample(series, "2028-03-01,1", 61831 + 11 / 86400.0, 1, 0);
    toliman_series_destroy(series);
}

TEST(bad_times) {
    assert_line_refused(kDefault, LINES("2028-03-01,1", "2028-02-30,2"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("2028-03-01,1", "61832,2"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("61832,1", "2028-03-01,2"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("2017-12-31T23:59:60,1"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("mjd,y", "2460000.5,1"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("mjd,y", "1e5x,1"), TOLIMAN_E_FORMAT, "t");
    assert_line_refused(kDefault, LINES("{\"t\": \"2028-03-01\", \"y\": 1}", "{\"t\": 5, \"y\": 1}"), TOLIMAN_E_FORMAT,
                        "t");
    toliman_series *series = made(kDefault);
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    assert_int_equal(toliman_series_parse(series, "2028-03-01\0x,1", 14, &sample), TOLIMAN_E_FORMAT);
    assert_string_equal(toliman_last_error(), "rv.csv:1: t: contains a zero byte");
    assert_int_equal(info_of(series).time_format, ISO);
    toliman_series_destroy(series);
}

static void assert_option(toliman_series_options options, const char *field) {
    toliman_series *series = NULL;
    assert_invalid(toliman_series_create(&options, &series), field);
    assert_null(series);
}

TEST(options_are_checked) {
    const char *const bad[] = {"", "t", "t,", ",y", "t,y,sigma,x"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_option(columns(bad[i]), "options->columns");
    assert_option(times(UTC, 0), "options->time_format");
    assert_option(times(0, ISO), "options->time_scale");
    toliman_series_options options = times(ISO, 0);
    options.flags = TOLIMAN_SERIES_PLAIN_TIMES;
    assert_option(options, "options->time_format");
    options.flags = 4;
    assert_option(options, "options->flags");
    const toliman_leap_second table[] = {{sizeof table[0], 11, 41317}};
    options = kDefault;
    options.leap_second_count = 1;
    assert_option(options, "options->leap_seconds");
    options.leap_seconds = table;
    assert_option(options, "options->leap_seconds[0]");
}

RUN_TESTS(NULL, NULL)
