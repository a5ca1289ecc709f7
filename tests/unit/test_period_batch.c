/* Tests the batch periodogram: its tolerance on hard cases against 113-bit sums, agreement with the streaming one,
 * threads, refusals. */
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "assert_close.h"
#include "quad_period.h"
#include "uniform.h"

#include <toliman/period.h>
#include <toliman/period_batch.h>

enum { N = 240, NF = 700, STEP = 23 };
static double times[N], values[N], sigmas[N];
static const double tolerances[] = {1e-3, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 0};
enum { TOLERANCES = sizeof tolerances / sizeof tolerances[0] };

static uint64_t state;

typedef enum { RANDOM, EVEN, CLUSTERS, TWICE, LOPSIDED } sampling;
typedef enum { NO_SIGMAS, BENIGN, ALL_SIZES, ONE_HEAVY, TWO_HEAVY, TWO_EQUAL, ONE_LIGHT } weighting;

typedef struct {
    const char *name;
    double start, span;
    sampling sampling;
    double mean, amplitude, noise, f; /* of the signal */
    weighting weighting;
    double f0, df;
    size_t n;
} hard_case;

static const hard_case cases[] = {
    {"benign", 0, 100, RANDOM, 0, 1, 1, 0.21, BENIGN, 0.015, 1e-3, N},
    {"strong signal", 0, 100, RANDOM, 0, 1, 1e-3, 0.21, BENIGN, 0.015, 1e-3, N},
    {"Julian days", 2.45e6, 1000, RANDOM, 3, 1, 1, 0.037, BENIGN, 0.0015, 1e-4, N},
    {"Unix seconds", 1.7e9, 1e7, RANDOM, 0, 1, 1, 3e-6, NO_SIGMAS, 1.5e-7, 1e-8, N},
    {"mean 1e9, amplitude 1e-3", 0, 1000, RANDOM, 1e9, 1e-3, 1e-3, 0.037, NO_SIGMAS, 0.0015, 1e-4, N},
    {"1e7 cycles", 0, 1e6, RANDOM, 0, 1, 1, 10.0003, BENIGN, 10, 1e-6, N},
    {"from frequency 0", 0, 100, RANDOM, 0, 1, 1, 0.21, BENIGN, 0, 1e-3, N},
    {"a hundredth of a cycle", 0, 1, RANDOM, 0, 1, 0.1, 0.3, BENIGN, 0.003, 1e-5, N},
    {"through the Nyquist frequency", 0, 239, EVEN, 0, 1, 1, 0.21, NO_SIGMAS, 0.3, 1e-3, N},
    {"through Nyquist's of rounded times", 0, 23.9, EVEN, 0, 1, 1, 2.1, NO_SIGMAS, 3, 1e-2, N},
    {"two clusters", 0, 1000, CLUSTERS, 0, 1, 0.1, 0.037, BENIGN, 0.0015, 1e-3, N},
    {"every time twice", 0, 100, TWICE, 0, 1, 1, 0.21, BENIGN, 0.015, 1e-3, N},
    {"most at the beginning", 0, 100, LOPSIDED, 0, 1, 1, 0.21, BENIGN, 0.015, 1e-3, N},
    {"weights spanning 1e12", 0, 100, RANDOM, 0, 1, 1, 0.21, ALL_SIZES, 0.015, 1e-3, N},
    {"one sample outweighs all", 0, 100, RANDOM, 0, 1, 1, 0.21, ONE_HEAVY, 0.015, 1e-3, N},
    {"two samples outweigh all", 0, 100, RANDOM, 0, 1, 1, 0.21, TWO_HEAVY, 0.015, 1e-3, N},
    {"two heavy samples of equal value", 0, 100, RANDOM, 0, 1, 1, 0.21, TWO_EQUAL, 0.015, 1e-3, N},
    {"one light sample", 0, 100, RANDOM, 0, 1, 1, 0.21, ONE_LIGHT, 0.015, 1e-3, N},
    {"four samples", 0, 100, RANDOM, 0, 1, 1, 0.21, NO_SIGMAS, 0.015, 1e-3, 4},
    {"five samples", 0, 100, RANDOM, 0, 1, 1, 0.21, BENIGN, 0.015, 1e-3, 5},
    {"tiny values", 0, 100, RANDOM, 0, 1e-90, 1e-90, 0.21, BENIGN, 0.015, 1e-3, N},
};

