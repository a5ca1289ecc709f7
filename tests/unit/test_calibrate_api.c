/* Tests the interface of calibrations: arguments and their messages, results without convergence, scenes from which a
 * calibration cannot start, and saved scenes that contradict it. */
#include "calibrate_group.h"

static toliman_status create(const toliman_sim *sim, const toliman_calibration_options *options,
                             toliman_calibration **out) {
    return toliman_calibration_create(sim, PLAIN_IMAGE(frames), FRAMES, NULL, options, out);
}

TEST(bad_options_are_refused) {
    const struct {
        toliman_calibration_options options;
        const char *field;
    } cases[] = {{{.flags = 8}, "options->flags"},
                 {{.most_iterations = -1}, "options->most_iterations"},
                 {{.struct_size = 4}, "options->struct_size"}};
    toliman_calibration *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_calibration_options options = cases[i].options;
        if (options.struct_size == 0)
            options.struct_size = sizeof options;
        assert_invalid(create(nominal, &options, &made), cases[i].field);
    }
    static const char *const lists[] = {"scal",
                                        "scale;focus",
                                        "zernike_4",
                                        "zernike_5-37",
                                        "zernike_5-",
                                        "zernike_5-7x",
                                        "zernike_7-5",
                                        "scale-3",
                                        "focus=0",
                                        "focus=-1",
                                        "focus=",
                                        "focus=inf",
                                        "focus=nan",
                                        "focus=1=2",
                                        "focus=1nm",
                                        " shift_x",
                                        "flux_b=1",
                                        "roll",
                                        "wavelength",
                                        "focus, scale=1 focus",
                                        "focus position_angle",
                                        "zernike_7 zernike_5-8"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        const toliman_calibration_options options = {.struct_size = sizeof options, .free = lists[i]};
        const int moves = strstr("roll wavelength focus position_angle", lists[i]) != NULL;
        assert_refused(create(nominal, &options, &made), moves ? TOLIMAN_E_UNSUPPORTED : TOLIMAN_E_ARGUMENT,
                       "options->free");
    }
    assert_invalid(create(NULL, NULL, &made), "sim");
    assert_invalid(create((const toliman_sim *)(const void *)whole, NULL, &made), "sim");
    assert_invalid(create(nominal, NULL, NULL), "out");
    assert_invalid(toliman_calibration_create(nominal, NULL, FRAMES, NULL, NULL, &made), "image");
    assert_null(made);
    toliman_calibration_destroy(NULL);
}

TEST(bad_frames_are_refused) {
    static double bad[3][2 * PIXELS]; /* NaN, infinity, no stars */
    for (size_t i = 0; i < 3; i++)
        memcpy(bad[i], frames, (i < 2 ? 2u : 1u) * PIXELS * sizeof **bad);
    bad[0][PIXELS + 3 * SIDE + 7] = NAN;
    bad[1][PIXELS + 3 * SIDE + 7] = INFINITY;
    const toliman_fit_prediction lost[2] = {{.struct_size = sizeof *lost}, {.x_px = NAN}};
    const toliman_fit_prediction far[2] = {{.struct_size = sizeof *far}, {.x_px = 7}}; /* beyond 6 px */
    const toliman_image small = {.struct_size = sizeof small, .pixels = frames, .rows = 32, .cols = 32};
    const struct {
        const toliman_image *image;
        size_t count;
        const toliman_fit_prediction *predictions;
        const char *text; /* with the number of the frame */
    } cases[] = {{PLAIN_IMAGE(bad[0]), 2, NULL, "frame 1: counts[3][7] = nan"},
                 {PLAIN_IMAGE(bad[1]), 2, NULL, "frame 1: counts[3][7] = inf"},
                 {PLAIN_IMAGE(bad[2]), 2, NULL, "frame 1: the stars are not found"},
                 {PLAIN_IMAGE(frames), 2, lost, "frame 1: predictions->x_px = nan"},
                 {PLAIN_IMAGE(frames), 2, far, "frame 1: the stars are not found within options->capture_px = 6 px"},
                 {PLAIN_IMAGE(frames), 0, NULL, "count"},
                 {PLAIN_IMAGE(frames), 1, NULL, "count"},
                 {&small, 2, NULL, "image->rows"}};
    toliman_calibration *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_fails(
            toliman_calibration_create(nominal, cases[i].image, cases[i].count, cases[i].predictions, NULL, &made),
            TOLIMAN_E_ARGUMENT, cases[i].text);
    assert_null(made);
}

