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

static toliman_status create(const toliman_sim *of, const toliman_fit_options *options, toliman_fit **out) {
    return toliman_fit_create(&of, NULL, 1, options, out);
}

FIXTURE(set_up) {
    sim = sim_of(kBinaryScene);
    assert_ok(create(sim, &kOptions, &fit));
    assert_ok(toliman_sim_frame(sim, NULL, 3, 0, FRAMES, frames));
    return 0;
}

FIXTURE(tear_down) {
    toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

static toliman_fit_result fitted(const double *counts, const toliman_fit_prediction *prediction) {
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(counts), 1, prediction, &result, NULL, NULL));
    return result;
}

TEST(bad_options_are_refused) {
    static const struct {
        const char *free;
        toliman_status status;
    } lists[] = {
        {"scal", TOLIMAN_E_ARGUMENT},
        {"scale;focus", TOLIMAN_E_ARGUMENT},
        {"focus scale focus", TOLIMAN_E_ARGUMENT},
        {" shift_x", TOLIMAN_E_ARGUMENT},
        {"separation", TOLIMAN_E_ARGUMENT},
        {"roll", TOLIMAN_E_UNSUPPORTED},
        {"focus anisotropy", TOLIMAN_E_UNSUPPORTED},
        {"shear", TOLIMAN_E_UNSUPPORTED},
        {"zernike_5 zernike_6 zernike_7 zernike_8 zernike_9 zernike_10 zernike_11 zernike_12 zernike_13 zernike_14 "
         "zernike_15 zernike_16 zernike_17 zernike_18 zernike_19 zernike_20 zernike_21 zernike_22 zernike_23 "
         "zernike_24 zernike_25 zernike_26 zernike_27 zernike_28 zernike_29 zernike_30",
         TOLIMAN_E_ARGUMENT} /* more than 25 */
    };
    toliman_fit *made = NULL;
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        const toliman_fit_options options = {.struct_size = sizeof options, .free = lists[i].free};
        assert_refused(create(sim, &options, &made), lists[i].status, "options->free");
    }
    for (size_t i = 0; i < 2; i++) {
        const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = i == 0 ? -1 : 64.5};
        assert_invalid(create(sim, &options, &made), "options->capture_px");
    }
    const toliman_fit_options older = {.struct_size = 4};
    assert_invalid(create(sim, &older, &made), "options->struct_size");
    assert_invalid(create(NULL, NULL, &made), "sims[0]");
    assert_invalid(create((const toliman_sim *)(const void *)fit, NULL, &made), "sims[0]");
    assert_invalid(create(sim, NULL, NULL), "out");
    assert_null(made);
}

TEST(parameters_are_listed) {
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
    assert_refused(toliman_fit_get_parameters(fit, parameters, 8, &count), TOLIMAN_E_CAPACITY, "capacity");
    assert_invalid(toliman_fit_get_parameters(fit, NULL, 9, &count), "parameters");
}

static toliman_fit_info info_with(const toliman_sim *of, const toliman_fit_options *options) {
    toliman_fit *made = NULL;
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(create(of, options, &made));
    assert_ok(toliman_fit_get_info(made, &info));
    toliman_fit_destroy(made);
    return info;
}

TEST(digests_distinguish_fits) {
    const toliman_fit_options options[] = {{.struct_size = sizeof *options},
                                           {.struct_size = sizeof *options, .capture_px = 10},
                                           {.struct_size = sizeof *options, .free = "scale"},
                                           {.struct_size = sizeof *options, .free = "zernike_7"}};
    const toliman_fit_info plain = info_with(sim, NULL);
    assert_int_equal(plain.rows, SIDE);
    assert_int_equal(plain.cols, SIDE);
    assert_int_equal(plain.parameters, 7);
    assert_true(plain.capture_px == 15 && plain.oversampling > 0 && plain.taps > 0 && plain.images > 0);
    assert_true(plain.image_error > 0 && plain.image_error < 1);
    for (size_t i = 0; i < 4; i++) {
        const toliman_fit_info other = info_with(sim, &options[i]);
        assert_int_equal(other.parameters, i < 2 ? 7 : 8);
        assert_true((other.digest == plain.digest) == (i == 0));
        assert_true(other.capture_px == (i == 1 ? 10 : 15));
    }
    toliman_fit_info info = {.struct_size = 8};
    assert_invalid(toliman_fit_get_info(fit, &info), "out->struct_size");
    assert_invalid(toliman_fit_get_info(NULL, &info), "fit");
}

static uint64_t digest_of_scene(const char *binary, const char *detector) {
    char *const text = replaced_again(
        replaced(kBinaryScene, "\"separation_arcsec\": 4, \"position_angle_deg\": 30", binary), "0.2}", detector);
    toliman_sim *const other = sim_of(text);
    const uint64_t digest = info_with(other, NULL).digest;
    toliman_sim_destroy(other), free(text);
    return digest;
}

