/* Tests nuisance functions of the periodogram: the same bits in any order, shards and after retraction; state bytes;
 * refusals; which functions are in use. Powers, fits and coefficients: tests/bind/test_nuisance.py. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "samples.h"
#include "uniform.h"

#include <toliman/period_fap.h>
#include <toliman/period_nuisance.h>

enum { kMost = 5000, kShards = 64, kColumns = 2, kFrequencies = 200, kFunctions = 6 };
static toliman_period_sample samples[kMost];
static double rows[kMost][kColumns];

static toliman_period_options options_for_rows(void) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.time_offset = 2451000.5;
    options.value_bound = 64;
    options.sigma_floor = 0.1;
    options.sigma_ceiling = 10;
    options.trend = 3;
    options.trend_start = 2451000;
    options.trend_end = 2455000;
    options.columns = kColumns;
    options.column_bound[1] = 8;
    options.prior_precision[5] = 4;
    return options;
}

static toliman_period *make(const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(1e-4, 1.7e-4, kFrequencies, options, &period));
    return period;
}

static void fill(void) {
    uint64_t state = 11;
    for (int i = 0; i < kMost; i++) {
        const double t = 2451000.5 + 3999 * uniform(&state), x = (t - 2451000) / 4000;
        rows[i][0] = cos(t / 58);
        rows[i][1] = 8 * uniform(&state) - 4;
        samples[i] = sample_pair(t, t * 0x1p-55, 20 * x * x - x + 0.1 * rows[i][1] + sin(0.05 * t) + uniform(&state),
                                 0.1 + 9 * uniform(&state));
    }
}

static uint8_t *bytes_of(const toliman_period *period, size_t *size) {
    assert_asks(toliman_period_save(period, NULL, 0, size));
    uint8_t *bytes = malloc(*size);
    assert_ok(toliman_period_save(period, bytes, *size, size));
    return bytes;
}

static void assert_same(const toliman_period *a, const toliman_period *b) {
    size_t size_a, size_b;
    uint8_t *bytes_a = bytes_of(a, &size_a), *bytes_b = bytes_of(b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
    free(bytes_a), free(bytes_b);
    double power_a[kFrequencies], power_b[kFrequencies];
    if (count_of(a) == 0)
        return;
    assert_ok(toliman_period_query_power(a, TOLIMAN_PERIOD_POWER_STANDARD, 0, kFrequencies, power_a));
    assert_ok(toliman_period_query_power(b, TOLIMAN_PERIOD_POWER_STANDARD, 0, kFrequencies, power_b));
    assert_memory_equal(power_a, power_b, sizeof power_a);
}

static void push(toliman_period *period, int i) {
    assert_ok(toliman_period_push_samples(period, &samples[i], rows[i], 1));
}

/* promise: functions-keep-exactness */
TEST(any_order_gives_the_same_bits) {
    fill();
    const toliman_period_options options = options_for_rows();
    toliman_period *all = make(&options), *backward = make(&options), *half = make(&options), *none = make(&options);
    assert_ok(toliman_period_push_samples(all, samples, rows[0], kMost));
    for (int i = kMost - 1; i >= 0; i--) {
        push(backward, i);
        if (i % 2 == 0)
            push(half, i);
    }
    assert_same(all, backward);
    for (int i = 1; i < kMost; i += 2)
        assert_ok(toliman_period_retract_samples(all, &samples[i], rows[i], 1));
    assert_same(all, half);
    for (int i = 0; i < kMost; i += 2)
        assert_ok(toliman_period_retract_samples(all, &samples[i], rows[i], 1));
    assert_same(all, none);
    toliman_period_destroy(all), toliman_period_destroy(backward), toliman_period_destroy(half);
    toliman_period_destroy(none);
}

/* promise: functions-keep-exactness */
TEST(shards_and_saved_states_give_the_same_bits) {
    fill();
    const toliman_period_options options = options_for_rows();
    toliman_period *whole = make(&options), *merged = make(&options), *shards[kShards], *loaded = NULL;
    for (int s = 0; s < kShards; s++)
        shards[s] = make(&options);
    for (int i = 0; i < kMost; i++) {
        push(whole, i);
        push(shards[(i * 7 + i / 64) % kShards], i);
    }
    for (int s = 0; s < kShards; s++) {
        size_t size;
        uint8_t *bytes = bytes_of(shards[(s * 29 + 3) % kShards], &size);
        assert_ok(toliman_period_load(bytes, size, NULL, &loaded));
        assert_ok(toliman_period_merge(merged, loaded));
        toliman_period_destroy(loaded), free(bytes);
    }
    assert_same(merged, whole);
    for (int s = 0; s < kShards; s++)
        toliman_period_destroy(shards[s]);
    toliman_period_destroy(whole), toliman_period_destroy(merged);
}

