/* Tests samples in their three forms, with and without sigmas, and the retraction of samples that were never pushed. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "samples.h"
#include "test_folder.h"
#include "uniform.h"

#include <toliman/period_batch.h>
#include <toliman/period_fap.h>

enum { kCount = 40, kCapacity = 400000 };
static double t[kCount], y[kCount], sigma[kCount];

static void fill(double noise) {
    uint64_t state = 5;
    for (int i = 0; i < kCount; i++) {
        t[i] = i + 0.25 * uniform(&state);
        y[i] = 3 * sin(2 * M_PI * 0.11 * t[i] + 0.3) + noise * (uniform(&state) - 0.5);
        sigma[i] = 1 + uniform(&state);
    }
}

static toliman_period *make(uint32_t flags) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = flags;
    options.value_bound = 16;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.01, 0.0025, 180, &options, &period));
    return period;
}

static void assert_same_bytes(const toliman_period *a, const toliman_period *b) {
    static unsigned char bytes_a[kCapacity], bytes_b[kCapacity];
    size_t size_a, size_b;
    assert_ok(toliman_period_save(a, bytes_a, kCapacity, &size_a));
    assert_ok(toliman_period_save(b, bytes_b, kCapacity, &size_b));
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
}

/* Only one struct size exists in this version, so smaller and larger structs are refused. */
TEST(three_forms_are_equivalent) {
    fill(1);
    toliman_period *one = make(0), *many = make(0), *structs = make(0), *none = make(0);
    toliman_period_sample samples[kCount];
    for (int i = 0; i < kCount; i++) {
        assert_ok(toliman_period_push(one, t[i], y[i], sigma[i]));
        samples[i] = sample_pair(t[i], 0, y[i], sigma[i]);
    }
    assert_ok(toliman_period_push_many(many, t, y, sigma, kCount));
    assert_ok(toliman_period_push_samples(structs, samples, NULL, kCount));
    assert_same_bytes(one, many);
    assert_same_bytes(one, structs);
    assert_ok(toliman_period_push_samples(structs, NULL, NULL, 0));
    assert_ok(toliman_period_retract_samples(structs, samples, NULL, kCount));
    assert_same_bytes(structs, none);
    assert_invalid(toliman_period_push_samples(structs, NULL, NULL, 1), "samples");
    samples[0].struct_size = 8;
    assert_invalid(toliman_period_push_samples(structs, samples, NULL, 2), "samples->struct_size");
    toliman_period_destroy(one), toliman_period_destroy(many);
    toliman_period_destroy(structs), toliman_period_destroy(none);
}

TEST(a_time_in_the_other_member_is_refused) {
    toliman_period *period = make(0);
    toliman_period_sample samples[3] = {sample_pair(1, 0, 1, 1), sample_pair(2, 0, 1, 1), sample_ns(0, 1, 1)};
    samples[1].t_ns = 5;
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 3), "samples[1].t_ns");
    samples[1].t_ns = 0;
    samples[2].t = 7;
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 3), "samples[2].t");
    samples[2].t = 0;
    samples[2].flags |= 1;
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 3), "samples[2].flags");
    samples[2].flags ^= 1;
    samples[1].y = NAN;
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 3), "y");
    assert_int_equal(count_of(period), 0);
    toliman_period_destroy(period);
}

