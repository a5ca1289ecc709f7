/* Tests the reader of pairs that grow: byte by byte, in any order of both files, replaced and truncated files, and
 * random growth against a reference that starts again at every call. */
#include <dirent.h>
#include <math.h>
#include <stdbool.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>

#include "pair_files.h"
#include "uniform.h"

static void finish(toliman_ingest *ingest) {
    assert_ok(toliman_ingest_finish(ingest));
}

static void start_files(void) {
    put_text(side_path, "wb", "");
    put_text(pixel_path, "wb", "");
}

static int open_files(void) {
    int count = 0;
    DIR *const folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder) != NULL)
        count++;
    closedir(folder);
    return count;
}

/* A frame is reported as soon as its line and all its pixels are there, and not before. */
/* promise: growing-pairs-lose-no-frame */
TEST_WITH_PAIR(test_byte_by_byte) {
    char text[512];
    const int others = open_files();
    for (int pixels_first = 0; pixels_first < 2; pixels_first++) {
        start_files();
        toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
        assert_nothing(ingest);
        for (int i = 0; i < 3; i++) {
            const char *const line = side_line(text, i, i * INT64_C(1000000000), i, ROWS, COLS);
            for (int half = 0; half < 2; half++) {
                const size_t bytes = (half == 0) == (pixels_first == 1) ? FRAME_BYTES : strlen(line);
                for (size_t b = 0; b < bytes; b++) {
                    if (bytes == FRAME_BYTES)
                        put_pixels((size_t)i * FRAME_BYTES + b + 1);
                    else
                        put_bytes(side_path, "ab", line + b, 1);
                    if (half == 0 || b + 1 < bytes)
                        assert_nothing(ingest);
                }
            }
            assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
            assert_nothing(ingest);
            assert_int_equal(open_files(), others);
        }
        assert_int_equal(info_of(ingest).lines, 3);
        assert_int_equal(info_of(ingest).bytes, 3 * FRAME_BYTES);
        toliman_ingest_destroy(ingest);
    }
}

/* Every combination of what is left over, with the calls before finish. */
TEST_WITH_PAIR(test_finish) {
    for (int calls = 0; calls < 4; calls++) // that return NOTHING before finish
        for (int later = 0; later < 3; later++) {
            start_files();
            put_lines(0, 3);
            put_text(side_path, "ab", "{");
            put_pixels(FRAME_BYTES + 1);
            toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
            if (calls > 0)
                assert_frame(ingest, 0, 1, 0);
            for (int i = 0; i < calls; i++)
                assert_nothing(ingest);
            if (later == 1)
                put_pixels(FRAME_BYTES + 2);
            if (later == 2)
                put_text(side_path, "ab", "}");
            finish(ingest);
            finish(ingest);
            if (calls >= 2 && later == 0)
                for (int i = 1; i < 3; i++) // the line without newline is not reported
                    assert_damage(ingest, TOLIMAN_INGEST_REASON_SHORT_FILE, i + 1, "ends before this frame");
            put_pixels(3 * FRAME_BYTES);
            for (int i = 0; calls == 0 && i < 3; i++) // the first call always examines the files
                assert_frame(ingest, i, i + 1, (uint64_t)i * FRAME_BYTES);
            for (int i = 0; i < 3; i++)
                assert_nothing(ingest);
            toliman_ingest_destroy(ingest);
        }
    start_files();
    put_lines(0, 1);
    put_pixels(FRAME_BYTES + 1);
    toliman_ingest *ingest = open_pair(TOLIMAN_INGEST_GROWING);
    assert_frame(ingest, 0, 1, 0);
    assert_nothing(ingest);
    assert_nothing(ingest);
    finish(ingest);
    assert_warning(ingest, TOLIMAN_INGEST_REASON_EXTRA_BYTES, 0, "has 1 bytes more");
    assert_end(ingest);
    /* What was found before is reported after finish. */
    start_files();
    put_lines(0, 3);
    put_pixels(3 * FRAME_BYTES);
    ingest = open_pair(TOLIMAN_INGEST_GROWING);
    assert_frame(ingest, 0, 1, 0);
    finish(ingest);
    put_lines(3, 1);
    put_pixels(4 * FRAME_BYTES);
    assert_frames(ingest, 1, 3);
    assert_end(ingest);
    /* Complete pairs need no finish. */
    ingest = open_pair(0);
    finish(ingest);
    assert_frames(ingest, 0, 4);
    assert_end(ingest);
}

