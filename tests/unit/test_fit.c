/* Tests the fit of the forward model: values against the truth of propagated images, covariances against finite
 * differences of whole images, one step against the template, noise against its own standard deviations, and frames
 * that cannot be fitted. */
#include <stdlib.h>

#include "images.h"
#include "invert.h"
#include "scene_text.h"
#include "uniform.h"

#include <toliman/fit.h>
#include <toliman/linear.h>

enum { SIDE = 64, PIXELS = SIDE * SIDE, N = 7, FRAMES = 100 };

/* kBinaryScene with absolute photons; %s: both photons_per_s, the stars, further keys. */
static const char *const kScene =
    "{\"schema\": \"toliman-scene/1\", \"name\": \"fit\","
    " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.01875, \"pupil_samples\": 96,"
    "  \"struts\": {\"count\": 3, \"width_m\": 0.002},"
    "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,"
    "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}]}},"
    " \"band\": {\"min_nm\": 550, \"max_nm\": 600, \"step_nm\": 12.5},"
    " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"photons_per_s\": %.17g},"
    "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"photons_per_s\": %.17g}},"
    " \"binary\": {%s},"
    " \"cadence\": {\"frames\": 100, \"interval_days\": 10, \"exposure_s\": 100},"
    " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.2%s},"
    " \"noise\": {\"photon\": true, \"read_e\": 2.5, \"seed\": 7}%s}";

static const double kFlux[2] = {3e6, 1e6}, kPlaces[4] = {3.5, -8.25, -4.75, 9.5};

static char *scene_text(const double *places, double brighter, const char *detector, const char *more) {
    char binary[300], *const text = malloc(3000);
    assert_non_null(text);
    snprintf(binary, sizeof binary, "\"offsets_px\": {\"A\": [%.17g, %.17g], \"B\": [%.17g, %.17g]}", places[0],
             places[1], places[2], places[3]);
    snprintf(text, 3000, kScene, kFlux[0] * (1 + brighter), kFlux[1], binary, detector, more);
    return text;
}

static toliman_sim *scene_of(const double *places, double brighter, const char *detector, const char *more) {
    char *const text = scene_text(places, brighter, detector, more);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

static toliman_fit *fit_of(const toliman_sim *sim, const char *parameters) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = parameters};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &fit));
    return fit;
}

static toliman_fit_result fitted(const toliman_fit *fit, const double *counts, const toliman_fit_prediction *prediction,
                                 double *values) {
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(counts), 1, prediction, &result, values, NULL));
    return result;
}

static double separation_of(const double *places) {
    return hypot(places[2] - places[0], places[3] - places[1]);
}

/* Noise-free images of other places and fluxes, propagated there, through every stage of the detector. */
TEST(places_of_propagated_images_are_found) {
    static const double moves[][5] = {/* of A, of B, relative brightness of A */
                                      {0, 0, 0, 0, 0},
                                      {0.3, -0.2, 0.3, -0.2, 0},
                                      {1e-6, 0, 0, 0, 0},
                                      {0.1, 0.25, -0.2, 0.15, 1e-3},
                                      {-0.4, -0.35, -0.38, -0.45, -0.05}};
    static const char *const detectors[] = {"", ", \"pixel\": \"integrated\"",
                                            (", \"qe\": 0.8, \"flat_rms\": 0.01, \"dark_e_per_s\": 0.5, "
                                             "\"gain_e_per_dn\": 3, \"bias_dn\": 100"),
                                            ", \"scale_anisotropy\": 2e-3, \"shear\": -1e-3, \"rotation_deg\": 20"};
    double worst = 0;
    for (size_t d = 0; d < 4; d++) {
        toliman_sim *const sim = scene_of(kPlaces, 0, detectors[d], "");
        toliman_fit *const fit = fit_of(sim, NULL);
        for (size_t m = 0; m < 5; m++) {
            double places[4], values[N];
            for (size_t i = 0; i < 4; i++)
                places[i] = kPlaces[i] + moves[m][i];
            toliman_sim *const truth = scene_of(places, moves[m][4], detectors[d], "");
            double *const image = image_of(truth, TOLIMAN_SIM_IMAGE_BOTH);
            const toliman_fit_result result = fitted(fit, image, NULL, values);
            const double share = kFlux[1] / (kFlux[0] + kFlux[1]); /* of the separation, from the barycentre to A */
            assert_int_equal(result.flags & ~TOLIMAN_FIT_SEARCHED, 0);
            assert_close(result.separation_px, separation_of(places), 0, 1e-8);
            assert_close(result.displacement_px, separation_of(places) - separation_of(kPlaces), 0, 1e-8);
            assert_close(result.x_px, (1 - share) * moves[m][0] + share * moves[m][2], 0, 1e-8);
            assert_close(result.y_px, (1 - share) * moves[m][1] + share * moves[m][3], 0, 1e-8);
            assert_close(result.flux_a, moves[m][4], 0, 1e-8);
            assert_close(result.flux_b, 0, 0, 1e-8);
            assert_close(result.background, 0, 0, 1e-4);
            assert_at_most(result.chi_square, 1e-4);
            worst = fmax(worst, fabs(result.separation_px - separation_of(places)));
            assert_true(values[0] >= result.separation_px && values[0] <= result.separation_px);
            free(image), toliman_sim_destroy(truth);
        }
        toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    }
    print_message("largest error of the separation of noise-free images: %.1e px\n", worst);
}

