/* Tests the periodogram with correlated noise against dense generalised least squares in wider arithmetic, its false
 * alarms, and refusals. */
#include "noise_trials.h"
#include "uniform.h"

enum { N = 60, NF = 50, MOST_FUNCTIONS = 3, COLUMNS = MOST_FUNCTIONS + 3 };
static const double kF0 = 0.02, kDf = 0.009;
static double times[N], values[N], sigmas[N], functions[N * MOST_FUNCTIONS];
static const double kPriors[MOST_FUNCTIONS] = {0, 0.7, 40};

static void fill(void) {
    uint64_t state = 5;
    double correlated = 0;
    for (int i = 0; i < N; i++) {
        correlated = 0.7 * correlated + noise(&state);
        times[i] = 2.45e6 + 1.3 * i + 0.6 * uniform_signed(&state);
        sigmas[i] = 0.5 + uniform(&state);
        values[i] = 1e3 + correlated + 0.02 * i + 0.5 * sin(0.9 * i);
    }
    for (int i = 0; i < N; i++) {
        const double x = 2.0 * i / (N - 1) - 1;
        functions[i * MOST_FUNCTIONS] = 100 * x;
        functions[i * MOST_FUNCTIONS + 1] = 2 * x * x - 1;
        functions[i * MOST_FUNCTIONS + 2] = sin(3 * x) * 1e-3;
    }
}

/* The case of a call: of the arrays above, or without some of them. */
typedef struct {
    const double *sigma, *precision;
    size_t k;
} series;

static double packed[N * MOST_FUNCTIONS];
static const double *columns(size_t k) {
    for (size_t i = 0; i < N; i++)
        for (size_t j = 0; j < k; j++)
            packed[i * k + j] = functions[i * MOST_FUNCTIONS + j];
    return k > 0 ? packed : NULL;
}

static toliman_status search(series given, uint32_t flags, double *power, double *coefficients, double *errors,
                             toliman_period_noise *out) {
    toliman_period_noise_options options = TOLIMAN_PERIOD_NOISE_OPTIONS_INIT;
    options.flags = flags;
    return noise_search_of(kF0, kDf, NF, times, values, given.sigma, N, columns(given.k), given.precision, given.k,
                           &options, power, coefficients, errors, out);
}

/* Cholesky factor of the covariance, in place: its lower triangle. */
static void factorise(long double a[N][N]) {
    for (int j = 0; j < N; j++)
        for (int i = j; i < N; i++) {
            for (int k = 0; k < j; k++)
                a[i][j] -= a[i][k] * a[j][k];
            a[i][j] = i == j ? sqrtl(a[i][i]) : a[i][j] / a[j][j];
        }
}

