/* Tests a tracker's files with correct checksums and impossible content, options that contradict the folder's, and
 * empty requests. Offsets as in tools/docs/formats.md. */
#include "track_folder.h"

static void seal(const char *path, off_t at) {
    unsigned char bytes[65536];
    read_at(path, 0, bytes, (size_t)at);
    const uint32_t crc = crc32(0, bytes, (size_t)at);
    write_at(path, at, &crc, sizeof crc);
}

static void assert_not_made(const toliman_track_options *options, toliman_status code, const char *field) {
    toliman_track *none = NULL;
    assert_refused(toliman_track_create(options, &none), code, field);
    assert_null(none);
}

/* Frames of 16x16, cropped to 8x8 from row 4, column 4. */
static toliman_track_options cropped_options(void) {
    toliman_track_options options = small_options(folder);
    options.frames.rows = options.frames.cols = 16;
    options.frames.crop_row = options.frames.crop_col = 4;
    options.frames.image_rows = options.frames.image_cols = 4;
    return options;
}

TEST_IN_FOLDER(other_options_are_refused) {
    const toliman_track_options options = cropped_options();
    toliman_track_destroy(make_track(&options));
#define REFUSED(member, value)                                                                                         \
    do {                                                                                                               \
        toliman_track_options other = options;                                                                         \
        other.member = (value);                                                                                        \
        assert_not_made(&other, TOLIMAN_E_MISMATCH, ledger);                                                           \
    } while (0)
    REFUSED(frames.rows, 17);
    REFUSED(frames.cols, 17);
    REFUSED(frames.crop_row, 3);
    REFUSED(frames.crop_col, 3);
    REFUSED(frames.image_rows, 3);
    REFUSED(frames.image_cols, 3);
    REFUSED(frames.bin, 2);
    REFUSED(frames.bit_depth, 13);
    REFUSED(frames.zero_run_bytes, 7);
    REFUSED(estimator.sigma, 0.5);
    REFUSED(limits.value, 4);
    REFUSED(estimator.id, 78);
}

