/* Tests the template estimator on a small scene: bias, scatter against its predicted sigma, insensitivity to nuisances,
 * errors. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <toliman/linear.h>

#include "assert_close.h"
#include "images.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

/* Both stars moved by (shift_x, shift_y) px; project is the list of projected images, "" for none. */
static toliman_sim *make_scene(double shift_x, double shift_y, const char *project) {
    static const char *const format =
        "{\"schema\": \"toliman-scene/1\", \"name\": \"small\","
        " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.02, \"pupil_samples\": 64,"
        "   \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 290,"
        "     \"terms\": [{\"a\": 1, \"f\": 2, \"l\": 3, \"m\": 5, \"p\": 0.4}]}},"
        " \"band\": {\"min_nm\": 570, \"max_nm\": 590, \"step_nm\": 5},"
        " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 2},"
        "   \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"relative_flux\": 1}},"
        " \"binary\": {\"offsets_px\": {\"A\": [%.17g, %.17g], \"B\": [%.17g, %.17g]}},"
        " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"A\", \"amplitude_px\": 1e-3, \"period_days\": 100},"
        " \"cadence\": {\"frames\": 300, \"interval_days\": 1, \"peak_photons\": 1e6},"
        " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.375, \"pixel\": \"point\"},"
        " \"noise\": {\"photon\": true, \"read_e\": 3, \"seed\": 1},"
        " \"preprocess\": {\"project\": [%s]}}";
    char json[2048];
    const int size =
        snprintf(json, sizeof json, format, -7.3 + shift_x, -4.2 + shift_y, 8.1 + shift_x, 5.6 + shift_y, project);
    assert_true(size > 0 && (size_t)size < sizeof json);
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, (size_t)size, NULL, NULL, &sim));
    return sim;
}

static const char *const all_four = "\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\"";

static toliman_linear *make_linear(const toliman_sim *sim) {
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    return linear;
}

/* promise: template-scatter-is-the-bound */
TEST(sigma_is_the_bound_with_projected_parameters_free) {
    const char *const projects[] = {"", "\"flux_a\", \"flux_b\"", all_four};
    double last = 0;
    for (size_t k = 0; k < 3; k++) {
        toliman_sim *sim = make_scene(0, 0, projects[k]);
        toliman_linear *linear = make_linear(sim);
        toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
        assert_ok(toliman_sim_get_bounds(sim, &bounds));
        double sigma = 0;
        assert_ok(toliman_linear_get_sigma(linear, &sigma));
        assert_close(sigma, bounds.crb_projected_px, 1e-9, 0);
        assert_true(sigma > last); /* the cost of free parameters */
        last = sigma;
        toliman_linear_destroy(linear), toliman_sim_destroy(sim);
    }
}

/* 2,000 noisy frames: the relative error of their scatter is 1.6 %. */
/* promise: template-scatter-is-the-bound */
TEST(values_are_unbiased_with_the_predicted_scatter) {
    enum { frames = 2000 };
    const char *const projects[] = {"", all_four};
    for (size_t k = 0; k < 2; k++) {
        toliman_sim *sim = make_scene(0, 0, projects[k]);
        toliman_linear *linear = make_linear(sim);
        double sigma = 0, sum = 0, squares = 0;
        static double image[PIXELS];
        assert_ok(toliman_linear_get_sigma(linear, &sigma));
        const double displacement = 5 * sigma;
        for (int64_t f = 0; f < frames; f++) {
            double value = 0;
            assert_ok(toliman_sim_frame(sim, &displacement, 77, f, 1, image));
            assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(image), 1, &value, NULL));
            sum += value - displacement;
            squares += (value - displacement) * (value - displacement);
        }
        assert_close(sum / frames, 0, 0, 4 * sigma / sqrt(frames));
        assert_close(sqrt(squares / frames), sigma, 0.05, 0);
        toliman_linear_destroy(linear), toliman_sim_destroy(sim);
    }
}

/* Value of a noise-free frame with the stars moved by 1e-4 px and 1e-4 more light of star A. */
static double value_of_disturbed_frame(const char *project) {
    static double moved[PIXELS], star[PIXELS];
    toliman_sim *sim = make_scene(0, 0, project), *other = make_scene(1e-4, -0.7e-4, project);
    toliman_linear *linear = make_linear(sim);
    double value = 0;
    assert_ok(toliman_sim_get_image(other, TOLIMAN_SIM_IMAGE_BOTH, moved, SIDE));
    assert_ok(toliman_sim_get_image(other, TOLIMAN_SIM_IMAGE_STAR_A, star, SIDE));
    for (size_t i = 0; i < PIXELS; i++)
        moved[i] += 1e-4 * star[i];
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(moved), 1, &value, NULL));
    toliman_linear_destroy(linear), toliman_sim_destroy(other), toliman_sim_destroy(sim);
    return value;
}

TEST(projected_disturbances_do_not_leak) {
    const double open = value_of_disturbed_frame(""), blind = value_of_disturbed_frame(all_four);
    assert_true(fabs(open) > 1e-6);
    assert_at_most(fabs(blind), 1e-3 * fabs(open));
}

/* Those of encode: test_images. */
TEST(errors_name_the_argument) {
    toliman_sim *sim = make_scene(0, 0, "");
    toliman_linear *linear = make_linear(sim), *untouched = NULL;
    double value = 42;
    assert_invalid(toliman_linear_create(NULL, NULL, &untouched), "sim");
    assert_null(untouched);
    assert_invalid(toliman_linear_create(sim, NULL, NULL), "out");
    assert_invalid(toliman_linear_get_sigma(NULL, &value), "linear");
    assert_invalid(toliman_linear_get_sigma(linear, NULL), "sigma_px");
    assert_true(value == 42);
    toliman_linear_destroy(NULL);
    toliman_linear_destroy(linear), toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