/* Without nuisance functions the bytes are those of version 3; a file is loaded by the size in its header. */
/* promise: damaged-states-are-refused */
TEST(state_has_a_version) {
    fill();
    toliman_period_options options = options_for_rows();
    toliman_period *period = make(&options), *loaded = NULL;
    assert_ok(toliman_period_push_samples(period, samples, rows[0], 50));
    size_t size;
    uint8_t *bytes = bytes_of(period, &size);
    assert_int_equal(bytes[4], 4);
    const char *path = "nuisance.tlmp";
    assert_ok(toliman_period_save_file(period, path));
    assert_ok(toliman_period_load_file(path, NULL, &loaded));
    assert_same(period, loaded);
    toliman_period_destroy(loaded);
    remove(path);
    for (size_t i = 0; i < 2900; i += 7) { /* every damage is found */
        bytes[i] ^= 1;
        assert_int_equal(toliman_period_load(bytes, size, NULL, &loaded), TOLIMAN_E_FORMAT);
        bytes[i] ^= 1;
    }
    free(bytes), toliman_period_destroy(period);
    options = (toliman_period_options)TOLIMAN_PERIOD_OPTIONS_INIT;
    period = make(&options);
    bytes = bytes_of(period, &size);
    assert_int_equal(bytes[4], 3);
    free(bytes), toliman_period_destroy(period);
}

TEST(bad_options_are_refused) {
    toliman_period *period = NULL;
#define REFUSED(change, field)                                                                                         \
    do {                                                                                                               \
        toliman_period_options options = options_for_rows();                                                           \
        change;                                                                                                        \
        assert_invalid(toliman_period_create(0.1, 0.1, 10, &options, &period), field);                                 \
        assert_null(period);                                                                                           \
    } while (0)
    REFUSED(options.columns = 30, "options->columns");
    REFUSED(options.columns = INT32_MAX, "options->columns");
    REFUSED(options.trend_end = options.trend_start, "options->trend_start");
    REFUSED(options.trend = 0, "options->trend_start");
    REFUSED(options.column_bound[2] = 1, "options->column_bound[2]");
    REFUSED(options.prior_precision[0] = INFINITY, "options->prior_precision[0]");
    REFUSED(options.prior_precision[6] = 1, "options->prior_precision[6]");
    REFUSED(options.flags = TOLIMAN_PERIOD_FIXED_MEAN, "options->flags");
#undef REFUSED
}

TEST(bad_samples_are_refused) {
    fill();
    toliman_period_options options = options_for_rows();
    toliman_period *period = make(&options), *other = NULL;
    const double t = samples[0].t, y = 1;
    assert_invalid(toliman_period_push(period, t, y, 1), "rows");
    assert_invalid(toliman_period_push_many(period, &t, &y, NULL, 1), "rows");
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 1), "rows");
    assert_invalid(toliman_period_push_samples(period, samples, NULL, 1), "rows");
    const double kept = rows[3][1];
    rows[3][1] = 8.5;
    assert_fails(toliman_period_push_samples(period, samples, rows[0], 9), TOLIMAN_E_RANGE,
                 "sample 3: rows: column 1 = 8.5: ");
    rows[3][1] = NAN;
    assert_invalid(toliman_period_push_samples(period, samples, rows[0], 9), "rows");
    rows[3][1] = kept;
    samples[5].t = options.trend_end + 0.001;
    assert_fails(toliman_period_push_samples(period, samples, rows[0], 9), TOLIMAN_E_RANGE, "sample 5: t = 2455000: ");
    assert_int_equal(count_of(period), 0);
    samples[5] = sample_pair(options.trend_end, 0, 1, 1); /* both ends belong to the span */
    samples[6] = sample_pair(options.trend_start, 0, 1, 1);
    assert_ok(toliman_period_push_samples(period, samples, rows[0], 9));
    options.prior_precision[5] = 5;
    other = make(&options);
    assert_refused(toliman_period_merge(period, other), TOLIMAN_E_MISMATCH, "");
    toliman_period_destroy(other);
    options = (toliman_period_options)TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = TOLIMAN_PERIOD_DOUBLE_LIMB;
    other = make(&options);
    assert_refused(toliman_period_merge(period, other), TOLIMAN_E_MISMATCH, "");
    assert_refused(toliman_period_merge(other, period), TOLIMAN_E_MISMATCH, "");
    double coefficients[kFunctions];
    assert_refused(toliman_period_query_coefficients(other, 0, 1, coefficients, NULL), TOLIMAN_E_STATE, "");
    assert_invalid(toliman_period_query_coefficients(period, 0, 5, coefficients, NULL), "count");
    assert_ok(toliman_period_query_coefficients(period, 0, 6, coefficients, NULL));
    assert_ok(toliman_period_retract_samples(period, &samples[8], rows[8], 1));
    assert_refused(toliman_period_query_coefficients(period, 0, 6, coefficients, NULL), TOLIMAN_E_STATE,
                   ""); /* six functions, one with a prior: 5 + 4 */
    toliman_period_destroy(period), toliman_period_destroy(other);
}