static double time_of(const hard_case *hard, size_t i) {
    const double at = (double)i / (double)(N - 1), u = uniform(&state);
    switch (hard->sampling) {
    case EVEN:
        return at;
    case CLUSTERS:
        return (i % 2 ? 0.97 : 0) + 0.03 * u;
    case TWICE:
        return i % 2 ? (times[i - 1] - hard->start) / hard->span : u;
    case LOPSIDED:
        return u * u * u * u * u * u;
    default:
        return u;
    }
}

static double sigma_of(weighting kind, size_t i) {
    const double u = uniform(&state);
    switch (kind) {
    case ALL_SIZES:
        return pow(10, 6 * u);
    case ONE_HEAVY:
        return i == 7 ? 1e-6 : 1;
    case TWO_HEAVY:
    case TWO_EQUAL:
        return i == 7 || i == 90 ? 1e-6 : 1;
    case ONE_LIGHT:
        return i == 7 ? 1e6 : 1;
    default:
        return 0.5 + u;
    }
}

static quad_samples fill(const hard_case *hard) {
    state = 17;
    for (size_t i = 0; i < N; i++) {
        times[i] = hard->start + hard->span * time_of(hard, i);
        const double phase = fmod(hard->f * (times[i] - hard->start), 1);
        values[i] = hard->mean + hard->amplitude * sin(2 * M_PI * phase) + hard->noise * (2 * uniform(&state) - 1);
        sigmas[i] = sigma_of(hard->weighting, i);
    }
    if (hard->weighting == TWO_EQUAL)
        values[90] = values[7];
    const quad_samples samples = {times, values, hard->weighting == NO_SIGMAS ? NULL : sigmas, hard->n, NULL};
    return samples;
}

static toliman_period_batch_options options_of(double tolerance, uint32_t flags) {
    toliman_period_batch_options options = TOLIMAN_PERIOD_BATCH_OPTIONS_INIT;
    options.tolerance = tolerance;
    options.flags = flags | (tolerance == 0 ? TOLIMAN_PERIOD_DIRECT : 0);
    return options;
}

/* |power - exact| <= tolerance for each requested tolerance; for tolerances below 1e-13, and the default, 1e-13. */
/* promise: batches-meet-their-tolerance */
TEST(hard_cases_meet_their_tolerance) {
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++)
        for (uint32_t flags = 0; flags < 2; flags++) {
            const quad_samples samples = fill(&cases[c]);
            double exact[NF], power[NF];
            for (int k = 0; k < NF; k += STEP) {
                const quad f = (quad)cases[c].f0 + k * (quad)cases[c].df;
                exact[k] = f > 0 ? (double)(1 - quad_residual(&samples, f, (int)flags)) : 0;
            }
            for (size_t a = 0; a < TOLERANCES; a++) {
                const toliman_period_batch_options options = options_of(tolerances[a], flags);
                const double allowed = fmax(tolerances[a], 1e-13);
                assert_ok(toliman_period_batch(cases[c].f0, cases[c].df, NF, times, values, samples.sigma, samples.n,
                                               &options, power));
                double worst = 0;
                for (int k = 0; k < NF; k += STEP) {
                    if (exact[k] == exact[k]) /* the reference cannot solve where cosine and sine coincide */
                        worst = fmax(worst, fabs(power[k] - exact[k]));
                    assert_true(power[k] >= 0 && power[k] <= 1);
                }
                if (!(worst <= allowed))
                    fail_msg("%s, flags %u, tolerance %g: power is wrong by %.2e", cases[c].name, flags, tolerances[a],
                             worst);
            }
        }
}

