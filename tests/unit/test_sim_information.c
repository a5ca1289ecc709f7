/* Tests Cramer-Rao bounds against the inverse Fisher matrix, and the known bounds of the shipped scenes. */
#include "scene_text.h"

enum { PARAMETERS = 9 };

/* Standard deviation of parameter 0 with all others free: square root of the first element of the inverse Fisher
 * matrix. */
static double deviation(double *const *images, size_t count, const double *variance, size_t pixels) {
    long double fisher[PARAMETERS][PARAMETERS + 1] = {{0}};
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b < count; b++)
            for (size_t i = 0; i < pixels; i++)
                fisher[a][b] += (long double)images[a][i] * images[b][i] / variance[i];
    fisher[0][count] = 1; /* solves for the first column of the inverse */
    for (size_t k = 0; k < count; k++) {
        for (size_t a = k + 1; a < count; a++) {
            const long double factor = fisher[a][k] / fisher[k][k];
            for (size_t b = k; b <= count; b++)
                fisher[a][b] -= factor * fisher[k][b];
        }
    }
    for (size_t k = count; k-- > 0;) {
        for (size_t b = k + 1; b < count; b++)
            fisher[k][count] -= fisher[k][b] * fisher[b][count];
        fisher[k][count] /= fisher[k][k];
    }
    return (double)sqrtl(fisher[0][count]);
}

TEST(bounds_match_the_fisher_matrix) {
    toliman_sim *const sim =
        sim_with(kBinaryScene, "'noise'", "'preprocess': {'project': ['shift_y', 'flux_b']}, 'noise'");
    const int32_t kinds[PARAMETERS] = {
        TOLIMAN_SIM_IMAGE_SEPARATION, TOLIMAN_SIM_IMAGE_SHIFT_Y, TOLIMAN_SIM_IMAGE_STAR_B,
        TOLIMAN_SIM_IMAGE_SHIFT_X,    TOLIMAN_SIM_IMAGE_STAR_A,  TOLIMAN_SIM_IMAGE_ROLL,
        TOLIMAN_SIM_IMAGE_SCALE,      TOLIMAN_SIM_IMAGE_FOCUS,   TOLIMAN_SIM_IMAGE_BACKGROUND};
    double *images[PARAMETERS], *const variance = image_of(sim, TOLIMAN_SIM_IMAGE_VARIANCE);
    for (int i = 0; i < PARAMETERS; i++)
        images[i] = image_of(sim, kinds[i]);
    const toliman_sim_bounds bounds = sim_bounds_of(sim);
    assert_close(bounds.crb_px, deviation(images, 1, variance, 64 * 64), 1e-12, 0);
    assert_close(bounds.crb_projected_px, deviation(images, 3, variance, 64 * 64), 1e-12, 0);
    assert_close(bounds.crb_flux_shift_px, deviation(images, 5, variance, 64 * 64), 1e-12, 0);
    assert_close(bounds.crb_marginal_px, deviation(images, 9, variance, 64 * 64), 1e-9, 0);
    assert_true(bounds.crb_flux_shift_px < bounds.crb_marginal_px);
    assert_true(bounds.crb_px < bounds.crb_projected_px && bounds.crb_projected_px < bounds.crb_flux_shift_px);
    for (int i = 0; i < PARAMETERS; i++)
        free(images[i]);
    free(variance), toliman_sim_destroy(sim);
}

