/* Tests the interface of fits: arguments and their messages, lists of parameters, the same bits from all calls, and
 * numbers of frames that cannot be fitted. */
#include "images.h"
#include "scene_text.h"

#include <toliman/fit.h>

enum { SIDE = 64, PIXELS = SIDE * SIDE, FRAMES = 5, MANY = TOLIMAN_FIT_MAX_PARAMETERS };

static toliman_sim *sim;
static toliman_fit *fit;
static double frames[FRAMES * PIXELS];

static const toliman_fit_options kOptions = {.struct_size = sizeof kOptions, .free = "scale jitter_xx"};

static int set_up(void **unused) {
    (void)unused;
    sim = sim_of(kBinaryScene);
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &kOptions, &fit));
    assert_ok(toliman_sim_frame(sim, NULL, 3, 0, FRAMES, frames));
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

static toliman_fit_result fitted(const double *counts, const toliman_fit_prediction *prediction) {
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(counts), 1, prediction, &result, NULL, NULL));
    return result;
}

static void bad_options_are_refused(void **state) {
    (void)state;
    const struct {
        toliman_fit_options options;
        const char *message;
    } cases[] = {
        {{.free = "scal"}, "options->free: \"scal\": must be the name of a parameter; did you mean \"scale\"?"},
        {{.free = "scale;focus"}, "options->free: \"scale;focus\": must be the name of a parameter"},
        {{.free = "focus scale focus"}, "options->free: \"focus\": must be named once"},
        {{.free = " shift_x"}, "options->free: \"shift_x\": is always free"},
        {{.free = "separation"}, "options->free: \"separation\": is always free"},
        {{.capture_px = -1}, "options->capture_px = -1: must be in (0, 64] px, or 0 for 15"},
        {{.capture_px = 64.5}, "options->capture_px = 64.5: must be in (0, 64] px, or 0 for 15"},
        {{.capture_px = NAN}, "options->capture_px = nan: must be in (0, 64] px, or 0 for 15"},
        {{.struct_size = 4}, "options->struct_size = 4"},
    };
    toliman_fit *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_fit_options options = cases[i].options;
        if (options.struct_size == 0)
            options.struct_size = sizeof options;
        assert_fails(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &made), TOLIMAN_E_ARGUMENT,
                     cases[i].message);
    }
    toliman_fit_options options;
    static const char *const moving[] = {"roll", "focus anisotropy", "shear"};
    for (size_t i = 0; i < 3; i++) {
        options = (toliman_fit_options){.struct_size = sizeof options, .free = moving[i]};
        assert_fails(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &made), TOLIMAN_E_UNSUPPORTED,
                     "options->free: \"");
    }
    options.free = "zernike_5 zernike_6 zernike_7 zernike_8 zernike_9 zernike_10 zernike_11 zernike_12 zernike_13 "
                   "zernike_14 zernike_15 zernike_16 zernike_17 zernike_18 zernike_19 zernike_20 zernike_21 zernike_22 "
                   "zernike_23 zernike_24 zernike_25 zernike_26 zernike_27 zernike_28 zernike_29 zernike_30";
    assert_fails(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &made), TOLIMAN_E_ARGUMENT,
                 "options->free: at most 25 names");
    assert_fails(toliman_fit_create((const toliman_sim *[]){NULL}, NULL, 1, NULL, &made), TOLIMAN_E_ARGUMENT,
                 "sims[0] is NULL");
    assert_fails(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "out is NULL");
    assert_fails(
        toliman_fit_create((const toliman_sim *[]){(const toliman_sim *)(const void *)fit}, NULL, 1, NULL, &made),
        TOLIMAN_E_ARGUMENT, "sims[0] is not a toliman_sim");
    assert_null(made);
}