/* Unweighted and weighted samples do not mix, in any order or form; a sigma of sigma_floor is compatible with both. */
TEST(samples_with_and_without_sigma_do_not_mix) {
    fill(1);
    toliman_period *weighted = make(0), *plain = make(0), *floor = make(0), *copy = NULL;
    toliman_period_sample samples[2] = {sample_pair(90, 0, 1, 0), sample_pair(91, 0, 1, 2)};
    assert_refused(toliman_period_push_samples(plain, samples, NULL, 2), TOLIMAN_E_STATE, "sigma");
    assert_ok(toliman_period_push_many(weighted, t, y, sigma, 20));
    assert_ok(toliman_period_push_many(plain, t, y, NULL, 20));
    assert_refused(toliman_period_push_many(weighted, t, y, NULL, 20), TOLIMAN_E_STATE, "sigma");
    assert_refused(retract_many(weighted, t, y, NULL, 1), TOLIMAN_E_STATE, "sigma");
    assert_refused(toliman_period_push_samples(weighted, samples, NULL, 1), TOLIMAN_E_STATE, "sigma");
    assert_refused(toliman_period_push(plain, 90, 1, 2), TOLIMAN_E_STATE, "sigma");
    assert_ok(toliman_period_copy(plain, &copy));
    assert_refused(toliman_period_push(copy, 90, 1, 2), TOLIMAN_E_STATE, "sigma");
    assert_refused(toliman_period_merge(plain, weighted), TOLIMAN_E_MISMATCH, "");
    assert_refused(toliman_period_merge(weighted, plain), TOLIMAN_E_MISMATCH, "");
    assert_same_bytes(plain, copy);

    double ones[kCount];
    for (int i = 0; i < kCount; i++)
        ones[i] = 1;
    assert_ok(toliman_period_push_many(floor, t, y, ones, 20));
    assert_same_bytes(floor, plain);
    assert_ok(toliman_period_push(plain, 90, 1, 1)); /* sigma_floor: the same weight as unweighted samples */
    assert_ok(toliman_period_push(floor, 90, 1, 2));
    assert_refused(toliman_period_push_many(floor, t, y, NULL, 1), TOLIMAN_E_STATE, "sigma");

    /* A saved state records that its samples have sigmas. An emptied periodogram accepts either kind. */
    static unsigned char bytes[kCapacity];
    size_t size;
    toliman_period *loaded = NULL;
    assert_ok(toliman_period_save(weighted, bytes, kCapacity, &size));
    assert_ok(toliman_period_load(bytes, size, NULL, &loaded));
    assert_refused(toliman_period_push_many(loaded, t, y, NULL, 1), TOLIMAN_E_STATE, "sigma");
    assert_ok(retract_many(copy, t, y, NULL, 20));
    assert_ok(toliman_period_push(copy, 90, 1, 2));
    toliman_period_destroy(weighted), toliman_period_destroy(plain), toliman_period_destroy(floor);
    toliman_period_destroy(copy), toliman_period_destroy(loaded);
}

/* Retractions that would make the totals impossible change nothing. */
/* promise: wrong-retracts-find-nothing */
TEST(impossible_totals_are_refused) {
    for (int last = 0; last < 3; last++) { /* for a single sample: wrong time, value, sigma */
        toliman_period *period = make(0), *same = make(0);
        assert_ok(toliman_period_push(period, 4, 2, 3));
        assert_ok(toliman_period_push(same, 4, 2, 3));
        assert_refused(retract(period, last == 0 ? 5 : 4, last == 1 ? 1 : 2, last == 2 ? 2 : 3), TOLIMAN_E_STATE, "");
        assert_same_bytes(period, same);
        assert_ok(retract(period, 4, 2, 3));
        toliman_period_destroy(period), toliman_period_destroy(same);
    }
    toliman_period *period = make(0), *same = make(0);
    double ones[] = {1, 1, 1}, times[] = {1, 2, 3}, far[] = {15, 15, 15};
    assert_ok(toliman_period_push_many(period, times, ones, NULL, 3));
    assert_ok(toliman_period_push_many(same, times, ones, NULL, 3));
    assert_refused(retract_many(period, times, far, NULL, 2), TOLIMAN_E_STATE, "");
    assert_same_bytes(period, same);
    toliman_period_destroy(period), toliman_period_destroy(same);
}

/* Retracts a sample with the wrong time. The power must never be 1: an impossible state is reported wherever it would
 * appear. */
