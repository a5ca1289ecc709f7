/* Tests the template estimator on synthetic frames against the normal equations of weighted least squares. */
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

static uint64_t draws = 31;

int shim_template(size_t rows, size_t cols, const double *reference, const double *variance, const double *derivative,
                  size_t count, const double *nuisances, size_t frames, const double *counts, double *values,
                  double *sigma_px, double *goodness);

enum { ROWS = 24, COLS = 20, PIXELS = ROWS * COLS, NUISANCES = 3 };

static double reference[PIXELS], variance[PIXELS], derivative[PIXELS], nuisances[NUISANCES][PIXELS], counts[PIXELS];

static int make_model(void **state) {
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

/* Solves the weighted normal equations for derivative and nuisances together, without the pixels that are left out;
 * returns value and sigma of the first parameter, and the chi-square per degree of freedom. */
static void solve_least_squares(const unsigned char *left_out, double *value, double *sigma, double *chi_square) {
    enum { N = NUISANCES + 1 };
    long double matrix[N][N + 2] = {{0}}, square = 0;
    const double *image[N] = {derivative, nuisances[0], nuisances[1], nuisances[2]};
    int used = 0;
    for (size_t a = 0; a < N; a++)
        for (size_t i = 0; i < PIXELS; i++) {
            const long double weighted = left_out[i] ? 0 : image[a][i] / (long double)variance[i];
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
    for (size_t i = 0; i < PIXELS; i++) {
        long double left = counts[i] - (long double)reference[i];
        for (size_t a = 0; a < N; a++)
            left -= matrix[a][N] * image[a][i];
        square += left_out[i] ? 0 : left * left / variance[i];
        used += !left_out[i];
    }
    *value = (double)matrix[0][N];
    *sigma = sqrt((double)matrix[0][N + 1]);
    *chi_square = (double)(square / (used - N));
}

static const unsigned char none[PIXELS];

TEST_WITH(estimate_matches_least_squares, make_model, NULL) {
    double value, sigma, chi_square, expected_value, expected_sigma;
    solve_least_squares(none, &expected_value, &expected_sigma, &chi_square);
    assert_int_equal(shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 1, counts,
                                   &value, &sigma, NULL),
                     0);
    assert_close(value, expected_value, 1e-12, 0);
    assert_close(sigma, expected_sigma, 1e-13, 0);
}

TEST_WITH(a_derivative_that_nuisances_explain_is_refused, make_model, NULL) {
    double value, sigma;
    for (size_t i = 0; i < PIXELS; i++)
        nuisances[1][i] = 2 * derivative[i] - nuisances[0][i];
    const int status = shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 1, counts,
                                     &value, &sigma, NULL);
    assert_int_equal(status, TOLIMAN_E_SCENE);
    assert_non_null(strstr(toliman_last_error(), "preprocess.project"));
    for (size_t i = 0; i < PIXELS; i++)
        derivative[i] = 0;
    assert_int_equal(
        shim_template(ROWS, COLS, reference, variance, derivative, 0, NULL, 1, counts, &value, &sigma, NULL),
        TOLIMAN_E_SCENE);
}

enum { MOST_BAD = 30 };
static const struct {
    const char *name;
    int number, step;    /* pixels 7, 7 + step, ... */
    double sigmas, more; /* what is added to the first pixel, and to each further one more than to the one before */
    int found;           /* -1: number */
} damages[] = {
    {"one, just above the limit", 1, 1, 12, 0, -1},
    {"one of 10,000 standard deviations", 1, 1, 1e4, 0, -1},
    {"a hot one", 1, 1, 1e11, 0, -1},
    {"a dead one", 1, 1, -25, 0, -1},
    {"neighbours", 4, 1, 300, 10, -1},
    {"ten of very different size", 10, 17, 20, 5000, -1},
    {"as many as are left out", MOST_BAD, 13, 40, 25, -1},
    {"one more than are left out", MOST_BAD + 1, 13, 40, 25, 0},
    {"none", 0, 1, 0, 0, -1},
};

/* The estimate without the bad pixels is that of the other pixels alone; with too many it is that of all. */
/* promises: bad-pixels-are-left-out, wrong-models-are-not-cleaned */
TEST_WITH(bad_pixels_are_left_out, make_model, NULL) {
    double clean[PIXELS];
    memcpy(clean, counts, sizeof clean);
    for (size_t d = 0; d < sizeof damages / sizeof *damages; d++) {
        unsigned char left_out[PIXELS] = {0};
        memcpy(counts, clean, sizeof counts);
        for (int i = 0; i < damages[d].number; i++) {
            const int pixel = 7 + i * damages[d].step;
            counts[pixel] += (damages[d].sigmas + i * damages[d].more) * sqrt(variance[pixel]);
            left_out[pixel] = damages[d].found != 0;
        }
        double values[2], sigma, expected, expected_sigma, chi_square, goodness[4];
        solve_least_squares(left_out, &expected, &expected_sigma, &chi_square);
        for (int asked = 0; asked < 2; asked++)
            assert_int_equal(shim_template(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], 1,
                                           counts, &values[asked], &sigma, asked ? goodness : NULL),
                             0);
        print_message("%s: value %.6g, bad pixels %.0f, chi-square %.6g\n", damages[d].name, values[0], goodness[3],
                      goodness[0]);
        assert_memory_equal(&values[0], &values[1], sizeof values[0]);
        assert_int_equal((int)goodness[3], damages[d].found < 0 ? damages[d].number : damages[d].found);
        assert_close(values[0], expected, 1e-9, 1e-4 * expected_sigma);
        assert_close(goodness[0], chi_square, 1e-4, 0);
        assert_true(goodness[2] > 0 && (goodness[2] < 8 || damages[d].found == 0));
    }
}

RUN_TESTS(NULL, NULL)
