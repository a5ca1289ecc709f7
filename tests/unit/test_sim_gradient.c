/* Tests the gradient by the OPD of the pupil: with Zernike modes it is the transpose of the derivative images, and with
 * a random OPD in every cell it predicts the change of whole scenes. */
#include <toliman/sim_derivative.h>

#include "scene_files.h"
#include "uniform.h"

enum { MOST = 96 * 96 };

typedef struct {
    int rows, cols, samples;
    const char *detector, *mask, *systematics; /* more keys of each */
} variant;

static const variant kVariants[] = {
    {40, 40, 64, "", "", ""},
    {33, 40, 65, "", "'edges': 'area', ", ""},
    {33, 33, 64, "'scale_anisotropy': 0.02, 'shear': -0.03, 'qe': 0.7, 'gain_e_per_dn': 3, 'bias_dn': 9, ",
     "'edges': 'area', ", ""},
    {32, 47, 63, "'pixel': 'integrated', 'flat_rms': 0.05, ", "", ""},
    {31, 30, 96, "'pixel': 'integrated', 'shear': 0.04, ", "'edges': 'area', ",
     "'systematics': {'jitter_covariance_px2': {'xx': 0.04, 'yy': 0.09, 'xy': -0.03}}, "},
};
enum { VARIANTS = sizeof kVariants / sizeof *kVariants };

/* kBinaryScene as a variant, with absolute photons and another term of the aberrations. Without aberrations the mask
 * leaves the image no first-order dependence on even modes. */
static toliman_sim *sim_of_variant(const variant *v, const char *zernike, const char *file) {
    char keys[300];
    snprintf(keys, sizeof keys, "'pupil_samples': %d, 'aberrations': {%s'zernike_rms_nm': {%s'4': 15, '7': 20}}",
             v->samples, file, zernike);
    char *text = replaced(kBinaryScene, "'pupil_samples': 96", keys);
    snprintf(keys, sizeof keys, "%s'shape': [%d, %d]", v->detector, v->rows, v->cols);
    text = replaced_again(text, "'shape': [64, 64]", keys);
    if (strstr(v->mask, "edges") != NULL)
        text = replaced_again(text, "'edges': 'cell', ", "");
    snprintf(keys, sizeof keys, "%s'terms'", v->mask);
    text = replaced_again(text, "'terms'", keys);
    snprintf(keys, sizeof keys, "%s'signal'", v->systematics);
    text = replaced_again(text, "'signal'", keys);
    text = replaced_again(text, "'peak_photons': 1e5", "'exposure_s': 1");
    text = replaced_again(text, "'relative_flux': 3", "'photons_per_s': 3e7");
    text = replaced_again(text, "5260}}}", "5260}, 'photons_per_s': 1e7}}");
    toliman_sim *sim = NULL;
    assert_ok(create_in_folder(text, &sim));
    free(text);
    return sim;
}

static void random_weights(const variant *v, double *weights) {
    uint64_t state = 5;
    for (int i = 0; i < v->rows * v->cols; i++)
        weights[i] = uniform_signed(&state);
}

/* OPD of 1 nm in a Zernike polynomial, in the cells of the pupil. */
static void mode_of(const variant *v, int noll, double *mode) {
    static double plain[MOST];
    char zernike[80];
    snprintf(zernike, sizeof zernike, "'%d': 1000, ", noll);
    for (int i = 0; i < 2; i++) {
        toliman_sim *const sim = sim_of_variant(v, i == 0 ? "" : zernike, "");
        assert_ok(toliman_sim_get_pupil(sim, NULL, i == 0 ? plain : mode));
        toliman_sim_destroy(sim);
    }
    for (int i = 0; i < v->samples * v->samples; i++)
        mode[i] = (mode[i] - plain[i]) / 1000;
}

/* promise: opd-gradients-transpose-derivatives */
TEST(gradient_transposes_derivatives) {
    static double weights[MOST], gradient[MOST], derivative[MOST], mode[MOST];
    const int nolls[] = {5, 8, 22, 36};
    for (int variation = 0; variation < VARIANTS; variation++) {
        const variant *const v = &kVariants[variation];
        toliman_sim *const sim = sim_of_variant(v, "", "");
        random_weights(v, weights);
        assert_ok(toliman_sim_get_opd_gradient(sim, weights, (size_t)v->cols, gradient));
        for (int k = 0; k < 4; k++) {
            char name[20];
            snprintf(name, sizeof name, "zernike_%d", nolls[k]);
            assert_ok(toliman_sim_get_derivative(sim, name, derivative, (size_t)v->cols));
            mode_of(v, nolls[k], mode);
            double by_pixels = 0, by_cells = 0, size = 0;
            for (int i = 0; i < v->rows * v->cols; i++) {
                by_pixels += weights[i] * derivative[i];
                size += fabs(weights[i] * derivative[i]);
            }
            for (int i = 0; i < v->samples * v->samples; i++)
                by_cells += mode[i] * gradient[i];
            assert_true(size > 1e-3);
            assert_close(by_cells, by_pixels, 0, 1e-12 * size);
        }
        toliman_sim_destroy(sim);
    }
}

