/* Tests components against slow direct computations: whitening and covariance in long double, eigenvectors by Jacobi's
 * method, a dictionary learnt pixel by pixel. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

static uint64_t draws = 57;

int shim_gram(size_t rows, size_t cols, const double *reference, const double *variance, const double *derivative,
              size_t count, const double *nuisances, int raw, size_t bin, size_t frames, const double *counts,
              unsigned workers, double *gram, double *bounds);
int shim_pca(size_t frames, const double *gram, size_t count, double *series, double *share);
int shim_dictionary(size_t frames, const double *gram, size_t pixels, size_t count, double lambda, size_t iterations,
                    uint64_t seed, double *series, double *share, double *objective, size_t *done);
void shim_atom_normals(uint64_t seed, size_t count, double *out);

static double next_normal(void) {
    const double radius = sqrt(-2 * log(uniform(&draws)));
    return radius * cos(2 * M_PI * uniform(&draws));
}

static double *new_array(size_t n) {
    double *array = calloc(n, sizeof *array);
    assert_non_null(array);
    return array;
}

/* Gram matrix of data [frames][pixels], without preparation. */
static double *products_of(const double *data, size_t frames, size_t pixels) {
    double *gram = new_array(frames * frames);
    for (size_t i = 0; i < frames; i++)
        for (size_t j = 0; j < frames; j++)
            for (size_t p = 0; p < pixels; p++)
                gram[i * frames + j] += data[i * pixels + p] * data[j * pixels + p];
    return gram;
}

/* Jacobi's method: a [n][n] becomes diagonal; the rows of v are its eigenvectors, by descending eigenvalue. */
static void jacobi(size_t n, long double *a, long double *v) {
    for (size_t i = 0; i < n * n; i++)
        v[i] = i % (n + 1) == 0;
    for (int sweep = 0; sweep < 30; sweep++)
        for (size_t p = 0; p < n; p++)
            for (size_t q = p + 1; q < n; q++) {
                if (a[p * n + q] == 0)
                    continue;
                const long double t = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
                const long double tangent = (t < 0 ? -1 : 1) / (fabsl(t) + sqrtl(t * t + 1));
                const long double c = 1 / sqrtl(tangent * tangent + 1), s = tangent * c;
                for (size_t k = 0; k < n; k++) {
                    const long double x = a[k * n + p], y = a[k * n + q];
                    a[k * n + p] = c * x - s * y;
                    a[k * n + q] = s * x + c * y;
                }
                for (size_t k = 0; k < n; k++) {
                    const long double x = a[p * n + k], y = a[q * n + k];
                    a[p * n + k] = c * x - s * y;
                    a[q * n + k] = s * x + c * y;
                }
                for (size_t k = 0; k < n; k++) {
                    const long double x = v[p * n + k], y = v[q * n + k];
                    v[p * n + k] = c * x - s * y;
                    v[q * n + k] = s * x + c * y;
                }
            }
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++)
            if (a[j * n + j] > a[i * n + i]) {
                const long double value = a[i * n + i];
                a[i * n + i] = a[j * n + j];
                a[j * n + j] = value;
                for (size_t k = 0; k < n; k++) {
                    const long double x = v[i * n + k];
                    v[i * n + k] = v[j * n + k];
                    v[j * n + k] = x;
                }
            }
}

enum { ROWS = 8, COLS = 12, PIXELS = ROWS * COLS, NUISANCES = 2, FRAMES = 60 };

static double reference[PIXELS], variance[PIXELS], derivative[PIXELS], nuisances[NUISANCES][PIXELS],
    counts[FRAMES][PIXELS];

/* Frames of 1e6 counts with noise of 1e3, three hidden series and variations of both nuisances. */
static int make_frames(void **state) {
    static double hidden[3][PIXELS];
    for (size_t i = 0; i < PIXELS; i++) {
        reference[i] = 1e6 * (1 + 0.9 * uniform(&draws));
        variance[i] = reference[i];
        derivative[i] = 1e6 * next_normal();
        for (size_t k = 0; k < NUISANCES; k++)
            nuisances[k][i] = reference[i] * uniform(&draws) + 0.3 * derivative[i];
        for (size_t k = 0; k < 3; k++)
            hidden[k][i] = 1e3 * (double)(5 - k) * next_normal();
    }
    for (size_t f = 0; f < FRAMES; f++) {
        double scale[5];
        for (size_t k = 0; k < 5; k++)
            scale[k] = next_normal();
        for (size_t i = 0; i < PIXELS; i++) {
            counts[f][i] =
                reference[i] + 1e3 * next_normal() + 0.01 * (scale[3] * nuisances[0][i] + scale[4] * nuisances[1][i]);
            for (size_t k = 0; k < 3; k++)
                counts[f][i] += scale[k] * hidden[k][i];
            counts[f][i] = nearbyint(counts[f][i]);
        }
    }
    return 0;
}

