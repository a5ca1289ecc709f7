/* Tests edge cases of the periodogram: sigmas and values of very different magnitude, the Nyquist frequency, perfect
 * fits, crafted state bytes, and allocations. */
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "asked_memory.h"
#include "assert_close.h"
#include "own_memory.h"
#include "quad_period.h"
#include "samples.h"
#include "uniform.h"

#include <toliman/period.h>
#include <toliman/period_fap.h>

enum { N = 200, NF = 90 };
static double times[N], values[N], sigmas[N];

/* A sine of period 10 with noise at 200 even times. */
static void fill_sine(double mean, double scale) {
    uint64_t state = 3;
    for (int i = 0; i < N; i++) {
        times[i] = i;
        values[i] = mean + scale * (sin(2 * M_PI * 0.1 * i) + 2 * uniform(&state) - 1);
        sigmas[i] = 1;
    }
}

static toliman_period *make(const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.0123, 0.0051, NF, options, &period));
    return period;
}

static void compare_with_113_bits(const char *name, const toliman_period_options *options) {
    toliman_period *period = make(options);
    assert_ok(toliman_period_push_many(period, times, values, sigmas, N));
    const quad_samples samples = {times, values, sigmas, N, NULL};
    double power[NF], worst = 0;
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, NF, power));
    for (int k = 0; k < NF; k += 11) {
        const quad f = (quad)0.0123 + k * (quad)0.0051;
        worst = fmax(worst, fabs(power[k] - (double)(1 - quad_residual(&samples, f, options->flags != 0))));
    }
    if (!(worst <= 1e-12))
        fail_msg("%s, flags %u: power is wrong by %.2e", name, options->flags, worst);
    toliman_period_destroy(period);
}

/* Floor and ceiling up to a factor 1e8 apart: all samples at the ceiling, one or two far below the others, all
 * magnitudes, one far above. */
TEST(sigma_ratios_match_113_bits) {
    static const char *const names[] = {"all light", "one heavy", "two heavy", "all sizes", "one light"};
    static const double ratios[] = {30, 33, 1e3, 1e6, 1e8};
    for (uint32_t flags = 0; flags < 2; flags++)
        for (int kind = 0; kind < 5; kind++)
            for (size_t r = 0; r < sizeof ratios / sizeof ratios[0]; r++) {
                uint64_t state = 8;
                fill_sine(0.3, 1);
                toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
                options.flags = flags;
                options.sigma_floor = 1e-3;
                options.sigma_ceiling = 1e-3 * ratios[r];
                for (int i = 0; i < N; i++)
                    sigmas[i] = kind == 3   ? fmin(1e-3 * pow(ratios[r], uniform(&state)), options.sigma_ceiling)
                                : kind == 4 ? options.sigma_floor
                                            : options.sigma_ceiling;
                if (kind == 1 || kind == 2)
                    sigmas[77] = options.sigma_floor;
                if (kind == 2)
                    sigmas[30] = options.sigma_floor;
                if (kind == 4)
                    sigmas[77] = options.sigma_ceiling;
                char name[64];
                snprintf(name, sizeof name, "%s, ratio %g", names[kind], ratios[r]);
                compare_with_113_bits(name, &options);
            }
}

TEST(sigmas_out_of_range_are_refused) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    toliman_period *period = make(&options), *none = NULL;
    assert_ok(toliman_period_push(period, 1, 1, 32));
    assert_refused(toliman_period_push(period, 1, 1, 32.1), TOLIMAN_E_RANGE, "sigma");
    assert_int_equal(count_of(period), 1);
    toliman_period_info info = {.struct_size = sizeof info};
    assert_ok(toliman_period_get_info(period, &info));
    assert_true(info.sigma_ceiling == 32);
    toliman_period_destroy(period);
    options.sigma_ceiling = 1.01e8;
    assert_refused(toliman_period_create(0, 1, 1, &options, &none), TOLIMAN_E_RANGE, "options->sigma_ceiling");
    options.sigma_ceiling = 0.5;
    assert_invalid(toliman_period_create(0, 1, 1, &options, &none), "options->sigma_ceiling");
    options.sigma_ceiling = NAN;
    assert_invalid(toliman_period_create(0, 1, 1, &options, &none), "options->sigma_ceiling");
    assert_null(none);
}

