/* Tests normalisations, models at a frequency and several peaks, against sums in 113-bit arithmetic and known
 * signals. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "quad_period.h"
#include "uniform.h"

#include <toliman/period.h>

enum { kMost = 800, kFrequencies = 400 };
static double times[kMost], values[kMost], sigmas[kMost];

static uint64_t state = 3;

static toliman_period *make(double f0, double df, int64_t nf, uint32_t flags, int n) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = flags;
    options.time_offset = 51000;
    options.value_offset = 2;
    options.value_bound = 32;
    options.sigma_floor = 0.2;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(f0, df, nf, &options, &period));
    assert_ok(toliman_period_push_many(period, times, values, sigmas, (size_t)n));
    return period;
}

static void fill(int n) {
    state = 3;
    for (int i = 0; i < n; i++) {
        times[i] = 51000 + 300 * uniform(&state);
        values[i] = 2.5 + 1.5 * sin(0.37 * times[i] + 1) + uniform(&state);
        sigmas[i] = 0.2 + uniform(&state);
    }
}

TEST(test_normalisations) {
    enum { N = 150 };
    fill(N);
    toliman_period *period = make(0.004, 0.001, kFrequencies, 0, N);
    double power[4][kFrequencies];
    for (int32_t kind = 0; kind < 4; kind++)
        assert_ok(
            toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD + kind, 0, kFrequencies, power[kind]));
    long double weight = 0, mean = 0, reference = 0;
    for (int i = 0; i < N; i++) {
        weight += 1 / ((long double)sigmas[i] * sigmas[i]);
        mean += values[i] / ((long double)sigmas[i] * sigmas[i]);
    }
    mean /= weight;
    for (int i = 0; i < N; i++)
        reference += (values[i] - mean) * (values[i] - mean) / ((long double)sigmas[i] * sigmas[i]);
    const quad_samples samples = {times, values, sigmas, N, NULL};
    for (int k = 0; k < kFrequencies; k += 7) {
        const quad residual = quad_residual(&samples, (quad)0.004 + (quad)0.001 * k, 0);
        assert_close(power[0][k], (double)(1 - residual), 0, 1e-12);
        assert_close(power[1][k], (double)(1 / residual - 1), 1e-11, 1e-12);
        assert_close(power[2][k], (double)-logq(residual), 1e-11, 1e-12);
        assert_close(power[3][k], (double)((1 - residual) * (quad)reference / 2), 1e-11, 1e-10);
    }
    assert_invalid(toliman_period_query_power(period, 105, 0, 1, power[0]), "normalisation");
    toliman_period_destroy(period);

    /* A perfect fit: the other normalisations are finite. */
    for (int i = 0; i < 3; i++)
        sigmas[i] = 1;
    period = make(0.004, 0.001, kFrequencies, 0, 3);
    for (int32_t kind = TOLIMAN_PERIOD_POWER_MODEL; kind <= TOLIMAN_PERIOD_POWER_PSD; kind++) {
        assert_ok(toliman_period_query_power(period, kind, 5, 1, power[0]));
        assert_true(isfinite(power[0][0]) && power[0][0] > 0);
    }
    toliman_period_destroy(period);
}

/* Normal equations about time_offset in 113 bits: solution and covariance. */
static void slow_model(int n, double f, int fixed_mean, quad x[3], quad covariance[3][3]) {
    quad a[3][3] = {{0}}, b[3] = {0}, mean = 0, weight = 0, residual = 0;
    for (int i = 0; i < n; i++) {
        const quad w = 1 / ((quad)sigmas[i] * sigmas[i]);
        weight += w;
        mean += w * values[i];
    }
    mean /= weight;
    const int first = fixed_mean ? 1 : 0, size = 3 - first;
    for (int i = 0; i < n; i++) {
        const quad w = 1 / ((quad)sigmas[i] * sigmas[i]);
        const quad angle = 2 * M_PIq * (quad)f * (times[i] - 51000);
        const quad row[3] = {1, cosq(angle), sinq(angle)};
        for (int j = 0; j < size; j++) {
            b[j] += w * row[first + j] * (values[i] - mean);
            for (int k = 0; k < size; k++)
                a[j][k] += w * row[first + j] * row[first + k];
        }
    }
    for (int unit = -1; unit < size; unit++) {
        quad matrix[3][3], right[3] = {0};
        memcpy(matrix, a, sizeof matrix);
        if (unit < 0)
            memcpy(right, b, sizeof right);
        else
            right[unit] = 1;
        quad_solve(matrix, right, size);
        for (int j = 0; j < size; j++)
            *(unit < 0 ? &x[first + j] : &covariance[first + unit][first + j]) = right[j];
    }
    if (fixed_mean)
        x[0] = 0;
    for (int i = 0; i < n; i++) {
        const quad angle = 2 * M_PIq * (quad)f * (times[i] - 51000);
        const quad gap = values[i] - mean - x[0] - x[1] * cosq(angle) - x[2] * sinq(angle);
        residual += gap * gap / ((quad)sigmas[i] * sigmas[i]);
    }
    for (int j = first; j < 3; j++)
        for (int k = first; k < 3; k++)
            covariance[j][k] *= residual / (n - size);
    x[0] += mean;
}

