/* False alarm rates in correlated noise with and without its model, and the loss of a signal in white noise by it. */
#include <stdio.h>
#include <stdlib.h>

#include "noise_trials.h"

static const double kRhos[] = {0, 0.2, 0.5, 0.9, -1};
static const fap_signal kNone = {0, 365, 0};
static const fap_signal kSignals[] = {{0.5, 365, -1}, {0.5, 20, -1}, {0.4, 479, -1}};

static void show(const noise_times *times, double rho, int series) {
    const noise_counts found = noise_count(times, rho, kNone, series, 1000);
    char name[32];
    (void)snprintf(name, sizeof name, rho < 0 ? "1/f" : "AR(1) %g", rho);
    printf("| %s, %s | %zu | %.2f %% | %.2f %% | %.1f %% | %d of %d | %.3f |\n", name, times->name, times->n,
           100.0 * found.alarms_white / series, 100.0 * found.alarms / series, 100.0 * found.flagged / series,
           found.flagged_alarms, found.alarms, found.rho);
    (void)fflush(stdout);
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
    printf("\nSignal in white noise, %d daily samples: mean log10 FAP.\n\n| amplitude, sigma | period, d | white noise "
           "assumed | noise fitted | loss | flagged |\n|---|---|---|---|---|---|\n",
           NOISE_MOST);
    for (size_t i = 0; i < sizeof kSignals / sizeof kSignals[0]; i++) {
        const noise_counts found = noise_count(&year, 0, kSignals[i], series / 10, 5000);
        printf("| %g | %g | %.1f | %.1f | %.1f %% | %.1f %% |\n", kSignals[i].amplitude, kSignals[i].period_days,
               found.white_fap, found.fap, 100 * (1 - found.fap / found.white_fap),
               100.0 * found.flagged / found.series);
        (void)fflush(stdout);
    }
    return 0;
}