/* promise: wrong-retracts-find-nothing */
TEST(a_wrong_retract_makes_no_perfect_detection) {
    static double power[180];
    uint64_t state = 77;
    int impossible = 0;
    fill(1.5);
    for (int trial = 0; trial < 400; trial++) {
        toliman_period *period = make(trial % 2 ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0), *loaded = NULL;
        assert_ok(toliman_period_push_many(period, t, y, NULL, 12));
        const double other = 3 * (2 * uniform(&state) - 1), when = 12 * uniform(&state);
        if (retract(period, when, other, 1) == TOLIMAN_OK) {
            static unsigned char bytes[kCapacity];
            size_t size;
            toliman_period_peak peak = {.struct_size = sizeof peak}, peaks[3] = {peak};
            size_t count;
            const toliman_status status = toliman_period_query_peak(period, &peak);
            assert_true(status == TOLIMAN_OK ? peak.power < 1 : status == TOLIMAN_E_STATE);
            memset(power, 0, sizeof power);
            assert_int_equal(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 180, power), status);
            for (int k = 0; k < 180; k++)
                assert_true(power[k] < 1 && (status == TOLIMAN_OK || power[k] == 0));
            assert_int_equal(toliman_period_query_peaks(period, peaks, 3, &count), status);
            assert_ok(toliman_period_save(period, bytes, kCapacity, &size));
            assert_ok(toliman_period_load(bytes, size, NULL, &loaded));
            assert_int_equal(toliman_period_query_peak(loaded, &peak), status);
            if (status != TOLIMAN_OK) {
                assert_non_null(strstr(toliman_last_error(), "a power above 1"));
                impossible++;
            }
            toliman_period_destroy(loaded);
        }
        toliman_period_destroy(period);
    }
    printf("%d of 400 wrong retracts leave a power above 1\n", impossible);
    assert_true(impossible > 100);
}

/* Sinusoids without noise, on and off the grid, few and many samples, in sliding windows: genuine perfect fits with
 * power 1. */
TEST(perfect_fits_are_accepted) {
    for (int way = 0; way < 48; way++) {
        const int double_limb = way & 1, heavy = way & 2, fixed = way & 4, few = 5 + (way >> 3) * 7;
        toliman_period *period =
            make((double_limb ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0) | (fixed ? TOLIMAN_PERIOD_FIXED_MEAN : 0));
        toliman_period_peak peak = {.struct_size = sizeof peak};
        double power[180];
        fill(0);
        for (int i = 0; i < kCount; i++) {
            y[i] = sin(2 * M_PI * (0.01 + 0.0025 * 40) * t[i]) + (fixed ? 0 : 9);
            sigma[i] = heavy ? 1 + 30.0 * i / kCount : 1;
        }
        for (int i = 0; i < kCount; i++) {
            assert_ok(toliman_period_push(period, t[i], y[i], sigma[i]));
            if (i >= few)
                assert_ok(retract(period, t[i - few], y[i - few], sigma[i - few]));
            if (i >= 5)
                assert_ok(toliman_period_query_peak(period, &peak));
            assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 180, power));
        }
        if (!fixed)
            assert_close(power[40], 1, 1e-9, 0);
        toliman_period_destroy(period);
    }
}

/* 0 in an option is its documented default, by the bits of the results. */
/* promise: zero-is-the-default */
TEST(zero_is_the_default_of_every_option) {
    fill(1);
    toliman_period_options zero = TOLIMAN_PERIOD_OPTIONS_INIT, filled = zero;
    filled.value_bound = 0x1p20, filled.sigma_floor = 1, filled.sigma_ceiling = 32, filled.unit_ns = 1e9;
    toliman_period *by_zero = NULL, *by_value = NULL;
    assert_ok(toliman_period_create(0.01, 0.0025, 180, &zero, &by_zero));
    assert_ok(toliman_period_create(0.01, 0.0025, 180, &filled, &by_value));
    for (int i = 0; i < kCount; i++) {
        assert_ok(push_ns(by_zero, (int64_t)(t[i] * 1e9), y[i], sigma[i]));
        assert_ok(push_ns(by_value, (int64_t)(t[i] * 1e9), y[i], sigma[i]));
    }
    assert_same_bytes(by_zero, by_value);
    toliman_period_info info = TOLIMAN_PERIOD_INFO_INIT;
    assert_ok(toliman_period_get_info(by_zero, &info));
    assert_true(info.value_bound == 0x1p20 && info.sigma_floor == 1 && info.sigma_ceiling == 32 && info.unit_ns == 1e9);

    toliman_period_bootstrap_options draws = TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT;
    double peaks[2][5];
    assert_ok(toliman_period_query_bootstrap(by_zero, t, y, sigma, kCount, &draws, 5, peaks[0]));
    assert_ok(toliman_period_query_bootstrap(by_zero, t, y, sigma, kCount, NULL, 5, peaks[1]));
    assert_memory_equal(peaks[0], peaks[1], sizeof peaks[0]);
    toliman_period_destroy(by_zero), toliman_period_destroy(by_value);
}

