/* Tests the limit of chi-square of a folder: misfits stay out of the sums, whatever the order of arrival, also if the
 * limit moves with the median, and after kills, rebuilds, merges and quarantines. The expected set of frames is
 * computed from all chi-squares by sorting. */
#include "track_folder.h"

#include <toliman/track_goodness.h>

enum { FRAMES = 120 };

/* chi-square 8 for the first third, later about 1 with some of 3 (below 4 times the median) and of 9; one of 1e9 */
static double chi_square_of(int64_t id) {
    const double noise = 0.9 + 0.2 * (double)(mixed((uint64_t)id + 99) % 1000) / 1000;
    return id == 5 ? 1e9 : id <= FRAMES / 3 ? 8 * noise : id % 9 == 1 ? 9 : id % 9 == 2 ? 3 : noise;
}

static int32_t estimate(const toliman_estimate_input *input, toliman_estimate *made, void *unused) {
    (void)unused;
    const int64_t id = input->tai_ns / DAY_NS;
    made->values[0] = value_of(input->image, input->rows * input->cols);
    made->chi_square = id == 77 ? NAN : chi_square_of(id);
    return 0;
}

static toliman_track_options misfit_options(const char *where) {
    toliman_track_options options = small_options(where);
    options.estimator.estimate = estimate;
    return options;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int is_quarantined(int64_t id, int quarantines) {
    return quarantines && id % 13 == 4;
}

/* Whether a frame is valid and its value is within value_limit. */
static int counts(int64_t id, int quarantines) {
    small_frame frame;
    make_frame(&frame, id);
    return !is_quarantined(id, quarantines) && fabs(value_of_frame(&frame)) <= VALUE_LIMIT;
}

/* The limit for the frames first to last: 4 times their lower median, in [2, 100]. */
static double expected_limit(int64_t first, int64_t last, int quarantines) {
    double found[FRAMES];
    size_t count = 0;
    for (int64_t id = first; id <= last; id++)
        if (counts(id, quarantines) && id != 77)
            found[count++] = chi_square_of(id);
    qsort(found, count, sizeof *found, by_size);
    return fmin(100, fmax(2, 4 * found[(count - 1) / 2]));
}

static void assert_expected(const toliman_track *track, const toliman_track_options *options, int64_t first,
                            int64_t last, int quarantines, double limit) {
    toliman_period *clean = clean_period(options);
    int64_t accepted = 0, misfit = 0, outlier = 0, quarantined = 0;
    for (int64_t id = first; id <= last; id++) {
        const int is_misfit = id != 77 && chi_square_of(id) > limit;
        if (!counts(id, quarantines))
            is_quarantined(id, quarantines) ? quarantined++ : outlier++;
        else if (is_misfit)
            misfit++;
        else {
            push_clean(clean, id);
            accepted++;
        }
    }
    const toliman_track_info info = info_of(track);
    assert_int_equal(info.accepted, accepted);
    assert_int_equal(info.misfit, misfit);
    assert_int_equal(info.outlier, outlier);
    assert_int_equal(info.quarantined, quarantined);
    assert_int_equal(info.missing, 0);
    assert_int_equal(info.received, info.accepted + info.misfit + info.outlier + info.quarantined + info.repeated);
    assert_close(info.chi_limit, limit, 0.005, 0);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

static void push_in_order(toliman_track *track, const int64_t *ids, int count, int quarantines) {
    for (int i = 0; i < count; i++) {
        small_frame frame;
        make_frame(&frame, ids[i]);
        push_one(track, &frame.frame);
        if (!is_quarantined(ids[i], quarantines))
            continue;
        frame.pixels[0]++;
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    }
}

/* In memory and in folders that are saved in the middle and reopened from the ledger behind that checkpoint. */
/* promise: misfits-ignore-arrival-order */
TEST(any_order_gives_the_same_sums) {
    for (int seed = 0; seed < 12; seed++) {
        const int quarantines = seed % 3 == 1;
        uint64_t random = (uint64_t)seed;
        int64_t ids[FRAMES];
        for (int i = 0; i < FRAMES; i++)
            ids[i] = i + 1;
        for (uint64_t i = FRAMES - 1; seed > 1 && i > 0; i--) {
            const uint64_t k = draw(&random, i + 1);
            const int64_t other = ids[i];
            ids[i] = ids[k];
            ids[k] = other;
        }
        for (int on_disk = 0; on_disk < 2; on_disk++) {
            char where[256];
            make_folder(where, sizeof where);
            const toliman_track_options options = misfit_options(on_disk ? where : NULL);
            toliman_track *track = make_track(&options);
            push_in_order(track, ids, FRAMES / 2, quarantines);
            if (on_disk)
                assert_ok(toliman_track_save(track));
            push_in_order(track, ids + FRAMES / 2, FRAMES - FRAMES / 2, quarantines);
            const double limit = expected_limit(1, FRAMES, quarantines);
            assert_expected(track, &options, 1, FRAMES, quarantines, limit);
            assert_ok(toliman_track_commit(track));
            toliman_track_destroy(track);
            if (on_disk) {
                track = make_track(&options); /* the limit was another one at the checkpoint */
                assert_expected(track, &options, 1, FRAMES, quarantines, limit);
                toliman_track_destroy(track);
            }
            remove_folder(where);
        }
    }
}

/* After each frame, the tracker has what the frames so far give: also when the limit falls and when it rises. */
/* promise: misfits-ignore-arrival-order */
TEST(limit_follows_the_median) {
    const toliman_track_options options = misfit_options(NULL);
    toliman_track *up = make_track(&options), *down = make_track(&options);
    for (int64_t n = 1; n <= FRAMES; n++) {
        push_number(up, n);
        assert_expected(up, &options, 1, n, 0, expected_limit(1, n, 0));
        push_number(down, FRAMES + 1 - n);
        assert_expected(down, &options, FRAMES + 1 - n, FRAMES, 0, expected_limit(FRAMES + 1 - n, FRAMES, 0));
    }
    assert_same_periods(period_of(up), period_of(down));
    toliman_track_destroy(up), toliman_track_destroy(down);
}

TEST_IN_FOLDER(limit_of_a_folder_is_kept) {
    toliman_track_options options = misfit_options(folder);
    options.limits.chi_square = 5;
    toliman_track *track = make_track(&options), *none = NULL;
    push_range(track, 1, FRAMES);
    assert_expected(track, &options, 1, FRAMES, 0, 5);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);

    toliman_track_options known = {.struct_size = sizeof known};
    assert_ok(toliman_track_load_options(folder, &known));
    assert_true(known.limits.chi_square == 5);
    options.limits.chi_square = 0;
    track = make_track(&options);
    assert_expected(track, &options, 1, FRAMES, 0, 5);
    toliman_track_destroy(track);
    options.limits.chi_square = -1;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, setup);
    static const double limits[] = {-1, 9.5, 0.5, 1e10};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        options.limits.chi_square = limits[i];
        options.flags = TOLIMAN_TRACK_REBUILD;
        toliman_track_destroy(make_track(&options));
        options.limits.chi_square = 0;
        options.flags = 0;
        track = make_track(&options);
        assert_expected(track, &options, 1, FRAMES, 0, limits[i] > 0 ? limits[i] : expected_limit(1, FRAMES, 0));
        toliman_track_destroy(track);
    }
    static const double bad[] = {-2, NAN, INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        options.limits.chi_square = bad[i];
        assert_invalid(toliman_track_create(&options, &none), "options->limits.chi_square");
    }
}

