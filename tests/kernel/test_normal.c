/* Tests weights, residuals, sums of normal equations and correlations with a filter against plain loops in long double,
 * on every instruction set. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
int shim_weigh(int isa, const double *counts, const double *light, const double *response, const double *how,
               double blend, size_t n, double *weight, double *residual, size_t *used, size_t *saturated);
void shim_normal_add(int isa, const double *const *lines, size_t count, const double *weight, size_t n, double *scratch,
                     double *sums);
void shim_whiten(int isa, double *weight, const double *residual, const double *light, const double *predicted,
                 size_t n, double *image);
void shim_correlate(int isa, const double *const *lines, size_t count, const double *root, const double *filter,
                    size_t n, double *scratch, double *sums);

enum { N = 203, LINES = 11, LANES = 8 };

static double counts[N], light[N], response[N], weight[N], residual[N];

/* e_per_count, bias, dark, added_variance, floor, limit */
static const double kHow[6] = {2.5, 100, 3, 7, 0.01, 1e4};

static void make_row(uint64_t seed) {
    for (size_t i = 0; i < N; i++) {
        light[i] = 3000 * fabs(uniform_signed(&seed));
        response[i] = i % 17 == 3 ? 0 : 1 + 0.1 * uniform_signed(&seed);
        counts[i] = (light[i] * response[i] + kHow[2]) / kHow[0] + kHow[1] + 30 * uniform_signed(&seed);
    }
}

TEST(weights_are_inverse_variances) {
    for (int isa = 0; isa < shim_isas(); isa++)
        for (int blended = 0; blended < 2; blended++) {
            make_row(3);
            counts[5] = 5000;              /* at the limit of electrons */
            light[9] = 9700 / response[9]; /* expected within 5 standard deviations of it */
            counts[21] = 0;                /* below the bias: the variance is that added */
            const double blend = blended * 0.5;
            size_t used = 10, saturated = 20, expected_used = 10, expected_saturated = 20;
            assert_int_equal(
                shim_weigh(isa, counts, light, response, kHow, blend, N, weight, residual, &used, &saturated), 1);
            for (size_t i = 0; i < N; i++) {
                const long double electrons = ((long double)counts[i] - kHow[1]) * kHow[0],
                                  expected = (long double)light[i] * response[i] + kHow[2],
                                  mean = (1 - blend) * expected + blend * electrons;
                const long double variance = fmaxl(fmaxl(mean, 0) + kHow[3], kHow[4]);
                const int full = electrons >= kHow[5] || expected + 5 * sqrtl(variance) >= kHow[5];
                const int use = !full && response[i] > 0;
                expected_saturated += (size_t)full;
                expected_used += (size_t)use;
                assert_close(weight[i], use ? (double)((long double)response[i] * response[i] / variance) : 0, 1e-14,
                             0);
                assert_close(residual[i], use ? (double)((electrons - expected) / response[i]) : 0, 1e-12, 1e-11);
            }
            assert_int_equal(used, expected_used);
            assert_int_equal(saturated, expected_saturated);
            assert_true(weight[5] <= 0 && weight[9] <= 0 && weight[3] <= 0 && weight[21] > 0);
        }
}

TEST(counts_that_are_not_finite_are_reported) {
    const double bad[] = {NAN, INFINITY, -INFINITY};
    size_t used = 0, saturated = 0;
    for (int isa = 0; isa < shim_isas(); isa++)
        for (size_t at = 0; at < N; at += 101)
            for (size_t kind = 0; kind < 3; kind++) {
                make_row(4);
                counts[at] = bad[kind];
                assert_int_equal(
                    shim_weigh(isa, counts, light, response, kHow, 0, N, weight, residual, &used, &saturated), 0);
            }
}

static const size_t sizes[] = {1, 7, 8, 9, 64, N};
enum { SIZES = sizeof sizes / sizeof *sizes };

static double values[LINES][N], scratch[N];
static const double *lines[LINES];

static void make_lines(uint64_t seed) {
    for (size_t k = 0; k < LINES; k++) {
        lines[k] = values[k];
        for (size_t i = 0; i < N; i++)
            values[k][i] = uniform_signed(&seed);
    }
    for (size_t i = 0; i < N; i++)
        weight[i] = fabs(uniform_signed(&seed));
}

