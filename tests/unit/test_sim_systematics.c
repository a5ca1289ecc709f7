/* Tests systematic effects: disturbed frames against scenes with these parameters, the random draws against their
 * distribution, and estimators that project the effects out. */
#include <stdio.h>

#include <toliman/linear.h>

#include "images.h"
#include "scene_text.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

static const double kStars[4] = {-4.5, -8.2, 5.1, 9.3};
static const char *const kProject = "'flux_a', 'flux_b', 'shift_x', 'shift_y'";

/* Both stars at given positions (px), without noise, observed for 10 s; `extra` is added to the scene. */
static char *text_with(const double places[4], const char *extra) {
    char binary[200], end[600];
    char *scene = EDITED(kBinaryScene, {"'peak_photons': 1e5", "'exposure_s': 10"},
                         {"'m': 5", "'m': 6"}); /* with odd waves alone, defocus has no first-order effect */
    scene = replaced_again(scene, "'relative_flux': 3", "'photons_per_s': 3e7");
    scene = replaced_again(scene, "5260}}}", "5260}, 'photons_per_s': 1e7}}");
    snprintf(binary, sizeof binary, "'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}", places[0], places[1],
             places[2], places[3]);
    scene = replaced_again(scene, "'separation_arcsec': 4, 'position_angle_deg': 30", binary);
    snprintf(end, sizeof end, "'noise': {'seed': 7}%s%s}", extra[0] != '\0' ? ", " : "", extra);
    return replaced_again(scene, "'noise': {'photon': true, 'read_e': 2.5, 'seed': 7}}", end);
}

static char heard[1000];

static void record_log(int32_t level, const char *text, void *user_data) {
    (void)level;
    (void)user_data;
    strncat(heard, text, sizeof heard - strlen(heard) - 1);
}

static toliman_sim *made(char *text) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.log = record_log;
    heard[0] = '\0';
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
    free(text);
    return sim;
}

static toliman_sim *make(const double places[4], const char *extra) {
    return made(text_with(places, extra));
}

static void frame_of(const toliman_sim *sim, double displacement, int64_t k, double *image) {
    assert_ok(toliman_sim_frame(sim, &displacement, 1, k, 1, image));
}

/* Frame k, and its change by the signal, against a scene with the stars at `places`. The signal must agree to 1e-9 of
 * itself plus the rounding of images, 1e-14 of the peak. */
static void check_places(const char *systematics, int64_t k, const double places[4]) {
    const double displacement = 1e-3;
    double image[PIXELS], still[PIXELS], expected[PIXELS], expected_still[PIXELS], ratio = 0;
    toliman_sim *const sim = make(kStars, systematics), *const other = make(places, "");
    frame_of(sim, displacement, k, image);
    frame_of(sim, 0, k, still);
    assert_ok(toliman_sim_propagate(other, displacement, expected, SIDE));
    assert_ok(toliman_sim_propagate(other, 0, expected_still, SIDE));
    assert_at_most(peak_difference(still, expected_still, PIXELS), 1e-9);
    assert_at_most(peak_difference(image, expected, PIXELS), 1e-9);
    for (size_t i = 0; i < PIXELS; i++) {
        image[i] -= still[i];
        expected[i] -= expected_still[i];
        ratio = fmax(ratio, fabs(expected[i]));
    }
    assert_true(ratio > 0);
    assert_at_most(peak_difference(image, expected, PIXELS), 1e-9 + 1e-11);
    assert_at_most(1e-3, peak_difference(still, image, PIXELS)); /* the disturbance is visible */
    toliman_sim_destroy(sim), toliman_sim_destroy(other);
}

/* What the plan reports for a scene with these systematic effects. */
static toliman_sim_plan_info plan_of(const char *systematics) {
    toliman_sim *const sim = make(kStars, systematics);
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_sim_get_plan(sim, &plan));
    toliman_sim_destroy(sim);
    return plan;
}

