/* Tests propagation against sums in long double. */
#include <stdio.h>

#include "long_double_sim.h"

/* Largest error over some pixels, relative to the peak. */
static double error_to_peak(const toliman_sim *sim, long double aperture_m, long double pixel_arcsec,
                            const int *columns, int count_x, const int *rows, int count_y) {
    const toliman_sim_info info = sim_info_of(sim);
    reference r = reference_of(sim, aperture_m, pixel_arcsec);
    double u[32], v[32];
    long double sum[1024] = {0};
    for (int j = 0; j < count_x; j++)
        u[j] = columns[j] - (double)(info.cols - 1) / 2;
    for (int i = 0; i < count_y; i++)
        v[i] = rows[i] - (double)(info.rows - 1) / 2;
    add_stars(&r, u, count_x, v, count_y, sum);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    long double worst = 0;
    for (int i = 0; i < count_y; i++)
        for (int j = 0; j < count_x; j++)
            worst = fmaxl(worst, fabsl(image[rows[i] * info.cols + columns[j]] - sum[i * count_x + j]));
    free(image);
    release(&r);
    return (double)(worst / info.peak_photons);
}

/* A scene file with accuracy 1e-15: every wavelength is propagated. */
static char *exact_scene(const char *path) {
    char text[8192];
    FILE *const file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    return replaced(text, "'accuracy': 1e-9", "'accuracy': 1e-15");
}

/* promise: images-keep-their-accuracy */
TEST(chapter_against_long_double) {
    char *const text = exact_scene("examples/scenes/chapter.json");
    toliman_sim *const sim = sim_of(text);
    free(text);
    double offset[4];
    get_offsets(sim, offset);
    int columns[6], rows[6];
    for (int i = 0; i < 2; i++) { /* both cores, then the whole frame with its corners */
        columns[i] = (int)(127.5 + offset[0]) + i;
        rows[i] = (int)(127.5 + offset[1]) + i;
        columns[2 + i] = (int)(127.5 + offset[2]) + i;
        rows[2 + i] = (int)(127.5 + offset[3]) + i;
    }
    for (int i = 0; i < 2; i++)
        columns[4 + i] = rows[4 + i] = 255 * i;
    const double error = error_to_peak(sim, 0.125L, 0.20, columns, 6, rows, 6);
    print_message("chapter scene, 36 pixels: error/peak %.2g\n", error);
    assert_at_most(error, 1e-14);
    toliman_sim_destroy(sim);
}

/* Odd and even numbers of rows and columns, more rows than columns, a pupil with a central sample. */
TEST(odd_sizes_against_long_double) {
    char *text = EDITED(kBinaryScene, {"'pupil_samples': 96", "'pupil_samples': 65"}, {"[64, 64]", "[47, 32]"});
    toliman_sim *const sim = sim_of(text);
    int columns[16], rows[16];
    for (int i = 0; i < 16; i++) {
        columns[i] = 2 * i + (i > 7);
        rows[i] = 3 * i + (i == 15);
    }
    assert_at_most(error_to_peak(sim, 0.125L, 0.2, columns, 16, rows, 16), 1e-14);
    toliman_sim_destroy(sim), free(text);
}

/* sum a_i b_i */
static long double product(const double *a, const double *b, size_t n) {
    long double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (long double)a[i] * b[i];
    return sum;
}

/* Recovers a displacement from two images by least squares on the derivative images. The moving star is far from the
 * axis, where its position in double has an error of 2e-15 px. */
TEST(shifts_are_recovered) {
    toliman_sim *const sim = sim_with(kBinaryScene, "'separation_arcsec': 4, 'position_angle_deg': 30",
                                      "'offsets_px': {'A': [-3.2, 4.7], 'B': [19.3, -21.7]}");
    const size_t n = 64 * 64;
    double *const first = image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION), *const second =
                                                                           image_of(sim, TOLIMAN_SIM_IMAGE_CURVATURE);
    double *const still = doubles(n), *const moved = doubles(n);
    assert_ok(toliman_sim_propagate(sim, 0, still, 64));
    for (double d = 1e-6; d > 5e-11; d /= 100) {
        assert_ok(toliman_sim_propagate(sim, d, moved, 64));
        for (size_t i = 0; i < n; i++)
            moved[i] = moved[i] - still[i] - 0.5 * d * d * second[i];
        const double error = (double)(product(moved, first, n) / product(first, first, n) - d);
        print_message("shift %g px recovered with error %.2g px\n", d, error);
        assert_at_most(fabs(error), 3e-16);
    }
    free(first), free(second), free(still), free(moved), toliman_sim_destroy(sim);
}

