/* Tests false alarm probabilities: the alarm rate on noise, thresholds, the bootstrap, and sampling diagnostics. */
#include <stdlib.h>
#include <string.h>

#include <toliman/period_sampling.h>

#include "fap_trials.h"

enum { baluev, naive, single, sequential, METHODS };
enum { DAYS = 200, MOST = 400 };
static double times[MOST], values[MOST], sigmas[MOST];

/* The trials of the benchmark on shorter series. */
/* promise: sequential-alarms-are-rare */
TEST(alarm_rate_is_as_documented) {
    const int ends = in_long() ? 2500 : 1000, streams = in_long() ? 200 : 100;
    toliman_period *const period = fap_periodogram(DAYS);
    int at_end[FAP_METHODS] = {0}, ever[FAP_METHODS] = {0};
    for (uint64_t i = 0; i < (uint64_t)ends; i++) {
        double log10_fap[FAP_METHODS];
        fap_at_end(period, DAYS, i, log10_fap);
        for (int m = 0; m < FAP_METHODS; m++)
            at_end[m] += log10_fap[m] <= -2;
    }
    for (uint64_t i = 0; i < (uint64_t)streams; i++) {
        int first[FAP_METHODS];
        fap_watch(period, DAYS, 1000000u + i, (fap_signal){0, 1, 0}, 0.01, first);
        for (int m = 0; m < FAP_METHODS; m++)
            ever[m] += first[m] != FAP_NEVER;
    }
    print_message("alarms at 0.01 of %d, of %d streams:\n", ends, streams);
    for (int m = 0; m < FAP_METHODS; m++)
        print_message("  %s %d, %d\n", fap_names[m], at_end[m], ever[m]);
    assert_in_range(at_end[0], 0.005 * ends, 0.012 * ends);
    assert_in_range(at_end[1], 0.02 * ends, 0.05 * ends);
    assert_true(ever[0] > 0.1 * streams); /* the reason for the sequential method */
    assert_true(ever[2] <= 0.02 * streams);
    toliman_period_destroy(period);
}

/* The chapter's signal of 1e-6 px, with a standard error of 1.24e-6 px per frame: the sequential method must not need
 * many more samples. */
TEST(sequential_finds_signals) {
    enum { SERIES = 51, SIGNAL_DAYS = 280 };
    static int found[FAP_METHODS][SERIES];
    toliman_period *const period = fap_periodogram(1095);
    for (int i = 0; i < SERIES; i++) {
        int first[FAP_METHODS];
        fap_watch(period, SIGNAL_DAYS, 5000000u + (uint64_t)i, (fap_signal){1 / 1.24, 365, 0.4}, 0.01, first);
        for (int m = 0; m < FAP_METHODS; m++)
            found[m][i] = first[m];
    }
    const int once = fap_median(found[0], SERIES), often = fap_median(found[2], SERIES);
    print_message("median samples until found: Baluev %d, sequential %d\n", once, often);
    assert_true(often <= 1.25 * once);
    toliman_period_destroy(period);
}

static toliman_period *filled(int n) {
    toliman_period *const period = fap_periodogram(n);
    fap_noise noise = fap_seeded(7);
    for (int i = 0; i < n; i++) {
        times[i] = i;
        values[i] = fap_normal(&noise);
        sigmas[i] = 1 + i % 3;
    }
    assert_ok(toliman_period_push_many(period, times, values, sigmas, (size_t)n));
    return period;
}

/* Indexed by the number of the method. */
static double fap_of(const toliman_period *period, int32_t method, double log10_residual) {
    double result = NAN;
    assert_ok(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_BALUEV + method, log10_residual, &result));
    assert_true(isfinite(result) && result <= 0);
    return result;
}

/* From the power 1/(N - 3) on, no method's FAP ever rises with the power. One query counts less than many, one
 * frequency less than several. */
/* promise: faps-are-finite */
TEST(faps_fall) {
    const int counts[] = {5, 6, 10, 100, 101, 102, MOST};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        toliman_period *const period = filled(counts[c]);
        double before[METHODS] = {0};
        for (double residual = log10(1 - 1 / (counts[c] - 2.999)); residual > -4900; residual *= 1.01) {
            double fap[METHODS];
            for (int32_t m = 0; m < METHODS; m++) {
                fap[m] = fap_of(period, m, residual);
                assert_true(fap[m] <= before[m] + 1e-13);
                before[m] = fap[m];
            }
            assert_true(fap[single] <= fap[naive]);
            assert_true(fap[naive] <= fap[baluev] + 1e-13 || residual > -1 || counts[c] < 100);
            assert_true(fap[baluev] <= fap[sequential]);
        }
        for (int32_t m = 0; m < METHODS; m++)
            assert_true(fap_of(period, m, 0) == 0);
        toliman_period_destroy(period);
    }
}

