/* Tests 'same' convolution, maximum pooling with switches and un-pooling against their definitions in long double. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

int shim_isas(void);
void shim_same(int isa, const size_t *d, const float *image, const float *kernel, int adjoint, const float *bias,
               float *out);
void shim_same_max(int isa, const size_t *d, const float *image, const float *kernel, const float *bias, float *pooled,
                   int32_t *switches);
void shim_same_gradient(int isa, const size_t *d, const float *in, const float *out, float *kernel);
void shim_unpool(int isa, const size_t *d, const float *pooled, const int32_t *switches, float *out);
void shim_pick(int isa, const size_t *d, const float *image, const int32_t *switches, float *pooled);

/* Rows, columns, input and output channels: the channels of every stage of the network, in both directions. */
enum { ROWS, COLS, IN, OUT, kPooled = 8, kShapes = kPooled + 4 };
static const size_t kShape[kShapes][4] = {
    {6, 16, 1, 8},   {4, 16, 8, 16},  {4, 16, 16, 32}, {2, 16, 32, 64},
    {2, 16, 1, 16},  {4, 16, 1, 32},  {2, 32, 16, 8},  {2, 16, 8, 32}, /* other channel counts */
    {4, 16, 64, 32}, {4, 16, 32, 16}, {4, 16, 16, 8},  {6, 16, 8, 1},
};

static uint32_t state;

static float *random_floats(size_t count) {
    float *values = malloc(count * sizeof *values);
    for (size_t i = 0; i < count; i++) {
        state = state * 1664525u + 1013904223u;
        values[i] = (float)(state >> 8) / 8388608.0f - 1.0f;
    }
    return values;
}

static long double at(const float *image, const size_t *s, size_t channels, long y, long x, size_t c) {
    if (y < 0 || x < 0 || y >= (long)s[ROWS] || x >= (long)s[COLS])
        return 0;
    return image[((size_t)y * s[COLS] + (size_t)x) * channels + c];
}

static long double slow_same(const size_t *s, const float *image, const float *kernel, int adjoint, long y, long x,
                             size_t k) {
    long double sum = 0;
    for (size_t c = 0; c < s[IN]; c++)
        for (int tap = 0; tap < 9; tap++) {
            const long dy = tap / 3 - 1, dx = tap % 3 - 1;
            if (adjoint)
                sum += kernel[(c * s[OUT] + k) * 9 + (size_t)tap] * at(image, s, s[IN], y - dy, x - dx, c);
            else
                sum += kernel[(k * s[IN] + c) * 9 + (size_t)tap] * at(image, s, s[IN], y + dy, x + dx, c);
        }
    return sum;
}

static void test_same(void **unused) {
    for (size_t shape = 0; shape < kShapes; shape++)
        for (int adjoint = 0; adjoint < 2; adjoint++) {
            const size_t *s = kShape[shape];
            float *image = random_floats(s[ROWS] * s[COLS] * s[IN]), *kernel = random_floats(9 * s[IN] * s[OUT]);
            float *bias = random_floats(s[OUT]), *out = malloc(s[ROWS] * s[COLS] * s[OUT] * sizeof *out);
            for (int isa = 0; isa < shim_isas(); isa++) {
                shim_same(isa, s, image, kernel, adjoint, bias, out);
                for (size_t i = 0; i < s[ROWS] * s[COLS] * s[OUT]; i++) {
                    const size_t k = i % s[OUT], x = i / s[OUT] % s[COLS], y = i / s[OUT] / s[COLS];
                    const long double expected = slow_same(s, image, kernel, adjoint, (long)y, (long)x, k) + bias[k];
                    assert_close(out[i], (double)expected, 0, 1e-6 * (double)(9 * s[IN]));
                }
            }
            free(image), free(kernel), free(bias), free(out);
        }
}

/* Against the convolution above. Of equal values, which a zero kernel produces everywhere, the first one is
 * selected. */