/* Residual of generalised least squares, and the coefficients x. Design [N][m]; precision of each column. */
static long double dense_residual(const series *given, double rho, double step, double f, int m, long double *x,
                                  long double *volume) {
    static long double c[N][N], design[N][COLUMNS + 1];
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            const long double gap = fabsl((long double)times[i] - times[j]) / step;
            const long double phi = i == j ? 1 : rho > 0 ? expl(gap * logl(rho)) : 0;
            c[i][j] = phi * (given->sigma ? (long double)given->sigma[i] * given->sigma[j] : 1);
        }
        const long double phase = 6.283185307179586476925287L * f * ((long double)times[i] - times[N / 2]);
        design[i][0] = 1;
        for (size_t j = 0; j < given->k; j++)
            design[i][1 + j] = functions[(size_t)i * MOST_FUNCTIONS + j];
        design[i][1 + given->k] = cosl(phase);
        design[i][2 + given->k] = sinl(phase);
    }
    factorise(c);
    long double normal[COLUMNS][COLUMNS + 1] = {{0}}, square = 0;
    for (int i = 0; i < N; i++) { /* whitens by forward substitution */
        long double row[COLUMNS + 1];
        for (int j = 0; j < m; j++)
            row[j] = design[i][j];
        row[m] = values[i] - 1000.0L;
        for (int k = 0; k < i; k++)
            for (int j = 0; j <= m; j++)
                row[j] -= c[i][k] * (j < m ? design[k][j] : design[k][COLUMNS]);
        for (int j = 0; j <= m; j++)
            row[j] /= c[i][i];
        for (int j = 0; j < m; j++)
            design[i][j] = row[j];
        design[i][COLUMNS] = row[m];
        for (int a = 0; a < m; a++)
            for (int b = 0; b <= m; b++)
                normal[a][b] += row[a] * row[b];
        square += row[m] * row[m];
    }
    for (size_t j = 0; j < given->k && given->precision; j++)
        normal[1 + j][1 + j] += given->precision[j];
    for (int a = 0; a < m; a++)
        for (int r = a + 1; r < m; r++) {
            const long double factor = normal[r][a] / normal[a][a];
            for (int b = a; b <= m; b++)
                normal[r][b] -= factor * normal[a][b];
        }
    for (int a = m - 1; a >= 0; a--) {
        x[a] = normal[a][m];
        for (int b = a + 1; b < m; b++)
            x[a] -= normal[a][b] * x[b];
        square -= normal[a][m] * normal[a][m] / normal[a][a];
        x[a] /= normal[a][a];
    }
    *volume = 0; /* log determinants of the normal matrix and of the covariance */
    for (int a = 0; a < m; a++)
        *volume += logl(normal[a][a]);
    for (int i = 0; i < N; i++)
        *volume += 2 * logl(c[i][i]);
    return square;
}

static void compare(const char *name, series given, uint32_t flags) {
    double power[NF], coefficients[MOST_FUNCTIONS], errors[MOST_FUNCTIONS];
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search(given, flags, power, coefficients, errors, &found));
    const int m = (int)given.k + 3;
    long double x[COLUMNS], volume;
    const long double null = dense_residual(&given, found.rho, found.step, 0, m - 2, x, &volume);
    double worst = 0;
    for (int k = 0; k < NF; k++) {
        const long double left = dense_residual(&given, found.rho, found.step, kF0 + k * kDf, m, x, &volume);
        worst = fmax(worst, (double)fabsl(power[k] - (1 - left / null)));
    }
    const long double left = dense_residual(&given, found.rho, found.step, found.frequency, m, x, &volume);
    print_message("%s: rho %.3f, largest error of a power %.2g\n", name, found.rho, worst);
    assert_at_most(worst, 1e-10);
    assert_close(found.amplitude, (double)hypotl(x[m - 2], x[m - 1]), 1e-8, 0);
    assert_close(found.offset, (double)x[0] + 1000, 1e-9, 0);
    for (size_t j = 0; j < given.k; j++)
        assert_close(coefficients[j], (double)x[1 + j], 1e-6, 1e-9);
    assert_true(power[found.index] == found.power);
    assert_close(found.log10_residual, log10(1 - found.power), 1e-9, 1e-12);
    assert_true(1 - left / null >= found.power - 1e-12);
    for (size_t j = 0; j < given.k; j++)
        assert_true(errors[j] > 0 && errors[j] < INFINITY);
    assert_true(flags != 0 || found.rho > 0.1);
}

/* Of white noise: least squares with the frequency, which has one degree of freedom less. */
TEST(errors_agree_with_the_fit) {
    fill();
    toliman_period *period = NULL;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.sigma_floor = 0.5;
    options.value_offset = 1000;
    options.time_offset = times[0];
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    assert_ok(toliman_period_create(kF0, kDf, NF, &options, &period));
    assert_ok(toliman_period_push_many(period, times, values, sigmas, N));
    assert_ok(toliman_period_query_fit(period, times, values, sigmas, NULL, N, &peak));
    toliman_period_destroy(period);
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search((series){sigmas, NULL, 0}, TOLIMAN_PERIOD_WHITE_NOISE, NULL, NULL, NULL, &found));
    const double freedom = sqrt((N - 4.0) / (N - 3.0));
    assert_close(found.frequency, peak.frequency, 1e-7, 0);
    assert_close(found.amplitude, peak.amplitude, 1e-6, 0);
    assert_close(found.frequency_error, peak.frequency_error * freedom, 1e-5, 0);
    assert_close(found.amplitude_error, peak.amplitude_error * freedom, 0.02, 0);
    assert_close(found.phase_error, found.amplitude_error / found.amplitude, 0.3, 0);
    const double phase = found.phase + 6.283185307179586 * found.frequency * (times[0] - found.time_reference);
    assert_close(remainder(phase - peak.phase, 6.283185307179586), 0, 0, 1e-4);
}