TEST(impossible_grids_are_refused) {
    toliman_period_options options;
    toliman_period *none = NULL;
    assert_invalid(toliman_period_create(1e308, 1e308, 2, NULL, &none), "f0");
#define REFUSED(member, wrong)                                                                                         \
    do {                                                                                                               \
        options = (toliman_period_options)TOLIMAN_PERIOD_OPTIONS_INIT;                                                 \
        options.member = (wrong);                                                                                      \
        assert_invalid(toliman_period_create(0, 1, 1, &options, &none), "options->" #member);                          \
        assert_null(none);                                                                                             \
    } while (0)
    REFUSED(time_offset, NAN);
    REFUSED(value_offset, INFINITY);
    REFUSED(value_bound, NAN);
    REFUSED(value_bound, 1e-101);
    REFUSED(value_bound, 1e101);
    REFUSED(sigma_floor, NAN);
    REFUSED(sigma_floor, 1e-101);
    REFUSED(sigma_floor, 1e101);
    REFUSED(unit_ns, 0.5);
    REFUSED(unit_ns, 1e31);
}

/* promise: lost-digits-are-refused */
TEST(small_values_keep_their_digits_or_are_refused) {
    static const struct {
        double scale, bound, ceiling;
        int refused;
    } cases[] = {{1e-9, 0x1p20, 0, 0}, {5e-11, 0x1p20, 0, 0}, {1e-12, 0x1p20, 0, 1},  {1e-27, 0x1p20, 0, 1},
                 {1e-27, 1e-20, 0, 0}, {1e-27, 1e-26, 0, 0},  {1e-9, 0x1p20, 1e4, 0}, {1e-27, 0x1p20, 1e8, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fill_sine(0, cases[i].scale);
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.value_bound = cases[i].bound;
        options.sigma_ceiling = cases[i].ceiling;
        if (!cases[i].refused) {
            compare_with_113_bits("small values", &options);
            continue;
        }
        toliman_period *period = make(&options);
        toliman_period_peak peak = {.struct_size = sizeof peak};
        double power;
        assert_ok(toliman_period_push_many(period, times, values, NULL, N));
        assert_refused(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 3, 1, &power), TOLIMAN_E_RANGE,
                       "value_bound");
        double scatter, least; /* of values within 1.5 of the scale */
        const char *numbers = strstr(toliman_last_error(), "standard deviation of the values");
        assert_non_null(numbers);
        assert_int_equal(sscanf(numbers,
                                "standard deviation of the values = %lg: value_bound = %*g resolves 12 digits from %lg",
                                &scatter, &least),
                         2);
        assert_true(scatter > 0.1 * cases[i].scale && scatter < 10 * cases[i].scale && least > scatter);
        assert_refused(toliman_period_query_peak(period, &peak), TOLIMAN_E_RANGE, "value_bound");
        assert_refused(toliman_period_query_fit(period, times, values, NULL, NULL, N, &peak), TOLIMAN_E_RANGE,
                       "value_bound");
        toliman_period_destroy(period);
    }
}

/* At the Nyquist frequency of even times the sine is 0 at every sample: only +-1 is fitted. */
TEST(nyquist_frequency_is_fitted) {
    for (int noisy = 0; noisy < 2; noisy++)
        for (int past = 0; past < 2; past++)
            for (uint32_t flags = 0; flags < 2; flags++) {
                uint64_t state = 5;
                double up = 0, mean = 0;
                for (int i = 0; i < N; i++) {
                    times[i] = i;
                    values[i] = (i % 2 ? -1 : 1) + (noisy ? 2 * uniform(&state) - 1 : 0);
                    up += (i % 2 ? -values[i] : values[i]) / N;
                    mean += values[i] / N;
                }
                toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
                options.flags = flags;
                toliman_period *period = NULL; /* the last frequency is 0.5, or the grid continues beyond it */
                assert_ok(toliman_period_create(0.4, 0.0005, past ? 350 : 201, &options, &period));
                assert_ok(toliman_period_push_many(period, times, values, NULL, N));
                toliman_period_peak grid = {.struct_size = sizeof grid}, fit = {.struct_size = sizeof fit};
                double power;
                assert_ok(toliman_period_query_peak(period, &grid));
                assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 200, 1, &power));
                assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, N, &fit));
                assert_close(fit.frequency, 0.5, 0, 1e-4);
                assert_true(fit.power >= power - 1e-12);
                assert_false(isnan(fit.frequency_error) || isnan(fit.amplitude_error) || isnan(fit.fwhm_period) ||
                             isnan(fit.half_width_period) || isnan(fit.phase));
                assert_true(fit.log10_fap < -50);
                if (fabs(fit.frequency - 0.5) < 1e-12) {
                    assert_close(fit.amplitude, fabs(up), 1e-12, 0);
                    assert_close(fit.offset, mean, 0, 1e-12);
                    assert_true(isinf(fit.frequency_error));
                    if (noisy) /* standard error of a mean of +-values */
                        assert_close(fit.amplitude_error, sqrt(1.0 / 3 / N), 0.15, 0);
                } else {
                    assert_true(noisy);
                }
                if (!noisy)
                    assert_close(fit.frequency, 0.5, 0, 1e-12);
                toliman_period_destroy(period);
            }
}

