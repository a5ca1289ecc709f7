/* Tests the kernels of the networks against their definitions in wider arithmetic: Adam against algorithm 1 of Kingma
 * and Ba, ELU against expm1l, the decorrelation, which forms no Gram matrix, against Gram-Schmidt on the augmented
 * vectors, and the structural similarity with a two-dimensional window. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

/* ---- adam */

void shim_adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
               float *weights);

TEST(test_follows_the_paper) {
    enum { kNumbers = 37, kSteps = 50 };
    float gradient[kNumbers], mean[kNumbers] = {0}, square[kNumbers] = {0}, weights[kNumbers] = {0};
    long double m[kNumbers] = {0}, v[kNumbers] = {0}, w[kNumbers] = {0};
    for (size_t step = 1; step <= kSteps; step++) {
        const double rate = 4e-3 / (double)step;
        for (int i = 0; i < kNumbers; i++) {
            gradient[i] = (float)(sin(1.7 * i + 0.3 * (double)step) * pow(10, i % 9 - 6));
            m[i] = 0.9L * m[i] + 0.1L * gradient[i];
            v[i] = 0.999L * v[i] + 0.001L * gradient[i] * gradient[i];
            w[i] -= rate * (m[i] / (1 - powl(0.9L, step))) / (sqrtl(v[i] / (1 - powl(0.999L, step))) + 1e-8L);
        }
        shim_adam(step, rate, gradient, kNumbers, mean, square, weights);
    }
    for (int i = 0; i < kNumbers; i++)
        assert_close(weights[i], (double)w[i], 1e-5, 1e-7);
}

/* ---- elu */

int shim_isas(void);
void shim_elu(int isa, float *values, size_t count);

enum { kCount = 300001 };

/* Magnitudes from 1e-30 to 1e5, both signs, and special values. */
static float *arguments(void) {
    float *values = malloc(kCount * sizeof *values);
    for (int i = 0; i < kCount; i++)
        values[i] = (float)((i % 2 ? 1 : -1) * pow(10, -30 + 35.0 * i / kCount));
    values[0] = 0.0f;
    values[1] = INFINITY;
    values[2] = -INFINITY;
    values[3] = NAN;
    return values;
}

TEST(test_relative_error) {
    for (int isa = 0; isa < shim_isas(); isa++) {
        float *in = arguments(), *out = arguments();
        shim_elu(isa, out, kCount);
        assert_true(isinf(out[1]) && isnan(out[3]));
        for (int i = 0; i < kCount; i++)
            if (i != 1 && i != 3)
                assert_close(out[i], in[i] > 0 ? in[i] : (double)expm1l(in[i]), 2e-7, 0);
        free(in), free(out);
    }
}

/* The bits of a value must depend neither on its neighbours, which determine how a block is computed, nor on the vector
 * width, although multiplications and additions are fused. */
TEST(test_same_bits) {
    float *fused = NULL;
    for (int isa = 0; isa < shim_isas(); isa++) {
        float *together = arguments();
        shim_elu(isa, together, kCount);
        const float *in = arguments();
        for (int i = 0; i < kCount; i += 7) {
            float alone = in[i];
            shim_elu(isa, &alone, 1);
            assert_memory_equal(&alone, &together[i], sizeof alone);
        }
        if (fused != NULL)
            assert_memory_equal(fused, together, kCount * sizeof *fused);
        if (isa == 1)
            fused = together;
        else
            free(together);
        free((void *)in);
    }
    free(fused);
}

/* ---- decorrelate */

void shim_decorrelate(int isa, float *samples, size_t n, size_t count, float *work);

enum { kMostSamples = 288, kMostVectors = 64, kMostRows = kMostSamples + kMostVectors };
static float samples[kMostSamples * kMostVectors], work[kMostVectors * kMostVectors];
static long double vectors[kMostVectors][kMostRows];

/* Nearly dependent vectors of very different norms. */
static float sample(int k, int i) {
    return (float)(pow(10, -i % 5) * (sin(0.7 * k) + 0.3 * cos(1.3 * k * (i % 7 + 1)) + 0.01 * sin(k * k + 5 * i)));
}

static long double product(const long double *a, const long double *b, int n) {
    long double sum = 0;
    for (int k = 0; k < n; k++)
        sum += a[k] * b[k];
    return sum;
}

/* Augments vector k (length n) by sqrt(0.1 mean square norm) in row n + k, and orthonormalises the vectors one after
 * the other: for [A; c I] = Q U, the upper part of Q is A U^-1, and U^T U = A^T A + c^2 I. */
