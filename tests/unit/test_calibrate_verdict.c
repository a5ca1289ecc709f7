/* Tests the verdict of calibrations: chi-square on both sides of 1, what an incomplete model lacks, changes that
 * complete it, default parameters that a scene does not have, and the verdict of a saved scene. */
#include "calibrate_group.h"

enum { FEW = 2 };
static double plain[FEW * PIXELS]; /* frames of the nominal scene */

static int set_up_plain(void **state) {
    const int failed = set_up(state);
    assert_ok(toliman_sim_frame(nominal, NULL, 5, 0, FEW, plain));
    return failed;
}

static toliman_sim *changed(const char *from, const char *to) {
    char *const text = replaced_again(calibrate_text(NULL), from, to);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

/* Frames f times those of the scene, plus a constant c, for a scene with another read noise. */
static const struct {
    const char *name, *read_e;
    double factor, constant, chi_square; /* expected chi_square; 0 = any */
    int32_t goodness;
    uint32_t flags;
    const char *warning; /* of the fitted scene */
} kCases[] = {{"right", "1.3", 1, 0, 1, TOLIMAN_GOODNESS_GOOD, 0, NULL},
              {"counts in DN, 1.5 photons each", "1.3", 1 / 1.5, 0, 1 / 1.5, TOLIMAN_GOODNESS_TOO_GOOD,
               TOLIMAN_CALIBRATION_TOO_GOOD, ": its calibration is too good: chi-square 0.6"},
              {"counts in another unit", "1.3", 1.5, 0, 1.5, TOLIMAN_GOODNESS_POOR, TOLIMAN_CALIBRATION_INCOMPLETE,
               ": its calibration is incomplete: chi-square 1."},
              {"read noise too large", "500", 1, 0, 0, TOLIMAN_GOODNESS_TOO_GOOD, TOLIMAN_CALIBRATION_TOO_GOOD,
               ": its calibration is too good: chi-square 0."},
              {"bias not subtracted", "1.3", 1, 1e6, 0, TOLIMAN_GOODNESS_TOO_GOOD, TOLIMAN_CALIBRATION_TOO_GOOD,
               ": its calibration is too good: chi-square 0."}};
enum { CASES = sizeof kCases / sizeof *kCases };

static void record_log(int32_t level, const char *text, void *user_data) {
    if (level == TOLIMAN_LOG_WARNING && strstr(text, "its calibration") != NULL)
        snprintf(user_data, 300, "%s", text);
}

/* Opens a saved scene; its warning about the calibration goes to `warning`. */
static toliman_sim_info opened(const char *path, char (*warning)[300]) {
    **warning = '\0';
    toliman_sim_options options = {.struct_size = sizeof options, .log = record_log, .log_data = *warning};
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_file(path, &options, &sim));
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    assert_ok(toliman_sim_get_info(sim, &info));
    toliman_sim_destroy(sim);
    return info;
}

TEST(both_sides_of_chi_square_count) {
    static double given[FEW * PIXELS];
    for (size_t i = 0; i < CASES; i++) {
        char read_e[40];
        snprintf(read_e, sizeof read_e, "\"read_e\": %s", kCases[i].read_e);
        toliman_sim *const sim = changed("\"read_e\": 1.3", read_e);
        for (size_t k = 0; k < FEW * PIXELS; k++)
            given[k] = kCases[i].factor * plain[k] + kCases[i].constant;
        const toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus scale"};
        toliman_calibration *const made = calibrated(sim, given, FEW, &options);
        const toliman_calibration_info info = calibrate_info_of(made);
        if (info.goodness != kCases[i].goodness || info.flags != kCases[i].flags)
            fail_msg("%s: chi-square %g +- %g, %s, flags %u", kCases[i].name, info.chi_square, info.chi_square_sigma,
                     toliman_constant_name(info.goodness), info.flags);
        if (kCases[i].chi_square > 0)
            assert_close(info.chi_square, kCases[i].chi_square, 0.05, 0);
        assert_true(info.largest_residual > 2.5 && info.largest_residual < 7);
        toliman_calibration_window window = {.struct_size = sizeof window};
        assert_ok(toliman_calibration_get_window(made, 0, &window));
        assert_true(window.chi_square == info.chi_square && window.chi_square_sigma == info.chi_square_sigma &&
                    window.largest_residual == info.largest_residual && window.goodness == info.goodness);

        /* The same verdict, from the file. */
        assert_ok(toliman_calibration_save_file(made, 0, in_folder("fitted.json")));
        char warning[300];
        const toliman_sim_info fitted = opened(in_folder("fitted.json"), &warning);
        assert_int_equal(fitted.calibration,
                         info.flags == 0 ? TOLIMAN_SIM_CALIBRATION_COMPLETE : TOLIMAN_SIM_CALIBRATION_INCOMPLETE);
        assert_int_equal(fitted.calibration_goodness, info.goodness);
        assert_true(fitted.calibration_chi_square == info.chi_square);
        assert_true(fitted.calibration_chi_square_sigma == info.chi_square_sigma);
        if (kCases[i].warning == NULL ? *warning != '\0' : strstr(warning, kCases[i].warning) == NULL)
            fail_msg("%s: \"%s\"", kCases[i].name, warning);
        toliman_calibration_destroy(made), toliman_sim_destroy(sim);
    }
}