static void parameters_are_listed(void **state) {
    (void)state;
    static const char *const expected[][2] = {
        {"separation", "px"}, {"position_angle", "deg"}, {"shift_x", "px"}, {"shift_y", "px"},    {"flux_a", ""},
        {"flux_b", ""},       {"background", "photons"}, {"scale", ""},     {"jitter_xx", "px^2"}};
    toliman_sim_parameter parameters[9] = {TOLIMAN_SIM_PARAMETER_INIT};
    size_t count = 0;
    assert_asks(toliman_fit_get_parameters(fit, NULL, 0, &count));
    assert_int_equal(count, 9);
    assert_ok(toliman_fit_get_parameters(fit, parameters, 9, &count));
    for (size_t i = 0; i < 9; i++) {
        const toliman_sim_parameter *const one = &parameters[i];
        assert_string_equal(one->name, expected[i][0]);
        assert_string_equal(one->unit, expected[i][1]);
        assert_true(one->scope == TOLIMAN_SIM_SCOPE_FRAME || one->scope == TOLIMAN_SIM_SCOPE_INSTRUMENT);
    }
    assert_fails(toliman_fit_get_parameters(fit, parameters, 8, &count), TOLIMAN_E_CAPACITY,
                 "capacity = 8: must be at least 9, the number of parameters");
    assert_fails(toliman_fit_get_parameters(fit, NULL, 9, &count), TOLIMAN_E_ARGUMENT, "parameters is NULL");
}

static toliman_fit_info info_with(const toliman_fit_options *options) {
    toliman_fit *made = NULL;
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, options, &made));
    assert_ok(toliman_fit_get_info(made, &info));
    toliman_fit_destroy(made);
    return info;
}

static void digests_distinguish_fits(void **state) {
    (void)state;
    const toliman_fit_options options[] = {{.struct_size = sizeof *options},
                                           {.struct_size = sizeof *options, .capture_px = 10},
                                           {.struct_size = sizeof *options, .free = "scale"},
                                           {.struct_size = sizeof *options, .free = "zernike_7"}};
    const toliman_fit_info plain = info_with(NULL);
    assert_int_equal(plain.rows, SIDE);
    assert_int_equal(plain.cols, SIDE);
    assert_int_equal(plain.parameters, 7);
    assert_true(plain.capture_px == 15 && plain.oversampling > 0 && plain.taps > 0 && plain.images > 0);
    assert_true(plain.image_error > 0 && plain.image_error < 1);
    for (size_t i = 0; i < 4; i++) {
        const toliman_fit_info other = info_with(&options[i]);
        assert_int_equal(other.parameters, i < 2 ? 7 : 8);
        assert_true((other.digest == plain.digest) == (i == 0));
        assert_true(other.capture_px == (i == 1 ? 10 : 15));
    }
    toliman_fit_info info = {.struct_size = 8};
    assert_fails(toliman_fit_get_info(fit, &info), TOLIMAN_E_ARGUMENT, "struct_size = 8");
    assert_fails(toliman_fit_get_info(NULL, &info), TOLIMAN_E_ARGUMENT, "fit is NULL");
}

static uint64_t digest_of_scene(const char *binary, const char *detector) {
    char *const text = replaced_again(
        replaced(kBinaryScene, "\"separation_arcsec\": 4, \"position_angle_deg\": 30", binary), "0.2}", detector);
    toliman_sim *const other = sim_of(text);
    toliman_fit *made = NULL;
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_create((const toliman_sim *[]){other}, NULL, 1, NULL, &made));
    assert_ok(toliman_fit_get_info(made, &info));
    toliman_fit_destroy(made), toliman_sim_destroy(other), free(text);
    return info.digest;
}

