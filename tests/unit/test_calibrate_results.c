/* Tests the results of calibrations: values against the truth of the frames, the same bits on any threads, steps,
 * cancellation and resumption, verdicts, windows, and saved scenes. */
#include "calibrate_group.h"

/* Results. */

/* Each parameter that the truth has, and 0 for the others, within 4.5 standard deviations; their rms is 1. */
TEST(the_truth_is_found) {
    static const char *const names[] = {"focus",     "zernike_5", "zernike_21", "scale",         "mask_rotation",
                                        "jitter_xx", "jitter_yy", "jitter_xy",  "temperature_a", "temperature_b"};
    static const int places[] = {0, 1, 17, 18, 19, 20, 21, 22, 23, 24};
    const toliman_calibration_info info = calibrate_info_of(whole);
    assert_int_equal(info.flags, 0);
    assert_true(info.frames == FRAMES && info.rows == SIDE && info.cols == SIDE && info.cells == CELLS);
    assert_true(info.parameters == KNOWN && info.windows == 1 && info.map_iterations == 0);
    assert_in_range(info.iterations, 3, 12);
    assert_close(info.chi_square_sigma, sqrt(2.0 / (FRAMES * PIXELS)), 0.05, 0);
    assert_close(info.chi_square, 1, 0, 5 * info.chi_square_sigma);
    assert_true(info.structure < 30 && info.structure_limit >= 50 && info.structure_limit <= 50);
    assert_true(info.map_rms_nm >= 0 && info.map_rms_nm <= 0);
    double sum = 0;
    for (int32_t i = 0; i < KNOWN; i++) {
        const toliman_calibration_value value = calibrate_value_of(whole, 0, i);
        const double pull = (value.value - calibrate_truth(value.name)) / value.sigma;
        assert_at_most(fabs(pull), 4.5);
        assert_true(value.sigma > 0 && value.sigma < 0.1 * value.prior_sigma && value.flags == 0);
        sum += pull * pull;
    }
    assert_close(sqrt(sum / KNOWN), 1, 0, 0.5);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        assert_string_equal(calibrate_value_of(whole, 0, places[i]).name, names[i]);
    assert_string_equal(calibrate_value_of(whole, 0, 0).unit, "nm");
    assert_string_equal(calibrate_value_of(whole, 0, 18).unit, "");
    assert_string_equal(calibrate_value_of(whole, 0, 22).unit, "px^2");
    assert_close(calibrate_value_of(whole, 0, 0).prior_sigma, 100, 0, 0);
    assert_close(calibrate_value_of(whole, 0, 18).prior_sigma, 1e-2, 1e-12, 0);
    assert_close(calibrate_value_of(whole, 0, 19).prior_sigma, 1, 0, 0);
    assert_close(calibrate_value_of(whole, 0, 20).prior_sigma, 0.1, 1e-12, 0);
    assert_close(calibrate_value_of(whole, 0, 23).prior_sigma, 200, 0, 0);
}

/* Without noise, what remains is the error of the method. */
TEST(values_of_noise_free_frames_are_exact) {
    static double exact[3 * PIXELS];
    char *const text = replaced_again(calibrate_text(&kTrueChange), "\"photon\": true, \"read_e\": 1.3",
                                      "\"photon\": false, \"read_e\": 0");
    toliman_sim *const noiseless = sim_of(text);
    assert_ok(toliman_sim_frame(noiseless, NULL, 3, 0, 3, exact));
    const toliman_calibration_options options = {.struct_size = sizeof options, .free = kKnown};
    toliman_calibration *const made = calibrated(nominal, exact, 3, &options);
    double worst = 0;
    assert_int_equal(calibrate_info_of(made).flags, TOLIMAN_CALIBRATION_TOO_GOOD);
    assert_at_most(calibrate_info_of(made).chi_square, 1e-4);
    for (int32_t i = 0; i < KNOWN; i++) {
        const toliman_calibration_value value = calibrate_value_of(made, 0, i);
        worst = fmax(worst, fabs(value.value - calibrate_truth(value.name)) / value.sigma);
    }
    print_message("largest error without noise: %.1e standard deviations\n", worst);
    assert_at_most(worst, 0.02);
    toliman_calibration_destroy(made), toliman_sim_destroy(noiseless), free(text);
}