/* Largest error of the Taylor expansion against exact propagation, relative to the largest pixel of the signal d I1. */
static double series_error(const toliman_sim *sim, const double *derivative, double d, size_t side) {
    double *const exact = doubles(side * side), *const series = doubles(side * side);
    assert_ok(toliman_sim_propagate(sim, d, exact, side));
    assert_ok(toliman_sim_expect(sim, d, series, side));
    double error = 0, signal = 0;
    for (size_t i = 0; i < side * side; i++) {
        error = fmax(error, fabs(series[i] - exact[i]));
        signal = fmax(signal, fabs(d * derivative[i]));
    }
    free(exact), free(series);
    return error / signal;
}

/* The scene's accuracy determines the expansion order: the error is as the info reports, and below the requested
 * accuracy. */
TEST(expansion_error_is_as_predicted) {
    const double displacements[] = {1e-1, 1e-2, 1e-4, 1e-6}, accuracies[] = {1e-2, 1e-4, 1e-6, 1e-9};
    for (size_t i = 0; i < 16; i++) {
        char amplitude[100];
        const double d = displacements[i / 4], accuracy = accuracies[i % 4];
        snprintf(amplitude, sizeof amplitude, "'amplitude_px': %g", d);
        char *text = replaced(kBinaryScene, "'amplitude_px': 1e-3", amplitude);
        snprintf(amplitude, sizeof amplitude, "'accuracy': %g, 'noise'", accuracy);
        text = replaced_again(text, "'noise'", amplitude);
        toliman_sim *const sim = sim_of(text);
        double *const derivative = image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION);
        toliman_sim_plan_info plan = {.struct_size = sizeof plan};
        assert_ok(toliman_sim_get_plan(sim, &plan));
        const double error = series_error(sim, derivative, d, 64), rounding = 1e-14 / d;
        print_message("series at %g px for %g: order %d, %.2g of the signal, predicted %.2g, planned %.2g\n", d,
                      accuracy, plan.order, error, sim_bounds_of(sim).truncation, plan.series_error);
        assert_at_most(plan.series_error, accuracy + rounding);
        assert_at_most(error, plan.series_error);
        assert_at_most(plan.series_error, 20 * error);
        if (error > 10 * rounding) /* below this, rounding exceeds the truncation error */
            assert_close(sim_bounds_of(sim).truncation, error, 0.2, 0);
        free(derivative), toliman_sim_destroy(sim), free(text);
    }
}

/* All derivative images against differences of propagated images: along the separation, and common shifts. */
/* promise: derivatives-are-exact */
TEST(derivatives_are_exact) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    const size_t n = 64 * 64;
    double *const first = image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION), *const second =
                                                                           image_of(sim, TOLIMAN_SIM_IMAGE_CURVATURE);
    double *const at[5] = {doubles(n), doubles(n), doubles(n), doubles(n), doubles(n)};
    const double h = 1e-2;
    for (int i = 0; i < 5; i++)
        assert_ok(toliman_sim_propagate(sim, (i - 2) * h, at[i], 64));
    double error_first = 0, error_second = 0, largest_first = 0, largest_second = 0;
    for (size_t i = 0; i < n; i++) { /* five-point differences, error O(h^4) */
        const double d1 = (at[0][i] - 8 * at[1][i] + 8 * at[3][i] - at[4][i]) / (12 * h);
        const double d2 = (-at[0][i] + 16 * at[1][i] - 30 * at[2][i] + 16 * at[3][i] - at[4][i]) / (12 * h * h);
        error_first = fmax(error_first, fabs(first[i] - d1));
        error_second = fmax(error_second, fabs(second[i] - d2));
        largest_first = fmax(largest_first, fabs(first[i]));
        largest_second = fmax(largest_second, fabs(second[i]));
    }
    assert_at_most(error_first / largest_first, 1e-8);
    assert_at_most(error_second / largest_second, 1e-8);
    for (int i = 0; i < 5; i++)
        free(at[i]);
    free(first), free(second), toliman_sim_destroy(sim);
}

