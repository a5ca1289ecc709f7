/* Tests the residual kernels against long double. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
int shim_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma, size_t count,
                  double *out);
int shim_scaled_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                         double scale, size_t count, float *out);
void shim_residual_project(int isa, const double *units, size_t planes, size_t count, double *vector);
int shim_project_rows(int isa, const size_t *rows_cols_planes, size_t frames, const double *counts,
                      const double *reference, const double *inverse_sigma, const float *basis, double scale,
                      float *vectors, float *out);
double shim_magnitude(int isa, const double *residual, size_t count, double most);
float shim_magnitude_float(int isa, const float *residual, size_t count, float most);
double shim_residual_inner(int isa, const double *a, const double *b, size_t count);
double shim_residual_inner_float(int isa, const float *a, const float *b, size_t count);

enum { N = 65536, kPlanes = 11, kMany = 32 }; /* groups of four planes; the most */
static double counts[N], reference[N], inverse_sigma[N], units[kPlanes * N];

static uint64_t state = 1;

static int set_up(void **unused) {
    for (int i = 0; i < N; i++) {
        reference[i] = 1e9 * (1 + 0.5 * uniform_signed(&state));
        counts[i] = reference[i] + 3e4 * uniform_signed(&state);
        inverse_sigma[i] = 1 / sqrt(reference[i]);
    }
    for (int k = 0; k < kPlanes; k++) { /* disjoint pixels, so orthogonal */
        long double square = 0;
        for (int i = k; i < N; i += kPlanes)
            units[k * N + i] = uniform_signed(&state), square += units[k * N + i] * units[k * N + i];
        for (int i = k; i < N; i += kPlanes)
            units[k * N + i] /= (double)sqrtl(square);
    }
    return 0;
}

TEST(test_residual) {
    static double out[N];
    static float scaled[N];
    for (int isa = 0; isa < shim_isas(); isa++) {
        assert_int_equal(shim_residual(isa, counts, reference, inverse_sigma, N, out), 1);
        assert_int_equal(shim_scaled_residual(isa, counts, reference, inverse_sigma, 1e-3, N, scaled), 1);
        for (int i = 0; i < N; i++) {
            assert_close(out[i], (double)(((long double)counts[i] - reference[i]) * inverse_sigma[i]), 1e-15, 0);
            assert_true(scaled[i] == (float)(1e-3 * out[i]));
        }
    }
}

/* Also at the end of a count that is not a multiple of a vector, and of either sign. */
TEST(test_magnitude) {
    enum { COUNT = 37 };
    for (int isa = 0; isa < shim_isas(); isa++)
        for (int at = 0; at < COUNT; at++)
            for (int sign = -1; sign <= 1; sign += 2) {
                double residual[COUNT];
                float residual32[COUNT];
                for (int i = 0; i < COUNT; i++)
                    residual32[i] = (float)(residual[i] = i == at ? sign * 2.5 : uniform_signed(&state));
                assert_true(shim_magnitude(isa, residual, COUNT, 0) == 2.5);
                assert_true(shim_magnitude(isa, residual, COUNT, 3) == 3);
                assert_true(shim_magnitude_float(isa, residual32, COUNT, 1) == 2.5f);
                assert_true(shim_magnitude_float(isa, residual32, COUNT, 3) == 3);
            }
}

TEST(test_non_finite_counts_are_seen) {
    static double out[N];
    static float scaled[N];
    const double bad[] = {NAN, -NAN, INFINITY, -INFINITY};
    for (int isa = 0; isa < shim_isas(); isa++)
        for (int k = 0; k < 4; k++) {
            const int at = k * 17 + (k == 3 ? N - 52 : 0);
            const double good = counts[at];
            counts[at] = bad[k];
            assert_int_equal(shim_residual(isa, counts, reference, inverse_sigma, N, out), 0);
            assert_int_equal(shim_scaled_residual(isa, counts, reference, inverse_sigma, 1, N, scaled), 0);
            counts[at] = good;
        }
}

TEST(test_inner_product) {
    long double expected = 0, absolute = 0;
    for (int i = 0; i < N; i++) {
        expected += (long double)units[i] * inverse_sigma[i];
        absolute += fabsl((long double)units[i] * inverse_sigma[i]);
    }
    const double first = shim_residual_inner(0, units, inverse_sigma, N);
    assert_close(first, (double)expected, 0, (double)absolute * N / 16 * 1.2e-16);
    for (int isa = 1; isa < shim_isas(); isa++) {
        const double other = shim_residual_inner(isa, units, inverse_sigma, N);
        assert_memory_equal(&other, &first, sizeof first);
    }
}