/* Bounds of a coarse scene are those of a fine one, although its own images would give 0.6 times the marginal bound. */
TEST(bounds_do_not_depend_on_the_accuracy) {
    char *const clear = replaced(kBinaryScene,
                                 ",  'mask': {'kind': 'spiral', 'edges': 'cell', 'opd_nm': 297.5,"
                                 "   'terms': [{'a': 0.819, 'f': 2.918, 'm': -7, 'p': 4.874}, "
                                 "{'a': 0.93, 'f': 1.829, 'm': 5}]}",
                                 ""),
                *const wide = replaced(clear, "'min_nm': 550, 'max_nm': 600, 'step_nm': 12.5",
                                       "'min_nm': 530, 'max_nm': 640, 'step_nm': 1");
    toliman_sim_bounds fine = TOLIMAN_SIM_BOUNDS_INIT;
    const char *const accuracies[] = {"1e-12", "1e-9", "1e-6", "1e-4"};
    for (int i = 0; i < 4; i++) {
        char text[64];
        snprintf(text, sizeof text, "'accuracy': %s, 'noise'", accuracies[i]);
        toliman_sim *const sim = sim_with(wide, "'noise'", text);
        const toliman_sim_bounds bounds = sim_bounds_of(sim);
        if (i == 0)
            fine = bounds;
        assert_close(bounds.crb_px, fine.crb_px, 1e-4, 0);
        assert_close(bounds.crb_flux_shift_px, fine.crb_flux_shift_px, 1e-4, 0);
        assert_close(bounds.crb_marginal_px, fine.crb_marginal_px, 1e-3, 0);
        toliman_sim_destroy(sim);
    }
    free(clear), free(wide);
}

/* The position of a single star cannot be distinguished from a common shift. */
TEST(a_single_star_has_no_separation) {
    toliman_sim *const sim = sim_of(kSingleScene);
    const toliman_sim_bounds bounds = sim_bounds_of(sim);
    assert_true(bounds.crb_px > 0 && isfinite(bounds.crb_px));
    assert_true(isinf(bounds.crb_flux_shift_px));
    assert_close(sim_info_of(sim).separation_px, 0, 0, 0);
    assert_close(sim_info_of(sim).flux_ratio, 0, 0, 0);
    toliman_sim_destroy(sim);
}

/* Photon noise alone: four times the light halves the bound. Read noise increases it. */
TEST(bounds_scale_with_light) {
    char *const quiet = replaced(kBinaryScene, "'read_e': 2.5, ", "");
    toliman_sim *const faint = sim_of(quiet), *const bright = sim_with(quiet, "1e5", "4e5"),
                       *const noisy = sim_of(kBinaryScene);
    assert_close(sim_bounds_of(bright).crb_px, sim_bounds_of(faint).crb_px / 2, 1e-10, 0);
    assert_true(sim_bounds_of(noisy).crb_px > sim_bounds_of(faint).crb_px);
    toliman_sim_destroy(faint), toliman_sim_destroy(bright), toliman_sim_destroy(noisy), free(quiet);
}

TEST(chapter_scene) {
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_file("examples/scenes/chapter.json", NULL, &sim));
    const toliman_sim_info info = sim_info_of(sim);
    const toliman_sim_bounds bounds = sim_bounds_of(sim);
    assert_string_equal(info.name, "chapter");
    assert_close(bounds.crb_px, 1.239e-6, 0.01, 0); /* from another simulator, whose pupil has no grey edges */
    assert_int_equal(info.wavelengths, 51);
    assert_int_equal(info.frames, 1095);
    assert_close(info.peak_photons, 1e9, 1e-15, 0);
    assert_close(info.flux_ratio, 3.12, 1e-14, 0);
    assert_close(info.separation_px, 50, 1e-14, 0);
    assert_close(info.period_days, 365, 0, 0);
    assert_at_most(bounds.truncation, 1e-12);
    toliman_sim_destroy(sim);
}

TEST(mission_scene) {
    if (!in_long())
        skip();
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_file("examples/scenes/mission.json", NULL, &sim));
    const toliman_sim_info info = sim_info_of(sim);
    double wavelength[111], a[111], b[111], total_a = 0, total_b = 0;
    assert_int_equal(info.wavelengths, 111);
    assert_int_equal(info.frames, 1437);
    assert_close(info.separation_px, 9.76 / 0.375, 1e-14, 0);
    assert_ok(toliman_sim_get_spectrum(sim, 111, wavelength, a, b, NULL));
    for (int i = 0; i < 111; i++) {
        total_a += a[i];
        total_b += b[i];
    }
    assert_close(total_a, 7.27e7 * 43200, 1e-13, 0);
    assert_close(total_b, 2.26e7 * 43200, 1e-13, 0);
    assert_true(info.total_photons < total_a + total_b && info.total_photons > 0.8 * (total_a + total_b));
    assert_close(info.amplitude_px, 6.8e-6, 0, 0);
    toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
