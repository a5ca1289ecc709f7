/* Tests the sums of the non-uniform FFT in the worst cases, and the direct sums of 1 - cosine and sine, against 113-bit
 * sums, and equal bits on every instruction set. */
#include "quad_math.h"
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_spread(int isa, const double *t_high, const double *t_low, const double *w, const double *x, size_t n,
                 size_t width, size_t lanes, const double *coefficients, double df, double f_high, double f_low,
                 double cells, size_t pairs, double *const *grids);
double shim_nufft(size_t modes, double error, const double *t_high, const double *t_low, const double *w,
                  const double *x, size_t n, double df, double f_high, double f_low, double *sums_w, double *sums_x,
                  size_t *cells);
void shim_direct(int isa, const double *half_high, const double *half_low, const double *t_high, const double *t_low,
                 const double *w, const double *x, size_t n, double *high, double *low);

enum { N = 150, MODES = 101, LANES = 16, SUMS = 7 };
static double t_high[N], t_low[N], w[N], x[N];

static uint64_t state = 11;

static void fill(double span) {
    for (int i = 0; i < N; i++) {
        t_high[i] = span * uniform_signed(&state);
        t_low[i] = t_high[i] * 0x1p-54 * uniform_signed(&state);
        w[i] = (1 + 0.9 * uniform_signed(&state)) / N;
        x[i] = uniform_signed(&state) / N;
    }
}

static quad_complex exact_sum(const double *weights, size_t n, quad f) {
    quad_complex sum = 0;
    for (size_t i = 0; i < n; i++) {
        const quad cycles = f * ((quad)t_high[i] + t_low[i]), part = cycles - rintq(cycles);
        sum += weights[i] * cexpiq(2 * M_PIq * part);
    }
    return sum;
}

/* Largest difference from the exact sum, relative to the sum of |weights|. */
static double worst_error(const double *sums, const double *weights, size_t n, size_t modes, size_t step, double df,
                          double f_high, double f_low) {
    double worst = 0, all = 0;
    for (size_t i = 0; i < n; i++)
        all += fabs(weights[i]);
    for (size_t k = 0; k < modes; k += step) {
        const quad f = (quad)df * ((int)k - (int)(modes / 2)) + f_high + f_low;
        const quad_complex exact = exact_sum(weights, n, f);
        worst = fmax(worst, (double)hypotq(sums[2 * k] - crealq(exact), sums[2 * k + 1] - cimagq(exact)) / all);
    }
    return worst;
}

/* One sample at various places between two cells: the error stays within the table's bound, and the bound is no more
 * than 20 times larger. */
TEST(test_error_of_one_sample) {
    static const double requested[] = {2e-4, 2e-6, 2e-8, 2e-10, 2e-12, 2e-14};
    for (size_t a = 0; a < sizeof requested / sizeof requested[0]; a++) {
        double sums_w[2 * MODES], sums_x[2 * MODES], worst = 0, bound = 0;
        for (int place = 0; place <= 24; place++) {
            size_t cells;
            shim_nufft(MODES, requested[a], t_high, t_low, w, x, 0, 1, 0, 0, sums_w, sums_x, &cells);
            t_high[0] = (40 + place / 24.0) / (double)cells;
            t_low[0] = 0;
            w[0] = x[0] = 1;
            bound = shim_nufft(MODES, requested[a], t_high, t_low, w, x, 1, 1, 0.375, 0, sums_w, sums_x, &cells);
            worst = fmax(worst, worst_error(sums_w, w, 1, MODES, 1, 1, 0.375, 0));
        }
        assert_true(bound <= requested[a]);
        if (!(worst <= bound && worst > bound / 20))
            fail_msg("requested %g: bound %g, found %g", requested[a], bound, worst);
    }
}

/* Phases of many cycles, many modes, times as two doubles: the error bound holds. */
TEST(test_many_samples) {
    static const struct {
        double span, df, f_high, f_low;
        size_t modes;
    } cases[] = {{10, 0.01, 3, 0, MODES},      {1e3, 0.1, 1e8, 1e-9, MODES},
                 {1e9, 1e-3, 1e5, 0, 8},       {0.5, 0.999, 20, 0, 200000},
                 {1e12, 1e2, 0, 0, 33},        {1e-6, 1, 3, 0, MODES},
                 {1e4, 1e-5, 1, 1e-17, 20001}, {3, 0.1, 1, 0, 1}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        const size_t modes = cases[c].modes, step = modes > 200 ? modes / 97 : 1;
        double *sums_w = malloc(2 * modes * sizeof(double)), *sums_x = malloc(2 * modes * sizeof(double));
        fill(cases[c].span);
        for (double requested = 1e-4; requested > 1e-15; requested *= 1e-3) {
            size_t cells;
            const double bound = shim_nufft(modes, requested, t_high, t_low, w, x, N, cases[c].df, cases[c].f_high,
                                            cases[c].f_low, sums_w, sums_x, &cells);
            const double error_w = worst_error(sums_w, w, N, modes, step, cases[c].df, cases[c].f_high, cases[c].f_low);
            const double error_x = worst_error(sums_x, x, N, modes, step, cases[c].df, cases[c].f_high, cases[c].f_low);
            if (!(error_w <= bound && error_x <= bound))
                fail_msg("case %zu, requested %g: bound %g, found %g and %g", c, requested, bound, error_w, error_x);
        }
        free(sums_w), free(sums_x);
    }
}

TEST(test_same_bits) {
    enum { CELLS = 60, SIZE = CELLS + 16 };
    static const size_t lanes[] = {8, 12, 16};
    double coefficients[4 * 16];
    for (size_t i = 0; i < 64; i++)
        coefficients[i] = uniform_signed(&state);
    fill(1e5);
    for (size_t l = 0; l < 3; l++)
        for (size_t pairs = 1; pairs <= 2; pairs++) {
            double first[4][SIZE], grids[4][SIZE];
            double *const at[] = {grids[0], grids[1], grids[2], grids[3]};
            for (int isa = 0; isa < shim_isas(); isa++) {
                memset(grids, 0, sizeof grids);
                shim_spread(isa, t_high, t_low, w, x, N, lanes[l] - 1, lanes[l], coefficients, 0.37, 1.5, 1e-17, CELLS,
                            pairs, at);
                if (isa == 0)
                    memcpy(first, grids, sizeof first);
                assert_memory_equal(first, grids, sizeof first);
            }
        }
}

/* Frequencies from f on: the error of a sum is at most 2e-15 times the sum of the magnitudes of its terms, also for
 * small sums. */
static void check_direct(double span, double f, double step) {
    double half_high[LANES], half_low[LANES], first[2][SUMS * LANES], sums[2][SUMS * LANES];
    fill(span);
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
        quad exact[SUMS] = {0}, size[SUMS] = {0};
        for (int i = 0; i < N; i++) {
            const quad t = (quad)t_high[i] + t_low[i], cycles = ((quad)half_high[j] + half_low[j]) * t;
            const quad angle = M_PIq * 2 * (cycles - rintq(cycles)), s = sinq(angle);
            const quad u = 2 * s * s, v = 2 * s * cosq(angle);
            const quad terms[SUMS] = {w[i] * u, w[i] * v, w[i] * u * u, w[i] * u * v, w[i] * v * v, x[i] * u, x[i] * v};
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

TEST(test_direct_sums) {
    check_direct(100, 0.3, 0.7);
    check_direct(1e9, 1e4, 0.1);
}

TEST(test_slow_phases_keep_their_digits) {
    check_direct(1, 1e-6, 1e-7);
    check_direct(1, 1e-60, 1e-61);
}

RUN_TESTS(NULL, NULL)