TEST(test_psd_of_a_perfect_fit) {
    toliman_period *period = NULL;
    double power[3] = {7, 7, 7};
    assert_ok(toliman_period_create(0.1, 0.1, 3, NULL, &period));
    for (int32_t normalisation = TOLIMAN_PERIOD_POWER_STANDARD; normalisation <= TOLIMAN_PERIOD_POWER_PSD;
         normalisation++) {
        assert_ok(toliman_period_query_power(period, normalisation, 0, 3, power));
        for (int k = 0; k < 3; k++)
            assert_true(power[k] == 0);
    }
    toliman_period_destroy(period);
}

TEST(test_model) {
    enum { N = 60 };
    fill(N);
    for (int fixed_mean = 0; fixed_mean < 2; fixed_mean++) {
        toliman_period *period = make(0.004, 0.001, kFrequencies, fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0, N);
        for (int k = 1; k < kFrequencies; k += 23) {
            toliman_period_model model = {.struct_size = sizeof model};
            assert_ok(toliman_period_query_model(period, k, &model));
            assert_close(model.frequency, 0.004 + 0.001 * k, 1e-15, 0);
            quad x[3] = {0}, v[3][3] = {{0}};
            slow_model(N, model.frequency, fixed_mean, x, v);
            const quad amplitude = hypotq(x[1], x[2]), c = x[1] / amplitude, s = x[2] / amplitude;
            assert_int_equal(model.rank, 2);
            assert_close(model.amplitude, (double)amplitude, 1e-10, 0);
            assert_close(model.phase, (double)atan2q(x[1], x[2]), 0, 1e-10);
            assert_close(model.offset, (double)x[0], 1e-10, 0);
            assert_close(model.amplitude_error, (double)sqrtq(c * c * v[1][1] + 2 * c * s * v[1][2] + s * s * v[2][2]),
                         1e-9, 0);
            assert_close(model.phase_error,
                         (double)(sqrtq(s * s * v[1][1] - 2 * c * s * v[1][2] + c * c * v[2][2]) / amplitude), 1e-9, 0);
            assert_close(model.offset_error, (double)sqrtq(v[0][0]), 1e-9, 0);
        }
        toliman_period_model model = {.struct_size = sizeof model};
        assert_refused(toliman_period_query_model(period, kFrequencies, &model), TOLIMAN_E_RANGE, "k");
        assert_refused(toliman_period_query_model(period, -1, &model), TOLIMAN_E_RANGE, "k");
        toliman_period_destroy(period);
        period = make(0.004, 0.001, kFrequencies, 0, 0);
        assert_refused(toliman_period_query_model(period, 1, &model), TOLIMAN_E_STATE, "");
        toliman_period_destroy(period);
    }
}

/* Even times at the Nyquist frequency: the sine vanishes, the cosine is fitted. */
TEST(test_model_of_one_wave) {
    for (int i = 0; i < 40; i++) {
        times[i] = 51000 + i;
        values[i] = 2 + 0.5 * (i % 2 ? -1 : 1) + 0.01 * uniform(&state);
        sigmas[i] = 1;
    }
    toliman_period *period = make(0.25, 0.25, 2, 0, 40);
    toliman_period_model model = {.struct_size = sizeof model};
    assert_ok(toliman_period_query_model(period, 1, &model));
    assert_int_equal(model.rank, 1);
    assert_close(model.amplitude, 0.5, 0, 0.01);
    assert_close(fabs(model.phase), M_PI / 2, 0, 1e-9);
    assert_true(isfinite(model.amplitude_error) && isinf(model.phase_error) && isfinite(model.offset_error));
    toliman_period_destroy(period);
}