/* Scenes with the same images whose stars are, or move, elsewhere on the sky. */
static void digests_distinguish_scenes(void **state) {
    (void)state;
    static const char at_rest[] = "\"offsets_px\": {\"A\": [-8, 1], \"B\": [9, 2]}";
    static const char orbit[] = "\"date\": 2027, \"moving\": true, \"orbit\": {\"period_years\": 10, "
                                "\"semi_major_arcsec\": 4, \"eccentricity\": 0, \"inclination_deg\": %s, "
                                "\"node_deg\": 0, \"periastron_deg\": 0, \"epoch\": 2027}";
    char direct[300], retrograde[300];
    snprintf(direct, sizeof direct, orbit, "0");
    snprintf(retrograde, sizeof retrograde, orbit, "180");
    assert_true(digest_of_scene(at_rest, "0.2}") == digest_of_scene(at_rest, "0.2}"));
    assert_true(digest_of_scene(at_rest, "0.2}") != digest_of_scene(at_rest, "0.2, \"rotation_deg\": 10}"));
    assert_true(digest_of_scene(at_rest, "0.2}") != digest_of_scene(at_rest, "0.2, \"full_well_e\": 3e6}"));
    assert_true(digest_of_scene(direct, "0.2}") != digest_of_scene(retrograde, "0.2}"));
}

static void single_stars_and_padded_transforms_are_unsupported(void **state) {
    (void)state;
    toliman_fit *made = NULL;
    toliman_sim *other = sim_of(kSingleScene);
    assert_fails(toliman_fit_create((const toliman_sim *[]){other}, NULL, 1, NULL, &made), TOLIMAN_E_UNSUPPORTED, "");
    toliman_sim_destroy(other);
    const toliman_sim_options padded = {.struct_size = sizeof padded, .engine = TOLIMAN_SIM_ENGINE_PADDED_FFT};
    assert_ok(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, &padded, &other));
    assert_fails(toliman_fit_create((const toliman_sim *[]){other}, NULL, 1, NULL, &made), TOLIMAN_E_UNSUPPORTED, "");
    toliman_sim_destroy(other);
    assert_null(made);
}

static void bad_frames_and_predictions_are_refused(void **state) {
    (void)state;
    toliman_fit_result result = {.struct_size = sizeof result};
    const toliman_fit_result before = result;
    const struct {
        toliman_fit_prediction prediction;
        const char *message;
    } cases[] = {
        {{.flags = 1}, "->flags = 1: must be 0"},
        {{.time_days = NAN}, "->time_days = nan: must be finite"},
        {{.x_px = INFINITY}, "->x_px = inf: must be finite"},
        {{.y_px = -INFINITY}, "->y_px = -inf: must be finite"},
        {{.separation_px = NAN}, "->separation_px = nan: must be finite"},
        {{.separation_px = -1}, "->separation_px = -1: must be above 0 px, or 0 for that of the scene"},
        {{.separation_px = 20, .position_angle_deg = NAN}, "->position_angle_deg = nan: must be finite"},
        {{.x_px = 1e6}, ": stars at (1e+06, "},
        {{.struct_size = 4}, "->struct_size = 4"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_fit_prediction prediction = cases[i].prediction;
        if (prediction.struct_size == 0)
            prediction.struct_size = sizeof prediction;
        assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 1, &prediction, &result, NULL, NULL),
                     TOLIMAN_E_ARGUMENT, cases[i].message);
        assert_fails(toliman_fit_predict(fit, &prediction, NULL, 0, NULL, NULL), TOLIMAN_E_ARGUMENT, cases[i].message);
    }
    static double bad[2 * PIXELS];
    memcpy(bad, frames, sizeof bad);
    bad[PIXELS + 3 * SIDE + 7] = NAN;
    assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(bad + PIXELS), 1, NULL, &result, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "counts[3][7] = nan");
    toliman_fit_result results[2] = {{.struct_size = sizeof *results}};
    double values[2 * MANY] = {-5}, covariance[2 * MANY * MANY] = {-5};
    assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(bad), 2, NULL, results, values, covariance), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[3][7] = nan");
    assert_true(results[0].iterations == 0 && values[0] == -5 && covariance[0] == -5); /* nothing was written */
    assert_fails(toliman_fit_frame(NULL, PLAIN_IMAGE(frames), 1, NULL, &result, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "fit is NULL");
    assert_fails(toliman_fit_predict(fit, NULL, bad, SIDE - 1, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "stride of image = 63: must be at least 64");
    assert_memory_equal(&result, &before, sizeof result);
}

static void bad_arrays_of_frames_are_refused(void **state) {
    (void)state;
    toliman_fit_result results[2] = {{.struct_size = sizeof *results}};
    assert_fails(toliman_fit_frame(fit, NULL, 2, NULL, results, NULL, NULL), TOLIMAN_E_ARGUMENT, "image is NULL");
    assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 2, NULL, NULL, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "results is NULL");
    assert_ok(toliman_fit_frame(fit, NULL, 0, NULL, NULL, NULL, NULL));
    const toliman_image small = {.struct_size = sizeof small, .pixels = frames, .rows = 32, .cols = 32};
    assert_fails(toliman_fit_frame(fit, &small, 2, NULL, results, NULL, NULL), TOLIMAN_E_ARGUMENT, "rows");
    const toliman_fit_prediction predictions[2] = {{.struct_size = sizeof *predictions}, {.x_px = NAN}};
    assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 2, predictions, results, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "frame 1: predictions->x_px = nan: must be finite");
    results[0].struct_size = 8;
    assert_fails(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 2, NULL, results, NULL, NULL), TOLIMAN_E_ARGUMENT,
                 "results->struct_size = 8");
}