/* The same for a batch, on an archive large enough for an FFT; direct sums are requested by a flag. */
/* promise: zero-is-the-default */
TEST(zero_is_the_default_of_a_batch) {
    enum { kMany = 1500, kGrid = 2000 };
    static double times[kMany], values[kMany], power[4][kGrid];
    uint64_t state = 3;
    for (int i = 0; i < kMany; i++) {
        times[i] = i + uniform(&state);
        values[i] = sin(0.3 * times[i]) + uniform(&state);
    }
    toliman_period_batch_options zero = TOLIMAN_PERIOD_BATCH_OPTIONS_INIT, filled = zero;
    filled.tolerance = 1e-9;
    const double f0 = 1e-3, df = 1e-4;
    assert_ok(toliman_period_batch(f0, df, kGrid, times, values, NULL, kMany, &zero, power[0]));
    assert_ok(toliman_period_batch(f0, df, kGrid, times, values, NULL, kMany, &filled, power[1]));
    assert_memory_equal(power[0], power[1], sizeof power[0]);
    zero.flags = TOLIMAN_PERIOD_DIRECT;
    assert_ok(toliman_period_batch(f0, df, kGrid, times, values, NULL, kMany, &zero, power[2]));
    filled.tolerance = 1e-14;
    assert_ok(toliman_period_batch(f0, df, kGrid, times, values, NULL, kMany, &filled, power[3]));
    assert_memory_equal(power[2], power[3], sizeof power[2]);
    for (int k = 0; k < kGrid; k++)
        assert_close(power[0][k], power[2][k], 0, 1e-9);
    assert_true(memcmp(power[0], power[2], sizeof power[0]) != 0);
}

/* After the only unweighted sample is retracted, samples with any sigma are accepted. */
TEST(the_last_sample_without_sigma_can_be_retracted) {
    toliman_period *period = make(0);
    const double time = 1, value = 2;
    assert_ok(toliman_period_push_many(period, &time, &value, NULL, 1));
    assert_ok(toliman_period_push(period, 2, 1, 1)); /* sigma_floor goes with both */
    assert_refused(toliman_period_push(period, 3, 1, 2), TOLIMAN_E_STATE, "sigma");
    assert_ok(retract_many(period, &time, &value, NULL, 1));
    assert_ok(toliman_period_push(period, 3, 1, 2));
    toliman_period_destroy(period);
    const toliman_period_sample sample = TOLIMAN_PERIOD_SAMPLE_INIT;
    period = make(0);
    assert_refused(toliman_period_push_samples(period, &sample, NULL, SIZE_MAX), TOLIMAN_E_RANGE, "samples");
    toliman_period_destroy(period);
}

/* Sums that were re-referenced by a merge are saved, loaded and queried like others, although they have rounding
 * errors. */