/* promise: impossible-records-are-refused */
TEST_IN_FOLDER(impossible_terms_are_refused) {
    enum { TERMS = 16 };
    const toliman_track_options options = cropped_options();
    toliman_track_destroy(make_track(&options));
    toliman_track_options known = {.struct_size = sizeof known};
    const struct {
        int place;
        uint64_t value;
        const char *field;
    } bad[] = {
        {0, 0, "rows"},
        {1, 0, "rows"},
        {4, 0, "rows"},
        {5, 0, "rows"},
        {6, 0, "rows"},
        {4, 17, "crop_row"},
        {5, 17, "crop_row"},
        {2, 13, "crop_row"},
        {3, 13, "crop_row"},
        {7, 33, "bit_depth"},
        {9, 0x7ff8000000000000u, "sigma"},
        {9, 0x7f00000000000000u, "sigma"},
        {10, 0x7ff8000000000000u, "value_limit"},
        {10, 0x7f00000000000000u, "value_limit"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const off_t at = TERMS + 8 * bad[i].place;
        const uint64_t good = number_at(ledger, at, 8);
        write_at(ledger, at, &bad[i].value, 8);
        seal(ledger, HEADER - 4);
        assert_not_made(&options, TOLIMAN_E_FORMAT, bad[i].field);
        assert_refused(toliman_track_load_options(folder, &known), TOLIMAN_E_FORMAT, bad[i].field);
        write_at(ledger, at, &good, 8);
        seal(ledger, HEADER - 4);
    }
    toliman_track_destroy(make_track(&options));
}

/* Appends a record to the ledger, whose last checksum is `chain`; returns the new one. */
static uint32_t add_line(unsigned char *line, off_t number, uint32_t chain) {
    chain = crc32(chain, line, LINE - 4);
    memcpy(line + LINE - 4, &chain, 4);
    write_at(ledger, HEADER + number * LINE, line, LINE);
    return chain;
}

/* promise: impossible-records-are-refused */
TEST_IN_FOLDER(contradictory_records_are_refused) {
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_number(track, 1);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    unlink(checkpoint);
    unsigned char first[LINE], line[LINE];
    read_at(ledger, HEADER, first, LINE);
    uint32_t chain;
    memcpy(&chain, first + LINE - 4, 4);
    memcpy(line, first, LINE);
    add_line(line, 1, chain);
    assert_not_made(&options, TOLIMAN_E_FORMAT, ledger);
    line[52] = 3;
    chain = add_line(line, 1, chain);
    toliman_track_destroy(make_track(&options)); /* a single quarantine record is valid */
    unlink(checkpoint);
    add_line(line, 2, chain);
    assert_not_made(&options, TOLIMAN_E_FORMAT, ledger);

    /* Marks of a merge whose counts are negative or too large. */
    const int64_t counts[][2] = {{-1, 0}, {0, -1}, {0, ((int64_t)1 << 60) + 1}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        const double sigma = SIGMA;
        memset(line, 0, LINE);
        memcpy(line + 12, counts[i], 16);
        memcpy(line + 44, &sigma, 8);
        line[52] = 5;
        memcpy(&chain, first + LINE - 4, 4);
        add_line(line, 1, chain);
        assert_int_equal(truncate(ledger, HEADER + 2 * LINE), 0);
        assert_not_made(&options, TOLIMAN_E_FORMAT, ledger);
    }
    const off_t most = HEADER + (((off_t)1 << 29) + 1) * LINE;
    if (truncate(ledger, most) == 0) /* as a sparse file */
        assert_not_made(&options, TOLIMAN_E_FORMAT, ledger);
}

/* Records damaged on disk while the tracker is open are refused; the others can be read. */
TEST_IN_FOLDER(damage_while_open) {
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_range(track, 1, 6);
    assert_ok(toliman_track_commit(track));
    flip_byte(ledger, HEADER + 3 * LINE + 20);
    toliman_track_record lines[6] = {{.struct_size = sizeof *lines}};
    size_t done = 9;
    assert_fails(toliman_track_get_records(track, 0, 6, lines, &done), TOLIMAN_E_FORMAT, "record 3 is damaged");
    assert_ok(toliman_track_get_records(track, 0, 3, lines, &done));
    assert_int_equal(done, 3);
    small_frame frame;
    make_frame(&frame, 4);
    frame.pixels[0]++;
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    assert_refused(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_FORMAT, ledger);
    toliman_track_destroy(track);
}

/* An impossible checkpoint or setup is ignored. */
/* promise: lost-checkpoints-cost-time-only */
TEST_IN_FOLDER(impossible_checkpoints_and_setups) {
    enum { POINTS = 8, REPEATS = 24 };
    toliman_track_options options = filled_folder();
    options.frames.stamp = TOLIMAN_FRAME_STAMP_MIDDLE;
    const int64_t camera[2] = {0, 0}, repeats[] = {-1, ((int64_t)1 << 60) + 1};
    for (size_t i = 0; i < 3; i++) {
        if (i < 2) {
            write_at(checkpoint, REPEATS, &repeats[i], 8);
            seal(checkpoint, size_of(checkpoint) - 4);
        } else {
            assert_int_equal(truncate(checkpoint, 10), 0);
        }
        toliman_track *const track = make_track(&options);
        assert_filled(track, &options);
        toliman_track_destroy(track);
    }
    for (int longer = 0; longer < 2; longer++) {
        const off_t size = size_of(setup);
        const uint32_t points = 1u << 30;
        if (longer) {
            assert_int_equal(truncate(setup, size + 8), 0);
            seal(setup, size + 4);
        } else {
            write_at(setup, POINTS, &points, sizeof points);
            seal(setup, size - 4);
        }
        options.clock.count = 0;
        assert_not_made(&options, TOLIMAN_E_ARGUMENT, "options->clock.pairs");
        options.clock.pairs = camera;
        options.clock.count = 1;
        toliman_track_destroy(make_track(&options)); /* rewritten */
    }
}

/* Lines of names that are truncated, invalid, with a wrong digest or of no frame are ignored. */
/* promise: lost-names-cost-no-frame */
TEST_IN_FOLDER(invalid_names) {
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_number(track, 1);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    char path[300], text[400];
    snprintf(path, sizeof path, "%s/streams.txt", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_non_null(fgets(text, sizeof text, file));
    fclose(file);
    unsigned long long digest;
    assert_int_equal(sscanf(text, "%llx", &digest), 1);
    /* FNV-1a of "pass-2", a zero byte, "core" */
    uint64_t other = 0xcbf29ce484222325u;
    for (const char *at = "pass-2\0core", *end = at + 11; at < end; at++)
        other = (other ^ (unsigned char)*at) * 0x100000001b3u;
    file = fopen(path, "w");
    fprintf(file, "%016llx pass-1\nnonsense\n%016llx .pass-1 core\n%016llx pass-1 .core\n", digest, digest, digest);
    fprintf(file, "%016llx pass-1 core\n%016llx pass-2 core\n%016llx pass-1", digest + 1, (unsigned long long)other,
            digest);
    fclose(file);
    track = make_track(&options);
    toliman_track_stream streams[2] = {{.struct_size = sizeof *streams}};
    size_t count = 0;
    assert_ok(toliman_track_get_streams(track, streams, 2, &count));
    assert_int_equal(count, 1);
    assert_true(streams[0].stream == digest);
    assert_string_equal(streams[0].session, "");
    push_number(track, 2); /* writes the name again, after the truncated line */
    assert_ok(toliman_track_get_streams(track, streams, 2, &count));
    assert_int_equal(count, 1);
    assert_string_equal(streams[0].session, "pass-1");
    assert_string_equal(streams[0].roi, "core");
    toliman_track_destroy(track);
}

/* The table of sessions and regions holds 65536 entries, regardless of the number of frames. */
TEST(number_of_sessions_is_limited) {
    enum { SESSIONS = 65536 };
    toliman_track_options options = small_options(NULL);
    options.ledger.capacity = 100000;
    toliman_track *track = make_track(&options);
    small_frame frame;
    char name[20];
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done = 9;
    make_frame(&frame, 1);
    frame.frame.session = name;
    for (int i = 0; i < SESSIONS; i++) {
        snprintf(name, sizeof name, "s%d", i);
        assert_ok(toliman_track_push(track, &frame.frame, 1, &outcome, &done));
    }
    snprintf(name, sizeof name, "one-more");
    assert_refused(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_CAPACITY, "");
    snprintf(name, sizeof name, "s7");
    frame.frame.frame_id = 2;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    toliman_track_destroy(track);
}

TEST(empty_requests) {
    const toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    toliman_track_record lines[2] = {{.struct_size = sizeof *lines}};
    size_t done = 9;
    assert_ok(toliman_track_push(track, NULL, 0, NULL, &done));
    assert_int_equal(done, 0);
    push_range(track, 1, 3);
    assert_ok(toliman_track_commit(track));
    assert_ok(toliman_track_save(track));
    done = 9;
    assert_ok(toliman_track_get_records(track, 0, 0, NULL, &done));
    assert_int_equal(done, 0);
    assert_ok(toliman_track_get_records(track, 1, 1, lines, &done));
    assert_int_equal(done, 1);
    assert_int_equal(lines[0].frame_id, 2);
    assert_ok(toliman_track_get_records(track, 2, 2, lines, &done));
    assert_int_equal(done, 1);
    assert_int_equal(lines[0].frame_id, 3);
    assert_ok(toliman_track_get_records(track, 3, 2, lines, &done));
    assert_int_equal(done, 0);
    assert_int_equal(info_of(track).received, 3);
    toliman_track_destroy(track);
}

RUN_TESTS(NULL, NULL)
