/* Tests fits with windows of time: each frame has the bits of the fit of its window's scene; digests; refusals. */
#include "images.h"
#include "scene_text.h"

#include <toliman/bank.h>
#include <toliman/fit.h>

enum { SIDE = 64, PIXELS = SIDE * SIDE, WINDOWS = 3, FRAMES = 6 };

static const double kStarts[WINDOWS] = {10, 20, 40}, kTimes[FRAMES] = {-5, 10, 19.999, 20, 40, 1e4};
static const size_t kWindows[FRAMES] = {0, 0, 0, 1, 2, 2}; /* those of kTimes */

static toliman_sim *sims[WINDOWS];
static double frames[FRAMES * PIXELS];

/* With another depth of the mask and another scale, which need another number of samples of the model images. */
static toliman_sim *scene_of(const char *opd_nm, const char *scale) {
    char *const text = replaced_again(replaced(kBinaryScene, "297.5", opd_nm), "0.2}", scale);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

static int set_up(void **unused) {
    (void)unused;
    sims[0] = sim_of(kBinaryScene);
    sims[1] = scene_of("290", "0.2002}");
    sims[2] = scene_of("285", "0.21}");
    assert_ok(toliman_sim_frame_many(sims[1], NULL, 3, 0, FRAMES, 1, frames));
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    for (size_t i = 0; i < WINDOWS; i++)
        toliman_sim_destroy(sims[i]);
    return 0;
}

static toliman_fit *windows_of(const double *starts, size_t count) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "scale", .capture_px = 3};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create_windows((const toliman_sim *const *)sims, starts, count, &options, &fit));
    return fit;
}

static toliman_fit *single(size_t window) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "scale", .capture_px = 3};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create(sims[window], &options, &fit));
    return fit;
}

static toliman_fit_info info_of(const toliman_fit *fit) {
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_get_info(fit, &info));
    return info;
}

static void frames_have_the_bits_of_their_window(void **state) {
    (void)state;
    toliman_fit *const all = windows_of(kStarts, WINDOWS);
    toliman_fit_prediction predictions[FRAMES];
    toliman_fit_result results[FRAMES] = {{.struct_size = sizeof *results}};
    for (size_t i = 0; i < FRAMES; i++)
        predictions[i] = (toliman_fit_prediction){.struct_size = sizeof *predictions, .time_days = kTimes[i]};
    assert_ok(toliman_fit_frames(all, PLAIN_IMAGE(frames), FRAMES, predictions, 3, results));
    for (size_t i = 0; i < FRAMES; i++) {
        toliman_fit *const one = single(kWindows[i]);
        toliman_fit_result result = {.struct_size = sizeof result}, again = result;
        static double expected[PIXELS], image[PIXELS];
        double values[8], bounds[8];
        assert_ok(toliman_fit_frame(one, frames + i * PIXELS, SIDE, &predictions[i], &result, NULL, NULL));
        assert_ok(toliman_fit_frame(all, frames + i * PIXELS, SIDE, &predictions[i], &again, NULL, NULL));
        assert_memory_equal(&result, &again, sizeof result);
        results[i].struct_size = sizeof result;
        assert_memory_equal(&result, &results[i], sizeof result);
        assert_ok(toliman_fit_predict(one, &predictions[i], expected, SIDE, values, NULL));
        assert_ok(toliman_fit_predict(all, &predictions[i], image, SIDE, bounds, NULL));
        assert_memory_equal(expected, image, sizeof image);
        assert_memory_equal(values, bounds, sizeof values);
        toliman_fit_destroy(one);
    }
    assert_true(results[2].chi_square != results[3].chi_square);
    toliman_fit_destroy(all);
}

static void properties_are_those_of_all_windows(void **state) {
    (void)state;
    toliman_fit *const all = windows_of(kStarts, WINDOWS), *const first = windows_of(kStarts, 1);
    uint32_t images = 0;
    double error = 0;
    for (size_t i = 0; i < WINDOWS; i++) {
        toliman_fit *const one = single(i);
        const toliman_fit_info info = info_of(one);
        images += info.images;
        error = fmax(error, info.image_error);
        assert_true((info.digest == info_of(first).digest) == (i == 0));
        assert_true(info.digest != info_of(all).digest);
        toliman_fit_destroy(one);
    }
    assert_int_equal(info_of(all).images, images);
    assert_true(info_of(all).image_error >= error && info_of(all).image_error <= error);
    assert_int_equal(toliman_fit_parameter_count(all), 8);
    toliman_fit_destroy(all);
    toliman_fit_destroy(first);
}

