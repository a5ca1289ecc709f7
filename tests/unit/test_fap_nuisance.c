/* Tests false alarm probabilities with nuisance functions on noise. All combinations: tools/bench/bench_fap_nuisance.c
 */
#include "nuisance_trials.h"

/* 30 samples, of which the functions take a large part: without counting them, 0.28 of the series with 6 functions
 * would be below 0.1. */
TEST(false_alarms_are_as_many_as_promised) {
    enum { SERIES = 1250 };
    static const int functions[] = {6, 1, 9};
    for (size_t k = 0; k < (in_long() ? sizeof functions / sizeof *functions : 1); k++)
        for (int priors = 0; priors < (functions[k] > 1 ? 2 : 1); priors++) {
            double shares[2];
            trial_shares(30, functions[k], priors, SERIES, shares);
            print_message("K = %d%s: %.4f, %.4f\n", functions[k], priors ? " with priors" : "", shares[0], shares[1]);
            assert_true(trial_is_calibrated(shares, SERIES));
        }
}

/* Every method counts the functions: 20 samples with 5 functions have the FAP of 16 with the mean alone, if the
 * variance of their times is equal. */
TEST(degrees_of_freedom_decide) {
    const int32_t methods[] = {TOLIMAN_PERIOD_FAP_BALUEV, TOLIMAN_PERIOD_FAP_NAIVE, TOLIMAN_PERIOD_FAP_SINGLE};
    toliman_period *periods[2] = {NULL};
    for (int with = 0; with < 2; with++) {
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.trend = with ? 4 : 0;
        options.trend_end = with ? 12 : 0;
        assert_ok(toliman_period_create(0.1, 0.01, 40, &options, &periods[with]));
        for (int i = 0; i < (with ? 20 : 16); i++)
            assert_ok(toliman_period_push(periods[with], with ? 0.3 * i : 0.3 * i * sqrt(399.0 / 255), (i * 7) % 5, 1));
    }
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (int power = 1; power < 10; power++) {
            double fap[2], level = NAN;
            for (int with = 0; with < 2; with++)
                assert_ok(toliman_period_query_fap(periods[with], methods[m], -0.2 * power, &fap[with]));
            assert_close(fap[1], fap[0], 1e-9, 1e-12);
            assert_ok(toliman_period_query_threshold(periods[1], methods[m], fap[1], &level));
            if (power > 1)
                assert_close(level, -0.2 * power, 1e-9, 0);
        }
    toliman_period_destroy(periods[0]), toliman_period_destroy(periods[1]);
}

RUN_TESTS(NULL, NULL)
