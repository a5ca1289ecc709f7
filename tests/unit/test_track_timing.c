/* Tests stamp and exposure_s of a folder: recorded in the setup file, kept by each run, refused if they differ. */
#include <stddef.h>

#include "track_folder.h"

static toliman_track_options timed_options(int32_t stamp, double exposure_s) {
    toliman_track_options options = small_options(folder);
    options.frames.stamp = stamp;
    options.frames.exposure_s = exposure_s;
    return options;
}

static void assert_timing(const toliman_track *track, int32_t stamp, double exposure_s) {
    toliman_track_options kept = TOLIMAN_TRACK_OPTIONS_INIT, loaded = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &kept));
    assert_ok(toliman_track_load_options(folder, &loaded));
    assert_int_equal(kept.frames.stamp, stamp);
    assert_int_equal(loaded.frames.stamp, stamp);
    assert_true(kept.frames.exposure_s == exposure_s && loaded.frames.exposure_s == exposure_s);
}

static void make_frames(const toliman_track_options *options) {
    toliman_track *track = make_track(options);
    push_range(track, 1, 8);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
}

static size_t read_whole(const char *path, unsigned char *bytes, size_t most) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, most, file);
    fclose(file);
    return size;
}

/* tools/docs/formats.md, "TLMS". */
TEST_IN_FOLDER(setup_file_has_version_2_only_with_a_timing) {
    unsigned char plain[1000], timed[1000];
    const toliman_track_options without = small_options(folder), with = timed_options(TOLIMAN_FRAME_STAMP_END, 0.75);
    make_frames(&without);
    const size_t size = read_whole(setup, plain, sizeof plain);
    assert_int_equal(number_at(setup, 4, 4), 1);
    remove_folder(folder);
    make_frames(&with);
    assert_int_equal(read_whole(setup, timed, sizeof timed), size + 12);
    assert_int_equal(number_at(setup, 4, 4), 2);
    assert_memory_equal(timed + 8, plain + 8, size - 12); /* clock and grid, without version and CRC32 */
    assert_int_equal(number_at(setup, (off_t)size - 4, 4), 2);
    assert_true(double_at(setup, (off_t)size) == 0.75);
    assert_int_equal(number_at(setup, (off_t)size + 8, 4), crc32(0, timed, size + 8));
}

/* Values of another kind of option would be a change of format, so each pair is compared with what the file says. */
TEST_IN_FOLDER(folder_keeps_its_timing) {
    static const struct {
        int32_t stamp, kept;
        double exposure_s;
    } cases[] = {{0, TOLIMAN_FRAME_STAMP_MIDDLE, 0},
                 {0, TOLIMAN_FRAME_STAMP_MIDDLE, 0.5},
                 {TOLIMAN_FRAME_STAMP_MIDDLE, TOLIMAN_FRAME_STAMP_MIDDLE, 0},
                 {TOLIMAN_FRAME_STAMP_START, TOLIMAN_FRAME_STAMP_START, 0},
                 {TOLIMAN_FRAME_STAMP_END, TOLIMAN_FRAME_STAMP_END, 1e9}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const toliman_track_options options = timed_options(cases[i].stamp, cases[i].exposure_s);
        make_frames(&options);
        for (int reading = 0; reading < 2; reading++) {
            toliman_track_options again = small_options(folder);
            again.flags = reading ? TOLIMAN_TRACK_READ_ONLY : 0;
            toliman_track *track = make_track(&again);
            assert_timing(track, cases[i].kept, cases[i].exposure_s);
            assert_int_equal(info_of(track).accepted + info_of(track).outlier, 8);
            toliman_track_destroy(track);
        }
        remove_folder(folder);
    }
    const toliman_track_options in_memory = small_options(NULL);
    toliman_track *track = make_track(&in_memory);
    toliman_track_options kept = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &kept));
    assert_int_equal(kept.frames.stamp, TOLIMAN_FRAME_STAMP_MIDDLE);
    toliman_track_destroy(track);
    mkdir(folder, 0777);
}

