/* Tests the power from fixed-point sums against 113-bit arithmetic on the same sums, with every instruction set. */
#include <quadmath.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
size_t shim_power(int isa, int double_limb, const int64_t *const *lo, const int64_t *const *hi, size_t n, double weight,
                  int64_t samples, double mean_high, double mean_low, double spread, int fixed_mean, double *power);
int shim_any_reaches(int isa, const double *values, size_t n, double limit);

enum {
    N = 203,
    C1 = 0,
    S1,
    C2,
    S2,
    YC,
    YS,
    YCLOW,
    YSLOW,
    NARROW_SUMS,
    C1LOW = NARROW_SUMS,
    S1LOW,
    C2LOW,
    S2LOW,
    YCLOWEST,
    YSLOWEST,
    SUMS
};

static int64_t lo[SUMS][N], hi[SUMS][N];

static uint64_t state = 5;

/* Splits x, in units of a limb, into a carry-save pair whose low part is not folded. */
static void put(int sum, int k, __float128 x) {
    const __float128 upper = floorq(x / 0x1p32Q) + (int64_t)(uniform_signed(&state) * 1000);
    hi[sum][k] = (int64_t)upper;
    lo[sum][k] = (int64_t)(x - upper * 0x1p32Q);
}

static __float128 get(int sum, int k) {
    return (__float128)hi[sum][k] * 0x1p32Q + (__float128)lo[sum][k];
}

/* The sum of a cosine including its lower limb, which single-limb accumulators do not have. */
static __float128 whole(int sum, int low, int k, int double_limb) {
    return get(sum, k) + (double_limb ? get(low, k) * 0x1p-50Q : 0);
}

static __float128 exact_power(int double_limb, int k, __float128 weight, __float128 mean, double spread, int fixed_mean,
                              __float128 *determinant) {
    const __float128 unit = 0x1p-50Q / weight, moving = fixed_mean ? 0 : 1;
    const __float128 c = whole(C1, C1LOW, k, double_limb) * unit, s = whole(S1, S1LOW, k, double_limb) * unit;
    const __float128 cc = 0.5Q + whole(C2, C2LOW, k, double_limb) * unit / 2 - moving * c * c;
    const __float128 ss = 0.5Q - whole(C2, C2LOW, k, double_limb) * unit / 2 - moving * s * s;
    const __float128 cs = whole(S2, S2LOW, k, double_limb) * unit / 2 - moving * c * s;
    const __float128 yc = (get(YC, k) + get(YCLOW, k) * 0x1p-50Q) * unit - mean * c;
    const __float128 ys = (get(YS, k) + get(YSLOW, k) * 0x1p-50Q) * unit - mean * s;
    *determinant = cc * ss - cs * cs;
    return (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / *determinant / (__float128)spread;
}

/* Sums as real samples produce: weights of `samples`, values scattering by `sigma` about `mean`. */
static void check_kind(int double_limb, double samples, double mean, double sigma) {
    const int64_t *low[SUMS], *high[SUMS];
    for (int s = 0; s < SUMS; s++)
        low[s] = lo[s], high[s] = hi[s];
    const __float128 weight = (__float128)samples * 0.875Q, one = 0x1p50Q * weight;
    const __float128 exact_mean = (__float128)mean * (1 + 0x1p-60Q);
    for (int k = 0; k < N; k++) {
        /* Every seventh frequency: cosine and sine hardly vary, which needs more than double precision. */
        const double flat = k % 7 == 3 ? 0.999 : 0.3 * uniform_signed(&state),
                     even = k % 7 == 5 ? 0.8 : 0.2 * uniform_signed(&state);
        put(C1, k, one * flat);
        put(S1, k, one * 0.2 * uniform_signed(&state));
        put(C2, k, one * (k % 7 == 3 ? 0.998 : even));
        put(S2, k, one * 0.2 * uniform_signed(&state));
        for (int limb = C1LOW; limb <= S2LOW; limb++)
            put(limb, k, rintq((__float128)samples * 0x1p49Q * uniform_signed(&state)));
        for (int part = 0; part < 2; part++) {
            const __float128 x = exact_mean * whole(part ? S1 : C1, part ? S1LOW : C1LOW, k, double_limb) +
                                 one * sigma * 0.3 * uniform_signed(&state);
            const __float128 whole = rintq(x);
            put(part ? YS : YC, k, whole);
            put(part ? YSLOW : YCLOW, k, rintq((x - whole) * 0x1p50Q));
        }
    }
    const double spread = sigma * sigma;
    for (int fixed_mean = 0; fixed_mean < 2; fixed_mean++) {
        double first[N], power[N];
        size_t reported = 0;
        for (int isa = 0; isa < shim_isas(); isa++) {
            reported = shim_power(isa, double_limb, low, high, N, (double)weight, (int64_t)samples, (double)exact_mean,
                                  (double)(exact_mean - (__float128)(double)exact_mean), spread, fixed_mean, power);
            if (isa == 0)
                memcpy(first, power, sizeof first);
            assert_memory_equal(first, power, sizeof first);
        }
        int left_out = 0;
        for (int k = 0; k < N; k++) {
            __float128 determinant;
            const __float128 expected =
                exact_power(double_limb, k, weight, exact_mean, spread, fixed_mean, &determinant);
            if (first[k] == -1) {
                left_out++;
                assert_true(determinant < 0.0501Q);
            } else {
                assert_true(determinant > 0.0499Q);
                assert_close(first[k], (double)(expected > 1 ? 1 : expected < 0 ? 0 : expected), 0, 1e-13);
            }
        }
        assert_int_equal(left_out, reported);
        assert_true(left_out >= (fixed_mean ? 0 : N / 7) && left_out < N / 2);
    }
}

static void check(double samples, double mean, double sigma) {
    check_kind(0, samples, mean, sigma);
    check_kind(1, samples, mean, sigma);
}

static void test_latents(void **unused) {
    check(1095, 0, 1e-3);
    check(1095, 7.9e-3, 1e-3);
    check(5, 0.1, 0.2);
    check(1e6, 3e-4, 1e-2);
}

static void test_many_samples(void **unused) {
    check(0x1p31, 0.4, 0.2);
}

static void test_mean_far_off(void **unused) {
    check(300, 0.9, 3e-5);
    check(1e6, -0.7, 3e-5);
    check(0x1p31, 0.3, 1e-5);
    check(1e6, 0.1, 0.01);
}

static void test_values_far_below_their_bound(void **unused) {
    check(200, 1e-16, 1e-15);
    check(200, 1e-12, 1e-15);
    check(0x1p22, 1e-12, 1e-13);
    check(0x1p22, -3e-12, 1e-16);
    check(1e6, 1e-12, 1e-12);
}

static void test_any_reaches(void **unused) {
    enum { MOST = 37 };
    for (int isa = 0; isa < shim_isas(); isa++)
        for (size_t n = 0; n <= MOST; n++) {
            double values[MOST] = {0};
            assert_false(shim_any_reaches(isa, values, n, 0x1p-1074));
            for (size_t k = 0; k < n; k++) {
                values[k] = 0.25;
                assert_true(shim_any_reaches(isa, values, n, 0.25));
                assert_false(shim_any_reaches(isa, values, n, 0.25 + 0x1p-54));
                values[k] = 0;
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_latents),      cmocka_unit_test(test_many_samples),
        cmocka_unit_test(test_mean_far_off), cmocka_unit_test(test_values_far_below_their_bound),
        cmocka_unit_test(test_any_reaches),
    };
    return cmocka_run_group_tests_name("power", tests, NULL, NULL);
}
