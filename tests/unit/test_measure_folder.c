/* Tests the frames of a tracker as a series: the values and functions of its sums, and the measured separations with
 * their time on target, also of frames with lists of intervals. */
#include "reduced_folder.h"

#include <toliman/sky.h>

static toliman_measure *load(int32_t kind) {
    const toliman_measure_options options = {.struct_size = sizeof options, .kind = kind};
    toliman_measure *made = NULL;
    assert_ok(toliman_measure_load_file(folder, &options, &made));
    return made;
}

static toliman_measure_info info_of_measure(const toliman_measure *measure) {
    toliman_measure_info info = TOLIMAN_MEASURE_INFO_INIT;
    assert_ok(toliman_measure_get_info(measure, &info));
    return info;
}

/* A periodogram of the series has the sums of the tracker. */
TEST_WITH(values_are_those_of_the_sums, set_up, tear_down) {
    fill_folder(orbit, 1, LAST);
    toliman_track *const track = open_reader();
    toliman_measure *const series = load(0);
    const toliman_measure_info info = info_of_measure(series);
    const size_t n = (size_t)info.n, k = (size_t)info.columns;
    assert_true(info.n == info_of(track).accepted && info.kind == TOLIMAN_MEASURE_REDUCED && k == 7);
    assert_close(info.unit, SCALE, 1e-15, 0);
    double *const y = calloc(n, sizeof *y), *const rows = calloc(n * k, sizeof *rows),
                  *const one = calloc(n, sizeof *one);
    int64_t *const times = calloc(n, sizeof *times);
    assert_ok(toliman_measure_get_values(series, "y", y, n));
    assert_ok(toliman_measure_get_times(series, times, n));
    for (size_t c = 0; c < k; c++) {
        toliman_measure_function function = TOLIMAN_MEASURE_FUNCTION_INIT;
        assert_ok(toliman_measure_get_function(series, (int64_t)c, &function));
        assert_true(function.sigma > 0 && function.bound > 0);
        assert_ok(toliman_measure_get_values(series, function.name, one, n));
        for (size_t i = 0; i < n; i++)
            rows[i * k + c] = one[i];
    }
    int32_t elements[7];
    toliman_period *const clean = clean_reduced(orbit, elements);
    for (size_t i = 0; i < n; i++) {
        const toliman_period_sample sample = sample_ns(times[i], y[i], SIGMA);
        assert_ok(toliman_period_push_samples(clean, &sample, rows + i * k, 1));
    }
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean), free(times), free(one), free(rows), free(y), toliman_measure_destroy(series);
    toliman_track_destroy(track);
}

/* Plain times are those of the periodogram, whose trend they have. */
TEST_WITH(plain_times_are_those_of_the_grid, set_up, tear_down) {
    fill_folder(orbit, 1, LAST);
    toliman_track *const track = open_reader();
    toliman_period_info sums = TOLIMAN_PERIOD_INFO_INIT;
    assert_ok(toliman_period_get_info(period_of(track), &sums));
    toliman_measure_options options = {.struct_size = sizeof options, .flags = TOLIMAN_SERIES_PLAIN_TIMES};
    toliman_measure *made = NULL;
    assert_ok(toliman_measure_load_file(folder, &options, &made));
    const toliman_measure_info info = info_of_measure(made);
    double t[LAST];
    int64_t times[LAST];
    assert_true(info.time_scale == 0 && info.n <= LAST && info.columns == 7);
    assert_close(info.time_unit_days, sums.unit_ns / 86400e9, 1e-15, 0);
    assert_ok(toliman_measure_get_values(made, "t", t, (size_t)info.n));
    assert_ok(toliman_measure_get_times(made, times, (size_t)info.n));
    for (int64_t i = 0; i < info.n; i++)
        assert_close(t[i], (double)(times[i] - sums.time_offset_ns) / sums.unit_ns, 1e-15, 0);
    toliman_measure_destroy(made), toliman_track_destroy(track);
}

