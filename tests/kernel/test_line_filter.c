/* Tests filters along a line against their transfer functions in long double: inside the band to the stated error; and
 * their size, which amplifies rounding. */
#include "assert_close.h"

size_t shim_line_filter(double cutoff, double sigma, size_t m, int integrated, double accuracy, size_t most,
                        double *taps, double *error);

enum { MOST = 2000, CHECKS = 77 };

static long double expected(long double f, double sigma, size_t m, int integrated) {
    const long double pi = acosl(-1), spread = 2 * pi * sigma * f;
    long double value = expl(-spread * spread / 2);
    for (size_t i = 1; i <= m; i++)
        value *= spread / sqrtl((long double)i);
    return integrated && f > 0 ? value * sinl(pi * f) / (pi * f) : value;
}

/* Largest error at frequencies between those that were compared when the filter was made; up to 1 % larger there. */
static long double worst_error(const double *taps, size_t count, double cutoff, double sigma, size_t m,
                               int integrated) {
    long double worst = 0;
    for (int i = 0; i <= CHECKS; i++) {
        const long double f = (long double)cutoff * i / CHECKS;
        long double sum = taps[0];
        for (size_t k = 1; k < count; k++) {
            const long double angle = 2 * acosl(-1) * f * (long double)k;
            sum += 2 * taps[k] * (m % 2 == 1 ? sinl(angle) : cosl(angle));
        }
        worst = fmaxl(worst, fabsl(sum - expected(f, sigma, m, integrated)));
    }
    return worst;
}

static void check(double cutoff, double sigma, size_t m, int integrated, double accuracy) {
    static double taps[MOST];
    double error, size = 0, least = 0;
    const size_t count = shim_line_filter(cutoff, sigma, m, integrated, accuracy, MOST, taps, &error);
    assert_in_range(count, 1, MOST);
    for (size_t k = 0; k < count; k++) {
        size += (k == 0 ? 1 : 2) * fabs(taps[k]);
        least = fmin(least, taps[k]);
    }
    const long double worst = worst_error(taps, count, cutoff, sigma, m, integrated);
    if (!(worst <= 1.01 * error / 2 && error <= accuracy && size <= 10 && (sigma < 2 || m > 0 || least >= -accuracy)))
        fail_msg(
            "cutoff %g, sigma %g, m %zu, integrated %d, accuracy %g: %zu taps, error %.3Lg, stated %g / 2, size %g, "
            "least tap %g",
            cutoff, sigma, m, integrated, accuracy, count, worst, error, size, least);
}

TEST(any_width) {
    static const double cutoffs[] = {0.02, 0.1, 0.214, 0.3, 0.4}, accuracies[] = {1e-3, 1e-6, 1e-9, 1e-11},
                        sigmas[] = {0, 0.1, 0.5, 1, 1.39, 1.41, 1.7, 2, 2.4, 3, 4.5, 7, 10, 20, 50};
    for (size_t c = 0; c < sizeof cutoffs / sizeof *cutoffs; c++)
        for (size_t a = 0; a < sizeof accuracies / sizeof *accuracies; a++)
            for (size_t s = 0; s < sizeof sigmas / sizeof *sigmas; s++)
                for (int integrated = 0; integrated < 2; integrated++)
                    check(cutoffs[c], sigmas[s], 0, integrated, accuracies[a]);
}

TEST(terms_of_a_covariance) {
    static const double sigmas[] = {0.3, 1, 2, 5, 20};
    static const size_t orders[] = {1, 2, 3, 4, 7, 20, 61};
    for (size_t s = 0; s < sizeof sigmas / sizeof *sigmas; s++)
        for (size_t m = 0; m < sizeof orders / sizeof *orders; m++)
            for (int integrated = 0; integrated < 2; integrated++)
                check(0.3, sigmas[s], orders[m], integrated, 1e-9);
}

RUN_TESTS(NULL, NULL)
