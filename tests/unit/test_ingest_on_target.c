/* Tests on-target intervals: on_target_s of the side file, and tables of windows. Constants of dates: astropy 5.2. */
#include <inttypes.h>

#include "pair_files.h"

enum { EXPOSURE_S = 100, APART_S = 200, MOST = 64 }; /* exposures do not overlap */

/* A line of frame `id` with on_target_s = list; text[5000]. */
static const char *line_with(char *text, int64_t id, const char *list) {
    char line[512];
    side_line(line, id, id * APART_S * INT64_C(1000000000), (double)(id * APART_S), ROWS, COLS);
    line[strlen(line) - 2] = '\0'; /* the brace and the newline */
    snprintf(text, 5000, "%s, \"on_target_s\": %s}\n", line, list);
    return text;
}

static toliman_ingest *open_exposed(double exposure_s, uint32_t buffers) {
    toliman_ingest_options options = pair_options(0);
    options.exposure_s = exposure_s;
    options.buffers = buffers;
    return open_with(options);
}

static void assert_intervals(const toliman_frame *found, size_t count, const double *intervals) {
    assert_int_equal(found->interval_count, count);
    for (size_t i = 0; i < 2 * count; i++)
        assert_true(found->intervals[i] == intervals[i]);
}

TEST_WITH_PAIR(intervals_of_frames) {
    char text[5000], lists[MOST * 40] = "[";
    double most[2 * MOST];
    for (int i = 0; i < 2 * MOST; i++) {
        most[i] = (i + 0.1234567890123456) * EXPOSURE_S / (2 * MOST);
        snprintf(lists + strlen(lists), sizeof lists - strlen(lists), "%s%.17g", i > 0 ? ", " : "", most[i]);
    }
    strcat(lists, "]");
    put_text(side_path, "wb", line_with(text, 0, "[0, 10.25, 10.25, 40, 55e0, 100]"));
    put_lines_apart(1, 1, APART_S);
    put_text(side_path, "ab", line_with(text, 2, lists));
    put_text(side_path, "ab", line_with(text, 3, "[1, 2]"));
    put_pixels(4 * FRAME_BYTES);
    for (uint32_t buffers = 1; buffers <= 4; buffers += 3) {
        toliman_ingest *const ingest = open_exposed(EXPOSURE_S, buffers);
        toliman_frame kept[4];
        for (int i = 0; i < 4; i++) {
            assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
            kept[i] = frame;
            if (i == 1)
                assert_true(frame.intervals == NULL && frame.interval_count == 0);
            else
                assert_intervals(&frame,
                                 i == 0   ? 3
                                 : i == 2 ? MOST
                                          : 1,
                                 i == 0   ? (const double[]){0, 10.25, 10.25, 40, 55, 100}
                                 : i == 2 ? most
                                          : (const double[]){1, 2});
        }
        if (buffers == 4) { /* the first is valid during the next three calls */
            assert_intervals(&kept[0], 3, (const double[]){0, 10.25, 10.25, 40, 55, 100});
            assert_intervals(&kept[2], MOST, most);
        }
        assert_nothing(ingest);
        assert_true(frame.intervals == NULL && frame.interval_count == 0);
        toliman_ingest_destroy(ingest);
    }
}

