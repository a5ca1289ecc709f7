/* Tests positions and velocities on Kepler orbits against bisection in long double, and products against long double.
 */
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
size_t shim_kepler_lanes(void);
void shim_kepler_rows(int isa, int velocity, double frequency, double anomaly, double eccentricity, const double *t,
                      size_t n, double *x, double *y);
void shim_products(int isa, const double *rows, size_t count, const double *x, const double *y, size_t n, double *out);

enum { SAMPLES = 203, ROWS = 208 }; /* not a multiple of a block; a multiple of the lanes */

/* The eccentric anomaly of a mean anomaly in [-pi, pi]. */
static long double eccentric(long double mean, long double e) {
    long double low = -4, high = 4;
    for (int i = 0; i < 80; i++) {
        const long double middle = (low + high) / 2;
        if (middle - e * sinl(middle) > mean)
            high = middle;
        else
            low = middle;
    }
    return low;
}

static double times[SAMPLES], x[SAMPLES], y[SAMPLES];

static void set_times(void) {
    uint64_t random = 3;
    for (int i = 0; i < SAMPLES; i++)
        times[i] = 2000 * uniform(&random) - 1000;
    times[0] = 0;
}

/* Largest errors of position and velocity. */
static double error_at(int velocity, double frequency, double anomaly, double e) {
    shim_kepler_rows(0, velocity, frequency, anomaly, e, times, SAMPLES, x, y);
    double worst = 0;
    for (int i = 0; i < SAMPLES; i++) {
        const double cycles = frequency * times[i] + anomaly; /* rounded, as in the kernel */
        const long double pi = acosl(-1), mean = 2 * pi * ((long double)cycles - rintl(cycles));
        const long double at = eccentric(mean, e), radius = 1 - e * cosl(at);
        long double exact_x = cosl(at) - e, exact_y = sqrtl(1 - (long double)e * e) * sinl(at);
        if (velocity) {
            exact_x = exact_x / radius + e;
            exact_y = exact_y / radius;
        }
        worst = fmax(worst, (double)fabsl(x[i] - exact_x));
        worst = fmax(worst, (double)fabsl(y[i] - exact_y));
    }
    return worst;
}

static const double kEccentricities[] = {0, 1e-9, 0.01, 0.3, 0.5, 0.50001, 0.7, 0.9, 0.95, 0.9511, 0.97, 0.991};
enum { ECCENTRICITIES = sizeof kEccentricities / sizeof *kEccentricities };

static void exact(void **state) {
    set_times();
    double worst_position = 0, worst_velocity = 0;
    for (int i = 0; i < ECCENTRICITIES; i++)
        for (int k = 0; k < 20; k++) {
            const double frequency = pow(10, -4 + 0.15 * k), anomaly = k / 20.0, e = kEccentricities[i];
            worst_position = fmax(worst_position, error_at(0, frequency, anomaly, e));
            worst_velocity = fmax(worst_velocity, error_at(1, frequency, anomaly, e));
        }
    print_message("position within %.1e, velocity within %.1e\n", worst_position, worst_velocity);
    assert_at_most(worst_position, 1e-13);
    assert_at_most(worst_velocity, 1e-12);
}

/* Sums of products, of which the rows cancel. */
static void products(void **state) {
    assert_int_equal(ROWS % shim_kepler_lanes(), 0);
    enum { COUNT = 5 };
    static double rows[COUNT * ROWS], a[ROWS], b[ROWS];
    uint64_t random = 9;
    for (int i = 0; i < COUNT * ROWS; i++)
        rows[i] = uniform(&random) - 0.5;
    for (int i = 0; i < ROWS; i++) {
        a[i] = uniform(&random) - 0.5;
        b[i] = uniform(&random);
    }
    double out[2 * COUNT];
    shim_products(0, rows, COUNT, a, b, ROWS, out);
    for (int j = 0; j < COUNT; j++) {
        long double with_a = 0, with_b = 0;
        for (int i = 0; i < ROWS; i++) {
            with_a += (long double)rows[j * ROWS + i] * a[i];
            with_b += (long double)rows[j * ROWS + i] * b[i];
        }
        assert_at_most(fabs(out[2 * j] - (double)with_a), 1e-14);
        assert_at_most(fabs(out[2 * j + 1] - (double)with_b), 1e-14);
    }
}

static void same_bits(void **state) {
    set_times();
    static double other_x[SAMPLES], other_y[SAMPLES];
    for (int isa = 1; isa < shim_isas(); isa++)
        for (int velocity = 0; velocity < 2; velocity++)
            for (int i = 0; i < ECCENTRICITIES; i++) {
                shim_kepler_rows(0, velocity, 0.00217, 0.3, kEccentricities[i], times, SAMPLES, x, y);
                shim_kepler_rows(isa, velocity, 0.00217, 0.3, kEccentricities[i], times, SAMPLES, other_x, other_y);
                assert_memory_equal(x, other_x, sizeof x);
                assert_memory_equal(y, other_y, sizeof y);
                double sums[2], other[2];
                shim_products(0, x, 1, x, y, SAMPLES / 16 * 16, sums);
                shim_products(isa, x, 1, x, y, SAMPLES / 16 * 16, other);
                assert_memory_equal(sums, other, sizeof sums);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact),
        cmocka_unit_test(products),
        cmocka_unit_test(same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
