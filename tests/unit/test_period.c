/* Tests the periodogram: long streams, peaks, fits, FAP and refusals. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "assert_close.h"
#include "quad_period.h"
#include "samples.h"
#include "uniform.h"

#include <toliman/period.h>
#include <toliman/period_fap.h>

enum { MOST = 4000 };
static double times[MOST], values[MOST], sigmas[MOST];

static toliman_period *make(double f0, double df, int64_t nf, const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(f0, df, nf, options, &period));
    return period;
}

static void save_into(const toliman_period *period, unsigned char *bytes, size_t capacity, size_t *size) {
    assert_asks(toliman_period_save(period, NULL, 0, size));
    assert_true(*size <= capacity);
    assert_ok(toliman_period_save(period, bytes, capacity, size));
}

static unsigned char bytes_a[1 << 20], bytes_b[1 << 20];

/* More samples than the sums accept between two folds, so that carries are tested; saved and loaded in between. */
/* promise: long-streams-stay-exact */
TEST(long_streams_survive_saving) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.sigma_ceiling = 1e6;
    toliman_period *whole = make(0.01, 0.001, 70, &options), *part = make(0.01, 0.001, 70, &options);
    size_t size_a, size_b;
    uint64_t state = 9;
    for (int i = 0; i < 20000; i++) {
        const double t = i + 0.3 * uniform(&state), y = 1e3 * noise(&state);
        const double sigma = pow(10, 6 * uniform(&state));
        assert_ok(toliman_period_push(whole, t, y, sigma));
        assert_ok(toliman_period_push(part, t, y, sigma));
        if (i % 3001 == 0) {
            save_into(part, bytes_b, sizeof bytes_b, &size_b);
            toliman_period_destroy(part);
            assert_ok(toliman_period_load(bytes_b, size_b, NULL, &part));
        }
    }
    save_into(whole, bytes_a, sizeof bytes_a, &size_a);
    save_into(part, bytes_b, sizeof bytes_b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
    assert_int_equal(count_of(part), 20000);
    toliman_period_destroy(whole), toliman_period_destroy(part);
}

/* The first row of the chapter's table: three cycles of a pure sine in unit span, 1095 samples. */
TEST(pure_signal_row) {
    const size_t n = 1095;
    for (size_t i = 0; i < n; i++) {
        times[i] = (double)i / (double)n;
        values[i] = sin(2 * M_PI * 3 * times[i]);
    }
    toliman_period *period = make(1.5, 0.1, 5460, NULL);
    assert_ok(toliman_period_push_many(period, times, values, NULL, n));
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, n, &peak));
    assert_close(peak.period, 1.0 / 3, 1e-14, 0);
    assert_close(peak.fwhm_period, 0.0998, 0, 2e-4);
    assert_close(peak.half_width_period, 0.0499, 0, 1e-4);
    assert_at_most(peak.log10_fap, -16000);

    /* Minimises the residual over frequency with Newton's method on central differences, in 113 bits. */
    const quad_samples samples = {times, values, NULL, n, NULL};
    quad f = 3, h = QUAD(1e-9), residual = 0;
    for (int i = 0; i < 3; i++) {
        const quad a = quad_residual(&samples, f - h, 0), c = quad_residual(&samples, f + h, 0);
        residual = quad_residual(&samples, f, 0);
        f -= h * (c - a) / 2 / (a - 2 * residual + c);
    }
    residual = quad_residual(&samples, f, 0);
    quad mean = 0, variance = 0;
    for (size_t i = 0; i < n; i++)
        mean += times[i] / (quad)n;
    for (size_t i = 0; i < n; i++)
        variance += (times[i] - mean) * (times[i] - mean) / (quad)n;
    const quad m = n - 1, w = (1.5 + 0.1 * 5459) * sqrtq(4 * M_PIq * variance);
    const quad ln_gamma = lgammaq(m / 2) - lgammaq((m - 1) / 2) + logq(2 / m) / 2;
    const quad ln_tau = ln_gamma + logq(w) + (m - 3) / 2 * logq(residual) + logq(m / 2 * (1 - residual)) / 2;
    const quad expected = (ln_tau + log1pq(expq((m - 2) / 2 * logq(residual) - ln_tau))) / M_LN10q;
    assert_close(peak.log10_residual, (double)log10q(residual), 0, 1e-3);
    assert_close(peak.log10_fap, (double)expected, 0, 1);
    toliman_period_destroy(period);
}

