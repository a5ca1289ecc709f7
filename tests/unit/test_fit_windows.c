/* Tests fits with windows of time: a frame at the start of a window has the bits of the fit of its scene, frames
 * between are fitted with the mean of two; no step in time; digests; refusals. */
#include "images.h"
#include "scene_text.h"

#include <toliman/bank.h>
#include <toliman/fit.h>

enum { SIDE = 64, PIXELS = SIDE * SIDE, WINDOWS = 3, FRAMES = 6 };

static const double kStarts[WINDOWS] = {10, 20, 40}, kTimes[FRAMES] = {-5, 10, 10, 20, 40, 1e4};
static const size_t kWindows[FRAMES] = {0, 0, 0, 1, 2, 2}; /* that start at kTimes */

static toliman_sim *sims[WINDOWS];
static double frames[FRAMES * PIXELS];

/* With another depth of the mask and another scale, which need another number of samples of the model images. */
static toliman_sim *scene_of(const char *opd_nm, const char *scale) {
    char *const text = replaced_again(replaced(kBinaryScene, "297.5", opd_nm), "0.2}", scale);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

FIXTURE(set_up) {
    sims[0] = sim_of(kBinaryScene);
    sims[1] = scene_of("290", "0.2002}");
    sims[2] = scene_of("285", "0.21}");
    assert_ok(toliman_sim_frame(sims[1], NULL, 3, 0, FRAMES, frames));
    return 0;
}

FIXTURE(tear_down) {
    for (size_t i = 0; i < WINDOWS; i++)
        toliman_sim_destroy(sims[i]);
    return 0;
}

static size_t largest_of(const double *image, size_t count) {
    size_t largest = 0;
    for (size_t i = 1; i < count; i++)
        largest = image[i] > image[largest] ? i : largest;
    return largest;
}

static toliman_fit *windows_of(const double *starts, size_t count) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "scale", .capture_px = 3};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *const *)sims, starts, count, &options, &fit));
    return fit;
}

static toliman_fit *single(size_t window) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "scale", .capture_px = 3};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sims[window]}, NULL, 1, &options, &fit));
    return fit;
}

static toliman_fit_info info_of(const toliman_fit *fit) {
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_get_info(fit, &info));
    return info;
}

TEST(frames_at_starts_have_the_bits_of_their_window) {
    toliman_fit *const all = windows_of(kStarts, WINDOWS);
    toliman_fit_prediction predictions[FRAMES];
    toliman_fit_result results[FRAMES] = {{.struct_size = sizeof *results}};
    for (size_t i = 0; i < FRAMES; i++)
        predictions[i] = (toliman_fit_prediction){.struct_size = sizeof *predictions, .time_days = kTimes[i]};
    assert_ok(toliman_fit_frame(all, PLAIN_IMAGE(frames), FRAMES, predictions, results, NULL, NULL));
    for (size_t i = 0; i < FRAMES; i++) {
        toliman_fit *const one = single(kWindows[i]);
        toliman_fit_result result = {.struct_size = sizeof result}, again = result;
        static double expected[PIXELS], image[PIXELS];
        double values[8], bounds[8];
        assert_ok(toliman_fit_frame(one, PLAIN_IMAGE(frames + i * PIXELS), 1, &predictions[i], &result, NULL, NULL));
        assert_ok(toliman_fit_frame(all, PLAIN_IMAGE(frames + i * PIXELS), 1, &predictions[i], &again, NULL, NULL));
        assert_memory_equal(&result, &again, sizeof result);
        results[i].struct_size = sizeof result;
        assert_memory_equal(&result, &results[i], sizeof result);
        assert_ok(toliman_fit_predict(one, &predictions[i], expected, SIDE, values, NULL));
        assert_ok(toliman_fit_predict(all, &predictions[i], image, SIDE, bounds, NULL));
        assert_memory_equal(expected, image, sizeof image);
        assert_memory_equal(values, bounds, sizeof values);
        toliman_fit_destroy(one);
    }
    toliman_fit_destroy(all);
}