static void test_maximum(void **unused) {
    for (size_t shape = 0; shape < kPooled; shape++)
        for (int tie = 0; tie < 2; tie++) {
            const size_t *s = kShape[shape], pooled_size = s[ROWS] * s[COLS] * s[OUT] / 4;
            float *image = random_floats(s[ROWS] * s[COLS] * s[IN]), *kernel = random_floats(9 * s[IN] * s[OUT]);
            if (tie)
                memset(kernel, 0, 9 * s[IN] * s[OUT] * sizeof *kernel);
            float *bias = random_floats(s[OUT]), *all = malloc(4 * pooled_size * sizeof *all);
            float *zero = calloc(s[OUT], sizeof *zero), *pooled = malloc(pooled_size * sizeof *pooled);
            int32_t *switches = malloc(pooled_size * sizeof *switches);
            for (int isa = 0; isa < shim_isas(); isa++) {
                shim_same(isa, s, image, kernel, 0, zero, all);
                shim_same_max(isa, s, image, kernel, bias, pooled, switches);
                for (size_t i = 0; i < pooled_size; i++) {
                    const size_t k = i % s[OUT], x = i / s[OUT] % (s[COLS] / 2), y = i / s[OUT] / (s[COLS] / 2);
                    float best = -INFINITY;
                    int from = -1;
                    for (int q = 0; q < 4; q++) {
                        const float v = all[((2 * y + (size_t)q / 2) * s[COLS] + 2 * x + (size_t)q % 2) * s[OUT] + k];
                        if (v > best)
                            best = v, from = q;
                    }
                    assert_int_equal(switches[i], from);
                    assert_close(pooled[i], best + bias[k], 1e-6, 1e-5);
                }
            }
            free(image), free(kernel), free(bias), free(all), free(zero), free(pooled), free(switches);
        }
}

static void test_weight_gradient(void **unused) {
    for (size_t shape = 0; shape < kShapes - 1; shape++) {
        const size_t *s = kShape[shape];
        float *in = random_floats(s[ROWS] * s[COLS] * s[IN]), *out = random_floats(s[ROWS] * s[COLS] * s[OUT]);
        float *gradient = malloc(9 * s[IN] * s[OUT] * sizeof *gradient);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_same_gradient(isa, s, in, out, gradient);
            for (size_t i = 0; i < 9 * s[IN] * s[OUT]; i++) {
                const size_t tap = i % 9, c = i / 9 % s[IN], k = i / 9 / s[IN];
                long double sum = 0;
                for (long y = 0; y < (long)s[ROWS]; y++)
                    for (long x = 0; x < (long)s[COLS]; x++)
                        sum += at(out, s, s[OUT], y, x, k) *
                               at(in, s, s[IN], y + (long)tap / 3 - 1, x + (long)tap % 3 - 1, c);
                assert_close(gradient[i], (double)sum, 0, 1e-6 * (double)(s[ROWS] * s[COLS]));
            }
        }
        free(in), free(out), free(gradient);
    }
}

/* Values return to the pixels they were taken from; all other pixels are 0. */
static void test_unpool(void **unused) {
    for (size_t shape = 0; shape < kPooled; shape++) {
        const size_t *s = kShape[shape], pooled_size = s[ROWS] * s[COLS] * s[OUT] / 4;
        float *pooled = random_floats(pooled_size), *all = malloc(4 * pooled_size * sizeof *all);
        float *back = malloc(pooled_size * sizeof *back);
        int32_t *switches = malloc(pooled_size * sizeof *switches);
        for (size_t i = 0; i < pooled_size; i++)
            switches[i] = (int32_t)(i * 2654435761u >> 13 & 3);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_unpool(isa, s, pooled, switches, all);
            for (size_t i = 0; i < 4 * pooled_size; i++) {
                const size_t k = i % s[OUT], x = i / s[OUT] % s[COLS], y = i / s[OUT] / s[COLS];
                const size_t coarse = ((y / 2) * (s[COLS] / 2) + x / 2) * s[OUT] + k;
                const int here = switches[coarse] == (int)(2 * (y % 2) + x % 2);
                assert_true(all[i] == (here ? pooled[coarse] : 0.0f));
            }
            shim_pick(isa, s, all, switches, back);
            assert_memory_equal(back, pooled, pooled_size * sizeof *back);
        }
        free(pooled), free(all), free(back), free(switches);
    }
}

/* The order of every sum is independent of the vector width. */
static void test_same_bits_with_fused_multiply_add(void **unused) {
    if (shim_isas() < 3)
        skip();
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape], size = s[ROWS] * s[COLS] * s[OUT];
        float *image = random_floats(s[ROWS] * s[COLS] * s[IN]), *kernel = random_floats(9 * s[IN] * s[OUT]);
        float *bias = random_floats(s[OUT]), *a = malloc(size * sizeof *a), *b = malloc(size * sizeof *b);
        shim_same(1, s, image, kernel, 0, bias, a);
        shim_same(2, s, image, kernel, 0, bias, b);
        assert_memory_equal(a, b, size * sizeof *a);
        free(image), free(kernel), free(bias), free(a), free(b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_maximum),
        cmocka_unit_test(test_weight_gradient),
        cmocka_unit_test(test_unpool),
        cmocka_unit_test(test_same_bits_with_fused_multiply_add),
    };
    return cmocka_run_group_tests_name("same_conv", tests, NULL, NULL);
}
