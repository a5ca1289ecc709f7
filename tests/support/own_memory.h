/* Memory of the process. */
#ifndef TOLIMAN_TESTS_OWN_MEMORY_H
#define TOLIMAN_TESTS_OWN_MEMORY_H

#include <stdio.h>

#include "assert_close.h"

/* Private memory of the process in KiB, from its page map: the count of statm lags behind by a few pages per
 * processor. */
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
