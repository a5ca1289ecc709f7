/* Finds the period of samples. Prints "period 17.026 +- 0.045 days". */
#include <stdio.h>

#include <toliman/period.h>

enum { N = 200 };

int main(void) {
    double t[N], y[N], f0, df; /* your samples; here with a period of 17 days */
    for (int i = 0; i < N; i++) {
        t[i] = i;
        y[i] = i % 17;
    }
    int64_t nf;
    toliman_period *period = NULL;
    toliman_period_peak fit = TOLIMAN_PERIOD_PEAK_INIT;
    const int found = toliman_period_suggest(t, y, NULL, N, 0, &f0, &df, &nf, NULL) == TOLIMAN_OK &&
                      toliman_period_create(f0, df, nf, NULL, &period) == TOLIMAN_OK &&
                      toliman_period_push_many(period, t, y, NULL, N) == TOLIMAN_OK &&
                      toliman_period_query_fit(period, t, y, NULL, NULL, N, &fit) == TOLIMAN_OK;
    if (found)
        printf("period %.3f +- %.3f days\n", fit.period, fit.period_error);
    else
        fprintf(stderr, "%s\n", toliman_last_error());
    toliman_period_destroy(period);
    return !found;
}