static void touch(const char *path, time_t seconds) {
    const struct timeval times[2] = {{seconds, 0}, {seconds, 0}};
    assert_int_equal(utimes(path, times), 0);
}

/* A file that another one replaces, by rename, truncation or overwriting: the first call waits for the second file. */
/* promise: replaced-pairs-start-again */
TEST_WITH_PAIR(test_replaced) {
    for (int way = 0; way < 3; way++) {
        char text[512], moved[400];
        start_files();
        put_lines(0, 2);
        put_pixels((way == 0 ? 3 : 2) * FRAME_BYTES);
        touch(side_path, 1000);
        toliman_ingest_options options = pair_options(TOLIMAN_INGEST_GROWING);
        options.buffers = 16;
        toliman_ingest *const ingest = open_with(options);
        assert_frame(ingest, 0, 1, 0);
        const char *const session = frame.session;
        assert_frame(ingest, 1, 2, FRAME_BYTES);
        assert_nothing(ingest);
        const char *const path = way == 0 ? side_path : moved;
        snprintf(moved, sizeof moved, "%s/new", pair_folder);
        put_text(path, "wb", side_line(text, 7, 5, 5, ROWS, COLS)); // truncates it if way is 0
        if (way > 0) {
            put_text(path, "ab", side_line(text, 8, 6, 6, ROWS, COLS));
            if (way == 2) { // the same inode and size
                struct stat old;
                assert_int_equal(stat(side_path, &old), 0);
                FILE *const file = fopen(side_path, "r+b");
                assert_non_null(file);
                fputs(side_line(text, 7, 1000000000, 5, ROWS, COLS), file);
                assert_int_equal(fclose(file), 0);
                struct stat now;
                assert_int_equal(stat(side_path, &now), 0);
                assert_true(now.st_size == old.st_size && now.st_ino == old.st_ino);
                remove(moved);
            } else {
                assert_int_equal(rename(moved, side_path), 0);
            }
        }
        assert_nothing(ingest);
        if (way == 2) { // its first line is longer, so that the second one begins with the rest of the old one
            assert_frame(ingest, 7, 1, 0);
            assert_damage(ingest, TOLIMAN_INGEST_REASON_BAD_LINE, 2, "");
        } else {
            assert_frame(ingest, 7, 1, 0);
            if (way == 1)
                assert_frame(ingest, 8, 2, FRAME_BYTES);
        }
        assert_nothing(ingest);
        assert_string_equal(session, "day1");
        toliman_ingest_destroy(ingest);
    }
}

/* A new file of pixels of the same size. */
/* promise: replaced-pairs-start-again */
TEST_WITH_PAIR(test_replaced_pixels) {
    start_files();
    put_lines(0, 2);
    put_pixels(2 * FRAME_BYTES);
    toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
    assert_frame(ingest, 0, 1, 0);
    assert_frame(ingest, 1, 2, FRAME_BYTES);
    assert_nothing(ingest);
    char kept[400];
    snprintf(kept, sizeof kept, "%s/kept", pair_folder);
    assert_int_equal(rename(pixel_path, kept), 0);
    put_pixels(2 * FRAME_BYTES);
    assert_nothing(ingest); // was replaced
    assert_frame(ingest, 0, 1, 0);
    assert_frame(ingest, 1, 2, FRAME_BYTES);
    toliman_ingest_destroy(ingest);
}

/* The files disappear and come back; the file of pixels is truncated while frames are read. */
/* promise: replaced-pairs-start-again */
TEST_WITH_PAIR(test_unreadable) {
    start_files();
    put_lines(0, 3);
    put_pixels(3 * FRAME_BYTES);
    toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
    assert_frame(ingest, 0, 1, 0);
    assert_int_equal(truncate(pixel_path, FRAME_BYTES + 1), 0);
    for (int i = 0; i < 2; i++) {
        if (i == 0)
            assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_NOT_FOUND, pixel_path);
        else
            assert_nothing(ingest); // was replaced
    }
    assert_frame(ingest, 0, 1, 0);
    assert_nothing(ingest);
    char moved[400];
    snprintf(moved, sizeof moved, "%s/moved", pair_folder);
    assert_int_equal(rename(side_path, moved), 0);
    for (int i = 0; i < 2; i++)
        assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_NOT_FOUND, side_path);
    assert_int_equal(rename(moved, side_path), 0);
    assert_nothing(ingest);
    put_pixels(2 * FRAME_BYTES);
    assert_frame(ingest, 1, 2, FRAME_BYTES);
    assert_nothing(ingest);
    assert_int_equal(rename(side_path, moved), 0);
    finish(ingest);
    assert_nothing(ingest); // files that have disappeared have changed
    toliman_ingest_destroy(ingest);
}