/* promise: noise-power-has-ten-digits */
TEST(power_agrees_with_dense_generalised_least_squares) {
    fill();
    compare("white", (series){NULL, NULL, 0}, TOLIMAN_PERIOD_WHITE_NOISE);
    compare("mean", (series){NULL, NULL, 0}, 0);
    compare("sigmas", (series){sigmas, NULL, 0}, 0);
    compare("functions", (series){sigmas, NULL, MOST_FUNCTIONS}, 0);
    compare("priors", (series){sigmas, kPriors, MOST_FUNCTIONS}, 0);
}

/* Noise with rho = 0.6 and no signal: rho has the largest restricted likelihood without a sinusoid. */
TEST(correlation_has_the_largest_likelihood) {
    fill();
    fap_noise random = fap_seeded(3);
    double x = 0;
    for (int i = 0; i < N; i++) {
        const double phi = i > 0 ? pow(0.6, (times[i] - times[i - 1]) / 1.3) : 0;
        x = phi * x + sqrt(1 - phi * phi) * fap_normal(&random);
        values[i] = 1000 + sigmas[i] * x;
    }
    const series given = {sigmas, NULL, 2};
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search(given, 0, NULL, NULL, NULL, &found));
    const int m = (int)given.k + 1;
    double best = -INFINITY, at = 0;
    for (int i = 0; i < 999; i++) {
        long double coefficients[COLUMNS], volume;
        const double rho = 0.001 * i;
        const long double left = dense_residual(&given, rho, found.step, 0, m, coefficients, &volume);
        const double likelihood = (double)(-0.5L * ((N - m) * logl(left) + volume));
        if (likelihood > best)
            best = likelihood, at = rho;
    }
    print_message("rho %.4f +- %.3f, by a scan %.3f\n", found.rho, found.rho_error, at);
    assert_close(found.rho, at, 0, 1.1e-3);
    assert_close(found.rho_error, sqrt((1 - at * at) / N), 0.35, 0);
    assert_close(found.tau, -found.step / log(found.rho), 1e-14, 0);
}

/* The trials of the benchmark, fewer. */
/* promise: correlated-alarms-are-rare */
TEST(alarms_are_as_documented) {
    enum { SERIES = 150 };
    const noise_times few = noise_regular(200, 5), many = noise_regular(400, 5);
    const fap_signal none = {0, 365, 0};
    const noise_counts red = noise_count(&few, 0.5, none, SERIES, 1), white = noise_count(&few, 0, none, SERIES, 1);
    print_message("alarms at 0.01 of %d: rho 0.5 %d, by the noise model %d, flagged %d; white %d, flagged %d\n", SERIES,
                  red.alarms_white, red.alarms, red.flagged, white.alarms, white.flagged);
    assert_true(red.alarms_white > 0.4 * SERIES); /* the reason for the model */
    assert_at_most(red.alarms, 5);
    assert_true(red.flagged > 0.97 * SERIES);
    assert_close(red.rho, 0.5, 0, 0.03);
    assert_at_most(white.alarms, 5);
    assert_at_most(white.flagged, 2);
    const noise_counts strong = noise_count(&many, 0, (fap_signal){0.85, 133, -1}, 30, 1);
    print_message("strong signal: log10 FAP %.1f, by the noise model %.1f\n", strong.white_fap, strong.fap);
    assert_int_equal(strong.same_peak, 30);
    assert_true(strong.fap < 0.93 * strong.white_fap);
}

