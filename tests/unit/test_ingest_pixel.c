/* The pixel type of a pair: given, named by the key dtype of its lines, or found from the size of its pixels. */
#include "pair_files.h"

enum { PIXELS = ROWS * COLS, LINES = 4 };

/* Writes LINES lines; line k has the member dtype with the JSON text types[k], unless it is NULL. */
static void put_typed(const char *const types[LINES], size_t bytes) {
    put_text(side_path, "wb", "");
    put_text(pixel_path, "wb", "");
    for (int k = 0; k < LINES; k++) {
        char line[512], text[600];
        side_line(line, k, k * INT64_C(1000000000), k, ROWS, COLS);
        snprintf(text, sizeof text, "%.*s", (int)strlen(line) - 2, line);
        put_text(side_path, "ab", text);
        snprintf(text, sizeof text, types[k] != NULL ? ", \"dtype\": %s}\n" : "}\n", types[k]);
        put_text(side_path, "ab", text);
    }
    put_pixels(bytes);
}

static int32_t known_pixel(const toliman_ingest *ingest) {
    toliman_ingest_info info = TOLIMAN_INGEST_INFO_INIT;
    assert_ok(toliman_ingest_get_info(ingest, &info));
    return info.pixel;
}

static toliman_ingest *open_typed(int32_t pixel, uint32_t flags) {
    toliman_ingest_options options = pair_options(flags);
    options.pixel = pixel;
    toliman_ingest *const ingest = open_with(options);
    assert_int_equal(known_pixel(ingest), pixel);
    return ingest;
}

#define SAME(type)                                                                                                     \
    { type, type, type, type }
#define U16 "\"u16le\""
#define U32 "\"u32le\""

/* promise: pixel-type-is-found */
TEST_WITH_PAIR(test_type_is_found) {
    static const struct {
        const char *types[LINES];
        size_t bytes;         /* of the file of pixels */
        int32_t given, found; /* found: 0 for a contradiction */
        int frames[2];        /* that are read: complete files, growing ones */
    } cases[] = {
        {SAME(NULL), 2 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U16, {4, 4}},
        {SAME(NULL), 4 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U32, {4, -1}}, /* twice the size of what the mission writes */
        {SAME(NULL), 3 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U32, {3, -1}},
        {SAME(NULL), 3 * LINES * PIXELS - 1, 0, TOLIMAN_PIXEL_U16, {4, 4}},
        {SAME(NULL), 2 * PIXELS, 0, TOLIMAN_PIXEL_U16, {1, 1}},
        {SAME(NULL), 3 * LINES * PIXELS, TOLIMAN_PIXEL_U16, TOLIMAN_PIXEL_U16, {4, 4}},
        {SAME(U16), 4 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U16, {4, 4}},
        {SAME(U16), 4 * LINES * PIXELS, TOLIMAN_PIXEL_U16, TOLIMAN_PIXEL_U16, {4, 4}},
        {SAME(U32), 2 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U32, {2, 2}},
        {{NULL, U32, NULL, U32}, 4 * LINES * PIXELS, 0, TOLIMAN_PIXEL_U32, {4, 4}},
        {SAME(U32), 4 * LINES * PIXELS, TOLIMAN_PIXEL_U16, 0, {0, 0}},
        {SAME(U16), 2 * LINES * PIXELS, TOLIMAN_PIXEL_U32, 0, {0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int growing = 0; growing < 2; growing++) {
            if (cases[i].frames[growing] < 0)
                continue;
            put_typed(cases[i].types, cases[i].bytes);
            toliman_ingest *const ingest = open_typed(cases[i].given, growing ? TOLIMAN_INGEST_GROWING : 0);
            if (cases[i].found == 0) {
                for (int again = 0; again < 2; again++)
                    assert_fails(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, "(--dtype)");
            } else {
                const size_t bytes = cases[i].found == TOLIMAN_PIXEL_U32 ? 4 * PIXELS : 2 * PIXELS;
                for (int k = 0; k < cases[i].frames[growing]; k++) {
                    assert_frame(ingest, k, k + 1, (uint64_t)k * bytes);
                    assert_int_equal(frame.pixel, cases[i].found);
                }
                assert_int_equal(known_pixel(ingest), cases[i].found);
                assert_int_not_equal(next_event(ingest), TOLIMAN_INGEST_EVENT_FRAME);
            }
            toliman_ingest_destroy(ingest);
        }
}

/* A line that contradicts those before it, or has another type, is damage: its frame alone is lost. */
TEST_WITH_PAIR(test_bad_type) {
    static const struct {
        const char *type, *text;
    } cases[] = {{U32, "dtype must be u16le, as before, not u32le"},
                 {"\"f32le\"", "dtype must be \"u16le\" or \"u32le\""},
                 {"\"u16be\"", "dtype must be \"u16le\" or \"u32le\""},
                 {"2", "dtype must be \"u16le\" or \"u32le\""}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int given = 0; given < 2; given++) {
            const char *const types[LINES] = {given ? NULL : U16, U16, cases[i].type, U16};
            put_typed(types, 2 * LINES * PIXELS);
            toliman_ingest *const ingest = open_typed(given ? TOLIMAN_PIXEL_U16 : 0, 0);
            assert_frames(ingest, 0, 2);
            assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 3, cases[i].text);
            assert_frame(ingest, 3, 4, 3 * FRAME_BYTES);
            assert_end(ingest);
            toliman_ingest_destroy(ingest);
        }
}

/* Lines without type that are read first decide for a growing pair; it is found again once the files are replaced. */
TEST_WITH_PAIR(test_type_of_growing_pair) {
    static const char *const none[LINES] = SAME(NULL), *const wide[LINES] = SAME(U32);
    put_typed(none, 2 * LINES * PIXELS);
    toliman_ingest *const ingest = open_typed(0, TOLIMAN_INGEST_GROWING);
    assert_frames(ingest, 0, LINES);
    assert_nothing(ingest);
    char line[512];
    put_text(side_path, "wb", "");
    assert_nothing(ingest); /* replaced */
    put_typed(wide, 4 * LINES * PIXELS);
    for (int k = 0; k < LINES; k++)
        assert_frame(ingest, k, k + 1, (uint64_t)k * 2 * FRAME_BYTES);
    assert_int_equal(known_pixel(ingest), TOLIMAN_PIXEL_U32);
    assert_nothing(ingest);
    put_text(side_path, "ab", side_line(line, LINES, LINES * INT64_C(1000000000), LINES, ROWS, COLS));
    put_pixels(4 * (LINES + 1) * PIXELS);
    assert_frame(ingest, LINES, LINES + 1, LINES * 2 * FRAME_BYTES);
    toliman_ingest_destroy(ingest);
}

RUN_TESTS(NULL, NULL)