/* A pair that grows through the size of the other pixel type, and one that has it. */
TEST_WITH_PAIR(test_other_pixel_type) {
    for (int grows = 0; grows < 2; grows++) {
        start_files();
        put_lines(0, 1);
        put_pixels(2 * FRAME_BYTES);
        toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
        assert_nothing(ingest);
        if (grows) {
            put_lines(1, 1);
            assert_frames(ingest, 0, 2);
            assert_nothing(ingest);
            put_pixels(4 * FRAME_BYTES); // no longer a question
            assert_nothing(ingest);
            assert_nothing(ingest);
            finish(ingest);
            assert_warning(ingest, TOLIMAN_INGEST_REASON_EXTRA_BYTES, 0, "has 48 bytes more");
        } else {
            for (int i = 0; i < 2; i++)
                assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, pixel_path);
            finish(ingest);
            assert_nothing(ingest);
        }
        toliman_ingest_destroy(ingest);
    }
}

/* Random growth. The reference knows the lines and reads all of them again at every call. */

enum { LINES = 24, EVENTS = 4 * LINES };

typedef struct {
    bool bad;
    int rows, cols;
    int64_t id, stamp_ns;
    double host_s;
    size_t end; /* in the side file */
} model_line;

typedef struct {
    model_line lines[LINES];
    size_t count, given, side_size, pixel_size;
    bool doubtful, settled, drifted;
} model;

typedef struct {
    int32_t event, reason;
    int64_t line;
    uint64_t offset;
} outcome;

