/* Tests the choice among aliases and their list: against the window function and powers by plain loops. */
#include <stdlib.h>
#include <string.h>

#include <toliman/period_sampling.h>

#include "assert_close.h"

enum { DAYS = 1095, MOST = 4000, LISTED = 16 };
static double t[MOST], y[MOST];

static double uniform(uint64_t *random) {
    *random = *random * 6364136223846793005u + 1442695040888963407u;
    return (double)(*random >> 11) * 0x1p-53;
}

/* Samples every `step` d, scattered by up to `scatter`, of nights in the first `season` days of each year. */
static int sample(double step, double scatter, double season, double period, double slope) {
    uint64_t random = 5;
    int n = 0;
    for (int i = 0; i * step < DAYS; i++) {
        const double at = i * step + scatter * (uniform(&random) - 0.5);
        const double noise = uniform(&random) + uniform(&random) + uniform(&random) - 1.5;
        if (uniform(&random) < 0.1 || fmod(at, 365.25) > season)
            continue;
        t[n] = at;
        y[n++] = (period > 0 ? 2 * sin(2 * M_PI * at / period + 1) : 0) + slope * at * at + noise;
    }
    return n;
}

static double window(int n, double frequency) {
    double c = 0, s = 0;
    for (int i = 0; i < n; i++) {
        c += cos(2 * M_PI * frequency * t[i]);
        s += sin(2 * M_PI * frequency * t[i]);
    }
    return (c * c + s * s) / ((double)n * n);
}

/* The fraction of the variance that a sinusoid with a mean explains, by least squares. */
static double power_at(int n, double frequency) {
    double c = 0, s = 0, mean = 0, cc = 0, ss = 0, cs = 0, yc = 0, ys = 0, yy = 0;
    for (int i = 0; i < n; i++) {
        c += cos(2 * M_PI * frequency * t[i]) / n;
        s += sin(2 * M_PI * frequency * t[i]) / n;
        mean += y[i] / n;
    }
    for (int i = 0; i < n; i++) {
        const double u = cos(2 * M_PI * frequency * t[i]) - c, v = sin(2 * M_PI * frequency * t[i]) - s;
        cc += u * u, ss += v * v, cs += u * v;
        yc += u * (y[i] - mean), ys += v * (y[i] - mean), yy += (y[i] - mean) * (y[i] - mean);
    }
    return (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / ((cc * ss - cs * cs) * yy);
}

/* The highest power within 1/T of a frequency, in steps of 0.01/T; 0 if it is not within 0.9/T. */
static double highest_power(int n, double frequency) {
    double highest = 0;
    int at = 0;
    for (int k = -100; k <= 100; k++) {
        const double power = power_at(n, frequency + 0.01 * k / DAYS);
        if (power > highest)
            highest = power, at = k;
    }
    return abs(at) < 90 ? highest : 0;
}

static toliman_period *pushed(int n, double last, double unit_ns) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    toliman_period *period = NULL;
    options.unit_ns = unit_ns;
    options.value_bound = 1024;
    options.flags = TOLIMAN_PERIOD_DOUBLE_LIMB;
    const int64_t nf = (int64_t)(last / (0.1 / DAYS)) - 14;
    assert_ok(toliman_period_create(1.5 / DAYS, 0.1 / DAYS, nf, &options, &period));
    assert_ok(toliman_period_push_many(period, t, y, NULL, (size_t)n));
    return period;
}

static const struct {
    const char *name;
    double step, scatter, season, period, slope; /* of the samples */
    double last, unit_ns;                        /* of the grid */
    double shown;                                /* period of the peak; 0: that of the sampling */
    int32_t kind;                                /* of an alias */
    double interval, alias;                      /* its interval and period */
} cases[] = {{"frames every 3 d", 3, 0.05, 366, 220, 0, 0.5, 86400e9, 220, TOLIMAN_PERIOD_INTERVAL_SAMPLING, 3, 3.0415},
             {"frames every 3 d, in s", 3, 0.05, 366, 220, 0, 0.5, 0, 220, TOLIMAN_PERIOD_INTERVAL_SAMPLING, 3, 2.9596},
             {"short period, scattered times", 3, 2, 366, 2.7, 0, 0.5, 86400e9, 2.7, 0, 0, 0},
             {"nights", 1, 0.2, 366, 9, 0, 2.5, 86400e9, 9, TOLIMAN_PERIOD_INTERVAL_SOLAR_DAY, 1, 1.125},
             {"sidereal nights", 0.99726957, 0.1, 366, 9, 0, 2.5, 86400e9, 9, TOLIMAN_PERIOD_INTERVAL_SIDEREAL_DAY,
              0.99726957, 1.12159},
             {"seasons", 1, 0.9, 180, 60, 0, 0.4, 86400e9, 60, TOLIMAN_PERIOD_INTERVAL_YEAR, 365.25, 71.791},
             {"slow change", 0.99726957, 0.1, 366, 0, 2e-5, 2.5, 86400e9, 0, TOLIMAN_PERIOD_INTERVAL_SIDEREAL_DAY,
              0.99726957, 0}};