/* The strongest sinusoid is between two points of the grid: what it leaves at either of them is not a correlation. */
TEST(strong_sinusoids_are_no_correlated_noise) {
    enum { COUNT = 200 };
    double t[COUNT], y[COUNT], sigma[COUNT];
    for (double amplitude = 1; amplitude < 2e6; amplitude *= 10) {
        uint64_t state = 11;
        for (int i = 0; i < COUNT; i++) {
            t[i] = i;
            y[i] = amplitude * sin(2 * acos(-1) * i / 72.376) + noise(&state);
            sigma[i] = 1;
        }
        for (int model = 0; model < 2; model++) {
            toliman_period_noise_options options = TOLIMAN_PERIOD_NOISE_OPTIONS_INIT;
            options.flags = model == 0 ? TOLIMAN_PERIOD_WHITE_NOISE : 0;
            toliman_period_noise out = TOLIMAN_PERIOD_NOISE_INIT;
            assert_ok(noise_search_of(0.002, 0.1 / COUNT, 900, t, y, sigma, COUNT, NULL, NULL, 0, &options, NULL, NULL,
                                      NULL, &out));
            assert_true(out.log10_p_white > -2);
            assert_true(out.rho < 0.2);
            assert_true(fabs(out.amplitude - amplitude) < 4 * out.amplitude_error && out.amplitude_error < 0.2);
        }
    }
}

TEST(order_of_samples_does_not_matter) {
    fill();
    double power[NF], reversed[NF], t[N], y[N];
    toliman_period_noise a = TOLIMAN_PERIOD_NOISE_INIT, b = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search((series){NULL, NULL, 0}, 0, power, NULL, NULL, &a));
    for (int i = 0; i < N; i++) {
        t[i] = times[N - 1 - i];
        y[i] = values[N - 1 - i];
    }
    assert_ok(noise_search_of(kF0, kDf, NF, t, y, NULL, N, NULL, NULL, 0, NULL, reversed, NULL, NULL, &b));
    for (int k = 0; k < NF; k++)
        assert_close(reversed[k], power[k], 0, 1e-9);
    assert_close(b.rho, a.rho, 0, 1e-6);
}

/* At the Nyquist frequency of regular samples the sine is 0, and at frequency 0 there is neither. */
TEST(coincident_cosine_and_sine) {
    fill();
    double t[N], power[11];
    for (int i = 0; i < N; i++)
        t[i] = i;
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(noise_search_of(0, 0.05, 11, t, values, NULL, N, NULL, NULL, 0, NULL, power, NULL, NULL, &found));
    assert_true(power[0] == 0);
    assert_true(power[10] > 0 && power[10] < 0.2);
    for (int i = 0; i < N; i++)
        values[i] = i % 2;
    assert_ok(noise_search_of(0, 0.05, 11, t, values, NULL, N, NULL, NULL, 0, NULL, power, NULL, NULL, &found));
    assert_int_equal(found.rank, 1);
    assert_true(found.power > 1 - 1e-12 && isinf(found.amplitude_error));
    assert_true(found.flags & TOLIMAN_PERIOD_AT_EDGE);
}

static toliman_status draw(double rho, uint64_t block, uint32_t threads, size_t count, double *peaks) {
    toliman_period_noise_bootstrap_options options = TOLIMAN_PERIOD_NOISE_BOOTSTRAP_OPTIONS_INIT;
    options.block = block;
    options.threads = threads;
    options.seed = 9;
    toliman_measure *const given = measure_of(times, values, sigmas, N);
    assert_ok(add_measure_columns(given, columns(2), NULL, N, 2));
    const toliman_status status =
        toliman_measure_query_noise_bootstrap(given, kF0, kDf, NF, rho, &options, count, peaks);
    toliman_measure_destroy(given);
    return status;
}

