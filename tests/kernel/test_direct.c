/* Tests the direct sums of 1 - cosine and sine against 113-bit sums, with every instruction set. */
#include <quadmath.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_direct(int isa, const double *half_high, const double *half_low, const double *t_high, const double *t_low,
                 const double *w, const double *x, size_t n, double *high, double *low);

enum { N = 1003, LANES = 16, SUMS = 7 };
static double t_high[N], t_low[N], w[N], x[N];

static uint64_t state = 4;

/* Frequencies from f on: the error of a sum is at most 2e-15 times the sum of the magnitudes of its terms, also for
 * small sums. */
static void check(double span, double f, double step) {
    double half_high[LANES], half_low[LANES], first[2][SUMS * LANES], sums[2][SUMS * LANES];
    for (int i = 0; i < N; i++) {
        t_high[i] = span * uniform_signed(&state);
        t_low[i] = t_high[i] * 0x1p-54 * uniform_signed(&state);
        w[i] = (1 + 0.9 * uniform_signed(&state)) / N;
        x[i] = uniform_signed(&state) / N;
    }
    for (int j = 0; j < LANES; j++) {
        half_high[j] = (f + step * j) / 2;
        half_low[j] = half_high[j] * 0x1p-55;
    }
    for (int isa = 0; isa < shim_isas(); isa++) {
        memset(sums, 0, sizeof sums);
        shim_direct(isa, half_high, half_low, t_high, t_low, w, x, N, sums[0], sums[1]);
        if (isa == 0)
            memcpy(first, sums, sizeof first);
        assert_memory_equal(first, sums, sizeof first);
    }
    for (int j = 0; j < LANES; j++) {
        __float128 exact[SUMS] = {0}, size[SUMS] = {0};
        for (int i = 0; i < N; i++) {
            const __float128 t = (__float128)t_high[i] + t_low[i],
                             cycles = ((__float128)half_high[j] + half_low[j]) * t;
            const __float128 angle = M_PIq * 2 * (cycles - rintq(cycles)), s = sinq(angle);
            const __float128 u = 2 * s * s, v = 2 * s * cosq(angle);
            const __float128 terms[SUMS] = {w[i] * u,     w[i] * v, w[i] * u * u, w[i] * u * v,
                                            w[i] * v * v, x[i] * u, x[i] * v};
            for (int k = 0; k < SUMS; k++) {
                exact[k] += terms[k];
                size[k] += fabsq(terms[k]);
            }
        }
        for (int k = 0; k < SUMS; k++)
            assert_close(first[0][k * LANES + j] + first[1][k * LANES + j], (double)exact[k], 0,
                         2e-15 * (double)size[k]);
    }
}

static void test_sums(void **unused) {
    check(100, 0.3, 0.7);
    check(1e9, 1e4, 0.1);
}

static void test_slow_phases_keep_their_digits(void **unused) {
    check(1, 1e-6, 1e-7);
    check(1, 1e-60, 1e-61);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums),
        cmocka_unit_test(test_slow_phases_keep_their_digits),
    };
    return cmocka_run_group_tests_name("direct", tests, NULL, NULL);
}