/* Samples at night only: a signal of 0.11/d has aliases at 1 - 0.11 and 1 + 0.11; a second signal has its own peak. */
TEST(test_peaks_and_aliases) {
    enum { N = 700, kWanted = 12 };
    state = 3;
    for (int i = 0; i < N; i++) {
        times[i] = 51000 + i + 0.2 * uniform(&state);
        sigmas[i] = 1;
        values[i] = 2 + 3 * sin(2 * M_PI * 0.11 * times[i]) + 1.6 * sin(2 * M_PI * 0.3 * times[i]) + uniform(&state);
    }
    toliman_period *period = make(0.002, 1.5e-4, 12000, 0, N);
    toliman_period_peak peaks[kWanted], highest = {.struct_size = sizeof highest};
    peaks[0].struct_size = sizeof *peaks; /* valid for all peaks */
    size_t count = 0;
    assert_ok(toliman_period_query_peaks(period, peaks, kWanted, &count));
    assert_int_equal(count, kWanted);
    assert_ok(toliman_period_query_peak(period, &highest));
    assert_true(peaks[0].frequency == highest.frequency && peaks[0].power == highest.power);
    assert_close(peaks[0].frequency, 0.11, 0, 2e-4);
    int own = 0, aliases = 0;
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(peaks[i].struct_size, sizeof *peaks);
        assert_true(i == 0 || peaks[i].power <= peaks[i - 1].power * 1.001);
        const double f = peaks[i].frequency;
        if ((peaks[i].flags & TOLIMAN_PERIOD_ALIAS) == 0 && peaks[i].power > 0.1) {
            own++;
            assert_true(fabs(f - 0.11) < 2e-4 || fabs(f - 0.3) < 2e-4);
        }
        if (fabs(f - 0.89) < 2e-4 || fabs(f - 1.11) < 2e-4 || fabs(f - 0.7) < 2e-4 || fabs(f - 1.3) < 2e-4) {
            aliases++;
            assert_true((peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0);
        }
    }
    assert_int_equal(own, 2);
    assert_true(aliases >= 3);
    assert_ok(toliman_period_query_peaks(period, peaks, 1, &count));
    assert_int_equal(count, 1);
    assert_true(peaks[0].frequency == highest.frequency);
    assert_invalid(toliman_period_query_peaks(period, peaks, 0, &count), "capacity");
    assert_invalid(toliman_period_query_peaks(period, peaks, 65, &count), "capacity");
    peaks[0].struct_size = 3;
    assert_invalid(toliman_period_query_peaks(period, peaks, 2, &count), "peaks->struct_size");
    toliman_period_destroy(period);
}

/* 800 daily samples: periods above 400 days are long; 1/yr +- 1/800 per day are periods from 251 to 672 days. */
TEST(test_flags_of_slow_peaks) {
    static const struct {
        double period, unit_ns;
        uint32_t flags;
    } cases[] = {{240, 86400e9, 0},
                 {265, 86400e9, TOLIMAN_PERIOD_ANNUAL},
                 {390, 86400e9, TOLIMAN_PERIOD_ANNUAL},
                 {410, 86400e9, TOLIMAN_PERIOD_ANNUAL | TOLIMAN_PERIOD_LONG},
                 {700, 86400e9, TOLIMAN_PERIOD_LONG},
                 {390, 1e9, 0}, /* seconds: T is not half a year */
                 {17, 86400e9 * 365.25 / 17, TOLIMAN_PERIOD_ANNUAL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int k = 0; k < kMost; k++) {
            times[k] = k;
            values[k] = sin(2 * M_PI * k / cases[i].period);
        }
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.flags = TOLIMAN_PERIOD_DOUBLE_LIMB;
        options.unit_ns = cases[i].unit_ns;
        toliman_period *period = NULL;
        assert_ok(toliman_period_create(1e-3, 2e-5, 4000, &options, &period));
        assert_ok(toliman_period_push_many(period, times, values, NULL, kMost));
        toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
        const uint32_t slow = TOLIMAN_PERIOD_LONG | TOLIMAN_PERIOD_ANNUAL;
        assert_ok(toliman_period_query_peak(period, &peak));
        assert_close(peak.period, cases[i].period, 1e-2, 0);
        assert_int_equal(peak.flags & slow, cases[i].flags);
        assert_ok(toliman_period_query_fit(period, times, values, NULL, NULL, kMost, &peak));
        assert_int_equal(peak.flags & slow, cases[i].flags);
        toliman_period_destroy(period);
    }
}

RUN_TESTS(NULL, NULL)