static size_t bytes_of(const model_line *line) {
    return line->bad ? FRAME_BYTES : (size_t)(2 * line->rows * line->cols);
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_step(const model_line *lines, size_t count) {
    double steps[LINES];
    size_t known = 0;
    for (size_t i = 1; i < count; i++)
        if (!lines[i].bad && !lines[i - 1].bad)
            steps[known++] = fabs((double)(lines[i].stamp_ns - lines[i - 1].stamp_ns));
    qsort(steps, known, sizeof *steps, compare_doubles);
    return known > 0 ? steps[known / 2] : 0;
}

/* The line before one that was valid and reported as a frame; the line itself if there is none. */
static size_t good_before(const bool *good, size_t line) {
    for (size_t i = line; i-- > 0;)
        if (good[i])
            return i;
    return line;
}

static bool stands(const model_line *lines, size_t before, size_t line) {
    return before != line && lines[before].stamp_ns == lines[line].stamp_ns;
}

static int32_t warning_at(model *m, const bool *good, size_t line, double usual) {
    const size_t before = good_before(good, line);
    if (before == line)
        return TOLIMAN_INGEST_REASON_NONE;
    const double step = (double)(m->lines[line].stamp_ns - m->lines[before].stamp_ns);
    if (step < 0 || (stands(m->lines, before, line) && !stands(m->lines, good_before(good, before), before)) ||
        (usual > 0 && step > 1000 * usual * (double)(line - before)))
        return TOLIMAN_INGEST_REASON_CLOCK_JUMP;
    size_t first = 0;
    while (!good[first])
        first++;
    const double camera = (double)(m->lines[line].stamp_ns - m->lines[first].stamp_ns) / 1e9;
    const double host = m->lines[line].host_s - m->lines[first].host_s;
    if (m->drifted || !(fabs(camera - host) > 1 + 0.01 * fmax(fabs(camera), fabs(host))))
        return TOLIMAN_INGEST_REASON_NONE;
    m->drifted = true;
    return TOLIMAN_INGEST_REASON_CLOCKS_DIFFER;
}

/* What an examination of the first `side` and `pixels` bytes must report. */
static size_t expected(model *m, bool *good, size_t side, size_t pixels, outcome *out) {
    const bool same = side == m->side_size && pixels == m->pixel_size;
    if (same && m->settled)
        return 0;
    m->side_size = side;
    m->pixel_size = pixels;
    size_t count = 0, own = 0, found = 0;
    while (count < m->count && m->lines[count].end <= side)
        own += bytes_of(&m->lines[count++]);
    if (m->given == 0 && own > 0 && 2 * own == pixels) {
        const bool certain = m->doubtful;
        m->doubtful = true;
        m->settled = false;
        if (certain)
            out[found++] = (outcome){.event = -1};
        return found;
    }
    m->doubtful = false;
    m->settled = true;
    const double usual = median_step(m->lines, count);
    const bool exact = own == pixels, uniform = !exact && count * FRAME_BYTES == pixels;
    size_t offset = 0;
    for (size_t i = 0; i < count; i++) {
        const model_line *const line = &m->lines[i];
        const bool odd = line->bad || bytes_of(line) != bytes_of(&m->lines[0]);
        if (!exact && !uniform && (odd || offset + bytes_of(line) > pixels))
            break;
        const bool wrong = line->bad || (uniform && bytes_of(line) != FRAME_BYTES);
        if (i >= m->given) {
            good[i] = !wrong;
            const int32_t warning = wrong ? TOLIMAN_INGEST_REASON_NONE : warning_at(m, good, i, usual);
            if (warning != TOLIMAN_INGEST_REASON_NONE)
                out[found++] = (outcome){TOLIMAN_INGEST_EVENT_WARNING, warning, (int64_t)i + 1, 0};
            out[found++] =
                wrong ? (outcome){TOLIMAN_INGEST_EVENT_DAMAGE, TOLIMAN_INGEST_REASON_BAD_LINE, (int64_t)i + 1, 0}
                      : (outcome){TOLIMAN_INGEST_EVENT_FRAME, TOLIMAN_INGEST_REASON_NONE, (int64_t)i + 1, offset};
            m->given = i + 1;
        }
        offset += uniform ? FRAME_BYTES : bytes_of(line);
    }
    return found;
}

static size_t pick(uint64_t *random, size_t count) {
    return (size_t)(uniform(random) * (double)count);
}

/* Draws lines, of which some are malformed or have other shapes or times. Returns the text of the side file. */
static char *draw(model *m, uint64_t *random, size_t *pixels) {
    char *const text = calloc(LINES, 512);
    assert_non_null(text);
    *m = (model){.count = 1 + pick(random, LINES)};
    const size_t odd = pick(random, 4) == 0 ? 1 + pick(random, 12) : 0;
    const bool shifted = pick(random, 4) == 0;
    int64_t stamp = 0;
    *pixels = 0;
    for (size_t i = 0; i < m->count; i++) {
        char line[512];
        model_line *const made = &m->lines[i];
        *made = (model_line){.rows = ROWS, .cols = COLS, .id = (int64_t)i, .stamp_ns = stamp};
        made->host_s = (double)stamp / 1e9 * (pick(random, 20) == 0 ? 1.02 : 1);
        if (odd > 0 && pick(random, odd) == 0) {
            made->bad = pick(random, 2) == 0;
            made->rows = made->bad ? ROWS : 1 + (int)pick(random, 5);
        }
        strcat(text,
               made->bad ? "[]\n" : side_line(line, made->id, made->stamp_ns, made->host_s, made->rows, made->cols));
        made->end = strlen(text);
        *pixels += bytes_of(made);
        const double steps[] = {0, -2, 1500};
        stamp += (int64_t)(1e9 * (pick(random, 10) == 0 ? steps[pick(random, 3)] : 1));
    }
    if (shifted)
        *pixels += pick(random, 2) == 0 ? FRAME_BYTES : 7;
    return text;
}

static void compare(toliman_ingest *ingest, const outcome *wanted, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (wanted[i].event == -1)
            assert_refused(toliman_ingest_next(ingest, &frame, &event), TOLIMAN_E_FORMAT, pixel_path);
        else if (wanted[i].event == TOLIMAN_INGEST_EVENT_FRAME)
            assert_frame(ingest, wanted[i].line - 1, wanted[i].line, wanted[i].offset);
        else
            assert_event(ingest, wanted[i].event, wanted[i].reason, wanted[i].line, "");
    if (count == 0 || wanted[count - 1].event != -1)
        assert_nothing(ingest);
}

/* The complete files at once, with what is left over at the end. */
static void compare_complete(model m, size_t side, size_t pixels) {
    bool good[LINES] = {false};
    outcome wanted[EVENTS];
    m.given = m.side_size = m.pixel_size = 0;
    m.drifted = m.settled = false;
    m.doubtful = true;
    size_t count = expected(&m, good, side, pixels, wanted);
    const bool is_refused = count > 0 && wanted[0].event == -1;
    size_t own = 0;
    for (size_t i = 0; i < m.count; i++)
        own += bytes_of(&m.lines[i]);
    for (size_t i = m.given; i < m.count && !is_refused; i++) {
        const model_line *const first = &m.lines[m.given];
        const bool odd = first->bad || bytes_of(first) != bytes_of(&m.lines[0]);
        const int32_t reason = m.lines[i].bad ? TOLIMAN_INGEST_REASON_BAD_LINE
                               : odd          ? TOLIMAN_INGEST_REASON_PLACE_UNKNOWN
                                              : TOLIMAN_INGEST_REASON_SHORT_FILE;
        wanted[count++] = (outcome){TOLIMAN_INGEST_EVENT_DAMAGE, reason, (int64_t)i + 1, 0};
    }
    if (!is_refused && m.given == m.count && pixels > own && pixels != m.count * FRAME_BYTES)
        wanted[count++] = (outcome){TOLIMAN_INGEST_EVENT_WARNING, TOLIMAN_INGEST_REASON_EXTRA_BYTES, 0, 0};
    toliman_ingest *const ingest = open_pair(0);
    compare(ingest, wanted, count);
    toliman_ingest_destroy(ingest);
}

/* promise: growing-pairs-lose-no-frame */
TEST_WITH_PAIR(test_random_growth) {
    uint64_t random = 20280301;
    int64_t frames = 0, damaged = 0, warnings = 0;
    for (int round = 0; round < 300; round++) {
        model m;
        size_t pixels, side = 0, drawn = 0;
        char *const text = draw(&m, &random, &pixels);
        bool good[LINES] = {false};
        outcome wanted[EVENTS];
        start_files();
        toliman_ingest *const ingest = open_pair(TOLIMAN_INGEST_GROWING);
        const size_t whole = strlen(text);
        while (side < whole || drawn < pixels) {
            const size_t most = pick(&random, 2) == 0 ? 60 : 600; // a part of a line, or several
            const size_t more = pick(&random, most), more_pixels = pick(&random, most / 8);
            const size_t grown = side + more < whole ? side + more : whole;
            put_bytes(side_path, "ab", text + side, grown - side);
            side = grown;
            drawn = drawn + more_pixels < pixels ? drawn + more_pixels : pixels;
            put_pixels(drawn);
            compare(ingest, wanted, expected(&m, good, side, drawn, wanted));
        }
        compare(ingest, wanted, expected(&m, good, side, drawn, wanted));
        const toliman_ingest_info info = info_of(ingest);
        assert_int_equal(info.lines, m.count);
        assert_int_equal(info.frames + info.damaged, m.given);
        frames += info.frames;
        damaged += info.damaged;
        warnings += info.warnings;
        toliman_ingest_destroy(ingest), free(text);
        compare_complete(m, side, drawn);
    }
    assert_in_range(frames, 1500, 100000);
    assert_in_range(damaged, 20, 10000);
    assert_in_range(warnings, 100, 10000);
}

/* Processor time of a pair that grows line by line: that of a line must not depend on the length of the file. */
static double seconds_per_line(int count) {
    char text[512];
    start_files();
    toliman_ingest_options options = pair_options(TOLIMAN_INGEST_GROWING);
    options.rows = options.cols = 1;
    toliman_ingest *const ingest = open_with(options);
    FILE *const side = fopen(side_path, "ab"), *const pixels = fopen(pixel_path, "ab");
    assert_true(side != NULL && pixels != NULL);
    const clock_t start = clock();
    for (int i = 0; i < count; i++) {
        fputs(side_line(text, i, i * INT64_C(1000000) + i % 7, i / 1e3, 1, 1), side);
        fwrite(&i, 2, 1, pixels);
        fflush(side);
        fflush(pixels);
        assert_int_equal(next_event(ingest), TOLIMAN_INGEST_EVENT_FRAME);
        assert_nothing(ingest);
    }
    const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    fclose(side);
    fclose(pixels);
    assert_int_equal(info_of(ingest).frames, count);
    toliman_ingest_destroy(ingest);
    return seconds / count;
}

TEST_WITH_PAIR(test_linear_time) {
    const char *const lines = getenv("TOLIMAN_INGEST_LINES");
    const int many = lines != NULL ? atoi(lines) : 50000;
    const double few = seconds_per_line(5000), last = seconds_per_line(many);
    print_message("%d lines: %.1f us per line; 5000 lines: %.1f us\n", many, 1e6 * last, 1e6 * few);
    assert_true(last < 3 * few);
}

RUN_TESTS(NULL, NULL)