static void digests_cover_starts_and_scenes(void **state) {
    (void)state;
    static const double starts[][WINDOWS] = {{10, 20, 40}, {10, 20, 41}, {10, 21, 40}, {9, 20, 40}};
    toliman_fit *const all = windows_of(kStarts, WINDOWS), *const two = windows_of(kStarts, 2);
    assert_true(info_of(two).digest != info_of(all).digest);
    for (size_t i = 0; i < 4; i++) {
        toliman_fit *const other = windows_of(starts[i], WINDOWS);
        /* The start of the first window has no effect. */
        assert_true((info_of(other).digest == info_of(all).digest) == (i == 0 || i == 3));
        toliman_fit_destroy(other);
    }
    toliman_fit_destroy(two);
    toliman_fit_destroy(all);
}

static void bad_windows_are_refused(void **state) {
    (void)state;
    const struct {
        double starts[2];
        size_t count;
        const char *message;
    } cases[] = {{{0, 1}, 0, "count = 0: must be at least 1"},
                 {{0, 0}, 2, "first_days[1] = 0: must be above first_days[0] = 0"},
                 {{5, 2}, 2, "first_days[1] = 2: must be above first_days[0] = 5"},
                 {{NAN, 2}, 2, "first_days[0] = nan: must be finite"},
                 {{0, INFINITY}, 2, "first_days[1] = inf: must be finite"}};
    const toliman_sim *const *const given = (const toliman_sim *const *)sims;
    toliman_fit *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_fails(toliman_fit_create_windows(given, cases[i].starts, cases[i].count, NULL, &made),
                     TOLIMAN_E_ARGUMENT, cases[i].message);
    const toliman_sim *const missing[] = {sims[0], NULL};
    assert_fails(toliman_fit_create_windows(missing, kStarts, 2, NULL, &made), TOLIMAN_E_ARGUMENT, "sims[1] is NULL");
    assert_fails(toliman_fit_create_windows(NULL, kStarts, 2, NULL, &made), TOLIMAN_E_ARGUMENT, "sims is NULL");
    assert_fails(toliman_fit_create_windows(given, NULL, 2, NULL, &made), TOLIMAN_E_ARGUMENT, "first_days is NULL");
    assert_fails(toliman_fit_create_windows(given, kStarts, 2, NULL, NULL), TOLIMAN_E_ARGUMENT, "out is NULL");
    assert_null(made);
}

static void scenes_that_differ_are_refused(void **state) {
    (void)state;
    static const char *const changes[][3] = {
        {"[64, 64]", "[64, 72]", "sims[1]: scene: detector.shape: must be that of scene"},
        {"\"position_angle_deg\": 30", "\"position_angle_deg\": 31", "sims[1]: scene: binary: must be that of scene"},
        {"\"interval_days\": 2", "\"interval_days\": 3", "sims[1]: scene: cadence: must be that of scene"}};
    toliman_fit *made = NULL;
    for (size_t i = 0; i < 3; i++) {
        toliman_sim *const other = sim_with(kBinaryScene, changes[i][0], changes[i][1]);
        const toliman_sim *const pair[] = {sims[0], other};
        assert_fails(toliman_fit_create_windows(pair, kStarts, 2, NULL, &made), TOLIMAN_E_MISMATCH, changes[i][2]);
        toliman_sim_destroy(other);
    }
    assert_null(made);
}

static int32_t record(const char *stage, double fraction, void *largest) {
    (void)stage;
    assert_true(fraction >= *(double *)largest - 1e-12);
    *(double *)largest = fraction;
    return fraction > 0.5;
}

/* The fractions increase over all windows. */
static void progress_is_that_of_all_windows(void **state) {
    (void)state;
    double largest = 0;
    const toliman_fit_options options = {
        .struct_size = sizeof options, .capture_px = 3, .progress = record, .progress_data = &largest};
    toliman_fit *made = NULL;
    assert_fails(toliman_fit_create_windows((const toliman_sim *const *)sims, kStarts, 3, &options, &made),
                 TOLIMAN_E_CANCELLED, "cancelled by the progress callback");
    assert_true(largest > 0.5 && largest < 0.9);
    assert_null(made);
}

static void banks_need_one_scene(void **state) {
    (void)state;
    toliman_fit *const all = windows_of(kStarts, WINDOWS);
    toliman_bank *bank = NULL;
    assert_fails(toliman_bank_create(all, NULL, &bank), TOLIMAN_E_UNSUPPORTED,
                 "fit: has 3 windows: a bank needs the fit of one scene");
    assert_null(bank);
    toliman_fit_destroy(all);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_have_the_bits_of_their_window),
        cmocka_unit_test(properties_are_those_of_all_windows),
        cmocka_unit_test(digests_cover_starts_and_scenes),
        cmocka_unit_test(bad_windows_are_refused),
        cmocka_unit_test(scenes_that_differ_are_refused),
        cmocka_unit_test(progress_is_that_of_all_windows),
        cmocka_unit_test(banks_need_one_scene),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
