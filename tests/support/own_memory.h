/* The memory of the process itself. */
#ifndef TOLIMAN_TESTS_OWN_MEMORY_H
#define TOLIMAN_TESTS_OWN_MEMORY_H

#include <stdio.h>

#include "assert_close.h"

/* KiB of the process's own, by walking its pages: the count of statm lags behind, by a few pages a processor. */
static inline long own_memory(void) {
    char line[256];
    long size = -1;
    FILE *const file = fopen("/proc/self/smaps_rollup", "r");
    assert_non_null(file);
    while (size < 0 && fgets(line, sizeof line, file) != NULL)
        sscanf(line, "Anonymous: %ld", &size);
    fclose(file);
    assert_true(size > 0);
    return size;
}

#endif
