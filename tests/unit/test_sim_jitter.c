/* Tests jitter that differs between x and y: against sums of shifted images, the one-dimensional key, and refusals. */
#include "scene_text.h"

enum { SIDE = 32, PIXELS = SIDE * SIDE };

static const char *const kMask = "'mask': {'kind': 'spiral', 'edges': 'cell', 'opd_nm': 275, 'terms':"
                                 " [{'a': 1, 'f': 2, 'm': 3, 'p': 1}]}, 'aperture_m'";

/* The image of a star at (x, y) px with these keys of the detector and of the systematics, 1e6 photons. */
static void image_of_star(double x, double y, const char *pixel, const char *systematics, double *image) {
    char place[80], detector[120], extra[200];
    snprintf(place, sizeof place, "'A': [%.17g, %.17g]", x, y);
    snprintf(detector, sizeof detector, "'pixel': '%s', 'shape'", pixel);
    snprintf(extra, sizeof extra, "'systematics': {%s}, 'cadence'", systematics);
    char *text = EDITED(kSingleScene, {"'A': [0, 0]", place}, {"'aperture_m'", kMask}, {"'shape'", detector},
                        {"'peak_photons': 1e6", "'exposure_s': 1"}, {"5790}}", "5790}, 'photons_per_s': 1e6}"},
                        {"'cadence'", extra});
    toliman_sim *const sim = sim_of(text);
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
    toliman_sim_destroy(sim), free(text);
}

/* The blurred image is the mean of shifted images. The trapezoidal rule over the Gaussian converges faster than any
 * power: steps of 0.75 standard deviations (0.5 for wide blurs), to 6.7 of them, give 1e-10. Correlated shifts are x =
 * s u, y = t (c u + d v) of independent u and v. */
static void check_blur(double xx, double yy, double xy, const char *pixel) {
    const double x0 = 1.3, y0 = -0.6, step = xx < 1 ? 0.75 : 0.5;
    const double s = sqrt(xx), along = xy / s, rest = sqrt(fmax(0, yy - along * along));
    const int reach = (int)ceil(6.7 / step), across = rest > 1e-9 ? reach : 0; /* a blur along a line needs no v */
    double expected[PIXELS] = {0}, image[PIXELS], weights = 0, peak = 0;
    for (int i = -reach; i <= reach; i++)
        for (int j = -across; j <= across; j++) {
            const double u = i * step, v = j * step, weight = exp(-(u * u + v * v) / 2);
            if (u * u + v * v > 46)
                continue;
            image_of_star(x0 + s * u, y0 + along * u + rest * v, pixel, "", image);
            weights += weight;
            for (int k = 0; k < PIXELS; k++)
                expected[k] += weight * image[k];
        }
    char key[160];
    snprintf(key, sizeof key, "'jitter_covariance_px2': {'xx': %.17g, 'yy': %.17g, 'xy': %.17g}", xx, yy, xy);
    image_of_star(x0, y0, pixel, key, image);
    for (int k = 0; k < PIXELS; k++)
        peak = fmax(peak, image[k]);
    for (int k = 0; k < PIXELS; k++)
        assert_close(image[k], expected[k] / weights, 0, 2e-9 * peak);
}

TEST(blurs_are_means_of_shifted_images) {
    check_blur(0.09, 0.04, 0.03, "point");
    check_blur(0.16, 0.04, -0.08, "integrated"); /* along a line */
    check_blur(4, 1, 2, "point");
}

/* Equal variances without covariance are the one-dimensional key, bit for bit. */
TEST(equal_variances_are_a_sigma) {
    double one[PIXELS], two[PIXELS];
    image_of_star(0, 0, "integrated", "'jitter_sigma_px': 0.2", one);
    image_of_star(0, 0, "integrated", "'jitter_covariance_px2': {'xx': 0.04000000000000001, 'yy': 0.04000000000000001}",
                  two);
    assert_true(0.2 * 0.2 == 0.04000000000000001);
    assert_memory_equal(one, two, sizeof one);
}

TEST(refusals) {
    const refusal cases[] = {
        {"'cadence'", "'systematics': {'jitter_sigma_px': 0.1, 'jitter_covariance_px2': {'xx': 1, 'yy': 1}}, 'cadence'",
         "systematics.jitter_sigma_px"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': 0.1}, 'cadence'", "systematics.jitter_covariance_px2"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': {'xx': 1}}, 'cadence'",
         "systematics.jitter_covariance_px2.yy"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': {'xx': -1, 'yy': 1}}, 'cadence'",
         "systematics.jitter_covariance_px2.xx"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': {'xx': 1, 'yy': '1'}}, 'cadence'",
         "systematics.jitter_covariance_px2.yy"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': {'xx': 1, 'yy': 4, 'xy': -2.1}}, 'cadence'",
         "systematics.jitter_covariance_px2.xy"},
        {"'cadence'", "'systematics': {'jitter_covariance_px2': {'xx': 1, 'yy': 4, 'yx': 1}}, 'cadence'",
         "systematics.jitter_covariance_px2.yx"},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, cases);
}

RUN_TESTS(NULL, NULL)
