/* Small frames by number, an estimator with exact values, and the expected periodogram. */
#ifndef TOLIMAN_TESTS_TRACK_FRAMES_H
#define TOLIMAN_TESTS_TRACK_FRAMES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "samples.h"
#include "test_folder.h"

#include <toliman/track_records.h>

enum { SIDE = 8, PIXELS = SIDE * SIDE, FREQUENCIES = 40, STATE_CAPACITY = 65536 };
#define DAY_NS 86400000000000
#define SIGMA 0.25
#define VALUE_LIMIT 3.0

/* SplitMix64. */
static inline uint64_t mixed(uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

static inline uint64_t draw(uint64_t *state, uint64_t below) {
    return mixed((*state)++) % below;
}

typedef struct small_frame {
    uint16_t pixels[PIXELS];
    toliman_frame frame;
} small_frame;

/* Pixels of 1 to 4000; every 23rd frame is an outlier. */
static inline void make_frame(small_frame *out, int64_t id) {
    for (int i = 0; i < PIXELS; i++)
        out->pixels[i] = (uint16_t)(1 + mixed((uint64_t)id * PIXELS + (uint64_t)i) % 1000);
    if (id % 23 == 7)
        out->pixels[0] = 4000;
    out->frame = (toliman_frame){.struct_size = sizeof out->frame,
                                 .pixel = TOLIMAN_PIXEL_U16,
                                 .session = "pass-1",
                                 .roi = "core",
                                 .frame_id = id,
                                 .camera_ns = id * DAY_NS + (int64_t)(mixed((uint64_t)id) % 1000000),
                                 .pixels = out->pixels,
                                 .rows = SIDE,
                                 .cols = SIDE};
}

/* Integers below 2^20 over 1024: exact. */
static inline double value_of(const double *image, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (i % 2 ? -1 : 1) * image[i];
    return sum / 1024;
}

static inline int32_t small_estimate(const toliman_estimate_input *input, toliman_estimate *made, void *unused) {
    (void)unused;
    made->values[0] = value_of(input->image, input->rows * input->cols);
    return 0;
}

static inline double value_of_frame(const small_frame *frame) {
    double image[PIXELS];
    for (int i = 0; i < PIXELS; i++)
        image[i] = frame->pixels[i];
    return value_of(image, PIXELS);
}

/* 12-bit frames; half a frame of zeros is a zero run. */
static inline toliman_track_options small_options(const char *folder) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.folder = folder;
    options.ledger.capacity = 5000;
    options.estimator.estimate = small_estimate;
    options.estimator.id = 77;
    options.estimator.sigma = SIGMA;
    options.limits.value = VALUE_LIMIT;
    options.frames.rows = options.frames.cols = SIDE;
    options.frames.bit_depth = 12;
    options.frames.zero_run_bytes = PIXELS;
    options.grid.f0 = 0.001;
    options.grid.df = 0.0007;
    options.grid.nf = FREQUENCIES;
    return options;
}

static inline toliman_track *make_track(const toliman_track_options *options) {
    toliman_track *track = NULL;
    assert_ok(toliman_track_create(options, &track));
    return track;
}

static inline toliman_track_outcome push_one(toliman_track *track, const toliman_frame *frame) {
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done = 9;
    assert_ok(toliman_track_push(track, frame, 1, &outcome, &done));
    assert_int_equal(done, 1);
    return outcome;
}

static inline int32_t push_number(toliman_track *track, int64_t id) {
    small_frame frame;
    make_frame(&frame, id);
    return push_one(track, &frame.frame).verdict;
}

static inline toliman_track_info info_of(const toliman_track *track) {
    toliman_track_info info = {.struct_size = sizeof info};
    assert_ok(toliman_track_get_info(track, &info));
    return info;
}

/* Of the periodogram that a tracker with these options must have, without nuisance functions. */
static inline toliman_period_options clean_options(const toliman_track_options *options) {
    toliman_period_options made = TOLIMAN_PERIOD_OPTIONS_INIT;
    made.flags = options->grid.flags;
    made.time_offset_ns = options->grid.time_offset_ns;
    made.unit_ns = options->grid.unit_ns != 0 ? options->grid.unit_ns : DAY_NS;
    made.value_bound = 4; /* the power of two above VALUE_LIMIT */
    made.sigma_floor = SIGMA;
    return made;
}

/* An empty periodogram on the grid that a tracker with these options must have. */
static inline toliman_period *clean_period(const toliman_track_options *options) {
    const toliman_period_options made = clean_options(options);
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(options->grid.f0, options->grid.df, options->grid.nf, &made, &period));
    return period;
}

static inline void push_clean(toliman_period *period, int64_t id) {
    small_frame frame;
    make_frame(&frame, id);
    const double value = value_of_frame(&frame);
    if (fabs(value) <= VALUE_LIMIT)
        assert_ok(push_ns(period, frame.frame.camera_ns, value, SIGMA));
}

static inline void assert_same_periods(const toliman_period *a, const toliman_period *b) {
    static unsigned char bytes_a[STATE_CAPACITY], bytes_b[STATE_CAPACITY];
    size_t size_a, size_b;
    assert_ok(toliman_period_save(a, bytes_a, sizeof bytes_a, &size_a));
    assert_ok(toliman_period_save(b, bytes_b, sizeof bytes_b, &size_b));
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
}

static inline const toliman_period *period_of(const toliman_track *track) {
    const toliman_period *period = NULL;
    assert_ok(toliman_track_get_period(track, &period));
    return period;
}

/* The tracker's periodogram must equal that of the frames first to last. */
static inline void assert_holds(const toliman_track *track, const toliman_track_options *options, int64_t first,
                                int64_t last) {
    toliman_period *clean = clean_period(options);
    for (int64_t id = first; id <= last; id++)
        push_clean(clean, id);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

#endif
