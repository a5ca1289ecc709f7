/* Folders of reduced frames for tests: observers, values computed by hand, and rebuilding. */
#ifndef TOLIMAN_TESTS_REDUCED_FOLDER_H
#define TOLIMAN_TESTS_REDUCED_FOLDER_H

#include <toliman/period_nuisance.h>

#include "track_folder.h"
#include "track_reduced.h"

/* Columns: 16 of the library, separation_px, 2 covariances. */
enum { LAST = 30, REDUCED_COLUMNS = 22 };

static toliman_sky *earth, *orbit, *predicted, *other;

static inline int make_skies(void **unused) {
    (void)unused;
    char place[256], path[300];
    make_folder(place, sizeof place);
    snprintf(path, sizeof path, "%s/states.csv", place);
    write_states(path);
    earth = make_sky("alpha-cen", NULL, 0);
    orbit = make_sky("alpha-cen", NULL, 600);
    predicted = make_sky("alpha-cen", path, 0);
    other = make_other_sky(orbit);
    set_base(earth);
    remove_folder(place);
    return 0;
}

static inline int destroy_skies(void **unused) {
    (void)unused;
    toliman_sky *const skies[] = {earth, orbit, predicted, other};
    for (size_t i = 0; i < sizeof skies / sizeof *skies; i++)
        toliman_sky_destroy(skies[i]);
    return 0;
}

/* The means over the time on target of a frame; the clock is fast by `rate`. */
static inline toliman_sky_prediction mean_by_hand(const toliman_sky *sky, const toliman_frame *frame, double rate) {
    static int64_t spans[2 * 5000];
    const double whole[] = {0, frame->exposure_s}, *pairs = frame->interval_count > 0 ? frame->intervals : whole;
    const size_t count = frame->interval_count > 0 ? frame->interval_count : 1;
    for (size_t i = 0; i < 2 * count; i++) {
        const int64_t camera_ns = frame->camera_ns + llround((pairs[i] - frame->exposure_s / 2) * 1e9);
        spans[i] = camera_ns + llround((double)(camera_ns - START_NS) * rate);
    }
    toliman_sky_prediction mean = TOLIMAN_SKY_PREDICTION_INIT;
    assert_ok(toliman_sky_predict_mean(sky, spans, &count, 1, &mean));
    return mean;
}

/* Measured separation over factor minus geometric separation. */
static inline double reduced_by_hand(const toliman_sky *sky, const toliman_frame *frame, double measured, double rate) {
    const toliman_sky_prediction mean = mean_by_hand(sky, frame, rate);
    return measured / mean.factor - mean.geometric_arcsec / SCALE;
}

static inline double value_by_hand(const toliman_sky *sky, const small_frame *frame) {
    return reduced_by_hand(sky, &frame->frame, base_px + value_of_frame(frame), 0);
}

static inline void push_by_hand(toliman_period *period, const toliman_sky *sky, const int32_t elements[7], int64_t id) {
    small_frame frame;
    make_exposed(&frame, id);
    const double value = value_by_hand(sky, &frame);
    if (fabs(value_of_frame(&frame)) > VALUE_LIMIT || fabs(value) > VALUE_LIMIT)
        return;
    const toliman_sky_prediction mean = mean_by_hand(sky, &frame.frame, 0);
    const toliman_period_sample sample = sample_ns(frame.frame.camera_ns, value, SIGMA);
    double row[7];
    for (int c = 0; c < 7; c++)
        row[c] = mean.partials[elements[c]];
    assert_ok(toliman_period_push_samples(period, &sample, row, 1));
}

/* An empty periodogram with the errors of the orbit as nuisance functions; elements: those of its columns. */
static inline toliman_period *clean_reduced(const toliman_sky *sky, int32_t elements[7]) {
    const toliman_track_options options = reduced_options(NULL, sky);
    toliman_period_options made = clean_options(&options);
    assert_ok(toliman_sky_set_columns(sky, SCALE, 0, &made, elements));
    toliman_period *clean = NULL;
    assert_ok(toliman_period_create(options.grid.f0, options.grid.df, options.grid.nf, &made, &clean));
    return clean;
}

static inline void assert_sums_by_hand(const toliman_track *track, const toliman_sky *sky, int64_t last,
                                       int64_t without) {
    int32_t elements[7];
    toliman_period *clean = clean_reduced(sky, elements);
    for (int64_t id = 1; id <= last; id++)
        if (id != without)
            push_by_hand(clean, sky, elements, id);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

static inline toliman_track_info assert_counted(const toliman_track *track) {
    const toliman_track_info info = info_of(track);
    assert_int_equal(info.received,
                     info.accepted + info.unreduced + info.outlier + info.quarantined + info.repeated + info.rejected);
    return info;
}

static inline void fill_with(const toliman_track_options *options, int64_t first, int64_t last) {
    toliman_track *const track = make_track(options);
    push_all_exposed(track, first, last);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
}

static inline void fill_folder(const toliman_sky *sky, int64_t first, int64_t last) {
    const toliman_track_options options = reduced_options(folder, sky);
    fill_with(&options, first, last);
}

/* Options with which a folder is opened as it is. */
static inline toliman_track_options loaded_options(uint32_t flags) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_load_options(folder, &options));
    options.flags |= flags;
    return options;
}

static inline toliman_track *open_reader(void) {
    const toliman_track_options options = loaded_options(TOLIMAN_TRACK_READ_ONLY);
    return make_track(&options);
}

static inline toliman_track *rebuild(const toliman_sky *sky, double scale) {
    toliman_track_options options = loaded_options(TOLIMAN_TRACK_REBUILD);
    options.reduction.sky = sky;
    options.reduction.plate_scale_arcsec = scale;
    return make_track(&options);
}

static inline toliman_track *reduced_in_memory(const toliman_sky *sky, int64_t first, int64_t last) {
    const toliman_track_options options = reduced_options(NULL, sky);
    toliman_track *const track = make_track(&options);
    push_all_exposed(track, first, last);
    return track;
}

static inline void assert_sums_of_memory(const toliman_track *track, const toliman_sky *sky, int64_t first,
                                         int64_t last) {
    toliman_track *const expected = reduced_in_memory(sky, first, last);
    assert_same_periods(period_of(track), period_of(expected));
    toliman_track_destroy(expected);
}

static inline int64_t records_with(const toliman_track *track, int32_t verdict, int32_t reason) {
    static toliman_track_record records[2000];
    size_t count = 0;
    int64_t found = 0;
    records->struct_size = sizeof *records;
    assert_ok(toliman_track_get_records(track, 0, 2000, records, &count));
    for (size_t i = 0; i < count; i++)
        found += records[i].verdict == verdict && records[i].reason == reason;
    return found;
}

static inline void push_changed(toliman_track *track, int64_t id) {
    small_frame frame;
    make_exposed(&frame, id);
    frame.pixels[1]++;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
}

#endif
