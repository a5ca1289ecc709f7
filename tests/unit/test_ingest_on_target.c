/* Tests on-target intervals of frames: on_target_s of the side file. */
#include <inttypes.h>

#include "pair_files.h"

enum { EXPOSURE_S = 100, MOST = 64 };

/* A line of frame `id` with on_target_s = list; text[5000]. */
static const char *line_with(char *text, int64_t id, const char *list) {
    char line[512];
    side_line(line, id, id * INT64_C(1000000000), (double)id, ROWS, COLS);
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

static void intervals_of_frames(void **state) {
    (void)state;
    char text[5000], lists[MOST * 40] = "[";
    double most[2 * MOST];
    for (int i = 0; i < 2 * MOST; i++) {
        most[i] = (i + 0.1234567890123456) * EXPOSURE_S / (2 * MOST);
        snprintf(lists + strlen(lists), sizeof lists - strlen(lists), "%s%.17g", i > 0 ? ", " : "", most[i]);
    }
    strcat(lists, "]");
    put_text(side_path, "wb", line_with(text, 0, "[0, 10.25, 10.25, 40, 55e0, 100]"));
    put_lines(1, 1);
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

static void malformed_intervals(void **state) {
    (void)state;
    char text[5000], many[2 * (MOST + 1) * 6] = "[0";
    for (int i = 1; i < 2 * (MOST + 1); i++)
        snprintf(many + strlen(many), sizeof many - strlen(many), ",%.1f", i / 2.0);
    strcat(many, "]");
    const char *const whole = "on_target_s must be an array of 2 to 128 numbers";
    const struct {
        const char *list, *text;
        double exposure_s;
    } cases[] = {
        {"null", whole, 100},
        {"5", whole, 100},
        {"{\"a\": 1}", whole, 100},
        {"[]", whole, 100},
        {"[1]", whole, 100},
        {"[1, 2, 3]", whole, 100},
        {"[[1, 2]]", whole, 100},
        {many, whole, 100},
        {"[1, \"2\"]", "on_target_s[1] must be a number", 100},
        {"[[1], [2]]", "on_target_s[0] must be a number", 100},
        {"[null, 2]", "on_target_s[0] must be a number", 100},
        {"[-1, 2]", "on_target_s[0] must be at least 0 s, not -1 s", 100},
        {"[1, 1]", "on_target_s[1] must be above 1 s, not 1 s", 100},
        {"[2, 1]", "on_target_s[1] must be above 2 s, not 1 s", 100},
        {"[1, 5, 4, 6]", "on_target_s[2] must be at least 5 s, not 4 s", 100},
        {"[1, 5, 5, 5]", "on_target_s[3] must be above 5 s, not 5 s", 100},
        {"[1, 100.5]", "on_target_s[1] must be within the exposure of 100 s, not 100.5 s", 100},
        {"[101, 102]", "on_target_s[0] must be within the exposure of 100 s, not 101 s", 100},
        {"[1, 1e999]", "range of double", 100},
        {"[0, 1], \"on_target_s\": [0, 1]", "duplicate key \"on_target_s\"", 100},
        {"[0, 1]", "on_target_s needs the length of the exposure: exposure_s, or --exposure of toliman", 0},
    };
    put_pixels(3 * FRAME_BYTES);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        remove(side_path);
        put_lines(0, 1);
        put_text(side_path, "ab", line_with(text, 1, cases[i].list));
        put_lines(2, 1);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(intervals_of_frames, make_pair, remove_pair),
        cmocka_unit_test_setup_teardown(malformed_intervals, make_pair, remove_pair),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