/* Sum of weights times the image, with an OPD of h times the file of the scene. */
static double weighted_sum(const variant *v, const double *opd, double h, const double *weights) {
    static double scaled[MOST], image[MOST];
    char shape[40];
    const int cells = v->samples * v->samples;
    for (int i = 0; i < cells; i++)
        scaled[i] = h * opd[i];
    snprintf(shape, sizeof shape, "(%d, %d)", v->samples, v->samples);
    write_npy("surface.npy", "<f8", shape, scaled, (size_t)cells * sizeof *scaled);
    toliman_sim *const sim = sim_of_variant(v, "", "'opd_file': 'surface.npy', ");
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, (size_t)v->cols));
    toliman_sim_destroy(sim);
    double sum = 0;
    for (int i = 0; i < v->rows * v->cols; i++)
        sum += weights[i] * image[i];
    return sum;
}

TEST(gradient_predicts_scenes) {
    static double weights[MOST], gradient[MOST], opd[MOST], amplitude[MOST];
    for (int variation = 0; variation < VARIANTS; variation++) {
        const variant *const v = &kVariants[variation];
        const int cells = v->samples * v->samples;
        uint64_t numbers = 11;
        for (int i = 0; i < cells; i++)
            opd[i] = 1e-9 * uniform_signed(&numbers);
        random_weights(v, weights);
        toliman_sim *const sim = sim_of_variant(v, "", "");
        assert_ok(toliman_sim_get_opd_gradient(sim, weights, (size_t)v->cols, gradient));
        assert_ok(toliman_sim_get_pupil(sim, amplitude, NULL));
        toliman_sim_destroy(sim);
        double predicted = 0, size = 0;
        for (int i = 0; i < cells; i++) {
            assert_true(amplitude[i] > 0 || gradient[i] == 0);
            predicted += opd[i] * gradient[i];
            size += pow(opd[i] * gradient[i], 2);
        }
        const double coarse = weighted_sum(v, opd, 1, weights) - weighted_sum(v, opd, -1, weights);
        const double fine = weighted_sum(v, opd, 0.5, weights) - weighted_sum(v, opd, -0.5, weights);
        assert_close(predicted, (8 * fine - coarse) / 6, 0, 1e-6 * sqrt(size));
    }
}

TEST(threads_change_no_bit) {
    static double weights[64 * 64], gradient[2][96 * 96];
    const variant shape = {.rows = 64, .cols = 64};
    random_weights(&shape, weights);
    for (uint32_t i = 0; i < 2; i++) {
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.threads = 1 + 2 * i;
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, &options, &sim));
        assert_ok(toliman_sim_get_opd_gradient(sim, weights, 64, gradient[i]));
        toliman_sim_destroy(sim);
    }
    assert_memory_equal(gradient[0], gradient[1], sizeof gradient[0]);
}

TEST(wrong_arguments) {
    static double weights[32 * 40], gradient[64 * 64], again[64 * 64];
    toliman_sim *sim = sim_of(kSingleScene);
    assert_invalid(toliman_sim_get_opd_gradient(NULL, weights, 32, gradient), "sim");
    assert_invalid(toliman_sim_get_opd_gradient(sim, NULL, 32, gradient), "weights");
    assert_invalid(toliman_sim_get_opd_gradient(sim, weights, 32, NULL), "gradient");
    assert_invalid(toliman_sim_get_opd_gradient(sim, weights, 31, gradient), "stride");
    weights[3 * 40 + 5] = NAN;
    gradient[0] = 7;
    assert_invalid(toliman_sim_get_opd_gradient(sim, weights, 40, gradient), "weights[3][5]");
    assert_true(gradient[0] == 7);
    weights[3 * 40 + 5] = 1;
    weights[3 * 40 + 35] = NAN; /* between the rows */
    assert_ok(toliman_sim_get_opd_gradient(sim, weights, 40, gradient));
    for (int i = 0; i < 32 * 32; i++)
        weights[i] = i == 3 * 32 + 5;
    assert_ok(toliman_sim_get_opd_gradient(sim, weights, 32, again));
    assert_memory_equal(gradient, again, sizeof gradient);
    toliman_sim_destroy(sim);
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    assert_ok(toliman_sim_create_json(kSingleScene, strlen(kSingleScene), NULL, &options, &sim));
    assert_refused(toliman_sim_get_opd_gradient(sim, weights, 32, gradient), TOLIMAN_E_UNSUPPORTED, "");
    toliman_sim_destroy(sim);
}

RUN_TESTS(make_folder, remove_folder)
