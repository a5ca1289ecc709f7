/* Tests what a pair of files tells about its camera: restarts within a session, further keys, blank lines, regions. */
#include <stdbool.h>

#include "pair_files.h"

typedef struct {
    int64_t id, stamp_s;
    double host_s;
    const char *roi;
    int64_t restarts, camera_s;
} line;

#define AT(id, stamp_s, host_s)                                                                                        \
    { id, stamp_s, host_s, NULL, 0, 0 }

static void put(const line *one) {
    char text[512];
    snprintf(text, sizeof text,
             "{\"frame_id\": %lld, \"timestamp_ns\": %lld, \"host_time\": %.9f, \"nframes_dropped\": 0, \"roi_label\": "
             "\"%s\", \"n_rows\": %d, \"n_cols\": %d, \"session_id\": \"day1\"}\n",
             (long long)one->id, (long long)(one->stamp_s * 1000000000), one->host_s, one->roi != NULL ? one->roi : "r",
             ROWS, COLS);
    put_text(side_path, "ab", text);
}

/* Reads the next frame of a line; the warning before it, if it has one, must be that of a restart if `restarts`. */
static int next_frame(toliman_ingest *ingest, const line *one, bool restarts) {
    int warnings = 0;
    if (next_event(ingest) == TOLIMAN_INGEST_EVENT_NOTHING) /* the call after it examines files that grow */
        (void)next_event(ingest);
    for (; event.event == TOLIMAN_INGEST_EVENT_WARNING; warnings++) {
        assert_int_equal(event.reason == TOLIMAN_INGEST_REASON_RESTART, restarts);
        assert_ok(toliman_ingest_next(ingest, &frame, &event));
    }
    assert_int_equal(event.event, TOLIMAN_INGEST_EVENT_FRAME);
    assert_int_equal(frame.frame_id, one->id);
    assert_int_equal(frame.restarts, one->restarts);
    assert_int_equal(frame.camera_ns, one->camera_s * 1000000000);
    assert_int_equal(event.stamp_ns, one->stamp_s * 1000000000);
    return warnings;
}

/* Each row: a file, complete and growing line by line. */
/* promise: restarted-counters-lose-no-frame */
TEST_WITH_PAIR(test_restarts) {
    static const struct {
        const char *what;
        int restarts; /* warnings */
        line lines[9];
        int count;
    } files[] = {
        {"counter and clock",
         1,
         {AT(0, 100, 0),
          AT(1, 101, 1),
          AT(2, 102, 2),
          AT(3, 103, 3),
          {0, 7, 9, NULL, 1, 109},
          {1, 8, 10, NULL, 1, 110}},
         6},
        {"counter alone", 1, {AT(5, 100, 0), AT(6, 101, 1), {0, 104, 4, NULL, 1, 104}, {1, 105, 5, NULL, 1, 105}}, 4},
        {"twice",
         2,
         {AT(3, 100, 0), AT(4, 101, 1), {0, 0, 5, NULL, 1, 105}, {1, 1, 6, NULL, 1, 106}, {0, 0, 9, NULL, 2, 109}},
         5},
        {"one frame before it", 1, {AT(0, 100, 0), {0, 3, 8, NULL, 1, 108}, {1, 4, 9, NULL, 1, 109}}, 3},
        {"frames lost after it", 1, {AT(50, 100, 0), AT(51, 101, 1), {4, 2, 6, NULL, 1, 106}}, 3},
        {"a damaged id", 0, {AT(1000, 0, 0), AT(1001, 1, 1), AT(500, 2, 2), AT(1003, 3, 3)}, 4},
        {"a damaged id, higher", 0, {AT(1000, 0, 0), AT(1001, 1, 1), AT(9002, 2, 2), AT(1003, 3, 3)}, 4},
        {"a damaged id, 0",
         1,
         {AT(1000, 0, 0), AT(1001, 1, 1), {0, 2, 2, NULL, 1, 2}, AT(1003, 3, 3), AT(1004, 4, 4)},
         5},
        {"late frames", 0, {AT(0, 0, 0), AT(2, 2, 2), AT(1, 1, 1), AT(3, 3, 3)}, 4},
        {"a late frame of before it",
         1,
         {AT(7, 100, 0), AT(8, 101, 1), {0, 0, 9, NULL, 1, 109}, AT(9, 102, 2), {1, 1, 10, NULL, 1, 110}},
         5},
        {"a host without clock", 0, {AT(0, 0, 0), AT(1, 1, 0), AT(0, 2, 0)}, 3},
        {"two regions of each exposure",
         1,
         {{4, 100, 0, "a", 0, 0},
          {4, 100, 0, "b", 0, 0},
          {5, 101, 1, "a", 0, 0},
          {5, 101, 1, "b", 0, 0},
          {0, 0, 5, "a", 1, 105},
          {0, 0, 5, "b", 1, 105},
          {1, 1, 6, "a", 1, 106}},
         7},
    };
    for (size_t k = 0; k < sizeof files / sizeof *files; k++)
        for (int grows = 0; grows < 2; grows++) {
            print_message("%s\n", files[k].what);
            remove(side_path);
            remove(pixel_path);
            put_pixels((size_t)(grows ? 1 : files[k].count) * FRAME_BYTES);
            put_text(side_path, "wb", "");
            for (int i = 0; !grows && i < files[k].count; i++)
                put(&files[k].lines[i]);
            toliman_ingest *const ingest = open_pair(grows ? TOLIMAN_INGEST_GROWING : 0);
            int64_t restarts = 0, warnings = 0;
            for (int i = 0; i < files[k].count; i++) {
                line expected = files[k].lines[i];
                if (grows) {
                    put(&expected);
                    put_pixels((size_t)(i + 1) * FRAME_BYTES);
                }
                if (expected.camera_s == 0)
                    expected.camera_s = expected.stamp_s;
                const bool is_restart = expected.restarts > restarts;
                restarts = is_restart ? expected.restarts : restarts;
                const int before = next_frame(ingest, &expected, is_restart);
                warnings += is_restart ? before : 0;
                assert_true(!is_restart || before == 1);
            }
            assert_int_equal(warnings, files[k].restarts);
            assert_nothing(ingest);
            toliman_ingest_destroy(ingest);
        }
}