/* promise: longest-alias-is-shown */
TEST(choice_and_list) {
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const int n = sample(cases[c].step, cases[c].scatter, cases[c].season, cases[c].period, cases[c].slope);
        toliman_period *period = pushed(n, cases[c].last, cases[c].unit_ns);
        toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT, fit = TOLIMAN_PERIOD_PEAK_INIT;
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_ok(toliman_period_query_fit(period, t, y, NULL, NULL, (size_t)n, &fit));
        if (cases[c].shown > 0 &&
            (fabs(peak.period / cases[c].shown - 1) > 0.02 || fabs(fit.period / peak.period - 1) > 0.02))
            fail_msg("%s: period %g, fit %g", cases[c].name, peak.period, fit.period);
        const double at = cases[c].shown > 0 ? peak.frequency : 1 / 0.99726957 + 0.6 / DAYS;
        toliman_period_alias aliases[LISTED];
        aliases[0].struct_size = sizeof *aliases;
        size_t count = 0;
        assert_ok(toliman_period_query_aliases(period, at, aliases, LISTED, &count));
        int found = cases[c].kind == 0;
        for (size_t i = 0; i < count; i++) {
            const toliman_period_alias *alias = aliases + i;
            assert_int_equal(alias->struct_size, sizeof *alias);
            assert_true(alias->window >= 0.1 && alias->window <= 1.0001);
            assert_true(i == 0 || alias->window <= alias[-1].window);
            assert_close(alias->window, window(n, 1 / alias->interval), 0, 0.1);
            assert_close(alias->period * alias->frequency, 1, 1e-12, 0);
            const double power = i < 3 && alias->power > 0.01 ? highest_power(n, alias->frequency) : 0;
            if (power > 0) /* of a parabola through three powers of the grid */
                assert_close(alias->power, power, 1e-3, 0);
            found |=
                alias->interval_kind == cases[c].kind && fabs(alias->interval / cases[c].interval - 1) < 1e-3 &&
                (cases[c].alias > 0 ? fabs(alias->period / cases[c].alias - 1) < 0.03 : alias->slow && alias->equal);
        }
        if (!found)
            fail_msg("%s: %zu aliases, the first at %g", cases[c].name, count, count > 0 ? aliases[0].period : 0);
        toliman_period_destroy(period);
    }
}

/* Neither order nor shards change the choice. */
TEST(choice_does_not_depend_on_order) {
    const int n = sample(3, 0.02, 366, 300, 0);
    toliman_period *whole = pushed(n, 0.5, 86400e9), *half = pushed(n / 2, 0.5, 86400e9), *other = NULL;
    for (int i = 0; i < n / 2; i++) { /* in reverse order */
        const double time = t[i], value = y[i];
        t[i] = t[n - 1 - i];
        y[i] = y[n - 1 - i];
        t[n - 1 - i] = time;
        y[n - 1 - i] = value;
    }
    other = pushed(n - n / 2, 0.5, 86400e9);
    assert_ok(toliman_period_merge(half, other));
    toliman_period_peak one = TOLIMAN_PERIOD_PEAK_INIT, two = TOLIMAN_PERIOD_PEAK_INIT;
    assert_ok(toliman_period_query_peak(whole, &one));
    assert_ok(toliman_period_query_peak(half, &two));
    assert_true(one.frequency == two.frequency && one.power == two.power);
    assert_close(one.period, 300, 0.03, 0);
    toliman_period_peak peaks[5];
    peaks[0].struct_size = sizeof *peaks;
    size_t count = 0;
    assert_ok(toliman_period_query_peaks(whole, peaks, 5, &count));
    assert_true(count == 5 && peaks[0].frequency == one.frequency && (peaks[0].flags & TOLIMAN_PERIOD_ALIAS) == 0);
    for (size_t i = 1; i < 3; i++)
        assert_true((peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0 && peaks[i].power > 0.9 * peaks[0].power);
    toliman_period_destroy(whole), toliman_period_destroy(half), toliman_period_destroy(other);
}

TEST(invalid_arguments_are_refused) {
    toliman_period *period = pushed(sample(3, 0.02, 366, 300, 0), 0.5, 86400e9);
    toliman_period_alias aliases[2] = {TOLIMAN_PERIOD_ALIAS_INIT};
    size_t count = 9;
    assert_invalid(toliman_period_query_aliases(period, 0.6, aliases, 2, &count), "frequency");
    assert_invalid(toliman_period_query_aliases(period, NAN, aliases, 2, &count), "frequency");
    assert_invalid(toliman_period_query_aliases(period, 0.1, NULL, 2, &count), "aliases");
    toliman_period_destroy(period);
    period = pushed(0, 0.5, 86400e9);
    assert_refused(toliman_period_query_aliases(period, 0.1, aliases, 2, &count), TOLIMAN_E_STATE, "");
    assert_int_equal(count, 9);
    toliman_period_destroy(period);
}

RUN_TESTS(NULL, NULL)