/* The kernel must be no wider than the tolerance requires: otherwise a larger tolerance would not save time. */
TEST(error_is_not_far_below_the_tolerance) {
    fill(&cases[1]);
    const toliman_period_batch_options direct = options_of(0, 0);
    double exact[NF], power[NF];
    assert_ok(toliman_period_batch(0.015, 1e-3, NF, times, values, sigmas, N, &direct, exact));
    for (double tolerance = 6e-4; tolerance > 1e-12; tolerance *= 1e-2) {
        const toliman_period_batch_options options = options_of(tolerance, 0);
        assert_ok(toliman_period_batch(0.015, 1e-3, NF, times, values, sigmas, N, &options, power));
        double worst = 0;
        for (int k = 0; k < NF; k++)
            worst = fmax(worst, fabs(power[k] - exact[k]));
        if (!(worst <= tolerance && worst > tolerance * 1e-4))
            fail_msg("tolerance %g: power is wrong by %.2e", tolerance, worst);
    }
}

/* Up to three samples, or constant values: as defined for query_power, at every tolerance. */
TEST(small_archives_match_streaming) {
    for (size_t n = 0; n <= 6; n++)
        for (int constant = n > 3; constant < 2; constant++)
            for (uint32_t flags = 0; flags < 2; flags++) {
                fill(&cases[0]);
                for (int i = 0; i < N && constant; i++)
                    values[i] = 0.1;
                toliman_period_options stream_options = TOLIMAN_PERIOD_OPTIONS_INIT;
                stream_options.flags = flags;
                stream_options.sigma_floor = 0.1;
                toliman_period *period = NULL;
                double streamed[NF], power[NF];
                assert_ok(toliman_period_create(0, 1e-3, NF, &stream_options, &period));
                assert_ok(toliman_period_push_many(period, times, values, sigmas, n));
                assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, NF, streamed));
                toliman_period_destroy(period);
                for (size_t a = 0; a < TOLERANCES; a++) {
                    const toliman_period_batch_options options = options_of(tolerances[a], flags);
                    assert_ok(toliman_period_batch(0, 1e-3, NF, times, values, sigmas, n, &options, power));
                    for (int k = 0; k < NF; k++)
                        assert_close(power[k], streamed[k], 0, 1e-9);
                }
            }
}

enum { MANY = 20000, WIDE = 3000 };

static void many(double *t, double *y, double *sigma) {
    state = 5;
    for (int i = 0; i < MANY; i++) {
        t[i] = 2.45e6 + 1000 * uniform(&state); /* unsorted */
        sigma[i] = 1 + uniform(&state);
        y[i] = 7 + 0.3 * sin(2 * M_PI * fmod(0.1337 * (t[i] - 2.45e6), 1)) + sigma[i] * (2 * uniform(&state) - 1);
    }
}