/* The position angle is that on the sky: of the scene's own stars it is the scene's. */
TEST(position_angles_are_on_the_sky) {
    toliman_sim *const sim = sim_with(kBinaryScene, "\"pixel_scale_arcsec\": 0.2",
                                      "\"pixel_scale_arcsec\": 0.2, \"rotation_deg\": 75, \"shear\": 1e-3");
    toliman_fit *const fit = fit_of(sim, NULL);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    const toliman_fit_result result = fitted(fit, image, NULL, NULL);
    assert_close(result.position_angle_deg, 30, 0, 1e-8);
    free(image), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* The Fisher matrix of places, fluxes and background, from differences of propagated images. */
/* promise: covariances-are-bounds */
TEST(covariances_are_the_cramer_rao_bound) {
    static double slope[N][PIXELS];
    toliman_sim *const sim = scene_of(kPlaces, 0, "", "");
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    double *const star[2] = {image_of(sim, TOLIMAN_SIM_IMAGE_STAR_A), image_of(sim, TOLIMAN_SIM_IMAGE_STAR_B)};
    const double h = 1e-4;
    for (int i = 0; i < 4; i++) {
        double *sides[2];
        for (int side = 0; side < 2; side++) {
            double places[4];
            memcpy(places, kPlaces, sizeof places);
            places[i] += side == 0 ? -h : h;
            toliman_sim *const moved = scene_of(places, 0, "", "");
            sides[side] = image_of(moved, TOLIMAN_SIM_IMAGE_BOTH);
            toliman_sim_destroy(moved);
        }
        for (int p = 0; p < PIXELS; p++)
            slope[i][p] = (sides[1][p] - sides[0][p]) / (2 * h);
        free(sides[0]), free(sides[1]);
    }
    long double fisher[N][N] = {{0}}, bound[N][N];
    for (int p = 0; p < PIXELS; p++) {
        slope[4][p] = star[0][p];
        slope[5][p] = star[1][p];
        slope[6][p] = 1;
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++)
                fisher[i][j] += (long double)slope[i][p] * slope[j][p] / (image[p] + 6.25L);
    }
    memcpy(bound, fisher, sizeof bound);
    invert(N, bound[0]);
    const double apart[2] = {kPlaces[2] - kPlaces[0], kPlaces[3] - kPlaces[1]}, separation = separation_of(kPlaces);
    const double share = kFlux[1] / (kFlux[0] + kFlux[1]);
    const double along[2] = {apart[0] / separation, apart[1] / separation};
    /* Derivatives of separation, position angle (deg), shift_x by the places. */
    const double turn = 180 / acos(-1) / separation;
    const double rows[3][4] = {{-along[0], -along[1], along[0], along[1]},
                               {along[1] * turn, -along[0] * turn, -along[1] * turn, along[0] * turn},
                               {1 - share, 0, share, 0}};
    toliman_fit *const fit = fit_of(sim, NULL);
    double covariance[N][N], values[N], expected[PIXELS];
    assert_ok(toliman_fit_predict(fit, NULL, expected, SIDE, values, &covariance[0][0]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < N; j++) {
            long double exact = 0;
            for (int k = 0; k < 4; k++)
                for (int l = 0; l < 4; l++)
                    exact += rows[i][k] * (j < 3 ? bound[k][l] * rows[j][l] : l == 0 ? bound[k][j] : 0);
            if (j != 3)
                assert_close(covariance[i][j], (double)exact, 0, 1e-5 * sqrt(covariance[i][i] * covariance[j][j]));
        }
    for (int j = 4; j < N; j++)
        assert_close(covariance[j][j], (double)bound[j][j], 1e-5, 0);
    for (int p = 0; p < PIXELS; p++)
        assert_close(expected[p], image[p], 1e-7, 1e-3);
    const toliman_fit_result result = fitted(fit, image, NULL, NULL);
    assert_close(result.separation_sigma_px, sqrt(covariance[0][0]), 1e-9, 0);
    toliman_fit_destroy(fit), free(image), free(star[0]), free(star[1]), toliman_sim_destroy(sim);
}

/* The template is one step of the fit from the scene's places: to first order in the noise both agree. */
TEST(the_template_is_one_step) {
    static const char *const free_in_both =
        ", \"preprocess\": {\"project\": [\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\", \"roll\", \"background\"]}";
    toliman_sim *const sim = scene_of(kPlaces, 0, "", free_in_both);
    toliman_fit *const fit = fit_of(sim, NULL);
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    double sigma;
    assert_ok(toliman_linear_get_sigma(linear, &sigma));
    static double frames[FRAMES * PIXELS];
    assert_ok(toliman_sim_frame(sim, NULL, 5, 0, FRAMES, frames));
    for (int k = 0; k < FRAMES; k++) {
        double value;
        assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frames + k * PIXELS), 1, &value, NULL));
        const toliman_fit_result result = fitted(fit, frames + k * PIXELS, NULL, NULL);
        assert_close(result.separation_sigma_px, sigma, 1e-2, 0);
        assert_close(result.displacement_px, value, 0, 0.01 * sigma);
    }
    toliman_linear_destroy(linear), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* Stars up to 15 px from their places. */
