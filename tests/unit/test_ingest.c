/* Tests the reader of complete pairs: frames, damage of every kind, options and errors. */
#include <inttypes.h>
#include <sys/stat.h>

#include "pair_files.h"

TEST_WITH_PAIR(test_frames) {
    static const char *const lines[] = {
        "{\"frame_id\": -5, \"timestamp_ns\": -9223372036854775808, \"host_time\": 1.5, \"nframes_dropped\": 72000, "
        "\"roi_label\": \"a\", \"n_rows\": 1, \"n_cols\": 5, \"session_id\": \"s.1_-\"}\n",
        "\t{ \"session_id\":\"s\\u002e1_-\",\"n_cols\":2,\"n_rows\":3,\"roi_label\":\"b\",\"nframes_dropped\":0,"
        "\"host_time\":125e-2,\"timestamp_ns\":-9223372036854775807,\"frame_id\":9007199254740993 } \r\n",
        "{\"frame_id\": 9223372036854775807, \"timestamp_ns\": 9223372036854775807, \"host_time\": 0, "
        "\"nframes_dropped\": 1, \"roi_label\": \"a\", \"n_rows\": 1, \"n_cols\": 1, \"session_id\": \"s.1_-\"}"};
    const int64_t ids[] = {-5, INT64_C(9007199254740993), INT64_MAX}, dropped[] = {72000, 0, 1};
    const int64_t stamps[] = {INT64_MIN, INT64_MIN + 1, INT64_MAX}, shape[3][2] = {{1, 5}, {3, 2}, {1, 1}};
    const double host[] = {1.5, 1.25, 0};
    for (int i = 0; i < 3; i++)
        put_text(side_path, i == 0 ? "wb" : "ab", lines[i]);
    for (size_t width = 2; width <= 4; width += 2) {
        put_pixels(12 * width);
        const char *const paths[] = {stem_path, side_path, pixel_path};
        for (int p = 0; p < 3; p++) {
            toliman_ingest_options options = pair_options(0);
            options.pixel = width == 2 ? TOLIMAN_PIXEL_U16 : TOLIMAN_PIXEL_U32;
            toliman_ingest *ingest = NULL;
            assert_ok(toliman_ingest_create(paths[p], &options, &ingest));
            uint64_t offset = 0;
            for (int i = 0; i < 3; i++) {
                if (i == 2)
                    assert_warning(ingest, TOLIMAN_INGEST_REASON_CLOCKS_DIFFER, 3, "since line 1 timestamp_ns has");
                assert_frame(ingest, ids[i], i + 1, offset);
                assert_string_equal(frame.session, "s.1_-");
                assert_string_equal(frame.roi, i == 1 ? "b" : "a");
                assert_int_equal(frame.camera_ns, stamps[i]);
                assert_int_equal(event.stamp_ns, stamps[i]);
                assert_true(event.host_s == host[i]);
                assert_int_equal(event.has_key, 1);
                assert_int_equal(frame.dropped, dropped[i]);
                assert_int_equal(frame.rows, shape[i][0]);
                assert_int_equal(frame.cols, shape[i][1]);
                assert_int_equal(frame.pixel, options.pixel);
                assert_int_equal((uintptr_t)frame.pixels % 64, 0);
                assert_true(frame.sigma == 0 && frame.exposure_s == 0 && frame.intervals == NULL);
                assert_string_equal(event.file, side_path);
                offset += (uint64_t)(frame.rows * frame.cols) * width;
            }
            for (int i = 0; i < 3; i++)
                assert_nothing(ingest);
            const toliman_ingest_info info = info_of(ingest);
            assert_int_equal(info.lines, 3);
            assert_int_equal(info.frames, 3);
            assert_int_equal(info.warnings, 1);
            assert_int_equal(info.damaged, 0);
            assert_int_equal(info.bytes, 12 * width);
            assert_string_equal(info.side_file, side_path);
            assert_string_equal(info.pixel_file, pixel_path);
            toliman_ingest_destroy(ingest);
        }
    }
}

