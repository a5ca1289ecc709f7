/* Tests the interface of calibrations: arguments and their messages, results without convergence, scenes from which a
 * calibration cannot start, and saved scenes that contradict it. */
#include "calibrate_group.h"

/* Refusals. */

static void bad_options_are_refused(void **state) {
    (void)state;
    const struct {
        toliman_calibration_options options;
        const char *message;
    } cases[] = {
        {{.flags = 4}, "options->flags = 4: must be a combination of TOLIMAN_CALIBRATION_MAP and _IMPROVE"},
        {{.most_iterations = -1}, "options->most_iterations = -1: must be in [1, 1000], or 0 for 30"},
        {{.most_iterations = 1001}, "options->most_iterations = 1001: must be in [1, 1000], or 0 for 30"},
        {{.capture_px = -1}, "options->capture_px = -1: must be in [0.1, 64], or 0 for 6"},
        {{.capture_px = 64.5}, "options->capture_px = 64.5: must be"},
        {{.capture_px = NAN}, "options->capture_px = nan: must be"},
        {{.window_days = -1}, "options->window_days = -1: must be"},
        {{.window_days = NAN}, "options->window_days = nan: must be"},
        {{.smoothness = -1}, "options->smoothness = -1: must be"},
        {{.smoothness = INFINITY}, "options->smoothness = inf: must be"},
        {{.map_rms_nm = -1}, "options->map_rms_nm = -1: must be"},
        {{.map_rms_nm = NAN}, "options->map_rms_nm = nan: must be"},
        {{.free = "scal"}, "options->free: \"scal\": must be the name of a parameter; did you mean \"scale\"?"},
        {{.free = "scale;focus"}, "options->free: \"scale;focus\": must be the name of a parameter"},
        {{.free = "zernike_4"}, "options->free: \"zernike_4\": must be the name of a parameter"},
        {{.free = "zernike_5-37"}, "options->free: \"zernike_37\": must be the name of a parameter"},
        {{.free = "zernike_5-"}, "options->free: \"zernike_5-\": must end with a number"},
        {{.free = "zernike_5-7x"}, "options->free: \"zernike_5-7x\": must end with a number"},
        {{.free = "zernike_7-5"}, "options->free: \"zernike_7-5\": a range must go from a number to a larger one"},
        {{.free = "scale-3"}, "options->free: \"scale-3\": a range must go"},
        {{.free = "focus=0"}, "options->free: \"focus=0\": the standard deviation of a prior must be"},
        {{.free = "focus=-1"}, "options->free: \"focus=-1\": the standard deviation"},
        {{.free = "focus="}, "options->free: \"focus=\": the standard deviation"},
        {{.free = "focus=inf"}, "options->free: \"focus=inf\": the standard deviation"},
        {{.free = "focus=nan"}, "options->free: \"focus=nan\": the standard deviation"},
        {{.free = "focus=1=2"}, "options->free: \"focus=1=2\": the standard deviation"},
        {{.free = "focus=1nm"}, "options->free: \"focus=1nm\": the standard deviation"},
        {{.free = "focus, scale=1 focus"}, "options->free: \"focus\": must be named once"},
        {{.free = "zernike_7 zernike_5-8"}, "options->free: \"zernike_7\": must be named once"},
        {{.free = " shift_x"}, "options->free: \"shift_x\": is always free"},
        {{.free = "flux_b=1"}, "options->free: \"flux_b\": is always free"},
        {{.struct_size = 4}, "options->struct_size = 4"},
    };
    toliman_calibration *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_calibration_options options = cases[i].options;
        if (options.struct_size == 0)
            options.struct_size = sizeof options;
        assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                     TOLIMAN_E_ARGUMENT, cases[i].message);
    }
    static const char *const never[] = {"roll", "wavelength", "focus position_angle"};
    for (size_t i = 0; i < 3; i++) {
        const toliman_calibration_options options = {.struct_size = sizeof options, .free = never[i]};
        assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                       TOLIMAN_E_UNSUPPORTED, "options->free");
    }
    assert_invalid(toliman_calibration_create(NULL, PLAIN_IMAGE(frames), FRAMES, NULL, NULL, &made), "sim");
    assert_invalid(toliman_calibration_create(nominal, NULL, FRAMES, NULL, NULL, &made), "image");
    assert_invalid(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, NULL, NULL), "out");
    assert_invalid(toliman_calibration_create((const toliman_sim *)(const void *)whole, PLAIN_IMAGE(frames), FRAMES,
                                              NULL, NULL, &made),
                   "sim");
    assert_null(made);
}