TEST(stars_are_searched_for) {
    static const double shifts[][2] = {{0.9, 0.4}, {3, -2.3}, {-8.4, 5.1}, {14.6, -14.7}, {-14.9, 14.2}};
    toliman_sim *const sim = scene_of(kPlaces, 0, "", "");
    toliman_fit *const fit = fit_of(sim, NULL);
    static double counts[PIXELS];
    for (size_t s = 0; s < 5; s++) {
        double places[4];
        for (size_t i = 0; i < 4; i++)
            places[i] = kPlaces[i] + shifts[s][i % 2];
        toliman_sim *const truth = scene_of(places, 0, "", "");
        assert_ok(toliman_sim_frame(truth, &(double){0}, 11, (int64_t)s, 1, counts));
        const toliman_fit_result result = fitted(fit, counts, NULL, NULL);
        assert_int_equal(result.flags, TOLIMAN_FIT_SEARCHED);
        assert_close(result.displacement_px, 0, 0, 5 * result.separation_sigma_px);
        assert_close(result.x_px, shifts[s][0], 0, 5 * result.x_sigma_px);
        assert_close(result.y_px, shifts[s][1], 0, 5 * result.y_sigma_px);
        /* A prediction of the pointing makes the search unnecessary, and changes the result by less than the places
         * may still move. */
        const toliman_fit_prediction near = {
            .struct_size = sizeof near, .x_px = shifts[s][0] + 0.1, .y_px = shifts[s][1] - 0.1};
        const toliman_fit_result again = fitted(fit, counts, &near, NULL);
        assert_int_equal(again.flags, 0);
        assert_close(again.separation_px, result.separation_px, 0, 1e-7);
        assert_true(again.iterations <= result.iterations);
        toliman_sim_destroy(truth);
    }
    toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* Where fringes are narrow, steps from 1.9 px away, almost along y, end at a false maximum: the search corrects them.
 */
TEST(false_maxima_are_left) {
    char *const text =
        replaced_again(scene_text(kPlaces, 0, "", ""), "\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 1");
    toliman_sim *const sim = sim_of(text);
    toliman_fit *const fit = fit_of(sim, NULL);
    static double counts[PIXELS];
    assert_ok(toliman_sim_frame(sim, &(double){0}, 11, 3, 1, counts));
    static const double shifts[][2] = {{0.025, 1.918}, {-0.076, 2.083}};
    for (int i = 0; i < 2; i++) {
        const toliman_fit_prediction far = {.struct_size = sizeof far, .x_px = shifts[i][0], .y_px = shifts[i][1]};
        const toliman_fit_result result = fitted(fit, counts, &far, NULL);
        assert_int_equal(result.flags, TOLIMAN_FIT_SEARCHED);
        assert_close(result.x_px, 0, 0, 5 * result.x_sigma_px);
        assert_close(result.y_px, 0, 0, 5 * result.y_sigma_px);
    }
    free(text), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* Scatter of noisy frames with pointing in units of their own standard deviations; the same with saturated pixels and
 * with few photons. */
/* promise: covariances-are-bounds */
TEST(errors_are_as_predicted) {
    static const char *const pointing = ", \"systematics\": {\"pointing_rms_px\": 0.3}";
    static const struct {
        const char *detector;
        uint32_t flags;
    } cases[] = {{"", 0}, {", \"full_well_e\": 1.5e5", TOLIMAN_FIT_SATURATED}, {", \"qe\": 1e-3", 0}};
    for (size_t c = 0; c < 3; c++) {
        toliman_sim *const sim = scene_of(kPlaces, 0, cases[c].detector, pointing);
        toliman_fit *const fit = fit_of(sim, NULL);
        static double frames[FRAMES * PIXELS];
        assert_ok(toliman_sim_frame(sim, NULL, 9, 0, FRAMES, frames));
        toliman_fit_result results[FRAMES] = {{.struct_size = sizeof *results}};
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames), FRAMES, NULL, results, NULL, NULL));
        double sum = 0, square = 0, chi_square = 0, largest = 0;
        for (int k = 0; k < FRAMES; k++) {
            const double pull = results[k].displacement_px / results[k].separation_sigma_px;
            assert_int_equal(results[k].flags & ~TOLIMAN_FIT_SEARCHED, cases[c].flags);
            assert_true((results[k].excluded > 0) == (cases[c].flags != 0));
            sum += pull;
            square += pull * pull;
            largest = fmax(largest, fabs(pull));
            chi_square += results[k].chi_square / FRAMES;
        }
        print_message("%s: mean pull %.2f, rms %.2f, largest %.2f, chi-square %.4f\n", cases[c].detector, sum / FRAMES,
                      sqrt(square / FRAMES), largest, chi_square);
        assert_close(sum / FRAMES, 0, 0, 0.35); /* 3.5 standard errors */
        assert_close(sqrt(square / FRAMES), 1, 0, 0.25);
        assert_at_most(largest, 5);
        assert_close(chi_square, 1, 0, 0.05);
        toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    }
}

