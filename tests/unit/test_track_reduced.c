/* Tests the reduction of separations to the orbit of a system while frames arrive: values against
 * toliman_sky_predict_mean, frames that wait for an observer file, intervals, and limits. */
#include "reduced_folder.h"

TEST_IN_FOLDER(values_are_measured_over_factor_minus_geometric) {
    toliman_sky *const skies[] = {earth, orbit};
    for (size_t sky = 0; sky < 2; sky++) {
        const toliman_track_options options = reduced_options(folder, skies[sky]);
        toliman_track *const track = make_track(&options), *memory = reduced_in_memory(skies[sky], 1, LAST);
        for (int64_t id = 1; id <= LAST; id++) {
            small_frame frame;
            make_exposed(&frame, id);
            const toliman_track_outcome outcome = push_one(track, &frame.frame);
            assert_close(outcome.value, value_by_hand(skies[sky], &frame), 0, 1e-14);
        }
        assert_sums_by_hand(track, skies[sky], LAST, 0);
        assert_same_periods(period_of(track), period_of(memory));
        assert_true(assert_counted(track).accepted > LAST / 2 && assert_counted(memory).accepted > LAST / 2);
        toliman_track_destroy(memory), toliman_track_destroy(track);
        remove_folder(folder);
        mkdir(folder, 0777);
    }
}

/* A clock that is fast by 1e-5 shifts both ends of 6000 s by 0.03 s, and the time of the frame by 0.3 s. */
TEST_IN_FOLDER(ends_of_intervals_go_through_the_clock) {
    const int64_t clock[] = {START_NS, START_NS, START_NS + 100000 * SECOND_NS, START_NS + 100001 * SECOND_NS};
    static const double pairs[] = {100, 1900, 3000, 3600.125, 5000, 6000};
    toliman_track_options options = reduced_options(NULL, orbit);
    options.clock.pairs = clock;
    options.clock.count = 2;
    toliman_track *const track = make_track(&options);
    small_frame frame;
    make_exposed(&frame, 30);
    frame.frame.exposure_s = 6000;
    frame.frame.intervals = pairs;
    frame.frame.interval_count = 3;
    const double found = push_one(track, &frame.frame).value, measured = base_px + value_of_frame(&frame);
    assert_close(found, reduced_by_hand(orbit, &frame.frame, measured, 1e-5), 0, 1e-14);
    toliman_frame shifted = frame.frame; /* as if only the time of the frame went through the clock */
    shifted.camera_ns += llround((double)(shifted.camera_ns - START_NS) * 1e-5);
    assert_true(fabs(found - reduced_by_hand(orbit, &shifted, measured, 0)) > 1e-12);
    toliman_track_destroy(track);
}

static void assert_unreduced(toliman_track *track, const small_frame *frame, int32_t reason) {
    const toliman_track_outcome outcome = push_one(track, &frame->frame);
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_UNREDUCED);
    assert_int_equal(outcome.reason, reason);
    assert_true(outcome.value == value_of_frame(frame)); /* the estimate */
    assert_int_equal(outcome.tai_ns, frame->frame.camera_ns);
}

/* promise: unknown-exposures-are-refused */
TEST_IN_FOLDER(frames_without_time_on_target_wait) {
    static const double day[] = {0, 500, 700, 1000}, points[] = {0, 1e-11, 0.5, 1};
    static const struct {
        double exposure_s;
        const double *pairs;
        size_t count;
        int32_t in_orbit, on_earth; /* reasons, 0 = accepted */
    } cases[] = {{0, NULL, 0, TOLIMAN_TRACK_REASON_NO_INTERVALS, 0},
                 {600, NULL, 0, 0, 0},
                 {600.001, NULL, 0, TOLIMAN_TRACK_REASON_NO_INTERVALS, 0},
                 {1000, day, 2, 0, 0},
                 {1000, day, 1, 0, 0},
                 {1, points, 1, TOLIMAN_TRACK_REASON_NO_INTERVALS, 0}, /* no length in ns */
                 {1, points, 2, TOLIMAN_TRACK_REASON_NO_INTERVALS, TOLIMAN_TRACK_REASON_NO_INTERVALS},
                 {4e7, NULL, 0, TOLIMAN_TRACK_REASON_NO_INTERVALS, TOLIMAN_TRACK_REASON_NO_INTERVALS}};
    const size_t count = sizeof cases / sizeof *cases;
    for (int in_orbit = 0; in_orbit < 2; in_orbit++) {
        const toliman_track_options options = reduced_options(in_orbit ? folder : NULL, in_orbit ? orbit : earth);
        toliman_track *const track = make_track(&options);
        int64_t waiting = 0;
        for (size_t i = 0; i < count; i++) {
            small_frame frame;
            make_exposed(&frame, 2 * (int64_t)i + 2);
            for (int k = 0; k < PIXELS; k++)
                frame.pixels[k] = 9; /* no outlier */
            frame.frame.dropped = 1;
            frame.frame.exposure_s = cases[i].exposure_s;
            frame.frame.intervals = cases[i].pairs;
            frame.frame.interval_count = cases[i].count;
            const int32_t reason = in_orbit ? cases[i].in_orbit : cases[i].on_earth;
            waiting += reason != 0;
            if (reason != 0)
                assert_unreduced(track, &frame, reason);
            else
                assert_true(push_one(track, &frame.frame).verdict != TOLIMAN_TRACK_VERDICT_UNREDUCED);
            assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
        }
        const toliman_track_info info = assert_counted(track);
        assert_int_equal(info.unreduced, waiting);
        assert_int_equal(info.repeated, count);
        assert_int_equal(info.received, 2 * count);
        assert_int_equal(info.missing, count - 1);
        assert_int_equal(info.dropped, count);
        assert_int_equal(records_with(track, TOLIMAN_TRACK_VERDICT_UNREDUCED, TOLIMAN_TRACK_REASON_NO_INTERVALS),
                         waiting);
        toliman_track_stream stream = {.struct_size = sizeof stream};
        size_t streams = 0;
        assert_ok(toliman_track_get_streams(track, &stream, 1, &streams));
        assert_int_equal(stream.frames, count);
        assert_int_equal(stream.missing, count - 1);
        toliman_track_destroy(track);
    }
}

