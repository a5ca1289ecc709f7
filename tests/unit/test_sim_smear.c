/* Tests motion within an exposure: against means of displaced images by a quadrature of another kind, its derivative at
 * length 0 against those of jitter, the fit that finds it, and refusals. */
#include <toliman/fit.h>
#include <toliman/sim_derivative.h>

#include "images.h"
#include "scene_text.h"

enum { SIDE = 32, PIXELS = SIDE * SIDE };

static const char *const kMask = "'mask': {'kind': 'spiral', 'edges': 'cell', 'opd_nm': 275, 'terms':"
                                 " [{'a': 1, 'f': 2, 'm': 3, 'p': 1}]}, 'aperture_m'";

/* A star at (x, y) px with these keys of the detector and of the systematics, 1e6 photons. */
static toliman_sim *star_at(double x, double y, const char *pixel, const char *systematics) {
    char place[80], detector[120], extra[300];
    snprintf(place, sizeof place, "'A': [%.17g, %.17g]", x, y);
    snprintf(detector, sizeof detector, "'pixel': '%s', 'shape'", pixel);
    snprintf(extra, sizeof extra, "'accuracy': 1e-12, 'systematics': {%s}, 'cadence'", systematics);
    char *text = EDITED(kSingleScene, {"'A': [0, 0]", place}, {"'aperture_m'", kMask}, {"'shape'", detector},
                        {"'peak_photons': 1e6", "'exposure_s': 1"}, {"5790}}", "5790}, 'photons_per_s': 1e6}"},
                        {"'cadence'", extra});
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

static void image_of_star(double x, double y, const char *pixel, const char *systematics, double *image) {
    toliman_sim *const sim = star_at(x, y, pixel, systematics);
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
    toliman_sim_destroy(sim);
}

typedef struct {
    const char *kind;
    double length, angle;
    const char *pixel, *jitter;
} path;

static void key_of(const path *p, char *key, size_t size) {
    snprintf(key, size, "'smear': {'kind': '%s', 'length_px': %g, 'angle_deg': %g}%s", p->kind, p->length, p->angle,
             p->jitter);
}

/* Mean of images along the path. The trapezoidal rule over a period of the sinusoid converges faster than any power;
 * so does Gauss' rule of 5 points on panels of 0.5 px. */
static void mean_along(const path *p, double *mean) {
    static const double node[5] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831, 0.9061798459386640},
                        weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                     0.2369268850561891};
    const double pi = acos(-1), angle = p->angle * pi / 180;
    const int linear = strcmp(p->kind, "linear") == 0, panels = (int)ceil(p->length / 0.5),
              count = linear ? 5 * panels : 12 + (int)ceil(2.5 * p->length);
    static double image[PIXELS];
    memset(mean, 0, sizeof image);
    for (int i = 0; i < count; i++) {
        const double t = linear ? (2 * (i / 5) + 1 + node[i % 5]) / panels - 1 : sin(2 * pi * (i + 0.3) / count);
        const double w = linear ? weight[i % 5] / (2 * panels) : 1.0 / count, at = p->length / 2 * t;
        image_of_star(1.3 + at * cos(angle), -0.6 + at * sin(angle), p->pixel,
                      p->jitter[0] != '\0' ? p->jitter + 2 : "", image);
        for (int k = 0; k < PIXELS; k++)
            mean[k] += w * image[k];
    }
}

static const path kPaths[] = {
    {"linear", 0.7, 0, "point", ""},
    {"linear", 3, 90, "integrated", ""},
    {"linear", 2.5, 37, "point", ""},
    {"linear", 1, -143, "integrated", ", 'jitter_sigma_px': 0.4"},
    {"linear", 1.5, 70, "point", ", 'jitter_covariance_px2': {'xx': 9, 'yy': 4, 'xy': -2}"},
    {"harmonic", 1.2, 180, "integrated", ""},
    {"harmonic", 4, -60, "integrated", ""},
    {"harmonic", 2, 20, "integrated", ", 'jitter_covariance_px2': {'xx': 0.16, 'yy': 0.09, 'xy': 0.1}"},
    {"harmonic", 12, 200, "point", ""},
};

/* promise: smear-is-a-mean-of-images */
TEST(smeared_images_are_means_of_displaced_ones) {
    static double image[PIXELS], expected[PIXELS], sharp[PIXELS];
    for (size_t i = 0; i < sizeof kPaths / sizeof *kPaths; i++) {
        const path *const p = &kPaths[i];
        char key[300];
        key_of(p, key, sizeof key);
        image_of_star(1.3, -0.6, p->pixel, key, image);
        mean_along(p, expected);
        image_of_star(1.3, -0.6, p->pixel, p->jitter[0] != '\0' ? p->jitter + 2 : "", sharp);
        const double error = peak_difference(image, expected, PIXELS);
        if (!(error <= 1e-10 && peak_difference(sharp, expected, PIXELS) >= 1e-3))
            fail_msg("%s: differs by %g of the peak", key, error);
    }
}