/* A fit without residual: 1 - power is treated as 1e-4900, and nothing is infinite or NaN. */
/* promise: faps-are-finite */
TEST(perfect_fit_has_a_probability) {
    for (uint32_t flags = 0; flags < 2; flags++) {
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.flags = flags;
        toliman_period *period = NULL;
        assert_ok(toliman_period_create(0.1, 0.1, 5, &options, &period));
        for (int i = 0; i < 16; i++) {
            times[i] = i;
            values[i] = i % 2 ? -1 : 1;
        }
        assert_ok(toliman_period_push_many(period, times, values, NULL, 16));
        toliman_period_peak fit = {.struct_size = sizeof fit};
        double fap;
        assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, 16, &fit));
        assert_true(fit.power == 1);
        assert_true(fit.log10_residual >= -4900);
        assert_ok(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_BALUEV, fit.log10_residual, &fap));
        assert_true(fit.log10_fap == fap);
        assert_ok(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_BALUEV, -4900, &fap));
        assert_true(isfinite(fap));
        toliman_period_destroy(period);
    }
    /* All times equal: no sinusoid can be fitted, and nothing is NaN. */
    toliman_period *period = make(NULL);
    for (int i = 0; i < 20; i++) {
        times[i] = 1000;
        values[i] = i % 5;
    }
    assert_ok(toliman_period_push_many(period, times, values, NULL, 20));
    toliman_period_peak fit = {.struct_size = sizeof fit}, peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_peak(period, &peak));
    assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, 20, &fit));
    assert_true(peak.power <= 1e-12 && !isnan(peak.fwhm));
    assert_true(fit.power == 0 && isinf(fit.fwhm));
    assert_true(fit.log10_fap == 0);
    assert_true(isinf(fit.frequency_error) && isinf(fit.amplitude_error));
    toliman_period_destroy(period);
    uint64_t state = 4;
    for (int draw = 0; draw < 300; draw++) { /* the weights add up to 1 only up to rounding */
        const size_t n = 5 + (size_t)(190 * uniform(&state));
        for (size_t i = 0; i < n; i++) {
            times[i] = 2451000.7;
            values[i] = uniform(&state);
            sigmas[i] = 1 + uniform(&state);
        }
        period = make(NULL);
        assert_ok(toliman_period_push_many(period, times, values, sigmas, n));
        assert_ok(toliman_period_query_fit(period, times, values, sigmas, NULL, n, &fit));
        assert_true(fit.power == 0 && isinf(fit.amplitude_error) && isinf(fit.period_error) && isinf(fit.fwhm));
        toliman_period_destroy(period);
    }
}

