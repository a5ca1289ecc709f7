/* Tests the warnings of the reader of pairs about time stamps: jumps, and clocks that differ. */
#include <math.h>

#include "pair_files.h"

/* The times in s of up to 12 lines, NaN for a malformed one, and the lines that are reported. */
TEST_WITH_PAIR(test_clock) {
    static const struct {
        int count;
        double times[12];
        int reported[3];
        const char *text;
    } cases[] = {{4, {0, 1, 2, 3}, {0}, ""},
                 {4, {0, 1, 2, 1001.9}, {0}, ""},
                 {5, {0, 1, 2, 1003, 1004}, {4}, "timestamp_ns advances by 1001 s, the median step is 1 s"},
                 {5, {0, 1, 2, 1.5, 2.5}, {4}, "timestamp_ns goes back by 0.5 s"},
                 {6, {0, 1, 1, 1, 2, 2}, {3, 6}, "as in the frame before"},
                 {6, {0, 1, 2, NAN, NAN, 1.5}, {6}, "goes back by 0.5 s"},
                 {7, {0, 1, 2, NAN, NAN, 3001.9, 3003}, {0}, ""},
                 {7, {0, 1, 2, NAN, NAN, 3002.1, 3003}, {6}, "advances by 3000.1 s"},
                 {1, {-5}, {0}, ""}};
    char text[512];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        remove(side_path);
        for (int i = 0; i < cases[k].count; i++) {
            const double t = cases[k].times[i];
            put_text(side_path, "ab",
                     t != t ? "{}\n" : side_line(text, i, (int64_t)(t * 1e9 + (t < 0 ? -0.5 : 0.5)), t, ROWS, COLS));
        }
        remove(pixel_path);
        put_pixels((size_t)cases[k].count * FRAME_BYTES);
        toliman_ingest *const ingest = open_pair(0);
        const int *reported = cases[k].reported;
        for (int i = 0; i < cases[k].count; i++) {
            if (*reported == i + 1) {
                assert_warning(ingest, TOLIMAN_INGEST_REASON_CLOCK_JUMP, i + 1, cases[k].text);
                reported++;
            }
            if (cases[k].times[i] != cases[k].times[i])
                assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, i + 1, "");
            else
                assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
        }
        assert_end(ingest);
    }
}

TEST_WITH_PAIR(test_drift) {
    const struct {
        double scale, late;
        int line;
    } cases[] = {{1, 0.99, 0}, {1, 1.02, 2}, {1.009, 0, 0}, {1.02, 0, 2}, {0.98, 0, 2}, {1e-3, 0, 2}, {0, 0, 2}};
    char text[512];
    put_pixels(5 * FRAME_BYTES);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        remove(side_path);
        for (int i = 0; i < 5; i++) {
            const double t = 1e5 * i;
            put_text(side_path, "ab",
                     side_line(text, i, (int64_t)(t * 1e9),
                               cases[k].scale * t + (i > 0) * cases[k].late * (1 + 0.01 * t), ROWS, COLS));
        }
        toliman_ingest *const ingest = open_pair(0);
        for (int i = 0; i < 5; i++) {
            if (cases[k].line == i + 1)
                assert_warning(ingest, TOLIMAN_INGEST_REASON_CLOCKS_DIFFER, i + 1,
                               "since line 1 timestamp_ns has advanced by 100000 s, host_time by ");
            assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
        }
        assert_end(ingest);
    }
}

/* Exposures of frames 1 s apart; a length in ms was taken for s. */
TEST_WITH_PAIR(test_overlaps) {
    put_lines(0, 4);
    put_pixels(4 * FRAME_BYTES);
    const double lengths[] = {0, 0.9, 1.04, 1.1, 900};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        toliman_ingest_options options = pair_options(0);
        options.exposure_s = lengths[i];
        toliman_ingest *const ingest = open_with(options);
        for (int k = 0; k < 4; k++) {
            if (k == 1 && lengths[i] > 1.05) /* once */
                assert_warning(ingest, TOLIMAN_INGEST_REASON_OVERLAP, 2,
                               "frames 0 and 1 are 1 s apart, and their exposures");
            assert_frame(ingest, k, k + 1, (uint64_t)k * FRAME_BYTES);
        }
        assert_end(ingest);
    }
}

RUN_TESTS(NULL, NULL)
