/* Tests the cases in which other periodograms are inaccurate: power against 113-bit arithmetic, and identical states
 * regardless of how the samples arrived. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "quad_period.h"
#include "samples.h"
#include "uniform.h"

#include <toliman/period.h>
#include <toliman/period_sampling.h>

enum { kMost = 1000, kShards = 64, kSaveEvery = 100 };
static double times[kMost], values[kMost], sigmas[kMost];

enum kind { SPREAD, CLUSTERS, TWICE, REGULAR };

typedef struct {
    const char *name;
    size_t n;
    double t0, span, mean, amplitude, cycles, f0, df;
    int64_t nf;
    double weight_range; /* largest weight over smallest */
    enum kind kind;
    double value_offset;
    uint32_t flags;
    double atol; /* where the header allows more than 1e-12 of the power, or 1e-14 */
} hard_case;

static const hard_case cases[] = {
    {"benign", 1000, 0, 1000, 0, 1, 37.3, 0.0015, 1e-4, 5000, 1, SPREAD, 0, 0, 0},
    {"julian dates", 300, 2451853.6, 4200, -20, 300, 8, 1e-4, 2e-5, 2000, 30, SPREAD, 0, 0, 0},
    {"unix seconds", 500, 1.7e9, 3e6, 0, 1e-6, 41, 1e-7, 1e-8, 3000, 1, SPREAD, 0, 0, 0},
    {"mean 1e9, amplitude 1e-3", 400, 0, 1000, 1e9, 1e-3, 12, 1e-3, 2e-4, 1000, 1, SPREAD, 1e9, 0, 0},
    {"mean 1e9, amplitude 1e-3, double-limb", 400, 0, 1000, 1e9, 1e-3, 12, 1e-3, 2e-4, 300, 1, SPREAD, 0,
     TOLIMAN_PERIOD_DOUBLE_LIMB, 0},
    {"two clusters", 400, 0, 10000, 3, 1, 100, 1e-3, 1e-5, 3000, 1, CLUSTERS, 0, 0, 0},
    {"three samples", 3, 0, 10, 3, 1, 1.3, 0.03, 0.011, 100, 4, SPREAD, 0, 0, 0},
    {"duplicate times", 200, 0, 100, 0, 1, 7, 0.01, 0.002, 800, 1, TWICE, 0, 0, 0},
    {"through the pseudo-Nyquist frequency", 300, 0, 300, 0, 1, 33, 0.3, 0.001, 400, 1, REGULAR, 0, 0, 0},
    {"weights over 1e12", 400, 0, 400, 0, 1, 20, 0.003, 0.0005, 1500, 1e12, SPREAD, 0, 0, 0},
    {"1e7 cycles", 300, 0, 1e7, 0, 1, 1e7 - 0.5, 0.9999, 1e-7, 2000, 1, SPREAD, 0, 0, 0},
    {"f T = 0.3", 300, 0, 300, 0, 1, 0.5, 0.001, 0.0001, 50, 1, SPREAD, 0, 0, 0},
    {"f T = 0.005", 300, 0, 300, 0, 1, 0.5, 1.7e-5, 1e-7, 50, 1, SPREAD, 0, 0, 1.6e-8},
    {"f T = 0.005, double-limb", 300, 0, 300, 0, 1, 0.5, 1.7e-5, 1e-7, 50, 1, SPREAD, 0, TOLIMAN_PERIOD_DOUBLE_LIMB, 0},
    {"f T = 3e-5, double-limb", 300, 0, 300, 0, 1, 0.5, 1e-7, 1e-9, 50, 1, SPREAD, 0, TOLIMAN_PERIOD_DOUBLE_LIMB, 0},
    {"mean 1e5 sigmas from the offset", 300, 0, 300, 1e5, 1, 11, 0.004, 0.0004, 1000, 1, SPREAD, 0, 0, 4e-12},
};
enum { kCases = sizeof cases / sizeof cases[0] };

static toliman_period *make(const hard_case *c, const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(c->f0, c->df, c->nf, options, &period));
    return period;
}