/* The streaming periodogram gives the same powers; the number of threads changes no bit. */
/* promise: threads-change-no-bit */
TEST(archive_matches_streaming_on_any_threads) {
    double *t = malloc(MANY * sizeof *t), *y = malloc(MANY * sizeof *y), *sigma = malloc(MANY * sizeof *sigma);
    double streamed[WIDE], power[WIDE], first[WIDE];
    many(t, y, sigma);
    toliman_period_options stream_options = TOLIMAN_PERIOD_OPTIONS_INIT;
    stream_options.time_offset = 2.45e6;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(5e-4, 1e-4, WIDE, &stream_options, &period));
    assert_ok(toliman_period_push_many(period, t, y, sigma, MANY));
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, WIDE, streamed));
    toliman_period_destroy(period);
    for (size_t a = 0; a < TOLERANCES; a++) {
        toliman_period_batch_options options = options_of(tolerances[a], 0);
        const size_t n = tolerances[a] == 0 ? 500 : MANY; /* direct sums are slow */
        for (options.threads = 1; options.threads <= 5; options.threads += 2) {
            assert_ok(toliman_period_batch(5e-4, 1e-4, WIDE, t, y, sigma, n, &options, power));
            if (options.threads == 1)
                memcpy(first, power, sizeof first);
            assert_memory_equal(first, power, sizeof first);
        }
        for (int k = 0; k < WIDE && n == MANY; k++)
            assert_close(power[k], streamed[k], 0, tolerances[a] + 1e-12);
    }
    toliman_period_batch_options options = options_of(1e-9, 0); /* and without options: */
    assert_ok(toliman_period_batch(5e-4, 1e-4, WIDE, t, y, sigma, MANY, &options, first));
    assert_ok(toliman_period_batch(5e-4, 1e-4, WIDE, t, y, sigma, MANY, NULL, power));
    assert_memory_equal(first, power, sizeof first);
    free(t), free(y), free(sigma);
}

static double most_bytes(void) {
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return 1024.0 * (double)usage.ru_maxrss;
}

/* The memory stated in the header, plus a tenth for the allocator. */
/* promise: batch-memory-is-stated */
TEST(memory_is_as_documented) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* its allocator keeps freed memory */
#endif
    enum { LARGE = 400000 };
    double *t = malloc(LARGE * sizeof *t), *y = malloc(LARGE * sizeof *y), *power = malloc(LARGE * sizeof *power);
    for (int i = 0; i < LARGE; i++) {
        t[i] = uniform(&state);
        y[i] = power[i] = uniform(&state);
    }
    toliman_period_batch_options options = options_of(1e-9, 0);
    options.threads = 1;
    const double before = most_bytes();
    assert_ok(toliman_period_batch(1, 0.1, 1000, t, y, NULL, LARGE, &options, power));
    const double samples = most_bytes() - before;
    assert_ok(toliman_period_batch(1, 0.1, LARGE, t, y, NULL, LARGE, &options, power));
    assert_at_most(samples / LARGE, 38.5);
    assert_at_most((most_bytes() - before) / LARGE, 1.1 * (35 + 170));
    free(t), free(y), free(power);
}

typedef struct {
    int calls, stop_at, exact;
    double least, most;
} progress_log;

static int32_t note(const char *stage, double fraction, void *data) {
    progress_log *log = data;
    assert_non_null(stage);
    log->exact += strcmp(stage, "exact sums") == 0;
    log->least = fmin(log->least, fraction);
    log->most = fmax(log->most, fraction);
    return ++log->calls == log->stop_at;
}

TEST(progress_is_reported_and_can_cancel) {
    static const struct {
        double tolerance;
        size_t which; /* number of cases in which two heavy samples of equal value need exact sums */
    } ways[] = {{1e-9, 0}, {0, 0}, {1e-9, 16}};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        const hard_case *hard = &cases[ways[i].which];
        fill(hard);
        progress_log log = {0, 0, 0, 1, 0};
        toliman_period_batch_options options = options_of(ways[i].tolerance, 0);
        options.progress = note;
        options.progress_data = &log;
        options.threads = 1;
        double power[NF], before[NF];
        memset(power, 0x55, sizeof power);
        memcpy(before, power, sizeof power);
        assert_ok(toliman_period_batch(hard->f0, hard->df, NF, times, values, sigmas, N, &options, power));
        assert_int_equal(log.exact > 0, hard->weighting == TWO_EQUAL);
        assert_true(log.calls > 3 && log.least >= 0 && log.most <= 1);
        memcpy(power, before, sizeof power);
        const int calls = log.calls;
        for (int stop = 1; stop <= calls; stop += 1 + calls / 5) {
            log.calls = 0;
            log.stop_at = stop;
            assert_refused(toliman_period_batch(hard->f0, hard->df, NF, times, values, sigmas, N, &options, power),
                           TOLIMAN_E_CANCELLED, "");
            assert_int_equal(log.calls, stop);
            assert_memory_equal(power, before, sizeof power);
        }
    }
}

