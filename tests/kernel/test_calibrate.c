/* Tests the joint step and its covariance against the whole system, solved without elimination in long double; the
 * derivatives by each parameter of the instrument against differences of whole images; and the symmetry of pupils. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_joint_step(size_t windows, size_t frames, size_t n, const double *sigma, double smoothness,
                    const double *matrices, const double *gradients, const double *values, double damping,
                    double *change, double *covariance, double *of_frames);
int shim_instrument_derivative(const char *json, const char *folder, const char *parameter, double step,
                               const double *own, double *derivative, double *difference);
int shim_is_antisymmetric(const char *json, const char *folder);
int shim_is_even(int noll);

enum { OWN = 7, N = 4, FRAMES = 6, SIZE = OWN + N, MOST = 3 * N + FRAMES * OWN, SAMPLES = 40 };

static const double kSigma[N] = {0.5, 2, 0.1, 30};
static const double kSmoothness = 0.03;

static double matrices[FRAMES][SIZE][SIZE], gradients[FRAMES][SIZE], values[3 * N];
static long double whole[MOST][2 * MOST], right[MOST];

/* Normal equations of random derivatives; the own parameters of a frame resemble those of the instrument. */
static void make_blocks(void) {
    uint64_t seed = 11;
    for (size_t k = 0; k < FRAMES; k++)
        for (size_t s = 0; s < SAMPLES; s++) {
            double row[SIZE];
            for (size_t i = 0; i < SIZE; i++)
                row[i] = uniform_signed(&seed) + (i >= OWN ? 0.7 * row[i - OWN] : 0);
            const double residual = uniform_signed(&seed);
            for (size_t i = 0; i < SIZE; i++) {
                gradients[k][i] += row[i] * residual;
                for (size_t j = 0; j < SIZE; j++)
                    matrices[k][i][j] += row[i] * row[j];
            }
        }
    for (size_t i = 0; i < 3 * N; i++)
        values[i] = 0.1 * uniform_signed(&seed);
}

/* The row of parameter i of frame k in the whole system, and its weight: the frame's own, or that of the instrument at
 * the start of the frame's window (next = 0), or at the next start. */
static size_t row_of(size_t windows, size_t k, size_t i, size_t next, long double *weight) {
    const size_t window = k % windows;
    const long double share = window + 1 < windows ? (long double)k / FRAMES : 0;
    *weight = i < OWN ? (next == 0) : next == 0 ? 1 - share : share;
    return i < OWN ? windows * N + k * OWN + i : (window + (*weight > 0 ? next : 0)) * N + i - OWN;
}

/* The whole system: parameters of the instrument at each start of a window, then those of the frames. */
static size_t assemble(size_t windows, double damping) {
    const size_t all = windows * N, size = all + FRAMES * OWN;
    memset(whole, 0, sizeof whole);
    memset(right, 0, sizeof right);
    for (size_t k = 0; k < FRAMES; k++)
        for (size_t i = 0; i < 2 * SIZE; i++) {
            long double of_row, of_col;
            const size_t row = row_of(windows, k, i / 2, i % 2, &of_row);
            right[row] += of_row * gradients[k][i / 2];
            for (size_t j = 0; j < 2 * SIZE; j++) {
                const size_t col = row_of(windows, k, j / 2, j % 2, &of_col);
                whole[row][col] += of_row * of_col * matrices[k][i / 2][j / 2];
            }
        }
    for (size_t w = 0; w < windows; w++)
        for (size_t i = 0; i < N; i++) {
            const long double elapsed = w + 1, /* window lengths since the one before */
                sigma = kSigma[i] * (w == 0 ? 1 : kSmoothness * sqrtl(elapsed)), weight = 1 / (sigma * sigma);
            const size_t at = w * N + i, before = at - N;
            whole[at][at] += weight;
            right[at] -= weight * (values[at] - (w == 0 ? 0 : values[before]));
            if (w == 0)
                continue;
            whole[before][before] += weight;
            whole[at][before] -= weight;
            whole[before][at] -= weight;
            right[before] += weight * (values[at] - values[before]);
        }
    for (size_t i = 0; i < size; i++)
        whole[i][i] *= 1 + (long double)damping;
    return size;
}

/* Gauss-Jordan with the identity to the right of the matrix, which becomes its inverse; right becomes the solution. */
static void solve(size_t size) {
    for (size_t i = 0; i < size; i++)
        for (size_t j = 0; j < size; j++)
            whole[i][size + j] = i == j;
    for (size_t pivot = 0; pivot < size; pivot++) {
        const long double by = whole[pivot][pivot];
        for (size_t j = 0; j < 2 * size; j++)
            whole[pivot][j] /= by;
        right[pivot] /= by;
        for (size_t i = 0; i < size; i++) {
            const long double factor = i == pivot ? 0 : whole[i][pivot];
            for (size_t j = 0; factor != 0 && j < 2 * size; j++)
                whole[i][j] -= factor * whole[pivot][j];
            right[i] -= factor * right[pivot];
        }
    }
}

