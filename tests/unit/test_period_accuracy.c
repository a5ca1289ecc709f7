/* Tests the error bound of include/toliman/period.h where cosine and sine nearly coincide, and the flag that reports a
 * large bound, against 113-bit arithmetic. */
#include <string.h>

#include "assert_close.h"
#include "quad_period.h"
#include "uniform.h"

#include <toliman/period.h>
#include <toliman/period_sampling.h>

enum { kMost = 400 };
static double times[kMost], values[kMost];

typedef struct {
    double eigenvalue, away; /* smaller eigenvalue of the covariance of cosine and sine; m of the bound */
} quad_properties;

static quad_properties properties_of(const quad_samples *s, quad f, double value_offset) {
    quad c = 0, s1 = 0, cc = 0, cs = 0, ss = 0, mean = 0, square = 0, middle = 0;
    const quad n = (quad)s->n;
    for (size_t i = 0; i < s->n; i++)
        middle += s->t[i] / n;
    for (size_t i = 0; i < s->n; i++) {
        const quad angle = 2 * M_PIq * f * (s->t[i] - middle), x = cosq(angle), y = sinq(angle);
        c += x / n, s1 += y / n, cc += x * x / n, cs += x * y / n, ss += y * y / n;
        mean += (s->y[i] - value_offset) / n;
        square += (quad)(s->y[i] - value_offset) * (s->y[i] - value_offset) / n;
    }
    cc -= c * c, cs -= c * s1, ss -= s1 * s1;
    const quad large = (cc + ss) / 2 + sqrtq((cc - ss) * (cc - ss) / 4 + cs * cs);
    return (quad_properties){(double)((cc * ss - cs * cs) / large), (double)fabsq(mean / sqrtq(square - mean * mean))};
}

/* The bound of the header, for samples of equal sigma. */
static double bound_of(const quad_properties *properties, int double_limb) {
    const double l = properties->eigenvalue, narrow = 4e-15 * (1 + properties->away) / l;
    return double_limb ? 1e-13 + 6e-16 / sqrt(l) + 1e-28 * (1 + properties->away) / l : 2e-15 + narrow;
}

static toliman_period *filled(double f0, double df, int64_t nf, uint32_t flags, double time_offset, size_t n) {
    toliman_period *period = NULL;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = flags;
    options.time_offset = time_offset;
    options.value_bound = 8;
    assert_ok(toliman_period_create(f0, df, nf, &options, &period));
    assert_ok(toliman_period_push_many(period, times, values, NULL, n));
    return period;
}

static void even_times(size_t n) {
    uint64_t state = 3;
    for (size_t i = 0; i < n; i++) {
        times[i] = (double)i;
        values[i] = sin(0.9 * (double)i) + 0.3 * noise(&state);
    }
}

/* Two groups of samples, each within `width` of one of two instants one unit apart. */
static void two_clusters(size_t n, double width) {
    uint64_t state = 4;
    for (size_t i = 0; i < n; i++) {
        times[i] = (double)(i % 2) + width * uniform(&state);
        values[i] = 0.4 * (double)(i % 2) + noise(&state);
    }
}

static double double_limb_power(double f, size_t n, double *bound, double *expected) {
    const quad_samples samples = {times, values, NULL, n, NULL};
    const quad_properties properties = properties_of(&samples, f, 0);
    *bound = bound_of(&properties, 1);
    *expected = (double)(1 - quad_residual(&samples, f, 0));
    toliman_period *period = filled(f, 1e-3, 1, TOLIMAN_PERIOD_DOUBLE_LIMB, times[0], n);
    toliman_period_model model = {.struct_size = sizeof model};
    double power;
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 1, &power));
    assert_ok(toliman_period_query_model(period, 0, &model));
    assert_int_equal(model.rank, 2);
    assert_int_equal(model.flags, 0);
    assert_close(model.power, power, 0, 0);
    assert_true(isfinite(model.amplitude_error) && isfinite(model.phase_error) && isfinite(model.offset_error));
    toliman_period_destroy(period);
    return power;
}

/* promise: power-error-is-bounded */
TEST(double_limb_sums_are_accurate_near_coincidence) {
    double bound, expected;
    even_times(256);
    for (int k = 9; k <= 14; k++) {
        const double power = double_limb_power(0.5 - pow(10, -k), 256, &bound, &expected);
        assert_true(bound < 1e-3);
        assert_close(power, expected, 0, bound);
    }
    for (double width = 1e-5; width > 1e-9; width /= 10) {
        two_clusters(200, width);
        const double power = double_limb_power(0.83, 200, &bound, &expected);
        assert_true(bound < 1e-3);
        assert_close(power, expected, 0, bound);
    }
}