/* Systematics are interpolated; without them, or at an accuracy beyond an interpolation, there is none. */
TEST(the_plan_reports_the_places) {
    const toliman_sim_plan_info none = plan_of(""), little = plan_of("'systematics': {'pointing_rms_px': 1e-5}");
    const toliman_sim_plan_info more = plan_of("'systematics': {'pointing_rms_px': 1e-5, 'focus_rms_nm': 1}");
    const toliman_sim_plan_info far = plan_of("'systematics': {'pointing_rms_px': 1}");
    const toliman_sim_plan_info coarse = plan_of("'systematics': {'pointing_rms_px': 1}, 'accuracy': 1e-3");
    const toliman_sim_plan_info exact = plan_of("'systematics': {'pointing_rms_px': 1}, 'accuracy': 1e-15");
    assert_true(none.atlas_taps == 0 && none.atlas_oversampling == 0 && none.atlas_error <= 0);
    assert_true(more.atlas_taps == 0 && more.exact_frames == 1); /* optics that differ */
    assert_true(exact.atlas_taps == 0 && exact.exact_frames == 1 && far.exact_frames == 0);
    assert_true(little.atlas_taps == far.atlas_taps && coarse.atlas_taps < far.atlas_taps);
    assert_true(far.atlas_error > 0 && far.atlas_error <= 1e-9);
    assert_true(none.setup_flops < little.setup_flops && little.setup_flops < far.setup_flops);
    assert_true(none.frame_flops < little.frame_flops && little.frame_flops < more.frame_flops);
    assert_true(little.bytes < far.bytes);
}

static void check_shift(double drift, int64_t k) {
    char extra[100];
    double places[4];
    snprintf(extra, sizeof extra, "'systematics': {'pointing_rms_px': {'rms': 0, 'drift_per_day': %g}}", drift);
    for (size_t i = 0; i < 4; i++)
        places[i] = kStars[i] + drift * 2 * (double)k;
    check_places(extra, k, places);
}

/* One star, in more wavelengths than are computed, against itself at the other position in each wavelength. */
TEST(pointing_moves_a_single_star) {
    static double moved[32 * 32], there[32 * 32];
    char *text = EDITED(
        kSingleScene, {"{'wavelength_nm': 550}", "{'min_nm': 550, 'max_nm': 600, 'step_nm': 1}"},
        {"'cadence'", "'systematics': {'pointing_rms_px': {'rms': 0, 'drift_per_day': 1e-3}}, 'cadence'"},
        {"'peak_photons': 1e6", "'exposure_s': 1, 'interval_days': 2"}, {"5790}", "5790}, 'photons_per_s': 1e6"});
    toliman_sim *const sim = sim_of(text);
    text = replaced_again(text, "'drift_per_day': 1e-3", "'drift_per_day': 0");
    text = replaced_again(text, "'A': [0, 0]", "'A': [0.014, 0.014]");
    text = replaced_again(text, "'cadence'", "'accuracy': 1e-15, 'cadence'");
    toliman_sim *const other = sim_of(text);
    free(text);
    toliman_sim_plan_info plan = {.struct_size = sizeof plan}, exact = plan;
    assert_ok(toliman_sim_get_plan(sim, &plan));
    assert_ok(toliman_sim_get_plan(other, &exact));
    assert_true(plan.wavelengths < exact.wavelengths);
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 7, 1, moved));
    assert_ok(toliman_sim_propagate(other, 0, there, 32));
    double worst = 0, peak = 0;
    for (int i = 0; i < 32 * 32; i++) {
        worst = fmax(worst, fabs(moved[i] - there[i]));
        peak = fmax(peak, there[i]);
    }
    assert_at_most(worst / peak, 1e-9);
    toliman_sim_destroy(sim), toliman_sim_destroy(other);
}

TEST(pointing_moves_both_stars) {
    check_shift(1e-4, 99);
    check_shift(1e-4, 1);
    check_shift(-0.02, 70);
}

