/* Tests Kepler's equation, and positions and velocities on orbits, against bisection in quadruple precision; products
 * against long double. */
#include "quad_math.h"
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

double shim_kepler(double mean_anomaly, double eccentricity);
int shim_isas(void);
size_t shim_kepler_lanes(void);
void shim_kepler_rows(int isa, int velocity, double frequency, double anomaly, double eccentricity, const double *t,
                      size_t n, double *x, double *y);
void shim_products(int isa, const double *rows, size_t count, const double *x, const double *y, size_t n, double *out);

/* x - e sin x; 113 bits keep enough precision where the two terms cancel. */
static quad mean_of(quad x, quad e) {
    if (x > QUAD(1e-2))
        return x - e * sinq(x);
    quad sum = 1;
    for (int k = 25; k > 3; k -= 2)
        sum = 1 - x * x / (k * (k - 1)) * sum;
    return (1 - e) * x + e * x * x * x / 6 * sum;
}

/* The root for 0 <= mean <= pi: 115 bisections of an interval whose ends differ by at most a factor of 2. */
static quad bisected(quad mean, double e) {
    quad high = M_PIq;
    while (mean_of(high / 2, e) > mean)
        high /= 2;
    quad low = high / 2;
    for (int i = 0; i < 115; i++) {
        const quad middle = (low + high) / 2;
        if (mean_of(middle, e) > mean)
            high = middle;
        else
            low = middle;
    }
    return low;
}

/* Error in units in the last place of the exact value. */
static double error_at(double mean, double e) {
    quad reduced = mean;
    if (fabs(mean) > M_PI)
        reduced = atan2q(sinq(mean), cosq(mean));
    const quad exact = copysignq(bisected(fabsq(reduced), e), reduced);
    const double found = shim_kepler(mean, e), near = (double)exact;
    assert_true(fabs(found) <= M_PI);
    const double unit = nextafter(fabs(near), INFINITY) - fabs(near);
    return (double)(fabsq(found - exact) / unit);
}

static const double kEccentricities[] = {0,   1e-300, 1e-9,   0.0167,   0.2,       0.51947,
                                         0.9, 0.99,   0.9999, 1 - 1e-8, 1 - 1e-12, 1 - 0x1p-53};
enum { ECCENTRICITIES = sizeof kEccentricities / sizeof *kEccentricities };

/* Every decade of the mean anomaly from the smallest normal double to pi, and uniformly over one revolution. */
TEST(within_a_revolution) {
    uint64_t random = 1;
    double worst = 0;
    for (int i = 0; i < ECCENTRICITIES; i++) {
        for (int exponent = -307; exponent <= 0; exponent += exponent < -20 ? 13 : 1)
            for (int k = 0; k < 3; k++) {
                const double mean = (1 + 2 * uniform(&random)) * pow(10, exponent);
                worst = fmax(worst, error_at(k == 2 ? -mean : mean, kEccentricities[i]));
            }
        for (int k = 0; k <= 200; k++)
            worst = fmax(worst, error_at(M_PI * k / 200, kEccentricities[i]));
    }
    for (int i = 0; i < (in_long() ? 5000 : 1500); i++) {
        const double e = 1 - pow(10, -12 * uniform(&random));
        worst = fmax(worst, error_at(M_PI * pow(uniform(&random), 3), e));
    }
    print_message("Kepler's equation within a revolution: at most %.2f units in the last place\n", worst);
    assert_at_most(worst, 4);
}

/* Many revolutions, of either sign. */
TEST(many_revolutions) {
    uint64_t random = 2;
    double worst = 0;
    for (int i = 0; i < ECCENTRICITIES; i++)
        for (int exponent = 0; exponent <= 300; exponent += exponent < 20 ? 1 : 20)
            for (int k = 0; k < 4; k++) {
                const double mean = (4 + 5 * uniform(&random)) * pow(10, exponent);
                worst = fmax(worst, error_at(k % 2 ? -mean : mean, kEccentricities[i]));
            }
    /* Doubles next to whole revolutions: the reduced anomaly is tiny. */
    for (int k = 1; k <= 20; k++)
        worst = fmax(worst, error_at(k * 6.283185307179586477, 0.9999));
    print_message("Kepler's equation after many revolutions: at most %.2f units in the last place\n", worst);
    assert_at_most(worst, 4);
}

