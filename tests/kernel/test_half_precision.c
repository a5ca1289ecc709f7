/* Tests bf16 and fp16 against their definitions: tables of all numbers, and rounding by search in the tables. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

float shim_to_float32(double value);
uint16_t shim_to_bf16(float value);
float shim_from_bf16(uint16_t bits);
uint16_t shim_to_fp16(double value);
double shim_from_fp16(uint16_t bits);

/* A binary format as IEEE 754 defines it; value[] holds the finite numbers >= 0, and one more: the first beyond the
 * range. */
typedef struct {
    int fraction_bits, bias, count;
    long double value[0x7f81];
} format;

static format bf16 = {.fraction_bits = 7, .bias = 127, .count = 0x7f80};
static format fp16 = {.fraction_bits = 10, .bias = 15, .count = 0x7c00};

static int fill_tables(void **unused) {
    format *const both[] = {&bf16, &fp16};
    for (int k = 0; k < 2; k++) {
        format *f = both[k];
        const int one = 1 << f->fraction_bits;
        for (int bits = 0; bits <= f->count; bits++) {
            const int exponent = bits / one, fraction = bits % one;
            f->value[bits] = ldexpl(exponent == 0 ? fraction : one + fraction,
                                    (exponent == 0 ? 1 : exponent) - f->bias - f->fraction_bits);
        }
    }
    return 0;
}

/* The nearest number by bisection, ties to even; the first number beyond the range counts as infinity. */
static int nearest(const format *f, long double size) {
    int low = 0, high = f->count;
    if (size >= f->value[high])
        return high;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        *(size < f->value[middle] ? &high : &low) = middle;
    }
    const long double below = size - f->value[low], above = f->value[high] - size;
    return below < above || (below == above && low % 2 == 0) ? low : high;
}

TEST(test_every_number) {
    for (int sign = 0; sign < 2; sign++) {
        for (int i = 0; i < bf16.count; i++) {
            const uint16_t bits = (uint16_t)(sign << 15 | i);
            assert_true(shim_from_bf16(bits) == (sign ? -bf16.value[i] : bf16.value[i]));
            assert_int_equal(shim_to_bf16(shim_from_bf16(bits)), bits);
        }
        for (int i = 0; i < fp16.count; i++) {
            const uint16_t bits = (uint16_t)(sign << 15 | i);
            assert_true(shim_from_fp16(bits) == (double)(sign ? -fp16.value[i] : fp16.value[i]));
            assert_int_equal(shim_to_fp16(shim_from_fp16(bits)), bits);
        }
    }
    assert_true(shim_from_fp16(0x7c00) == HUGE_VAL && shim_from_fp16(0xfc00) == -HUGE_VAL);
    assert_true(isnan(shim_from_fp16(0x7c01)) && isnan(shim_from_fp16(0xffff)));
    assert_true(isinf(shim_from_bf16(0x7f80)) && isnan(shim_from_bf16(0x7fc0)));
}

static void check(double value) {
    const uint16_t sign = signbit(value) ? 0x8000 : 0;
    assert_int_equal(shim_to_fp16(value), sign | nearest(&fp16, fabsl(value)));
    const float single = (float)value;
    if (isfinite(single))
        assert_int_equal(shim_to_bf16(single), sign | nearest(&bf16, fabsl(single)));
}

/* Midpoints between neighbours and the doubles next to them, for every pair and both signs. */
TEST(test_ties) {
    const format *const both[] = {&bf16, &fp16};
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < both[k]->count; i++) {
            const double middle = (double)((both[k]->value[i] + both[k]->value[i + 1]) / 2);
            for (int sign = -1; sign < 2; sign += 2) {
                check(sign * middle);
                check(sign * nextafter(middle, 0));
                check(sign * nextafter(middle, INFINITY));
                check(sign * (double)nextafterf((float)middle, 0));
                check(sign * (double)nextafterf((float)middle, INFINITY));
            }
        }
    check(65519.999);
    check(65520);
    check(1e300);
    check(FLT_MAX);
    check(DBL_MIN);
}

TEST(test_subnormal_float32_is_zero) {
    const double least = FLT_MIN;
    assert_true(shim_to_float32(least) == FLT_MIN && shim_to_float32(-least) == -FLT_MIN);
    assert_true(shim_to_float32(least * (1 - 0x1p-30)) == FLT_MIN); /* rounds up to it */
    const double small[] = {least * (1 - 0x1p-23), least / 2, 1e-45, 5e-324, 0};
    for (size_t i = 0; i < sizeof small / sizeof *small; i++)
        assert_true(shim_to_float32(small[i]) == 0 && shim_to_float32(-small[i]) == 0);
    assert_true(shim_to_float32(0.1) == 0.1f && shim_to_float32(-1e30) == -1e30f);
}

RUN_TESTS(fill_tables, NULL)
