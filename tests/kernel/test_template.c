/* Tests the template estimator on synthetic frames against the normal equations of weighted least squares. */
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

static uint64_t draws = 31;

int shim_template(size_t rows, size_t cols, const double *reference, const double *variance, const double *derivative,
                  size_t count, const double *nuisances, size_t frames, const double *counts, double *values,
                  double *sigma_px);

enum { ROWS = 12, COLS = 10, PIXELS = ROWS * COLS, NUISANCES = 3 };

static double reference[PIXELS], variance[PIXELS], derivative[PIXELS], nuisances[NUISANCES][PIXELS], counts[PIXELS];

static int make_model(void **state) {
    (void)state;
    for (size_t i = 0; i < PIXELS; i++) {
        reference[i] = 1000 + 900 * uniform_signed(&draws);
        variance[i] = reference[i] + 2;
        derivative[i] = 500 * uniform_signed(&draws);
        for (size_t k = 0; k < NUISANCES; k++)
            nuisances[k][i] = 100 * uniform_signed(&draws) + 0.3 * derivative[i];
        counts[i] = reference[i] + 30 * uniform_signed(&draws);
    }
    return 0;
}

/* Solves the weighted normal equations for derivative and nuisances together; returns value and sigma of the first
 * parameter. */
static void solve_least_squares(double *value, double *sigma) {
    enum { N = NUISANCES + 1 };
    long double matrix[N][N + 2] = {{0}};
    const double *image[N] = {derivative, nuisances[0], nuisances[1], nuisances[2]};
    for (size_t a = 0; a < N; a++)
        for (size_t i = 0; i < PIXELS; i++) {
            const long double weighted = image[a][i] / (long double)variance[i];
            for (size_t b = 0; b < N; b++)
                matrix[a][b] += weighted * image[b][i];
            matrix[a][N] += weighted * (counts[i] - (long double)reference[i]);
        }
    matrix[0][N + 1] = 1; /* the first column of the inverse */
    for (size_t a = 0; a < N; a++) {
        const long double pivot = matrix[a][a];
        for (size_t c = 0; c < N + 2; c++)
            matrix[a][c] /= pivot;
        for (size_t b = 0; b < N; b++) {
            const long double factor = matrix[b][a];
            for (size_t c = 0; c < N + 2 && b != a; c++)
                matrix[b][c] -= factor * matrix[a][c];
        }
    }
    *value = (double)matrix[0][N];
    *sigma = sqrt((double)matrix[0][N + 1]);
}

static void estimate_matches_least_squares(void **state) {
    (void)state;
    double value, sigma, expected_value, expected_sigma;
    solve_least_squares(&expected_value, &expected_sigma);
    assert_int_equal(
        shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 1, counts, &value, &sigma),
        0);
    assert_close(value, expected_value, 1e-12, 0);
    assert_close(sigma, expected_sigma, 1e-13, 0);
}

static void nuisances_do_not_leak_and_the_slope_is_one(void **state) {
    (void)state;
    double frames[3][PIXELS], values[3], sigma;
    for (size_t i = 0; i < PIXELS; i++) {
        frames[0][i] = reference[i];
        frames[1][i] = reference[i] + 5 * nuisances[0][i] - 3 * nuisances[2][i];
        frames[2][i] = frames[1][i] + 0.01 * derivative[i];
    }
    assert_int_equal(shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 3, frames[0],
                                   values, &sigma),
                     0);
    assert_true(values[0] == 0);
    assert_close(values[1], 0, 0, 1e-13);
    assert_close(values[2], 0.01, 1e-11, 0);
}

static void a_derivative_that_nuisances_explain_is_refused(void **state) {
    (void)state;
    double value, sigma;
    for (size_t i = 0; i < PIXELS; i++)
        nuisances[1][i] = 2 * derivative[i] - nuisances[0][i];
    const int status =
        shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 1, counts, &value, &sigma);
    assert_int_equal(status, TOLIMAN_E_SCENE);
    assert_non_null(strstr(toliman_last_error(), "preprocess.project"));
    for (size_t i = 0; i < PIXELS; i++)
        derivative[i] = 0;
    assert_int_equal(shim_template(ROWS, COLS, reference, variance, derivative, 0, NULL, 1, counts, &value, &sigma),
                     TOLIMAN_E_SCENE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(estimate_matches_least_squares, make_model),
        cmocka_unit_test_setup(nuisances_do_not_leak_and_the_slope_is_one, make_model),
        cmocka_unit_test_setup(a_derivative_that_nuisances_explain_is_refused, make_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