static void check_roll(double drift_deg, int64_t k) {
    char extra[100];
    snprintf(extra, sizeof extra, "'systematics': {'roll_rms_deg': {'rms': 0, 'drift_per_day': %g}}", drift_deg);
    const double angle = drift_deg * 2 * (double)k * acos(-1) / 180, c = cos(angle), s = sin(angle);
    const double places[4] = {c * kStars[0] - s * kStars[1], s * kStars[0] + c * kStars[1],
                              c * kStars[2] - s * kStars[3], s * kStars[2] + c * kStars[3]};
    check_places(extra, k, places);
}

TEST(roll_rotates_the_stars_not_their_patterns) {
    check_roll(1e-3, 99);
    check_roll(0.04, 90);
}

/* The alias of a moving star must not enter the frame. */
TEST(aliases_are_refused) {
    toliman_sim *sim = NULL;
    const char *const systematics[] = {"", "'systematics': {'pointing_rms_px': 10}"};
    for (size_t i = 0; i < 2; i++) {
        char *const text =
            replaced_again(text_with(kStars, systematics[i]), "'pupil_samples': 96", "'pupil_samples': 24");
        if (i == 0) {
            assert_ok(toliman_sim_create_json(text, strlen(text), NULL, NULL, &sim));
            toliman_sim_destroy(sim);
        } else {
            assert_refused(toliman_sim_create_json(text, strlen(text), NULL, NULL, &sim), TOLIMAN_E_SCENE,
                           "telescope.pupil_samples");
        }
        free(text);
    }
}

/* Also the star of the signal, for frames outside the cadence. */
TEST(fluxes_multiply) {
    toliman_sim *const sim =
        make(kStars, "'systematics': {'flux_rms': {'rms': 0, 'drift_per_day': -1e-4}}, 'accuracy': 1e-12");
    double image[PIXELS], expected[PIXELS];
    frame_of(sim, 1e-3, 30, image);
    assert_ok(toliman_sim_propagate(sim, 1e-3, expected, SIDE));
    for (size_t i = 0; i < PIXELS; i++)
        expected[i] *= 1 - 6e-3;
    assert_at_most(peak_difference(image, expected, PIXELS), 1e-12);
    toliman_sim_destroy(sim);
}

/* Frame 99 against a scene with the optics of that frame, also far beyond a second order of them.
 * promise: optics-of-frames-are-exact */
TEST(optics_of_frames_are_exact) {
    const struct {
        const char *drifts, *zernikes; /* per day, and after 198 days */
        double scale;
    } cases[] = {
        {"'focus_rms_nm': {'rms': 0, 'drift_per_day': 0.005}", "'4': 0.99", 0},
        {"'focus_rms_nm': {'rms': 0, 'drift_per_day': -1}", "'4': -198", 0},
        {"'zernike_rms_nm': {'7': {'rms': 0, 'drift_per_day': 0.5}, '22': {'rms': 0, 'drift_per_day': 0.1}}",
         "'7': 99, '22': 19.8", 0},
        {"'scale_rms': {'rms': 0, 'drift_per_day': 1e-6}", "'1': 0", 1.98e-4},
        {"'scale_rms': {'rms': 0, 'drift_per_day': -5e-5}, 'focus_rms_nm': {'rms': 0, 'drift_per_day': 0.1},"
         " 'zernike_rms_nm': {'5': {'rms': 0, 'drift_per_day': -0.1}}",
         "'4': 19.8, '5': -19.8", -9.9e-3},
    };
    const char *const pixels[] = {"point", "integrated"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char extra[300], optics[200], pitch[100], integration[60];
        double image[PIXELS], bare[PIXELS], places[4];
        snprintf(integration, sizeof integration, "'pixel': '%s', 'shape'", pixels[i % 2]);
        snprintf(extra, sizeof extra, "'accuracy': 1e-12, 'systematics': {%s}", cases[i].drifts);
        snprintf(optics, sizeof optics, "'aberrations': {'zernike_rms_nm': {%s}}, 'aperture_m'", cases[i].zernikes);
        snprintf(pitch, sizeof pitch, "'pixel_scale_arcsec': %.17g", 0.2 / (1 + cases[i].scale));
        for (size_t j = 0; j < 4; j++)
            places[j] = kStars[j] * (1 + cases[i].scale);
        char *text = replaced_again(text_with(places, "'accuracy': 1e-12"), "'aperture_m'", optics);
        text = replaced_again(text, "'pixel_scale_arcsec': 0.2", pitch);
        toliman_sim *const other = made(replaced_again(text, "'shape'", integration)), *const sim = made(replaced_again(
                                                                                           text_with(kStars, extra),
                                                                                           "'shape'", integration));
        frame_of(sim, 0, 0, bare);
        frame_of(sim, 0, 99, image);
        double *const expected = image_of(other, TOLIMAN_SIM_IMAGE_BOTH);
        assert_at_most(peak_difference(image, expected, PIXELS), 1e-10);
        assert_true(peak_difference(bare, expected, PIXELS) > 1e-4);
        free(expected), toliman_sim_destroy(sim), toliman_sim_destroy(other);
    }
}