/* With few photons and an exact prediction, steps are not much shorter from one to the next. */
TEST(faint_frames_converge) {
    char *text = scene_text(kPlaces, 0, "", "");
    text = replaced_again(text, "\"exposure_s\": 100", "\"exposure_s\": 0.01");
    text = replaced_again(text, "\"read_e\": 2.5", "\"read_e\": 1.3");
    toliman_sim *const sim = sim_of(text);
    toliman_fit *const fit = fit_of(sim, NULL);
    static double counts[PIXELS];
    int lost = 0;
    for (int k = 0; k < 200; k++) {
        assert_ok(toliman_sim_frame(sim, &(double){0}, 11, k, 1, counts));
        const toliman_fit_result result = fitted(fit, counts, NULL, NULL);
        if ((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0)
            lost++;
        else
            assert_close(result.displacement_px, 0, 0, 5 * result.separation_sigma_px);
    }
    assert_at_most(lost, 1);
    free(text), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* A damaged frame has a flag; whatever the frame, numbers are finite unless it did not converge. */
/* promise: unfitted-frames-are-nan */
TEST(damage_is_flagged) {
    toliman_sim *const sim = scene_of(kPlaces, 0, "", "");
    toliman_fit *const fit = fit_of(sim, NULL);
    double *const good = malloc(PIXELS * sizeof *good), *const bad = malloc(PIXELS * sizeof *bad);
    assert_true(good != NULL && bad != NULL);
    assert_ok(toliman_sim_frame(sim, &(double){0}, 3, 0, 1, good));
    const toliman_fit_result clean = fitted(fit, good, NULL, NULL);
    assert_int_equal(clean.flags, 0);
    for (int kind = 0; kind < 8; kind++) {
        uint64_t seed = 5;
        memcpy(bad, good, PIXELS * sizeof *bad);
        for (int p = 0; p < PIXELS; p++) {
            const int row = p / SIDE, col = p % SIDE;
            if (kind == 0)
                bad[p] = 0;
            else if (kind == 1 && row >= 32)
                bad[p] = 0; /* lost packets */
            else if (kind == 2 && row == 20)
                bad[p] = 1e7; /* a hot row */
            else if (kind == 3)
                bad[p] = good[(SIDE - 1 - row) * SIDE + col]; /* upside down */
            else if (kind == 4)
                bad[p] = 1e6 * fabs(uniform_signed(&seed));
            else if (kind == 5)
                bad[p] = -1e300;
            else if (kind == 6)
                bad[p] = 4 * good[p]; /* another unit */
            else if (kind == 7)
                bad[p] = p == 30 * SIDE + 40 ? 1e5 : good[p]; /* a cosmic ray */
        }
        const toliman_fit_result result = fitted(fit, bad, NULL, NULL);
        const int damaged = (result.flags & (TOLIMAN_FIT_NOT_CONVERGED | TOLIMAN_FIT_EDGE)) != 0 ||
                            result.goodness == TOLIMAN_GOODNESS_POOR;
        const int relative = kind == 6; /* a frame four times brighter has a good fit, with its flux */
        print_message("damage %d: flags %u, chi-square %.3g\n", kind, result.flags, result.chi_square);
        if (kind == 7) { /* left out */
            assert_int_equal(result.bad_pixels, 1);
            assert_int_equal(result.goodness, TOLIMAN_GOODNESS_GOOD);
            assert_close(result.displacement_px, clean.displacement_px, 0, 0.2 * clean.separation_sigma_px);
        } else {
            assert_int_equal(result.bad_pixels, 0);
            assert_true(damaged || (relative && fabs(result.flux_a - 3) < 0.01));
        }
        assert_true(isfinite(result.separation_px) == !(result.flags & TOLIMAN_FIT_NOT_CONVERGED));
        assert_true(isfinite(result.displacement_px) == isfinite(result.separation_px));
    }
    free(good), free(bad), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* Focus, scale or jitter that differ from the scene's: fitted, they leave the separation as it is; not fitted, focus
 * and jitter do not (the control). */
TEST(freed_parameters_are_found) {
    static const struct {
        const char *from, *to;
        int number; /* of the parameter */
        double value, control_px;
    } cases[] = {{"\"pupil_samples\": 96", "\"pupil_samples\": 96, \"aberrations\": {\"zernike_rms_nm\": {\"4\": 1}}",
                  N, 1, 1e-5},
                 {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.19999800002", N + 1, 1e-5, 0},
                 {"\"noise\"", "\"systematics\": {\"jitter_covariance_px2\": {\"xx\": 1e-3, \"yy\": 1e-3}}, \"noise\"",
                  N + 2, 1e-3, 5e-8}};
    toliman_sim *const sim = scene_of(kPlaces, 0, "", "");
    toliman_fit *const fixed = fit_of(sim, NULL), *const fit = fit_of(sim, "focus scale jitter_xx jitter_yy jitter_xy");
    for (size_t c = 0; c < 3; c++) {
        char *const text = replaced_again(scene_text(kPlaces, 0, "", ""), cases[c].from, cases[c].to);
        toliman_sim *const truth = sim_of(text);
        double *const image = image_of(truth, TOLIMAN_SIM_IMAGE_BOTH), values[N + 5];
        const toliman_fit_result result = fitted(fit, image, NULL, values), control = fitted(fixed, image, NULL, NULL);
        print_message("%.20s...: fitted %.1e px; not fitted: %.1e px, chi-square %.3g\n", cases[c].to,
                      result.displacement_px, control.displacement_px, control.chi_square);
        assert_close(result.displacement_px, 0, 0, 5e-8);
        assert_close(values[cases[c].number], cases[c].value, 1e-2, 0);
        assert_true(fabs(control.displacement_px) >= cases[c].control_px);
        free(image), free(text), toliman_sim_destroy(truth);
    }
    toliman_fit_destroy(fixed), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

/* Parameters whose derivative is an image of its own, of one star or of both. */
TEST(spectra_and_aberrations_are_found) {
    static const struct {
        const char *name, *from, *to;
        double value, error_px;
    } cases[] = {{"temperature_b", "\"temperature_k\": 5260", "\"temperature_k\": 5259", -1, 1e-9},
                 {"zernike_7", "\"pupil_samples\": 96",
                  "\"pupil_samples\": 96, \"aberrations\": {\"zernike_rms_nm\": {\"7\": 0.1}}", 0.1, 2e-6}};
    toliman_sim *const sim = scene_of(kPlaces, 0, ", \"pixel\": \"integrated\"", "");
    for (size_t c = 0; c < 2; c++) {
        toliman_fit *const fit = fit_of(sim, cases[c].name);
        char *const text =
            replaced_again(scene_text(kPlaces, 0, ", \"pixel\": \"integrated\"", ""), cases[c].from, cases[c].to);
        toliman_sim *const truth = sim_of(text);
        double *const image = image_of(truth, TOLIMAN_SIM_IMAGE_BOTH), values[N + 1];
        const toliman_fit_result result = fitted(fit, image, NULL, values);
        assert_int_equal(result.flags, 0);
        assert_close(values[N], cases[c].value, 1e-3, 0);
        assert_close(result.displacement_px, 0, 0, cases[c].error_px);
        free(image), free(text), toliman_sim_destroy(truth), toliman_fit_destroy(fit);
    }
    toliman_sim_destroy(sim);
}

/* Without struts, defocus has no first-order effect behind this mask: its sign cannot be known. */
TEST(parameters_without_effect_are_refused) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "focus"};
    toliman_fit *fit = NULL;
    assert_refused(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &fit), TOLIMAN_E_SCENE,
                   "options->free");
    assert_null(fit);
    toliman_sim_destroy(sim);
}

TEST(frames_with_too_few_pixels_are_refused) {
    static const struct {
        const char *from, *to, *field;
    } cases[] = {{"[64, 64]", "[2, 2]", "detector"}, {"\"bit_depth\": 16", "\"bit_depth\": 1", "detector"}};
    for (size_t c = 0; c < 2; c++) {
        char *const text =
            replaced_again(scene_text(kPlaces, 0, ", \"bit_depth\": 16", ""), cases[c].from, cases[c].to);
        toliman_sim *const sim = sim_of(text);
        toliman_fit *fit = NULL;
        assert_refused(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit), TOLIMAN_E_SCENE,
                       cases[c].field);
        assert_null(fit);
        toliman_sim_destroy(sim), free(text);
    }
}

RUN_TESTS(NULL, NULL)