TEST(times_have_a_limit) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0, 1e-300, 10, NULL, &period));
    assert_refused(toliman_period_push(period, 1e200, 1, 1), TOLIMAN_E_RANGE, "t");
    for (int i = 0; i < 6; i++) {
        times[i] = (i - 3) * 3e99;
        values[i] = i % 3;
        assert_ok(toliman_period_push(period, times[i], values[i], 1));
    }
    double fap;
    assert_ok(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_BALUEV, -2, &fap));
    assert_true(fap <= 0 && isfinite(fap));
    toliman_period_destroy(period);
}

static uint32_t crc32(const unsigned char *bytes, size_t size) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

/* States with a correct checksum and impossible content; offsets as in tools/docs/formats.md. */
/* promises: damaged-states-are-refused, other-versions-are-refused */
TEST(crafted_state_is_refused) {
    enum { COUNT = 104, PAIRS = 112, DIGITS = 148, SUMS = 2948, EXACT = 560 };
    static const struct {
        size_t at;
        int64_t value;
        const char *text;
    } cases[] = {
        {COUNT, INT64_MAX, "count"},
        {COUNT, -1, "count"},
        {COUNT, ((int64_t)1 << 43) + 1, "count"},
        {PAIRS, INT64_MAX, ""},
        {PAIRS, (int64_t)11 << 18, ""},
        {SUMS, INT64_MIN, ""},
        {DIGITS + EXACT - 8, INT64_MIN, ""},
        {DIGITS + 8, -1, ""},
        {DIGITS + 16, (int64_t)1 << 32, ""},
        {DIGITS + EXACT - 8, 1, ""},
        {DIGITS + EXACT - 16, 1, ""},
        {DIGITS + EXACT + EXACT - 8, INT64_MAX, ""},
        {DIGITS + 4 * EXACT + 8 * 60, 1, ""},
        /* What no nine samples of weight 1 have: digit 36 is that of whole numbers. */
        {COUNT, 8, "count"},
        {DIGITS + 8 * 36, 8, ""},
        {DIGITS + 8 * 36, 0, "count"},
        {DIGITS + EXACT + 8 * 36, 10, ""},
        {DIGITS + 2 * EXACT + 8 * 36, 10, ""},
        {PAIRS, (int64_t)8 << 18, ""},
        {SUMS, (int64_t)11 << 18, ""},
    };
    toliman_period *period = NULL, *loaded = NULL;
    assert_ok(toliman_period_create(0.01, 0.01, 5, NULL, &period));
    for (int i = 0; i < 9; i++)
        assert_ok(toliman_period_push(period, i, i % 4, 1));
    unsigned char bytes[8192], bad[8192];
    size_t size;
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    assert_int_equal(size, SUMS + 96 * 5 + 4);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        memcpy(bad, bytes, size);
        memcpy(bad + cases[i].at, &cases[i].value, 8);
        const uint32_t crc = crc32(bad, size - 4);
        memcpy(bad + size - 4, &crc, 4);
        assert_refused(toliman_period_load(bad, size, NULL, &loaded), TOLIMAN_E_FORMAT, cases[i].text);
    }
    /* The largest number of samples: no more are accepted, and the saved state loads. */
    memcpy(bad, bytes, size);
    const int64_t most = (int64_t)1 << 43;
    memcpy(bad + COUNT, &most, 8);
    const int64_t weight = (int64_t)1 << 61, digits[2] = {0, 1 << 11}; /* 2^43 */
    memcpy(bad + PAIRS, &weight, 8);
    memcpy(bad + DIGITS + 8 * 36, digits, sizeof digits);
    uint32_t crc = crc32(bad, size - 4);
    memcpy(bad + size - 4, &crc, 4);
    assert_ok(toliman_period_load(bad, size, NULL, &loaded));
    assert_refused(toliman_period_push(loaded, 1, 1, 1), TOLIMAN_E_RANGE, "");
    assert_refused(toliman_period_merge(loaded, period), TOLIMAN_E_RANGE, "");
    assert_refused(toliman_period_merge(period, loaded), TOLIMAN_E_RANGE, "");
    toliman_period_destroy(loaded);
    loaded = NULL;
    /* The previous version. */
    memcpy(bad, bytes, size);
    bad[4] = 1;
    assert_fails(toliman_period_load(bad, size, NULL, &loaded), TOLIMAN_E_FORMAT, "version 1 ");
    toliman_period_destroy(period);
}

