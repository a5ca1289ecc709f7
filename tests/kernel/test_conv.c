/* Tests the convolution kernels against their definitions in long double: 3x3 'same' convolution and 2x2 mean;
 * nearest-neighbour up-sampling and 3x3 transposed convolution. Weight gradients are tested against differences of the
 * convolution. Also 'same' convolution without mean, maximum pooling with switches and un-pooling. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_conv_down(int isa, const size_t *dimensions, const float *image, const float *kernel, float factor,
                    const float *bias, float *out);
void shim_conv_down_elu(int isa, const size_t *dimensions, const float *image, const float *kernel, const float *bias,
                        float *out, float *expected);
void shim_conv_up(int isa, const size_t *dimensions, const float *image, const float *kernel, float factor,
                  const float *bias, float *out);
void shim_conv_gradient(int isa, const size_t *dimensions, const float *fine, const float *coarse, float factor,
                        float *kernel);
void shim_same(int isa, const size_t *d, const float *image, const float *kernel, int adjoint, const float *bias,
               float *out);
void shim_same_max(int isa, const size_t *d, const float *image, const float *kernel, const float *bias, float *pooled,
                   int32_t *switches);
void shim_same_gradient(int isa, const size_t *d, const float *in, const float *out, float *kernel);
void shim_unpool(int isa, const size_t *d, const float *pooled, const int32_t *switches, float *out);
void shim_pick(int isa, const size_t *d, const float *image, const int32_t *switches, float *pooled);

/* Rows and columns of the coarse image, fine and coarse channels: the channels of every stage of the network, on images
 * small enough for the slow sums. */
enum { ROWS, COLS, FINE, COARSE, kShapes = 14 };
static const size_t kShape[kShapes][4] = {
    {6, 16, 1, 8},  {4, 16, 8, 16}, {3, 8, 16, 32}, {2, 16, 32, 64}, /* the network's stages */
    {1, 128, 1, 8}, {1, 64, 8, 16},                                  /* whole rows of the network */
    {3, 64, 1, 8},  {2, 8, 32, 64},                                  /* those of layout `core` */
    {2, 5, 1, 8},   {3, 11, 1, 16}, {2, 13, 1, 32}, {2, 16, 1, 16},  {3, 10, 8, 16}, {2, 13, 16, 32},
};

static size_t fine_size(const size_t *s) {
    return 4 * s[ROWS] * s[COLS] * s[FINE];
}
static size_t coarse_size(const size_t *s) {
    return s[ROWS] * s[COLS] * s[COARSE];
}
static size_t weights(const size_t *s) {
    return 9 * s[FINE] * s[COARSE];
}

static uint64_t state;

static float *random_floats(size_t count) {
    float *values = malloc(count * sizeof *values);
    for (size_t i = 0; i < count; i++)
        values[i] = (float)uniform_signed(&state);
    return values;
}

static long double at(const float *image, size_t rows, size_t cols, size_t channels, long y, long x, size_t c) {
    if (y < 0 || x < 0 || y >= (long)rows || x >= (long)cols)
        return 0;
    return image[((size_t)y * cols + (size_t)x) * channels + c];
}

/* Convolution and mean of channel k at one coarse pixel. */
static long double slow_down(const size_t *s, const float *image, const float *kernel, long y, long x, size_t k) {
    long double sum = 0;
    for (int corner = 0; corner < 4; corner++)
        for (size_t c = 0; c < s[FINE]; c++)
            for (int tap = 0; tap < 9; tap++)
                sum += (long double)kernel[(k * s[FINE] + c) * 9 + (size_t)tap] *
                       at(image, 2 * s[ROWS], 2 * s[COLS], s[FINE], 2 * y + corner / 2 + tap / 3 - 1,
                          2 * x + corner % 2 + tap % 3 - 1, c);
    return sum / 4;
}

/* Up-sampling and transposed convolution: tap (ky, kx) adds up-sampled pixel (y, x) to (y + ky - 1, x + kx - 1). */
static long double slow_up(const size_t *s, const float *image, const float *kernel, long y, long x, size_t c) {
    long double sum = 0;
    for (size_t k = 0; k < s[COARSE]; k++)
        for (int tap = 0; tap < 9; tap++) {
            const long from_y = y - (tap / 3 - 1), from_x = x - (tap % 3 - 1);
            if (from_y >= 0 && from_x >= 0)
                sum += (long double)kernel[(k * s[FINE] + c) * 9 + (size_t)tap] *
                       at(image, s[ROWS], s[COLS], s[COARSE], from_y / 2, from_x / 2, k);
        }
    return sum;
}

