/* Tests the push kernel for samples with nuisance functions: terms against 113 bits, equal bits on all instruction
 * sets, removal. */
#include <quadmath.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_push_rows(int isa, double f0, double df, size_t blocks, const double *sample, size_t functions,
                    const double *high, const double *low, int64_t *lo);

enum { BLOCKS = 67, WIDTH = 64 * BLOCKS, FUNCTIONS = 3, SUMS = 14 + 4 * (FUNCTIONS - 1) }; /* over 4096 frequencies */
static int64_t sums[3][SUMS * WIDTH];

static __float128 value(const int64_t *lo, int k, int high, int low) {
    const __float128 unit = 0x1p-50Q;
    return unit * (lo[high * WIDTH + k] + unit * lo[low * WIDTH + k]);
}

/* The terms of all sums, whose phases have 100 bits, also for many cycles. */
static void terms_follow_their_definition(void **unused) {
    const double f0 = 0.013, df = 0.00171, times[] = {777.123, -1e-3, 1.25e5};
    const double high[FUNCTIONS] = {-0.61, 0.83, 1.0 / 3}, low[FUNCTIONS] = {1.3e-18, -2e-17, 0};
    for (int n = 0; n < 3; n++) {
        const double sample[3] = {times[n], times[n] * 0x1p-55, n == 1 ? 1 : 0.37};
        int64_t *const lo = sums[0];
        memset(lo, 0, sizeof sums[0]);
        shim_push_rows(0, f0, df, BLOCKS, sample, FUNCTIONS, high, low, lo);
        double worst[3] = {0};
        const __float128 w = sample[2], t = (__float128)sample[0] + sample[1];
        for (int k = 0; k < WIDTH; k++) {
            const __float128 cycles = ((__float128)f0 + k * (__float128)df) * t;
            const __float128 angle = 2 * M_PIq * (cycles - rintq(cycles)), wave[2] = {cosq(angle), sinq(angle)};
            const __float128 twice[2] = {cosq(2 * angle), sinq(2 * angle)};
            for (int i = 0; i < 2; i++) {
                worst[0] = fmax(worst[0], fabs((double)(value(lo, k, i, 8 + i) - w * wave[i])));
                worst[1] = fmax(worst[1], fabs((double)(value(lo, k, 2 + i, 10 + i) - w * twice[i])));
                for (int f = 0; f < FUNCTIONS; f++) {
                    const int at = f == 0 ? 4 + i : 14 + 4 * (f - 1) + i;
                    const __float128 term = w * ((__float128)high[f] + low[f]) * wave[i];
                    worst[2] = fmax(worst[2], fabs((double)(value(lo, k, at, at + 2) - term)));
                }
            }
        }
        const double cycles = fabs(times[n]) * (f0 + df * WIDTH);
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
        shim_push_rows(isa, 1.0 / 3, 0.001 / 7, BLOCKS, sample, FUNCTIONS, high, low, lo);
    }
}

static void equal_bits_on_all_instruction_sets(void **unused) {
    memset(sums, 0, sizeof sums);
    for (int isa = 0; isa < shim_isas(); isa++) {
        push_many(isa, 1, sums[isa]);
        assert_memory_equal(sums[isa], sums[0], sizeof sums[0]);
    }
    push_many(0, -1, sums[0]); /* removes all samples */
    for (int i = 0; i < SUMS * WIDTH; i++)
        assert_int_equal(sums[0][i], 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_follow_their_definition),
        cmocka_unit_test(equal_bits_on_all_instruction_sets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