/* The separations of a fit with the true optics are those of the calibration, within the noise that it adds. */
TEST(frames_agree_with_the_true_optics) {
    toliman_fit *fit = NULL;
    const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = 3};
    const toliman_calibration_info info = calibrate_info_of(whole);
    assert_ok(toliman_fit_create((const toliman_sim *[]){truth}, NULL, 1, &options, &fit));
    for (int64_t k = 0; k < FRAMES; k++) {
        const toliman_fit_result found = calibrate_frame_of(whole, k);
        const toliman_fit_prediction prediction = {.struct_size = sizeof prediction, .time_days = 15.0 * (double)k};
        toliman_fit_result right = {.struct_size = sizeof right};
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames + k * PIXELS), 1, &prediction, &right, NULL, NULL));
        assert_close(found.separation_px, right.separation_px, 0, 5 * info.calibration_sigma_px);
        assert_close(found.x_px, right.x_px, 0, right.x_sigma_px);
        assert_true(found.separation_sigma_px > right.separation_sigma_px);
        assert_close(found.separation_sigma_px, right.separation_sigma_px, 0.05, 0);
        assert_close(found.separation_sigma_px, info.separation_sigma_px, 0.1, 0);
        assert_close(found.chi_square, 1, 0, 6 * sqrt(2.0 / PIXELS));
        assert_int_equal(found.flags & TOLIMAN_FIT_NOT_CONVERGED, 0);
    }
    assert_true(info.calibration_sigma_px > 0 && info.calibration_sigma_px < 0.2 * info.separation_sigma_px);
    toliman_fit_destroy(fit);
}

TEST(covariances_belong_to_the_values) {
    double covariance[KNOWN * KNOWN];
    assert_ok(toliman_calibration_get_covariance(whole, 0, covariance));
    for (int32_t i = 0; i < KNOWN; i++) {
        const double sigma = calibrate_value_of(whole, 0, i).sigma;
        assert_close(covariance[i * KNOWN + i], sigma * sigma, 1e-12, 0);
        for (int32_t j = 0; j < KNOWN; j++) {
            const double other = calibrate_value_of(whole, 0, j).sigma, c = covariance[i * KNOWN + j];
            assert_close(c, covariance[j * KNOWN + i], 1e-9, 1e-9 * sigma * other);
            assert_at_most(fabs(c), (1 + 1e-9) * sigma * other);
        }
    }
    /* The ruler is the wavelength: a hotter star is a smaller scale. */
    const double scale = calibrate_value_of(whole, 0, 18).sigma, hot = calibrate_value_of(whole, 0, 23).sigma;
    assert_true(fabs(covariance[18 * KNOWN + 23]) > 0.3 * scale * hot);
}

static double mean_square(const double *values) {
    double sum = 0;
    for (int i = 0; i < PIXELS; i++)
        sum += values[i] * values[i];
    return sum / PIXELS;
}

TEST(residuals_are_white_after_the_fit) {
    static double before[PIXELS], after[PIXELS], map[PIXELS + SIDE], mean;
    assert_ok(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_BEFORE, before, SIDE));
    assert_ok(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_AFTER, after, SIDE));
    assert_true(mean_square(before) > 20);
    assert_close(mean_square(after), 1, 0, 6 * sqrt(2.0 / PIXELS));
    assert_ok(toliman_calibration_get_image(whole, TOLIMAN_CALIBRATION_IMAGE_CHI, map, SIDE + 1));
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            mean += map[y * (SIDE + 1) + x] / PIXELS;
    assert_close(mean, calibrate_info_of(whole).chi_square, 0.01, 0);
    toliman_calibration_window window = {.struct_size = sizeof window};
    assert_ok(toliman_calibration_get_window(whole, 0, &window));
    assert_true(window.frames == FRAMES && window.first_days >= 0 && window.first_days <= 0);
    assert_close(window.chi_square, calibrate_info_of(whole).chi_square, 0.01, 0);
}