TEST_WITH_PAIR(test_stamps) {
    put_lines(3, 1);
    put_pixels(FRAME_BYTES);
    const struct {
        int32_t stamp;
        double exposure_s;
        int64_t camera_ns;
    } cases[] = {{0, 0, 3000000000},
                 {0, 0.5, 3250000000},
                 {TOLIMAN_FRAME_STAMP_START, 2.000000001, 4000000001}, // half a nanosecond away from 0
                 {TOLIMAN_FRAME_STAMP_MIDDLE, 0.5, 3000000000},
                 {TOLIMAN_FRAME_STAMP_END, 0.5, 2750000000},
                 {TOLIMAN_FRAME_STAMP_END, 1e9, 3000000000 - INT64_C(500000000000000000)}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_ingest_options options = pair_options(0);
        options.stamp = cases[i].stamp;
        options.exposure_s = cases[i].exposure_s;
        toliman_ingest *const ingest = open_with(options);
        assert_frame(ingest, 3, 1, 0);
        assert_int_equal(frame.camera_ns, cases[i].camera_ns);
        assert_int_equal(event.stamp_ns, 3000000000);
        assert_true(frame.exposure_s == cases[i].exposure_s);
        const toliman_ingest_info info = info_of(ingest);
        assert_int_equal(info.stamp, cases[i].stamp != 0 ? cases[i].stamp : TOLIMAN_FRAME_STAMP_START);
        assert_true(info.exposure_s == cases[i].exposure_s);
        toliman_ingest_destroy(ingest);
    }
    char text[512];
    put_text(side_path, "wb", side_line(text, 3, INT64_MAX - 9, 0, ROWS, COLS));
    toliman_ingest_options options = pair_options(0);
    options.exposure_s = 19e-9;
    toliman_ingest *ingest = open_with(options);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 1,
                  "timestamp_ns: the middle of the exposure exceeds 64 bits");
    toliman_ingest_destroy(ingest);
    options.stamp = TOLIMAN_FRAME_STAMP_END;
    ingest = open_with(options);
    assert_frame(ingest, 3, 1, 0);
    assert_int_equal(frame.camera_ns, INT64_MAX - 19);
    toliman_ingest_destroy(ingest);
}

#define KEY "\"session_id\": \"s\", \"roi_label\": \"r\", \"frame_id\": 7"
#define SHAPE "\"n_rows\": 3, \"n_cols\": 4"
#define REST "\"timestamp_ns\": 5, \"nframes_dropped\": 0, \"host_time\": 0"
#define LONG_NAME "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklm"