/* Solves a x = b for several right-hand sides, largest pivot first; the solutions replace b[count][n]. */
static void solve(size_t n, double *a, size_t count, double *b) {
    for (size_t i = 0; i < n; i++) {
        size_t p = i;
        for (size_t r = i + 1; r < n; r++)
            if (fabs(a[r * n + i]) > fabs(a[p * n + i]))
                p = r;
        for (size_t c = 0; c < n; c++) {
            const double swap = a[i * n + c];
            a[i * n + c] = a[p * n + c];
            a[p * n + c] = swap;
        }
        for (size_t k = 0; k < count; k++) {
            const double swap = b[k * n + i];
            b[k * n + i] = b[k * n + p];
            b[k * n + p] = swap;
        }
        for (size_t r = 0; r < n; r++) {
            const double factor = r == i ? 0 : a[r * n + i] / a[i * n + i];
            for (size_t c = i; c < n; c++)
                a[r * n + c] -= factor * a[i * n + c];
            for (size_t k = 0; k < count; k++)
                b[k * n + r] -= factor * b[k * n + i];
        }
    }
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < n; i++)
            b[k * n + i] /= a[i * n + i];
}

/* Recovers the random draws from frames without noise by least squares on the effect of each disturbance: nine
 * independent sequences of mean 0 and the requested rms. Common drifts, which provide the effects, are tested above. */