/* promise: folders-merge-in-any-order */
TEST(shards_merge_to_the_whole) {
    char shard[256];
    make_folder(shard, sizeof shard);
    toliman_track_options options = misfit_options(shard);
    toliman_track *track = make_track(&options);
    push_range(track, 1, 60);
    assert_expected(track, &options, 1, 60, 0, expected_limit(1, 60, 0));
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    options.folder = NULL;
    track = make_track(&options);
    push_range(track, 50, FRAMES);
    assert_ok(toliman_track_merge(track, shard, 0, NULL));
    const toliman_track_info info = info_of(track);
    assert_true(info.repeated == 11 && info.missing == 0);
    toliman_track *whole = make_track(&options);
    push_range(whole, 1, FRAMES);
    assert_same_periods(period_of(track), period_of(whole));
    assert_int_equal(info_of(whole).misfit, info.misfit);
    toliman_track_destroy(whole), toliman_track_destroy(track);
    remove_folder(shard);
}

/* The shard has a misfit, which is none here, and a frame that is known here: equal numbers of other frames. */
/* promise: folders-merge-in-any-order */
TEST_IN_FOLDER(sums_of_other_frames_are_not_taken) {
    toliman_track_options options = misfit_options(folder);
    toliman_track *track = make_track(&options);
    push_range(track, 41, 60);
    assert_int_equal(info_of(track).misfit, 1);
    const int64_t accepted = info_of(track).accepted;
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    options.folder = NULL;
    track = make_track(&options);
    push_range(track, 1, 40);
    push_number(track, 45);
    const int64_t before = info_of(track).accepted;
    assert_ok(toliman_track_merge(track, folder, 0, NULL));
    assert_int_equal(info_of(track).accepted - before, accepted);
    toliman_track *whole = make_track(&options);
    push_range(whole, 1, 60);
    assert_same_periods(period_of(track), period_of(whole));
    toliman_track_destroy(whole), toliman_track_destroy(track);
}

