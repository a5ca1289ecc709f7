/* False alarm rates on pure noise, and number of samples until a signal is detected, for the chapter's sampling: 1095
 * daily samples. */
/* promise: sequential-alarms-are-rare */
#include <stdio.h>
#include <stdlib.h>

#include "fap_trials.h"

enum { DAYS = 1095, ENDS = 4000, STREAMS = 1000, SIGNALS = 400, SIGNAL_DAYS = 450 };
static const double kTarget = 0.01;
/* 1e-6 px, with a standard error of 1.24e-6 px per frame. */
static const double kAmplitude = 1 / 1.24, kPeriodDays = 365, kChapterPhase = 0.4;

static int found[FAP_METHODS][STREAMS > SIGNALS ? STREAMS : SIGNALS];

static void watch(toliman_period *period, int days, int series, fap_signal signal) {
    for (int i = 0; i < series; i++) {
        int first[FAP_METHODS];
        fap_watch(period, days, 1000000u + (uint64_t)i, signal, kTarget, first);
        for (int m = 0; m < FAP_METHODS; m++)
            found[m][i] = first[m];
    }
}

int main(void) {
    toliman_period *const period = fap_periodogram(DAYS);
    int at_end[FAP_METHODS] = {0}, ever[FAP_METHODS] = {0}, drawn[FAP_METHODS], chapter[FAP_METHODS];
    for (uint64_t i = 0; i < ENDS; i++) {
        double log10_fap[FAP_METHODS];
        fap_at_end(period, DAYS, i, log10_fap);
        for (int m = 0; m < FAP_METHODS; m++)
            at_end[m] += log10_fap[m] <= log10(kTarget);
    }
    watch(period, DAYS, STREAMS, (fap_signal){0, kPeriodDays, 0});
    for (int m = 0; m < FAP_METHODS; m++)
        for (int i = 0; i < STREAMS; i++)
            ever[m] += found[m][i] != FAP_NEVER;
    watch(period, SIGNAL_DAYS, SIGNALS, (fap_signal){kAmplitude, kPeriodDays, -1});
    for (int m = 0; m < FAP_METHODS; m++)
        drawn[m] = fap_median(found[m], SIGNALS);
    watch(period, SIGNAL_DAYS, SIGNALS, (fap_signal){kAmplitude, kPeriodDays, kChapterPhase});
    for (int m = 0; m < FAP_METHODS; m++)
        chapter[m] = fap_median(found[m], SIGNALS);
    toliman_period_destroy(period);

    printf("FAP %g, one sample a day. Noise: %d series of %d samples with one query, %d queried at every sample from "
           "%d on.\n"
           "Signal of %.3f sigma and %g days: median number of samples until detection, %d series.\n\n",
           kTarget, ENDS, DAYS, STREAMS, FAP_FROM, kAmplitude, kPeriodDays, SIGNALS);
    printf("| method | alarms, one query | alarms, every query | until detection, any phase | phase %g "
           "|\n|---|---|---|---|---|\n",
           kChapterPhase);
    for (int m = 0; m < FAP_METHODS; m++)
        printf("| %s | %.2f %% | %.1f %% | %d | %d |\n", fap_names[m], 100.0 * at_end[m] / ENDS,
               100.0 * ever[m] / STREAMS, drawn[m], chapter[m]);
    return 0;
}