static void bad_frames_are_refused(void **state) {
    (void)state;
    static double bad[2 * PIXELS];
    toliman_calibration *made = NULL;
    memcpy(bad, frames, sizeof bad);
    bad[PIXELS + 3 * SIDE + 7] = NAN;
    assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(bad), 2, NULL, NULL, &made), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[3][7] = nan");
    bad[PIXELS + 3 * SIDE + 7] = INFINITY;
    assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(bad), 2, NULL, NULL, &made), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[3][7] = inf");
    memset(bad + PIXELS, 0, PIXELS * sizeof *bad);
    assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(bad), 2, NULL, NULL, &made), TOLIMAN_E_ARGUMENT,
                 "frame 1: the stars are not found within ");
    for (size_t count = 0; count < 2; count++)
        assert_invalid(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), count, NULL, NULL, &made), "count");
    const toliman_image small = {.struct_size = sizeof small, .pixels = frames, .rows = 32, .cols = 32};
    assert_invalid(toliman_calibration_create(nominal, &small, 2, NULL, NULL, &made), "image->rows");
    toliman_fit_prediction predictions[2] = {{.struct_size = sizeof *predictions}};
    predictions[1].x_px = NAN;
    assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), 2, predictions, NULL, &made),
                 TOLIMAN_E_ARGUMENT, "frame 1: predictions->x_px = nan: must be finite");
    predictions[1].x_px = 7; /* beyond 6 px */
    assert_fails(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), 2, predictions, NULL, &made),
                 TOLIMAN_E_ARGUMENT, "frame 1: the stars are not found within options->capture_px = 6 px");
    assert_null(made);
}

static void unsuitable_scenes_are_refused(void **state) {
    (void)state;
    toliman_calibration *made = NULL;
    toliman_sim *other = sim_of(kSingleScene);
    assert_refused(toliman_calibration_create(other, PLAIN_IMAGE(frames), 2, NULL, NULL, &made), TOLIMAN_E_UNSUPPORTED,
                   "stars");
    toliman_sim_destroy(other);
    char *text = calibrate_text(NULL);
    const toliman_sim_options padded = {.struct_size = sizeof padded, .engine = TOLIMAN_SIM_ENGINE_PADDED_FFT};
    assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &padded, &other));
    assert_refused(toliman_calibration_create(other, PLAIN_IMAGE(frames), 2, NULL, NULL, &made), TOLIMAN_E_UNSUPPORTED,
                   "");
    toliman_sim_destroy(other);
    /* A mask that its cells' centres sample has no derivative by its rotation: refused if named, else left out. */
    text = replaced_again(text, "\"area\"", "\"cell\"");
    other = sim_of(text);
    toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus mask_rotation"};
    assert_refused(toliman_calibration_create(other, PLAIN_IMAGE(frames), 2, NULL, &options, &made),
                   TOLIMAN_E_UNSUPPORTED, "options->free");
    assert_null(made);
    options = (toliman_calibration_options){.struct_size = sizeof options, .most_iterations = 1};
    made = calibrated(other, frames, 2, &options);
    assert_int_equal(calibrate_info_of(made).parameters, DEFAULT - 1);
    toliman_calibration_destroy(made), toliman_sim_destroy(other), free(text);
}

static void defaults_are_zero(void **state) {
    (void)state;
    toliman_calibration_destroy(NULL);
}