/* Any number of threads, pixels of another type, and times given by the caller. */
/* promise: threads-change-no-bit */
TEST(all_calls_give_the_same_bits) {
    static float single[FRAMES * PIXELS];
    static double rounded[FRAMES * PIXELS];
    toliman_fit_prediction predictions[FRAMES] = {{.struct_size = sizeof *predictions}};
    for (int k = 0; k < FRAMES; k++)
        predictions[k].time_days = 15.0 * k;
    for (int i = 0; i < FRAMES * PIXELS; i++)
        rounded[i] = (double)(single[i] = (float)frames[i]);
    toliman_calibration *made[4] = {NULL};
    toliman_calibration_options options = {
        .struct_size = sizeof options, .threads = 1, .free = "focus scale mask_rotation jitter_xx temperature_a"};
    assert_ok(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, predictions, &options, &made[0]));
    options.threads = 3;
    assert_ok(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made[1]));
    assert_same(made[0], made[1]);
    assert_ok(toliman_calibration_create(nominal, PLAIN_IMAGE(rounded), FRAMES, NULL, &options, &made[2]));
    options.threads = 0;
    assert_ok(
        toliman_calibration_create(nominal, IMAGE_OF(TOLIMAN_PIXEL_F32, single), FRAMES, NULL, &options, &made[3]));
    assert_same(made[2], made[3]);
    for (int i = 0; i < 4; i++)
        toliman_calibration_destroy(made[i]);
}

/* Photons relative to the peak of the image, which the optics change, are held: the true values are found. */
TEST(photons_may_be_relative_to_the_peak) {
    static double of_peak[2 * PIXELS];
    toliman_sim *sims[2];
    for (int i = 0; i < 2; i++) {
        char *text = calibrate_text(i == 0 ? NULL : &kTrueChange);
        text = replaced_again(text, "\"exposure_s\": 100", "\"peak_photons\": 3e6");
        sims[i] = sim_of(text);
        free(text);
    }
    assert_ok(toliman_sim_frame(sims[1], NULL, 3, 0, 2, of_peak));
    const toliman_calibration_options options = {
        .struct_size = sizeof options,
        .free = "focus zernike_5-11 scale mask_rotation jitter_xx jitter_yy jitter_xy temperature_a"};
    toliman_calibration *const made = calibrated(sims[0], of_peak, 2, &options);
    assert_int_equal(calibrate_info_of(made).flags, 0);
    assert_in_range(calibrate_info_of(made).iterations, 3, 8);
    for (int32_t i = 0; i < 14; i++) {
        const toliman_calibration_value value = calibrate_value_of(made, 0, i);
        assert_close(value.value, calibrate_truth(value.name), 0, 4.5 * value.sigma);
    }
    toliman_calibration_destroy(made), toliman_sim_destroy(sims[0]), toliman_sim_destroy(sims[1]);
}

/* Steps. */

typedef struct {
    int calls, cancel_at;
    int32_t iteration;
    double chi_square, largest;
    const char *save;
} steps;

static int32_t count_steps(const toliman_calibration *so_far, const toliman_calibration_step *step, void *user_data) {
    steps *const all = user_data;
    const toliman_calibration_info info = calibrate_info_of(so_far);
    assert_true(step->struct_size == sizeof *step && step->is_map == 0 && step->accepted <= 1);
    assert_int_equal(step->iteration, ++all->iteration);
    assert_true(info.frames == FRAMES && info.iterations == step->iteration && step->largest_step > 0);
    if (step->accepted == 1)
        all->chi_square = step->chi_square;
    assert_true(isfinite(calibrate_value_of(so_far, 0, 0).value));
    all->largest = step->largest_step;
    if (all->save != NULL)
        assert_ok(toliman_calibration_save_file(so_far, 0, all->save));
    return ++all->calls == all->cancel_at;
}

