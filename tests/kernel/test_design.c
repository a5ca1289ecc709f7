/* Tests the design of a mask in small: a smaller bound within the limits at all places, the same bits on any number of
 * threads, symmetry, and a design that is stopped. */
#include <string.h>

#include "assert_close.h"

int shim_design(const char *json, const double *angles_deg, int count, unsigned long long seed, int iterations,
                int symmetry, double peak_to_mean, unsigned workers, int calls, unsigned char *cells, double *scores,
                double *small);

enum { N = 64, CELLS = N * N, PLACES = 2, NONE = 0, ODD = 2 };

static const char *const kScene =
    "{\"schema\": \"toliman-scene/1\","
    " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.02, \"pupil_samples\": 64,"
    "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 292.5, \"terms\": [{\"a\": 1, \"f\": 1.2, "
    "\"m\": -5, \"p\": 1}]}},"
    " \"band\": {\"min_nm\": 550, \"max_nm\": 620, \"step_nm\": 10},"
    " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"photons_per_s\": 7e11},"
    "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"photons_per_s\": 3e11}},"
    " \"binary\": {\"separation_arcsec\": 6, \"position_angle_deg\": 30},"
    " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"A\", \"amplitude_px\": 1e-6, \"period_days\": 9},"
    " \"cadence\": {\"frames\": 4, \"exposure_s\": 1},"
    " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.375},"
    " \"noise\": {\"photon\": true},"
    " \"accuracy\": 1e-9}";
static const double kAngles[PLACES] = {30, 45};
static const double kPeak = 30;

static unsigned char cells[CELLS], again[CELLS];
static double scores[PLACES][2][3], others[PLACES][2][3], small;

static void better_within_the_limits(void **state) {
    for (int symmetry = NONE; symmetry <= ODD; symmetry += ODD) {
        assert_int_equal(
            shim_design(kScene, kAngles, PLACES, 3, 60, symmetry, kPeak, 2, 0, cells, scores[0][0], &small), 0);
        for (int place = 0; place < PLACES; place++) {
            const double *own = scores[place][0], *best = scores[place][1];
            assert_true(best[0] < 0.85 * own[0]);
            assert_true(best[1] <= kPeak);
            assert_true(best[2] > 0.49);
        }
        assert_true(small < 1e-2);
        shim_design(kScene, kAngles, PLACES, 3, 60, symmetry, kPeak, 1, 0, again, others[0][0], &small);
        assert_memory_equal(cells, again, sizeof cells);
        assert_memory_equal(scores, others, sizeof scores);
    }
}

/* Even before the first iteration there is a mask, with its scores. */
static void stopped(void **state) {
    for (int calls = 1; calls <= 20; calls += 19) {
        memset(cells, 2, sizeof cells);
        assert_int_equal(
            shim_design(kScene, kAngles, PLACES, 3, 60, NONE, kPeak, 2, calls, cells, scores[0][0], &small), 1);
        int covered = 0;
        for (int i = 0; i < CELLS; i++) {
            assert_true(cells[i] <= 1);
            covered += cells[i];
        }
        assert_true(covered > CELLS / 5 && covered < 4 * CELLS / 5);
        assert_true(scores[0][1][0] > 0 && scores[0][1][0] < 1e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(better_within_the_limits),
        cmocka_unit_test(stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