/* Less than 1e-9 of a nuisance ten thousand times the noise remains; equal bits on every instruction set. */
TEST(test_projection) {
    static double first[N], vector[N];
    for (int isa = 0; isa < shim_isas(); isa++) {
        state = 7;
        for (int i = 0; i < N; i++)
            vector[i] = uniform_signed(&state) + 1e4 * units[N + i];
        shim_residual_project(isa, units, kPlanes, N, vector);
        for (int k = 0; k < kPlanes; k++) {
            long double left = 0;
            for (int i = 0; i < N; i++)
                left += (long double)units[k * N + i] * vector[i];
            assert_at_most(fabs((double)left), 1e-9);
        }
        if (isa == 0)
            memcpy(first, vector, sizeof first);
        assert_memory_equal(first, vector, sizeof first);
    }
}

/* Frames together, with planes as float32: the projection in long double to the rounding of residual and result; equal
   bits on every instruction set and for any number of frames. */
TEST(test_projected_rows) {
    enum { kRows = 32, kCols = 128, kPixels = kRows * kCols, kFrames = 7 };
    static float planes[kMany * kPixels], vectors[kFrames * kPixels], rounded[kFrames * kPixels];
    static float first[kFrames * kPixels], alone[kPixels], alone_rounded[kPixels];
    for (int k = 0; k < kMany; k++) /* disjoint pixels, so orthogonal */
        for (int i = 0; i < kPixels; i++)
            planes[(i / kCols * kMany + k) * kCols + i % kCols] =
                i % kMany == k ? (float)(uniform_signed(&state) / sqrt(kPixels / 3.0 / kMany)) : 0;
    for (int isa = 0; isa < shim_isas(); isa++) {
        const size_t size[] = {kRows, kCols, kMany};
        assert_int_equal(
            shim_project_rows(isa, size, kFrames, counts, reference, inverse_sigma, planes, 0.3, vectors, rounded), 1);
        for (int f = 0; f < kFrames; f++) {
            long double component[kMany] = {0}, square[kMany] = {0};
            for (int i = 0; i < kPixels; i++) {
                const long double residual = ((long double)counts[f * kPixels + i] - reference[i]) * inverse_sigma[i];
                component[i % kMany] += residual * planes[(i / kCols * kMany + i % kMany) * kCols + i % kCols];
                square[i % kMany] += residual * residual;
            }
            for (int i = 0; i < kPixels; i++) {
                const long double residual = ((long double)counts[f * kPixels + i] - reference[i]) * inverse_sigma[i];
                const long double plane = planes[(i / kCols * kMany + i % kMany) * kCols + i % kCols];
                const long double along = component[i % kMany] * plane;
                const double rounding =
                    1.5e-7 * (double)(fabsl(residual) + fabsl(along) + sqrtl(square[i % kMany]) * fabsl(plane));
                assert_close(vectors[f * kPixels + i], (double)(residual - along), 0, rounding);
                assert_close(rounded[f * kPixels + i], 0.3 * (double)(residual - along), 0, 0.3 * rounding);
            }
            assert_int_equal(shim_project_rows(isa, size, 1, counts + f * kPixels, reference, inverse_sigma, planes,
                                               0.3, alone, alone_rounded),
                             1);
            assert_memory_equal(alone, vectors + f * kPixels, sizeof alone);
            assert_memory_equal(alone_rounded, rounded + f * kPixels, sizeof alone);
        }
        if (isa == 0)
            memcpy(first, rounded, sizeof first);
        assert_memory_equal(first, rounded, sizeof first);
        const double good = counts[kFrames * kPixels - 1];
        counts[kFrames * kPixels - 1] = NAN;
        assert_int_equal(
            shim_project_rows(isa, size, kFrames, counts, reference, inverse_sigma, planes, 0.3, vectors, rounded), 0);
        counts[kFrames * kPixels - 1] = good;
    }
}

/* The inner product of float32 numbers in double: products are exact. */
TEST(test_inner_product_of_floats) {
    static float a[N], b[N];
    long double expected = 0, absolute = 0;
    for (int i = 0; i < N; i++) {
        a[i] = (float)uniform_signed(&state);
        b[i] = (float)uniform_signed(&state);
        expected += (long double)a[i] * b[i];
        absolute += fabsl((long double)a[i] * b[i]);
    }
    const double first = shim_residual_inner_float(0, a, b, N);
    assert_close(first, (double)expected, 0, (double)absolute * N / 8 * 1.2e-16);
    for (int isa = 1; isa < shim_isas(); isa++)
        assert_true(shim_residual_inner_float(isa, a, b, N) == first);
}

RUN_TESTS(set_up, NULL)
