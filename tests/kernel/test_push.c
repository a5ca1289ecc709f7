/* Tests the push kernels, without and with nuisance functions: cosine and sine against 113 bits, terms against their
 * definition, equal bits on all instruction sets, removal. */
#include "quad_math.h"
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_push(int isa, int double_limb, double f0, double df, size_t blocks, const double *sample, double *anchors,
               int64_t *lo);
void shim_fold(int isa, int64_t *lo, int64_t *hi, size_t n);
void shim_cis(int isa, double f_high, double f_low, double t_high, double t_low, double *cosine, double *sine);
void shim_push_rows(int isa, double f0, double df, size_t blocks, const double *sample, size_t functions,
                    const double *high, const double *low, int64_t *lo);

enum { BLOCKS = 3, WIDTH = 64 * BLOCKS, SUMS = 8, DOUBLE_LIMB_SUMS = 14 };

/* f t far above one cycle: the product must be reduced without loss of digits. */
TEST(cosine_and_sine) {
    uint64_t state = 3;
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        const double f = pow(10, -4 + 4 * uniform(&state)), f_low = f * 0x1p-54 * uniform(&state);
        const double t = pow(10, -3 + 11 * uniform(&state)) * (i % 2 ? 1 : -1), t_low = t * 0x1p-54 * uniform(&state);
        double c, s;
        shim_cis(0, f, f_low, t, t_low, &c, &s);
        const quad cycles = ((quad)f + f_low) * ((quad)t + t_low);
        const quad angle = 2 * M_PIq * (cycles - rintq(cycles));
        worst = fmax(worst, fabs((double)(c - cosq(angle))));
        worst = fmax(worst, fabs((double)(s - sinq(angle))));
        for (int isa = 1; isa < shim_isas(); isa++) {
            double c2, s2;
            shim_cis(isa, f, f_low, t, t_low, &c2, &s2);
            assert_memory_equal(&c, &c2, sizeof c);
            assert_memory_equal(&s, &s2, sizeof s);
        }
    }
    assert_at_most(worst, 2e-16);
}

TEST(terms_follow_their_definition) {
    const double f0 = 0.013, df = 0.00171, unit = 0x1p50;
    const double sample[5] = {777.123, 1e-14, 0.37, -0.61, 1.3e-18};
    double anchors[2 * BLOCKS];
    static int64_t lo[SUMS * WIDTH];
    memset(lo, 0, sizeof lo);
    shim_push(0, 0, f0, df, BLOCKS, sample, anchors, lo);
    for (int k = 0; k < WIDTH; k++) {
        const quad cycles = ((quad)f0 + k * (quad)df) * ((quad)sample[0] + sample[1]);
        const quad angle = 2 * M_PIq * (cycles - rintq(cycles)), c = cosq(angle), s = sinq(angle);
        const quad w = sample[2], wy = w * ((quad)sample[3] + sample[4]);
        const quad expected[6] = {w * c, w * s, w * cosq(2 * angle), w * sinq(2 * angle), wy * c, wy * s};
        for (int i = 0; i < 6; i++)
            assert_close((double)lo[i * WIDTH + k] / unit, (double)expected[i], 0, 1.5e-15);
        /* the two limbs together hold every digit of the product of the rounded cosine */
        for (int i = 4; i < 6; i++) {
            const quad both = lo[i * WIDTH + k] / (quad)unit + lo[(i + 2) * WIDTH + k] / ((quad)unit * unit);
            assert_close((double)both, (double)expected[i], 0, 4e-16);
            assert_true(fabs((double)lo[(i + 2) * WIDTH + k]) <= 0.75 * unit);
        }
    }
}

/* The limbs of a double-limb push, for heavy and light samples: close to the phase, and on the unit circle to 2^-98. */
TEST(double_limb_terms_lie_on_the_circle) {
    const double f0 = 0.013, df = 0.00171;
    const quad unit = QUAD(0x1p-50);
    double anchors[2 * BLOCKS];
    static int64_t lo[DOUBLE_LIMB_SUMS * WIDTH];
    for (int light = 0; light < 2; light++) {
        const double sample[5] = {777.123, 1e-14, light ? 1e-16 / 3 : 1, -0.61, 1.3e-18};
        const quad w = sample[2], y = (quad)sample[3] + sample[4];
        memset(lo, 0, sizeof lo);
        shim_push(0, 1, f0, df, BLOCKS, sample, anchors, lo);
        for (int k = 0; k < WIDTH; k++) {
            const quad cycles = ((quad)f0 + k * (quad)df) * ((quad)sample[0] + sample[1]);
            const quad angle = 2 * M_PIq * (cycles - rintq(cycles));
            quad term[6];
            static const int low[6] = {8, 9, 10, 11, 6, 7};
            for (int i = 0; i < 6; i++)
                term[i] = unit * (lo[i * WIDTH + k] + unit * lo[low[i] * WIDTH + k]);
            for (int i = 4; i < 6; i++)
                term[i] += unit * unit * unit * lo[(i + 8) * WIDTH + k];
            const quad c = term[0] / w, s = term[1] / w, atol = light ? 1e-13 : 4e-30;
            assert_close((double)(c - cosq(angle)), 0, 0, light ? 3e-14 : 4.1e-16);
            assert_close((double)(s - sinq(angle)), 0, 0, light ? 3e-14 : 4.1e-16);
            assert_true(fabsq(c * c + s * s - 1) <= atol);
            assert_true(fabsq(c * c - s * s - term[2] / w) <= atol);
            assert_true(fabsq(2 * c * s - term[3] / w) <= atol);
            assert_true(fabsq(y * c - term[4] / w) <= atol);
            assert_true(fabsq(y * s - term[5] / w) <= atol);
            if (light) /* the third limb: values keep their digits at the smallest weight */
                assert_true(fabsq(y * cosq(angle) - term[4] / w) <= 4e-16);
        }
    }
}

