/* Memory and files that fail on demand, where the library calls the C library's functions. */
#ifndef TOLIMAN_TESTS_FAILING_H
#define TOLIMAN_TESTS_FAILING_H

#include <stddef.h>

/* arm() makes calls fail: of all calls that count, call number `at` (from 0), or all calls from there on. */
enum what { FAIL_NOTHING, FAIL_MEMORY, FAIL_FILES };
enum { SHORT_COUNT = -1 }; /* instead of an errno: reads and writes transfer half of the requested size and succeed */

void arm(enum what what, long at, int permanent, int error);

/* Stops failing calls; returns how many calls counted. */
long disarm(void);

/* Name of the first call that failed, "" if none. */
const char *failed_call(void);

/* Number of blocks allocated since watch_memory() and not freed. */
void watch_memory(void);
long blocks_held(void);

#endif
