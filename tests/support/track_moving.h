/* Trackers of frames of moving stars. A file defines SIDE, PIXELS, NF, FRAMES, INTERVAL_DAYS and ARRIVING (the number
 * of frames that arrive) before it includes this. */
#ifndef TOLIMAN_TESTS_TRACK_MOVING_H
#define TOLIMAN_TESTS_TRACK_MOVING_H

#include "images.h"
#include "samples.h"
#include "scene_text.h"
#include "test_folder.h"

#include <toliman/track.h>
#include <toliman/track_records.h>

#define DAY_NS 86400000000000
#define EPOCH_NS (1234 * DAY_NS + 5)

static toliman_sim *sim;
static toliman_fit *fit;
static double frames[FRAMES * PIXELS]; /* of the scene at their times */

static inline toliman_track_options moving_options(const char *place) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.folder = place;
    options.ledger.capacity = 100;
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.estimator.fit = fit;
    options.grid.f0 = 0.001;
    options.grid.df = 0.001;
    options.grid.nf = NF;
    options.grid.time_offset_ns = EPOCH_NS;
    return options;
}

static inline toliman_track *opened(const toliman_track_options *options) {
    toliman_track *track = NULL;
    assert_ok(toliman_track_create(options, &track));
    return track;
}

static inline toliman_frame frame_of(int64_t id) {
    return (toliman_frame){.struct_size = sizeof(toliman_frame),
                           .pixel = TOLIMAN_PIXEL_F64,
                           .session = "s",
                           .roi = "core",
                           .frame_id = id,
                           .camera_ns = EPOCH_NS + id * INTERVAL_DAYS * DAY_NS,
                           .pixels = frames + id * PIXELS,
                           .rows = SIDE,
                           .cols = SIDE};
}

static inline void push(toliman_track *track, const int *ids, size_t count, toliman_track_outcome *outcomes) {
    toliman_frame given[ARRIVING];
    size_t done;
    for (size_t i = 0; i < count; i++)
        given[i] = frame_of(ids[i]);
    outcomes[0].struct_size = sizeof *outcomes;
    assert_ok(toliman_track_push(track, given, count, outcomes, &done));
    assert_int_equal(done, count);
}

/* A frame without stars is rejected, and the next one is not. */
static inline void assert_empty_rejected(const toliman_track_options *options) {
    static double empty[PIXELS];
    toliman_track *const track = opened(options);
    toliman_frame frame = frame_of(1);
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done;
    frame.pixels = empty;
    assert_ok(toliman_track_push(track, &frame, 1, &outcome, &done));
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
    assert_int_equal(outcome.reason, TOLIMAN_TRACK_REASON_ESTIMATE);
    push(track, (int[]){1}, 1, &outcome);
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    toliman_track_destroy(track);
}

/* The bits of the periodogram, without those that depend on the order of arrival. */
static inline void powers_of(const toliman_track *track, double *powers) {
    const toliman_period *period = NULL;
    assert_ok(toliman_track_get_period(track, &period));
    assert_int_equal(count_of(period), ARRIVING);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, NF, powers));
}

static inline double cell(const toliman_track *track, const char *name, int64_t record) {
    double value;
    size_t done;
    assert_ok(toliman_track_get_column(track, name, record, 1, &value, &done));
    assert_int_equal(done, 1);
    return value;
}

#endif
