/* False alarm rates in correlated noise with and without its model, and the loss of a signal in white noise by it.
 * Exits with 1 if with the model less than 0.6 % or more than 1.4 % of the series of AR(1) noise have a FAP of 0.01, up
 * to two standard errors, if less than 95 % of the alarms in 1/f noise are flagged, or if the median loss of the signal
 * of the scene chapter.json exceeds 5 % of its log10 FAP. */
/* promise: correlated-alarms-are-rare */
#include <stdio.h>
#include <stdlib.h>

#include "noise_trials.h"

static const double kRhos[] = {0, 0.2, 0.5, 0.9, -1};
static const fap_signal kNone = {0, 365, 0};
/* The first is that of chapter.json, 1e-6 px, with the standard error of the template, 1.24e-6 px per frame. */
static const fap_signal kSignals[] = {{1 / 1.24, 365, 0.4}, {0.5, 365, -1}, {0.5, 20, -1}, {0.4, 479, -1}};
static int missed = 0;

static const char *mark(int good) {
    missed += !good;
    return good ? "" : " !";
}

static void show(const noise_times *times, double rho, int series) {
    const noise_counts found = noise_count(times, rho, kNone, series, 1000);
    char name[32];
    (void)snprintf(name, sizeof name, rho < 0 ? "1/f" : "AR(1) %g", rho);
    const double share = (double)found.alarms / series, error = 2 * sqrt(0.01 / series);
    const int calibrated = rho < 0 || (share >= 0.006 - error && share <= 0.014 + error);
    const int reported = rho >= 0 || found.flagged_alarms >= 0.95 * found.alarms;
    printf("| %s, %s | %zu | %.2f %% | %.2f %%%s | %.1f %% | %d of %d%s | %.3f |\n", name, times->name, times->n,
           100.0 * found.alarms_white / series, 100 * share, mark(calibrated), 100.0 * found.flagged / series,
           found.flagged_alarms, found.alarms, mark(reported), found.rho);
    (void)fflush(stdout);
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Losses of log10 FAP by the model, over seeds. most: largest median. */
static void show_loss(const noise_times *times, fap_signal signal, int series, double most) {
    double *const losses = malloc((size_t)series * sizeof *losses);
    assert_non_null(losses);
    double white = 0, fitted = 0;
    int flagged = 0;
    for (int s = 0; s < series; s++) {
        const noise_counts found = noise_count(times, 0, signal, 1, 5000 + (uint64_t)s);
        losses[s] = 1 - found.fap / found.white_fap;
        white += found.white_fap / series;
        fitted += found.fap / series;
        flagged += found.flagged;
    }
    qsort(losses, (size_t)series, sizeof *losses, by_size);
    const double median = losses[series / 2];
    printf("| %.3g | %g | %.1f | %.1f | %.1f %% | %.1f %%%s | %.1f %% | %.1f %% |\n", signal.amplitude,
           signal.period_days, white, fitted, 100 * (1 - fitted / white), 100 * median, mark(median <= most),
           100 * losses[series * 95 / 100], 100.0 * flagged / series);
    (void)fflush(stdout);
    free(losses);
}

/* Usage: bench_noise [series], by default 3000 */
int main(int argc, char **argv) {
    const int series = argc > 1 ? atoi(argv[1]) : 3000;
    const noise_times few = noise_regular(200, 10), many = noise_seasons(5), year = noise_regular(NOISE_MOST, 5);
    printf(
        "%d series each. Alarm: FAP of the highest peak at most 0.01. Flag: not white, log10 p < -3.\n\n"
        "| noise | samples | alarms, white noise assumed | alarms, noise fitted | flagged | alarms flagged | mean rho "
        "|\n|---|---|---|---|---|---|---|\n",
        series);
    for (size_t i = 0; i < sizeof kRhos / sizeof kRhos[0]; i++)
        show(&few, kRhos[i], series);
    for (size_t i = 0; i < sizeof kRhos / sizeof kRhos[0]; i++)
        show(&many, kRhos[i], series);
    printf(
        "\nSignal in white noise, %d daily samples, %d series each: mean log10 FAP, and its loss by the model.\n\n"
        "| amplitude, sigma | period, d | white noise assumed | noise fitted | loss of the mean | median loss | 95th "
        "percentile | flagged |\n|---|---|---|---|---|---|---|---|\n",
        NOISE_MOST, series / 5);
    for (size_t i = 0; i < sizeof kSignals / sizeof kSignals[0]; i++)
        show_loss(&year, kSignals[i], series / 5, i > 0 ? INFINITY : 0.05);
    return missed > 0;
}