/* Where cosine and sine coincide, only one of them is fitted: even times at the Nyquist frequency. */
TEST(coincident_frequency_is_fitted) {
    enum { NYQUIST = 256 };
    fill(&cases[0]);
    double up = 0, mean = 0, weight = 0, alternating = 0, spread = 0;
    for (int i = 0; i < N; i++) {
        times[i] = i;
        const double w = 1 / (sigmas[i] * sigmas[i]);
        weight += w;
        mean += w * values[i];
        alternating += i % 2 ? -w : w;
    }
    mean /= weight;
    alternating /= weight;
    for (int i = 0; i < N; i++) {
        const double w = 1 / (sigmas[i] * sigmas[i]) / weight, y = values[i] - mean;
        up += w * ((i % 2 ? -1 : 1) - alternating) * y;
        spread += w * y * y;
    }
    for (size_t a = 0; a < TOLERANCES; a++) {
        const toliman_period_batch_options options = options_of(tolerances[a], 0);
        double power[NF];
        assert_ok(toliman_period_batch(0.25, 0x1p-10, NF, times, values, sigmas, N, &options, power));
        assert_close(power[NYQUIST], up * up / (1 - alternating * alternating) / spread, 0, 1e-13);
        const quad_samples samples = {times, values, sigmas, N, NULL};
        for (int k = NYQUIST - 2; k <= NYQUIST + 2; k++)
            if (k != NYQUIST)
                assert_close(power[k], (double)(1 - quad_residual(&samples, QUAD(0.25) + k * QUAD(0x1p-10), 0)), 0,
                             fmax(tolerances[a], 1e-13));
    }
}

/* A few ill-conditioned frequencies are summed exactly, and each counts as progress. */
/* promise: batches-meet-their-tolerance */
TEST(few_frequencies_are_summed_exactly) {
    enum { FEW = 7 };
    const quad_samples samples = {times, values, sigmas, FEW, NULL};
    progress_log log = {0, 0, 0, 1, 0};
    toliman_period_batch_options options = options_of(0, 0);
    options.progress = note;
    options.progress_data = &log;
    options.threads = 1;
    fill(&cases[0]);
    double power[NF];
    assert_ok(toliman_period_batch(0.015, 1e-3, NF, times, values, sigmas, FEW, &options, power));
    assert_true(log.exact > 1 && log.exact < NF / 64);
    for (int k = 0; k < NF; k++)
        assert_close(power[k], (double)(1 - quad_residual(&samples, (quad)0.015 + k * (quad)1e-3, 0)), 0, 1e-13);
}

