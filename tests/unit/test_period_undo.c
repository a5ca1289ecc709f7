/* Tests retracted samples, merged shards, sliding windows and times in nanoseconds: by their bits, and against 113-bit
 * sums. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "quad_period.h"
#include "samples.h"
#include "test_folder.h"
#include "uniform.h"

#include <toliman/period.h>

enum { kMost = 6000 };
static double times[kMost], values[kMost], sigmas[kMost];

static uint64_t state = 11;

static toliman_period_options options_for(int double_limb) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.time_offset = 2451000.5;
    options.value_bound = 64;
    options.sigma_floor = 0.1;
    options.sigma_ceiling = double_limb ? 1e5 : 0;
    return options;
}

static toliman_period *make(const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(1e-3, 1.7e-4, 300, options, &period));
    return period;
}

static void fill(int double_limb) {
    state = 11;
    for (int i = 0; i < kMost; i++) {
        times[i] = 2451000.5 + 4000 * uniform(&state);
        values[i] = 3 * sin(0.05 * times[i]) + uniform(&state);
        sigmas[i] = double_limb ? 0.1 * pow(1e5, uniform(&state)) : 0.1 + uniform(&state);
    }
}

static void push(toliman_period *period, int i) {
    assert_ok(toliman_period_push(period, times[i], values[i], sigmas[i]));
}

static uint8_t *bytes_of(const toliman_period *period, size_t *size) {
    assert_asks(toliman_period_save(period, NULL, 0, size));
    uint8_t *bytes = malloc(*size);
    assert_ok(toliman_period_save(period, bytes, *size, size));
    return bytes;
}

static void assert_same_bytes(const toliman_period *a, const toliman_period *b) {
    size_t size_a, size_b;
    uint8_t *bytes_a = bytes_of(a, &size_a), *bytes_b = bytes_of(b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
    free(bytes_a), free(bytes_b);
}

/* More than 4096 pushes, so that sums are folded in between; retracted in another order. */
/* promise: retractions-are-exact */
TEST(test_retract_undoes_push) {
    for (int double_limb = 0; double_limb < 2; double_limb++) {
        fill(double_limb);
        const toliman_period_options options = options_for(double_limb);
        toliman_period *all = make(&options), *half = make(&options), *none = make(&options);
        for (int i = 0; i < kMost; i++)
            push(all, i);
        for (int i = kMost - 2; i >= 0; i -= 2)
            push(half, i);
        for (int i = 1; i < kMost; i += 2) {
            const int k = (i * 7 + 2998) % kMost | 1; /* every odd one once */
            assert_ok(retract(all, times[k], values[k], sigmas[k]));
        }
        assert_int_equal(count_of(all), kMost / 2);
        assert_same_bytes(all, half);
        for (int i = 0; i < kMost; i += 2)
            assert_ok(retract(all, times[i], values[i], sigmas[i]));
        assert_same_bytes(all, none);
        assert_refused(retract(all, times[0], values[0], sigmas[0]), TOLIMAN_E_STATE, "");
        toliman_period_destroy(all), toliman_period_destroy(half), toliman_period_destroy(none);
    }
}

/* promise: pushes-take-all-or-none */
TEST(test_retract_many_is_all_or_none) {
    fill(0);
    const toliman_period_options options = options_for(0);
    toliman_period *period = make(&options), *other = make(&options);
    assert_ok(toliman_period_push_many(period, times, values, sigmas, 100));
    assert_ok(toliman_period_push_many(other, times, values, sigmas, 100));
    const double kept = values[60];
    values[60] = NAN;
    assert_fails(retract_many(period, times, values, sigmas, 100), TOLIMAN_E_ARGUMENT, "sample 60");
    values[60] = kept;
    assert_fails(retract_many(period, times, values, sigmas, 101), TOLIMAN_E_STATE,
                 "cannot retract 101 samples: the periodogram has 100");
    assert_same_bytes(period, other);
    assert_ok(retract_many(period, times + 40, values + 40, sigmas + 40, 60));
    toliman_period_destroy(other);
    other = make(&options);
    assert_ok(toliman_period_push_many(other, times, values, sigmas, 40));
    assert_same_bytes(period, other);
    toliman_period_destroy(period), toliman_period_destroy(other);
}