/* Number of interval records of a frame with this many intervals. */
static int64_t parts_of(size_t intervals) {
    const size_t pairs = REDUCED_COLUMNS / 2;
    return (int64_t)((intervals + pairs - 1) / pairs);
}

TEST_IN_FOLDER(any_number_of_intervals_is_kept) {
    enum { MOST = 5000 };
    static double pairs[2 * MOST];
    static const size_t counts[] = {0, 1, 7, 8, 9, 10, 200, MOST};
    enum { FRAMES = sizeof counts / sizeof *counts };
    for (size_t i = 0; i < 2 * MOST; i++)
        pairs[i] = (double)i * 0.01 + (i % 2 == 0 ? 0.001 * (double)(i % 7) : 0);
    const toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *const track = make_track(&options);
    int64_t records = FRAMES;
    for (size_t i = 0; i < FRAMES; i++) {
        small_frame frame;
        make_exposed(&frame, (int64_t)i + 1);
        frame.frame.exposure_s = 100;
        frame.frame.intervals = counts[i] > 0 ? pairs : NULL;
        frame.frame.interval_count = counts[i];
        assert_close(push_one(track, &frame.frame).value, value_by_hand(orbit, &frame), 0, 1e-14);
        records += parts_of(counts[i]);
    }
    assert_int_equal(info_of(track).records, records);
    assert_int_equal(records_with(track, TOLIMAN_TRACK_VERDICT_INTERVALS, TOLIMAN_TRACK_REASON_NONE), records - FRAMES);
    double found[1000], factors[1000];
    size_t done = 0;
    assert_ok(toliman_track_get_column(track, "intervals", 0, 1000, found, &done));
    assert_int_equal(done, records);
    assert_ok(toliman_track_get_column(track, "factor", 0, 1000, factors, &done));
    for (size_t i = 0, at = 0; i < FRAMES; i++, at++) {
        for (int64_t part = 0; part < parts_of(counts[i]); part++, at++)
            assert_true(found[at] == 0 && isnan(factors[at]));
        assert_true(found[at] == (double)counts[i] && isfinite(factors[at]));
    }
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track), toliman_track_destroy(rebuild(other, 0));
    toliman_track *const back = rebuild(orbit, 0);
    assert_int_equal(info_of(back).records, records);
    const toliman_track_options memory = reduced_options(NULL, orbit);
    toliman_track *const expected = make_track(&memory);
    assert_ok(toliman_track_merge(expected, folder, 0, NULL));
    assert_same_periods(period_of(back), period_of(expected));
    assert_int_equal(info_of(back).unreduced, 0);
    toliman_track_destroy(expected), toliman_track_destroy(back);
}

