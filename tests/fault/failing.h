/* Memory and files that fail on demand, at the library's calls of the C library's functions. */
#ifndef TOLIMAN_TESTS_FAILING_H
#define TOLIMAN_TESTS_FAILING_H

#include <stddef.h>

/* What fails once armed: of all calls that count, the one number `at`, from 0 on, or all from there on. */
enum what { FAIL_NOTHING, FAIL_MEMORY, FAIL_FILES };
enum { SHORT_COUNT = -1 }; /* in place of an errno: reads and writes do half of what they are asked for, and succeed */

void arm(enum what what, long at, int for_ever, int error);

/* Nothing fails any more; returns how many calls counted. */
long disarm(void);

/* Name of the call that failed first, "" if none did. */
const char *failed_call(void);

/* Blocks of memory that were taken since watch_memory() and are not given back. */
void watch_memory(void);
long blocks_held(void);

#endif