TEST(thresholds_invert_the_fap) {
    const int counts[] = {5, 6, 30, MOST};
    const double faps[] = {0, -1e-9, -1e-3, -0.1, -0.3, -1, -2, -10, -300, -1e4, -1e5};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        toliman_period *const period = filled(counts[c]);
        for (int32_t m = 0; m < METHODS; m++) {
            double before = 0;
            for (size_t i = 0; i < sizeof faps / sizeof *faps; i++) {
                double level = NAN;
                if (faps[i] < fap_of(period, m, -4900)) {
                    assert_invalid(
                        toliman_period_query_threshold(period, TOLIMAN_PERIOD_FAP_BALUEV + m, faps[i], &level),
                        "log10_fap");
                    continue;
                }
                assert_ok(toliman_period_query_threshold(period, TOLIMAN_PERIOD_FAP_BALUEV + m, faps[i], &level));
                assert_close(fap_of(period, m, level), faps[i], 1e-10, 1e-10);
                assert_true(level <= before);
                before = faps[i] < -0.5 ? level : 0; /* close to 1 Baluev's bound is not monotonic */
            }
        }
        toliman_period_destroy(period);
    }
}

static double seen; /* last fraction passed to the progress callback */

static int32_t record_fraction(const char *stage, double fraction, void *user_data) {
    assert_string_equal(stage, "bootstrap");
    assert_true(fraction > 0 && fraction <= 1);
    seen = fraction;
    return user_data != NULL;
}

/* promise: threads-change-no-bit */
TEST(bootstrap_is_the_same_for_any_threads) {
    enum { COUNT = 60 };
    toliman_period *const period = filled(100);
    double alone[COUNT], three[COUNT], longer[2 * COUNT];
    toliman_period_bootstrap_options options = TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT;
    options.seed = 5;
    options.threads = 1;
    options.progress = record_fraction;
    seen = 0;
    assert_ok(toliman_period_query_bootstrap(period, times, values, sigmas, 100, &options, COUNT, alone));
    assert_true(seen == 1);
    options.threads = 3;
    assert_ok(toliman_period_query_bootstrap(period, times, values, sigmas, 100, &options, COUNT, three));
    assert_memory_equal(alone, three, sizeof alone);
    assert_ok(toliman_period_query_bootstrap(period, times, values, sigmas, 100, &options, 2 * COUNT, longer));
    for (int i = 0, j = 0; i < COUNT; i++, j++) { /* resampling i does not depend on the number of resamplings */
        while (j < 2 * COUNT && longer[j] != alone[i])
            j++;
        assert_true(j < 2 * COUNT);
        assert_true(alone[i] < 0 && (i == 0 || alone[i] >= alone[i - 1]));
    }
    options.seed = 6;
    assert_ok(toliman_period_query_bootstrap(period, times, values, sigmas, 100, &options, COUNT, three));
    assert_memory_not_equal(alone, three, sizeof alone);
    /* A cancelled bootstrap leaves its outputs unchanged. */
    options.progress_data = &options;
    assert_refused(toliman_period_query_bootstrap(period, times, values, sigmas, 100, &options, COUNT, alone),
                   TOLIMAN_E_CANCELLED, "");
    assert_memory_not_equal(alone, three, sizeof alone);
    toliman_period_destroy(period);
}

/* Five values of which four are equal: some resamplings are constant and have no power. */
TEST(bootstrap_of_few_distinct_values) {
    enum { COUNT = 200 };
    toliman_period *const period = fap_periodogram(50);
    const double t[5] = {0, 1, 3, 4, 9}, y[5] = {1, 1, 1, 1, 2};
    double peaks[COUNT];
    assert_ok(toliman_period_push_many(period, t, y, NULL, 5));
    assert_ok(toliman_period_query_bootstrap(period, t, y, NULL, 5, NULL, COUNT, peaks));
    int none = 0;
    for (int i = 0; i < COUNT; i++) {
        assert_true(isfinite(peaks[i]) && peaks[i] <= 0);
        none += peaks[i] == 0;
    }
    assert_in_range(none, 0.2 * COUNT, 0.45 * COUNT); /* (4/5)^5 = 0.328, and 1 in 3125 */
    toliman_period_destroy(period);
}

/* Just below the Nyquist frequency of even times the power is high; exactly at it, half of the model vanishes. A
 * parabola through this step would be unrelated to the power in between. */
TEST(no_parabola_over_a_step) {
    fap_noise noise = fap_seeded(11);
    for (int series = 0; series < 200; series++) {
        toliman_period *const period = fap_periodogram(1095);
        for (int i = 0; i < 5; i++) {
            times[i] = i;
            values[i] = fap_normal(&noise);
            assert_ok(toliman_period_push(period, times[i], values[i], 1));
        }
        toliman_period_peak peak = {.struct_size = sizeof peak}, fit = {.struct_size = sizeof fit};
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, 5, &fit));
        assert_close(peak.power, fit.power, 0, 1e-4);
        toliman_period_destroy(period);
    }
}

static toliman_period_sampling sampling_of(const toliman_period *period, const double *t, size_t n) {
    toliman_period_sampling sampling = {.struct_size = sizeof sampling};
    assert_ok(toliman_period_query_sampling(period, t, n, &sampling));
    return sampling;
}

