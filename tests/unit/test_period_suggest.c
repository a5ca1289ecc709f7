/* Tests the suggested grid and options against their definitions and against the result of a search with them. */
#include <stdlib.h>
#include <string.h>

#include <toliman/period.h>
#include <toliman/period_sampling.h>

#include "assert_close.h"

typedef struct Suggestion {
    double f0, df;
    int64_t nf;
    toliman_period_options options;
} Suggestion;

static toliman_status suggest(const double *t, const double *y, const double *sigma, size_t n, double mission,
                              Suggestion *s) {
    s->options.struct_size = sizeof s->options;
    return toliman_period_suggest(t, y, sigma, n, mission, &s->f0, &s->df, &s->nf, &s->options);
}

enum { N = 1095 };

TEST(daily_samples) {
    static double t[N], y[N], sigma[N];
    for (int i = 0; i < N; i++) {
        t[i] = 100 + (N - 1 - i); /* in any order */
        y[i] = i % 7 == 0 ? 40 : 42;
        sigma[i] = i == 3 ? 0.5 : i == 4 ? 4 : 1;
    }
    Suggestion s;
    assert_ok(suggest(t, y, sigma, N, 0, &s));
    assert_close(s.f0, 1.5 / N, 1e-15, 0);
    assert_close(s.df, 0.1 / N, 1e-15, 0);
    assert_int_equal(s.nf, 5 * N - 14); /* exactly one cycle in two days */
    assert_true(s.options.time_offset == 100 && s.options.value_offset == 42 && s.options.value_bound == 2);
    assert_true(s.options.sigma_floor == 0.5 && s.options.sigma_ceiling == 4);
    assert_int_equal(s.options.flags, TOLIMAN_PERIOD_DOUBLE_LIMB);
    assert_int_equal(s.options.struct_size, sizeof s.options);

    assert_ok(suggest(t, y, sigma, N, 2 * N, &s)); /* as many more days expected */
    assert_close(s.f0, 0.75 / N, 1e-15, 0);
    assert_int_equal(s.nf, 10 * N - 14);
    assert_true(s.options.value_bound == 0x1p21);
    assert_true(s.options.sigma_floor == 0.0625 && s.options.sigma_ceiling == 16);

    assert_ok(suggest(NULL, NULL, NULL, 0, N, &s)); /* before the first sample, one unit of t apart */
    assert_int_equal(s.nf, 5 * N - 14);
    assert_true(s.options.value_bound == 0x1p20 && s.options.sigma_floor == 1);
    assert_ok(toliman_period_suggest(t, NULL, NULL, N, 0, &s.f0, &s.df, &s.nf, NULL));
    assert_int_equal(s.nf, 5 * N - 14);
}

/* The grid follows the differences of the times: regular samples with gaps to 1/(2 step), others to 5/(2 s) with the
 * s that 5 % of the differences do not exceed. Its cost is bounded. */
TEST(grid_of_the_differences) {
    enum { MOST = 131072, MANY = 1 << 20 };
    static double t[MANY];
    const struct {
        const char *name;
        int n, each;         /* exposures of a night */
        double scatter, gap; /* of the nights in d; longest gap in nights */
        double last;         /* of the grid; 0 = as many frequencies as allowed */
        int64_t most;
    } cases[] = {
        {"every night, same hour", 200, 1, 0, 1, 0.5, MOST},
        {"gaps, same hour", 200, 1, 0, 9, 0.5, MOST},
        {"gaps, minutes apart", 200, 1, 0.01, 9, 0.5, MOST},
        {"gaps, hours apart", 400, 1, 0.2, 3, 2.5 / 0.86, MOST},
        {"three a night", 300, 3, 0, 9, 0, MOST},
        {"4 minutes apart", 300, 300, 0, 1, 0.5 / 0.0035, MOST},
        {"10,000", 10000, 1, 0, 1, 0.5, MOST},
        {"a million", MANY, 1, 0, 1, 0, ((int64_t)1 << 32) / MANY},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        uint64_t random = 3;
        double night = 0;
        for (int i = 0; i < cases[c].n; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            const double u = (double)(random >> 11) * 0x1p-53;
            if (i % cases[c].each == 0)
                night += 1 + floor(u * cases[c].gap);
            t[i] = night + cases[c].scatter * (u * 1000 - floor(u * 1000) - 0.5) + 0.0035 * (i % cases[c].each);
        }
        Suggestion s;
        assert_ok(suggest(t, NULL, NULL, (size_t)cases[c].n, 0, &s));
        const double last = s.f0 + s.df * (double)(s.nf - 1);
        if (cases[c].last > 0 && fabs(last / cases[c].last - 1) > 0.05)
            fail_msg("%s: the grid ends at %g", cases[c].name, last);
        if (cases[c].last == 0)
            assert_int_equal(s.nf, cases[c].most);
        assert_true(s.nf <= cases[c].most);
    }
    const double far[] = {0, 1e-9, 2e-9, 1e9};
    Suggestion s;
    assert_ok(suggest(far, NULL, NULL, 4, 0, &s));
    assert_int_equal(s.nf, MOST);
    assert_ok(suggest(NULL, NULL, NULL, 0, 1e6, &s));
    assert_int_equal(s.nf, MOST);
}