/* Common shift images against scenes with slightly shifted stars. */
TEST(shift_images_are_exact) {
    const char *const place = "{'separation_arcsec': 4, 'position_angle_deg': 30}";
    const int32_t kinds[2] = {TOLIMAN_SIM_IMAGE_SHIFT_X, TOLIMAN_SIM_IMAGE_SHIFT_Y};
    const size_t n = 64 * 64;
    char *const text = replaced(kBinaryScene, "'peak_photons': 1e5", "'exposure_s': 1");
    char *const with_a = replaced(text, "'relative_flux': 3", "'photons_per_s': 3e6");
    char *const base = replaced(with_a, "'temperature_k': 5260}", "'temperature_k': 5260}, 'photons_per_s': 1e6");
    for (int axis = 0; axis < 2; axis++) {
        const double h = 1e-2;
        double *image[5];
        for (int i = 0; i < 5; i++) {
            char offsets[200];
            const double x = axis == 0 ? (i - 2) * h : 0, y = axis == 1 ? (i - 2) * h : 0;
            snprintf(offsets, sizeof offsets, "{'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}}", 3.2 + x,
                     -4.1 + y, -6.5 + x, 8.3 + y);
            toliman_sim *const sim = sim_with(base, place, offsets);
            image[i] = image_of(sim, i == 2 ? kinds[axis] : TOLIMAN_SIM_IMAGE_BOTH);
            toliman_sim_destroy(sim);
        }
        double error = 0, largest = 0;
        for (size_t i = 0; i < n; i++) {
            const double d = (image[0][i] - 8 * image[1][i] + 8 * image[3][i] - image[4][i]) / (12 * h);
            error = fmax(error, fabs(image[2][i] - d));
            largest = fmax(largest, fabs(d));
        }
        assert_at_most(error / largest, 1e-8);
        for (int i = 0; i < 5; i++)
            free(image[i]);
    }
    free(text), free(with_a), free(base);
}

/* Light of the frame with one quantity changed by h: the binary scene with fixed photons and positions. */
static double *frame_off_by(int32_t kind, double h) {
    const double x[2] = {3.2, -6.5}, y[2] = {-4.1, 8.3};
    const double turn = kind == TOLIMAN_SIM_IMAGE_ROLL ? h : 0, stretch = kind == TOLIMAN_SIM_IMAGE_SCALE ? 1 + h : 1;
    char place[300], pixel[80], focus[200];
    double at[4];
    for (int star = 0; star < 2; star++) {
        at[2 * star] = stretch * (x[star] * cos(turn) - y[star] * sin(turn));
        at[2 * star + 1] = stretch * (y[star] * cos(turn) + x[star] * sin(turn));
    }
    snprintf(place, sizeof place, "{'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}}", at[0], at[1], at[2],
             at[3]);
    snprintf(pixel, sizeof pixel, "'pixel_scale_arcsec': %.17g", 0.2 / stretch);
    snprintf(focus, sizeof focus, "'aberrations': {'zernike_rms_nm': {'5': 20, '4': %.17g}}, 'mask'",
             kind == TOLIMAN_SIM_IMAGE_FOCUS ? h : 0);
    char *text =
        EDITED(kBinaryScene, {"'peak_photons': 1e5", "'exposure_s': 1"}, {"'relative_flux': 3", "'photons_per_s': 3e6"},
               {"'temperature_k': 5260}", "'temperature_k': 5260}, 'photons_per_s': 1e6"},
               {"{'separation_arcsec': 4, 'position_angle_deg': 30}", place}, {"'pixel_scale_arcsec': 0.2", pixel},
               {"'mask'", focus});
    toliman_sim *const sim = sim_of(text);
    double *const image = image_of(sim, h > 0 || h < 0 ? TOLIMAN_SIM_IMAGE_BOTH : kind);
    toliman_sim_destroy(sim), free(text);
    return image;
}

/* Roll, scale and focus against five-point differences of rotated, scaled and defocused scenes. */
TEST(nuisance_images_are_exact) {
    const struct {
        int32_t kind;
        double h;
    } cases[] = {{TOLIMAN_SIM_IMAGE_ROLL, 1e-3}, {TOLIMAN_SIM_IMAGE_SCALE, 5e-4}, {TOLIMAN_SIM_IMAGE_FOCUS, 0.5}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const double h = cases[c].h;
        double *image[5], error = 0, largest = 0;
        for (int i = 0; i < 5; i++)
            image[i] = frame_off_by(cases[c].kind, (i - 2) * h);
        for (size_t i = 0; i < 64 * 64; i++) {
            const double d = (image[0][i] - 8 * image[1][i] + 8 * image[3][i] - image[4][i]) / (12 * h);
            error = fmax(error, fabs(image[2][i] - d));
            largest = fmax(largest, fabs(d));
        }
        print_message("nuisance %d: error %.2g of the largest\n", cases[c].kind, error / largest);
        assert_at_most(error / largest, 1e-7);
        for (int i = 0; i < 5; i++)
            free(image[i]);
    }
}

RUN_TESTS(NULL, NULL)
