/* A tracker's folder for tests: its files, damage to them, and a folder with records of every kind. */
#ifndef TOLIMAN_TESTS_TRACK_FOLDER_H
#define TOLIMAN_TESTS_TRACK_FOLDER_H

#include <fcntl.h>
#include <sys/stat.h>

#include "track_frames.h"

/* Columns: tools/docs/formats.md "TLML". */
enum { COLUMNS = 10, HEADER = 124 + COLUMNS * 64, LINE = 64 + COLUMNS * 8 };

static char folder[256], ledger[300], checkpoint[300], setup[300];

static inline int set_up(void **unused) {
    (void)unused;
    make_folder(folder, sizeof folder);
    snprintf(ledger, sizeof ledger, "%s/ledger.tlml", folder);
    snprintf(checkpoint, sizeof checkpoint, "%s/checkpoint.tlmc", folder);
    snprintf(setup, sizeof setup, "%s/setup.tlms", folder);
    return 0;
}

static inline int tear_down(void **unused) {
    (void)unused;
    remove_folder(folder);
    return 0;
}

/* A test with a new folder. */
#define TEST_IN_FOLDER(name) TEST_WITH(name, set_up, tear_down)

static inline void push_range(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++)
        push_number(track, id);
}

static inline void write_at(const char *path, off_t at, const void *bytes, size_t size) {
    const int file = open(path, O_RDWR);
    assert_true(file >= 0);
    assert_int_equal(pwrite(file, bytes, size, at), (ssize_t)size);
    close(file);
}

static inline void read_at(const char *path, off_t at, void *bytes, size_t size) {
    const int file = open(path, O_RDONLY);
    assert_int_equal(pread(file, bytes, size, at), (ssize_t)size);
    close(file);
}

static inline off_t size_of(const char *path) {
    struct stat attributes;
    assert_int_equal(stat(path, &attributes), 0);
    return attributes.st_size;
}

static inline void flip_byte(const char *path, off_t at) {
    unsigned char byte;
    read_at(path, at, &byte, 1);
    byte ^= 0x10;
    write_at(path, at, &byte, 1);
}

/* Content of filled_folder: number of repeated frames, and of records, of which two count the repeats. */
enum { FILLED_REPEATS = 5 + 11 + 3, FILLED_LINES = 60 + 3 + 2 };

/* A folder with 60 frames, 40 of them in the checkpoint. Frame 10 is quarantined before the checkpoint, 20 and 50 after
 * it. */
static inline toliman_track_options filled_folder(void) {
    toliman_track_options options = small_options(folder);
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    toliman_track *track = make_track(&options);
    small_frame frame;
    push_range(track, 1, 40);
    push_range(track, 1, 5);
    make_frame(&frame, 10);
    frame.pixels[0]++;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    assert_ok(toliman_track_save(track));
    for (int64_t id = 20; id <= 50; id += 30) {
        push_range(track, id < 41 ? 41 : id, 60);
        make_frame(&frame, id);
        frame.pixels[0]++;
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    }
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    return options;
}

static inline void assert_filled(const toliman_track *track, const toliman_track_options *options) {
    toliman_period *clean = clean_period(options);
    for (int64_t id = 1; id <= 60; id++)
        if (id != 10 && id != 20 && id != 50)
            push_clean(clean, id);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
    const toliman_track_info info = info_of(track);
    assert_int_equal(info.accepted + info.outlier, 57);
    assert_int_equal(info.quarantined, 3);
    assert_int_equal(info.repeated, FILLED_REPEATS);
    assert_int_equal(info.received, 60 + FILLED_REPEATS);
    assert_int_equal(info.records, FILLED_LINES);
    assert_true(info.committed == FILLED_LINES || (info.flags & TOLIMAN_TRACK_READ_ONLY) != 0);
}

static inline uint64_t number_at(const char *path, off_t at, size_t size) {
    uint64_t number = 0;
    read_at(path, at, &number, size);
    return number;
}

static inline double double_at(const char *path, off_t at) {
    const uint64_t bits = number_at(path, at, 8);
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static inline uint32_t crc32(uint32_t before, const void *data, size_t size) {
    uint32_t crc = ~before;
    for (size_t i = 0; i < size; i++) {
        crc ^= ((const unsigned char *)data)[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

#endif
