/* Tests the residual kernels against long double. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

int shim_residual_isas(void);
int shim_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma, size_t count,
                  double *out);
int shim_scaled_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                         double scale, size_t count, float *out);
void shim_residual_project(int isa, const double *units, size_t planes, size_t count, double *vector);
int shim_project_rows(int isa, const size_t *rows_cols_planes, const double *counts, const double *reference,
                      const double *inverse_sigma, const float *basis, double scale, double *vector, float *out,
                      size_t out_stride);
double shim_residual_inner(int isa, const double *a, const double *b, size_t count);

enum { N = 65536, kPlanes = 11, kMany = 20 }; /* two groups of four planes and three more */
static double counts[N], reference[N], inverse_sigma[N], units[kPlanes * N];

static uint32_t state = 1;

static double uniform(void) {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) / 8388608.0 - 1;
}

static int set_up(void **unused) {
    (void)unused;
    for (int i = 0; i < N; i++) {
        reference[i] = 1e9 * (1 + 0.5 * uniform());
        counts[i] = reference[i] + 3e4 * uniform();
        inverse_sigma[i] = 1 / sqrt(reference[i]);
    }
    for (int k = 0; k < kPlanes; k++) { /* disjoint pixels, so orthogonal */
        long double square = 0;
        for (int i = k; i < N; i += kPlanes)
            units[k * N + i] = uniform(), square += units[k * N + i] * units[k * N + i];
        for (int i = k; i < N; i += kPlanes)
            units[k * N + i] /= (double)sqrtl(square);
    }
    return 0;
}

static void test_residual(void **unused) {
    (void)unused;
    static double out[N];
    static float scaled[N];
    for (int isa = 0; isa < shim_residual_isas(); isa++) {
        assert_int_equal(shim_residual(isa, counts, reference, inverse_sigma, N, out), 1);
        assert_int_equal(shim_scaled_residual(isa, counts, reference, inverse_sigma, 1e-3, N, scaled), 1);
        for (int i = 0; i < N; i++) {
            assert_close(out[i], (double)(((long double)counts[i] - reference[i]) * inverse_sigma[i]), 1e-15, 0);
            assert_true(scaled[i] == (float)(1e-3 * out[i]));
        }
    }
}

static void test_non_finite_counts_are_seen(void **unused) {
    (void)unused;
    static double out[N];
    static float scaled[N];
    const double bad[] = {NAN, -NAN, INFINITY, -INFINITY};
    for (int isa = 0; isa < shim_residual_isas(); isa++)
        for (int k = 0; k < 4; k++) {
            const int at = k * 17 + (k == 3 ? N - 52 : 0);
            const double good = counts[at];
            counts[at] = bad[k];
            assert_int_equal(shim_residual(isa, counts, reference, inverse_sigma, N, out), 0);
            assert_int_equal(shim_scaled_residual(isa, counts, reference, inverse_sigma, 1, N, scaled), 0);
            counts[at] = good;
        }
}

static void test_inner_product(void **unused) {
    (void)unused;
    long double expected = 0, absolute = 0;
    for (int i = 0; i < N; i++) {
        expected += (long double)units[i] * inverse_sigma[i];
        absolute += fabsl((long double)units[i] * inverse_sigma[i]);
    }
    const double first = shim_residual_inner(0, units, inverse_sigma, N);
    assert_close(first, (double)expected, 0, (double)absolute * N / 16 * 1.2e-16);
    for (int isa = 1; isa < shim_residual_isas(); isa++) {
        const double other = shim_residual_inner(isa, units, inverse_sigma, N);
        assert_memory_equal(&other, &first, sizeof first);
    }
}

/* Less than 1e-9 of a nuisance ten thousand times the noise remains; equal bits on every instruction set. */
static void test_projection(void **unused) {
    (void)unused;
    static double first[N], vector[N];
    for (int isa = 0; isa < shim_residual_isas(); isa++) {
        state = 7;
        for (int i = 0; i < N; i++)
            vector[i] = uniform() + 1e4 * units[N + i];
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

/* Row by row, with planes as float32: the bits of the residual, its projection and its rounding one after the other. */
static void test_projected_rows(void **unused) {
    (void)unused;
    enum { kSide = 256, kStride = 258 };
    static float planes[kMany * N], rounded[kSide * kStride];
    static double same[kMany * N], vector[N], other[N];
    for (int i = 0; i < kMany * N; i++)
        same[i] = planes[i] = (float)(units[i % (kPlanes * N)] * (1 + i / (kPlanes * N)));
    for (int isa = 0; isa < shim_residual_isas(); isa++)
        for (size_t count = 0; count <= kMany; count += count < kPlanes ? 1 : kMany - kPlanes) {
            assert_int_equal(shim_residual(isa, counts, reference, inverse_sigma, N, vector), 1);
            shim_residual_project(isa, same, count, N, vector);
            const size_t rows_cols_planes[] = {kSide, kSide, count};
            assert_int_equal(shim_project_rows(isa, rows_cols_planes, counts, reference, inverse_sigma, planes, 0.3,
                                               other, rounded, kStride),
                             1);
            assert_memory_equal(vector, other, sizeof vector);
            for (int i = 0; i < N; i++)
                assert_true(rounded[i / kSide * kStride + i % kSide] == (float)(0.3 * vector[i]));
            const double good = counts[N - 1];
            counts[N - 1] = NAN;
            assert_int_equal(shim_project_rows(isa, rows_cols_planes, counts, reference, inverse_sigma, planes, 0.3,
                                               other, rounded, kStride),
                             0);
            counts[N - 1] = good;
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_residual),       cmocka_unit_test(test_non_finite_counts_are_seen),
        cmocka_unit_test(test_inner_product),  cmocka_unit_test(test_projection),
        cmocka_unit_test(test_projected_rows),
    };
    return cmocka_run_group_tests_name("residual", tests, set_up, NULL);
}