/* Where the power in 113 bits has fallen to half of that at f, in steps of `step` from there; 0 if not in 500. */
static double quad_half_power(const quad_samples *samples, quad f, quad step) {
    const quad half = (1 - quad_residual(samples, f, 0)) / 2;
    quad inside = 0, outside = step;
    for (int i = 0; 1 - quad_residual(samples, f + outside, 0) > half; i++) {
        if (i == 500)
            return 0;
        inside = outside;
        outside += step;
    }
    for (int i = 0; i < 40; i++) {
        const quad middle = (inside + outside) / 2;
        *(1 - quad_residual(samples, f + middle, 0) > half ? &inside : &outside) = middle;
    }
    return (double)fabsq(inside);
}

/* Frequency and width of fits, against the residual in 113 bits: from noise alone to a signal of 1e9 sigma. */
TEST(fits_have_the_least_residual_and_their_width) {
    enum { N = 150 };
    const double amplitudes[] = {0, 1, 30, 1e4, 1e9};
    for (size_t a = 0; a < sizeof amplitudes / sizeof *amplitudes; a++) {
        uint64_t state = 5 + a;
        for (size_t i = 0; i < N; i++) {
            times[i] = 1000 * uniform(&state);
            sigmas[i] = 1 + uniform(&state);
            values[i] = amplitudes[a] * sin(2 * M_PI * times[i] / 37.3 + 1) + sigmas[i] * noise(&state);
        }
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.value_bound = 1e10;
        toliman_period *period = make(1e-3, 2e-4, 400, &options);
        assert_ok(toliman_period_push_many(period, times, values, sigmas, N));
        toliman_period_peak fit = {.struct_size = sizeof fit};
        assert_ok(toliman_period_query_fit(period, times, values, sigmas, NULL, N, &fit));
        const quad_samples samples = {times, values, sigmas, N, NULL};
        const quad h = QUAD(1e-12);
        const quad low = quad_residual(&samples, fit.frequency - h, 0),
                   high = quad_residual(&samples, fit.frequency + h, 0);
        const quad bend = low - 2 * quad_residual(&samples, fit.frequency, 0) + high;
        /* rounding of the frequency to double, or 1e-8 of its error */
        assert_close((double)(h * (high - low) / 2 / bend), 0, 0, 1e-8 * fit.frequency_error + 4e-18);
        const double width = quad_half_power(&samples, fit.frequency, QUAD(1e-5)) +
                             quad_half_power(&samples, fit.frequency, -QUAD(1e-5));
        assert_close(fit.fwhm, width, 1e-8, 0);
        toliman_period_destroy(period);
    }
}

TEST(fit_recovers_parameters) {
    const size_t n = 1095;
    uint64_t state = 77;
    for (size_t i = 0; i < n; i++) {
        times[i] = 2451545.0 + (double)i;
        values[i] = 5 + 1e-2 * sin(2 * M_PI * (double)i / 365 + 0.4) + 1e-3 * noise(&state);
    }
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.time_offset = times[0];
    options.value_offset = 5;
    toliman_period *period = make(1.5 / 1095, 1.0 / 10950, 5000, &options);
    assert_ok(toliman_period_push_many(period, times, values, NULL, n));
    toliman_period_peak fit = {.struct_size = sizeof fit}, peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, n, &fit));
    assert_ok(toliman_period_query_peak(period, &peak));
    assert_close(fit.amplitude, 1e-2, 0, 4 * fit.amplitude_error);
    assert_close(fit.frequency, 1.0 / 365, 0, 4 * fit.frequency_error);
    assert_close(fit.phase, 0.4, 0, 0.05);
    assert_close(fit.offset, 5, 0, 2e-4);
    assert_close(fit.amplitude_error, 1e-3 * sqrt(2.0 / (double)n), 0.1, 0);
    assert_close(fit.frequency_error, sqrt(6.0 / (double)n) / (M_PI * 1095) * 0.1, 0.1, 0);
    assert_close(peak.frequency, fit.frequency, 0, 0.02 * fit.fwhm);
    assert_close(peak.fwhm, fit.fwhm, 0.02, 0);
    toliman_period_destroy(period);
}

