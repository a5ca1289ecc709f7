/* Tests the gradient by the OPD of the images of both stars together against the sum of their own gradients, which
 * unit/test_sim_gradient tests. */
#include <string.h>

#include "scene_text.h"
#include "uniform.h"

void shim_joint_gradient(const char *json, double x, double y, unsigned workers, const double *weights, double *joint,
                         double *single);

enum { CELLS = 96 * 96, PIXELS = 64 * 64 };

static double weights[2 * PIXELS], joint[CELLS], again[CELLS], single[CELLS];

static void joint_is_the_sum(void **state) {
    const char *const detectors[] = {
        "\"shape\": [64, 64]",
        "\"shape\": [31, 40], \"pixel\": \"integrated\", \"shear\": 0.04",
    };
    const char *const bands[] = {"\"step_nm\": 12.5", "\"step_nm\": 0.5"}; /* the second one on nodes */
    const char *const spectra[] = {"\"temperature_k\": 5260", "\"temperature_k\": 3000"};
    uint64_t numbers = 3;
    for (int i = 0; i < 2 * PIXELS; i++)
        weights[i] = uniform_signed(&numbers);
    for (int c = 0; c < 2; c++) {
        char *text = replaced(kBinaryScene, "\"shape\": [64, 64]", detectors[c]);
        text = replaced_again(text, "\"step_nm\": 12.5", bands[c]);
        text = replaced_again(text, "\"temperature_k\": 5260", spectra[c]);
        shim_joint_gradient(text, 1.25, -2.5, 1, weights, joint, single);
        double largest = 0;
        for (int i = 0; i < CELLS; i++)
            largest = fmax(largest, fabs(single[i]));
        assert_true(largest > 0);
        for (int i = 0; i < CELLS; i++)
            assert_close(joint[i], single[i], 0, 1e-12 * largest);
        shim_joint_gradient(text, 1.25, -2.5, 3, weights, again, single);
        assert_memory_equal(joint, again, sizeof joint);
        free(text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(joint_is_the_sum)};
    return cmocka_run_group_tests_name("joint gradient", tests, NULL, NULL);
}
