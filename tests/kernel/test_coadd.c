/* Tests the kernels of sums of frames against plain loops in double, for shapes with and without a last part of a
 * vector, and that every instruction set gives the same bits. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_coadd_accumulate(int isa, const uint16_t *counts, const size_t *shape, const uint16_t *images, size_t stride,
                           const float *scales, const float *arrays, const float *limits, float flux, size_t start,
                           size_t step, double *sums);
size_t shim_coadd_test(int isa, const uint16_t *counts, const size_t *shape, const uint16_t *images, size_t stride,
                       const float *scales, const float *arrays, const float *limits, const float *fitted,
                       uint32_t *found, size_t capacity);
void shim_coadd_add(int isa, const uint16_t *counts, const size_t *shape, uint32_t *sums);
size_t shim_coadd_zero_rows(int isa, const uint16_t *counts, const size_t *shape);

enum { MOST = 40 * 96, SUMS = 10, LIMIT = 36, MOST_FOUND = 64 };

static const size_t kShapes[][3] = {{32, 64, 64}, {40, 75, 80}, {7, 5, 9}, {17, 16, 33}}; /* rows, cols, stride */
static const float kScales[2] = {0.01f, 0.004f}, kFlux = 1.03f, kFitted[3] = {1.02f, 0.05f, -0.03f};
static const float kUnused = 1e30f;
static uint16_t counts[MOST], images[3 * MOST + 64];
static float arrays[4 * MOST];
static uint64_t state = 5;

static double light_of(size_t size, size_t i) {
    return (double)kScales[0] * images[i] + 0 * (double)size;
}
static double slope_of(size_t size, size_t i, size_t which) {
    return (double)kScales[1] * (int16_t)images[which * size + i];
}

/* A frame with counts near those of the model, two cosmic rays, a saturated pixel, and pixels that are not used. */
static void make(const size_t *shape, size_t stride, int uniform_pixels) {
    const size_t pixels = shape[0] * shape[1], size = shape[0] * stride;
    for (size_t i = 0; i < 3 * size; i++)
        images[i] = (uint16_t)(i < size ? 100 + 30000 * uniform(&state) : (int16_t)(3000 * uniform_signed(&state)));
    for (size_t r = 0; r < shape[0]; r++)
        for (size_t c = 0; c < shape[1]; c++) {
            const size_t p = r * shape[1] + c;
            const int plain = uniform_pixels || p % 3 == 0;
            arrays[p] = plain ? 2 : 2.1f;
            arrays[pixels + p] = plain ? 200 : 190;
            arrays[2 * pixels + p] = plain ? 1 : 1.05f;
            arrays[3 * pixels + p] = plain ? 4 : 5;
            if (!uniform_pixels && p % 31 == 7)
                arrays[3 * pixels + p] = kUnused;
            const double photons = light_of(size, r * stride + c);
            const double value =
                (photons + 4 * sqrt(photons) * uniform_signed(&state) + (double)arrays[pixels + p]) / (double)arrays[p];
            counts[r * shape[2] + c] = (uint16_t)fmax(0, rint(value));
        }
    counts[shape[2] + 2] = 3000;
    counts[3 * shape[2] + 4] += 200;
    counts[5 * shape[2] + 1] = 4095;
}

TEST(sums_are_those_of_a_plain_loop) {
    for (size_t s = 0; s < sizeof kShapes / sizeof *kShapes; s++)
        for (int uniform_pixels = 0; uniform_pixels < 2; uniform_pixels++)
            for (size_t step = 1; step <= 4; step += 3) {
                const size_t *const shape = kShapes[s], stride = (shape[1] + 15) / 16 * 16;
                const size_t size = shape[0] * stride, pixels = shape[0] * shape[1], start = step / 2;
                const float limits[5] = {0.5f, 1e4f, 4095, (float)uniform_pixels, 0};
                make(shape, stride, uniform_pixels);
                double expected[SUMS] = {0}, magnitude[SUMS] = {0};
                for (size_t r = start; r < shape[0]; r += step)
                    for (size_t c = 0; c < shape[1]; c++) {
                        const size_t i = r * stride + c, p = r * shape[1] + c;
                        const double l = light_of(size, i), x = slope_of(size, i, 1), y = slope_of(size, i, 2);
                        const double m = (double)kFlux * l, w = 1 / (fmax(m, 0.5) * (double)arrays[2 * pixels + p] +
                                                                     (double)arrays[3 * pixels + p]);
                        const double n = counts[r * shape[2] + c];
                        const double d = n * (double)arrays[p] - (double)arrays[pixels + p] - m;
                        const double terms[SUMS] = {l * l, l * x, l * y, x * x, x * y,
                                                    y * y, l * d, x * d, y * d, d * d};
                        for (size_t k = 0; k < SUMS; k++) {
                            expected[k] += w * terms[k];
                            magnitude[k] += w * fabs(terms[k]);
                        }
                    }
                double first[SUMS];
                for (int isa = 0; isa < shim_isas(); isa++) {
                    double sums[SUMS];
                    shim_coadd_accumulate(isa, counts, shape, images, stride, kScales, arrays, limits, kFlux, start,
                                          step, sums);
                    for (size_t k = 0; k < SUMS; k++)
                        assert_close(sums[k], expected[k], 0, 2e-6 * magnitude[k]);
                    if (isa == 0)
                        memcpy(first, sums, sizeof sums);
                    assert_memory_equal(sums, first, sizeof sums);
                }
            }
}

