/* Tests the interpolation window against I_0 by quadrature in long double, its derivatives against differences, its
 * transform against quadrature, its error against interpolated waves, and its sums against plain loops. */
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

enum { MOST_TAPS = 32, ORDERS = 3 };

double shim_shift_beta(size_t taps, double cutoff);
void shim_shift_weights(size_t taps, double beta, double fraction, double *weights);
double shim_shift_transform(size_t taps, double beta, double frequency);
double shim_shift_error(size_t taps, double beta, double cutoff);
int shim_isas(void);
void shim_shift_sum(int isa, const double *samples, const size_t *offset, const double *weights, size_t orders,
                    size_t taps, size_t count, double *const *out);
void shim_shift_spread(int isa, const double *values, const size_t *offset, const double *weights, size_t taps,
                       size_t count, double *samples);

static const struct {
    size_t taps;
    double cutoff;
} kWindows[] = {{4, 0.1}, {8, 0.21}, {12, 0.21}, {14, 0.3}, {20, 0.4}, {32, 0.25}};
enum { WINDOWS = sizeof kWindows / sizeof *kWindows };

static uint64_t state = 17;

/* I_0 of the square root of its argument: the mean of cosh(x cos t), exponentially accurate with equal steps. */
static long double bessel(long double square) {
    enum { STEPS = 128 };
    const long double x = sqrtl(fabsl(square)), step = acosl(-1) / STEPS;
    long double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const long double phase = x * cosl(step * (i + 0.5L));
        sum += square < 0 ? cosl(phase) : coshl(phase);
    }
    return sum / STEPS;
}

static long double window(size_t taps, double beta, long double distance) {
    const long double x = 2 * distance / (long double)taps, b = beta;
    return bessel(b * b * (1 - x * x)) / bessel(b * b);
}

TEST(test_weights) {
    const double fractions[] = {0, 1e-12, 0.25, 0.5, 0.7312345, 0.999999999};
    for (size_t w = 0; w < WINDOWS; w++) {
        const size_t taps = kWindows[w].taps;
        const double beta = shim_shift_beta(taps, kWindows[w].cutoff);
        for (size_t f = 0; f < sizeof fractions / sizeof *fractions; f++) {
            double weights[ORDERS * MOST_TAPS];
            shim_shift_weights(taps, beta, fractions[f], weights);
            for (size_t t = 0; t < taps; t++) {
                const long double distance = (long double)fractions[f] + (double)(taps / 2) - 1 - (double)t;
                assert_close(weights[t], (double)window(taps, beta, distance), 1e-14, 1e-16);
                /* Differences of eighth order. */
                const long double h = 0.01L, a[] = {0, 4 / 5.0L, -1 / 5.0L, 4 / 105.0L, -1 / 280.0L};
                const long double b[] = {-205 / 72.0L, 8 / 5.0L, -1 / 5.0L, 8 / 315.0L, -1 / 560.0L};
                long double slope = 0, curve = b[0] * window(taps, beta, distance);
                for (int i = 1; i <= 4; i++) {
                    const long double up = window(taps, beta, distance + i * h),
                                      down = window(taps, beta, distance - i * h);
                    slope += a[i] * (up - down);
                    curve += b[i] * (up + down);
                }
                assert_close(weights[MOST_TAPS + t], (double)(slope / h), 0, 1e-10);
                assert_close(weights[2 * MOST_TAPS + t], (double)(curve / h / h), 0, 1e-8);
            }
        }
    }
}

/* By Gauss-Legendre quadrature in 200 intervals. */
TEST(test_transform) {
    enum { INTERVALS = 200 };
    static const long double nodes[] = {0, -0.538469310105683091036L, 0.538469310105683091036L,
                                        -0.906179845938663992798L, 0.906179845938663992798L};
    static const long double shares[] = {0.568888888888888888889L, 0.478628670499366468041L, 0.478628670499366468041L,
                                         0.236926885056189087514L, 0.236926885056189087514L};
    for (size_t w = 0; w < WINDOWS; w++) {
        const size_t taps = kWindows[w].taps;
        const double beta = shim_shift_beta(taps, kWindows[w].cutoff);
        const long double step = (long double)taps / INTERVALS;
        static long double place[5 * INTERVALS], value[5 * INTERVALS];
        for (int i = 0; i < 5 * INTERVALS; i++) {
            place[i] = -0.5L * (long double)taps + step * (i / 5 + 0.5L * (1 + nodes[i % 5]));
            value[i] = 0.5L * step * shares[i % 5] * window(taps, beta, place[i]);
        }
        const double whole = shim_shift_transform(taps, beta, 0);
        for (double frequency = 0; frequency < 2.6; frequency += 0.0625) {
            long double sum = 0;
            for (int i = 0; i < 5 * INTERVALS; i++)
                sum += value[i] * cosl(2 * acosl(-1) * frequency * place[i]);
            assert_close(shim_shift_transform(taps, beta, frequency), (double)sum, 0, 1e-14 * whole);
        }
    }
}

/* Interpolates waves up to the cutoff, from samples divided by the transform: the error is within the bound, and the
 * bound is not excessive. */