TEST(bad_input_is_refused) {
    fill(&cases[0]);
    toliman_period_batch_options options = options_of(1e-9, 0);
    double power[NF], before[NF];
    memset(power, 0x55, sizeof power);
    memcpy(before, power, sizeof power);
#define REFUSED(f0, df, nf, n, code, field)                                                                            \
    assert_refused(toliman_period_batch(f0, df, nf, times, values, sigmas, n, &options, power), TOLIMAN_E_##code, field)
    REFUSED(-1, 1, NF, N, ARGUMENT, "f0");
    REFUSED(NAN, 1, NF, N, ARGUMENT, "f0");
    REFUSED(0, 0, NF, N, ARGUMENT, "df");
    REFUSED(0, 1, 0, N, ARGUMENT, "nf");
    REFUSED(0, 1, -5, N, ARGUMENT, "nf");
    REFUSED(0, 1, (int64_t)1 << 40, N, ARGUMENT, "nf");
    REFUSED(0, 1, 1, N, ARGUMENT, "f0");
    REFUSED(0, 1e300, NF, N, RANGE, "t");
    REFUSED(0.1, 0.1, NF, SIZE_MAX / 8, RANGE, "t");
    options.reserved = 1;
    REFUSED(0.1, 0.1, NF, N, ARGUMENT, "options->reserved");
    options.reserved = 0;
    static const struct {
        double *array, value;
        toliman_status code;
        const char *text;
    } bad[] = {{times, NAN, TOLIMAN_E_ARGUMENT, "t"},      {times, INFINITY, TOLIMAN_E_ARGUMENT, "t"},
               {times, -1e101, TOLIMAN_E_RANGE, "t"},      {times, 1e20, TOLIMAN_E_RANGE, "t"},
               {values, NAN, TOLIMAN_E_ARGUMENT, "y"},     {values, -1e301, TOLIMAN_E_RANGE, "y"},
               {sigmas, 0, TOLIMAN_E_ARGUMENT, "sigma"},   {sigmas, -1, TOLIMAN_E_ARGUMENT, "sigma"},
               {sigmas, NAN, TOLIMAN_E_ARGUMENT, "sigma"}, {sigmas, INFINITY, TOLIMAN_E_ARGUMENT, "sigma"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const double good = bad[i].array[9];
        bad[i].array[9] = bad[i].value;
        assert_refused(toliman_period_batch(0.1, 0.1, NF, times, values, sigmas, N, &options, power), bad[i].code,
                       bad[i].text);
        bad[i].array[9] = good;
    }
    options.flags = 6;
    REFUSED(0.1, 0.1, NF, N, ARGUMENT, "options->flags");
    options.flags = 0;
    for (int i = 0; i < 3; i++) {
        options.tolerance = i == 0 ? -1e-9 : i == 1 ? 0.02 : NAN;
        REFUSED(0.1, 0.1, NF, N, ARGUMENT, "options->tolerance");
    }
    options = options_of(1e-9, 0);
    options.struct_size = 4;
    REFUSED(0.1, 0.1, NF, N, ARGUMENT, "options->struct_size");
    options = options_of(1e-9, 0);
    assert_invalid(toliman_period_batch(0.1, 0.1, NF, NULL, values, NULL, N, NULL, power), "t");
    assert_invalid(toliman_period_batch(0.1, 0.1, NF, times, NULL, NULL, N, NULL, power), "y");
    assert_invalid(toliman_period_batch(0.1, 0.1, NF, times, values, NULL, N, NULL, NULL), "power");
    /* Exact sums would be needed, but are not possible. */
    sigmas[7] = sigmas[90] = 3e-9;
    values[90] = values[7];
    REFUSED(0.1, 0.1, NF, N, RANGE, "sigma_ceiling");
    assert_memory_equal(power, before, sizeof power);
}

/* Values, sigmas and weights near the limits of double. */
TEST(extreme_scales_are_defined) {
    static const double scales[] = {1e-300, 1e-150, 1, 1e150, 1e299};
    double first[NF], power[NF];
    for (size_t j = 0; j < 10; j++)
        for (size_t i = 0; i < 5; i++) {
            fill(&cases[j < 5 ? 0 : 16]); /* the latter by exact sums */
            for (int k = 0; k < N; k++) {
                values[k] *= scales[i];
                sigmas[k] *= scales[j % 5];
            }
            assert_ok(toliman_period_batch(0.015, 1e-3, NF, times, values, sigmas, N, NULL, power));
            if (i == 0 && j % 5 == 0)
                memcpy(first, power, sizeof first);
            for (int k = 0; k < NF; k++)
                assert_close(power[k], first[k], 0, 1e-9);
        }
    /* One sample with a weight so large that the others are negligible: the values have no variance. */
    sigmas[5] = 1e-300;
    assert_ok(toliman_period_batch(0.015, 1e-3, NF, times, values, sigmas, N, NULL, power));
    for (int k = 0; k < NF; k++)
        assert_true(power[k] == 0);
}

RUN_TESTS(NULL, NULL)