/* promise: damaged-lines-are-events */
TEST_WITH_PAIR(test_malformed_lines) {
    static const struct {
        const char *line, *text;
        int has_key;
    } cases[] = {
        {"[]", "not a JSON object", 0},
        {"5", "not a JSON object", 0},
        {"{", "malformed JSON: column 2", 0},
        {"{" KEY ", " SHAPE ", " REST "} x", "malformed JSON", 0},
        {"{" KEY ", " SHAPE ", " REST ", \"a\": 01}", "leading zero", 0},
        {"{" KEY ", " SHAPE ", " REST ", \"\xff\": 1}", "invalid UTF-8", 0},
        {"{" KEY ", " SHAPE ", \"timestamp_ns\": 5, \"nframes_dropped\": 0, \"host_time\": 1e999}", "range of double",
         0},
        {"{}", "session_id is missing", 0},
        {"{\"session_id\": \"s\", \"roi_label\": \"r\", " SHAPE ", " REST "}", "frame_id is missing", 0},
        {"{\"session_id\": \"s\", \"roi_label\": \"r\", \"frame_id\": 7.5}", "frame_id must be", 0},
        {"{\"session_id\": \"s\", \"roi_label\": \"r\", \"frame_id\": 9223372036854775808}", "frame_id must be", 0},
        {"{\"session_id\": \"s\", \"roi_label\": \"r\", \"frame_id\": \"7\"}", "frame_id must be", 0},
        {"{\"session_id\": \"../s\", \"roi_label\": \"r\", \"frame_id\": 7}", "session_id must be", 0},
        {"{\"session_id\": \".s\", \"roi_label\": \"r\", \"frame_id\": 7}", "session_id must be", 0},
        {"{\"session_id\": \"\", \"roi_label\": \"r\", \"frame_id\": 7}", "session_id must be", 0},
        {"{\"session_id\": \"" LONG_NAME "\"}", "session_id must be", 0},
        {"{\"session_id\": \"s\", \"roi_label\": 5, \"frame_id\": 7}", "roi_label must be", 0},
        {"{" KEY ", " SHAPE ", \"nframes_dropped\": 0, \"host_time\": 0}", "timestamp_ns is missing", 1},
        {"{" KEY ", \"timestamp_ns\": 1e3}", "timestamp_ns must be", 1},
        {"{" KEY ", \"timestamp_ns\": null}", "timestamp_ns must be", 1},
        {"{" KEY ", \"timestamp_ns\": 5}", "nframes_dropped is missing", 1},
        {"{" KEY ", \"timestamp_ns\": 5, \"nframes_dropped\": -1}", "nframes_dropped must be", 1},
        {"{" KEY ", " REST ", \"n_rows\": 0}", "n_rows must be", 1},
        {"{" KEY ", " REST ", \"n_rows\": 3, \"n_cols\": 65537}", "n_cols must be", 1},
        {"{" KEY ", " SHAPE ", \"timestamp_ns\": 5, \"nframes_dropped\": 0}", "host_time is missing", 1},
        {"{" KEY ", " SHAPE ", \"timestamp_ns\": 5, \"nframes_dropped\": 0, \"host_time\": true}", "host_time must be",
         1},
        {"{" KEY ", " SHAPE ", " REST ", \"n_rows\": 3}", "duplicate key \"n_rows\"", 1}};
    put_pixels(3 * FRAME_BYTES);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        put_text(side_path, "wb", side_line(text, 0, 0, 0, ROWS, COLS));
        put_text(side_path, "ab", cases[i].line);
        put_text(side_path, "ab", "\n");
        put_text(side_path, "ab", side_line(text, 2, 0, 0, ROWS, COLS));
        toliman_ingest *const ingest = open_pair(0);
        assert_frame(ingest, 0, 1, 0);
        assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 2, cases[i].text);
        assert_int_equal(event.has_key, cases[i].has_key);
        if (cases[i].has_key) {
            assert_string_equal(frame.session, "s");
            assert_string_equal(frame.roi, "r");
        } else {
            assert_null(frame.session);
        }
        assert_int_equal(frame.frame_id, cases[i].has_key ? 7 : 0);
        assert_null(frame.pixels);
        assert_int_equal(frame.rows, 0);
        assert_warning(ingest, TOLIMAN_INGEST_REASON_CLOCK_JUMP, 3, "as in the frame before");
        assert_frame(ingest, 2, 3, 2 * FRAME_BYTES);
        assert_end(ingest);
    }
}

/* Lines longer than 4096 bytes, also longer than what is read at once, are reported and skipped. */
/* promise: damaged-lines-are-events */
TEST_WITH_PAIR(test_long_lines) {
    static char spaces[200001];
    memset(spaces, ' ', sizeof spaces - 1);
    const size_t sizes[] = {4096, 4097, 65535, 65536, 65537, 200000};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (int last = 0; last < 2; last++) {
            char text[512];
            const char *const line = side_line(text, 1, 1000000000, 1, ROWS, COLS);
            remove(side_path);
            put_lines(0, 1);
            put_bytes(side_path, "ab", spaces, sizes[i] - (strlen(line) - 1));
            put_bytes(side_path, "ab", line, strlen(line) - (size_t)last); // the last line lacks its newline
            if (!last)
                put_lines(2, 1);
            remove(pixel_path);
            put_pixels((size_t)(3 - last) * FRAME_BYTES);
            toliman_ingest *const ingest = open_pair(0);
            assert_frame(ingest, 0, 1, 0);
            if (sizes[i] > 4096)
                assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 2, "longer than 4096 bytes");
            else
                assert_frame(ingest, 1, 2, FRAME_BYTES);
            if (!last)
                assert_frame(ingest, 2, 3, 2 * FRAME_BYTES);
            assert_end(ingest);
        }
}