TEST(test_down) {
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape];
        float *image = random_floats(fine_size(s)), *kernel = random_floats(weights(s));
        float *bias = random_floats(s[COARSE]), *out = malloc(coarse_size(s) * sizeof *out);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_conv_down(isa, s, image, kernel, 0.25f, bias, out);
            for (size_t i = 0; i < coarse_size(s); i++) {
                const size_t k = i % s[COARSE], pixel = i / s[COARSE];
                const long y = (long)(pixel / s[COLS]), x = (long)(pixel % s[COLS]);
                assert_close(out[i], (double)(slow_down(s, image, kernel, y, x, k) + bias[k]), 0, 1e-5);
            }
        }
        free(image), free(kernel), free(bias), free(out);
    }
}

TEST(test_down_elu_is_elu_of_down) {
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape], size = coarse_size(s);
        float *image = random_floats(fine_size(s)), *kernel = random_floats(weights(s));
        float *bias = random_floats(s[COARSE]), *out = malloc(size * sizeof *out),
              *expected = malloc(size * sizeof *out);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_conv_down_elu(isa, s, image, kernel, bias, out, expected);
            assert_memory_equal(out, expected, size * sizeof *out);
        }
        free(image), free(kernel), free(bias), free(out), free(expected);
    }
}

TEST(test_up) {
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape];
        float *image = random_floats(coarse_size(s)), *kernel = random_floats(weights(s));
        float *bias = random_floats(s[FINE]), *out = malloc(fine_size(s) * sizeof *out);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_conv_up(isa, s, image, kernel, 1, bias, out);
            for (size_t i = 0; i < fine_size(s); i++) {
                const size_t c = i % s[FINE], pixel = i / s[FINE];
                const long y = (long)(pixel / (2 * s[COLS])), x = (long)(pixel % (2 * s[COLS]));
                assert_close(out[i], (double)(slow_up(s, image, kernel, y, x, c) + bias[c]), 0, 3e-5);
            }
        }
        free(image), free(kernel), free(bias), free(out);
    }
}

/* d/dkernel of sum(coarse * down(fine)). The sum is linear in the kernel, so a central difference of any step is
 * exact. */
static long double slow_gradient(const size_t *s, const float *fine, const float *coarse, float *kernel, size_t j) {
    const size_t k = j / 9 / s[FINE];
    const float kept = kernel[j];
    long double change = 0;
    for (int sign = -1; sign <= 1; sign += 2) {
        kernel[j] = kept + (float)sign;
        for (size_t pixel = 0; pixel < s[ROWS] * s[COLS]; pixel++)
            change += sign * (long double)coarse[pixel * s[COARSE] + k] *
                      slow_down(s, fine, kernel, (long)(pixel / s[COLS]), (long)(pixel % s[COLS]), k);
    }
    kernel[j] = kept;
    return change / 2;
}

TEST(test_weight_gradient) {
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape];
        float *fine = random_floats(fine_size(s)), *coarse = random_floats(coarse_size(s));
        float *kernel = calloc(weights(s), sizeof *kernel), *gradient = malloc(weights(s) * sizeof *gradient);
        const size_t step = weights(s) > 2000 ? 31 : 1;
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_conv_gradient(isa, s, fine, coarse, 0.25f, gradient);
            for (size_t j = 0; j < weights(s); j += step)
                assert_close(gradient[j], (double)slow_gradient(s, fine, coarse, kernel, j), 0, 1e-5);
        }
        free(fine), free(coarse), free(kernel), free(gradient);
    }
}

/* Every sum is evaluated in the order of the definition, not of the vectors: AVX2 and AVX-512 agree to the bit. */
TEST(test_same_bits_with_fused_multiply_add) {
    if (shim_isas() < 3)
        skip();
    for (size_t shape = 0; shape < kShapes; shape++) {
        const size_t *s = kShape[shape];
        const size_t all = coarse_size(s) + fine_size(s) + weights(s);
        float *fine = random_floats(fine_size(s)), *coarse = random_floats(coarse_size(s));
        float *kernel = random_floats(weights(s)), *bias = random_floats(64), *out[3];
        for (int isa = 1; isa <= 2; isa++) {
            out[isa] = calloc(all, sizeof *out[isa]);
            shim_conv_down(isa, s, fine, kernel, 0.25f, bias, out[isa]);
            shim_conv_up(isa, s, coarse, kernel, 1, bias, out[isa] + coarse_size(s));
            shim_conv_gradient(isa, s, fine, coarse, 0.25f, out[isa] + coarse_size(s) + fine_size(s));
        }
        assert_memory_equal(out[1], out[2], all * sizeof(float));
        free(fine), free(coarse), free(kernel), free(bias), free(out[1]), free(out[2]);
    }
}