TEST_WITH_PAIR(malformed_intervals) {
    char text[5000], many[2 * (MOST + 1) * 6] = "[0";
    for (int i = 1; i < 2 * (MOST + 1); i++)
        snprintf(many + strlen(many), sizeof many - strlen(many), ",%.1f", i / 2.0);
    strcat(many, "]");
    const char *const whole = "on_target_s must";
    const struct {
        const char *list, *text;
        double exposure_s;
    } cases[] = {{"null", whole, 100},
                 {"5", whole, 100},
                 {"{\"a\": 1}", whole, 100},
                 {"[]", whole, 100},
                 {"[1]", whole, 100},
                 {"[1, 2, 3]", whole, 100},
                 {"[[1, 2]]", whole, 100},
                 {many, whole, 100},
                 {"[1, \"2\"]", "on_target_s[1] must", 100},
                 {"[[1], [2]]", "on_target_s[0] must", 100},
                 {"[null, 2]", "on_target_s[0] must", 100},
                 {"[-1, 2]", "on_target_s[0] must", 100},
                 {"[1, 1]", "on_target_s[1] must", 100},
                 {"[2, 1]", "on_target_s[1] must", 100},
                 {"[1, 5, 4, 6]", "on_target_s[2] must", 100},
                 {"[1, 5, 5, 5]", "on_target_s[3] must", 100},
                 {"[1, 100.5]", "on_target_s[1] must", 100},
                 {"[101, 102]", "on_target_s[0] must", 100},
                 {"[1, 1e999]", "range of double", 100},
                 {"[0, 1], \"on_target_s\": [0, 1]", "duplicate", 100},
                 {"[0, 1]", "exposure_s", 0}};
    put_pixels(3 * FRAME_BYTES);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        remove(side_path);
        put_lines_apart(0, 1, APART_S);
        put_text(side_path, "ab", line_with(text, 1, cases[i].list));
        put_lines_apart(2, 1, APART_S);
        toliman_ingest *const ingest = open_exposed(cases[i].exposure_s, 1);
        assert_frame(ingest, 0, 1, 0);
        assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 2, cases[i].text);
        assert_true(frame.intervals == NULL && frame.interval_count == 0);
        if (strstr(event.text, "range of double") == NULL) {
            assert_int_equal(event.has_key, 1);
            assert_int_equal(frame.frame_id, 1);
        }
        assert_frame(ingest, 2, 3, 2 * FRAME_BYTES);
        toliman_ingest_destroy(ingest);
    }
}

static void put_table(const char *text) {
    put_text(stem_path, "wb", text);
}

static toliman_status read_table(int64_t *intervals, size_t capacity, size_t *count) {
    return toliman_ingest_read_on_target(stem_path, NULL, 0, intervals, capacity, count);
}

TEST_WITH_PAIR(tables) {
    const int64_t start = INT64_C(1835524837000000000), s = 1000000000; /* 2028-03-01T12:00:00 UTC */
    const char *const texts[] = {
        "start_tai_ns,end_tai_ns\n1835524837000000000,1835524838500000000\n1835524838500000000,1835524839000000000\n",
        "# x\n\n end_tai_ns , start_tai_ns # y\r\n1835524838500000000,1835524837000000000 # z\r\n# between\n"
        "1835524839000000000, 1835524838500000000",
        "start_utc,end_utc\n2028-03-01T12:00:00,2028-03-01T12:00:01.5Z\n2028-061T12:00:01.5,2028-061T12:00:02Z\n",
        "start_tai,end_tai\n2028-03-01T12:00:37,2028-03-01T12:00:38.5\n2028-061T12:00:38.5,2028-061T12:00:39\n",
        "start_tt,end_tt\n2028-03-01T12:01:09.184,2028-03-01T12:01:10.684\n"
        "2028-03-01T12:01:10.684,2028-03-01T12:01:11.184\n",
        "start_tdb,end_tdb\n2028-03-01T12:01:09.184,2028-03-01T12:01:10.684\n"
        "2028-03-01T12:01:10.684,2028-03-01T12:01:11.184\n",
        "start_gps,end_gps\n2028-03-01T12:00:18,2028-03-01T12:00:19.5\n2028-03-01T12:00:19.5,2028-03-01T12:00:20\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        int64_t intervals[4] = {0};
        size_t count = 0;
        put_table(texts[i]);
        assert_asks(read_table(NULL, 0, &count));
        assert_int_equal(count, 2);
        count = 77;
        assert_refused(read_table(intervals, 1, &count), TOLIMAN_E_CAPACITY, "capacity");
        assert_true(count == 2 && intervals[0] == 0);
        assert_ok(read_table(intervals, 2, &count));
        assert_int_equal(count, 2);
        assert_int_equal(intervals[0], start);
        assert_int_equal(intervals[1], start + 3 * s / 2);
        assert_int_equal(intervals[2], start + 3 * s / 2);
        assert_int_equal(intervals[3], start + 2 * s);
    }
}