/* Samples of the case, and suitable options. */
static toliman_period_options fill(const hard_case *c, int fixed_mean) {
    uint64_t state = 20u + (uint64_t)c->n;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = c->flags | (fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0);
    options.time_offset = c->t0;
    options.value_offset = c->value_offset;
    if (c->mean - c->value_offset > 1e6)
        options.value_bound = 2 * c->mean;
    options.sigma_floor = 1e300;
    for (size_t i = 0; i < c->n; i++) {
        double u = c->kind == REGULAR ? (double)i / (double)c->n : uniform(&state);
        if (c->kind == CLUSTERS)
            u = i < c->n / 2 ? u * 0.02 : 0.98 + u * 0.02;
        if (c->kind == TWICE && i % 2 == 1)
            u = (times[i - 1] - c->t0) / c->span;
        times[i] = c->t0 + c->span * u;
        values[i] = c->mean + c->amplitude * (sin(2 * M_PI * c->cycles * u + 0.7) + 0.7 * noise(&state));
        sigmas[i] = c->amplitude * pow(c->weight_range, 0.5 * uniform(&state));
        options.sigma_floor = fmin(options.sigma_floor, sigmas[i]);
        options.sigma_ceiling = fmax(options.sigma_ceiling, sigmas[i]);
    }
    return options;
}

/* Compares the two lowest frequencies and eight others across the grid. */
/* promise: power-error-is-bounded */
TEST(power_matches_113_bits) {
    for (int i = 0; i < 2 * kCases; i++) {
        const hard_case *c = &cases[i / 2];
        const int fixed_mean = i % 2;
        const toliman_period_options options = fill(c, fixed_mean);
        toliman_period *period = make(c, &options);
        assert_ok(toliman_period_push_many(period, times, values, sigmas, c->n));
        const quad_samples samples = {times, values, sigmas, c->n, NULL};
        double *power = malloc((size_t)c->nf * sizeof *power);
        assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, (size_t)c->nf, power));
        for (int64_t k = 0; k < c->nf; k += k == 0 ? 1 : c->nf / 8) {
            const quad f = (quad)c->f0 + (quad)k * (quad)c->df;
            const double expected = (double)(1 - quad_residual(&samples, f, fixed_mean));
            const double error = fabs(power[k] - expected), allowed = fmax(1e-12 * expected, 1e-14);
            if (!(error <= fmax(allowed, c->atol)))
                fail_msg("%s, %s mean, frequency %d: power %.17g is wrong by %.2e", c->name,
                         fixed_mean ? "fixed" : "floating", (int)k, expected, error);
        }
        free(power), toliman_period_destroy(period);
    }
}

static void push(toliman_period *period, size_t i) {
    assert_ok(toliman_period_push(period, times[i], values[i], sigmas[i]));
}

static unsigned char bytes_a[1 << 20], bytes_b[1 << 20];

static void assert_same_bytes(const toliman_period *a, const toliman_period *b, const char *name, const char *way) {
    size_t size_a, size_b;
    assert_ok(toliman_period_save(a, bytes_a, sizeof bytes_a, &size_a));
    assert_ok(toliman_period_save(b, bytes_b, sizeof bytes_b, &size_b));
    if (size_a != size_b || memcmp(bytes_a, bytes_b, size_a) != 0)
        fail_msg("%s: other bytes after %s", name, way);
}

static void saved_and_loaded(toliman_period **period) {
    size_t size;
    assert_ok(toliman_period_save(*period, bytes_a, sizeof bytes_a, &size));
    toliman_period_destroy(*period);
    *period = NULL;
    assert_ok(toliman_period_load(bytes_a, size, NULL, period));
}

/* The samples are shuffled; pushed to 64 shards that are merged; mixed with as many samples that are retracted; saved
 * and loaded in between. */