TEST(draws_follow_their_distribution) {
    enum { kinds = 9, frames = 400 };
    static const char *const names[] = {"'roll_rms_deg': ", "'scale_rms': ", "'focus_rms_nm': ",
                                        "'zernike_rms_nm': {'5': ", "'zernike_rms_nm': {'7': "};
    /* px, px, 1, 1, deg, 1, nm, nm, nm */
    static const double rms[kinds] = {1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-6, 1e-3, 1e-3, 1e-3};
    static double effect[kinds][PIXELS], image[PIXELS], values[frames][kinds], normal[kinds * kinds];
    toliman_sim *const bare = make(kStars, "");
    double *const both = image_of(bare, TOLIMAN_SIM_IMAGE_BOTH);
    const int32_t known[] = {TOLIMAN_SIM_IMAGE_SHIFT_X, TOLIMAN_SIM_IMAGE_SHIFT_Y, TOLIMAN_SIM_IMAGE_STAR_A,
                             TOLIMAN_SIM_IMAGE_STAR_B};
    for (size_t j = 0; j < 4; j++) {
        double *const derivative = image_of(bare, known[j]);
        memcpy(effect[j], derivative, sizeof effect[j]);
        free(derivative);
    }
    for (size_t j = 4; j < kinds; j++) {
        char extra[100];
        snprintf(extra, sizeof extra, "'systematics': {%s{'rms': 0, 'drift_per_day': %g}}%s", names[j - 4], rms[j],
                 j > 6 ? "}" : "");
        toliman_sim *const drifting = make(kStars, extra);
        frame_of(drifting, 0, 1, image);
        for (size_t i = 0; i < PIXELS; i++)
            effect[j][i] = (image[i] - both[i]) / (2 * rms[j]);
        toliman_sim_destroy(drifting);
    }
    toliman_sim_destroy(bare);
    for (size_t j = 0; j < kinds; j++)
        for (size_t l = 0; l < kinds; l++)
            for (size_t i = 0; i < PIXELS; i++)
                normal[j * kinds + l] += rms[j] * rms[l] * effect[j][i] * effect[l][i];

    toliman_sim *const sim = make(kStars, "'systematics': {'pointing_rms_px': 1e-5, 'flux_rms': {'rms': 1e-5},"
                                          " 'roll_rms_deg': 1e-5, 'scale_rms': 1e-6, 'focus_rms_nm': 1e-3,"
                                          " 'zernike_rms_nm': {'5': 1e-3, '7': {'rms': 1e-3}}}");
    for (int64_t k = 0; k < frames; k++) {
        frame_of(sim, 0, k, image);
        for (size_t j = 0; j < kinds; j++)
            for (size_t i = 0; i < PIXELS; i++)
                values[k][j] += rms[j] * effect[j][i] * (image[i] - both[i]);
    }
    toliman_sim_destroy(sim), free(both);
    solve(kinds, normal, frames, values[0]);
    for (size_t j = 0; j < kinds; j++) {
        for (size_t l = 0; l <= j; l++) {
            double product = 0;
            for (size_t k = 0; k < frames; k++)
                product += values[k][j] * values[k][l] / frames;
            assert_close(product, j == l ? 1 : 0, 0, (j == l ? 5 * sqrt(2.0) : 5) / sqrt(frames));
        }
        double sum = 0;
        for (size_t k = 0; k < frames; k++)
            sum += values[k][j] / frames;
        assert_close(sum, 0, 0, 5 / sqrt(frames));
    }
}

/* A blur equals the mean of shifted scenes: Gauss-Hermite quadrature with 5 x 5 shifts, accurate to 1e-9 here. */
TEST(jitter_blurs) {
    const double sigma = 0.2,
                 node[5] = {-2.0201828704560856, -0.9585724646138185, 0, 0.9585724646138185, 2.0201828704560856};
    const double weight[5] = {0.019953242059045913, 0.39361932315224116, 0.9453087204829419, 0.39361932315224116,
                              0.019953242059045913};
    double expected[PIXELS] = {0};
    for (size_t j = 0; j < 25; j++) {
        const double x = sqrt(2) * sigma * node[j % 5], y = sqrt(2) * sigma * node[j / 5];
        const double places[4] = {kStars[0] + x, kStars[1] + y, kStars[2] + x, kStars[3] + y};
        toliman_sim *const sim = make(places, "");
        double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
        for (size_t i = 0; i < PIXELS; i++)
            expected[i] += weight[j % 5] * weight[j / 5] / acos(-1) * image[i];
        free(image), toliman_sim_destroy(sim);
    }
    toliman_sim *const sharp = make(kStars, ""), *const sim = make(kStars, "'systematics': {'jitter_sigma_px': 0.2}");
    double *const bare = image_of(sharp, TOLIMAN_SIM_IMAGE_BOTH), *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    double frame[PIXELS];
    assert_at_most(1e-3, peak_difference(bare, expected, PIXELS));
    assert_at_most(peak_difference(image, expected, PIXELS), 2e-9);
    frame_of(sim, 0, 3, frame); /* the same blur in all frames */
    assert_memory_equal(frame, image, sizeof frame);
    free(bare), free(image), toliman_sim_destroy(sharp), toliman_sim_destroy(sim);
}