/* Bins an image by bin x bin pixels. */
static size_t bin_image(const double *image, size_t bin, long double *out) {
    const size_t across = COLS / bin, pixels = ROWS / bin * across;
    for (size_t p = 0; p < pixels; p++)
        out[p] = 0;
    for (size_t r = 0; r < ROWS; r++)
        for (size_t c = 0; c < COLS; c++)
            out[r / bin * across + c / bin] += image[r * COLS + c];
    return pixels;
}

static void remove_direction(const long double *unit, long double *vector, size_t n) {
    long double product = 0;
    for (size_t p = 0; p < n; p++)
        product += unit[p] * vector[p];
    for (size_t p = 0; p < n; p++)
        vector[p] -= product * unit[p];
}

/* The expected prepared frames x [FRAMES][pixels], mean removed; returns the squared norm of the derivative. */
static size_t prepare(int raw, size_t bin, long double *x, long double *information) {
    static long double sigma[PIXELS], units[NUISANCES][PIXELS], signal[PIXELS];
    const size_t pixels = bin_image(variance, bin, sigma), projected = raw ? 0 : NUISANCES;
    for (size_t p = 0; p < pixels; p++)
        sigma[p] = raw ? 1 : sqrtl(sigma[p]);
    for (size_t k = 0; k < projected; k++) {
        long double length = 0;
        bin_image(nuisances[k], bin, units[k]);
        for (size_t p = 0; p < pixels; p++)
            units[k][p] /= sigma[p];
        for (size_t l = 0; l < k; l++)
            remove_direction(units[l], units[k], pixels);
        for (size_t p = 0; p < pixels; p++)
            length += units[k][p] * units[k][p];
        for (size_t p = 0; p < pixels; p++)
            units[k][p] /= sqrtl(length);
    }
    for (size_t f = 0; f <= FRAMES; f++) {
        long double *const frame = f < FRAMES ? x + f * pixels : signal;
        bin_image(f < FRAMES ? counts[f] : derivative, bin, frame);
        for (size_t p = 0; p < pixels; p++)
            frame[p] /= sigma[p];
        for (size_t k = 0; k < projected; k++)
            remove_direction(units[k], frame, pixels);
    }
    *information = 0;
    for (size_t p = 0; p < pixels; p++) {
        long double mean = 0;
        for (size_t f = 0; f < FRAMES; f++)
            mean += x[f * pixels + p] / FRAMES;
        for (size_t f = 0; f < FRAMES; f++)
            x[f * pixels + p] -= mean;
        *information += signal[p] * signal[p];
    }
    return pixels;
}

/* Scores on the eigenvectors of the covariance of the pixels. Residuals are float32: relative rounding error 6e-8. */
TEST_WITH(components_match_the_covariance, make_frames, NULL) {
    static long double x[FRAMES * PIXELS], covariance[PIXELS * PIXELS], vectors[PIXELS * PIXELS];
    enum { COUNT = 3 };
    for (int raw = 0; raw < 2; raw++)
        for (size_t bin = 1; bin <= 4; bin *= 2) {
            double gram[FRAMES * FRAMES], bounds[2], series[COUNT * FRAMES], share[COUNT];
            assert_int_equal(shim_gram(ROWS, COLS, reference, variance, derivative, NUISANCES, nuisances[0], raw, bin,
                                       FRAMES, counts[0], 2, gram, bounds),
                             0);
            assert_int_equal(shim_pca(FRAMES, gram, COUNT, series, share), 0);
            long double information, total = 0;
            const size_t n = prepare(raw, bin, x, &information);
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < n; j++) {
                    covariance[i * n + j] = 0;
                    for (size_t f = 0; f < FRAMES; f++)
                        covariance[i * n + j] += x[f * n + i] * x[f * n + j];
                }
            for (size_t i = 0; i < n; i++)
                total += covariance[i * n + i];
            jacobi(n, covariance, vectors);
            for (size_t k = 0; k < COUNT; k++) {
                double score[FRAMES], largest = 0;
                for (size_t f = 0; f < FRAMES; f++) {
                    long double sum = 0;
                    for (size_t p = 0; p < n; p++)
                        sum += x[f * n + p] * vectors[k * n + p];
                    score[f] = (double)sum;
                    largest = fabs(score[f]) > fabs(largest) ? score[f] : largest;
                }
                for (size_t f = 0; f < FRAMES; f++)
                    assert_close(series[k * FRAMES + f], largest > 0 ? score[f] : -score[f], 0, 3e-6 * fabs(largest));
                assert_close(share[k], (double)(covariance[k * n + k] / total), 1e-6, 0);
            }
            if (raw) {
                assert_true(isnan(bounds[0]) && isnan(bounds[1]));
            } else {
                const double crb = 1 / sqrt((double)information), white = (double)(n - NUISANCES) / FRAMES;
                assert_close(bounds[0], crb, 1e-12, 0);
                assert_close(bounds[1], crb * sqrt(2 * sqrt(white)), 1e-12, 0);
            }
        }
}