/* Five lines; `odd` is malformed or of another shape. */
static void put_odd_lines(int odd, const char *line) {
    char text[512];
    remove(side_path);
    remove(pixel_path);
    for (int i = 0; i < 5; i++)
        put_text(side_path, "ab", i == odd ? line : side_line(text, i, i * INT64_C(1000000000), i, ROWS, COLS));
}

/* promise: damaged-lines-are-events */
TEST_WITH_PAIR(test_positions) {
    char text[512];
    /* The shapes of the lines fill the file: every position is known. */
    put_odd_lines(2, side_line(text, 2, 2000000000, 2, 1, 5));
    put_pixels(4 * FRAME_BYTES + 10);
    toliman_ingest *ingest = open_pair(0);
    for (int i = 0; i < 5; i++)
        assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES - (i > 2 ? FRAME_BYTES - 10 : 0));
    assert_end(ingest);
    /* Frames of the expected shape fill the file: the line is wrong. */
    put_pixels(5 * FRAME_BYTES);
    ingest = open_pair(0);
    assert_frames(ingest, 0, 2);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 3, "n_rows = 1, n_cols = 5: the frames in ");
    assert_int_equal(frame.frame_id, 2);
    assert_frames(ingest, 3, 5);
    assert_end(ingest);
    /* Neither: the positions after the odd line are unknown, and bytes are not reported as extra. */
    const char *const odd[] = {side_line(text, 2, 2000000000, 2, 1, 5), "{}\n"};
    for (int k = 0; k < 2; k++)
        for (int longer = 0; longer < 2; longer++) {
            put_odd_lines(2, odd[k]);
            put_pixels((longer ? 5 : 4) * FRAME_BYTES + 1);
            ingest = open_pair(0);
            assert_frames(ingest, 0, 2);
            if (k == 1)
                assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 3, "session_id is missing");
            else
                assert_damage(ingest, TOLIMAN_INGEST_REASON_PLACE_UNKNOWN, 3, "position of the frame in ");
            for (int i = 3; i < 5; i++) {
                assert_damage(ingest, TOLIMAN_INGEST_REASON_PLACE_UNKNOWN, i + 1, pixel_path);
                assert_int_equal(event.has_key, 1);
                assert_int_equal(frame.frame_id, i);
                assert_string_equal(frame.session, "day1");
            }
            assert_nothing(ingest);
            assert_int_equal(info_of(ingest).damaged, 3);
            toliman_ingest_destroy(ingest);
        }
    /* A malformed line counts as a frame of the expected shape, by default that of the first valid line. */
    put_odd_lines(0, "{}\n");
    put_pixels(5 * FRAME_BYTES);
    for (int k = 0; k < 2; k++) {
        toliman_ingest_options options = pair_options(0);
        options.rows *= k;
        options.cols *= k;
        ingest = open_with(options);
        assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 1, "session_id");
        assert_frames(ingest, 1, 5);
        assert_end(ingest);
    }
}

/* promise: damaged-lines-are-events */
TEST_WITH_PAIR(test_sizes) {
    put_lines(0, 3);
    put_pixels(2 * FRAME_BYTES + 5);
    toliman_ingest *ingest = open_pair(0);
    assert_frames(ingest, 0, 2);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_SHORT_FILE, 3, "ends before this frame");
    assert_int_equal(frame.frame_id, 2);
    assert_true(frame.camera_ns == event.stamp_ns && frame.camera_ns != 0 && frame.rows != 0 && frame.pixels == NULL);
    assert_string_equal(event.file, side_path);
    assert_end(ingest);

    put_pixels(3 * FRAME_BYTES + 3);
    ingest = open_pair(0);
    assert_frames(ingest, 0, 3);
    assert_warning(ingest, TOLIMAN_INGEST_REASON_EXTRA_BYTES, 0, "has 3 bytes more than the frames of ");
    assert_string_equal(event.file, pixel_path);
    assert_end(ingest);

    put_text(side_path, "wb", "");
    ingest = open_pair(0);
    assert_warning(ingest, TOLIMAN_INGEST_REASON_EXTRA_BYTES, 0, "has 75 bytes more");
    assert_end(ingest);
    put_text(pixel_path, "wb", "");
    ingest = open_pair(0);
    assert_end(ingest);
    put_lines(0, 1);
    ingest = open_pair(0);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_SHORT_FILE, 1, "ends before");
    toliman_ingest_destroy(ingest);
}

