/* Slow, direct Lomb-Scargle periodogram in 113-bit arithmetic: the reference for the streaming periodogram. */
#ifndef TOLIMAN_TESTS_QUAD_PERIOD_H
#define TOLIMAN_TESTS_QUAD_PERIOD_H

#include "quad_math.h"
#include <stddef.h>

typedef struct {
    const double *t, *y, *sigma; /* sigma may be NULL */
    size_t n;
    const double *t_low; /* times are t + t_low; may be NULL */
} quad_samples;

static inline quad quad_time(const quad_samples *s, size_t i) {
    return s->t_low ? (quad)s->t[i] + s->t_low[i] : s->t[i];
}

/* Solves the n x n system in place, largest pivot first; the solution replaces b. */
static inline void quad_solve(quad a[3][3], quad b[3], int n) {
    for (int i = 0; i < n; i++) {
        int p = i;
        for (int r = i + 1; r < n; r++)
            if (fabsq(a[r][i]) > fabsq(a[p][i]))
                p = r;
        for (int c = 0; c < n; c++) {
            const quad swap = a[i][c];
            a[i][c] = a[p][c];
            a[p][c] = swap;
        }
        const quad swap = b[i];
        b[i] = b[p];
        b[p] = swap;
        for (int r = i + 1; r < n; r++) {
            const quad factor = a[r][i] / a[i][i];
            for (int c = i; c < n; c++)
                a[r][c] -= factor * a[i][c];
            b[r] -= factor * b[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int c = i + 1; c < n; c++)
            b[i] -= a[i][c] * b[c];
        b[i] /= a[i][i];
    }
}

/* Residual sum of squares over total sum of squares about the weighted mean, at frequency f. */
static inline quad quad_residual(const quad_samples *s, quad f, int fixed_mean) {
    quad a[3][3] = {{0}}, b[3] = {0}, weight = 0, mean = 0, total = 0, left = 0, middle = 0;
    for (size_t i = 0; i < s->n; i++) {
        const quad sigma = s->sigma ? s->sigma[i] : 1;
        weight += 1 / (sigma * sigma);
        mean += s->y[i] / (sigma * sigma);
        middle += quad_time(s, i);
    }
    mean /= weight;
    middle /= (quad)s->n;
    const int first = fixed_mean ? 1 : 0, size = 3 - first;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < s->n; i++) {
            const quad sigma = s->sigma ? s->sigma[i] : 1, w = 1 / (sigma * sigma), y = s->y[i] - mean;
            const quad angle = 2 * M_PIq * f * (quad_time(s, i) - middle);
            const quad row[3] = {1, cosq(angle), sinq(angle)};
            if (pass == 0) {
                total += w * y * y;
                for (int j = 0; j < size; j++) {
                    b[j] += w * row[first + j] * y;
                    for (int k = 0; k < size; k++)
                        a[j][k] += w * row[first + j] * row[first + k];
                }
                if (i + 1 == s->n)
                    quad_solve(a, b, size);
            } else {
                quad gap = y;
                for (int j = 0; j < size; j++)
                    gap -= b[j] * row[first + j];
                left += w * gap * gap;
            }
        }
    return left / total;
}

#endif
