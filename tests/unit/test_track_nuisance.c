/* Tests nuisance functions of a tracker: its sums against those of a periodogram with the same functions, its options
 * when a folder is created, opened and rebuilt, and damage to the setup. */
#include "reduced_folder.h"

enum { ORDER = 3 };
static const double kEnd = 0.5; /* d; frame LAST is at 0.35 */

static toliman_track_options trend_options(const char *where, double end) {
    toliman_track_options options = measured_options(where);
    options.grid.trend = ORDER;
    options.grid.trend_end = end;
    return options;
}

static void assert_sums_with_trend(const toliman_track *track, double end) {
    const toliman_track_options options = measured_options(NULL);
    toliman_period_options made = clean_options(&options);
    made.trend = ORDER;
    made.trend_end = end;
    toliman_period *clean = NULL;
    assert_ok(toliman_period_create(options.grid.f0, options.grid.df, options.grid.nf, &made, &clean));
    for (int64_t id = 1; id <= LAST; id++) {
        small_frame frame;
        make_exposed(&frame, id);
        const double value = value_of_frame(&frame), days = (double)(frame.frame.camera_ns - START_NS) / DAY_NS;
        if (fabs(value) <= VALUE_LIMIT && days <= end)
            assert_ok(push_ns(clean, frame.frame.camera_ns, value, SIGMA));
    }
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

static void assert_functions(const toliman_track *track, int32_t trend, uint32_t elements) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &options));
    assert_int_equal(options.grid.trend, trend);
    assert_int_equal(info_of(track).elements, elements);
    toliman_period_info period = TOLIMAN_PERIOD_INFO_INIT;
    assert_ok(toliman_period_get_info(period_of(track), &period));
    assert_int_equal(period.trend, trend > 0 ? trend : 0);
    assert_int_equal(period.columns, __builtin_popcount(elements));
}

static void reopen_with(int32_t trend, double end, toliman_status status) {
    toliman_track_options options = trend_options(folder, end);
    options.grid.trend = trend;
    toliman_track *track = NULL;
    if (status != TOLIMAN_OK) {
        assert_refused(toliman_track_create(&options, &track), status, setup);
        return;
    }
    track = make_track(&options);
    assert_sums_with_trend(track, kEnd);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(a_trend_is_fitted) {
    const toliman_track_options options = trend_options(folder, kEnd);
    fill_with(&options, 1, LAST);
    toliman_track *const reader = open_reader();
    assert_functions(reader, ORDER, 0);
    assert_sums_with_trend(reader, kEnd);
    toliman_track_destroy(reader);
    reopen_with(0, 0, TOLIMAN_OK);
    reopen_with(ORDER, kEnd, TOLIMAN_OK);
    reopen_with(ORDER + 1, kEnd, TOLIMAN_E_MISMATCH);
    reopen_with(ORDER, kEnd / 2, TOLIMAN_E_MISMATCH);
    reopen_with(-1, 0, TOLIMAN_E_MISMATCH);
    const toliman_track_options loaded = loaded_options(0);
    assert_int_equal(loaded.grid.trend, ORDER);
    assert_true(loaded.grid.trend_start == 0 && loaded.grid.trend_end == kEnd);
}

TEST_IN_FOLDER(frames_outside_the_span_are_rejected) {
    const double end = 0.3;
    const toliman_track_options options = trend_options(folder, end);
    toliman_track *track = make_track(&options);
    for (int64_t id = 1; id <= LAST; id++) {
        small_frame frame;
        make_exposed(&frame, id);
        const int is_outside = (double)(frame.frame.camera_ns - START_NS) > end * DAY_NS;
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        assert_int_equal(outcome.verdict == TOLIMAN_TRACK_VERDICT_REJECTED, is_outside);
        assert_int_equal(outcome.reason, is_outside ? TOLIMAN_TRACK_REASON_CLOCK : TOLIMAN_TRACK_REASON_NONE);
    }
    assert_sums_with_trend(track, end);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    toliman_track_options shorter = loaded_options(TOLIMAN_TRACK_REBUILD);
    shorter.grid.trend_end = end / 2;
    track = make_track(&shorter); /* later frames become outliers */
    assert_sums_with_trend(track, end / 2);
    assert_true(assert_counted(track).outlier > LAST / 3);
    toliman_track_destroy(track);
}

TEST(the_span_suits_the_grid) {
    const toliman_track_options options = trend_options(NULL, 0);
    toliman_track *const track = make_track(&options);
    toliman_track_options known = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &known));
    assert_close(known.grid.trend_start, -0.05 / options.grid.df, 1e-15, 0);
    assert_close(known.grid.trend_end, 0.15 / options.grid.df, 1e-15, 0);
    toliman_track_destroy(track);
}