/* With both stars at the same places in both scenes: their images are means, whose weights are linear in time. */
TEST(images_are_interpolated_between_starts) {
    static double first[PIXELS], next[PIXELS], image[PIXELS], values[2][8], value[8];
    toliman_fit *const all = windows_of(kStarts, WINDOWS), *const one = single(0), *const two = single(1);
    toliman_fit_prediction at = {.struct_size = sizeof at, .separation_px = 20, .position_angle_deg = 30};
    assert_ok(toliman_fit_predict(one, &at, first, SIDE, values[0], NULL));
    assert_ok(toliman_fit_predict(two, &at, next, SIDE, values[1], NULL));
    const double peak = fabs(first[largest_of(first, PIXELS)]);
    for (int i = 0; i <= 8; i++) {
        const double share = i / 8.0;
        at.time_days = kStarts[0] + share * (kStarts[1] - kStarts[0]);
        assert_ok(toliman_fit_predict(all, &at, image, SIDE, value, NULL));
        for (size_t k = 0; k < PIXELS; k++)
            assert_close(image[k], (1 - share) * first[k] + share * next[k], 0, 1e-12 * peak);
        assert_close(value[0], 20, 1e-12, 0);
    }
    /* Places that the scene predicts are interpolated, too: the separation in px changes with the scale. */
    at = (toliman_fit_prediction){.struct_size = sizeof at, .time_days = 0.5 * (kStarts[0] + kStarts[1])};
    assert_ok(toliman_fit_predict(one, &at, NULL, 0, values[0], NULL));
    assert_ok(toliman_fit_predict(two, &at, NULL, 0, values[1], NULL));
    assert_ok(toliman_fit_predict(all, &at, NULL, 0, value, NULL));
    assert_true(fabs(values[0][0] - values[1][0]) > 1e-2);
    assert_close(value[0], 0.5 * (values[0][0] + values[1][0]), 1e-12, 0);
    toliman_fit_destroy(one), toliman_fit_destroy(two), toliman_fit_destroy(all);
}

/* The image between two depths of the mask against that of a scene with their mean: the error falls by 4 if the
 * difference is halved. */
/* promise: windows-err-in-second-order */
TEST(interpolation_has_an_error_of_second_order) {
    static const char *const depths[][2] = {{"293.5", "301.5"}, {"295.5", "299.5"}};
    static double exact[PIXELS], image[PIXELS], errors[2];
    toliman_fit *const middle = single(0);
    const toliman_fit_prediction at = {.struct_size = sizeof at, .time_days = 15};
    assert_ok(toliman_fit_predict(middle, &at, exact, SIDE, NULL, NULL));
    toliman_fit_destroy(middle);
    for (size_t i = 0; i < 2; i++) {
        toliman_sim *const ends[] = {scene_of(depths[i][0], "0.2}"), scene_of(depths[i][1], "0.2}")};
        const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = 3};
        toliman_fit *between = NULL;
        assert_ok(toliman_fit_create((const toliman_sim *const *)ends, kStarts, 2, &options, &between));
        assert_ok(toliman_fit_predict(between, &at, image, SIDE, NULL, NULL));
        for (size_t k = 0; k < PIXELS; k++)
            errors[i] = fmax(errors[i], fabs(image[k] - exact[k]));
        toliman_fit_destroy(between), toliman_sim_destroy(ends[0]), toliman_sim_destroy(ends[1]);
    }
    assert_close(errors[0] / errors[1], 4, 0.1, 0);
    print_message("largest error, relative to the peak: %.2e\n", errors[0] / exact[largest_of(exact, PIXELS)]);
    assert_at_most(errors[0], 0.02 * exact[largest_of(exact, PIXELS)]);
}

