/* Tests what a mask design minimises: its gradient against differences, its bound against the simulator's. */
#include <stdio.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

void shim_objective(const char *json, double step_m, int count, double peak_to_mean, double weight, unsigned workers,
                    const double *covered, double *merit, double *gradient);
void shim_objective_own(const char *json, double *bounds, double *light);

enum { N = 48, CELLS = N * N };

/* Two stars on 40 x 44 px, with struts, aberrations, a spiral mask and a detector; three wavelengths. */
static const char *make_scene(const char *cadence, const char *detector) {
    static char text[2048];
    const int is_bright = strstr(cadence, "peak") == NULL;
    snprintf(text, sizeof text,
             "{\"schema\": \"toliman-scene/1\","
             " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.032, \"pupil_samples\": 48,"
             "  \"struts\": {\"count\": 3, \"width_m\": 0.004, \"angle_deg\": 20},"
             "  \"mask\": {\"kind\": \"spiral\", \"opd_nm\": 292.5, \"edges\": \"area\","
             "   \"terms\": [{\"a\": 1, \"f\": 1.2, \"m\": -5, \"p\": 1}]},"
             "  \"aberrations\": {\"zernike_rms_nm\": {\"5\": 12, \"8\": -9}}},"
             " \"band\": {\"min_nm\": 530, \"max_nm\": 640, \"step_nm\": 55},"
             " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, %s},"
             "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, %s}},"
             " \"binary\": {\"offsets_px\": {\"A\": [-6.4, 8.3], \"B\": [7.1, -9.6]}},"
             " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-6, \"period_days\": 9},"
             " \"cadence\": {\"frames\": 4, %s},"
             " \"detector\": {\"shape\": [40, 44], \"pixel_scale_arcsec\": 0.375%s},"
             " \"noise\": {\"photon\": true, \"read_e\": 30},"
             " \"accuracy\": 1e-9}",
             is_bright ? "\"photons_per_s\": 7e11" : "\"relative_flux\": 3",
             is_bright ? "\"photons_per_s\": 3e11" : "\"relative_flux\": 1", cadence, detector);
    return text;
}

static const char kExposure[] = "\"exposure_s\": 1", kPeak[] = "\"peak_photons\": 1e8";
static const char kPlain[] = "", kFull[] = ", \"pixel\": \"integrated\", \"qe\": 0.7, \"flat_rms\": 0.05";
static const char kTilted[] = ", \"shear\": 0.03, \"scale_anisotropy\": 0.02";
static const double kStep = 292.5e-9;

static uint64_t numbers_state;
static double covered[CELLS], direction[CELLS], moved[CELLS], gradient[CELLS], again[CELLS], merit[4], other[4];

static double loss_at(const char *scene, double by, int count, double limit, double weight) {
    for (int i = 0; i < CELLS; i++)
        moved[i] = covered[i] + by * direction[i];
    shim_objective(scene, kStep, count, limit, weight, 2, moved, other, NULL);
    return other[0];
}

/* Central differences of two steps, extrapolated. */
static double slope_of(const char *scene, int count, double limit, double weight) {
    const double h = 1e-3;
    double by[2];
    for (int i = 0; i < 2; i++) {
        const double step = h / (1 << i);
        by[i] = (loss_at(scene, step, count, limit, weight) - loss_at(scene, -step, count, limit, weight)) / (2 * step);
    }
    return (4 * by[1] - by[0]) / 3;
}

static int set_up(void **unused) {
    numbers_state = 5;
    for (int i = 0; i < CELLS; i++) {
        covered[i] = 0.5 + 0.45 * uniform_signed(&numbers_state);
        direction[i] = uniform_signed(&numbers_state);
    }
    return 0;
}

TEST_WITH(gradient_of_the_loss, set_up, NULL) {
    const struct {
        const char *cadence, *detector;
        int count;
        double weight;
    } cases[] = {{kExposure, kPlain, 0, 0}, {kExposure, kPlain, 4, 0},  {kExposure, kPlain, 8, 0.3},
                 {kExposure, kFull, 8, 0},  {kExposure, kTilted, 8, 0}, {kPeak, kPlain, 8, 0.1},
                 {kPeak, kFull, 8, 0}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const char *scene = make_scene(cases[c].cadence, cases[c].detector);
        shim_objective(scene, kStep, cases[c].count, 6, cases[c].weight, 2, covered, merit, gradient);
        double slope = 0;
        for (int i = 0; i < CELLS; i++)
            slope += gradient[i] * direction[i];
        assert_close(slope, slope_of(scene, cases[c].count, 6, cases[c].weight), 1e-7, 0);
        shim_objective(scene, kStep, cases[c].count, 6, cases[c].weight, 1, covered, other, again);
        assert_memory_equal(gradient, again, sizeof gradient); /* the same bits on any number of threads */
        assert_memory_equal(merit, other, sizeof merit);
    }
}

/* The bound of the scene's own mask is that of the simulator. */
TEST(bound_of_the_scene) {
    const char *cadences[] = {kExposure, kPeak};
    for (size_t c = 0; c < 2; c++) {
        double bounds[2], light[2];
        shim_objective_own(make_scene(cadences[c], kPlain), bounds, light);
        assert_close(light[0], light[1], 1e-9, 0);
        assert_close(bounds[0], bounds[1], 1e-9, 0);
    }
}

RUN_TESTS(NULL, NULL)