/* One night: from 3e-6 of a cycle to one and a half in steps of a factor 1.25, each with its own grid. */
/* promise: inaccurate-powers-are-flagged */
TEST(inaccurate_powers_are_flagged) {
    enum { kSamples = 60 };
    const double first = 2460000.3, span = 0.35;
    uint64_t state = 5;
    int flagged = 0, wrong = 0;
    for (int i = 0; i < kSamples; i++) {
        times[i] = first + span * ((double)i + uniform(&state)) / kSamples;
        values[i] = sin(4 * (times[i] - first)) + 0.1 * noise(&state);
    }
    const quad_samples samples = {times, values, NULL, kSamples, NULL};
    for (double cycles = 3e-6; cycles < 1.5; cycles *= 1.25) {
        const double f = cycles / span;
        toliman_period *period = filled(f, f, 1, 0, first, kSamples);
        toliman_period_peak peak = {.struct_size = sizeof peak}, peaks = peak, fit = peak;
        toliman_period_model model = {.struct_size = sizeof model};
        toliman_period_sampling sampling = {.struct_size = sizeof sampling};
        size_t count;
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_ok(toliman_period_query_peaks(period, &peaks, 1, &count));
        assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, kSamples, &fit));
        assert_ok(toliman_period_query_model(period, 0, &model));
        assert_ok(toliman_period_query_sampling(period, NULL, 0, &sampling));
        const int inaccurate = (sampling.flags & TOLIMAN_PERIOD_INACCURATE) != 0;
        assert_int_equal((peak.flags & TOLIMAN_PERIOD_INACCURATE) != 0, inaccurate);
        assert_int_equal((peaks.flags & TOLIMAN_PERIOD_INACCURATE) != 0, inaccurate);
        assert_int_equal((fit.flags & TOLIMAN_PERIOD_INACCURATE) != 0, inaccurate);
        assert_int_equal((model.flags & TOLIMAN_PERIOD_INACCURATE) != 0, inaccurate);
        const quad_properties properties = properties_of(&samples, f, 0);
        const double bound = bound_of(&properties, 0), expected = (double)(1 - quad_residual(&samples, f, 0));
        if (fabs(log(bound / 1e-3)) > 0.01) /* the eigenvalue itself has the error of the sums */
            assert_int_equal(inaccurate, bound > 1e-3);
        if (!inaccurate)
            assert_close(peak.power, expected, 0, bound);
        flagged += inaccurate;
        wrong += fabs(peak.power - expected) > 1e-3;
        toliman_period_destroy(period);
    }
    assert_true(wrong > 5 && flagged >= wrong && flagged < 40);
}

/* Half a thousandth of a cycle is too short for single-limb accumulators; double-limb ones fail if all times are equal.
 */
/* promise: inaccurate-powers-are-flagged */
TEST(double_limb_sums_are_flagged_later) {
    two_clusters(200, 0.1);
    for (int double_limb = 0; double_limb < 2; double_limb++) {
        toliman_period *period = filled(1e-3, 1e-3, 50, double_limb ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0, 0, 200);
        toliman_period_sampling sampling = {.struct_size = sizeof sampling};
        assert_ok(toliman_period_query_sampling(period, times, 200, &sampling));
        assert_int_equal((sampling.flags & TOLIMAN_PERIOD_INACCURATE) != 0, !double_limb);
        toliman_period_destroy(period);
    }
    for (int i = 0; i < 20; i++)
        times[i] = 3;
    toliman_period *once = filled(1e-3, 1e-3, 50, TOLIMAN_PERIOD_DOUBLE_LIMB, 0, 20);
    toliman_period_sampling sampling = {.struct_size = sizeof sampling};
    assert_ok(toliman_period_query_sampling(once, NULL, 0, &sampling));
    assert_true((sampling.flags & TOLIMAN_PERIOD_INACCURATE) != 0);
    toliman_period_destroy(once);
}

/* Nights over years, and an even series whose grid ends at 1/(2 step): single-limb accumulators are accurate enough for
 * both. */
TEST(well_sampled_series_are_not_flagged) {
    uint64_t state = 6;
    for (int even = 0; even < 2; even++) {
        const size_t n = even ? 256 : kMost;
        const double first = even ? 0 : 2451853.6, span = even ? 256 : 4200;
        even_times(n);
        for (size_t i = 0; i < n && !even; i++)
            times[i] = first + floor(span * ((double)i + uniform(&state)) / (double)n) + 0.2 * uniform(&state);
        toliman_period *period = filled(1.5 / span, 0.1 / span, (int64_t)(5 * n) - 14, 0, first, n);
        for (int given = 0; given < 2; given++) {
            toliman_period_sampling sampling = {.struct_size = sizeof sampling};
            assert_ok(toliman_period_query_sampling(period, given ? times : NULL, n, &sampling));
            assert_int_equal(sampling.flags & TOLIMAN_PERIOD_INACCURATE, 0);
        }
        toliman_period_peak peaks[8];
        for (int i = 0; i < 8; i++)
            peaks[i].struct_size = sizeof peaks[i];
        size_t count;
        assert_ok(toliman_period_query_peaks(period, peaks, 8, &count));
        for (size_t i = 0; i < count; i++)
            assert_int_equal(peaks[i].flags & TOLIMAN_PERIOD_INACCURATE, 0);
        toliman_period_destroy(period);
    }
}

RUN_TESTS(NULL, NULL)