TEST(unsuitable_scenes_are_refused) {
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

TEST(bad_arguments_of_results_are_refused) {
    toliman_calibration_info info = {.struct_size = 8};
    toliman_calibration_value value = {.struct_size = sizeof value};
    toliman_calibration_window window = {.struct_size = sizeof window};
    toliman_fit_result result = {.struct_size = sizeof result};
    static double numbers[PIXELS];
    assert_invalid(toliman_calibration_get_info(whole, &info), "out->struct_size");
    assert_invalid(toliman_calibration_get_info(whole, NULL), "out");
    assert_invalid(toliman_calibration_get_info(NULL, &info), "calibration");
    assert_invalid(toliman_calibration_get_value(whole, 0, 0, NULL), "out");
    assert_invalid(toliman_calibration_get_frame(whole, 0, NULL), "out");
    assert_invalid(toliman_calibration_get_window(whole, 0, NULL), "out");
    assert_invalid(toliman_calibration_get_covariance(whole, 0, NULL), "covariance");
    assert_invalid(toliman_calibration_get_opd(whole, 0, NULL), "opd");
    for (int64_t bad = -1; bad < 2; bad += 2) { /* one before the first, and one after the last */
        const int64_t index = bad < 0 ? -1 : KNOWN, frame = bad < 0 ? -1 : FRAMES;
        assert_refused(toliman_calibration_get_value(whole, 0, index, &value), TOLIMAN_E_RANGE, "index");
        assert_refused(toliman_calibration_get_frame(whole, frame, &result), TOLIMAN_E_RANGE, "index");
        assert_refused(toliman_calibration_get_value(whole, bad, 0, &value), TOLIMAN_E_RANGE, "window");
        assert_refused(toliman_calibration_get_window(whole, bad, &window), TOLIMAN_E_RANGE, "window");
        assert_refused(toliman_calibration_get_covariance(whole, bad, numbers), TOLIMAN_E_RANGE, "window");
        assert_refused(toliman_calibration_get_opd(whole, bad, numbers), TOLIMAN_E_RANGE, "window");
        assert_refused(toliman_calibration_save_file(whole, bad, in_folder("bad.json")), TOLIMAN_E_RANGE, "window");
    }
    const int32_t images[] = {TOLIMAN_CALIBRATION_IMAGE_CHI, TOLIMAN_CALIBRATION_IMAGE_AFTER};
    for (int i = 0; i < 2; i++) {
        assert_invalid(toliman_calibration_get_image(whole, images[i], NULL, SIDE), "image");
        assert_invalid(toliman_calibration_get_image(whole, images[i], numbers, SIDE - 1), "stride");
    }
    assert_invalid(toliman_calibration_get_image(whole, 2, numbers, SIDE), "kind");
    assert_invalid(toliman_calibration_save_file(whole, 0, NULL), "path");
    assert_invalid(toliman_calibration_save_file(whole, 0, in_folder("scene.txt")), "path");
    const char *const path = in_folder("none/scene.json");
    assert_refused(toliman_calibration_save_file(whole, 0, path), TOLIMAN_E_WRITE, path);
}

TEST(other_scenes_are_no_start) {
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

/* promise: unconverged-values-are-nan */
TEST(without_convergence_every_value_is_nan) {
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
/* promise: contradicting-scenes-are-refused */
TEST(contradictions_of_saved_scenes_are_refused) {
    assert_ok(toliman_calibration_save_file(whole, 0, in_folder("fitted.json")));
    char *const text = text_of(in_folder("fitted.json"));
    char *const group = strstr(text, "\"calibration\":");
    assert_non_null(group);
    static const struct {
        const char *key, *value;
    } rows[] = {{"pupil_samples", "50"}, {"step_nm", "54"}, {"edges", "\"cell\""}, {"accuracy", "1e-9"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char key[40], field[40], *const changed = calloc(strlen(text) + 20, 1);
        snprintf(key, sizeof key, "\"%s\":", rows[i].key);
        snprintf(field, sizeof field, "calibration.%s", rows[i].key);
        const char *const place = strstr(group, key);
        assert_non_null(place);
        const char *const value = place + strlen(key), *const end = value + strcspn(value, ",}");
        sprintf(changed, "%.*s%s%s", (int)(value - text), text, rows[i].value, end);
        toliman_sim *sim = NULL;
        assert_refused(toliman_sim_create_json(changed, strlen(changed), NULL, NULL, &sim), TOLIMAN_E_SCENE, field);
        assert_null(sim);
        free(changed);
    }
    free(text);
}

RUN_TESTS(set_up, tear_down)