/* The header determines the size before anything else is read: 8 GiB of another file cost nothing. */
/* promise: damaged-states-are-refused */
TEST(large_foreign_file_is_not_read) {
    char path[] = "large.XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    toliman_period *period = make(NULL), *loaded = NULL;
    unsigned char bytes[16384];
    size_t size;
    const off_t large = (off_t)1 << 33;
    assert_int_equal(ftruncate(file, large), 0);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    assert_int_equal(pwrite(file, bytes, size, 0), (ssize_t)size);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_int_equal(ftruncate(file, (off_t)size - 1), 0);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_int_equal(ftruncate(file, 5), 0);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_int_equal(ftruncate(file, 0), 0);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_null(loaded);
    toliman_period_destroy(period);
    close(file);
    unlink(path);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
static size_t allocated_bytes(void) {
    const struct mallinfo2 usage = mallinfo2();
    return usage.uordblks + usage.hblkhd;
}

/* promise: pushes-allocate-nothing */
TEST(memory_is_allocated_at_creation) {
    enum { MANY = 1 << 20 };
    for (int double_limb = 0; double_limb < 2; double_limb++) {
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.sigma_ceiling = double_limb ? 1e8 : 0;
        toliman_period *period = NULL;
        const size_t before = allocated_bytes();
        assert_ok(toliman_period_create(0, 1e-6, MANY, &options, &period));
        assert_close((double)(allocated_bytes() - before) / MANY, double_limb ? 225 : 129, 0, 1);
        toliman_period_peak peak = {.struct_size = sizeof peak};
        double power[NF];
        size_t needed;
        asked = 0;
        for (int i = 0; i < 6; i++)
            assert_ok(toliman_period_push(period, i, i % 3, 1));
        assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, NF, power));
        if (!double_limb) /* a million frequencies in 113 bits take long */
            assert_ok(toliman_period_query_peak(period, &peak));
        assert_int_equal(asked, 0);
        assert_asks(toliman_period_save(period, NULL, 0, &needed)); /* an exception of the promise, as is any save */
        assert_int_equal(needed, 2948 + (double_limb ? 168 : 96) * (size_t)MANY + 4);
        toliman_period_destroy(period);
    }
}

/* A window sliding over many samples, with occasional queries: no allocation. */
TEST(pushes_allocate_nothing) {
    enum { WINDOW = 1000, PUSHES = 100000 };
    toliman_period *period = make(NULL);
    double power[NF];
    long size = 0;
    for (int i = 0; i < PUSHES; i++) {
        assert_ok(toliman_period_push(period, i, i % 97, 1));
        if (i >= WINDOW)
            assert_ok(retract(period, i - WINDOW, (i - WINDOW) % 97, 1));
        if (i % 10000 == 0)
            assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, NF, power));
        if (i == 10000) {
            size = own_memory();
            asked = 0;
        }
    }
    assert_int_equal(asked, 0);
    assert_true(own_memory() <= size || getenv("TOLIMAN_EMULATED") != NULL); /* the emulator's grows */
    assert_int_equal(count_of(period), WINDOW);
    toliman_period_destroy(period);
}
#else
TEST(memory_is_allocated_at_creation) {}