static const char *const kAll = "'systematics': {'pointing_rms_px': {'rms': 1e-3, 'drift_per_day': 1e-5},"
                                " 'jitter_sigma_px': 0.1, 'roll_rms_deg': 1e-3, 'scale_rms': 1e-6,"
                                " 'focus_rms_nm': 0.01, 'zernike_rms_nm': {'11': 0.02}, 'flux_rms': 1e-4}";

static char *noisy_text(const char *extra) {
    char *text = replaced_again(text_with(kStars, extra), "'seed': 7", "'photon': true, 'read_e': 2, 'seed': 7");
    return replaced_again(text, "'pixel_scale_arcsec': 0.2",
                          "'pixel_scale_arcsec': 0.2, 'qe': 0.9, 'flat_rms': 0.01, 'dark_e_per_s': 5,"
                          "'coadds': 2, 'full_well_e': 2e6, 'gain_e_per_dn': 2, 'bias_dn': 100,"
                          "'bit_depth': 24");
}

/* promise: frames-depend-on-seed-alone */
TEST(frames_do_not_depend_on_threads_or_order) {
    enum { count = 17 };
    toliman_sim *const sim = made(noisy_text(kAll));
    static double one[count][PIXELS], many[count][PIXELS], alone[PIXELS];
    assert_ok(toliman_sim_frame(sim, NULL, 7, 20, count, one[0]));
    const uint32_t workers[] = {1, 2, 3, 8};
    for (size_t i = 0; i < 4; i++) {
        char *const text = noisy_text(kAll);
        toliman_sim *const other = sim_on_threads(text, workers[i]);
        assert_ok(toliman_sim_frame(other, NULL, 7, 20, count, many[0]));
        assert_memory_equal(one, many, sizeof one);
        toliman_sim_destroy(other), free(text);
    }
    for (int64_t k = 36; k >= 20; k -= 4) {
        double displacement;
        assert_ok(toliman_sim_get_series(sim, k, 1, NULL, &displacement));
        assert_ok(toliman_sim_frame(sim, &displacement, 7, k, 1, alone));
        assert_memory_equal(one[k - 20], alone, sizeof alone);
    }
    toliman_sim_destroy(sim);
}

/* Apart from noise, the draws depend on seed and frame number; after the cadence, drifts restart. */
TEST(draws_depend_on_seed_and_number) {
    double a[PIXELS], b[PIXELS];
    toliman_sim *const random = make(kStars, "'systematics': {'pointing_rms_px': 1e-3}");
    assert_ok(toliman_sim_frame(random, &(double){0}, 1, 3, 1, a));
    assert_ok(toliman_sim_frame(random, &(double){0}, 2, 3, 1, b));
    assert_at_most(1e-5, peak_difference(a, b, PIXELS));
    assert_ok(toliman_sim_frame(random, &(double){0}, 1, 103, 1, b));
    assert_at_most(1e-5, peak_difference(a, b, PIXELS));
    toliman_sim_destroy(random);
    toliman_sim *const drift = make(kStars, "'systematics': {'pointing_rms_px': {'rms': 0, 'drift_per_day': 1e-4}}");
    assert_ok(toliman_sim_frame(drift, &(double){0}, 1, 3, 1, a));
    assert_ok(toliman_sim_frame(drift, &(double){0}, 2, 12345678900003, 1, b));
    assert_memory_equal(a, b, sizeof a);
    toliman_sim_destroy(drift);
}