TEST_WITH_PAIR(leap_seconds_of_the_caller) {
    const toliman_leap_second table[2] = {{sizeof *table, 10, 41317}, {0, 11, 41499}};
    const char *const text = "start_utc,end_utc\n2016-12-31T23:59:59,2017-01-01T00:00:00\n";
    int64_t known[2], given[2];
    size_t count = 0;
    put_table(text);
    assert_ok(read_table(known, 1, &count));
    assert_int_equal(known[0], INT64_C(1483228835000000000));
    assert_int_equal(known[1], INT64_C(1483228837000000000)); /* a leap second is between them */
    assert_ok(toliman_ingest_read_on_target(stem_path, table, 2, given, 1, &count));
    assert_int_equal(given[0], known[0] - INT64_C(25000000000));
    assert_int_equal(given[1], known[1] - INT64_C(26000000000));
    assert_invalid(toliman_ingest_read_on_target(stem_path, table, 1, NULL, 1, &count), "intervals");
    const toliman_leap_second wrong = {sizeof wrong, 11, 41317};
    assert_invalid(toliman_ingest_read_on_target(stem_path, &wrong, 1, NULL, 0, &count), "leap_seconds[0]");
}

#define NS "start_tai_ns,end_tai_ns\n"
#define UTC "start_utc,end_utc\n"

TEST_WITH_PAIR(malformed_tables) {
    const char *const bad[][2] = {{"", "is empty"},
                                  {"# nothing\n\n", "contains no window"},
                                  {NS "# nothing\n", "contains no window"},
                                  {"1,2\n", "day1:1: "},
                                  {"#\nstart,end\n1,2\n", "day1:2: "},
                                  {"start_tai_ns\n1\n", "day1:1: "},
                                  {"start_tai_ns,end_tai_ns,flag\n1,2,3\n", "day1:1: "},
                                  {"start_tai_ns,end_utc\n", "day1:1: "},
                                  {"start_tai_ns,start_tai_ns\n", "day1:1: "},
                                  {"start_tcb,end_tcb\n", "day1:1: "},
                                  {"START_UTC,END_UTC\n", "day1:1: "},
                                  {NS "1\n", "day1:2: "},
                                  {NS "1,2,3\n", "day1:2: "},
                                  {NS "1;2\n", "day1:2: "},
                                  {NS "1,\n", "day1:2: "},
                                  {NS "1e3,2e3\n", "day1:2: "},
                                  {NS "1,9223372036854775808\n", "day1:2: "},
                                  {NS "1,4102444800000000000\n", "day1:2: "},
                                  {NS "-378691200000000001,1\n", "day1:2: "},
                                  {NS "# y\n5,5\n", "day1:3: "},
                                  {NS "5,4\n", "day1:2: "},
                                  {NS "0,1000000000\n\n999999999,1500000000\n", "day1:4: "},
                                  {NS "0,5\n-5,-1\n", "day1:3: "},
                                  {NS "1,2\n" NS, "day1:3: "},
                                  {UTC "2028-03-01,2028-03-02\n", "day1:2: "},
                                  {UTC "2028-03-01T12:00:00,2028-02-30T12:00:00\n", "day1:2: "},
                                  {UTC "1971-03-01T12:00:00,1973-02-20T12:00:00\n", "day1:2: "},
                                  {"start_gps,end_gps\n2028-03-01T12:00:00,2028-03-01T12:00:01Z\n", "day1:2: "}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t count = 77;
        put_table(bad[i][0]);
        assert_fails(read_table(NULL, 0, &count), TOLIMAN_E_FORMAT, bad[i][1]);
        assert_string_equal(toliman_last_error_field(), stem_path);
        assert_int_equal(count, 77);
    }
}

TEST(wrong_arguments) {
    int64_t intervals[2];
    size_t count = 0;
    assert_invalid(toliman_ingest_read_on_target(NULL, NULL, 0, NULL, 0, &count), "path");
    assert_invalid(toliman_ingest_read_on_target("x", NULL, 1, intervals, 1, &count), "leap_seconds");
    assert_invalid(toliman_ingest_read_on_target("x", NULL, 0, NULL, 1, &count), "intervals");
    assert_invalid(toliman_ingest_read_on_target("x", NULL, 0, intervals, 1, NULL), "count");
    assert_refused(toliman_ingest_read_on_target("/none/w.csv", NULL, 0, NULL, 0, &count), TOLIMAN_E_NOT_FOUND,
                   "/none/w.csv");
}

RUN_TESTS(NULL, NULL)