/* The errors of the elements are functions unless a trend or the mean alone is asked for. */
TEST_IN_FOLDER(a_system_brings_the_errors_of_its_orbit) {
    static const struct {
        int32_t trend;
        uint32_t flags, elements;
        int32_t functions;
    } cases[] = {{0, 0, 0x7f, 8}, {-1, 0, 0, 1}, {2, 0, 0, 3}, {0, TOLIMAN_PERIOD_FIXED_MEAN, 0, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_track_options options = reduced_options(folder, orbit);
        options.grid.trend = cases[i].trend;
        options.grid.flags = cases[i].flags;
        fill_with(&options, 1, LAST);
        toliman_track *track = open_reader();
        assert_functions(track, cases[i].flags != 0 ? -1 : cases[i].trend, cases[i].elements);
        toliman_period_info period = TOLIMAN_PERIOD_INFO_INIT;
        assert_ok(toliman_period_get_info(period_of(track), &period));
        assert_int_equal(1 + period.trend + period.columns, cases[i].functions);
        assert_int_equal(period.free_functions, cases[i].trend > 0 ? cases[i].functions : 1);
        toliman_track_destroy(track);
        const toliman_track_options loaded = loaded_options(TOLIMAN_TRACK_REBUILD);
        track = make_track(&loaded);
        assert_int_equal(info_of(track).elements, cases[i].elements);
        toliman_track_destroy(track);
        remove_folder(folder);
        mkdir(folder, 0777);
    }
}

TEST_IN_FOLDER(an_error_of_the_plate_scale_widens_a_prior) {
    double axis, sigma;
    assert_ok(toliman_sky_get_element(orbit, TOLIMAN_SKY_ELEMENT_SEMI_MAJOR, &axis, &sigma));
    toliman_track_options options = reduced_options(folder, orbit);
    options.reduction.scale_sigma = 1e-3;
    fill_with(&options, 1, LAST);
    for (int rebuilt = 0; rebuilt < 2; rebuilt++) {
        options = loaded_options(rebuilt ? TOLIMAN_TRACK_REBUILD : TOLIMAN_TRACK_READ_ONLY);
        options.reduction.sky = rebuilt ? orbit : NULL;
        toliman_track *const track = make_track(&options);
        toliman_period_info period = TOLIMAN_PERIOD_INFO_INIT;
        assert_ok(toliman_period_get_info(period_of(track), &period));
        const double all = hypot(sigma, axis * 1e-3) / SCALE;
        assert_close(period.prior_precision[2], 1 / (all * all), 1e-13, 0);
        toliman_track_destroy(track);
    }
}

/* The fit of a reader against that of a periodogram with the rows of the ledger. */
TEST_IN_FOLDER(the_fit_uses_the_columns) {
    fill_folder(orbit, 1, LAST);
    toliman_track *const reader = open_reader();
    int32_t elements[7];
    toliman_period *const clean = clean_reduced(orbit, elements);
    static double t[LAST], y[LAST], sigmas[LAST], rows[7 * LAST];
    size_t count = 0;
    for (int64_t id = 1; id <= LAST; id++) {
        small_frame frame;
        make_exposed(&frame, id);
        const double value = value_by_hand(orbit, &frame);
        if (fabs(value_of_frame(&frame)) > VALUE_LIMIT || fabs(value) > VALUE_LIMIT)
            continue;
        push_by_hand(clean, orbit, elements, id);
        const toliman_sky_prediction mean = mean_by_hand(orbit, &frame.frame, 0);
        t[count] = (double)(frame.frame.camera_ns - START_NS) / DAY_NS;
        y[count] = value;
        sigmas[count] = SIGMA;
        for (int c = 0; c < 7; c++)
            rows[7 * count + (size_t)c] = mean.partials[elements[c]];
        count++;
    }
    toliman_period_peak found = TOLIMAN_PERIOD_PEAK_INIT, expected = TOLIMAN_PERIOD_PEAK_INIT;
    assert_ok(toliman_track_query_fit(reader, &found));
    assert_ok(toliman_period_query_fit(clean, t, y, sigmas, rows, count, &expected));
    assert_close(found.frequency, expected.frequency, 1e-12, 0);
    assert_close(found.amplitude, expected.amplitude, 1e-9, 0);
    assert_close(found.log10_fap, expected.log10_fap, 1e-9, 1e-12);
    toliman_period_destroy(clean), toliman_track_destroy(reader);
}

/* promise: rebuilds-equal-new-folders */
TEST_IN_FOLDER(rebuild_changes_the_functions) {
    fill_folder(orbit, 1, LAST);
    toliman_track_options options = loaded_options(TOLIMAN_TRACK_REBUILD);
    options.grid.trend = -1;
    toliman_track *track = make_track(&options);
    assert_functions(track, -1, 0);
    toliman_track_destroy(track);
    options = loaded_options(TOLIMAN_TRACK_REBUILD);
    assert_int_equal(options.grid.trend, -1);
    options.grid.trend = 0; /* those of the folder: the mean alone */
    track = make_track(&options);
    assert_functions(track, -1, 0);
    toliman_track_destroy(track);
    options.reduction.sky = orbit;
    track = make_track(&options);
    assert_functions(track, 0, 0x7f);
    assert_sums_by_hand(track, orbit, LAST, 0);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(shards_with_functions_merge) {
    char shards[2][300], whole[300];
    snprintf(whole, sizeof whole, "%s/whole", folder);
    for (int trend = 0; trend < 2; trend++) {
        for (int i = 0; i < 2; i++) {
            snprintf(shards[i], sizeof shards[i], "%s/shard%d%d", folder, trend, i);
            const toliman_track_options options =
                trend ? trend_options(shards[i], kEnd) : reduced_options(shards[i], orbit);
            fill_with(&options, 1 + i * 12, 15 + i * 15);
        }
        toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
        assert_ok(toliman_track_load_options(shards[1], &options));
        options.folder = whole;
        options.ledger.setup_folder = shards[1];
        options.grid.nf = 0;
        toliman_track *const track = make_track(&options);
        for (int i = 0; i < 2; i++)
            assert_ok(toliman_track_merge(track, shards[1 - i], 0, NULL));
        if (trend)
            assert_sums_with_trend(track, kEnd);
        else
            assert_sums_by_hand(track, orbit, LAST, 0);
        toliman_track_destroy(track);
        remove_folder(whole);
        for (int i = 0; i < 2; i++)
            remove_folder(shards[i]);
    }
}

TEST(bad_functions_are_refused) {
    static const struct {
        int32_t trend;
        double start, end, scale_sigma;
        const char *message;
    } cases[] = {{0, 0, 1, 0, "options->grid.trend_start"},
                 {1, 1, 1, 0, "options->grid.trend_start"},
                 {0, 0, 0, 0.1, "options->reduction.scale_sigma"}};
    toliman_track *none = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_track_options options = measured_options(NULL);
        options.grid.trend = cases[i].trend;
        options.grid.trend_start = cases[i].start;
        options.grid.trend_end = cases[i].end;
        options.reduction.scale_sigma = cases[i].scale_sigma;
        assert_invalid(toliman_track_create(&options, &none), cases[i].message);
    }
    toliman_track_options options = trend_options(NULL, kEnd);
    options.grid.flags = TOLIMAN_PERIOD_FIXED_MEAN;
    assert_invalid(toliman_track_create(&options, &none), "options->grid.flags");
}

/* Every byte of a setup with functions is covered by a check. */
TEST_IN_FOLDER(damage_to_the_setup_is_found) {
    fill_folder(orbit, 1, 3);
    const off_t size = size_of(setup);
    for (off_t at = 0; at < size; at += at < 400 ? 1 : 101) {
        flip_byte(setup, at);
        assert_int_equal(loaded_options(TOLIMAN_TRACK_READ_ONLY).grid.nf, 0);
        flip_byte(setup, at);
    }
    assert_int_equal(loaded_options(TOLIMAN_TRACK_READ_ONLY).grid.nf, FREQUENCIES);
}

RUN_TESTS(make_skies, destroy_skies)
