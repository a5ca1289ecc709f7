/* Tests whitening and projection against sums in 113-bit arithmetic. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "quad_math.h"
#include "uniform.h"

int shim_isas(void);
double shim_dot(const double *a, const double *b, size_t n);
double shim_dot_difference(int isa, const double *a, const double *reference, const double *b, size_t n, size_t first);
void shim_whiten(int isa, const double *image, const double *variance, size_t n, double *out);
void shim_project_out(const double *units, size_t count, size_t n, double *vector);
size_t shim_orthonormalise(double *vectors, size_t count, size_t n);

enum { N = 4096 };

static quad quad_dot(const double *a, const double *b, size_t n) {
    quad sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (quad)a[i] * b[i];
    return sum;
}

static quad quad_absolute(const double *a, const double *b, size_t n) {
    quad sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (quad)fabs(a[i]) * fabs(b[i]);
    return sum;
}

/* Terms with magnitudes up to `spread`; the second half cancels the first except for a sum of order 1. */
static void make_ill_conditioned(double spread, uint64_t seed, double *a, double *b) {
    for (size_t i = 0; i < N / 2; i++) {
        a[i] = uniform_signed(&seed) * pow(spread, fabs(uniform_signed(&seed)));
        b[i] = uniform_signed(&seed);
        a[i + N / 2] = -a[i] + uniform_signed(&seed);
        b[i + N / 2] = b[i];
    }
}

TEST(dot_has_twice_the_precision) {
    static double a[N], b[N];
    int plain_fails = 0;
    for (int step = 0; step <= 5; step++) {
        make_ill_conditioned(pow(10, 3 * step), 17 + (uint64_t)step, a, b);
        const quad exact = quad_dot(a, b, N);
        const double absolute = (double)quad_absolute(a, b, N), bound = N * DBL_EPSILON;
        const double limit = DBL_EPSILON * fabs((double)exact) + bound * bound * absolute;
        assert_at_most(fabs((double)(shim_dot(a, b, N) - exact)), limit);
        double plain = 0;
        for (size_t i = 0; i < N; i++)
            plain += a[i] * b[i];
        plain_fails += fabs((double)(plain - exact)) > 100 * limit;
    }
    assert_true(plain_fails > 0); /* the cases are hard enough to tell a plain sum from the compensated one */
}

/* Any length, in one call or two; the same bits on every instruction set. */
TEST(dots_of_differences) {
    static double a[N], b[N], reference[N], residual[N];
    uint64_t seed = 31;
    for (size_t i = 0; i < N; i++) {
        reference[i] = 1e9 * (1 + 0.5 * uniform_signed(&seed));
        a[i] = reference[i] + 3e4 * uniform_signed(&seed);
        b[i] = 1e-9 * uniform_signed(&seed);
        residual[i] = a[i] - reference[i];
    }
    for (size_t n = 0; n < N; n = 3 * n / 2 + 1) {
        const quad exact = quad_dot(residual, b, n);
        const double bound = (double)n * DBL_EPSILON, absolute = (double)quad_absolute(residual, b, n);
        const double limit = DBL_EPSILON * fabs((double)exact) + bound * bound * absolute;
        const double first = shim_dot_difference(0, a, reference, b, n, n / 3);
        assert_at_most(fabs((double)(first - exact)), limit);
        for (int isa = 1; isa < shim_isas(); isa++) {
            const double other = shim_dot_difference(isa, a, reference, b, n, n / 3);
            assert_memory_equal(&other, &first, sizeof first);
        }
    }
    const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int isa = 0; isa < shim_isas(); isa++)
        for (size_t k = 0; k < 3; k++) {
            const size_t at = k == 2 ? N - 1 : 17 * k;
            const double good = a[at];
            a[at] = bad[k];
            assert_true(isnan(shim_dot_difference(isa, a, reference, b, N, 100)));
            a[at] = good;
        }
}