TEST(re_referenced_sums_survive_saving) {
    static unsigned char bytes[kCapacity];
    double power[2][180];
    for (uint32_t flags = 0; flags <= TOLIMAN_PERIOD_DOUBLE_LIMB; flags += TOLIMAN_PERIOD_DOUBLE_LIMB) {
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.flags = flags;
        options.value_bound = 8192;
        toliman_period *there = NULL, *here = NULL, *again = NULL;
        assert_ok(toliman_period_create(0.01, 0.0025, 180, &options, &there));
        options.value_bound = 2.9e-5;
        options.time_offset = 2459000.123456;
        options.value_offset = 7137.1;
        assert_ok(toliman_period_create(0.01, 0.0025, 180, &options, &here));
        for (int i = 0; i < kCount; i++)
            assert_ok(toliman_period_push(there, 2459000 + i, 7137.1 + 2e-5 * sin(0.7 * i), 1 + i % 3));
        assert_ok(toliman_period_merge(here, there));
        size_t size;
        assert_ok(toliman_period_save(here, bytes, kCapacity, &size));
        assert_ok(toliman_period_load(bytes, size, NULL, &again));
        assert_ok(toliman_period_query_power(here, TOLIMAN_PERIOD_POWER_STANDARD, 0, 180, power[0]));
        assert_ok(toliman_period_query_power(again, TOLIMAN_PERIOD_POWER_STANDARD, 0, 180, power[1]));
        assert_memory_equal(power[0], power[1], sizeof power[0]);
        toliman_period_destroy(there), toliman_period_destroy(here), toliman_period_destroy(again);
    }
}

/* 2^48 cycles from the offset: the product f t in double would be wrong by 1/32 cycle. */
TEST(a_distant_sample_is_saved) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = TOLIMAN_PERIOD_DOUBLE_LIMB;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(18.808776142838681, 1e-3, 1, &options, &period));
    assert_ok(toliman_period_push(period, 18039215772513.445, 1.5, 1));
    size_t size;
    static unsigned char bytes[kCapacity];
    assert_ok(toliman_period_save(period, bytes, kCapacity, &size));
    toliman_period_destroy(period);
}

/* A grid in 1/day: with times in seconds, fit and peaks set a flag; with times in days they do not. */
TEST(a_grid_in_another_unit_is_flagged) {
    const uint32_t both = TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_ABOVE_NYQUIST;
    fill(1);
    for (int way = 0; way < 3; way++) { /* days; seconds; nanoseconds with the default unit_ns */
        toliman_period *period = make(0);
        double times[kCount];
        for (int i = 0; i < kCount; i++) {
            times[i] = t[i] * (way == 0 ? 1 : 86400);
            assert_ok(way < 2 ? toliman_period_push(period, times[i], y[i], 1)
                              : push_ns(period, (int64_t)(times[i] * 1e9), y[i], 1));
        }
        toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT, fit = peak, peaks[2] = {peak};
        size_t count;
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_ok(toliman_period_query_peaks(period, peaks, 2, &count));
        assert_ok(toliman_period_query_fit(period, times, y, NULL, NULL, kCount, &fit));
        assert_int_equal(peak.flags & both, way == 0 ? 0 : TOLIMAN_PERIOD_COARSE);
        assert_int_equal(peaks[0].flags & both, way == 0 ? 0 : TOLIMAN_PERIOD_COARSE);
        assert_int_equal(fit.flags & both, way == 0 ? 0 : both);
        toliman_period_destroy(period);
    }
}

/* On the suggested grid, and on one beyond the ceiling, for two nights with many samples and for even days. */
TEST(ordinary_grids_have_no_flag) {
    uint64_t state = 9;
    for (int nights = 0; nights < 2; nights++) {
        double times[kCount], values[kCount], f0, df;
        int64_t nf;
        for (int i = 0; i < kCount; i++) {
            times[i] = nights ? (i < kCount / 2 ? 0.01 * i : 3 + 0.01 * i) : i;
            values[i] = uniform(&state);
        }
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        assert_ok(toliman_period_suggest(times, values, NULL, kCount, 0, &f0, &df, &nf, &options));
        for (int further = 1; further < 3; further++) {
            toliman_period *period = NULL;
            toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT, fit = peak;
            assert_ok(toliman_period_create(f0, df, nf * further, &options, &period));
            assert_ok(toliman_period_push_many(period, times, values, NULL, kCount));
            assert_ok(toliman_period_query_peak(period, &peak));
            assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, kCount, &fit));
            const uint32_t both = TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_ABOVE_NYQUIST;
            assert_int_equal(peak.flags & both, 0);
            assert_int_equal(fit.flags & both, further == 1 ? 0 : TOLIMAN_PERIOD_ABOVE_NYQUIST);
            toliman_period_destroy(period);
        }
    }
}

RUN_TESTS(NULL, NULL)