/* Rows, columns, input and output channels: the channels of every stage of the network, in both directions. */
enum { IN = FINE, OUT = COARSE, kPooled = 8, kSameShapes = kPooled + 4 };
static const size_t kSameShape[kSameShapes][4] = {
    {6, 16, 1, 8},   {4, 16, 8, 16},  {4, 16, 16, 32}, {2, 16, 32, 64},
    {2, 16, 1, 16},  {4, 16, 1, 32},  {2, 32, 16, 8},  {2, 16, 8, 32}, /* other channel counts */
    {4, 16, 64, 32}, {4, 16, 32, 16}, {4, 16, 16, 8},  {6, 16, 8, 1},
};

static long double slow_same(const size_t *s, const float *image, const float *kernel, int adjoint, long y, long x,
                             size_t k) {
    long double sum = 0;
    for (size_t c = 0; c < s[IN]; c++)
        for (int tap = 0; tap < 9; tap++) {
            const long dy = tap / 3 - 1, dx = tap % 3 - 1;
            if (adjoint)
                sum +=
                    kernel[(c * s[OUT] + k) * 9 + (size_t)tap] * at(image, s[ROWS], s[COLS], s[IN], y - dy, x - dx, c);
            else
                sum +=
                    kernel[(k * s[IN] + c) * 9 + (size_t)tap] * at(image, s[ROWS], s[COLS], s[IN], y + dy, x + dx, c);
        }
    return sum;
}

TEST(test_same) {
    for (size_t shape = 0; shape < kSameShapes; shape++)
        for (int adjoint = 0; adjoint < 2; adjoint++) {
            const size_t *s = kSameShape[shape];
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
TEST(test_maximum) {
    for (size_t shape = 0; shape < kPooled; shape++)
        for (int tie = 0; tie < 2; tie++) {
            const size_t *s = kSameShape[shape], pooled_size = s[ROWS] * s[COLS] * s[OUT] / 4;
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

TEST(test_same_gradient) {
    for (size_t shape = 0; shape < kSameShapes - 1; shape++) {
        const size_t *s = kSameShape[shape];
        float *in = random_floats(s[ROWS] * s[COLS] * s[IN]), *out = random_floats(s[ROWS] * s[COLS] * s[OUT]);
        float *gradient = malloc(9 * s[IN] * s[OUT] * sizeof *gradient);
        for (int isa = 0; isa < shim_isas(); isa++) {
            shim_same_gradient(isa, s, in, out, gradient);
            for (size_t i = 0; i < 9 * s[IN] * s[OUT]; i++) {
                const size_t tap = i % 9, c = i / 9 % s[IN], k = i / 9 / s[IN];
                long double sum = 0;
                for (long y = 0; y < (long)s[ROWS]; y++)
                    for (long x = 0; x < (long)s[COLS]; x++)
                        sum += at(out, s[ROWS], s[COLS], s[OUT], y, x, k) *
                               at(in, s[ROWS], s[COLS], s[IN], y + (long)tap / 3 - 1, x + (long)tap % 3 - 1, c);
                assert_close(gradient[i], (double)sum, 0, 1e-6 * (double)(s[ROWS] * s[COLS]));
            }
        }
        free(in), free(out), free(gradient);
    }
}

/* Values return to the pixels they were taken from; all other pixels are 0. */
TEST(test_unpool) {
    for (size_t shape = 0; shape < kPooled; shape++) {
        const size_t *s = kSameShape[shape], pooled_size = s[ROWS] * s[COLS] * s[OUT] / 4;
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
TEST(test_same_bits_of_same) {
    if (shim_isas() < 3)
        skip();
    for (size_t shape = 0; shape < kSameShapes; shape++) {
        const size_t *s = kSameShape[shape], size = s[ROWS] * s[COLS] * s[OUT];
        float *image = random_floats(s[ROWS] * s[COLS] * s[IN]), *kernel = random_floats(9 * s[IN] * s[OUT]);
        float *bias = random_floats(s[OUT]), *a = malloc(size * sizeof *a), *b = malloc(size * sizeof *b);
        shim_same(1, s, image, kernel, 0, bias, a);
        shim_same(2, s, image, kernel, 0, bias, b);
        assert_memory_equal(a, b, size * sizeof *a);
        free(image), free(kernel), free(bias), free(a), free(b);
    }
}

RUN_TESTS(NULL, NULL)