static int32_t save_and_stop(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused) {
    (void)step, (void)unused;
    assert_ok(toliman_calibration_save_file(so_far, 0, in_folder("part.json")));
    return 1;
}

/* Scenes without a calibration, of one that was stopped, and of one from before the verdict existed. */
TEST(verdicts_may_be_missing) {
    char warning[300];
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    assert_ok(toliman_sim_get_info(nominal, &info));
    assert_int_equal(info.calibration, TOLIMAN_SIM_CALIBRATION_NONE);
    assert_int_equal(info.calibration_goodness, TOLIMAN_GOODNESS_UNKNOWN);
    assert_true(isnan(info.calibration_chi_square));

    const toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus", .step = save_and_stop};
    toliman_calibration *made = NULL;
    assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    info = opened(in_folder("part.json"), &warning);
    assert_int_equal(info.calibration, TOLIMAN_SIM_CALIBRATION_INCOMPLETE);
    assert_int_equal(info.calibration_goodness, TOLIMAN_GOODNESS_UNKNOWN);
    assert_non_null(strstr(warning, "part.json: its calibration did not end"));

    char *const text = replaced_again(
        calibrate_text(NULL), "\"accuracy\": 1e-7",
        "\"accuracy\": 1e-7, \"calibration\": {\"pupil_samples\": 32, \"edges\": \"area\", \"accuracy\": 1e-7}");
    toliman_sim *const old = sim_of(text);
    assert_ok(toliman_sim_get_info(old, &info));
    assert_int_equal(info.calibration, TOLIMAN_SIM_CALIBRATION_NONE);
    toliman_sim_destroy(old), free(text);
}

TEST(damaged_verdicts_are_refused) {
    static const char *const cases[][2] = {
        {"\"goodness\": \"fine\"", "calibration.goodness = \"fine\": must be \"good\", \"poor\", \"too good\" or"},
        {"\"goodness\": 3", "calibration.goodness"},
        {"\"chi_square\": 1", "calibration.chi_square"},
        {"\"complete\": true", "calibration.complete"},
        {"\"goodness\": \"good\", \"chi_square\": -1", "calibration.chi_square = -1: must be in [0"},
        {"\"goodness\": \"good\", \"chi_square_sigma\": \"x\"", "calibration.chi_square_sigma"},
        {"\"goodness\": \"good\", \"complete\": \"yes\"", "calibration.complete"},
        {"\"goodness\": \"good\", \"frames\": -1", "calibration.frames = -1: must be in [0"},
        {"\"goodness\": \"good\", \"verdict\": 1", "calibration.verdict: unknown key"}};
    char *const text = calibrate_text(NULL);
    check_additions(text, "\"accuracy\": 1e-7", "\"accuracy\": 1e-7, \"calibration\": {%s}", cases,
                    sizeof cases / sizeof *cases);
    free(text);
}