/* Reducing the measured separations gives the values. */
TEST_WITH(separations_reduce_to_the_values, set_up, tear_down) {
    static const double pairs[] = {100, 400, 1500, 1900};
    toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *const track = make_track(&options);
    push_all_exposed(track, 1, 10);
    small_frame frame;
    make_exposed(&frame, 11);
    frame.frame.exposure_s = 2000;
    frame.frame.intervals = pairs;
    frame.frame.interval_count = 2;
    push_one(track, &frame.frame);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    toliman_measure *const values = load(0), *const measured = load(TOLIMAN_MEASURE_SEPARATION), *reduced = NULL;
    assert_ok(toliman_sky_reduce(orbit, measured, NULL, &reduced));
    const toliman_measure_info all = info_of_measure(measured), info = info_of_measure(values);
    assert_true(all.n >= info.n && info.n > 5 && all.has_exposures == 1);
    double y[2][20];
    int64_t times[2][20];
    assert_ok(toliman_measure_get_values(values, "y", y[0], (size_t)info.n));
    assert_ok(toliman_measure_get_times(values, times[0], (size_t)info.n));
    assert_ok(toliman_measure_get_values(reduced, "y", y[1], (size_t)all.n));
    assert_ok(toliman_measure_get_times(measured, times[1], (size_t)all.n));
    int found = 0;
    for (int64_t i = 0; i < info.n; i++)
        for (int64_t j = 0; j < all.n; j++)
            if (times[1][j] == times[0][i]) {
                assert_close(y[1][j], y[0][i], 0, 1e-13);
                found++;
            }
    assert_int_equal(found, info.n);
    toliman_measure_destroy(reduced), toliman_measure_destroy(measured), toliman_measure_destroy(values);
}

/* It keeps no lists: the time on target of such a frame is not known. */
TEST_WITH(a_tracker_in_memory_leaves_lists_out, set_up, tear_down) {
    static const double pairs[] = {100, 400, 1500, 1900};
    toliman_track *const track = reduced_in_memory(orbit, 1, 10);
    small_frame frame;
    make_exposed(&frame, 11);
    frame.frame.exposure_s = 2000;
    frame.frame.intervals = pairs;
    frame.frame.interval_count = 2;
    push_one(track, &frame.frame);
    const toliman_measure_options options = {.struct_size = sizeof options, .kind = TOLIMAN_MEASURE_SEPARATION};
    toliman_measure *made = NULL;
    assert_ok(toliman_track_get_measure(track, &options, &made));
    assert_true(info_of_measure(made).left_out >= 1 && info_of_measure(made).n > 3);
    toliman_measure_destroy(made), toliman_track_destroy(track);
}

/* Times and exposures go through the clock of the rebuilt folder. */
TEST_WITH(times_are_those_of_a_new_clock, set_up, tear_down) {
    fill_folder(orbit, 1, 10);
    const int64_t clock[] = {START_NS, START_NS + SECOND_NS, START_NS + 1000000 * SECOND_NS,
                             START_NS + 1000001 * SECOND_NS};
    toliman_track_options options = loaded_options(TOLIMAN_TRACK_REBUILD);
    options.reduction.sky = orbit;
    options.clock.pairs = clock;
    options.clock.count = 2;
    toliman_track *const track = make_track(&options);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    toliman_measure *const values = load(0), *const measured = load(TOLIMAN_MEASURE_SEPARATION);
    const size_t n = (size_t)info_of_measure(measured).n;
    int64_t times[2][20];
    assert_true(n == (size_t)info_of_measure(values).n && n <= 20);
    assert_ok(toliman_measure_get_times(values, times[0], n));
    assert_ok(toliman_measure_get_times(measured, times[1], n));
    assert_memory_equal(times[0], times[1], n * sizeof **times);
    toliman_measure_destroy(measured), toliman_measure_destroy(values);
}

TEST_WITH(options_of_files_are_refused, set_up, tear_down) {
    fill_folder(orbit, 1, 5);
    toliman_measure *made = NULL;
    const struct {
        toliman_measure_options options;
        const char *field;
    } cases[] = {{{.columns = "t,y"}, "options->columns"},
                 {{.time_scale = TOLIMAN_INGEST_SCALE_TAI}, "options->time_scale"},
                 {{.exposure_s = 1}, "options->exposure_s"},
                 {{.kind = TOLIMAN_MEASURE_VELOCITY}, "options->kind"},
                 {{.flags = TOLIMAN_SERIES_GROWING}, "options->flags"},
                 {{.kind = TOLIMAN_MEASURE_SEPARATION, .flags = TOLIMAN_SERIES_PLAIN_TIMES}, "options->flags"},
                 {{.unit = -1}, "options->unit"},
                 {{.unit = 2}, "options->unit"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_measure_options options = cases[i].options;
        options.struct_size = sizeof options;
        assert_invalid(toliman_measure_load_file(folder, &options, &made), cases[i].field);
    }
    assert_refused(toliman_measure_load_file("/tmp", NULL, &made), TOLIMAN_E_NOT_FOUND, "/tmp");
    assert_null(made);
}

RUN_TESTS(make_skies, destroy_skies)