TEST(zero_systematics_change_no_byte) {
    const char *const nothing[] = {"", "'systematics': {}",
                                   ("'systematics': {'pointing_rms_px': 0, 'jitter_sigma_px': 0, 'flux_rms':"
                                    " {'rms': 0, 'drift_per_day': 0}}")};
    double first[PIXELS], image[PIXELS];
    for (size_t i = 0; i < 3; i++) {
        toliman_sim *const sim = made(noisy_text(nothing[i]));
        assert_ok(toliman_sim_frame(sim, &(double){1e-3}, 7, 3, 1, i == 0 ? first : image));
        if (i > 0)
            assert_memory_equal(first, image, sizeof image);
        toliman_sim_destroy(sim);
    }
}

/* Rms of the template's values over frames with pointing errors of 1e-3 px and flux errors of 1e-4, without noise. */
static double rms_bias(const char *project) {
    enum { frames = 50 };
    char extra[200];
    snprintf(extra, sizeof extra,
             "'systematics': {'pointing_rms_px': 1e-3, 'flux_rms': 1e-4}, 'preprocess': {'project': [%s]}", project);
    toliman_sim *const sim = make(kStars, extra);
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    double squares = 0, image[PIXELS];
    for (int64_t k = 0; k < frames; k++) {
        double value;
        frame_of(sim, 1e-6, k, image);
        assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(image), 1, &value, NULL));
        squares += (value - 1e-6) * (value - 1e-6) / frames;
    }
    toliman_linear_destroy(linear), toliman_sim_destroy(sim);
    return sqrt(squares);
}

TEST(projection_makes_estimators_blind) {
    assert_at_most(1e-4, rms_bias(""));
    assert_at_most(rms_bias(kProject), 5e-7);
}

TEST(impossible_systematics) {
    const refusal cases[] = {
        {"'noise'", "'systematics': {'pointing_rms_px': -1}, 'noise'", "systematics.pointing_rms_px"},
        {"'noise'", "'systematics': {'roll_rms_deg': 11}, 'noise'", "systematics.roll_rms_deg"},
        {"'noise'", "'systematics': {'scale_rms': 'much'}, 'noise'", "systematics.scale_rms"},
        {"'noise'", "'systematics': {'focus_rms_nm': {}}, 'noise'", "systematics.focus_rms_nm.rms"},
        {"'noise'", "'systematics': {'zernike_rms_nm': 1}, 'noise'", "systematics.zernike_rms_nm"},
        {"'noise'", "'systematics': {'zernike_rms_nm': {'4': 1}}, 'noise'", "systematics.zernike_rms_nm.4"},
        {"'noise'", "'systematics': {'zernike_rms_nm': {'5': -1}}, 'noise'", "systematics.zernike_rms_nm.5"},
        {"'noise'", "'systematics': {'zernike_rms_nm': {'5': {'rms': 1, 'drift_per_day': 9}}}, 'noise'",
         "systematics.zernike_rms_nm.5.drift_per_day"},
        {"'noise'", "'systematics': {'flux_rms': {'rms': 0.2}}, 'noise'", "systematics.flux_rms.rms"},
        {"'noise'", "'systematics': {'flux_rms': {'rms': 0, 'drift': 1}}, 'noise'", "systematics.flux_rms.drift"},
        {"'noise'", "'systematics': {'flux_rms': {'rms': 0, 'drift_per_day': -1}}, 'noise'",
         "systematics.flux_rms.drift_per_day"},
        {"'noise'", "'systematics': {'pointing_rms_px': {'rms': 0, 'drift_per_day': -0.1}}, 'noise'",
         "systematics.pointing_rms_px.drift_per_day"},
        {"'noise'", "'systematics': {'pointing': 1}, 'noise'", "systematics.pointing"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
    /* Twice the light must still be within the range of the Poisson generator. */
    char *const bright = replaced(kBinaryScene, "1e5", "6e11");
    toliman_sim_destroy(sim_of(bright));
    const refusal flux[] = {{"'noise'", "'systematics': {'flux_rms': 0.01}, 'noise'", "cadence"}};
    CHECK_REFUSALS(bright, TOLIMAN_E_SCENE, flux);
    free(bright);
}

RUN_TESTS(NULL, NULL)
