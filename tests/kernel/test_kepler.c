/* Tests Kepler's equation against bisection in quadruple precision. */
#include <quadmath.h>

#include "assert_close.h"
#include "uniform.h"

double shim_kepler(double mean_anomaly, double eccentricity);

/* x - e sin x; 113 bits keep enough precision where the two terms cancel. */
static __float128 mean_of(__float128 x, __float128 e) {
    if (x > 1e-2Q)
        return x - e * sinq(x);
    __float128 sum = 1;
    for (int k = 25; k > 3; k -= 2)
        sum = 1 - x * x / (k * (k - 1)) * sum;
    return (1 - e) * x + e * x * x * x / 6 * sum;
}

/* The root for 0 <= mean <= pi: 115 bisections of an interval whose ends differ by at most a factor of 2. */
static __float128 bisected(__float128 mean, double e) {
    __float128 high = M_PIq;
    while (mean_of(high / 2, e) > mean)
        high /= 2;
    __float128 low = high / 2;
    for (int i = 0; i < 115; i++) {
        const __float128 middle = (low + high) / 2;
        if (mean_of(middle, e) > mean)
            high = middle;
        else
            low = middle;
    }
    return low;
}

/* Error in units in the last place of the exact value. */
static double error_at(double mean, double e) {
    __float128 reduced = mean;
    if (fabs(mean) > M_PI)
        reduced = atan2q(sinq(mean), cosq(mean));
    const __float128 exact = copysignq(bisected(fabsq(reduced), e), reduced);
    const double found = shim_kepler(mean, e), near = (double)exact;
    assert_true(fabs(found) <= M_PI);
    const double unit = nextafter(fabs(near), INFINITY) - fabs(near);
    return (double)(fabsq(found - exact) / unit);
}

static const double kEccentricities[] = {0,   1e-300, 1e-9,   0.0167,   0.2,       0.51947,
                                         0.9, 0.99,   0.9999, 1 - 1e-8, 1 - 1e-12, 1 - 0x1p-53};
enum { ECCENTRICITIES = sizeof kEccentricities / sizeof *kEccentricities };

/* Every decade of the mean anomaly from the smallest normal double to pi, and uniformly over one revolution. */
static void within_a_revolution(void **state) {
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
    for (int i = 0; i < 5000; i++) {
        const double e = 1 - pow(10, -12 * uniform(&random));
        worst = fmax(worst, error_at(M_PI * pow(uniform(&random), 3), e));
    }
    print_message("Kepler's equation within a revolution: at most %.2f units in the last place\n", worst);
    assert_at_most(worst, 4);
}

/* Many revolutions, of either sign. */
static void many_revolutions(void **state) {
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

static void limits(void **state) {
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(within_a_revolution),
        cmocka_unit_test(many_revolutions),
        cmocka_unit_test(limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