TEST(test_error) {
    for (size_t w = 0; w < WINDOWS; w++) {
        const size_t taps = kWindows[w].taps;
        const double beta = shim_shift_beta(taps, kWindows[w].cutoff),
                     bound = shim_shift_error(taps, beta, kWindows[w].cutoff);
        double worst = 0, slopes = 0;
        for (int i = 0; i <= 2000; i++) {
            const double frequency = kWindows[w].cutoff * (i % 21) / 20, fraction = (uniform_signed(&state) + 1) / 2,
                         phase = 7 * uniform_signed(&state), turn = 2 * acos(-1) * frequency;
            const double transform = shim_shift_transform(taps, beta, frequency);
            double weights[ORDERS * MOST_TAPS], sum = 0, slope = 0;
            shim_shift_weights(taps, beta, fraction, weights);
            for (size_t t = 0; t < taps; t++) {
                const double wave = cos(turn * ((double)t - (double)(taps / 2) + 1) + phase);
                sum += weights[t] * wave;
                slope += weights[MOST_TAPS + t] * wave;
            }
            worst = fmax(worst, fabs(sum / transform - cos(turn * fraction + phase)));
            slopes = fmax(slopes, fabs(slope / transform + turn * sin(turn * fraction + phase)));
        }
        const double rounding =
            3e-15 * shim_shift_transform(taps, beta, 0) / shim_shift_transform(taps, beta, kWindows[w].cutoff);
        print_message("%zu taps, cutoff %g: error %.2g, of slopes %.2g, bound %.2g, rounding %.2g\n", taps,
                      kWindows[w].cutoff, worst, slopes, bound, rounding);
        assert_at_most(slopes, 20 * (bound + rounding));
        assert_at_most(worst, bound + rounding);
        if (bound > 10 * rounding)
            assert_at_most(bound, 3 * worst);
    }
}

/* Every number of outputs up to 75, at places that no vector is aligned to: as a plain loop in wider arithmetic, and
 * the same bits on every instruction set. */
TEST(test_sums) {
    enum { SAMPLES = 400, MOST = 75 };
    double samples[SAMPLES], weights[ORDERS * MOST_TAPS];
    for (size_t i = 0; i < SAMPLES; i++)
        samples[i] = uniform_signed(&state);
    for (size_t i = 0; i < ORDERS * MOST_TAPS; i++)
        weights[i] = uniform_signed(&state);
    for (size_t count = 0; count <= MOST; count++)
        for (size_t orders = 1; orders <= ORDERS; orders++) {
            const size_t taps = 4 + 2 * (count % 15);
            size_t offset[MOST_TAPS];
            for (size_t t = 0; t < taps; t++)
                offset[t] = (7 * t + 3 * count) % (SAMPLES - MOST);
            double first[ORDERS][MOST + 1], sums[ORDERS][MOST + 1];
            double *const out[] = {sums[0], sums[1], sums[2]};
            for (int isa = 0; isa < shim_isas(); isa++) {
                for (size_t i = 0; i < ORDERS * (MOST + 1); i++)
                    sums[i / (MOST + 1)][i % (MOST + 1)] = -9;
                shim_shift_sum(isa, samples, offset, weights, orders, taps, count, out);
                if (isa == 0)
                    memcpy(first, sums, sizeof first);
                assert_memory_equal(first, sums, sizeof first);
            }
            for (size_t o = 0; o < ORDERS; o++)
                for (size_t i = 0; i <= MOST; i++) {
                    long double sum = 0;
                    for (size_t t = 0; t < taps && o < orders && i < count; t++)
                        sum += (long double)weights[o * MOST_TAPS + t] * samples[offset[t] + i];
                    assert_close(sums[o][i], o < orders && i < count ? (double)sum : -9, 0, 1e-14);
                }
        }
}

/* The adjoint, with taps that overlap: as a plain loop in wider arithmetic, and the same bits everywhere. */
TEST(test_spreading) {
    enum { SAMPLES = 200, MOST = 75 };
    double values[MOST], weights[MOST_TAPS];
    for (size_t i = 0; i < MOST; i++)
        values[i] = uniform_signed(&state);
    for (size_t i = 0; i < MOST_TAPS; i++)
        weights[i] = uniform_signed(&state);
    for (size_t count = 0; count <= MOST; count++) {
        const size_t taps = 4 + 2 * (count % 15);
        size_t offset[MOST_TAPS];
        long double expected[SAMPLES];
        for (size_t i = 0; i < SAMPLES; i++)
            expected[i] = 3;
        for (size_t t = 0; t < taps; t++) {
            offset[t] = (7 * t + 3 * count) % (SAMPLES - MOST);
            for (size_t i = 0; i < count; i++)
                expected[offset[t] + i] += (long double)weights[t] * values[i];
        }
        double first[SAMPLES], samples[SAMPLES];
        for (int isa = 0; isa < shim_isas(); isa++) {
            for (size_t i = 0; i < SAMPLES; i++)
                samples[i] = 3;
            shim_shift_spread(isa, values, offset, weights, taps, count, samples);
            if (isa == 0)
                memcpy(first, samples, sizeof first);
            assert_memory_equal(first, samples, sizeof first);
        }
        for (size_t i = 0; i < SAMPLES; i++)
            assert_close(samples[i], (double)expected[i], 0, 2e-14);
    }
}

RUN_TESTS(NULL, NULL)