TEST(steps_are_reported_and_cancel) {
    steps all = {.cancel_at = 0};
    toliman_calibration_options options = {
        .struct_size = sizeof options, .free = kKnown, .step = count_steps, .step_data = &all};
    toliman_calibration *made = calibrated(nominal, frames, FRAMES, &options);
    assert_same(whole, made);
    assert_int_equal(all.calls, calibrate_info_of(made).iterations);
    assert_close(all.chi_square, calibrate_info_of(made).chi_square, 1e-3, 0);
    assert_at_most(all.largest, 0.1);
    toliman_calibration_destroy(made);
    made = NULL;
    all = (steps){.cancel_at = 2};
    assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    assert_null(made);
    assert_int_equal(all.calls, 2);
}

typedef struct {
    int calls, cancel_at;
    int derivatives, frames;
} parts;

static int32_t count_parts(const char *stage, double fraction, void *user_data) {
    parts *const all = user_data;
    assert_true(fraction >= 0 && fraction <= 1);
    all->derivatives |= strcmp(stage, "derivatives") == 0;
    all->frames |= strcmp(stage, "frames") == 0;
    return ++all->calls == all->cancel_at;
}

/* Also within an iteration. */
TEST(progress_is_reported_and_cancels) {
    parts all = {.cancel_at = 0};
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .free = "focus scale", .progress = count_parts, .progress_data = &all};
    toliman_calibration *made = calibrated(nominal, frames, FRAMES, &options);
    assert_true(all.derivatives && all.frames);
    toliman_calibration_destroy(made);
    made = NULL;
    const int calls = all.calls;
    for (int at = 1; at <= calls; at += 1 + calls / 4) {
        all = (parts){.cancel_at = at};
        assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                       TOLIMAN_E_CANCELLED, "");
        assert_null(made);
        assert_int_equal(all.calls, at);
    }
}

/* From the state that a cancelled calibration saved: fewer steps to the same maximum. */
TEST(calibrations_resume) {
    char path[400];
    snprintf(path, sizeof path, "%s", in_folder("so_far.json"));
    steps all = {.cancel_at = 3, .save = path};
    toliman_calibration_options options = {
        .struct_size = sizeof options, .free = kKnown, .step = count_steps, .step_data = &all};
    toliman_calibration *made = NULL;
    assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    toliman_sim *start = NULL;
    assert_ok(toliman_sim_create_file(path, NULL, &start));
    options = (toliman_calibration_options){.struct_size = sizeof options, .free = kKnown, .start = start};
    made = calibrated(nominal, frames, FRAMES, &options);
    assert_true(calibrate_info_of(made).iterations < calibrate_info_of(whole).iterations);
    for (int32_t i = 0; i < KNOWN; i++) {
        const toliman_calibration_value value = calibrate_value_of(made, 0, i);
        assert_close(value.value, calibrate_value_of(whole, 0, i).value, 0, 0.02 * value.sigma);
    }
    toliman_calibration_destroy(made), toliman_sim_destroy(start);
}

/* Verdicts. */

/* promise: incomplete-models-are-reported */
TEST(missing_parameters_are_reported) {
    const toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus zernike_5-11 scale"};
    toliman_calibration *const made = calibrated(nominal, frames, FRAMES, &options);
    const toliman_calibration_info info = calibrate_info_of(made);
    assert_int_equal(info.flags, TOLIMAN_CALIBRATION_INCOMPLETE);
    assert_true(info.chi_square > 1 + 6 * info.chi_square_sigma);
    assert_int_equal(info.parameters, 9);
    assert_int_equal(info.goodness, TOLIMAN_GOODNESS_POOR);
    assert_int_equal(info.lacks, TOLIMAN_CALIBRATION_CHANGE_SAMPLES | TOLIMAN_CALIBRATION_CHANGE_SPECTRUM |
                                     TOLIMAN_CALIBRATION_CHANGE_OPD_MAP);
    assert_true(info.pupil_error > info.peak_noise && info.attempts == 0 && info.changes == 0);
    toliman_calibration_destroy(made);
}