/* Two brown dwarfs around nu Ophiuchi; the inner one has a period of about 530 days. */
TEST(nu_ophiuchi) {
    FILE *file = fopen("examples/data/nu_oph_rv.csv", "r");
    assert_non_null(file);
    char line[256];
    size_t n = 0;
    double floor = 1e300;
    while (fgets(line, sizeof line, file) != NULL && n < MOST)
        if (sscanf(line, "%lf,%lf,%lf", &times[n], &values[n], &sigmas[n]) == 3)
            floor = fmin(floor, sigmas[n++]);
    fclose(file);
    assert_int_equal(n, 150);
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.time_offset = times[0];
    options.sigma_floor = floor;
    toliman_period *period = make(1e-4, 2e-5, 2500, &options);
    assert_ok(toliman_period_push_many(period, times, values, sigmas, n));
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_fit(period, times, values, sigmas, NULL, n, &peak));
    assert_close(peak.period, 531.93, 0, 0.05);
    assert_at_most(peak.log10_fap, -40);
    toliman_period_destroy(period);
}

/* promise: power-is-never-nan */
TEST(defined_where_others_give_nan) {
    double power[64];
    const double same[6] = {7.25, 7.25, 7.25, 7.25, 7.25, 7.25}, t[6] = {0, 1, 2.5, 3, 4.5, 6};
    toliman_period_peak peak = {.struct_size = sizeof peak};
    toliman_period *period = make(0, 0.05, 64, NULL);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 64, power)); /* no samples */
    for (int k = 0; k < 64; k++)
        assert_true(power[k] == 0);
    assert_ok(toliman_period_push_many(period, t, same, NULL, 6)); /* constant values */
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 64, power));
    for (int k = 0; k < 64; k++)
        assert_true(power[k] == 0);
    assert_refused(toliman_period_query_peak(period, &peak), TOLIMAN_E_STATE, "");
    for (int32_t method = TOLIMAN_PERIOD_FAP_BALUEV; method <= TOLIMAN_PERIOD_FAP_SEQUENTIAL; method++) {
        double log10_fap = -1;
        assert_ok(toliman_period_query_fap(period, method, 0, &log10_fap));
        assert_true(log10_fap == 0);
        assert_refused(toliman_period_query_fap(period, method, -1, &log10_fap), TOLIMAN_E_STATE, "");
    }

    const double three[3] = {1, -2, 4};
    toliman_period_destroy(period);
    period = make(0, 0.05, 64, NULL);
    assert_ok(toliman_period_push_many(period, t, three, NULL, 3)); /* as many parameters as samples */
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 64, power));
    assert_true(power[0] == 0); /* f = 0: only the mean remains */
    for (int k = 1; k < 64; k++)
        assert_true(power[k] >= 0 && power[k] <= 1);
    assert_true(power[7] == 1);

    const double regular[6] = {0, 1, 2, 3, 4, 5}, alternating[6] = {1, -1, 1, -1, 1, -1};
    toliman_period_destroy(period);
    period = make(0, 0.05, 64, NULL);
    assert_ok(toliman_period_push_many(period, regular, alternating, NULL, 6));
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 10, 1,
                                         power)); /* f = 1/2: the sine vanishes at every sample */
    assert_close(power[0], 1, 0, 1e-12);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 20, 1,
                                         power)); /* f = 1: the cosine equals the mean */
    assert_true(power[0] == 0);
    toliman_period_destroy(period);
}

