/* False alarms on noise with 1 to 9 nuisance functions, with and without priors: fractions of the series whose FAP is
 * below 0.1 and 0.01. Exits with 1 if one is outside [0.08, 0.11] or [0.006, 0.013]. */
#include <stdio.h>

#include "nuisance_trials.h"

int main(void) {
    static const int counts[] = {30, 60, 836}, series[] = {12000, 12000, 3000};
    int bad = 0;
    printf("| samples | functions | free: FAP < 0.1 | < 0.01 | with priors: < 0.1 | < 0.01 "
           "|\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < 3; i++)
        for (int functions = 1; functions <= 9; functions++) {
            printf("| %d | %d", counts[i], functions);
            for (int priors = 0; priors < (functions > 1 ? 2 : 1); priors++) {
                double shares[2];
                trial_shares(counts[i], functions, priors, series[i], shares);
                const int good = trial_is_calibrated(shares, series[i]);
                printf(" | %.4f | %.4f%s", shares[0], shares[1], good ? "" : " !");
                bad += !good;
            }
            printf(functions > 1 ? " |\n" : " | | |\n");
            fflush(stdout);
        }
    return bad > 0;
}
