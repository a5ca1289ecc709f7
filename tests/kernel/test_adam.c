/* Tests Adam against algorithm 1 of Kingma and Ba in long double. */
#include "assert_close.h"

void shim_adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
               float *weights);

static void test_follows_the_paper(void **unused) {
    enum { kWeights = 37, kSteps = 50 };
    float gradient[kWeights], mean[kWeights] = {0}, square[kWeights] = {0}, weights[kWeights] = {0};
    long double m[kWeights] = {0}, v[kWeights] = {0}, w[kWeights] = {0};
    for (size_t step = 1; step <= kSteps; step++) {
        const double rate = 4e-3 / (double)step;
        for (int i = 0; i < kWeights; i++) {
            gradient[i] = (float)(sin(1.7 * i + 0.3 * (double)step) * pow(10, i % 9 - 6));
            m[i] = 0.9L * m[i] + 0.1L * gradient[i];
            v[i] = 0.999L * v[i] + 0.001L * gradient[i] * gradient[i];
            w[i] -= rate * (m[i] / (1 - powl(0.9L, step))) / (sqrtl(v[i] / (1 - powl(0.999L, step))) + 1e-8L);
        }
        shim_adam(step, rate, gradient, kWeights, mean, square, weights);
    }
    for (int i = 0; i < kWeights; i++)
        assert_close(weights[i], (double)w[i], 1e-5, 1e-7);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_follows_the_paper)};
    return cmocka_run_group_tests_name("adam", tests, NULL, NULL);
}