TEST(pixels_beyond_the_limit_are_found) {
    for (size_t s = 0; s < sizeof kShapes / sizeof *kShapes; s++)
        for (int kind = 0; kind < 3; kind++) {
            const int uniform_pixels = kind > 0, far = kind > 1;
            const size_t *const shape = kShapes[s], stride = (shape[1] + 15) / 16 * 16;
            const size_t size = shape[0] * stride, pixels = shape[0] * shape[1];
            const double limit = far ? 2e4 : 330; /* some pixels are near it, or none */
            const float limits[5] = {0.5f, (float)limit, 4095, (float)uniform_pixels, (float)far};
            make(shape, stride, uniform_pixels);
            size_t count = 0, unclear = 0;
            uint32_t expected[MOST];
            for (size_t r = 0; r < shape[0]; r++)
                for (size_t c = 0; c < shape[1]; c++) {
                    const size_t i = r * stride + c, p = r * shape[1] + c;
                    const double a = (double)arrays[2 * pixels + p], b = (double)arrays[3 * pixels + p];
                    const double m =
                        fmax(0.5, (double)kFitted[0] * light_of(size, i) + (double)kFitted[1] * slope_of(size, i, 1) +
                                      (double)kFitted[2] * slope_of(size, i, 2));
                    const double v = m * a + b, n = counts[r * shape[2] + c];
                    const double d = n * (double)arrays[p] - (double)arrays[pixels + p] - m, margin = limit * a - m;
                    const double beyond = d * d - LIMIT * (v + fmax(d, 0) * a / 3),
                                 full = 25 * v - margin * fabs(margin);
                    if (b > 1e29)
                        continue;
                    if (fabs(beyond) < 1e-4 * LIMIT * v || fabs(full) < 1e-4 * (25 * v + margin * margin))
                        unclear++;
                    if (beyond > 0 || n >= 4095 || full > 0)
                        expected[count++] = (uint32_t)p;
                }
            assert_int_equal(unclear, 0);
            assert_true(count >= 2 && (count > 3 || far || pixels < 100));
            for (int isa = 0; isa < shim_isas(); isa++) {
                uint32_t found[MOST] = {0};
                assert_int_equal(
                    shim_coadd_test(isa, counts, shape, images, stride, kScales, arrays, limits, kFitted, found, MOST),
                    count);
                assert_memory_equal(found, expected, count * sizeof *found);
                uint32_t few[2] = {0, 77};
                assert_int_equal(
                    shim_coadd_test(isa, counts, shape, images, stride, kScales, arrays, limits, kFitted, few, 1),
                    count);
                assert_true(few[0] == expected[0] && few[1] == 77);
            }
        }
}

TEST(counts_are_added) {
    for (size_t s = 0; s < sizeof kShapes / sizeof *kShapes; s++) {
        const size_t *const shape = kShapes[s], pixels = shape[0] * shape[1];
        make(shape, (shape[1] + 15) / 16 * 16, 1);
        counts[0] = 65535;
        for (size_t c = 0; c < shape[1]; c++)
            counts[6 * shape[2] + c] = 0;
        for (int isa = 0; isa < shim_isas(); isa++) {
            uint32_t sums[MOST];
            for (size_t p = 0; p < pixels; p++)
                sums[p] = (uint32_t)p;
            shim_coadd_add(isa, counts, shape, sums);
            shim_coadd_add(isa, counts, shape, sums);
            for (size_t p = 0; p < pixels; p++)
                assert_int_equal(sums[p], p + 2u * counts[p / shape[1] * shape[2] + p % shape[1]]);
            assert_int_equal(shim_coadd_zero_rows(isa, counts, shape), 1);
        }
    }
}

RUN_TESTS(NULL, NULL)