TEST(pushes_allocate_nothing) {}
#endif

/* A signal of half a cycle more than the series holds: the power rises beyond the first frequency, and no peak is
 * reported there. */
TEST(peak_at_the_edge_is_flagged) {
    for (int i = 0; i < N; i++) {
        times[i] = i;
        values[i] = sin(2 * M_PI * i / 310);
        sigmas[i] = 1;
    }
    const struct {
        double f0, df;
        int64_t nf;
        double edge; /* 0: the peak is not at an edge */
    } grids[] = {{0.005, 0.001, 50, 0.005}, {0.0001, 0.0002, 11, 0.0021}, {0.004, 1, 1, 0.004},
                 {0.001, 0.0005, 50, 0},    {0.0032, 0.001, 9, 0},        {0, 0.0005, 20, 0}};
    for (size_t i = 0; i < sizeof grids / sizeof grids[0]; i++) {
        toliman_period *period = NULL;
        toliman_period_peak fit = {.struct_size = sizeof fit}, peak = {.struct_size = sizeof peak};
        assert_ok(toliman_period_create(grids[i].f0, grids[i].df, grids[i].nf, NULL, &period));
        assert_ok(toliman_period_push_many(period, times, values, sigmas, N));
        assert_ok(toliman_period_query_fit(period, times, values, sigmas, NULL, N, &fit));
        assert_ok(toliman_period_query_peak(period, &peak));
        const uint32_t others = /* T is 200 */
            TOLIMAN_PERIOD_LONG | (grids[i].df > 0.0011 ? TOLIMAN_PERIOD_COARSE : 0);
        assert_int_equal(fit.flags, (grids[i].edge > 0 ? TOLIMAN_PERIOD_AT_EDGE : 0) | others);
        if (grids[i].edge > 0) {
            assert_int_equal(peak.flags, TOLIMAN_PERIOD_AT_EDGE | others);
            assert_close(fit.frequency, grids[i].edge, 1e-14, 0);
            assert_close(peak.frequency, grids[i].edge, 1e-14, 0);
        } else {
            assert_close(fit.period, 310, 1e-9, 0);
        }
        toliman_period_destroy(period);
    }
    toliman_period *none = NULL;
    assert_invalid(toliman_period_create(0, 1, 1, NULL, &none), "f0");
}

/* Pure sines between grid points: a parabola through the powers would exceed the sine's power, even 1. */
/* promises: fits-beat-the-grid, peaks-are-not-overstated */
TEST(peak_power_is_not_overestimated) {
    for (int quarter = 0; quarter < 4; quarter++) {
        const double frequency = 0.01 + 0.25 * quarter / (10.0 * N);
        for (int i = 0; i < N; i++) {
            times[i] = i;
            values[i] = sin(2 * M_PI * frequency * i + 0.4);
        }
        toliman_period *period = NULL;
        toliman_period_peak fit = {.struct_size = sizeof fit}, peak = {.struct_size = sizeof peak};
        double power[200], highest = 0;
        assert_ok(toliman_period_create(0.01 - 10.0 / (10 * N), 1.0 / (10 * N), 200, NULL, &period));
        assert_ok(toliman_period_push_many(period, times, values, NULL, N));
        assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 200, power));
        for (int k = 0; k < 200; k++)
            highest = fmax(highest, power[k]);
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, N, &fit));
        assert_close(peak.frequency, frequency, 0, 0.1 / (10 * N));
        assert_close(peak.power, highest, 0, 1e-13); /* computed with vector instructions */
        assert_true(peak.log10_residual >= fit.log10_residual && peak.log10_fap >= fit.log10_fap);
        if (quarter > 0)
            assert_close(peak.log10_residual, log10(1 - highest), 0, 1e-9);
        toliman_period_destroy(period);
    }
}

RUN_TESTS(NULL, NULL)