/* A prior far narrower than what the frames tell determines its parameter. */
TEST(priors_that_hold_are_reported) {
    const toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus=1e-5 zernike_5-6=50"};
    static double exact[2 * PIXELS];
    assert_ok(toliman_sim_frame(nominal, NULL, 3, 0, 2, exact));
    toliman_calibration *const made = calibrated(nominal, exact, 2, &options);
    assert_int_equal(calibrate_info_of(made).flags, TOLIMAN_CALIBRATION_HELD);
    assert_int_equal(calibrate_value_of(made, 0, 0).flags, TOLIMAN_CALIBRATION_HELD);
    assert_close(calibrate_value_of(made, 0, 0).sigma, 1e-5, 1e-3, 0);
    for (int32_t i = 1; i < 3; i++) {
        assert_int_equal(calibrate_value_of(made, 0, i).flags, 0);
        assert_close(calibrate_value_of(made, 0, i).prior_sigma, 50, 0, 0);
    }
    toliman_calibration_destroy(made);
}

/* Without struts, the images of an aberration of even order and of its negative are the same. */
TEST(signs_that_have_no_effect_are_reported) {
    static double both[2][2 * PIXELS];
    const calibrate_change plain = {.no_struts = 1};
    toliman_sim *const open = calibrate_sim(&plain);
    for (int negative = 0; negative < 2; negative++) {
        const calibrate_change change = {
            .no_struts = 1,
            .telescope = negative ? ", \"aberrations\": {\"zernike_rms_nm\": {\"4\": -9, \"7\": 8}}"
                                  : ", \"aberrations\": {\"zernike_rms_nm\": {\"4\": 9, \"7\": -8}}"};
        toliman_sim *const other = calibrate_sim(&change);
        assert_ok(toliman_sim_frame(other, NULL, 3, 0, 2, both[negative]));
        const toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus zernike_7"};
        toliman_calibration *const made = calibrated(open, both[negative], 2, &options);
        const toliman_calibration_value focus = calibrate_value_of(made, 0, 0), coma = calibrate_value_of(made, 0, 1);
        assert_int_equal(calibrate_info_of(made).flags, TOLIMAN_CALIBRATION_NO_SIGN);
        assert_int_equal(focus.flags, TOLIMAN_CALIBRATION_NO_SIGN);
        assert_int_equal(coma.flags, 0);
        assert_close(focus.value, 9, 0, 5 * focus.sigma);
        assert_close(coma.value, negative ? 8 : -8, 0, 5 * coma.sigma);
        toliman_calibration_destroy(made), toliman_sim_destroy(other);
    }
    /* From the other side: the value is positive all the same. */
    const calibrate_change below = {.no_struts = 1,
                                    .telescope = ", \"aberrations\": {\"zernike_rms_nm\": {\"4\": -7}}"};
    toliman_sim *const start = calibrate_sim(&below);
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .free = "focus zernike_7", .start = start};
    toliman_calibration *const made = calibrated(open, both[0], 2, &options);
    const toliman_calibration_value focus = calibrate_value_of(made, 0, 0), coma = calibrate_value_of(made, 0, 1);
    assert_close(focus.value, 9, 0, 5 * focus.sigma);
    assert_close(coma.value, -8, 0, 5 * coma.sigma);
    toliman_calibration_destroy(made), toliman_sim_destroy(start), toliman_sim_destroy(open);
}

/* Windows. */

static double drifting[ALL * PIXELS];

/* Frames whose focus (nm) is linear between `ends`, with two frames from one to the next. */
static void draw_drifting(const double *ends, uint64_t seed) {
    for (size_t k = 0; k < ALL; k++) {
        const double at = 0.5 * (double)k, share = at - floor(at);
        const double focus = (1 - share) * ends[k / 2] + share * ends[k / 2 + 1];
        char text[100];
        snprintf(text, sizeof text, ", \"aberrations\": {\"zernike_rms_nm\": {\"4\": %.17g, \"7\": 10}}", focus);
        const calibrate_change change = {.telescope = text};
        toliman_sim *const other = calibrate_sim(&change);
        assert_ok(toliman_sim_frame(other, NULL, seed, (int64_t)k, 1, drifting + k * PIXELS));
        toliman_sim_destroy(other);
    }
}