/* The summary, against sums over the expected frames, and the verdict of a record that was reported as accepted. */
TEST_IN_FOLDER(goodness_of_the_folder) {
    const toliman_track_options options = misfit_options(folder);
    toliman_track *track = make_track(&options);
    assert_int_equal(push_number(track, 1), TOLIMAN_TRACK_VERDICT_ACCEPTED);
    push_range(track, 2, FRAMES);
    toliman_track_goodness found = TOLIMAN_TRACK_GOODNESS_INIT;
    assert_ok(toliman_track_query_goodness(track, &found));
    const double limit = expected_limit(1, FRAMES, 0);
    long double n = 0, t = 0, x = 0, tt = 0, tx = 0, first_year = 0, last_year = 0;
    double all[FRAMES];
    for (int64_t id = 1; id <= FRAMES; id++) {
        if (!counts(id, 0) || id == 77 || chi_square_of(id) > limit)
            continue;
        small_frame frame;
        make_frame(&frame, id);
        const long double year = (long double)frame.frame.camera_ns / (365.25L * DAY_NS);
        all[(int)n] = chi_square_of(id);
        first_year = n == 0 ? year : first_year;
        last_year = year;
        n += 1;
        t += year;
        x += chi_square_of(id);
        tt += year * year;
        tx += year * chi_square_of(id);
    }
    qsort(all, (size_t)n, sizeof *all, by_size);
    assert_int_equal(found.frames, (int64_t)n);
    assert_true(found.chi_square == all[((int)n - 1) / 2]);
    assert_true(isnan(found.chi_square_sigma) && found.goodness == TOLIMAN_GOODNESS_UNKNOWN);
    assert_close(found.trend_per_year, (double)((n * tx - t * x) / (n * tt - t * t)), 1e-9, 0);
    assert_true(found.trend_sigma_per_year > 0);
    assert_close(found.years, (double)(last_year - first_year), 1e-12, 0);
    assert_int_equal(found.misfit, info_of(track).misfit);
    assert_true(found.poor == 0 && found.too_good == 0 && found.bad_pixels == 0 && found.cleaned == 0);
    assert_true(found.is_calibrated == 0 && found.is_complete == 1);
    toliman_track_record first = {.struct_size = sizeof first};
    size_t done = 0;
    assert_ok(toliman_track_get_records(track, 0, 1, &first, &done));
    assert_int_equal(first.verdict, TOLIMAN_TRACK_VERDICT_MISFIT);
    assert_true(first.chi_square == chi_square_of(1) && first.goodness == TOLIMAN_GOODNESS_UNKNOWN);
    toliman_track_destroy(track);

    toliman_track_options strict = options;
    strict.folder = NULL;
    strict.limits.chi_square = 1e-3;
    track = make_track(&strict);
    push_range(track, 1, 3);
    assert_ok(toliman_track_query_goodness(track, &found));
    const double median = fmax(fmin(chi_square_of(1), chi_square_of(2)),
                               fmin(fmax(chi_square_of(1), chi_square_of(2)), chi_square_of(3)));
    assert_true(found.frames == 0 && found.misfit == 3 && found.chi_square == median);
    toliman_track_destroy(track);
}

RUN_TESTS(NULL, NULL)