/* Frames in one call, by any number of threads and of any pixel type, give the bits of the single calls. */
static void all_calls_give_the_same_bits(void **state) {
    (void)state;
    toliman_fit_prediction predictions[FRAMES];
    toliman_fit_result alone[FRAMES], together[FRAMES];
    enum { N = 9 };
    static double numbers[2][FRAMES][N], covariance[2][FRAMES][N * N]; /* alone and together */
    static uint32_t whole[FRAMES * PIXELS];
    memset(alone, 0, sizeof alone);
    for (int i = 0; i < FRAMES; i++) {
        predictions[i] = (toliman_fit_prediction){.struct_size = sizeof *predictions, .time_days = 2 * i};
        for (int k = 0; k < PIXELS; k++) {
            whole[i * PIXELS + k] = (uint32_t)fmax(0, nearbyint(frames[i * PIXELS + k]));
            frames[i * PIXELS + k] = whole[i * PIXELS + k];
        }
        alone[i].struct_size = sizeof *alone;
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames + i * PIXELS), 1, &predictions[i], &alone[i], numbers[0][i],
                                    covariance[0][i]));
    }
    toliman_fit_info as_given = {.struct_size = sizeof as_given};
    assert_ok(toliman_fit_get_info(fit, &as_given));
    assert_int_equal(as_given.parameters, N);
    for (uint32_t threads = 0; threads < 4; threads++) {
        toliman_fit_options options = kOptions;
        options.threads = threads;
        toliman_fit *other = NULL;
        assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &other));
        toliman_fit_info info = {.struct_size = sizeof info};
        assert_ok(toliman_fit_get_info(other, &info));
        assert_true(info.digest == as_given.digest); /* the model images */
        for (int kind = 0; kind < 2; kind++) {
            const toliman_image *const image = kind ? IMAGE_OF(TOLIMAN_PIXEL_U32, whole) : PLAIN_IMAGE(frames);
            memset(together, 0x5a, sizeof together);
            together[0].struct_size = sizeof *together;
            assert_ok(toliman_fit_frame(other, image, FRAMES, predictions, together, numbers[1][0], covariance[1][0]));
            assert_memory_equal(together, alone, sizeof together);
            assert_memory_equal(numbers[1], numbers[0], sizeof numbers[0]);
            assert_memory_equal(covariance[1], covariance[0], sizeof covariance[0]);
        }
        toliman_fit_destroy(other);
    }
}