TEST_WITH_PAIR(test_other_pixel_type) {
    put_lines(0, 3);
    put_pixels(6 * FRAME_BYTES);
    toliman_ingest_options options = pair_options(0);
    toliman_ingest *ingest = open_with(options);
    for (int i = 0; i < 2; i++)
        assert_fails(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, "(--dtype u32le)?");
    toliman_ingest_destroy(ingest);
    options.pixel = TOLIMAN_PIXEL_U32;
    ingest = open_with(options);
    for (int i = 0; i < 3; i++)
        assert_frame(ingest, i, i + 1, (uint64_t)i * 2 * FRAME_BYTES);
    assert_end(ingest);
    remove(pixel_path);
    put_pixels(3 * FRAME_BYTES);
    ingest = open_with(options);
    assert_fails(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, "(--dtype u16le)?");
    toliman_ingest_destroy(ingest);
}

TEST_WITH_PAIR(test_too_many_lines) {
    put_pixels(1);
    for (int i = 0; i < 1044; i++)
        put_text(side_path, "ab", "x\n");
    toliman_ingest *ingest = open_pair(0);
    assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, side_path);
    toliman_ingest_destroy(ingest);
}

TEST_WITH_PAIR(test_range_of_ids) {
    put_lines(-3, 8);
    put_pixels(7 * FRAME_BYTES); // of the last frame none
    toliman_ingest_options options = pair_options(0);
    options.first_id = -1;
    options.end_id = 2;
    toliman_ingest *ingest = open_with(options);
    for (int i = -1; i < 2; i++)
        assert_frame(ingest, i, i + 4, (uint64_t)(i + 3) * FRAME_BYTES);
    assert_nothing(ingest);
    assert_int_equal(info_of(ingest).skipped, 5);
    assert_int_equal(info_of(ingest).frames, 3);
    toliman_ingest_destroy(ingest);
    options.first_id = INT64_MIN;
    options.end_id = -2;
    ingest = open_with(options);
    assert_frame(ingest, -3, 1, 0);
    assert_end(ingest);
}

/* Of malformed lines, and of those of a wrong shape, the id decides, too, if it is known. */
TEST_WITH_PAIR(test_range_of_damaged_ids) {
    char text[512];
    put_lines(0, 2);
    for (int id = 2; id < 6; id++) {
        char *const end = strrchr(side_line(text, id, id, id, ROWS, COLS), '}');
        (void)snprintf(end, sizeof text - (size_t)(end - text), ", \"n_rows\": 1}\n");
        put_text(side_path, "ab", text);
    }
    put_text(side_path, "ab", side_line(text, 6, 6, 6, ROWS, COLS + 1));
    put_text(side_path, "ab", "junk\n");
    for (size_t frames = 1; frames <= 8; frames += 7) { // in the file of pixels
        put_pixels(frames * FRAME_BYTES);
        toliman_ingest_options options = pair_options(0);
        options.first_id = 3;
        options.end_id = 5;
        toliman_ingest *const ingest = open_with(options);
        for (int id = 3; id < 5; id++) {
            assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, id + 1, "duplicate key \"n_rows\"");
            assert_int_equal(frame.frame_id, id);
        }
        assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 8, "malformed JSON");
        assert_nothing(ingest);
        assert_int_equal(info_of(ingest).skipped, 5);
        toliman_ingest_destroy(ingest);
    }
}