/* promise: retractions-are-exact */
/* Also of sums that were folded, after 4,096 pushes. */
TEST(test_shards_merge_to_the_same_bits) {
    for (int double_limb = 0; double_limb < 2; double_limb++) {
        fill(double_limb);
        const toliman_period_options options = options_for(double_limb);
        toliman_period *whole = make(&options), *shards[2] = {make(&options), make(&options)};
        for (int i = 0; i < kMost; i++)
            push(whole, i), push(shards[uniform(&state) < 0.8], i);
        assert_ok(toliman_period_merge(shards[0], shards[1]));
        assert_same_bytes(shards[0], whole);
        toliman_period_destroy(whole), toliman_period_destroy(shards[0]), toliman_period_destroy(shards[1]);
    }
}

TEST(test_window_slides) {
    enum { kWindow = 50 };
    fill(0);
    const toliman_period_options options = options_for(0);
    toliman_period *sliding = make(&options), *fresh = make(&options);
    for (int i = 0; i < 400; i++) {
        push(sliding, i);
        if (i >= kWindow)
            assert_ok(retract(sliding, times[i - kWindow], values[i - kWindow], sigmas[i - kWindow]));
    }
    for (int i = 350; i < 400; i++)
        push(fresh, i);
    assert_same_bytes(sliding, fresh);
    toliman_period_destroy(sliding), toliman_period_destroy(fresh);
}

TEST(test_copies_are_independent) {
    fill(0);
    const toliman_period_options options = options_for(0);
    toliman_period *one = make(&options), *copy = NULL;
    assert_ok(toliman_period_push_many(one, times, values, sigmas, 20));
    assert_ok(toliman_period_copy(one, &copy));
    assert_same_bytes(one, copy);
    push(copy, 20);
    assert_int_equal(count_of(one), 20);
    assert_int_equal(count_of(copy), 21);
    toliman_period_destroy(one), toliman_period_destroy(copy);
}

/* Shards with different references: after re-referencing to the first one's, the power agrees with 113-bit sums. */
/* promise: other-references-merge */
TEST(test_merge_of_other_references) {
    for (int double_limb = 0; double_limb < 2; double_limb++) {
        fill(double_limb);
        toliman_period_options options = options_for(double_limb), other = options;
        other.time_offset = 2453333.25;
        other.value_offset = 1.7;
        other.value_bound = 40;
        other.sigma_floor = double_limb ? 0.1 : 0.1;
        other.sigma_ceiling = double_limb ? 1e4 : 2;
        for (int i = 300; i < 600; i++)
            sigmas[i] = fmin(sigmas[i], other.sigma_ceiling);
        toliman_period *first = make(&options), *second = make(&other);
        assert_ok(toliman_period_push_many(first, times, values, sigmas, 300));
        assert_ok(toliman_period_push_many(second, times + 300, values + 300, sigmas + 300, 300));
        assert_ok(toliman_period_merge(first, second));
        assert_int_equal(count_of(first), 600);
        double power[300];
        assert_ok(toliman_period_query_power(first, TOLIMAN_PERIOD_POWER_STANDARD, 0, 300, power));
        const quad_samples samples = {times, values, sigmas, 600, NULL};
        for (int k = 0; k < 300; k += 13) {
            const quad f = (quad)1e-3 + (quad)1.7e-4 * k;
            assert_close(power[k], (double)(1 - quad_residual(&samples, f, 0)), 0, 1e-12);
        }
        toliman_period_destroy(first), toliman_period_destroy(second);
    }
}