static void bad_arguments_of_results_are_refused(void **state) {
    (void)state;
    toliman_calibration_info info = {.struct_size = 8};
    toliman_calibration_value value = {.struct_size = sizeof value};
    toliman_calibration_window window = {.struct_size = sizeof window};
    toliman_fit_result result = {.struct_size = sizeof result};
    static double numbers[PIXELS];
    assert_invalid(toliman_calibration_get_info(whole, &info), "out->struct_size");
    assert_invalid(toliman_calibration_get_info(whole, NULL), "out");
    assert_invalid(toliman_calibration_get_info(NULL, &info), "calibration");
    assert_refused(toliman_calibration_get_value(whole, 0, KNOWN, &value), TOLIMAN_E_RANGE, "index");
    assert_refused(toliman_calibration_get_value(whole, 0, -1, &value), TOLIMAN_E_RANGE, "index");
    assert_invalid(toliman_calibration_get_value(whole, 0, 0, NULL), "out");
    assert_refused(toliman_calibration_get_frame(whole, FRAMES, &result), TOLIMAN_E_RANGE, "index");
    assert_refused(toliman_calibration_get_frame(whole, -1, &result), TOLIMAN_E_RANGE, "index");
    assert_invalid(toliman_calibration_get_frame(whole, 0, NULL), "out");
    for (int64_t bad = -1; bad < 2; bad += 2) {
        const char *const message = bad < 0 ? "window" : "window";
        assert_refused(toliman_calibration_get_value(whole, bad, 0, &value), TOLIMAN_E_RANGE, message);
        assert_refused(toliman_calibration_get_window(whole, bad, &window), TOLIMAN_E_RANGE, message);
        assert_refused(toliman_calibration_get_covariance(whole, bad, numbers), TOLIMAN_E_RANGE, message);
        assert_refused(toliman_calibration_get_opd(whole, bad, numbers), TOLIMAN_E_RANGE, message);
        assert_refused(toliman_calibration_save_file(whole, bad, in_folder("bad.json")), TOLIMAN_E_RANGE, message);
    }
    assert_invalid(toliman_calibration_get_window(whole, 0, NULL), "out");
    assert_invalid(toliman_calibration_get_covariance(whole, 0, NULL), "covariance");
    assert_invalid(toliman_calibration_get_opd(whole, 0, NULL), "opd");
    assert_invalid(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_CHI, NULL, SIDE), "image");
    assert_invalid(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_CHI, numbers, SIDE - 1), "stride");
    assert_invalid(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_AFTER, NULL, SIDE), "image");
    assert_invalid(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_AFTER, numbers, SIDE - 1), "stride");
    assert_invalid(toliman_calibration_get_image(whole, 2, numbers, SIDE), "kind");
    assert_invalid(toliman_calibration_save_file(whole, 0, NULL), "path");
    assert_invalid(toliman_calibration_save_file(whole, 0, in_folder("scene.txt")), "path");
    assert_fails(toliman_calibration_save_file(whole, 0, in_folder("none/scene.json")), TOLIMAN_E_WRITE, "");
}

static void other_scenes_are_no_start(void **state) {
    (void)state;
    static const char *const places[][2] = {{"\"pupil_samples\": 32", "\"pupil_samples\": 48"},
                                            {"\"secondary_m\": 0.032", "\"secondary_m\": 0.03"},
                                            {"\"step_nm\": 55", "\"step_nm\": 27.5"},
                                            {"\"opd_nm\": 292.5", "\"opd_nm\": 290"},
                                            {"\"shape\": [40, 40]", "\"shape\": [36, 40]"}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char *const text = replaced_again(calibrate_text(NULL), places[i][0], places[i][1]);
        toliman_sim *const other = sim_of(text);
        const toliman_calibration_options options = {.struct_size = sizeof options, .start = other, .free = "focus"};
        toliman_calibration *made = NULL;
        assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                       TOLIMAN_E_MISMATCH, "options->start");
        assert_null(made);
        toliman_sim_destroy(other), free(text);
    }
}

/* Verdicts. */