/* promise: pushes-take-all-or-none */
TEST(refusals_name_the_argument) {
    toliman_period *period = NULL;
    toliman_period_options options;
    assert_invalid(toliman_period_create(-1, 1, 1, NULL, &period), "f0");
    assert_invalid(toliman_period_create(0, 0, 1, NULL, &period), "df");
    assert_invalid(toliman_period_create(0, NAN, 1, NULL, &period), "df");
    assert_invalid(toliman_period_create(0, 1, 0, NULL, &period), "nf");
    assert_invalid(toliman_period_create(0, 1, INT64_MAX, NULL, &period), "nf");
    assert_invalid(toliman_period_create(0, 1, 1, NULL, NULL), "out");
    options = (toliman_period_options)TOLIMAN_PERIOD_OPTIONS_INIT;
    options.struct_size = 3;
    assert_invalid(toliman_period_create(0, 1, 1, &options, &period), "options->struct_size");
    options = (toliman_period_options)TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = 64;
    assert_invalid(toliman_period_create(0, 1, 1, &options, &period), "options->flags");
    assert_null(period);

    period = make(0.1, 0.1, 10, NULL);
    assert_invalid(toliman_period_push(period, NAN, 1, 1), "t");
    assert_invalid(toliman_period_push(period, 1, INFINITY, 1), "y");
    assert_invalid(toliman_period_push(period, 1, 1, 0), "sigma");
    assert_invalid(toliman_period_push(period, 1, 1, -2), "sigma");
    assert_refused(toliman_period_push(period, 1, 1e9, 1), TOLIMAN_E_RANGE, "y");
    assert_refused(toliman_period_push(period, 1, 1, 0.5), TOLIMAN_E_RANGE, "sigma");
    assert_refused(toliman_period_push(period, 1e30, 1, 1), TOLIMAN_E_RANGE, "t");
    assert_invalid(toliman_period_push(NULL, 1, 1, 1), "period");
    const double t[3] = {1, 2, 3}, y[3] = {1, NAN, 3};
    assert_fails(toliman_period_push_many(period, t, y, NULL, 3), TOLIMAN_E_ARGUMENT, "sample 1: y = nan");
    assert_int_equal(count_of(period), 0);
    double power;
    assert_refused(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 10, 1, &power), TOLIMAN_E_RANGE,
                   "first");
    assert_invalid(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_BALUEV, 0.5, &power), "log10_residual");
    toliman_period_destroy(period), toliman_period_destroy(NULL);
}

/* promise: damaged-states-are-refused */
TEST(damaged_state_is_refused) {
    toliman_period *period = make(0.1, 0.1, 10, NULL), *loaded = NULL;
    for (int i = 0; i < 9; i++)
        assert_ok(toliman_period_push(period, i, i % 3, 1));
    size_t size;
    save_into(period, bytes_a, sizeof bytes_a, &size);
    assert_refused(toliman_period_save(period, bytes_b, size - 1, &size), TOLIMAN_E_CAPACITY, "capacity");
    for (size_t cut = 0; cut < size; cut += cut < 100 ? 1 : 97)
        assert_refused(toliman_period_load(bytes_a, cut, NULL, &loaded), TOLIMAN_E_FORMAT, "");
    for (size_t i = 0; i < size; i += i < 200 ? 1 : 31) {
        memcpy(bytes_b, bytes_a, size);
        bytes_b[i] ^= 0x10;
        assert_int_equal(toliman_period_load(bytes_b, size, NULL, &loaded), TOLIMAN_E_FORMAT);
    }
    assert_null(loaded);
    assert_refused(toliman_period_load_file("no/such/file", NULL, &loaded), TOLIMAN_E_NOT_FOUND, "no/such/file");
    assert_refused(toliman_period_save_file(period, "no/such/folder/state"), TOLIMAN_E_WRITE, "no/such/folder/state");
    toliman_period_destroy(period);
}

TEST(saving_replaces_what_a_link_names_and_no_pipe) {
    char folder[] = "saving.XXXXXX", state[64], link[64], pipe[64];
    assert_non_null(mkdtemp(folder));
    snprintf(state, sizeof state, "%s/state", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    snprintf(pipe, sizeof pipe, "%s/pipe", folder);
    toliman_period *period = make(0.1, 0.1, 10, NULL), *loaded = NULL;
    assert_ok(toliman_period_save_file(period, state));
    assert_int_equal(symlink("state", link), 0);
    assert_int_equal(mkfifo(pipe, 0600), 0);
    assert_ok(toliman_period_push(period, 1, 2, 3));
    assert_ok(toliman_period_save_file(period, link));
    struct stat attributes;
    assert_int_equal(lstat(link, &attributes), 0);
    assert_true(S_ISLNK(attributes.st_mode));
    assert_ok(toliman_period_load_file(state, NULL, &loaded));
    assert_int_equal(count_of(loaded), 1);
    assert_refused(toliman_period_save_file(period, pipe), TOLIMAN_E_WRITE, pipe);
    assert_int_equal(lstat(pipe, &attributes), 0);
    assert_true(S_ISFIFO(attributes.st_mode));
    assert_refused(toliman_period_save_file(period, folder), TOLIMAN_E_WRITE, folder);
    toliman_period_destroy(loaded), toliman_period_destroy(period);
    unlink(pipe), unlink(link), unlink(state);
    assert_int_equal(rmdir(folder), 0); // no other file was left in the folder
}

RUN_TESTS(NULL, NULL)