/* Two nights, each with its own suitable options: value offset by its first value, sigmas about its own. */
/* promise: other-references-merge */
TEST(test_merge_of_two_nights) {
    fill(0);
    toliman_period *nights[2];
    for (int night = 0; night < 2; night++) {
        toliman_period_options options = options_for(0);
        const int first = 300 * night;
        options.time_offset = times[first];
        options.value_offset = values[first];
        options.value_bound = 8; /* of values within 5 of each other */
        for (int i = 0; i < 300; i++)
            sigmas[first + i] = (night ? 0.3 : 0.2) * (1 + uniform(&state));
        options.sigma_floor = sigmas[first] / 8;
        options.sigma_ceiling = sigmas[first] * 4;
        nights[night] = make(&options);
        assert_ok(toliman_period_push_many(nights[night], times + first, values + first, sigmas + first, 300));
    }
    const quad_samples samples = {times, values, sigmas, 600, NULL};
    for (int into = 0; into < 2; into++) {
        toliman_period *both = NULL;
        assert_ok(toliman_period_copy(nights[into], &both));
        assert_ok(toliman_period_merge(both, nights[1 - into]));
        double power[300];
        assert_ok(toliman_period_query_power(both, TOLIMAN_PERIOD_POWER_STANDARD, 0, 300, power));
        for (int k = 0; k < 300; k += 13) {
            const quad f = (quad)1e-3 + (quad)1.7e-4 * k;
            assert_close(power[k], (double)(1 - quad_residual(&samples, f, 0)), 1e-12, 1e-14);
        }
        toliman_period_destroy(both);
    }
    toliman_period_destroy(nights[0]), toliman_period_destroy(nights[1]);
}

TEST(test_merge_refuses) {
    const toliman_period_options options = options_for(0);
    toliman_period_options other = options;
    toliman_period *period = make(&options), *odd = NULL;
    assert_invalid(toliman_period_merge(period, period), "other");
    assert_invalid(toliman_period_merge(period, NULL), "other");
    assert_ok(toliman_period_create(1e-3, 1.7e-4, 301, &options, &odd));
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_MISMATCH, "");
    toliman_period_destroy(odd);
    other.flags = TOLIMAN_PERIOD_FIXED_MEAN;
    odd = make(&other);
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_MISMATCH, "");
    toliman_period_destroy(odd);
    other = options;
    other.value_bound = 100;
    odd = make(&other);
    assert_ok(toliman_period_merge(period, odd)); /* empty, so nothing can be incompatible */
    for (int i = 0; i < 4; i++)
        assert_ok(toliman_period_push(odd, 2451000.5 + i, 70, 1));
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_RANGE, "value_bound");
    toliman_period_destroy(odd);
    other = options;
    other.sigma_floor = 0.05;
    odd = make(&other);
    assert_ok(toliman_period_push(odd, 2451000.5, 1, 0.09));
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_RANGE, "sigma_floor");
    toliman_period_destroy(odd);
    other = options;
    other.flags = TOLIMAN_PERIOD_DOUBLE_LIMB;
    odd = make(&other);
    assert_ok(toliman_period_push(period, 2451000.5, 1, 1));
    assert_refused(toliman_period_merge(odd, period), TOLIMAN_E_MISMATCH, "");
    assert_ok(retract(period, 2451000.5, 1, 1));
    toliman_period_destroy(odd);
    other = options;
    other.sigma_floor = 1;
    other.sigma_ceiling = 10;
    odd = make(&other);
    assert_ok(toliman_period_push(odd, 2451000.5, 1, 9));
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_RANGE, "sigma_floor");
    toliman_period_destroy(odd);
    assert_int_equal(count_of(period), 0);
    other = options;
    other.unit_ns = 86400e9;
    odd = make(&other);
    assert_refused(toliman_period_merge(period, odd), TOLIMAN_E_MISMATCH, "time_offset_ns");
    toliman_period_destroy(odd), toliman_period_destroy(period);
}

