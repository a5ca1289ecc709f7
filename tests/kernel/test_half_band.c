/* Tests the interpolation of images from every other sample: waves inside the band to the stated error, the adjoint. */
#include "assert_close.h"

size_t shim_half_band(double cutoff, double accuracy);
void shim_sparse_size(double cutoff, double accuracy, size_t rows, size_t cols, size_t *sparse_rows,
                      size_t *sparse_cols);
void shim_half_band_apply(double cutoff, double accuracy, size_t rows, size_t cols, int adjoint, const double *from,
                          size_t count, double *to);

enum { MOST = 300 * 300 };

/* A wave of these frequencies (cycles per dense sample) at sample (row, col) of a grid whose step is `step`. */
static double wave(size_t row, size_t col, size_t rows, size_t cols, int step, long double fx, long double fy) {
    const long double x = step * ((long double)col - ((long double)cols - 1) / 2),
                      y = step * ((long double)row - ((long double)rows - 1) / 2);
    return (double)cosl(2 * acosl(-1) * (fx * x + fy * y) + 0.7L);
}

static void check_wave(double cutoff, double accuracy, size_t rows, size_t cols, double fx, double fy) {
    static double sparse[MOST], dense[MOST];
    size_t sparse_rows, sparse_cols;
    shim_sparse_size(cutoff, accuracy, rows, cols, &sparse_rows, &sparse_cols);
    assert_true(sparse_rows * sparse_cols <= MOST && sparse_rows % 2 == 1 && sparse_cols % 2 == 1);
    for (size_t i = 0; i < sparse_rows * sparse_cols; i++)
        sparse[i] = wave(i / sparse_cols, i % sparse_cols, sparse_rows, sparse_cols, 2, fx, fy);
    shim_half_band_apply(cutoff, accuracy, rows, cols, 0, sparse, sparse_rows * sparse_cols, dense);
    double worst = 0;
    for (size_t i = 0; i < rows * cols; i++)
        worst = fmax(worst, fabs(dense[i] - wave(i / cols, i % cols, rows, cols, 1, fx, fy)));
    if (!(worst <= accuracy)) /* the amplitude of a wave is 1 */
        fail_msg("cutoff %g, accuracy %g, %zu x %zu, wave (%g, %g): error %g", cutoff, accuracy, rows, cols, fx, fy,
                 worst);
}

TEST(waves_inside_the_band) {
    static const double cutoffs[] = {0.1, 0.2, 0.2149, 0.224}, accuracies[] = {1e-4, 1e-5, 1e-8};
    static const size_t sides[] = {41, 43, 45, 63}; /* the middle is a sample of either parity */
    for (size_t c = 0; c < sizeof cutoffs / sizeof *cutoffs; c++)
        for (size_t a = 0; a < sizeof accuracies / sizeof *accuracies; a++)
            for (size_t i = 0; i < 4; i++)
                for (int part = 0; part <= 4; part++)
                    check_wave(cutoffs[c], accuracies[a], sides[i], sides[(i + 1) % 4], cutoffs[c] * part / 4,
                               -cutoffs[c] * (4 - part) / 4);
}

TEST(adjoint_is_the_transpose) {
    static double dense[MOST], sparse[MOST], forward[MOST], back[MOST];
    static const size_t sides[][2] = {{41, 43}, {43, 41}, {7, 45}};
    for (size_t s = 0; s < 3; s++) {
        const size_t rows = sides[s][0], cols = sides[s][1];
        size_t sparse_rows, sparse_cols;
        shim_sparse_size(0.2, 1e-5, rows, cols, &sparse_rows, &sparse_cols);
        const size_t count = sparse_rows * sparse_cols;
        for (size_t i = 0; i < count; i++)
            sparse[i] = sin(0.1 + 1.7 * (double)(i * i % 1013));
        for (size_t i = 0; i < rows * cols; i++)
            dense[i] = cos(0.3 + 2.3 * (double)(i * i % 997));
        shim_half_band_apply(0.2, 1e-5, rows, cols, 0, sparse, count, forward);
        shim_half_band_apply(0.2, 1e-5, rows, cols, 1, dense, rows * cols, back);
        long double one = 0, other = 0;
        for (size_t i = 0; i < rows * cols; i++)
            one += (long double)dense[i] * forward[i];
        for (size_t i = 0; i < count; i++)
            other += (long double)sparse[i] * back[i];
        assert_close((double)one, (double)other, 1e-11, 1e-11);
    }
}

size_t shim_half_band_images(const char *scene_json, double accuracy, double *difference);

TEST(images_are_those_of_all_samples) {
    static const char kScene[] =
        "{\"schema\": \"toliman-scene/1\","
        " \"telescope\": {\"aperture_m\": 0.125, \"pupil_samples\": 96,"
        "  \"struts\": {\"count\": 3, \"width_m\": 0.003, \"angle_deg\": 20},"
        "  \"mask\": {\"kind\": \"spiral\", \"opd_nm\": 292.5, \"edges\": \"area\","
        "   \"terms\": [{\"a\": 1, \"f\": 1.2, \"m\": -5, \"p\": 1}]}},"
        " \"band\": {\"min_nm\": 530, \"max_nm\": 640, \"step_nm\": 10},"
        " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"photons_per_s\": "
        "7e11}},"
        " \"binary\": {\"offsets_px\": {\"A\": [0, 0]}}, \"cadence\": {\"frames\": 4, \"interval_days\": 30, "
        "\"exposure_s\": 1},"
        " \"detector\": {\"shape\": [48, 40], \"pixel_scale_arcsec\": 0.375}, \"accuracy\": 1e-9}";
    static const double accuracies[] = {1e-4, 1e-6};
    for (size_t a = 0; a < 2; a++) {
        double difference[11]; /* of ten images, and of the adjoint */
        assert_in_range(shim_half_band_images(kScene, accuracies[a], difference), 10, 40);
        for (size_t i = 0; i < 10; i++)
            if (!(difference[i] <= accuracies[a]))
                fail_msg("accuracy %g: image %zu differs by %g of its largest value", accuracies[a], i, difference[i]);
        if (!(difference[10] <= 1e-11))
            fail_msg("the adjoint differs by %g", difference[10]);
    }
}

TEST(wide_bands_need_every_sample) {
    assert_int_equal(shim_half_band(0.23, 1e-5), 0);
    assert_int_equal(shim_half_band(0.4, 1e-5), 0);
    assert_in_range(shim_half_band(0.2149, 1e-5), 10, 30);
}

RUN_TESTS(NULL, NULL)