/* Parameters that vanish are named. */
TEST(missing_default_parameters_are_named) {
    static const struct {
        const char *from, *to;
        const char *names[5], *reason;
    } cases[] = {{"\"seed\": 7", "\"seed\": 8", {NULL}, ""},
                 {"\"area\"", "\"cell\"", {"mask_rotation"}, "needs a spiral mask with mask.edges = \"area\""},
                 {"{\"kind\": \"blackbody\", \"temperature_k\": 5260}",
                  "{\"kind\": \"lines\", \"wavelength_nm\": [570, 600], \"weight\": [1, 1]}",
                  {"temperature_b", "spectrum_b_1", "spectrum_b_2"},
                  "the spectrum consists of lines"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_sim *const sim = changed(cases[i].from, cases[i].to);
        const toliman_calibration_options options = {.struct_size = sizeof options, .most_iterations = 1};
        toliman_calibration *const made = calibrated(sim, frames, 2, &options);
        const toliman_calibration_info info = calibrate_info_of(made);
        int64_t count = 0;
        for (; cases[i].names[count] != NULL; count++) {
            toliman_calibration_left_out left_out = TOLIMAN_CALIBRATION_LEFT_OUT_INIT;
            assert_ok(toliman_calibration_get_left_out(made, count, &left_out));
            assert_string_equal(left_out.name, cases[i].names[count]);
            assert_string_equal(left_out.reason, cases[i].reason);
        }
        assert_int_equal(info.left_out, count);
        assert_int_equal(info.parameters, DEFAULT - count);
        toliman_calibration_left_out none = TOLIMAN_CALIBRATION_LEFT_OUT_INIT;
        assert_refused(toliman_calibration_get_left_out(made, count, &none), TOLIMAN_E_RANGE, "index");
        toliman_calibration_destroy(made), toliman_sim_destroy(sim);
    }
}

/* The frames are those of a mask with edges "area"; the model has others. */
TEST(a_model_is_completed) {
    toliman_sim *const cell = changed("\"area\"", "\"cell\"");
    toliman_calibration_options options = {
        .struct_size = sizeof options, .flags = TOLIMAN_CALIBRATION_IMPROVE, .free = "focus zernike_5-7 scale"};
    toliman_calibration *made = calibrated(cell, plain, FEW, &options);
    toliman_calibration_info info = calibrate_info_of(made);
    assert_int_equal(info.flags & (TOLIMAN_CALIBRATION_INCOMPLETE | TOLIMAN_CALIBRATION_TOO_GOOD), 0);
    assert_int_equal(info.changes, TOLIMAN_CALIBRATION_CHANGE_EDGES);
    assert_int_equal(info.attempts, 1);
    assert_int_equal(info.left_out, 0);
    assert_int_equal(info.lacks, 0);
    assert_int_equal(info.parameters, 5);
    toliman_calibration_attempt attempt = TOLIMAN_CALIBRATION_ATTEMPT_INIT;
    assert_ok(toliman_calibration_get_attempt(made, 0, &attempt));
    assert_true(attempt.kept == 1 && attempt.change == TOLIMAN_CALIBRATION_CHANGE_EDGES && attempt.cells == CELLS);
    assert_true(attempt.chi_square == info.chi_square);
    assert_refused(toliman_calibration_get_attempt(made, 1, &attempt), TOLIMAN_E_RANGE, "index");
    assert_string_equal(toliman_constant_name((int32_t)attempt.change), "mask edges");
    for (int32_t i = 0; i < 5; i++) {
        const toliman_calibration_value value = calibrate_value_of(made, 0, i);
        assert_close(value.value, 0, 0, 5 * value.sigma);
    }
    /* The scene that it saves has the edges, and is a start for the same call. */
    assert_ok(toliman_calibration_save_file(made, 0, in_folder("improved.json")));
    toliman_calibration_destroy(made);
    toliman_sim *saved = NULL;
    assert_ok(toliman_sim_create_file(in_folder("improved.json"), NULL, &saved));
    options.start = saved;
    made = calibrated(cell, plain, FEW, &options);
    const toliman_calibration_info again = calibrate_info_of(made);
    assert_true(again.flags == info.flags && again.attempts == 0 && again.changes == info.changes);
    assert_close(again.chi_square, info.chi_square, 1e-3, 0);
    toliman_calibration_destroy(made), toliman_sim_destroy(saved), toliman_sim_destroy(cell);
}

/* A complete model is left as it is. */
TEST(nothing_is_tried_without_need) {
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .flags = TOLIMAN_CALIBRATION_IMPROVE, .free = kKnown};
    toliman_calibration *const made = calibrated(nominal, frames, FRAMES, &options);
    const toliman_calibration_info info = calibrate_info_of(made), without = calibrate_info_of(whole);
    assert_memory_equal(&info, &without, sizeof info);
    assert_int_equal(info.attempts, 0);
    toliman_calibration_destroy(made);
}

RUN_TESTS(set_up_plain, tear_down)
