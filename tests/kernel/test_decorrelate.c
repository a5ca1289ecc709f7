/* Tests the decorrelation, which forms no Gram matrix, against Gram-Schmidt in long double on the augmented vectors,
 * and for equal bits on every instruction set. */
#include <string.h>

#include "assert_close.h"

int shim_isas(void);
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

static void test_against_gram_schmidt(void **unused) {
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

static void test_zeros_stay(void **unused) {
    enum { kSamples = 9, kVectors = 8 };
    for (int i = 0; i < kSamples * kVectors; i++)
        samples[i] = 0;
    shim_decorrelate(0, samples, kSamples, kVectors, work);
    for (int i = 0; i < kSamples * kVectors; i++)
        assert_true(samples[i] == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_gram_schmidt), cmocka_unit_test(test_zeros_stay)};
    return cmocka_run_group_tests_name("decorrelate", tests, NULL, NULL);
}