/* The bits of a plain loop, of any length, also in place. */
TEST(whiten_divides_by_the_deviation) {
    enum { MOST = 67 };
    double image[MOST], variance[MOST], expected[MOST], out[MOST];
    uint64_t seed = 41;
    for (int isa = 0; isa < shim_isas(); isa++)
        for (size_t n = 0; n <= MOST; n++) {
            for (size_t i = 0; i < n; i++) {
                image[i] = 1e9 * uniform_signed(&seed);
                variance[i] = 1e-6 + 1e9 * fabs(uniform_signed(&seed));
                expected[i] = image[i] / sqrt(variance[i]);
            }
            shim_whiten(isa, image, variance, n, out);
            assert_memory_equal(out, expected, n * sizeof *out);
            shim_whiten(isa, image, variance, n, image);
            assert_memory_equal(image, expected, n * sizeof *image);
        }
}

/* Four vectors within 1e-6 of each other. */
static void fill_nearly_parallel(double *vectors, size_t count) {
    uint64_t seed = 5;
    for (size_t i = 0; i < N; i++) {
        const double common = uniform_signed(&seed);
        for (size_t k = 0; k < count; k++)
            vectors[k * N + i] = common + 1e-6 * uniform_signed(&seed);
    }
}

TEST(basis_is_orthonormal_for_nearly_parallel_vectors) {
    static double vectors[4 * N], original[4 * N];
    fill_nearly_parallel(vectors, 4);
    memcpy(original, vectors, sizeof vectors);
    assert_int_equal(shim_orthonormalise(vectors, 4, N), 4);
    for (size_t k = 0; k < 4; k++)
        for (size_t l = 0; l < 4; l++)
            assert_close((double)quad_dot(vectors + k * N, vectors + l * N, N), k == l, 0, 1e-14);
    for (size_t k = 0; k < 4; k++) { /* and it spans the originals */
        const double length = sqrt((double)quad_dot(original + k * N, original + k * N, N));
        shim_project_out(vectors, 4, N, original + k * N);
        assert_at_most(sqrt((double)quad_dot(original + k * N, original + k * N, N)), 1e-14 * length);
    }
}

TEST(dependent_vectors_are_dropped) {
    static double vectors[5 * N], third[N];
    uint64_t seed = 9;
    for (size_t i = 0; i < N; i++) {
        vectors[i] = uniform_signed(&seed);
        vectors[N + i] = 0;                                             /* the zero vector */
        vectors[2 * N + i] = -3 * vectors[i];                           /* parallel to the first */
        vectors[3 * N + i] = third[i] = uniform_signed(&seed);          /* independent */
        vectors[4 * N + i] = 2 * vectors[i] - 1e5 * vectors[3 * N + i]; /* a combination of both */
    }
    assert_int_equal(shim_orthonormalise(vectors, 5, N), 2);
    const double length = sqrt((double)quad_dot(third, third, N));
    shim_project_out(vectors, 2, N, third);
    assert_at_most(sqrt((double)quad_dot(third, third, N)), 1e-14 * length);
}

TEST(projection_removes_the_components_and_nothing_else) {
    static double units[2 * N], vector[N], before[N];
    uint64_t seed = 3;
    for (size_t i = 0; i < N; i++) {
        units[i] = uniform_signed(&seed);
        units[N + i] = uniform_signed(&seed);
        vector[i] = before[i] = uniform_signed(&seed);
    }
    assert_int_equal(shim_orthonormalise(units, 2, N), 2);
    const double first = (double)quad_dot(units, vector, N), second = (double)quad_dot(units + N, vector, N);
    shim_project_out(units, 2, N, vector);
    assert_close((double)quad_dot(units, vector, N), 0, 0, 1e-14);
    assert_close((double)quad_dot(units + N, vector, N), 0, 0, 1e-14);
    for (size_t i = 0; i < N; i++)
        assert_close(vector[i], before[i] - first * units[i] - second * units[N + i], 0, 1e-14);
}

RUN_TESTS(NULL, NULL)