TEST(parameters_may_change_between_windows) {
    static const double ends[] = {5, 8, 6, 6, 9};
    draw_drifting(ends, 3);
    toliman_calibration_options options = {
        .struct_size = sizeof options, .free = "focus zernike_7", .window_days = 30, .smoothness = 0.05};
    toliman_calibration *made = calibrated(nominal, drifting, ALL, &options);
    const toliman_calibration_info info = calibrate_info_of(made);
    assert_int_equal(info.flags, 0);
    assert_int_equal(info.windows, 5);
    for (int64_t w = 0; w < 5; w++) {
        toliman_calibration_window window = {.struct_size = sizeof window};
        assert_ok(toliman_calibration_get_window(made, w, &window));
        assert_true(window.frames == (w < 4 ? 2 : 0)); /* the last start is the end of the last frames' window */
        assert_close(window.first_days, 30.0 * (double)w, 0, 1e-9);
        assert_close(window.chi_square, 1, 0, 6 * sqrt(1.0 / PIXELS));
        const toliman_calibration_value value = calibrate_value_of(made, w, 0);
        assert_close(value.value, ends[w], 0, 5 * value.sigma);
        assert_true(value.sigma < 1);
        assert_close(calibrate_value_of(made, w, 1).value, 10, 0, 5 * calibrate_value_of(made, w, 1).sigma);
    }
    toliman_calibration_destroy(made);
    /* Windows that may hardly differ are one window. */
    options.smoothness = 1e-7;
    made = calibrated(nominal, drifting, ALL, &options);
    assert_int_equal(calibrate_info_of(made).flags & TOLIMAN_CALIBRATION_INCOMPLETE, TOLIMAN_CALIBRATION_INCOMPLETE);
    assert_close(calibrate_value_of(made, 3, 0).value, calibrate_value_of(made, 0, 0).value, 0, 1e-3);
    toliman_calibration_destroy(made);
}

/* Frames without jitter: its variances are at their bound in half of the windows, and others reach it when these are
 * held. */
TEST(jitter_at_its_bound_converges) {
    static const double ends[] = {4, 6, 8, 8, 8};
    static const uint64_t seeds[] = {2, 3, 16}; /* several windows held in one step; variances of -1e-20 px^2 */
    for (int i = 0; i < 3; i++) {
        draw_drifting(ends, seeds[i]);
        for (int days = 15; days <= 30; days += 15) {
            const toliman_calibration_options options = {.struct_size = sizeof options,
                                                         .free = "focus zernike_7 jitter_xx jitter_yy",
                                                         .window_days = days,
                                                         .smoothness = 0.05};
            toliman_calibration *const made = calibrated(nominal, drifting, ALL, &options);
            const toliman_calibration_info info = calibrate_info_of(made);
            if ((info.flags & TOLIMAN_CALIBRATION_NOT_CONVERGED) != 0)
                fail_msg("seed %d, windows of %d days: not converged", (int)seeds[i], days);
            for (int64_t w = 0; w < info.windows; w++)
                for (int64_t which = 2; which < 4; which++)
                    assert_true(calibrate_value_of(made, w, which).value > -1e-12);
            toliman_calibration_destroy(made);
        }
    }
}