TEST(sampling_flags_depend_on_the_times) {
    toliman_period *period = filled(MOST);
    for (int given = 0; given < 2; given++) {
        const toliman_period_sampling even = sampling_of(period, given ? times : NULL, given ? MOST : 0);
        const double span = given ? MOST : sqrt(12.0) * 114.61; /* the weights change the variance */
        assert_close(even.baseline, span, given ? 1e-15 : 0.02, 0);
        assert_close(even.coarsest_df, 0.2 / even.baseline, 1e-15, 0);
        assert_close(even.nyquist, 0.5, given ? 1e-15 : 0.02, 0);
        assert_close(even.independent, 0.5 * even.baseline, 1e-12, 0);
        assert_true((even.flags & TOLIMAN_PERIOD_COARSE) == 0);
        /* the grid ends at the ceiling, where cosine and sine coincide */
        assert_true(!given || even.flags == TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB);
    }
    toliman_period_destroy(period);

    /* Steps of 1 with one gap of 100: the median step gives the right limit, the mean step does not. */
    assert_ok(toliman_period_create(0.01, 0.01, 45, NULL, &period));
    for (int i = 0; i < 40; i++) {
        times[i] = i < 20 ? i : i + 100;
        assert_ok(toliman_period_push(period, times[i], i % 4, 1));
    }
    toliman_period_sampling gap = sampling_of(period, times, 40);
    assert_true(gap.baseline == 140 && gap.nyquist == 0.5 && gap.flags == TOLIMAN_PERIOD_COARSE);
    gap = sampling_of(period, NULL, 0);
    assert_true(gap.nyquist < 0.1 && gap.flags == (TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_ABOVE_NYQUIST));
    toliman_period_destroy(period);

    assert_ok(toliman_period_create(0.01, 0.01, 60, NULL, &period));
    toliman_period_sampling none = sampling_of(period, NULL, 0);
    assert_true(none.flags == 0 && none.baseline == 0 && isinf(none.nyquist) && isinf(none.coarsest_df));
    assert_true(none.independent == 1);
    const double same[2] = {3, 3};
    assert_ok(toliman_period_push_many(period, same, same, NULL, 2));
    none = sampling_of(period, same, 2);
    assert_true(none.flags == 0 && none.baseline == 0 && isinf(none.nyquist));
    assert_ok(toliman_period_push(period, 4, 0, 1));
    const double late[3] = {4, 3, 3};
    assert_true(sampling_of(period, late, 3).flags == TOLIMAN_PERIOD_ABOVE_NYQUIST);
    const double broken[3] = {4, NAN, 3};
    assert_invalid(toliman_period_query_sampling(period, broken, 3, &none), "t");
    assert_invalid(toliman_period_query_sampling(period, late, 2, &none), "n");
    toliman_period_destroy(period);
}

TEST(invalid_arguments_are_refused) {
    enum { BALUEV = TOLIMAN_PERIOD_FAP_BALUEV, SEQUENTIAL = TOLIMAN_PERIOD_FAP_SEQUENTIAL };
    toliman_period *const period = filled(100), *const empty = fap_periodogram(100);
    double out = 7, peaks[3];
    const struct {
        int32_t method;
        double given;
        const char *of_fap, *of_threshold; /* fields */
    } cases[] = {{115, -1, "method", "method"},
                 {110, -1, "method", "method"},
                 {BALUEV, NAN, "log10_residual", "log10_fap"},
                 {BALUEV, 1, "log10_residual", "log10_fap"},
                 {BALUEV, -INFINITY, "log10_residual", "log10_fap"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_invalid(toliman_period_query_fap(period, cases[i].method, cases[i].given, &out), cases[i].of_fap);
        assert_invalid(toliman_period_query_threshold(period, cases[i].method, cases[i].given, &out),
                       cases[i].of_threshold);
    }
    assert_invalid(toliman_period_query_fap(period, BALUEV, -4901, &out), "log10_residual");
    assert_invalid(toliman_period_query_fap(period, BALUEV, -1, NULL), "log10_fap");
    assert_invalid(toliman_period_query_threshold(NULL, BALUEV, -1, &out), "period");
    assert_invalid(toliman_period_query_bootstrap(period, times, values, NULL, 99, NULL, 3, peaks), "n");
    assert_invalid(toliman_period_query_bootstrap(period, times, values, NULL, 100, NULL, 3, NULL), "log10_residuals");
    assert_ok(toliman_period_query_bootstrap(period, times, values, NULL, 100, NULL, 0, peaks));
    assert_refused(toliman_period_query_fap(empty, SEQUENTIAL, -1, &out), TOLIMAN_E_STATE, "");
    assert_refused(toliman_period_query_threshold(empty, SEQUENTIAL, -1, &out), TOLIMAN_E_STATE, "");
    assert_refused(toliman_period_query_bootstrap(empty, times, values, NULL, 0, NULL, 3, peaks), TOLIMAN_E_STATE, "");
    assert_true(out == 7);
    toliman_period_destroy(period), toliman_period_destroy(empty);
}

RUN_TESTS(NULL, NULL)