/* The median of the resampled peaks has a FAP of one half by Baluev's formula, roughly. */
TEST(bootstrap_agrees_with_the_formula) {
    enum { DRAWS = 200 };
    fill();
    static double one[DRAWS], three[DRAWS];
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search((series){sigmas, NULL, 2}, 0, NULL, NULL, NULL, &found));
    assert_ok(draw(found.rho, 0, 1, DRAWS, one));
    assert_ok(draw(found.rho, 0, 3, DRAWS, three));
    assert_memory_equal(one, three, sizeof one);
    for (int i = 1; i < DRAWS; i++)
        assert_true(one[i - 1] <= one[i]);
    /* Threshold of a FAP of one half for this grid with N - 3 degrees of freedom: expected by Baluev at about -0.1. */
    print_message("log10 residual of the highest peak: median %.3f\n", one[DRAWS / 2]);
    assert_close(one[DRAWS / 2], -0.09, 0, 0.04);
    assert_ok(draw(found.rho, N, 1, 3, three));
    assert_refused(draw(1, 0, 1, DRAWS, one), TOLIMAN_E_RANGE, "rho");
    assert_refused(draw(0, N + 1, 1, DRAWS, one), TOLIMAN_E_RANGE, "options->block");
}

TEST(bad_input_is_refused) {
    fill();
    double power[NF] = {-7};
    toliman_period_noise found = TOLIMAN_PERIOD_NOISE_INIT;
    const series plain = {sigmas, NULL, 2};
#define REFUSED(place, wrong, field)                                                                                   \
    do {                                                                                                               \
        const double kept = (place);                                                                                   \
        (place) = (wrong);                                                                                             \
        assert_invalid(search(plain, 0, power, NULL, NULL, &found), field);                                            \
        (place) = kept;                                                                                                \
    } while (0)
    REFUSED(times[7], NAN, "t[7]");
    REFUSED(values[7], INFINITY, "y[7]");
    REFUSED(sigmas[7], 0, "sigma[7]");
    REFUSED(functions[7 * MOST_FUNCTIONS + 1], NAN, "values[7]");
    REFUSED(times[8], times[7], "t");
    double negative[2] = {0, -1};
    assert_invalid(search((series){sigmas, negative, 2}, 0, power, NULL, NULL, &found), "sigma");
    for (int i = 0; i < N; i++)
        functions[i * MOST_FUNCTIONS + 1] = 3 - 2 * functions[i * MOST_FUNCTIONS];
    assert_fails(search(plain, 0, power, NULL, NULL, &found), TOLIMAN_E_ARGUMENT, "functions[1]: ");
    double prior[2] = {0, 1};
    toliman_period_noise other = TOLIMAN_PERIOD_NOISE_INIT;
    assert_ok(search((series){sigmas, prior, 2}, 0, NULL, NULL, NULL, &other)); /* a prior determines it */
    fill();
    assert_invalid(search(plain, 1, power, NULL, NULL, &found), "options->flags");
    assert_refused(
        noise_search_of(kF0, kDf, NF, times, values, NULL, 7, columns(2), NULL, 2, NULL, power, NULL, NULL, &found),
        TOLIMAN_E_STATE, "n");
    assert_invalid(noise_search_of(kF0, -1, NF, times, values, NULL, N, NULL, NULL, 0, NULL, power, NULL, NULL, &found),
                   "df");
    for (int i = 0; i < N; i++)
        values[i] = 3 + functions[i * MOST_FUNCTIONS];
    assert_refused(search(plain, 0, power, NULL, NULL, &found), TOLIMAN_E_STATE, "y");
    for (int i = 0; i < N; i++)
        values[i] = 3;
    assert_refused(search(plain, 0, power, NULL, NULL, &found), TOLIMAN_E_STATE, "y");
    assert_true(power[0] == -7 && found.rho == 0);
}

RUN_TESTS(NULL, NULL)