TEST(step_and_covariance_are_those_of_the_whole_system) {
    make_blocks();
    double change[MOST], covariance[9 * N * N], of_frames[FRAMES][OWN][OWN];
    for (size_t windows = 1; windows <= 3; windows++)
        for (int damped = 0; damped < 2; damped++) {
            const double damping = damped * 0.3;
            assert_int_equal(shim_joint_step(windows, FRAMES, N, kSigma, kSmoothness, &matrices[0][0][0],
                                             &gradients[0][0], values, damping, change, covariance,
                                             &of_frames[0][0][0]),
                             1);
            size_t size = assemble(windows, damping);
            solve(size);
            for (size_t i = 0; i < size; i++)
                assert_close(change[i], (double)right[i], 1e-10, 1e-12);
            size = assemble(windows, 0);
            solve(size);
            const size_t all = windows * N;
            for (size_t i = 0; i < all; i++)
                for (size_t j = 0; j < all; j++)
                    assert_close(covariance[i * all + j], (double)whole[i][size + j], 1e-9, 1e-12);
            for (size_t k = 0; k < FRAMES; k++)
                for (size_t i = 0; i < OWN; i++)
                    for (size_t j = 0; j < OWN; j++)
                        assert_close(of_frames[k][i][j], (double)whole[all + k * OWN + i][size + all + k * OWN + j],
                                     1e-9, 1e-12);
        }
}

static const char kScene[] =
    "{\"schema\": \"toliman-scene/1\", \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.032, %s"
    "\"pupil_samples\": 64, \"mask\": {\"kind\": \"spiral\", \"edges\": \"area\", \"opd_nm\": 292.5, \"terms\": "
    "[{\"a\": 1, \"f\": 1.2, \"m\": -5, \"p\": 1}]},"
    "\"aberrations\": {\"zernike_rms_nm\": {\"5\": 4, \"7\": 9, \"11\": -6}}},"
    "\"band\": {\"min_nm\": 530, \"max_nm\": 640, \"step_nm\": 27.5}, \"stars\": {"
    "\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"photons_per_s\": 7e7},"
    "\"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"photons_per_s\": 2e7}},"
    "\"binary\": {\"separation_arcsec\": 4, \"position_angle_deg\": 30},"
    "\"systematics\": {\"jitter_sigma_px\": 0.1}, \"cadence\": {\"frames\": 4, \"interval_days\": 1, \"exposure_s\": "
    "10},"
    "\"detector\": {\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375, \"pixel\": \"point\"},"
    "\"noise\": {\"photon\": true, \"seed\": 1}, \"accuracy\": 1e-9}";

static const char *scene_with(const char *struts) {
    static char text[4096];
    snprintf(text, sizeof text, kScene, struts);
    return text;
}

TEST(derivatives_agree_with_differences_of_images) {
    const struct {
        const char *name;
        double step, tolerance; /* of the largest */
    } kCases[] = {
        {"focus", 0.05, 2e-4},         {"zernike_8", 0.05, 2e-4},    {"zernike_22", 0.05, 2e-4},
        {"scale", 1e-5, 2e-4},         {"anisotropy", 1e-5, 2e-4},   {"shear", 1e-5, 2e-4},
        {"mask_rotation", 0.02, 2e-3}, {"mask_shift_x", 2e-6, 2e-3}, {"jitter_xx", 1e-4, 1e-3},
        {"jitter_xy", 1e-4, 1e-3},     {"temperature_a", 5, 2e-4},   {"spectrum_b_3", 1e-4, 2e-4},
    };
    const double own[OWN] = {-1.3, 2.2, 4.1, -6.4, 0.02, -0.03, 5};
    static double derivative[48 * 48], difference[48 * 48];
    for (size_t i = 0; i < sizeof kCases / sizeof kCases[0]; i++) {
        assert_int_equal(
            shim_instrument_derivative(scene_with("\"struts\": {\"count\": 3, \"width_m\": 0.004, \"angle_deg\": 0},"),
                                       ".", kCases[i].name, kCases[i].step, own, derivative, difference),
            1);
        double largest = 0, worst = 0;
        for (size_t p = 0; p < 48 * 48; p++) {
            largest = fmax(largest, fabs(difference[p]));
            worst = fmax(worst, fabs(derivative[p] - difference[p]));
        }
        if (worst > kCases[i].tolerance * largest)
            print_error("%s: %g of the largest\n", kCases[i].name, worst / largest);
        assert_true(largest > 0 && worst <= kCases[i].tolerance * largest);
    }
}

TEST(aberrations_lose_their_sign_without_struts) {
    char *plain = strdup(scene_with(""));
    char *start = strstr(plain, ",\"aberrations\""), *end = strstr(plain, ",\"band\"");
    memmove(start + 1, end, strlen(end) + 1); /* nominal optics */
    *start = '}';
    assert_int_equal(shim_is_antisymmetric(plain, "."), 1);
    free(plain);
    assert_int_equal(shim_is_antisymmetric(scene_with(""), "."), 0); /* known aberrations tell the sign */
    assert_int_equal(
        shim_is_antisymmetric(scene_with("\"struts\": {\"count\": 3, \"width_m\": 0.004, \"angle_deg\": 0},"), "."), 0);
    const int even[] = {4, 5, 6, 11, 12, 13, 14, 15, 22}, odd[] = {7, 8, 9, 10, 16, 17, 18, 19, 20, 21};
    for (size_t i = 0; i < sizeof even / sizeof even[0]; i++)
        assert_int_equal(shim_is_even(even[i]), 1);
    for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++)
        assert_int_equal(shim_is_even(odd[i]), 0);
}

RUN_TESTS(NULL, NULL)