/* Scenes with the same images whose stars are, or move, elsewhere on the sky. */
TEST(digests_distinguish_scenes) {
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

TEST(single_stars_and_padded_transforms_are_unsupported) {
    const toliman_sim_options padded = {.struct_size = sizeof padded, .engine = TOLIMAN_SIM_ENGINE_PADDED_FFT};
    toliman_fit *made = NULL;
    toliman_sim *others[] = {sim_of(kSingleScene), NULL};
    assert_ok(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, &padded, &others[1]));
    for (int i = 0; i < 2; i++) {
        assert_int_equal(create(others[i], NULL, &made), TOLIMAN_E_UNSUPPORTED);
        toliman_sim_destroy(others[i]);
    }
    assert_null(made);
}

TEST(bad_frames_and_predictions_are_refused) {
    toliman_fit_result results[2] = {{.struct_size = sizeof *results}};
    double values[2 * MANY] = {-5}, covariance[2 * MANY * MANY] = {-5};
    const struct {
        toliman_fit_prediction prediction;
        const char *of_frame, *of_predict; /* fields */
    } cases[] = {{{.flags = 1}, "predictions->flags", "prediction->flags"},
                 {{.time_days = NAN}, "predictions->time_days", "prediction->time_days"},
                 {{.x_px = INFINITY}, "predictions->x_px", "prediction->x_px"},
                 {{.y_px = -INFINITY}, "predictions->y_px", "prediction->y_px"},
                 {{.separation_px = NAN}, "predictions->separation_px", "prediction->separation_px"},
                 {{.separation_px = -1}, "predictions->separation_px", "prediction->separation_px"},
                 {{.separation_px = 20, .position_angle_deg = NAN},
                  "predictions->position_angle_deg",
                  "prediction->position_angle_deg"},
                 {{.x_px = 1e6}, "prediction", "prediction"},
                 {{.struct_size = 4}, "predictions->struct_size", "prediction->struct_size"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_fit_prediction prediction = cases[i].prediction;
        if (prediction.struct_size == 0)
            prediction.struct_size = sizeof prediction;
        assert_invalid(toliman_fit_frame(fit, PLAIN_IMAGE(frames), 1, &prediction, results, NULL, NULL),
                       cases[i].of_frame);
        assert_invalid(toliman_fit_predict(fit, &prediction, NULL, 0, NULL, NULL), cases[i].of_predict);
    }
    static double bad[2 * PIXELS];
    memcpy(bad, frames, sizeof bad);
    bad[PIXELS + 3 * SIDE + 7] = NAN;
    const toliman_fit_prediction second[2] = {{.struct_size = sizeof *second}, {.x_px = NAN}};
    const toliman_image small = {.struct_size = sizeof small, .pixels = frames, .rows = 32, .cols = 32};
    toliman_fit_result older = {.struct_size = 8};
    const struct {
        const toliman_image *image;
        const toliman_fit_prediction *predictions;
        toliman_fit_result *results;
        const char *text; /* with the number of the frame */
    } calls[] = {{PLAIN_IMAGE(bad), NULL, results, "frame 1: counts[3][7] = nan"},
                 {PLAIN_IMAGE(frames), second, results, "frame 1: predictions->x_px = nan"},
                 {NULL, NULL, results, "image"},
                 {PLAIN_IMAGE(frames), NULL, NULL, "results"},
                 {&small, NULL, results, "image->rows"},
                 {PLAIN_IMAGE(frames), NULL, &older, "results->struct_size"}};
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++)
        assert_fails(
            toliman_fit_frame(fit, calls[i].image, 2, calls[i].predictions, calls[i].results, values, covariance),
            TOLIMAN_E_ARGUMENT, calls[i].text);
    assert_true(results[0].iterations == 0 && values[0] == -5 && covariance[0] == -5); /* nothing was written */
    assert_invalid(toliman_fit_frame(NULL, PLAIN_IMAGE(frames), 1, NULL, results, NULL, NULL), "fit");
    assert_invalid(toliman_fit_predict(fit, NULL, bad, SIDE - 1, NULL, NULL), "stride");
    assert_ok(toliman_fit_frame(fit, NULL, 0, NULL, NULL, NULL, NULL));
}

/* Frames in one call, by any number of threads and of any pixel type, give the bits of the single calls. */
/* promise: fits-ignore-other-frames */
TEST(all_calls_give_the_same_bits) {
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
        assert_ok(create(sim, &options, &other));
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

TEST(values_and_covariance_match_the_result) {
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

TEST(predictions_state_what_is_expected) {
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
/* promise: unfitted-frames-are-nan */
TEST(numbers_of_frames_without_a_fit_are_nan) {
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

RUN_TESTS(set_up, tear_down)