/* A path of length 0 changes no bit. Its derivative is half of that by the jitter along it, times the variance of the
 * places over the square of the length: 1/12 and 1/8. */
TEST(at_length_0) {
    static double image[PIXELS], sharp[PIXELS], rate[PIXELS], jitter[PIXELS], expected[PIXELS];
    const double angle = 25 * acos(-1) / 180, x = cos(angle), y = sin(angle);
    const struct {
        const char *key;
        double variance;
    } cases[] = {{"'smear': {'kind': 'linear', 'length_px': 0, 'angle_deg': 25}", 1.0 / 12},
                 {"'smear': {'kind': 'harmonic', 'length_px': 0, 'angle_deg': 25}", 1.0 / 8}};
    image_of_star(1.3, -0.6, "integrated", "", sharp);
    for (size_t i = 0; i < 2; i++) {
        toliman_sim *const sim = star_at(1.3, -0.6, "integrated", cases[i].key);
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
        assert_memory_equal(image, sharp, sizeof image);
        assert_ok(toliman_sim_get_derivative(sim, "smear", rate, SIDE));
        const char *const names[] = {"jitter_xx", "jitter_xy", "jitter_yy"};
        const double weights[] = {x * x, x * y, y * y};
        memset(expected, 0, sizeof expected);
        for (size_t j = 0; j < 3; j++) {
            assert_ok(toliman_sim_get_derivative(sim, names[j], jitter, SIDE));
            for (int k = 0; k < PIXELS; k++)
                expected[k] += cases[i].variance * weights[j] * jitter[k];
        }
        assert_at_most(peak_difference(rate, expected, PIXELS), 1e-10);
        toliman_sim_destroy(sim);
    }
}

/* Two stars whose frame moved farther than the model says. */
TEST(the_fit_finds_a_smear) {
    static double values[12];
    char *text = EDITED(kBinaryScene, {"'peak_photons': 1e5", "'peak_photons': 1e8"},
                        {"'noise'", "'systematics': {'smear': {'kind': 'linear', 'length_px': 0.2, 'angle_deg': 50}},"
                                    " 'noise'"});
    toliman_sim *const model = sim_of(text);
    text = replaced_again(text, "'length_px': 0.2", "'length_px': 0.201");
    toliman_sim *const truth = sim_of(text);
    toliman_fit_options options = {.struct_size = sizeof options, .free = "smear"};
    toliman_fit *fit = NULL, *fixed = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){model}, NULL, 1, &options, &fit));
    options.free = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){model}, NULL, 1, &options, &fixed));
    double *const image = image_of(truth, TOLIMAN_SIM_IMAGE_BOTH);
    toliman_fit_result result = {.struct_size = sizeof result}, control = result;
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(image), 1, NULL, &result, values, NULL));
    assert_ok(toliman_fit_frame(fixed, PLAIN_IMAGE(image), 1, NULL, &control, NULL, NULL));
    assert_close(values[7], 0.201 * 0.201 - 0.2 * 0.2, 1e-3, 0);
    assert_true(result.chi_square < 0.01 * control.chi_square);
    assert_at_most(fabs(result.displacement_px), 0.1 * fabs(control.displacement_px));
    toliman_fit_destroy(fit), toliman_fit_destroy(fixed), free(image);
    toliman_sim_destroy(model), toliman_sim_destroy(truth), free(text);
}

TEST(refusals) {
    const refusal cases[] = {
        {"'cadence'", "'systematics': {'smear': 1}, 'cadence'", "systematics.smear"},
        {"'cadence'", "'systematics': {'smear': {'kind': 'linear', 'length_px': 1}}, 'cadence'",
         "systematics.smear.angle_deg"},
        {"'cadence'", "'systematics': {'smear': {'kind': 'shm', 'length_px': 1, 'angle_deg': 0}}, 'cadence'",
         "systematics.smear.kind"},
        {"'cadence'", "'systematics': {'smear': {'kind': 'linear', 'length_px': -1, 'angle_deg': 0}}, 'cadence'",
         "systematics.smear.length_px"},
        {"'cadence'", "'systematics': {'smear': {'kind': 'linear', 'length_px': 21, 'angle_deg': 0}}, 'cadence'",
         "systematics.smear.length_px"},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, cases);
}

RUN_TESTS(NULL, NULL)