/* promises: any-order-gives-same-bits, merged-shards-give-same-bits, retractions-are-exact */
TEST(state_does_not_depend_on_the_order) {
    for (int which = 0; which < kCases; which++) {
        const hard_case *c = &cases[which];
        const toliman_period_options options = fill(c, 0);
        toliman_period *straight = make(c, &options), *shuffled = make(c, &options), *undone = make(c, &options);
        toliman_period *resumed = make(c, &options), *shards[kShards];
        for (int s = 0; s < kShards; s++)
            shards[s] = make(c, &options);
        uint64_t state = 5;
        size_t order[kMost];
        for (size_t i = 0; i < c->n; i++)
            order[i] = i;
        for (size_t i = c->n - 1; i > 0; i--) {
            const size_t j = (size_t)(uniform(&state) * (double)(i + 1)), swap = order[i];
            order[i] = order[j];
            order[j] = swap;
        }
        for (size_t i = 0; i < c->n; i++) {
            push(straight, i);
            push(shuffled, order[i]);
            push(undone, i);
            assert_ok(toliman_period_push(undone, times[i] + 0.1, values[order[i]], sigmas[i]));
            push(resumed, i);
            if (i % kSaveEvery == kSaveEvery - 1)
                saved_and_loaded(&resumed);
            push(shards[(size_t)(uniform(&state) * kShards)], order[i]);
        }
        for (size_t i = 0; i < c->n; i++)
            assert_ok(retract(undone, times[order[i]] + 0.1, values[order[order[i]]], sigmas[order[i]]));
        for (int s = 1; s < kShards; s++)
            assert_ok(toliman_period_merge(shards[0], shards[s]));
        assert_same_bytes(straight, shuffled, c->name, "another order");
        assert_same_bytes(straight, undone, c->name, "pushing as many again and removing them");
        assert_same_bytes(straight, resumed, c->name, "saving and loading at every 100th sample");
        assert_same_bytes(straight, shards[0], c->name, "merging 64 shards");
        double *power = malloc((size_t)c->nf * sizeof *power), *again = malloc((size_t)c->nf * sizeof *again);
        assert_ok(toliman_period_query_power(straight, TOLIMAN_PERIOD_POWER_STANDARD, 0, (size_t)c->nf, power));
        const toliman_period *others[] = {shuffled, undone, resumed, shards[0]};
        for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) { /* folded or not, the power has the same bits */
            assert_ok(toliman_period_query_power(others[i], TOLIMAN_PERIOD_POWER_STANDARD, 0, (size_t)c->nf, again));
            assert_memory_equal(power, again, (size_t)c->nf * sizeof *power);
        }
        free(power), free(again);
        toliman_period_destroy(straight), toliman_period_destroy(shuffled), toliman_period_destroy(undone);
        toliman_period_destroy(resumed);
        for (int s = 0; s < kShards; s++)
            toliman_period_destroy(shards[s]);
    }
}

/* (1 + m) N/(W l) of the header, by plain sums. */
static double loss_of(size_t n, double f) {
    double w = 0, c = 0, s = 0, y = 0, yy = 0, cc = 0, cs = 0, ss = 0;
    for (size_t i = 0; i < n; i++) {
        const double part = 1 / (sigmas[i] * sigmas[i]), angle = 2 * M_PI * remainder(f * (times[i] - times[0]), 1);
        w += part, c += part * cos(angle), s += part * sin(angle), y += part * values[i];
    }
    for (size_t i = 0; i < n; i++) {
        const double part = 1 / (sigmas[i] * sigmas[i] * w);
        const double angle = 2 * M_PI * remainder(f * (times[i] - times[0]), 1);
        const double u = cos(angle) - c / w, v = sin(angle) - s / w, z = values[i] - y / w;
        cc += part * u * u, cs += part * u * v, ss += part * v * v, yy += part * z * z;
    }
    const double large = (cc + ss) / 2 + hypot((cc - ss) / 2, cs), small = (cc * ss - cs * cs) / large;
    return (1 + fabs(y / w) / sqrt(yy)) * (double)n / (w * small);
}

/* Few and many samples, equal sigmas and sigmas up to the ceiling, short nights, even times near their aliases, values
 * far from the offset: the error is within the header's bound, and where it exceeds 1e-9 the sampling diagnostics flag
 * it. */