TEST(limits) {
    for (int i = 0; i < ECCENTRICITIES; i++) {
        const double e = kEccentricities[i];
        assert_close(shim_kepler(0, e), 0, 0, 0);
        assert_true(signbit(shim_kepler(-0.0, e)));
        assert_close(shim_kepler(M_PI, e), M_PI, 3e-16, 0);
        assert_true(shim_kepler(0x1p-1074, e) > 0 && isfinite(shim_kepler(0x1p-1074, e)));
        assert_true(isnan(shim_kepler(INFINITY, e)) && isnan(shim_kepler(NAN, e)));
        assert_close(shim_kepler(-1.25, e), -shim_kepler(1.25, e), 0, 0);
    }
    for (double mean = -3; mean <= 3; mean += 0.37)
        assert_close(shim_kepler(mean, 0), mean, 0, 0);
}

enum { SAMPLES = 203, ROWS = 208 }; /* not a multiple of a block; a multiple of the lanes */

/* The eccentric anomaly of a mean anomaly in [-pi, pi], where 64 bits suffice. */
static long double eccentric(long double mean, long double e) {
    long double low = -4, high = 4;
    for (int i = 0; i < 80; i++) {
        const long double middle = (low + high) / 2;
        *(middle - e * sinl(middle) > mean ? &high : &low) = middle;
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
static double row_error_at(int velocity, double frequency, double anomaly, double e) {
    shim_kepler_rows(0, velocity, frequency, anomaly, e, times, SAMPLES, x, y);
    double worst = 0;
    for (int i = 0; i < SAMPLES; i++) {
        const double cycles = frequency * times[i] + anomaly; /* rounded, as in the kernel */
        const long double mean = 2 * M_PIl * ((long double)cycles - rintl(cycles));
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

static const double kModerate[] = {0, 1e-9, 0.01, 0.3, 0.5, 0.50001, 0.7, 0.9, 0.95, 0.9511, 0.97, 0.991};
enum { MODERATE = sizeof kModerate / sizeof *kModerate };

TEST(rows_are_exact) {
    set_times();
    double worst_position = 0, worst_velocity = 0;
    for (int i = 0; i < MODERATE; i++)
        for (int k = 0; k < 20; k += in_long() ? 1 : 3) {
            const double frequency = pow(10, -4 + 0.15 * k), anomaly = k / 20.0, e = kModerate[i];
            worst_position = fmax(worst_position, row_error_at(0, frequency, anomaly, e));
            worst_velocity = fmax(worst_velocity, row_error_at(1, frequency, anomaly, e));
        }
    print_message("position within %.1e, velocity within %.1e\n", worst_position, worst_velocity);
    assert_at_most(worst_position, 1e-13);
    assert_at_most(worst_velocity, 1e-12);
}

/* Sums of products, of which the rows cancel. */
TEST(products) {
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

TEST(same_bits) {
    set_times();
    static double other_x[SAMPLES], other_y[SAMPLES];
    for (int isa = 1; isa < shim_isas(); isa++)
        for (int velocity = 0; velocity < 2; velocity++)
            for (int i = 0; i < MODERATE; i++) {
                shim_kepler_rows(0, velocity, 0.00217, 0.3, kModerate[i], times, SAMPLES, x, y);
                shim_kepler_rows(isa, velocity, 0.00217, 0.3, kModerate[i], times, SAMPLES, other_x, other_y);
                assert_memory_equal(x, other_x, sizeof x);
                assert_memory_equal(y, other_y, sizeof y);
                double sums[2], other[2];
                shim_products(0, x, 1, x, y, SAMPLES / 16 * 16, sums);
                shim_products(isa, x, 1, x, y, SAMPLES / 16 * 16, other);
                assert_memory_equal(sums, other, sizeof sums);
            }
}

RUN_TESTS(NULL, NULL)
