/* Random numbers for tests: the same on every machine. */
#ifndef TOLIMAN_TESTS_UNIFORM_H
#define TOLIMAN_TESTS_UNIFORM_H

#include <stdint.h>

/* Between 0 and 1, both excluded; the state may be any number. */
static inline double uniform(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return ((double)(*state >> 11) + 0.5) * 0x1p-53;
}

/* Between -1 and 1. */
static inline double uniform_signed(uint64_t *state) {
    return 2 * uniform(state) - 1;
}

/* Nearly normal, with variance 1. */
static inline double noise(uint64_t *state) {
    double sum = -6;
    for (int i = 0; i < 12; i++)
        sum += uniform(state);
    return sum;
}

#endif