static void orthonormalise(int n, int count) {
    long double squares = 0;
    for (int i = 0; i < count; i++)
        squares += product(vectors[i], vectors[i], n);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < count; k++)
            vectors[i][n + k] = k == i ? sqrtl(0.1L * squares / count) : 0;
        for (int pass = 0; pass < 2; pass++)
            for (int j = 0; j < i; j++) {
                const long double along = product(vectors[i], vectors[j], n + count);
                for (int k = 0; k < n + count; k++)
                    vectors[i][k] -= along * vectors[j][k];
            }
        const long double length = sqrtl(product(vectors[i], vectors[i], n + count));
        for (int k = 0; k < n + count; k++)
            vectors[i][k] /= length;
    }
}

TEST(test_against_gram_schmidt) {
    const int shapes[][2] = {{1, 1}, {9, 8}, {72, 16}, {5, 16}, {21, 13}, {288, 64}, {256, 64}};
    static float first[kMostSamples * kMostVectors];
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        for (int isa = 0; isa < shim_isas(); isa++) {
            const int n = shapes[s][0], count = shapes[s][1];
            for (int k = 0; k < n; k++)
                for (int i = 0; i < count; i++)
                    vectors[i][k] = samples[k * count + i] = sample(k + 1, i);
            shim_decorrelate(isa, samples, (size_t)n, (size_t)count, work);
            if (isa > 0) {
                assert_memory_equal(samples, first, (size_t)(n * count) * sizeof *samples);
                continue;
            }
            memcpy(first, samples, sizeof first);
            orthonormalise(n, count);
            for (int k = 0; k < n; k++)
                for (int i = 0; i < count; i++)
                    assert_close(samples[k * count + i], (double)vectors[i][k], 0, 2e-5);
        }
}

TEST(test_zeros_stay) {
    enum { kSamples = 9, kVectors = 8 };
    for (int i = 0; i < kSamples * kVectors; i++)
        samples[i] = 0;
    shim_decorrelate(0, samples, kSamples, kVectors, work);
    for (int i = 0; i < kSamples * kVectors; i++)
        assert_true(samples[i] == 0);
}

/* ---- ssim */

double shim_ssim(const double *a, const double *b, size_t rows, size_t cols);

enum { kRows = 23, kCols = 31, kWindow = 11 };

static long double at_window(const double *a, const double *b, int row, int col) {
    long double weights[kWindow][kWindow], sum = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++)
            sum += weights[i][j] = expl(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5L * 1.5L));
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++) {
            weights[i][j] /= sum;
            x += weights[i][j] * a[(row + i) * kCols + col + j];
            y += weights[i][j] * b[(row + i) * kCols + col + j];
        }
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++) {
            const long double u = a[(row + i) * kCols + col + j] - x, v = b[(row + i) * kCols + col + j] - y;
            xx += weights[i][j] * u * u;
            yy += weights[i][j] * v * v;
            xy += weights[i][j] * u * v;
        }
    return (2 * x * y + 1e-4L) * (2 * xy + 9e-4L) / ((x * x + y * y + 1e-4L) * (xx + yy + 9e-4L));
}

static void fill(double *a, double *b, double difference) {
    for (int i = 0; i < kRows * kCols; i++) {
        a[i] = 0.5 + 0.5 * sin(0.7 * i) * cos(0.01 * i * i);
        b[i] = a[i] + difference * cos(3.1 * i);
    }
}

TEST(test_follows_the_definition) {
    static double a[kRows * kCols], b[kRows * kCols];
    const double differences[] = {0.5, 1e-2, 1e-5};
    for (int k = 0; k < 3; k++) {
        long double sum = 0;
        fill(a, b, differences[k]);
        for (int row = 0; row + kWindow <= kRows; row++)
            for (int col = 0; col + kWindow <= kCols; col++)
                sum += at_window(a, b, row, col);
        assert_close(shim_ssim(a, b, kRows, kCols), (double)(sum / ((kRows - kWindow + 1) * (kCols - kWindow + 1))), 0,
                     1e-13);
    }
}

TEST(test_equal_images_give_one) {
    static double a[kRows * kCols], b[kRows * kCols];
    fill(a, b, 0);
    assert_close(shim_ssim(a, b, kRows, kCols), 1, 0, 1e-15);
}

RUN_TESTS(NULL, NULL)