/* The memory of a frame and the text of an event stay valid during the next `buffers` - 1 calls, and are reused. */
/* promise: frames-outlive-their-buffers */
TEST_WITH_PAIR(test_buffers) {
    enum { COUNT = 12, BUFFERS = 4 };
    put_lines(0, COUNT);
    put_pixels(COUNT * FRAME_BYTES);
    toliman_ingest_options options = pair_options(0);
    options.buffers = BUFFERS;
    toliman_ingest *ingest = open_with(options);
    const unsigned char *pixels[COUNT];
    for (int i = 0; i < COUNT; i++) {
        assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
        pixels[i] = frame.pixels;
        for (int k = i; k >= 0 && k > i - BUFFERS; k--)
            for (int b = 0; b < FRAME_BYTES; b++)
                assert_int_equal(pixels[k][b], pixel_byte((uint64_t)(k * FRAME_BYTES + b)));
        if (i >= BUFFERS)
            assert_ptr_equal(pixels[i], pixels[i - BUFFERS]);
    }
    toliman_ingest_destroy(ingest);
    put_odd_lines(1, "{}\n");
    put_text(side_path, "ab", "[]\n");
    put_pixels(6 * FRAME_BYTES);
    options.buffers = 6;
    ingest = open_with(options);
    assert_frame(ingest, 0, 1, 0);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 2, "session_id is missing");
    const char *const text = event.text;
    assert_frames(ingest, 2, 5);
    assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 6, "not a JSON object");
    assert_string_equal(text, "session_id is missing");
    toliman_ingest_destroy(ingest);
}

/* Pixels come from the caller's allocator: one block per buffer, however many frames are read. */
static struct { int taken, held, most; } memory;