TEST(properties_are_those_of_all_windows) {
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
    assert_int_equal(info_of(all).parameters, 8);
    toliman_fit_destroy(all), toliman_fit_destroy(first);
}

TEST(digests_cover_starts_and_scenes) {
    static const double starts[][WINDOWS] = {{10, 20, 40}, {10, 20, 41}, {10, 21, 40}, {9, 20, 40}};
    const double alone[] = {9};
    toliman_fit *const all = windows_of(kStarts, WINDOWS), *const two = windows_of(kStarts, 2);
    assert_true(info_of(two).digest != info_of(all).digest);
    for (size_t i = 0; i < 4; i++) {
        toliman_fit *const other = windows_of(starts[i], WINDOWS);
        assert_true((info_of(other).digest == info_of(all).digest) == (i == 0));
        toliman_fit_destroy(other);
    }
    /* The start of a single window has no effect. */
    toliman_fit *const one = windows_of(alone, 1), *const first = windows_of(kStarts, 1);
    assert_true(info_of(one).digest == info_of(first).digest);
    toliman_fit_destroy(one), toliman_fit_destroy(first), toliman_fit_destroy(two), toliman_fit_destroy(all);
}

TEST(bad_windows_are_refused) {
    const struct {
        double starts[2];
        size_t count;
        const char *field;
    } cases[] = {{{0, 1}, 0, "count"},
                 {{0, 0}, 2, "first_days[1]"},
                 {{5, 2}, 2, "first_days[1]"},
                 {{NAN, 2}, 2, "first_days[0]"},
                 {{0, INFINITY}, 2, "first_days[1]"}};
    const toliman_sim *const *const given = (const toliman_sim *const *)sims;
    toliman_fit *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_invalid(toliman_fit_create(given, cases[i].starts, cases[i].count, NULL, &made), cases[i].field);
    const toliman_sim *const missing[] = {sims[0], NULL};
    assert_invalid(toliman_fit_create(missing, kStarts, 2, NULL, &made), "sims[1]");
    assert_invalid(toliman_fit_create(NULL, kStarts, 2, NULL, &made), "sims");
    assert_invalid(toliman_fit_create(given, NULL, 2, NULL, &made), "first_days");
    assert_invalid(toliman_fit_create(given, kStarts, 2, NULL, NULL), "out");
    assert_null(made);
}

TEST(scenes_that_differ_are_refused) {
    static const char *const changes[][3] = {{"[64, 64]", "[64, 72]", "sims[1]"},
                                             {"\"position_angle_deg\": 30", "\"position_angle_deg\": 31", "sims[1]"},
                                             {"\"interval_days\": 2", "\"interval_days\": 3", "sims[1]"}};
    toliman_fit *made = NULL;
    for (size_t i = 0; i < 3; i++) {
        toliman_sim *const other = sim_with(kBinaryScene, changes[i][0], changes[i][1]);
        const toliman_sim *const pair[] = {sims[0], other};
        assert_refused(toliman_fit_create(pair, kStarts, 2, NULL, &made), TOLIMAN_E_MISMATCH, changes[i][2]);
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
TEST(progress_is_that_of_all_windows) {
    double largest = 0;
    const toliman_fit_options options = {
        .struct_size = sizeof options, .capture_px = 3, .progress = record, .progress_data = &largest};
    toliman_fit *made = NULL;
    assert_refused(toliman_fit_create((const toliman_sim *const *)sims, kStarts, 3, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    assert_true(largest > 0.5 && largest < 0.9);
    assert_null(made);
}

TEST(banks_need_one_scene) {
    toliman_fit *const all = windows_of(kStarts, WINDOWS);
    toliman_bank *bank = NULL;
    assert_refused(toliman_bank_create(all, NULL, &bank), TOLIMAN_E_UNSUPPORTED, "fit");
    assert_null(bank);
    toliman_fit_destroy(all);
}

RUN_TESTS(set_up, tear_down)