/* A drift is named, and fitted in as many windows as it takes. */
TEST(drifts_are_found) {
    static const double cases[][5] = {
        {4, 4.2, 4.4, 4.6, 4.8}, /* linear */
        {4, 4.8, 4.8, 4.8, 4.8},
        {4, 6, 8, 10, 12}, /* linear, but so far that the image between the ends is not */
    };
    for (int i = 0; i < 3; i++) {
        draw_drifting(cases[i], 3);
        toliman_calibration_options options = {.struct_size = sizeof options, .free = "focus zernike_7"};
        toliman_calibration *made = calibrated(nominal, drifting, ALL, &options);
        toliman_calibration_info info = calibrate_info_of(made);
        assert_true((info.flags & TOLIMAN_CALIBRATION_INCOMPLETE) != 0);
        assert_true((info.lacks & TOLIMAN_CALIBRATION_CHANGE_WINDOWS) != 0);
        const double chi_square = info.chi_square;
        toliman_calibration_destroy(made);

        options.flags = TOLIMAN_CALIBRATION_IMPROVE;
        options.smoothness = 0.05;
        made = calibrated(nominal, drifting, ALL, &options);
        info = calibrate_info_of(made);
        assert_true((info.changes & TOLIMAN_CALIBRATION_CHANGE_WINDOWS) != 0);
        assert_true(info.chi_square < chi_square);
        if (i == 0) {
            assert_int_equal(info.flags & TOLIMAN_CALIBRATION_INCOMPLETE, 0);
            assert_int_equal(info.windows, 2);
            assert_int_equal(info.attempts, 1);
            const toliman_calibration_value first = calibrate_value_of(made, 0, 0),
                                            last = calibrate_value_of(made, 1, 0);
            assert_close(first.value, 4, 0, 5 * first.sigma);
            assert_close(last.value, 4.7, 0, 5 * last.sigma); /* of the last frame */
        } else {
            assert_int_equal(info.windows, 3); /* and no more: of four frames each */
        }
        toliman_calibration_destroy(made);
    }
}

/* Saved scenes. */

/* The OPD of the saved scene minus that of the nominal one with the same mask is the reported change; its fit measures
 * the same places. */
TEST(saved_scenes_are_the_fitted_ones) {
    static double before[CELLS * CELLS], after[CELLS * CELLS], change[CELLS * CELLS], open[CELLS * CELLS];
    assert_ok(toliman_calibration_save_file(whole, 0, in_folder("fitted.json")));
    toliman_sim *fitted = NULL;
    assert_ok(toliman_sim_create_file(in_folder("fitted.json"), NULL, &fitted));
    char rotation[100];
    snprintf(rotation, sizeof rotation, ", \"rotation_deg\": %.17g", calibrate_value_of(whole, 0, 19).value);
    const calibrate_change rotated_mask = {.mask = rotation};
    toliman_sim *const rotated = calibrate_sim(&rotated_mask);
    assert_ok(toliman_sim_get_pupil(rotated, open, before));
    toliman_sim_destroy(rotated);
    assert_ok(toliman_sim_get_pupil(fitted, NULL, after));
    assert_ok(toliman_calibration_get_opd(whole, 0, change));
    for (int i = 0; i < CELLS * CELLS; i++)
        assert_close(change[i], open[i] > 0 ? after[i] - before[i] : 0, 0, 1e-15);
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){fitted}, NULL, 1, NULL, &fit));
    for (int64_t k = 0; k < FRAMES; k++) {
        const toliman_fit_prediction prediction = {.struct_size = sizeof prediction, .time_days = 15.0 * (double)k};
        const toliman_fit_result found = calibrate_frame_of(whole, k);
        toliman_fit_result result = {.struct_size = sizeof result};
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames + k * PIXELS), 1, &prediction, &result, NULL, NULL));
        assert_close(result.separation_px, found.separation_px, 0, 1e-7);
        assert_close(result.position_angle_deg, found.position_angle_deg, 0, 1e-6);
        assert_close(result.x_px, found.x_px, 0, 1e-7);
        assert_close(result.flux_a, found.flux_a, 0, 1e-8);
        assert_close(result.displacement_px, found.displacement_px, 0, 1e-7);
        assert_close(result.chi_square, found.chi_square, 1e-6, 0);
    }
    toliman_fit_destroy(fit), toliman_sim_destroy(fitted);
}

RUN_TESTS(set_up, tear_down)