/* 300 frames make one full and one partial block; 10 x 13 pixels make two full slabs and a partial one. */
TEST(products_match_plain_loops_for_any_workers) {
    enum { N = 300, R = 10, C = 13, P = R * C };
    double *const frames = new_array(N * P), *const gram = new_array(N * N), *const same = new_array(N * N), bounds[2];
    double zero[P] = {0}, one[P];
    static long double mean[P];
    for (size_t p = 0; p < P; p++)
        one[p] = 1;
    for (size_t i = 0; i < N * P; i++)
        frames[i] = (double)(float)(next_normal() + 3); /* exact in float32 */
    assert_int_equal(shim_gram(R, C, zero, one, one, 0, NULL, 0, 1, N, frames, 1, gram, bounds), 0);
    for (size_t i = 0; i < N * P; i++)
        mean[i % P] += (long double)frames[i] / N;
    for (size_t i = 0; i < N; i++)
        for (size_t j = 0; j < N; j++) {
            long double sum = 0;
            for (size_t p = 0; p < P; p++)
                sum += (frames[i * P + p] - mean[p]) * (frames[j * P + p] - mean[p]);
            assert_close(gram[i * N + j], (double)sum, 0, 1e-13 * P);
        }
    for (unsigned workers = 2; workers < 5; workers++) {
        assert_int_equal(shim_gram(R, C, zero, one, one, 0, NULL, 0, 1, N, frames, workers, same, bounds), 0);
        assert_memory_equal(gram, same, N * N * sizeof *gram);
    }
    free(frames);
    free(gram);
    free(same);
}

static double soft(double value, double by) {
    return copysign(fmax(fabs(value) - by, 0), value);
}

/* Frames s_i u with a single direction u: the atom is u, the codes are s_i after soft thresholding. */
TEST(codes_of_one_direction_are_soft_thresholded) {
    enum { N = 50, P = 20 };
    double s[N], gram[N * N], series[N], share, objective, squares = 0, expected = 0;
    size_t done;
    for (size_t i = 0; i < N; i++) {
        s[i] = next_normal();
        squares += s[i] * s[i];
    }
    for (size_t i = 0; i < N * N; i++)
        gram[i] = s[i / N] * s[i % N];
    const double lambda = 2, penalty = lambda * sqrt(squares / (N * P));
    assert_int_equal(shim_dictionary(N, gram, P, 1, lambda, 200, 4, series, &share, &objective, &done), 0);
    assert_true(done > 0);
    double sign = 0;
    for (size_t i = 0; i < N; i++)
        sign += series[i] * s[i];
    sign = copysign(1, sign);
    for (size_t i = 0; i < N; i++) {
        assert_close(series[i], sign * soft(s[i], penalty), 0, 1e-9);
        expected += pow(s[i] - soft(s[i], penalty), 2) / squares + 2 * penalty * fabs(series[i]) / squares;
    }
    assert_close(objective, expected, 1e-9, 0);
}