static void *take(size_t size, size_t alignment, void *user_data) {
    assert_ptr_equal(user_data, &memory);
    if (memory.taken == memory.most)
        return NULL;
    memory.taken++;
    memory.held++;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void give_back(void *block, size_t size, void *user_data) {
    (void)size, (void)user_data;
    memory.held--;
    free(block);
}

TEST_WITH_PAIR(test_allocator) {
    put_lines(0, 9);
    put_pixels(9 * FRAME_BYTES);
    const toliman_allocator allocator = {sizeof allocator, 0, take, give_back, &memory};
    toliman_ingest_options options = pair_options(0);
    options.allocator = &allocator;
    options.buffers = 2;
    memory.most = 2;
    toliman_ingest *ingest = open_with(options);
    assert_frames(ingest, 0, 9);
    assert_int_equal(memory.taken, 2);
    assert_int_equal(memory.held, 2);
    toliman_ingest_destroy(ingest);
    assert_int_equal(memory.held, 0);
    ingest = open_with(options);
    for (int i = 0; i < 2; i++)
        assert_int_equal(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_MEMORY);
    memory.most = 4;
    assert_frames(ingest, 0, 9);
    toliman_ingest_destroy(ingest);
    assert_int_equal(memory.held, 0);
    /* The memory is freed when the last frame is no longer valid, and allocated by the same allocator later. */
    memory.most = memory.taken + 2;
    options.flags = TOLIMAN_INGEST_GROWING;
    ingest = open_with(options);
    assert_frames(ingest, 0, 9);
    assert_nothing(ingest);
    assert_int_equal(memory.held, 2);
    assert_nothing(ingest);
    assert_int_equal(memory.held, 0);
    put_lines(9, 1);
    put_pixels(10 * FRAME_BYTES);
    assert_int_equal(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_MEMORY);
    memory.most++;
    assert_frame(ingest, 9, 10, 9 * FRAME_BYTES);
    assert_int_equal(memory.held, 1);
    toliman_ingest_destroy(ingest);
    assert_int_equal(memory.held, 0);
}

/* Other ranges of numbers: bind/test_options. */
TEST_WITH_PAIR(test_options) {
    put_lines(0, 1);
    put_pixels(FRAME_BYTES);
    toliman_ingest *ingest = NULL;
    const struct {
        toliman_ingest_options options; /* members that are 0 are those of pair_options */
        const char *field;
    } cases[] = {{{.first_id = 5}, "options->end_id"},
                 {{.end_id = -5}, "options->end_id"},
                 {{.flags = 2}, "options->flags"},
                 {{.rows = -1}, "options->rows"},
                 {{.struct_size = 8}, "options->struct_size"},
                 {{.pixel = TOLIMAN_PIXEL_F64}, "options->pixel"},
                 {{.exposure_s = -1}, "options->exposure_s"}};
    toliman_ingest_options options = pair_options(0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const toliman_ingest_options *const c = &cases[i].options;
        toliman_ingest_options wrong = *c;
        wrong.struct_size = c->struct_size != 0 ? c->struct_size : options.struct_size;
        wrong.pixel = c->pixel != 0 ? c->pixel : options.pixel;
        wrong.rows = c->rows != 0 ? c->rows : ROWS;
        wrong.cols = c->cols != 0 ? c->cols : COLS;
        assert_invalid(toliman_ingest_create(stem_path, &wrong, &ingest), cases[i].field);
        assert_null(ingest);
    }
    options.rows = 0; /* both or none */
    assert_invalid(toliman_ingest_create(stem_path, &options, &ingest), "options->rows");
    options = pair_options(0);
    options.cols = 0;
    assert_invalid(toliman_ingest_create(stem_path, &options, &ingest), "options->cols");
    options = pair_options(0);
    assert_invalid(toliman_ingest_create(NULL, &options, &ingest), "path");
    assert_invalid(toliman_ingest_create(stem_path, NULL, &ingest), "options");
    assert_invalid(toliman_ingest_create(stem_path, &options, NULL), "out");
    ingest = open_with(options);
    assert_invalid(toliman_ingest_next(ingest, NULL, &event), "frame");
    assert_invalid(toliman_ingest_next(ingest, &frame, NULL), "event");
    frame.struct_size = 4; /* refused before the event is taken */
    assert_invalid(toliman_ingest_next(ingest, &frame, &event), "frame->struct_size");
    assert_frame(ingest, 0, 1, 0);
    toliman_ingest_destroy(ingest);
    assert_string_equal(toliman_constant_name(TOLIMAN_INGEST_REASON_PLACE_UNKNOWN), "place unknown");
    assert_string_equal(toliman_constant_name(TOLIMAN_INGEST_REASON_EXTRA_BYTES), "extra bytes");
    assert_string_equal(toliman_constant_name(TOLIMAN_INGEST_REASON_OVERLAP), "overlap");
    assert_string_equal(toliman_constant_name(TOLIMAN_INGEST_REASON_UNKNOWN_KEY), "unknown key");
    assert_string_equal(toliman_constant_name(15), "?");
}

TEST_WITH_PAIR(test_files) {
    const toliman_ingest_options options = pair_options(0);
    toliman_ingest *ingest = NULL;
    assert_refused(toliman_ingest_create(pixel_path, &options, &ingest), TOLIMAN_E_NOT_FOUND, side_path);
    put_lines(0, 1);
    assert_refused(toliman_ingest_create(side_path, &options, &ingest), TOLIMAN_E_NOT_FOUND, pixel_path);
    assert_int_equal(mkfifo(pixel_path, 0600), 0); /* is not waited for */
    assert_refused(toliman_ingest_create(stem_path, &options, &ingest), TOLIMAN_E_NOT_FOUND, pixel_path);
    remove(pixel_path);
    assert_int_equal(mkdir(pixel_path, 0700), 0);
    assert_refused(toliman_ingest_create(stem_path, &options, &ingest), TOLIMAN_E_NOT_FOUND, pixel_path);
    rmdir(pixel_path);
    put_pixels(FRAME_BYTES);
    assert_ok(toliman_ingest_create(stem_path, &options, &ingest));
    remove(pixel_path);
    assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_NOT_FOUND, pixel_path);
    put_pixels(FRAME_BYTES);
    assert_frame(ingest, 0, 1, 0);
    toliman_ingest_destroy(ingest);
    assert_null(strstr(toliman_last_error(), "destroyed"));
    toliman_ingest_destroy(NULL);
}

RUN_TESTS(NULL, NULL)