static void values_and_covariance_match_the_result(void **state) {
    (void)state;
    toliman_fit_result result = {.struct_size = sizeof result};
    const toliman_fit_prediction none = {.struct_size = sizeof none};
    double values[MANY], covariance[MANY * MANY];
    enum { N = 9 };
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 1, &none, &result, values, covariance));
    const toliman_fit_result again = fitted(frames, NULL);
    assert_memory_equal(&result, &again, sizeof result);
    assert_int_equal(result.flags & ~TOLIMAN_FIT_SEARCHED, 0);
    const double shown[] = {result.separation_px, result.position_angle_deg, result.x_px, result.y_px, result.flux_a,
                            result.flux_b,        result.background};
    for (int i = 0; i < 7; i++)
        assert_true(values[i] == shown[i]);
    const double sigmas[] = {result.separation_sigma_px, result.position_angle_sigma_deg, result.x_sigma_px,
                             result.y_sigma_px};
    for (int i = 0; i < 4; i++)
        assert_close(sigmas[i] * sigmas[i], covariance[i * N + i], 1e-14, 0);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++)
            assert_close(covariance[i * N + k], covariance[k * N + i], 1e-9, 0);
    double expected[MANY];
    assert_ok(toliman_fit_predict(fit, NULL, NULL, 0, expected, NULL));
    assert_close(result.separation_px - result.displacement_px, expected[0], 1e-12, 0);
}

static void predictions_state_what_is_expected(void **state) {
    (void)state;
    static double image[SIDE * (SIDE + 3)], again[PIXELS];
    const toliman_fit_prediction shifted = {.struct_size = sizeof shifted, .x_px = 0.25, .y_px = -0.5};
    double still[MANY], moved[MANY], covariance[MANY * MANY];
    assert_ok(toliman_fit_predict(fit, NULL, image, SIDE + 3, still, covariance));
    assert_ok(toliman_fit_predict(fit, NULL, again, SIDE, NULL, NULL));
    for (int r = 0; r < SIDE; r++)
        assert_memory_equal(image + r * (SIDE + 3), again + r * SIDE, SIDE * sizeof *again);
    assert_ok(toliman_fit_predict(fit, &shifted, NULL, 0, moved, NULL));
    assert_close(moved[2] - still[2], 0.25, 1e-9, 0);
    assert_close(moved[3] - still[3], -0.5, 1e-9, 0);
    assert_close(moved[0], still[0], 1e-9, 0);
    const toliman_fit_prediction placed = {
        .struct_size = sizeof placed, .separation_px = still[0] + 1, .position_angle_deg = still[1]};
    assert_ok(toliman_fit_predict(fit, &placed, NULL, 0, moved, NULL));
    assert_close(moved[0], still[0] + 1, 1e-12, 0);
    assert_close(moved[1], still[1], 1e-9, 0);
    for (int i = 0; i < 9; i++)
        assert_true(covariance[i * 9 + i] > 0);
}

/* An empty frame has no stars to fit. */
static void numbers_of_frames_without_a_fit_are_nan(void **state) {
    (void)state;
    static double empty[PIXELS];
    toliman_fit_result result = {.struct_size = sizeof result};
    double values[MANY], covariance[MANY * MANY];
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(empty), 1, NULL, &result, values, covariance));
    assert_true((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0);
    const double *const first = &result.displacement_px;
    for (const double *at = first; at <= &result.chi_square; at++)
        assert_true(isnan(*at));
    for (int i = 0; i < 9; i++)
        assert_true(isnan(values[i]) && isnan(covariance[i]));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_options_are_refused),
        cmocka_unit_test(parameters_are_listed),
        cmocka_unit_test(digests_distinguish_fits),
        cmocka_unit_test(digests_distinguish_scenes),
        cmocka_unit_test(single_stars_and_padded_transforms_are_unsupported),
        cmocka_unit_test(bad_frames_and_predictions_are_refused),
        cmocka_unit_test(bad_arrays_of_frames_are_refused),
        cmocka_unit_test(all_calls_give_the_same_bits),
        cmocka_unit_test(values_and_covariance_match_the_result),
        cmocka_unit_test(predictions_state_what_is_expected),
        cmocka_unit_test(numbers_of_frames_without_a_fit_are_nan),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