/* The same algorithm with atoms as images: three rounds on frames of noise, with the same initial values. */
TEST(dictionary_matches_pixelwise_learning) {
    enum { N = 30, P = 40, K = 3, ROUNDS = 3 };
    static double x[N][P], atom[K][P], code[N][K];
    double start[K * N], squares = 0, series[K * N], share[K], objective, energy[K] = {0};
    size_t done;
    for (size_t i = 0; i < N; i++)
        for (size_t p = 0; p < P; p++) {
            x[i][p] = next_normal();
            squares += x[i][p] * x[i][p];
        }
    const double penalty = 0.7 * sqrt(squares / (N * P));
    shim_atom_normals(9, K * N, start);
    for (size_t j = 0; j < K; j++)
        for (size_t p = 0; p < P; p++)
            for (size_t i = 0; i < N; i++)
                atom[j][p] += start[j * N + i] * x[i][p];
    for (size_t round = 0; round <= ROUNDS; round++) {
        for (size_t j = 0; j < K; j++) {
            double length = 0, used = 0, better[P] = {0};
            for (size_t i = 0; i < N && round > 0; i++)
                used += code[i][j] * code[i][j];
            for (size_t p = 0; p < P; p++) {
                for (size_t i = 0; i < N && round > 0; i++) {
                    double left = x[i][p];
                    for (size_t l = 0; l < K; l++)
                        left -= l != j ? atom[l][p] * code[i][l] : 0;
                    better[p] += code[i][j] * left / used;
                }
                if (round == 0)
                    better[p] = atom[j][p];
                length += better[p] * better[p];
            }
            for (size_t p = 0; p < P; p++)
                atom[j][p] = better[p] / fmax(1, sqrt(length));
        }
        for (size_t i = 0; i < N; i++)
            for (size_t step = 0; step < 20000; step++) { /* by proximal gradient, starting from 0 */
                double slope[K] = {0};
                for (size_t p = 0; p < P; p++) {
                    double left = x[i][p];
                    for (size_t l = 0; l < K; l++)
                        left -= step > 0 ? atom[l][p] * code[i][l] : 0;
                    for (size_t j = 0; j < K; j++)
                        slope[j] += left * atom[j][p];
                }
                double change = 0;
                for (size_t j = 0; j < K; j++) {
                    const double last = step > 0 ? code[i][j] : 0;
                    code[i][j] = soft(last + slope[j] / K, penalty / K);
                    change = fmax(change, fabs(code[i][j] - last));
                }
                if (change < 1e-13)
                    break;
            }
    }
    double *const gram = products_of(x[0], N, P);
    assert_int_equal(shim_dictionary(N, gram, P, K, 0.7, ROUNDS, 9, series, share, &objective, &done), 0);
    free(gram);
    double expected = 0;
    for (size_t i = 0; i < N; i++)
        for (size_t p = 0; p < P; p++) {
            double left = x[i][p];
            for (size_t j = 0; j < K; j++)
                left -= atom[j][p] * code[i][j];
            expected += left * left / squares;
        }
    for (size_t i = 0; i < N; i++)
        for (size_t j = 0; j < K; j++) {
            expected += 2 * penalty * fabs(code[i][j]) / squares;
            energy[j] += code[i][j] * code[i][j];
        }
    assert_close(objective, expected, 1e-8, 0);
    int taken[K] = {0};
    for (size_t rank = 0; rank < K; rank++) { /* by descending energy */
        size_t j = K;
        for (size_t l = 0; l < K; l++)
            if (!taken[l] && (j == K || energy[l] > energy[j]))
                j = l;
        taken[j] = 1;
        double sign = 0;
        for (size_t i = 0; i < N; i++)
            sign += series[rank * N + i] * code[i][j];
        for (size_t i = 0; i < N; i++)
            assert_close(series[rank * N + i], copysign(code[i][j], sign * code[i][j]), 0, 1e-7);
    }
}

TEST_WITH(equal_frames_have_series_of_zeros, make_frames, NULL) {
    enum { COUNT = 2 };
    double gram[FRAMES * FRAMES], bounds[2], series[COUNT * FRAMES], share[COUNT], objective;
    size_t done;
    for (size_t f = 1; f < FRAMES; f++)
        memcpy(counts[f], counts[0], sizeof counts[0]);
    assert_int_equal(
        shim_gram(ROWS, COLS, reference, variance, derivative, 0, NULL, 0, 1, FRAMES, counts[0], 1, gram, bounds), 0);
    for (int dictionary = 0; dictionary < 2; dictionary++) {
        memset(series, 1, sizeof series);
        if (dictionary)
            shim_dictionary(FRAMES, gram, PIXELS, COUNT, 1, 10, 0, series, share, &objective, &done);
        else
            shim_pca(FRAMES, gram, COUNT, series, share);
        for (size_t i = 0; i < COUNT * FRAMES; i++)
            assert_true(series[i] == 0);
        assert_true(share[0] == 0 && share[1] == 0);
    }
    assert_true(objective == 0);
}

/* Two orthogonal series of equal norm: the result is any basis of their plane, without components outside it. */
TEST(equal_eigenvalues_share_their_plane) {
    enum { N = 40, COUNT = 3 };
    double gram[N * N], series[COUNT * N], share[COUNT];
    for (size_t i = 0; i < N * N; i++)
        gram[i] = cos(2 * M_PI * (double)(i / N) / N) * cos(2 * M_PI * (double)(i % N) / N) +
                  sin(2 * M_PI * (double)(i / N) / N) * sin(2 * M_PI * (double)(i % N) / N);
    assert_int_equal(shim_pca(N, gram, COUNT, series, share), 0);
    for (size_t i = 0; i < N * N; i++)
        assert_close(series[i / N] * series[i % N] + series[N + i / N] * series[N + i % N], gram[i], 0, 1e-14);
    assert_close(share[0], 0.5, 1e-14, 0);
    assert_close(share[1], 0.5, 1e-14, 0);
    for (size_t i = 0; i < N; i++)
        assert_true(series[2 * N + i] == 0);
    assert_true(share[2] == 0);
}

RUN_TESTS(NULL, NULL)