TEST_IN_FOLDER(another_timing_is_refused) {
    const toliman_track_options options = timed_options(TOLIMAN_FRAME_STAMP_START, 0.5);
    make_frames(&options);
    toliman_track *none = NULL;
    for (uint32_t flags = 0; flags <= TOLIMAN_TRACK_REBUILD; flags++) {
        toliman_track_options other = options;
        other.flags = flags;
        other.frames.stamp = TOLIMAN_FRAME_STAMP_END;
        assert_refused(toliman_track_create(&other, &none), TOLIMAN_E_MISMATCH, setup);
        other.frames.stamp = 0;
        other.frames.exposure_s = 0.25;
        assert_refused(toliman_track_create(&other, &none), TOLIMAN_E_MISMATCH, setup);
    }
    toliman_track_options rebuilt = options; /* which keeps what it is not given */
    rebuilt.flags = TOLIMAN_TRACK_REBUILD;
    rebuilt.grid.nf = 2 * FREQUENCIES;
    rebuilt.frames.stamp = 0;
    rebuilt.frames.exposure_s = 0;
    toliman_track *track = make_track(&rebuilt);
    assert_timing(track, TOLIMAN_FRAME_STAMP_START, 0.5);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(bad_values_are_refused) {
    static const double bad[] = {-1, 1.1e9, NAN, INFINITY};
    toliman_track *none = NULL;
    for (int32_t stamp = 600; stamp <= 604; stamp += 4) {
        const toliman_track_options options = timed_options(stamp, 0);
        assert_invalid(toliman_track_create(&options, &none), "options->frames.stamp");
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const toliman_track_options options = timed_options(0, bad[i]);
        assert_invalid(toliman_track_create(&options, &none), "options->frames.exposure_s");
    }
}

/* Frames of both folders were given times by different rules. */
TEST_IN_FOLDER(merge_needs_the_same_timing) {
    const toliman_track_options options = timed_options(TOLIMAN_FRAME_STAMP_START, 0.5);
    make_frames(&options);
    toliman_track_options into = small_options(NULL);
    toliman_track *track = make_track(&into);
    for (uint32_t flags = 0; flags <= TOLIMAN_TRACK_SALVAGE; flags += TOLIMAN_TRACK_SALVAGE)
        assert_refused(toliman_track_merge(track, folder, flags, NULL), TOLIMAN_E_MISMATCH, setup);
    assert_int_equal(info_of(track).received, 0);
    toliman_track_destroy(track);
    into.frames.stamp = TOLIMAN_FRAME_STAMP_START;
    into.frames.exposure_s = 0.5;
    track = make_track(&into);
    assert_ok(toliman_track_merge(track, folder, 0, NULL));
    assert_int_equal(info_of(track).received, 8);
    assert_int_equal(unlink(setup), 0); /* without the file, nothing contradicts */
    assert_ok(toliman_track_merge(track, folder, 0, NULL));
    toliman_track_destroy(track);
}

/* With each byte of the file flipped, it is lost, and timing, grid and clock must be given again. */
TEST_IN_FOLDER(lost_setup_loses_the_timing) {
    const int64_t camera[2] = {0, 0};
    toliman_track_options options = timed_options(TOLIMAN_FRAME_STAMP_START, 0.5), known = TOLIMAN_TRACK_OPTIONS_INIT;
    make_frames(&options);
    options.clock.pairs = camera;
    options.clock.count = 1;
    const off_t size = size_of(setup);
    for (off_t at = 0; at < size; at++) {
        flip_byte(setup, at);
        assert_ok(toliman_track_load_options(folder, &known));
        assert_true(known.grid.nf == 0 && known.frames.stamp == 0 && known.frames.exposure_s == 0);
        flip_byte(setup, at);
    }
    flip_byte(setup, size - 1);
    toliman_track *none = NULL;
    options.frames.stamp = 0;
    assert_invalid(toliman_track_create(&options, &none), "options->frames.stamp");
    options.frames.stamp = TOLIMAN_FRAME_STAMP_START;
    toliman_track *track = make_track(&options);
    assert_timing(track, TOLIMAN_FRAME_STAMP_START, 0.5);
    toliman_track_destroy(track);
}

RUN_TESTS(NULL, NULL)
