/* The inverse of a matrix in long double. */
#ifndef TOLIMAN_TESTS_INVERT_H
#define TOLIMAN_TESTS_INVERT_H

#include <stddef.h>

/* Inverts a symmetric positive definite matrix by Gauss-Jordan elimination. */
static inline void invert(size_t n, long double *matrix) {
    for (size_t k = 0; k < n; k++) {
        const long double pivot = matrix[k * n + k];
        matrix[k * n + k] = 1;
        for (size_t j = 0; j < n; j++)
            matrix[k * n + j] /= pivot;
        for (size_t i = 0; i < n; i++) {
            if (i == k)
                continue;
            const long double factor = matrix[i * n + k];
            matrix[i * n + k] = 0;
            for (size_t j = 0; j < n; j++)
                matrix[i * n + j] -= factor * matrix[k * n + j];
        }
    }
}

#endif
