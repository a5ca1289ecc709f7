/* Tests level sets: heights against slow sums, the gradient against differences, symmetry; and the removal of small
 * features against a slow search. */
#include <stdio.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

double shim_level_set(int points, double smoothing, int fine, int coarse, int symmetry, double slope,
                      const double *open, const double *heights, const double *weights, double *covered,
                      double *gradient, unsigned char *cells);
double shim_small_features(int samples, int side, const double *open, unsigned char *cells);

enum { POINTS = 10, FINE = 24, COARSE = 12, RATIO = FINE / COARSE, N = 20 };
enum { NONE, EVEN, ODD };

static uint64_t numbers_state;
static double open_cells[FINE * FINE], heights[POINTS * POINTS], weights[COARSE * COARSE];
static double covered[COARSE * COARSE], gradient[POINTS * POINTS], unused[POINTS * POINTS];
static unsigned char cells[FINE * FINE];

static double random_number(void) {
    return uniform_signed(&numbers_state);
}

static int set_up(void **state) {
    numbers_state = 11;
    for (int i = 0; i < FINE * FINE; i++)
        open_cells[i] = hypot(i % FINE - 11.5, i / FINE - 11.5) < 11.5 ? 0.3 : 0;
    for (int i = 0; i < POINTS * POINTS; i++)
        heights[i] = random_number();
    for (int i = 0; i < COARSE * COARSE; i++)
        weights[i] = random_number();
    return 0;
}

/* Interpolated height of a fine cell by all control points. */
static double slow_height(const double *from, int cell, double smoothing) {
    double sum = 0, norm = 0;
    for (int i = 0; i < POINTS * POINTS; i++) {
        const double x = (cell % FINE + 0.5) / FINE * POINTS - 0.5 - i % POINTS,
                     y = (cell / FINE + 0.5) / FINE * POINTS - 0.5 - i / POINTS;
        const double weight = exp(-0.5 * (x * x + y * y) / (smoothing * smoothing));
        sum += weight * from[i];
        norm += weight;
    }
    return sum / norm;
}

TEST_WITH(covered_fractions, set_up, NULL) {
    const double smoothing = 1.1, slope = 7;
    const double rms = shim_level_set(POINTS, smoothing, FINE, COARSE, NONE, slope, open_cells, heights, weights,
                                      covered, gradient, cells);
    double square = 0, count = 0, expected[COARSE * COARSE] = {0};
    for (int i = 0; i < FINE * FINE; i++)
        if (open_cells[i] > 0) {
            square += pow(slow_height(heights, i, smoothing), 2);
            count++;
        }
    assert_close(rms, sqrt(square / count), 1e-7, 0); /* Gaussians end at six standard deviations */
    for (int i = 0; i < FINE * FINE; i++) {
        const double height = slow_height(heights, i, smoothing);
        assert_int_equal(cells[i], height > 0);
        expected[i / FINE / RATIO * COARSE + i % FINE / RATIO] +=
            1 / (1 + exp(-slope * height / rms)) / (RATIO * RATIO);
    }
    for (int i = 0; i < COARSE * COARSE; i++)
        assert_close(covered[i], expected[i], 0, 1e-6);
}

static double weighted(int symmetry, double by, int point, double slope) {
    double moved[POINTS * POINTS], sum = 0;
    memcpy(moved, heights, sizeof moved);
    moved[point] += by;
    shim_level_set(POINTS, 1, FINE, COARSE, symmetry, slope, open_cells, moved, weights, covered, unused, cells);
    for (int i = 0; i < COARSE * COARSE; i++)
        sum += weights[i] * covered[i];
    return sum;
}

TEST_WITH(gradient_by_heights, set_up, NULL) {
    for (int symmetry = NONE; symmetry <= ODD; symmetry++)
        for (int slope = 3; slope <= 40; slope += 37) {
            shim_level_set(POINTS, 1, FINE, COARSE, symmetry, slope, open_cells, heights, weights, covered, gradient,
                           cells);
            for (int point = 0; point < POINTS * POINTS; point += 7) {
                const double h = 1e-4,
                             wide = weighted(symmetry, h, point, slope) - weighted(symmetry, -h, point, slope),
                             narrow =
                                 weighted(symmetry, h / 2, point, slope) - weighted(symmetry, -h / 2, point, slope);
                assert_close(gradient[point], (8 * narrow - wide) / (6 * h), 1e-7, 1e-8);
            }
        }
}

/* A mask turned by 180 degrees is itself, or its complement. */
TEST_WITH(symmetry, set_up, NULL) {
    for (int kind = EVEN; kind <= ODD; kind++) {
        shim_level_set(POINTS, 1, FINE, COARSE, kind, 5, open_cells, heights, weights, covered, gradient, cells);
        for (int i = 0; i < FINE * FINE; i++)
            assert_int_equal(cells[i], kind == EVEN ? cells[FINE * FINE - 1 - i] : !cells[FINE * FINE - 1 - i]);
    }
}

/* Whether a square of side x side cells of one kind, or closed, contains the cell. */
static int is_large(const unsigned char *mask, const double *open, int side, int cell) {
    for (int y = cell / N - side + 1; y <= cell / N; y++)
        for (int x = cell % N - side + 1; x <= cell % N; x++) {
            int whole = y >= 0 && x >= 0 && y + side <= N && x + side <= N;
            for (int i = 0; whole && i < side * side; i++) {
                const int at = (y + i / side) * N + x + i % side;
                whole = open[at] == 0 || mask[at] == mask[cell];
            }
            if (whole)
                return 1;
        }
    return 0;
}

TEST_WITH(small_features, set_up, NULL) {
    for (int side = 1; side <= 3; side++) {
        double open[N * N], count = 0, small = 0;
        unsigned char mask[N * N], before[N * N];
        for (int i = 0; i < N * N; i++) {
            open[i] = hypot(i % N - 9.5, i / N - 9.5) < 9.8;
            mask[i] = sin(0.9 * (i % N) + 0.05 * (i / N)) + 1.1 * cos(0.7 * (i / N)) > 0;
        }
        memcpy(before, mask, sizeof mask);
        for (int i = 0; i < N * N; i++) {
            count += open[i];
            small += open[i] * !is_large(mask, open, side, i);
        }
        assert_close(shim_small_features(N, side, open, mask), small / count, 1e-12, 0);
        if (side > 1)
            assert_true(small > 0);
        for (int i = 0; i < N * N; i++) {
            if (open[i] > 0)
                assert_true(is_large(mask, open, side, i));
            else
                assert_int_equal(mask[i], before[i]);
        }
    }
}

/* A bridge of one cell, which would be small with either kind, becomes wider. */
TEST(bridges) {
    static const char *const kBridge[] = {"1111111", "0111111", "0001111", "0001000", "0111000", "1111000", "1111100"};
    double open[N * N];
    unsigned char mask[N * N], before[N * N];
    for (int i = 0; i < N * N; i++) {
        const int row = (int)fmin(fmax(i / N - 6, 0), 6), col = (int)fmin(fmax(i % N - 6, 0), 6);
        open[i] = 1;
        before[i] = mask[i] = kBridge[row][col] == '1';
    }
    assert_close(shim_small_features(N, 2, open, mask), 1.0 / (N * N), 1e-12, 0);
    int changed = 0;
    for (int i = 0; i < N * N; i++) {
        assert_true(is_large(mask, open, 2, i));
        changed += mask[i] != before[i];
    }
    assert_in_range(changed, 1, 3);
}

RUN_TESTS(NULL, NULL)
