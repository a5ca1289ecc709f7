/* A pair of files in a temporary folder, and a reader of it. */
#ifndef TOLIMAN_TESTS_PAIR_FILES_H
#define TOLIMAN_TESTS_PAIR_FILES_H

#include <stdarg.h>
#include <stdint.h>

#include <toliman/ingest.h>

#include "test_folder.h"

enum { ROWS = 3, COLS = 4, FRAME_BYTES = 2 * ROWS * COLS };

static char pair_folder[256], stem_path[300], side_path[320], pixel_path[320];

static inline int make_pair(void **state) {
    (void)state;
    make_folder(pair_folder, sizeof pair_folder);
    snprintf(stem_path, sizeof stem_path, "%s/day1", pair_folder);
    snprintf(side_path, sizeof side_path, "%s_meta.jsonl", stem_path);
    snprintf(pixel_path, sizeof pixel_path, "%s_frames.bin", stem_path);
    return 0;
}

static inline int remove_pair(void **state) {
    (void)state;
    remove_folder(pair_folder);
    return 0;
}

#define TEST_WITH_PAIR(name) TEST_WITH(name, make_pair, remove_pair)

static inline void put_bytes(const char *path, const char *mode, const void *bytes, size_t size) {
    FILE *file = fopen(path, mode);
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void put_text(const char *path, const char *mode, const char *text) {
    put_bytes(path, mode, text, strlen(text));
}

/* Byte i of every file of pixels. */
static inline unsigned char pixel_byte(uint64_t i) {
    return (unsigned char)((i * 2654435761u) >> 13);
}

/* Creates the file of pixels with its first `size` bytes, or lets it grow to them. */
static inline void put_pixels(size_t size) {
    FILE *file = fopen(pixel_path, "ab");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    for (size_t i = (size_t)ftell(file); i < size; i++)
        fputc(pixel_byte(i), file);
    assert_int_equal(fclose(file), 0);
}

/* The line of a frame of ROWS x COLS pixels; text[512]. */
static inline const char *side_line(char *text, int64_t id, int64_t stamp_ns, double host_s, int rows, int cols) {
    snprintf(text, 512,
             "{\"frame_id\": %lld, \"timestamp_ns\": %lld, \"host_time\": %.9f, \"nframes_dropped\": 0, "
             "\"roi_label\": \"single_roi\", \"n_rows\": %d, \"n_cols\": %d, \"session_id\": \"day1\"}\n",
             (long long)id, (long long)stamp_ns, host_s, rows, cols);
    return text;
}

/* Appends the lines of the frames first ... first + count - 1, so many seconds apart. */
static inline void put_lines_apart(int first, int count, int seconds) {
    char text[512];
    for (int i = first; i < first + count; i++)
        put_text(side_path, "ab", side_line(text, i, i * seconds * INT64_C(1000000000), i * seconds, ROWS, COLS));
}
static inline void put_lines(int first, int count) {
    put_lines_apart(first, count, 1);
}

static inline toliman_ingest_options pair_options(uint32_t flags) {
    toliman_ingest_options options = TOLIMAN_INGEST_OPTIONS_INIT;
    options.pixel = TOLIMAN_PIXEL_U16;
    options.rows = ROWS;
    options.cols = COLS;
    options.flags = flags;
    return options;
}

static inline toliman_ingest *open_with(toliman_ingest_options options) {
    toliman_ingest *ingest = NULL;
    assert_ok(toliman_ingest_create(stem_path, &options, &ingest));
    return ingest;
}

static inline toliman_ingest *open_pair(uint32_t flags) {
    return open_with(pair_options(flags));
}

/* The last event of next_event. */
static toliman_frame frame;
static toliman_ingest_event event;

static inline int32_t next_event(toliman_ingest *ingest) {
    frame = (toliman_frame)TOLIMAN_FRAME_INIT;
    event = (toliman_ingest_event)TOLIMAN_INGEST_EVENT_INIT;
    assert_ok(toliman_ingest_next(ingest, &frame, &event));
    return event.event;
}

static inline void assert_frame(toliman_ingest *ingest, int64_t id, int64_t line, uint64_t offset) {
    if (next_event(ingest) != TOLIMAN_INGEST_EVENT_FRAME)
        fail_msg("frame %lld: event %d, %s", (long long)id, event.event, event.text);
    assert_int_equal(frame.frame_id, id);
    assert_int_equal(event.line, line);
    assert_int_equal(event.reason, TOLIMAN_INGEST_REASON_NONE);
    assert_string_equal(event.text, "");
    const size_t bytes = (size_t)(frame.rows * frame.cols) * (frame.pixel == TOLIMAN_PIXEL_U16 ? 2 : 4);
    for (size_t i = 0; i < bytes; i++)
        assert_int_equal(((const unsigned char *)frame.pixels)[i], pixel_byte(offset + i));
}

/* Frames first ... end - 1 of a pair with these ids, all of ROWS x COLS pixels of 16 bits. */
static inline void assert_frames(toliman_ingest *ingest, int first, int end) {
    for (int i = first; i < end; i++)
        assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
}

static inline void assert_event(toliman_ingest *ingest, int32_t kind, int32_t reason, int64_t line, const char *text) {
    if (next_event(ingest) != kind || event.reason != reason || event.line != line || strstr(event.text, text) == NULL)
        fail_msg("event %d, %s, line %lld: \"%s\", expected %d, %s, line %lld: \"%s\"", event.event,
                 toliman_constant_name(event.reason), (long long)event.line, event.text, kind,
                 toliman_constant_name(reason), (long long)line, text);
}

static inline void assert_damage(toliman_ingest *ingest, int32_t reason, int64_t line, const char *text) {
    assert_event(ingest, TOLIMAN_INGEST_EVENT_DAMAGE, reason, line, text);
}

static inline void assert_warning(toliman_ingest *ingest, int32_t reason, int64_t line, const char *text) {
    assert_event(ingest, TOLIMAN_INGEST_EVENT_WARNING, reason, line, text);
}

static inline void assert_nothing(toliman_ingest *ingest) {
    if (next_event(ingest) != TOLIMAN_INGEST_EVENT_NOTHING)
        fail_msg("event %d, line %lld: %s, expected none", event.event, (long long)event.line, event.text);
    assert_null(frame.session);
    assert_null(frame.pixels);
    assert_string_equal(event.text, "");
}

/* Nothing is left; destroys the reader. */
static inline void assert_end(toliman_ingest *ingest) {
    assert_nothing(ingest);
    toliman_ingest_destroy(ingest);
}

static inline toliman_ingest_info info_of(const toliman_ingest *ingest) {
    toliman_ingest_info info = TOLIMAN_INGEST_INFO_INIT;
    assert_ok(toliman_ingest_get_info(ingest, &info));
    return info;
}

#endif