/* Further keys: one warning, and the frames. A key is shown without control bytes. */
TEST_WITH_PAIR(test_further_keys) {
    char text[512];
    put_pixels(3 * FRAME_BYTES);
    for (int i = 0; i < 3; i++) {
        char *const end = strrchr(side_line(text, i, i, i * 1e-9, ROWS, COLS), '}');
        (void)snprintf(end, sizeof text - (size_t)(end - text),
                       ", \"\\u001b[2J\": [1, {\"a\": null}], \"exposure_us\": 5}\n");
        put_text(side_path, "ab", text);
    }
    toliman_ingest *const ingest = open_pair(0);
    assert_warning(ingest, TOLIMAN_INGEST_REASON_UNKNOWN_KEY, 1, "unknown key \"?[2J\": ignored");
    for (int i = 0; i < 3; i++)
        assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
    assert_end(ingest);
}

/* Blank lines have no pixels, but a number. */
TEST_WITH_PAIR(test_blank_lines) {
    char text[512];
    put_pixels(3 * FRAME_BYTES);
    put_text(side_path, "ab", "\n \t\r\n");
    for (int i = 0; i < 3; i++) {
        put_text(side_path, "ab", side_line(text, i, i, i * 1e-9, ROWS, COLS));
        put_text(side_path, "ab", "\r\n");
    }
    put_text(side_path, "ab", "  "); // without a newline
    toliman_ingest *const ingest = open_pair(0);
    for (int i = 0; i < 3; i++)
        assert_frame(ingest, i, 2 * i + 3, (uint64_t)i * FRAME_BYTES);
    assert_end(ingest);
}

TEST_WITH_PAIR(test_region) {
    const line lines[] = {{0, 0, 0, "a", 0, 0}, {0, 0, 0, "b", 0, 0}, {1, 1, 1, "a", 0, 1}, {1, 1, 1, "b", 0, 1}};
    put_pixels(4 * FRAME_BYTES);
    for (int i = 0; i < 4; i++)
        put(&lines[i]);
    toliman_ingest_options options = pair_options(0);
    options.roi = "b";
    toliman_ingest *const ingest = open_with(options);
    for (int i = 1; i < 4; i += 2) {
        next_frame(ingest, &lines[i], false);
        assert_string_equal(frame.roi, "b");
        assert_int_equal(event.offset, i * FRAME_BYTES);
    }
    assert_nothing(ingest);
    assert_int_equal(info_of(ingest).skipped, 2);
    toliman_ingest_destroy(ingest);
    options.roi = "../b";
    toliman_ingest *refused = NULL;
    assert_invalid(toliman_ingest_create(stem_path, &options, &refused), "options->roi");
}

RUN_TESTS(NULL, NULL)