TEST(sums_are_inner_products) {
    static double sums[3][LINES * LINES * LANES];
    make_lines(8);
    for (size_t s = 0; s < SIZES; s++)
        for (size_t count = 1; count <= LINES; count += 5) {
            memset(sums, 0, sizeof sums);
            for (int isa = 0; isa < shim_isas(); isa++) {
                shim_normal_add(isa, lines, count, weight, sizes[s], scratch, sums[isa]);
                shim_normal_add(isa, lines, count, weight, sizes[s], scratch, sums[isa]); /* adds to what is there */
                assert_memory_equal(sums[isa], sums[0], sizeof *sums);
            }
            for (size_t i = 0; i < count; i++)
                for (size_t j = i; j < count; j++) {
                    long double exact = 0, size = 0, sum = 0;
                    for (size_t p = 0; p < sizes[s]; p++) {
                        exact += 2 * (long double)weight[p] * values[i][p] * values[j][p];
                        size += 2 * fabsl((long double)weight[p] * values[i][p] * values[j][p]);
                    }
                    for (size_t lane = 0; lane < LANES; lane++)
                        sum += sums[0][(i * count + j) * LANES + lane];
                    assert_close((double)sum, (double)exact, 0, 1e-14 * (double)size);
                }
        }
}

/* Against the definition with the counts: (electrons - response predicted - dark)/sigma. */
TEST(whitened_residuals_are_in_standard_deviations) {
    static double predicted[N], image[N], root[N];
    for (int isa = 0; isa < shim_isas(); isa++) {
        make_row(5);
        counts[5] = 5000; /* at the limit of electrons */
        for (size_t i = 0; i < N; i++)
            predicted[i] = light[i] * (1 + 0.01 * (double)(i % 5));
        size_t used = 0, saturated = 0;
        assert_int_equal(shim_weigh(isa, counts, light, response, kHow, 0, N, weight, residual, &used, &saturated), 1);
        assert_int_equal(saturated, 1);
        memcpy(root, weight, sizeof root);
        shim_whiten(isa, root, residual, light, predicted, N, image);
        for (size_t i = 0; i < N; i++) {
            const long double electrons = ((long double)counts[i] - kHow[1]) * kHow[0],
                              sigma = sqrtl((long double)light[i] * response[i] + kHow[2] + kHow[3]),
                              difference = electrons - (long double)predicted[i] * response[i] - kHow[2];
            const int use = i != 5 && response[i] > 0;
            assert_close(root[i], (double)sqrtl(weight[i]), 1e-15, 0);
            assert_close(image[i], use ? (double)(difference / sigma) : 0, 1e-12, 1e-11);
        }
    }
}

/* Of a filter with all lines and with itself, without the pixels of weight 0. */
TEST(correlations_are_inner_products) {
    static double filter[N], sums[3][(LINES + 1) * LANES];
    make_lines(9);
    uint64_t seed = 10;
    for (size_t i = 0; i < N; i++)
        filter[i] = uniform_signed(&seed);
    weight[0] = weight[6] = weight[77] = 0;
    for (size_t s = 0; s < SIZES; s++)
        for (size_t count = 1; count <= LINES; count += 5) {
            const size_t n = sizes[s];
            memset(sums, 0, sizeof sums);
            for (int isa = 0; isa < shim_isas(); isa++) {
                shim_correlate(isa, lines, count, weight, filter, n, scratch, sums[isa]);
                shim_correlate(isa, lines, count, weight, filter, n, scratch, sums[isa]); /* adds to what is there */
                assert_memory_equal(sums[isa], sums[0], sizeof *sums);
            }
            for (size_t i = 0; i <= count; i++) {
                long double exact = 0, size = 0, sum = 0;
                for (size_t p = 0; p < n; p++) {
                    const long double own = weight[p] > 0 ? filter[p] : 0,
                                      term = 2 * own * (i < count ? (long double)weight[p] * values[i][p] : own);
                    exact += term;
                    size += fabsl(term);
                }
                for (size_t lane = 0; lane < LANES; lane++)
                    sum += sums[0][i * LANES + lane];
                assert_close((double)sum, (double)exact, 0, 1e-14 * (double)size);
            }
        }
}

RUN_TESTS(NULL, NULL)