/* Without a grid: the same options as with one, also where no grid can be suggested. */
TEST(options_alone) {
    const double t[] = {7, 7e9, 6, 7}, y[] = {1, -4, 2, 2}, sigma[] = {1, 2, 0.5, 1};
    for (int mission = 0; mission < 2; mission++) {
        Suggestion whole, alone = {.options = TOLIMAN_PERIOD_OPTIONS_INIT};
        assert_ok(suggest(t, y, sigma, 4, mission * 1e11, &whole));
        assert_ok(toliman_period_suggest(t, y, sigma, 4, mission, NULL, NULL, NULL, &alone.options));
        assert_memory_equal(&alone.options, &whole.options, sizeof whole.options);
        assert_ok(toliman_period_suggest(t, y, sigma, 1, mission, NULL, NULL, NULL, &alone.options));
        assert_true(alone.options.time_offset == 7 && alone.options.value_offset == 1);
        assert_true(alone.options.value_bound == (mission ? 0x1p20 : 1));
        assert_true(alone.options.sigma_floor == (mission ? 0.125 : 1));
        assert_true(alone.options.sigma_ceiling == (mission ? 4 : 1));
    }
}

/* create() and every push accept the suggestion, and the search finds the period. */
TEST(search_with_the_suggestion) {
    enum { M = 200 };
    double t[M], y[M], sigma[M];
    uint64_t random = 1;
    for (int i = 0; i < M; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        const double u = (double)(random >> 11) * 0x1p-53;
        t[i] = 2460000 + 300 * u;
        y[i] = 1e-6 * sin(2 * M_PI * t[i] / 17.3) + 5;
        sigma[i] = 1e-7 * (1 + i % 3);
    }
    Suggestion s;
    assert_ok(suggest(t, y, sigma, M, 0, &s));
    toliman_period *period = NULL;
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_create(s.f0, s.df, s.nf, &s.options, &period));
    assert_ok(toliman_period_push_many(period, t, y, sigma, M));
    assert_ok(toliman_period_query_fit(period, t, y, sigma, NULL, M, &peak));
    assert_close(peak.period, 17.3, 1e-6, 0);
    toliman_period_sampling sampling = {.struct_size = sizeof sampling};
    assert_ok(toliman_period_query_sampling(period, t, M, &sampling));
    assert_int_equal(sampling.flags, 0);
    toliman_period_destroy(period);
}

TEST(invalid_arguments_are_refused) {
    const double t[] = {1, 2, 3}, same[] = {1, 1, 1}, bad[] = {1, NAN, 2}, none[] = {1, 0, 1};
    const double wide[] = {1e-5, 1, 1e5};
    Suggestion s = {.f0 = -1, .nf = -1};
    assert_refused(suggest(same, NULL, NULL, 3, 0, &s), TOLIMAN_E_STATE, "t");
    assert_refused(suggest(NULL, NULL, NULL, 0, 0, &s), TOLIMAN_E_STATE, "n");
    assert_invalid(suggest(bad, NULL, NULL, 3, 0, &s), "t");
    assert_invalid(suggest(t, bad, NULL, 3, 0, &s), "y");
    assert_invalid(suggest(t, t, none, 3, 0, &s), "sigma");
    assert_refused(suggest(t, t, wide, 3, 0, &s), TOLIMAN_E_RANGE, "sigma_ceiling");
    assert_invalid(suggest(t, NULL, NULL, 3, -1, &s), "mission_span");
    assert_invalid(suggest(t, NULL, NULL, 3, NAN, &s), "mission_span");
    assert_invalid(toliman_period_suggest(t, NULL, NULL, 3, 0, NULL, &s.df, &s.nf, NULL), "f0");
    assert_invalid(toliman_period_suggest(NULL, NULL, NULL, 3, 0, &s.f0, &s.df, &s.nf, NULL), "t");
    assert_true(s.f0 == -1 && s.nf == -1);
}

RUN_TESTS(NULL, NULL)