static void equal_bits(int double_limb, int sums) {
    static int64_t lo[3][DOUBLE_LIMB_SUMS * WIDTH], hi[3][DOUBLE_LIMB_SUMS * WIDTH];
    double anchors[2 * BLOCKS];
    const int isas = shim_isas();
    memset(lo, 0, sizeof lo);
    memset(hi, 0, sizeof hi);
    for (int isa = 0; isa < isas; isa++) {
        uint64_t state = 11;
        for (int n = 0; n < 3000; n++) {
            const double t = 1e6 * uniform(&state), y = 2 * uniform(&state) - 1;
            const double sample[5] = {t, t * 0x1p-55, uniform(&state), y, y * 0x1p-56};
            shim_push(isa, double_limb, 1.0 / 3, 0.001 / 7, BLOCKS, sample, anchors, lo[isa]);
            if (n % 1000 == 0)
                shim_fold(isa, lo[isa], hi[isa], (size_t)sums * WIDTH);
        }
        shim_fold(isa, lo[isa], hi[isa], (size_t)sums * WIDTH);
        assert_memory_equal(lo[isa], lo[0], sizeof lo[0]);
        assert_memory_equal(hi[isa], hi[0], sizeof hi[0]);
    }
    for (int i = 0; i < sums * WIDTH; i++)
        assert_true(lo[0][i] >= 0 && lo[0][i] < (int64_t)1 << 32);
}

TEST(equal_bits_on_all_instruction_sets) {
    equal_bits(0, SUMS);
    equal_bits(1, DOUBLE_LIMB_SUMS);
}

/* Samples with nuisance functions, at more than 4096 frequencies. */
enum { ROW_BLOCKS = 67, ROW_WIDTH = 64 * ROW_BLOCKS, FUNCTIONS = 3, ROW_SUMS = 14 + 4 * (FUNCTIONS - 1) };
static int64_t sums[3][ROW_SUMS * ROW_WIDTH];

static quad value(const int64_t *lo, int k, int high, int low) {
    const quad unit = QUAD(0x1p-50);
    return unit * (lo[high * ROW_WIDTH + k] + unit * lo[low * ROW_WIDTH + k]);
}

/* The terms of all sums, whose phases have 100 bits, also for many cycles. */
TEST(row_terms_follow_their_definition) {
    const double f0 = 0.013, df = 0.00171, times[] = {777.123, -1e-3, 1.25e5};
    const double high[FUNCTIONS] = {-0.61, 0.83, 1.0 / 3}, low[FUNCTIONS] = {1.3e-18, -2e-17, 0};
    for (int n = 0; n < 3; n++) {
        const double sample[3] = {times[n], times[n] * 0x1p-55, n == 1 ? 1 : 0.37};
        int64_t *const lo = sums[0];
        memset(lo, 0, sizeof sums[0]);
        shim_push_rows(0, f0, df, ROW_BLOCKS, sample, FUNCTIONS, high, low, lo);
        double worst[3] = {0};
        const quad w = sample[2], t = (quad)sample[0] + sample[1];
        for (int k = 0; k < ROW_WIDTH; k++) {
            const quad cycles = ((quad)f0 + k * (quad)df) * t;
            const quad angle = 2 * M_PIq * (cycles - rintq(cycles)), wave[2] = {cosq(angle), sinq(angle)};
            const quad twice[2] = {cosq(2 * angle), sinq(2 * angle)};
            for (int i = 0; i < 2; i++) {
                worst[0] = fmax(worst[0], fabs((double)(value(lo, k, i, 8 + i) - w * wave[i])));
                worst[1] = fmax(worst[1], fabs((double)(value(lo, k, 2 + i, 10 + i) - w * twice[i])));
                for (int f = 0; f < FUNCTIONS; f++) {
                    const int at = f == 0 ? 4 + i : 14 + 4 * (f - 1) + i;
                    const quad term = w * ((quad)high[f] + low[f]) * wave[i];
                    worst[2] = fmax(worst[2], fabs((double)(value(lo, k, at, at + 2) - term)));
                }
            }
        }
        const double cycles = fabs(times[n]) * (f0 + df * ROW_WIDTH);
        for (int i = 0; i < 3; i++)
            assert_at_most(worst[i], (i == 1 ? 2 : 1) * (3e-30 + 5e-34 * cycles));
    }
}

static void push_many(int isa, double sign, int64_t *lo) {
    uint64_t state = 11;
    for (int n = 0; n < 300; n++) {
        const double t = 1e4 * uniform(&state), sample[3] = {t, t * 0x1p-55, sign * uniform(&state)};
        double high[FUNCTIONS], low[FUNCTIONS];
        for (int f = 0; f < FUNCTIONS; f++) {
            high[f] = 2 * uniform(&state) - 1;
            low[f] = high[f] * 0x1p-56;
        }
        shim_push_rows(isa, 1.0 / 3, 0.001 / 7, ROW_BLOCKS, sample, FUNCTIONS, high, low, lo);
    }
}

TEST(equal_bits_of_rows) {
    memset(sums, 0, sizeof sums);
    for (int isa = 0; isa < shim_isas(); isa++) {
        push_many(isa, 1, sums[isa]);
        assert_memory_equal(sums[isa], sums[0], sizeof sums[0]);
    }
    push_many(0, -1, sums[0]); /* removes all samples */
    for (int i = 0; i < ROW_SUMS * ROW_WIDTH; i++)
        assert_int_equal(sums[0][i], 0);
}

RUN_TESTS(NULL, NULL)