static toliman_period_info info_of(const toliman_period *period) {
    toliman_period_info info = {.struct_size = sizeof info};
    assert_ok(toliman_period_get_info(period, &info));
    return info;
}

/* A trend of order 6: as many functions as different times, and with times close together only as many as 2^-40
 * distinguishes; a function with a prior is always in use. */
TEST(functions_in_use_grow_with_the_samples) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.trend = 6;
    options.trend_end = 1000;
    toliman_period *period = make(&options);
    assert_int_equal(info_of(period).trend, 6);
    for (int i = 0; i < 9; i++) {
        assert_int_equal(info_of(period).functions, i < 7 ? i : 7);
        assert_ok(toliman_period_push(period, 100.0 * i, i % 3, 1));
        assert_ok(toliman_period_push(period, 100.0 * i, i % 3, 1));
    }
    assert_int_equal(info_of(period).free_functions, 7);
    toliman_period_destroy(period);
    period = make(&options);
    for (int i = 0; i < 40; i++)
        assert_ok(toliman_period_push(period, 500 + 1e-3 * i, i % 3, 1));
    const int32_t used = info_of(period).functions;
    assert_in_range(used, 3, 4); /* the part of T_j that is left is about (2e-5)^j */
    double coefficients[7], errors[7];
    assert_ok(toliman_period_query_coefficients(period, 9, 7, coefficients, errors));
    for (int f = 0; f < 7; f++)
        assert_true(isfinite(errors[f]) == (f < used) && (f < used || coefficients[f] == 0));
    toliman_period_destroy(period);
    options.prior_precision[4] = 1e-3;
    period = make(&options);
    for (int i = 0; i < 40; i++)
        assert_ok(toliman_period_push(period, 500 + 1e-3 * i, i % 3, 1));
    assert_int_equal(info_of(period).free_functions, used);
    assert_int_equal(info_of(period).functions, used + 1);
    toliman_period_destroy(period);
}

/* Times in nanoseconds have the position in the span of the trend of the same times as doubles. */
TEST(times_in_nanoseconds_have_a_trend) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.trend = 4;
    options.trend_end = 1 << 20;
    options.unit_ns = 1 << 10;
    options.time_offset_ns = 77;
    toliman_period *doubles = make(&options), *integers = make(&options);
    for (int i = 0; i < 100; i++) {
        const int64_t elapsed = i * INT64_C(8191);
        const toliman_period_sample by_ns = sample_ns(77 + elapsed, i % 7, 1);
        assert_ok(toliman_period_push_samples(integers, &by_ns, NULL, 1));
        assert_ok(toliman_period_push(doubles, (double)elapsed / (1 << 10), i % 7, 1));
    }
    assert_same(doubles, integers);
    const toliman_period_sample late = sample_ns(78 + (INT64_C(1) << 30), 1, 1);
    assert_refused(toliman_period_push_samples(integers, &late, NULL, 1), TOLIMAN_E_RANGE, "t");
    toliman_period_destroy(doubles), toliman_period_destroy(integers);
}

/* Values that the functions describe have no power; a trend alone is not an alarm. */
TEST(trend_has_no_power) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.trend = 3;
    options.trend_end = 1000;
    toliman_period *period = make(&options);
    uint64_t state = 5;
    toliman_period_peak peak = {.struct_size = sizeof peak};
    for (int i = 0; i < 300; i++) {
        const double t = 3.125 * i, x = t / 500 - 1;
        assert_ok(toliman_period_push(period, t, 4 * x * x * x - 3 * x, 1)); /* exact: T_3 */
    }
    assert_refused(toliman_period_query_peak(period, &peak), TOLIMAN_E_STATE, "");
    double power[kFrequencies];
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, kFrequencies, power));
    for (int k = 0; k < kFrequencies; k++)
        assert_true(power[k] == 0);
    for (int i = 0; i < 300; i++)
        assert_ok(toliman_period_push(period, 3.125 * i, 1e5 * (uniform(&state) - 0.5), 1));
    assert_ok(toliman_period_query_peak(period, &peak));
    assert_true(peak.log10_fap > -2);
    toliman_period_destroy(period);
}

RUN_TESTS(NULL, NULL)