/* Frame 4 has intervals; it is also quarantined in memory, and after the folder is reopened. */
/* promise: quarantines-retract-exactly */
TEST_IN_FOLDER(quarantine_retracts_the_reduced_value) {
    toliman_track *const memory = reduced_in_memory(orbit, 1, LAST);
    push_changed(memory, 4);
    assert_sums_by_hand(memory, orbit, LAST, 4);
    toliman_track_destroy(memory);
    fill_folder(orbit, 1, LAST);
    const toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *track = make_track(&options);
    push_changed(track, 4);
    assert_sums_by_hand(track, orbit, LAST, 4);
    assert_int_equal(assert_counted(track).quarantined, 1);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    track = open_reader();
    assert_sums_by_hand(track, orbit, LAST, 4);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(quarantine_of_an_unreduced_frame) {
    const toliman_track_options options = reduced_options(folder, predicted);
    toliman_track *track = make_track(&options);
    push_all_exposed(track, 1, LAST);
    const toliman_track_info before = assert_counted(track);
    assert_int_equal(before.unreduced,
                     records_with(track, TOLIMAN_TRACK_VERDICT_UNREDUCED, TOLIMAN_TRACK_REASON_NO_ORBIT));
    push_changed(track, 25);
    const toliman_track_info info = assert_counted(track);
    assert_int_equal(info.unreduced, before.unreduced - 1);
    assert_int_equal(info.accepted, before.accepted);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    track = rebuild(orbit, 0);
    assert_sums_by_hand(track, orbit, LAST, 25);
    assert_int_equal(assert_counted(track).quarantined, 1);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(readers_need_no_sky) {
    fill_folder(orbit, 1, LAST);
    const toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *const writer = make_track(&options), *const reader = open_reader();
    assert_same_periods(period_of(reader), period_of(writer));
    assert_string_equal(info_of(reader).system, info_of(writer).system);
    assert_true(info_of(reader).plate_scale_arcsec == SCALE);
    static toliman_track_record records[2][2 * LAST];
    size_t count = 0;
    for (int i = 0; i < 2; i++) {
        records[i]->struct_size = sizeof **records;
        assert_ok(toliman_track_get_records(i ? reader : writer, 0, 2 * LAST, records[i], &count));
    }
    assert_memory_equal(records[0], records[1], count * sizeof **records);
    toliman_period_peak peaks[2] = {TOLIMAN_PERIOD_PEAK_INIT, TOLIMAN_PERIOD_PEAK_INIT};
    assert_ok(toliman_track_query_fit(writer, &peaks[0]));
    assert_ok(toliman_track_query_fit(reader, &peaks[1]));
    assert_memory_equal(&peaks[0], &peaks[1], sizeof *peaks);
    toliman_track_destroy(reader), toliman_track_destroy(writer);
}

TEST_IN_FOLDER(another_reference_is_refused) {
    toliman_track *none = NULL;
    fill_folder(orbit, 1, LAST);
    toliman_track_options options = measured_options(folder);
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.sky");
    options = reduced_options(folder, other);
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, setup);
    options = reduced_options(folder, orbit);
    options.reduction.plate_scale_arcsec = 0.5;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, setup);
    options = loaded_options(TOLIMAN_TRACK_READ_ONLY);
    options.reduction.plate_scale_arcsec = 0.5;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, setup);
    options = measured_options(NULL);
    options.reduction.sky = orbit;
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.plate_scale_arcsec");
    options.reduction.sky = NULL;
    options.reduction.plate_scale_arcsec = SCALE;
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.plate_scale_arcsec");
    options = reduced_options(NULL, orbit);
    options.estimator.values[0] = 0;
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.sky");
}

/* An observer at the Earth's centre instead of one in orbit, effects that are left out, and another clock table without
 * the observer would each give other values without a message. */
TEST_IN_FOLDER(other_observers_and_clocks_are_refused) {
    toliman_track *none = NULL;
    toliman_sky *partial = NULL;
    fill_folder(orbit, 1, LAST);
    toliman_track_options options = reduced_options(folder, earth);
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, setup);
    toliman_sky_options without = TOLIMAN_SKY_OPTIONS_INIT;
    without.without = TOLIMAN_SKY_DEFLECTION;
    without.altitude_km = 600;
    assert_ok(toliman_sky_create("alpha-cen", &without, &partial));
    options = reduced_options(NULL, partial);
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.sky");
    static const int64_t later[2] = {0, 600000000000};
    options = loaded_options(TOLIMAN_TRACK_REBUILD);
    options.clock.pairs = later;
    options.clock.count = 1;
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.sky");
    toliman_sky_destroy(partial);
}

TEST_IN_FOLDER(limits_apply_to_the_reduced_value) {
    static const double sigmas[] = {1e-6, 1e-3}, limits[] = {0.25, 10};
    for (int i = 0; i < 2; i++) {
        toliman_track_options options = reduced_options(NULL, orbit);
        options.estimator.sigma = sigmas[i];
        options.limits.value = 0;
        toliman_track *const track = make_track(&options);
        assert_close(info_of(track).value_limit, limits[i], 1e-15, 0);
        toliman_track_destroy(track);
    }
    const double base = base_px;
    base_px += 2 * VALUE_LIMIT;
    toliman_track *const track = reduced_in_memory(orbit, 1, 6);
    base_px = base;
    const toliman_track_info info = assert_counted(track);
    assert_int_equal(info.accepted, 0); /* although the estimates are within the limit */
    assert_int_equal(info.outlier, 6);
    toliman_track_destroy(track);
}

static int32_t measure_nothing(const toliman_estimate_input *input, toliman_estimate *made, void *value) {
    measure(input, made, NULL);
    made->values[1] = *(const double *)value;
    return 0;
}

/* Such a frame could never be reduced. */
TEST_IN_FOLDER(separations_must_be_finite) {
    double bad[] = {NAN, INFINITY};
    for (int i = 0; i < 2; i++) {
        toliman_track_options options = reduced_options(NULL, orbit);
        options.estimator.estimate = measure_nothing;
        options.estimator.estimate_data = &bad[i];
        toliman_track *const track = make_track(&options);
        small_frame frame;
        make_exposed(&frame, 1);
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
        assert_int_equal(outcome.reason, TOLIMAN_TRACK_REASON_ESTIMATE);
        toliman_track_destroy(track);
    }
}

RUN_TESTS(make_skies, destroy_skies)
