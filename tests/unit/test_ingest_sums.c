/* Tests the keys of sums in lines of a side file: exposure, number of frames, covariance and cumulants of places. */
#include "pair_files.h"

static const int64_t kSecond = 1000000000;

/* A line of frame `id` at 200 id s with further members. */
static void put_line(const char *mode, int64_t id, const char *members) {
    char line[512], text[5000];
    side_line(line, id, id * 200 * kSecond, (double)(id * 200), ROWS, COLS);
    line[strlen(line) - 2] = '\0'; /* the brace and the newline */
    snprintf(text, sizeof text, "%s%s%s}\n", line, *members != '\0' ? ", " : "", members);
    put_text(side_path, mode, text);
}

TEST_WITH_PAIR(sums_have_their_exposure_and_spread) {
    put_line("wb", 0,
             "\"exposure_s\": 20, \"on_target_s\": [1, 19.5], \"frames\": 1000, \"jitter_px2\": [0.09, 0.08, -0.01]");
    put_line("ab", 1, "");
    put_line("ab", 2,
             "\"jitter_px2\": [1, 0.5, 0.1], \"cumulants_px\": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, "
             "16, 17, 18, 19, 20, 21, 2.2e-1]");
    put_pixels(3 * FRAME_BYTES);
    const int32_t stamps[] = {TOLIMAN_FRAME_STAMP_START, TOLIMAN_FRAME_STAMP_MIDDLE, TOLIMAN_FRAME_STAMP_END};
    for (int i = 0; i < 3; i++) {
        toliman_ingest_options options = pair_options(0);
        options.stamp = stamps[i];
        options.exposure_s = 4;
        options.buffers = 3;
        toliman_ingest *const ingest = open_with(options);
        assert_frame(ingest, 0, 1, 0);
        const toliman_frame first = frame;
        assert_close(first.exposure_s, 20, 0, 0);
        assert_int_equal(first.camera_ns, (1 - i) * 10 * kSecond);
        assert_close(first.intervals[1], 19.5, 0, 0);
        assert_frame(ingest, 1, 2, FRAME_BYTES);
        assert_close(frame.exposure_s, 4, 0, 0);
        assert_int_equal(frame.camera_ns, 200 * kSecond + (1 - i) * 2 * kSecond);
        assert_null(frame.spread);
        assert_frame(ingest, 2, 3, 2 * FRAME_BYTES);
        assert_close(frame.spread->frames, 1, 0, 0);
        for (int k = 0; k < 21; k++)
            assert_close(frame.spread->cumulants[k], k + 1, 0, 0);
        assert_close(frame.spread->cumulants[21], 0.22, 1e-15, 0);
        assert_close(first.spread->frames, 1000, 0, 0); /* still valid */
        assert_close(first.spread->xx_px2, 0.09, 0, 0);
        assert_close(first.spread->yy_px2, 0.08, 0, 0);
        assert_close(first.spread->xy_px2, -0.01, 0, 0);
        assert_nothing(ingest);
        toliman_ingest_destroy(ingest);
    }
}

TEST_WITH_PAIR(malformed_keys_are_damage) {
    static const char *const kCases[][2] = {
        {"\"exposure_s\": -1", "exposure_s must"},
        {"\"exposure_s\": \"1\"", "exposure_s must"},
        {"\"exposure_s\": 10, \"on_target_s\": [1, 11]", "on_target_s[1] must"},
        {"\"frames\": 0.5", "frames must"},
        {"\"frames\": 1e13", "frames must"},
        {"\"jitter_px2\": [1, 1]", "jitter_px2 must"},
        {"\"jitter_px2\": [1, 1, true]", "jitter_px2[2] must"},
        {"\"jitter_px2\": [-1, 1, 0]", "jitter_px2"},
        {"\"jitter_px2\": [5, 1, 0]", "jitter_px2"},
        {"\"jitter_px2\": [1, 1, 1.1]", "jitter_px2"},
        {"\"cumulants_px\": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]", "needs jitter_px2"},
        {"\"jitter_px2\": [1, 1, 0], \"cumulants_px\": [1]", "cumulants_px must"},
        {"\"jitter_px2\": [0, 0, 0], \"cumulants_px\": [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, "
         "0]",
         "cumulants_px must be 0"},
        {"\"frames\": 2, \"frames\": 3", "duplicate key"},
    };
    enum { CASES = sizeof kCases / sizeof *kCases };
    for (int i = 0; i < CASES; i++)
        put_line(i == 0 ? "wb" : "ab", i, kCases[i][0]);
    put_pixels(CASES * FRAME_BYTES);
    toliman_ingest *const ingest = open_pair(0);
    for (int i = 0; i < CASES; i++)
        assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, i + 1, kCases[i][1]);
    assert_nothing(ingest);
    toliman_ingest_destroy(ingest);
}

RUN_TESTS(NULL, NULL)