/* Camera times of 1.7e18 ns, in days; the same times as pairs of doubles; both against 113-bit sums. */
TEST(test_times_in_nanoseconds_and_pairs) {
    enum { kCount = 300 };
    fill(0);
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.unit_ns = 86400e9;
    options.time_offset_ns = 1700000000123456789;
    options.value_bound = 64;
    options.sigma_floor = 0.1;
    toliman_period *by_ns = NULL, *by_pair = NULL;
    /* 40,000 cycles in the span: a nanosecond (1e-14 d) is visible in the phase */
    assert_ok(toliman_period_create(9.5, 1e-4, 200, &options, &by_ns));
    assert_ok(toliman_period_create(9.5, 1e-4, 200, &options, &by_pair));
    static double days[kCount], low[kCount];
    for (int i = 0; i < kCount; i++) {
        const int64_t ns = options.time_offset_ns + (int64_t)(4000 * 86400e9 * uniform(&state)) - 5;
        const quad t = (quad)(ns - options.time_offset_ns) / options.unit_ns;
        days[i] = (double)t;
        low[i] = (double)(t - days[i]);
        const toliman_period_sample of_ns = sample_ns(ns, values[i], sigmas[i]);
        const toliman_period_sample of_pair = sample_pair(days[i], low[i], values[i], sigmas[i]);
        assert_ok(toliman_period_push_samples(by_ns, &of_ns, NULL, 1));
        assert_ok(toliman_period_push_samples(by_pair, &of_pair, NULL, 1));
        if (i == 7) { /* retracted and pushed again */
            assert_ok(toliman_period_retract_samples(by_ns, &of_ns, NULL, 1));
            assert_ok(toliman_period_push_samples(by_ns, &of_ns, NULL, 1));
            assert_ok(toliman_period_retract_samples(by_pair, &of_pair, NULL, 1));
            assert_ok(toliman_period_push_samples(by_pair, &of_pair, NULL, 1));
        }
    }
    const toliman_period_sample not_finite = sample_pair(1, NAN, 0, 1), too_large = sample_ns(INT64_MIN, 100, 1);
    assert_invalid(toliman_period_push_samples(by_pair, &not_finite, NULL, 1), "t");
    assert_refused(toliman_period_push_samples(by_ns, &too_large, NULL, 1), TOLIMAN_E_RANGE, "y");
    const quad_samples samples = {days, values, sigmas, kCount, low};
    double power[2][200];
    assert_ok(toliman_period_query_power(by_ns, TOLIMAN_PERIOD_POWER_STANDARD, 0, 200, power[0]));
    assert_ok(toliman_period_query_power(by_pair, TOLIMAN_PERIOD_POWER_STANDARD, 0, 200, power[1]));
    for (int k = 0; k < 200; k += 11) {
        const quad f = (quad)9.5 + (quad)1e-4 * k;
        const double expected = (double)(1 - quad_residual(&samples, f, 0));
        assert_close(power[0][k], expected, 0, 1e-13);
        assert_close(power[1][k], expected, 0, 1e-13);
    }
    options.unit_ns = 0.5;
    toliman_period *none = NULL;
    assert_invalid(toliman_period_create(9.5, 1e-4, 200, &options, &none), "options->unit_ns");
    toliman_period_destroy(by_ns), toliman_period_destroy(by_pair);
}

/* Sums that no samples can produce are reported when they are saved, not only when they are loaded; the previous file
 * is kept. */
/* promise: unloadable-states-are-not-saved */
TEST(unloadable_state_is_not_saved) {
    unsigned char bytes[8192];
    char folder[256], path[300];
    size_t size;
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/sums", folder);
    toliman_period *period = NULL, *other = NULL, *loaded = NULL;
    assert_ok(toliman_period_create(0.1, 0.1, 3, NULL, &period));
    assert_ok(toliman_period_push(period, 1, 2, 1));
    assert_ok(toliman_period_save_file(period, path));
    for (int i = 0; i < 3; i++)
        assert_ok(toliman_period_push(period, i, 1000000, 1));
    assert_refused(retract(period, 10, -1000000, 1), TOLIMAN_E_STATE, "");
    toliman_period_destroy(period);

    /* One of a hundred samples has a weight below the allowed range. */
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.sigma_ceiling = 4;
    assert_ok(toliman_period_create(0.1, 0.1, 3, &options, &period));
    options.sigma_ceiling = 32;
    assert_ok(toliman_period_create(0.1, 0.1, 3, &options, &other));
    for (int i = 0; i < 100; i++)
        assert_ok(toliman_period_push(other, i, 1, i == 0 ? 30 : 1));
    assert_ok(toliman_period_merge(period, other));
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    assert_ok(toliman_period_load(bytes, size, NULL, &loaded));
    toliman_period_destroy(loaded);
    for (int i = 1; i < 100; i++)
        assert_ok(retract(period, i, 1, 1));
    assert_refused(toliman_period_save(period, bytes, sizeof bytes, &size), TOLIMAN_E_STATE, "count");
    assert_refused(toliman_period_save_file(period, path), TOLIMAN_E_STATE, "count");
    assert_ok(toliman_period_load_file(path, NULL, &loaded));
    assert_int_equal(count_of(loaded), 1);
    toliman_period_destroy(loaded), toliman_period_destroy(period), toliman_period_destroy(other);
    remove_folder(folder);
}

RUN_TESTS(NULL, NULL)
