/* Timing of repeated work: processor seconds, their median and half their interquartile range. */
#ifndef TOLIMAN_TESTS_TIMING_H
#define TOLIMAN_TESTS_TIMING_H

#include <stdlib.h>
#include <time.h>

typedef struct timing {
    double median, spread;
} timing;

static inline double processor_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline int compare_times(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the times in place. */
static inline timing timing_of(double *times, size_t count) {
    timing of;
    qsort(times, count, sizeof *times, compare_times);
    of.median = times[count / 2];
    of.spread = (times[count - 1 - count / 4] - times[count / 4]) / 2;
    return of;
}

#endif
