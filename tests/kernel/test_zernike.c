/* Tests Zernike polynomials against Noll's table and against his sum of powers in 113 bits. */
#include "quad_math.h"

#include "assert_close.h"

double shim_zernike(int noll, double x, double y);
int shim_largest_noll(void);

/* Points of the disc in polar coordinates, from the centre to the rim. */
enum { RADII = 21, ANGLES = 16 };
static double radius(int i) {
    return i / (RADII - 1.0);
}
static double angle(int k) {
    return (k + 0.3) * 2 * M_PI / ANGLES;
}

/* The first eleven as printed in Noll's table I. */
static double printed(int noll, double r, double t) {
    const double coma = sqrt(8) * (3 * r * r * r - 2 * r), trefoil = sqrt(8) * r * r * r, twice = sqrt(6) * r * r;
    const double all[] = {1,
                          2 * r * cos(t),
                          2 * r * sin(t),
                          sqrt(3) * (2 * r * r - 1),
                          twice * sin(2 * t),
                          twice * cos(2 * t),
                          coma * sin(t),
                          coma * cos(t),
                          trefoil * sin(3 * t),
                          trefoil * cos(3 * t),
                          sqrt(5) * (6 * r * r * r * r - 6 * r * r + 1)};
    return all[noll - 1];
}

TEST(first_eleven_match_the_table) {
    for (int noll = 1; noll <= 11; noll++)
        for (int i = 0; i < RADII; i++)
            for (int k = 0; k < ANGLES; k++) {
                const double r = radius(i), t = angle(k);
                assert_close(shim_zernike(noll, r * cos(t), r * sin(t)), printed(noll, r, t), 0, 4e-15);
            }
}

/* Noll's equation 2: (-1)^s (n-s)! / (s! ((n+m)/2-s)! ((n-m)/2-s)!) r^(n-2s), summed over s. */
static quad radial(int n, int m, quad r) {
    quad factorial[64] = {1}, sum = 0;
    for (int i = 1; i < 64; i++)
        factorial[i] = i * factorial[i - 1];
    for (int s = 0; s <= (n - m) / 2; s++)
        sum += (s % 2 == 0 ? 1 : -1) * factorial[n - s] /
               (factorial[s] * factorial[(n + m) / 2 - s] * factorial[(n - m) / 2 - s]) * powq(r, n - 2 * s);
    return sum;
}

/* Every index in Noll's order: by n, then by m; the cosine term has the even index. */
TEST(polynomials_are_sums_of_powers) {
    double worst = 0;
    int noll = 0;
    for (int n = 0; noll < shim_largest_noll(); n++)
        for (int m = n % 2; m <= n; m += 2)
            for (int twin = 0; twin < (m == 0 ? 1 : 2); twin++) {
                noll++;
                for (int i = 0; i < RADII; i++)
                    for (int k = 0; k < ANGLES; k++) {
                        const double x = radius(i) * cos(angle(k)), y = radius(i) * sin(angle(k));
                        const quad r = hypotq(x, y), t = atan2q(y, x);
                        const quad turn = m == 0 ? 1 : sqrtq(2) * (noll % 2 == 0 ? cosq(m * t) : sinq(m * t));
                        worst = fmax(worst,
                                     fabs((double)(sqrtq(n + 1) * radial(n, m, r) * turn - shim_zernike(noll, x, y))));
                    }
            }
    assert_int_equal(noll, shim_largest_noll());
    print_message("largest error of a Zernike polynomial within the disc: %.2g\n", worst);
    assert_at_most(worst, 1e-13);
}

TEST(other_indices_give_nan) {
    const int bad[] = {0, -1, INT32_MIN, shim_largest_noll() + 1, INT32_MAX};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_true(isnan(shim_zernike(bad[i], 0.1, 0.2)));
    assert_true(shim_largest_noll() >= 66);
}

RUN_TESTS(NULL, NULL)