/* promise: power-error-is-bounded */
TEST(power_is_within_the_documented_bound) {
    uint64_t state = 77;
    for (int draw = 0; draw < 600; draw++) {
        static const size_t sizes[] = {5, 8, 20, 100};
        static const double means[] = {0, 10, 1e5};
        const size_t n = sizes[(int)(4 * uniform(&state))];
        const double mean = means[(int)(3 * uniform(&state))], night = pow(10, -3 + 2 * uniform(&state));
        const int cadence = (int)(3 * uniform(&state)), weights = (int)(3 * uniform(&state));
        const double f = cadence == 2 ? 1 + pow(10, -4 + 3 * uniform(&state)) : pow(10, -4 + 3.5 * uniform(&state));
        for (size_t i = 0; i < n; i++) {
            times[i] = cadence == 0   ? 300 * uniform(&state)
                       : cadence == 1 ? 1000 * (double)(i % 3) + night * uniform(&state)
                                      : (double)i;
            values[i] = mean + noise(&state);
            sigmas[i] = weights == 0 ? 1 : weights == 1 ? 32 : 1 + 31 * uniform(&state);
        }
        const quad_samples samples = {times, values, sigmas, n, NULL};
        const double expected = (double)(1 - quad_residual(&samples, f, 0)), loss = loss_of(n, f);
        for (uint32_t double_limb = 0; double_limb < 2; double_limb++) {
            toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
            options.flags = double_limb ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0;
            toliman_period *period = NULL;
            toliman_period_sampling sampling = {.struct_size = sizeof sampling};
            double power;
            assert_ok(toliman_period_create(f, 1, 1, &options, &period));
            assert_ok(toliman_period_push_many(period, times, values, sigmas, n));
            assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 1, &power));
            assert_ok(toliman_period_query_sampling(period, times, n, &sampling));
            const double error = fabs(power - expected),
                         bound = (double_limb ? 1e-13 : 2e-15) + (double_limb ? 1e-28 : 4e-15) * loss;
            if (!(error <= bound))
                fail_msg("draw %d, double-limb %u: error %.2e, bound %.2e", draw, double_limb, error, bound);
            if (error > 1e-9 && (sampling.flags & TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB) == 0)
                fail_msg("draw %d: wrong by %.2e, and not flagged", draw, error);
            assert_true(!double_limb || (sampling.flags & TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB) == 0);
            toliman_period_destroy(period);
        }
    }
}

/* A million samples against sums in long double with exact phases. */
/* promise: long-streams-stay-exact */
TEST(million_samples) { /* in make long */
    enum { kFrequencies = 12 };
    const int many = in_long() ? 1000000 : 200000;
    const double f0 = 1e-3, df = 0.045;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(f0, df, kFrequencies, NULL, &period));
    long double sums[3][9] = {{0}}, total = 0, square = 0;
    const int64_t at[3] = {1, 4, 11};
    uint64_t state = 31;
    for (int i = 0; i < many; i++) {
        const double t = i + uniform(&state), y = 1e-3 * sin(2 * M_PI * 0.183 * t) + 3 + 1e-2 * noise(&state);
        assert_ok(toliman_period_push(period, t, y, 1));
        const long double v = y - 3.0L;
        total += v, square += v * v;
        for (int q = 0; q < 3; q++) {
            const quad cycles = ((quad)f0 + (quad)at[q] * (quad)df) * t;
            const long double angle = 6.283185307179586476925286766559L * (long double)(cycles - rintq(cycles));
            const long double c = cosl(angle), s = sinl(angle), row[9] = {c, s, c * c, c * s, s * s, v * c, v * s};
            for (int j = 0; j < 7; j++)
                sums[q][j] += row[j];
        }
    }
    for (int q = 0; q < 3; q++) {
        const long double n = many, c = sums[q][0] / n, s = sums[q][1] / n, cc = sums[q][2] / n - c * c;
        const long double cs = sums[q][3] / n - c * s, ss = sums[q][4] / n - s * s;
        const long double yc = sums[q][5] / n - total / n * c, ys = sums[q][6] / n - total / n * s;
        const long double expected = (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / (cc * ss - cs * cs) /
                                     (square / n - total / n * (total / n));
        double power;
        assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, at[q], 1, &power));
        assert_close(power, (double)expected, 1e-12, 1e-14);
    }
    toliman_period_destroy(period);
}

RUN_TESTS(NULL, NULL)