static void without_convergence_every_value_is_nan(void **state) {
    (void)state;
    static double numbers[PIXELS];
    const toliman_calibration_options options = {.struct_size = sizeof options, .most_iterations = 1};
    toliman_calibration *const made = calibrated(nominal, frames, FRAMES, &options);
    const toliman_calibration_info info = calibrate_info_of(made);
    assert_int_equal(info.flags, TOLIMAN_CALIBRATION_NOT_CONVERGED);
    assert_true(isnan(info.chi_square_sigma) && isnan(info.structure) && isnan(info.separation_sigma_px));
    assert_true(isnan(info.calibration_sigma_px) && info.iterations == 1);
    for (int32_t i = 0; i < KNOWN; i++) {
        const toliman_calibration_value value = calibrate_value_of(made, 0, i);
        assert_true(isnan(value.value) && isnan(value.sigma) && value.prior_sigma > 0);
    }
    assert_ok(toliman_calibration_get_covariance(made, 0, numbers));
    for (int i = 0; i < KNOWN * KNOWN; i++)
        assert_true(isnan(numbers[i]));
    assert_ok(toliman_calibration_get_opd(made, 0, numbers));
    assert_true(isnan(numbers[CELLS * CELLS / 2 + 5]));
    assert_ok(toliman_calibration_get_image(made, TOLIMAN_CALIBRATION_IMAGE_CHI, numbers, SIDE));
    assert_true(isnan(numbers[0]) && isnan(numbers[PIXELS - 1]));
    assert_ok(toliman_calibration_get_image(made, TOLIMAN_CALIBRATION_IMAGE_AFTER, numbers, SIDE));
    assert_true(isnan(numbers[0]) && isnan(numbers[PIXELS - 1]));
    toliman_calibration_window window = {.struct_size = sizeof window};
    assert_ok(toliman_calibration_get_window(made, 0, &window));
    assert_true(isnan(window.chi_square) && window.frames == FRAMES);
    const toliman_fit_result frame = calibrate_frame_of(made, 0);
    assert_true(isnan(frame.separation_px) && isnan(frame.separation_sigma_px) && isnan(frame.chi_square));
    assert_int_equal(frame.flags, TOLIMAN_FIT_NOT_CONVERGED);
    assert_refused(toliman_calibration_save_file(made, 0, in_folder("none.json")), TOLIMAN_E_UNSUPPORTED,
                   "calibration");
    toliman_calibration_destroy(made);
}

/* Saved scenes. */

static char *text_of(const char *path) {
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    char *const text = calloc(1, 20000);
    assert_non_null(text);
    assert_true(fread(text, 1, 19999, file) > 0);
    fclose(file);
    return text;
}

/* Its group `calibration` states what belongs to the model. */
static void contradictions_of_saved_scenes_are_refused(void **state) {
    (void)state;
    assert_ok(toliman_calibration_save_file(whole, 0, in_folder("fitted.json")));
    char *const text = text_of(in_folder("fitted.json"));
    char *const group = strstr(text, "\"calibration\":");
    assert_non_null(group);
    for (size_t i = 0; i < 2; i++) {
        char *const place = strstr(group, i == 0 ? "32" : "area"), kept[5] = {0};
        assert_non_null(place);
        memcpy(kept, place, 4);
        memcpy(place, i == 0 ? "50" : "cell", i == 0 ? 2 : 4);
        toliman_sim *sim = NULL;
        assert_fails(toliman_sim_create_json(text, strlen(text), NULL, NULL, &sim), TOLIMAN_E_SCENE, "calibration");
        assert_null(sim);
        memcpy(place, kept, 4);
    }
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_options_are_refused),
                                       cmocka_unit_test(bad_frames_are_refused),
                                       cmocka_unit_test(unsuitable_scenes_are_refused),
                                       cmocka_unit_test(defaults_are_zero),
                                       cmocka_unit_test(bad_arguments_of_results_are_refused),
                                       cmocka_unit_test(other_scenes_are_no_start),
                                       cmocka_unit_test(without_convergence_every_value_is_nan),
                                       cmocka_unit_test(contradictions_of_saved_scenes_are_refused)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
