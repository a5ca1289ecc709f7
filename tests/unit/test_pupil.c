/* Tests the effect of aberrations, an amplitude file and a stepped mirror on the pupil and the image. */
#include <complex.h>

#include "scene_files.h"

static const double kAperture = 0.125, kPixel = 0.2 * M_PI / 648000, kWavelength = 550e-9;

enum { N = 64, SIDE = 32, PIXELS = SIDE * SIDE };

/* The single star, 1e6 photons at the detector, with `telescope` added to its telescope, at (ox, oy) px. */
static toliman_sim *star_with(const char *telescope, double ox, double oy) {
    char place[60], optics[400];
    snprintf(place, sizeof place, "'A': [%.17g, %.17g]", ox, oy);
    snprintf(optics, sizeof optics, "%s'aperture_m'", telescope);
    char *text = EDITED(kSingleScene, {"'A': [0, 0]", place}, {"'aperture_m'", optics},
                        {"'peak_photons': 1e6", "'exposure_s': 1"}, {"5790}}", "5790}, 'photons_per_s': 1e6}"});
    toliman_sim *sim = NULL;
    assert_ok(create_in_folder(text, &sim));
    free(text);
    return sim;
}

static double *image_with(const char *telescope, double ox, double oy) {
    toliman_sim *const sim = star_with(telescope, ox, oy);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    toliman_sim_destroy(sim);
    return image;
}

static double *image_with_zernike(int noll, double rms_nm) {
    char telescope[100];
    snprintf(telescope, sizeof telescope, "'aberrations': {'zernike_rms_nm': {'%d': %.17g}}, ", noll, rms_nm);
    return image_with(telescope, 0, 0);
}

static void assert_same(double *image, double *expected, double rtol_of_peak) {
    double peak = 0;
    for (int i = 0; i < PIXELS; i++)
        peak = fmax(peak, expected[i]);
    for (int i = 0; i < PIXELS; i++)
        assert_close(image[i], expected[i], 0, rtol_of_peak * peak);
    free(image), free(expected);
}

/* Noll 2 of rms a is OPD = 2 a x/(D/2) = (4 a/D) x; a star ox px to higher columns has OPD = ox p x. So ox = 4 a/(D p):
 * positive a moves to higher columns. Noll 3 is the same for rows. */
TEST(tilt_moves_the_image) {
    const double rms_nm = 90.9, px = 4 * rms_nm * 1e-9 / (kAperture * kPixel);
    assert_close(px, 3, 1e-3, 0);
    assert_same(image_with_zernike(2, rms_nm), image_with("", px, 0), 1e-12);
    assert_same(image_with_zernike(2, -rms_nm), image_with("", -px, 0), 1e-12);
    assert_same(image_with_zernike(3, rms_nm), image_with("", 0, px), 1e-12);
    double *const moved = image_with_zernike(3, rms_nm), *const still = image_with("", 0, 0);
    double centre = 0, light = 0;
    for (int row = 3; row < SIDE - 3; row++)
        for (int col = 0; col < SIDE; col++) {
            light += still[row * SIDE + col];
            centre += (moved[(row + 3) * SIDE + col] - still[row * SIDE + col]);
        }
    assert_close(centre / light, 0, 0, 1e-3); /* up by three rows */
    free(moved), free(still);
}

/* A defocus of either sign gives the same symmetric image. With u = r^2 the axis keeps (sin x/x)^2 of its light, x = 2
 * pi sqrt(3) a/lambda: OPD = sqrt(3) a (2u - 1). */
TEST(defocus_is_symmetric) {
    const double rms_nm = 60, x = 2 * M_PI * sqrt(3) * rms_nm * 1e-9 / kWavelength;
    assert_same(image_with_zernike(4, rms_nm), image_with_zernike(4, -rms_nm), 1e-13);
    double *const image = image_with_zernike(4, rms_nm);
    for (int row = 0; row < SIDE; row++)
        for (int col = 0; col < SIDE; col++) {
            assert_close(image[row * SIDE + col], image[col * SIDE + row], 1e-12, 1e-9);
            assert_close(image[row * SIDE + col], image[(SIDE - 1 - row) * SIDE + col], 1e-12, 1e-9);
        }
    free(image);
    const char *const defocus = "'aberrations': {'zernike_rms_nm': {'4': 60}}, ";
    double *const sharp = image_with("", 0.5, 0.5), *const blurred = image_with(defocus, 0.5, 0.5);
    const int axis = SIDE / 2 * SIDE + SIDE / 2;
    assert_close(blurred[axis] / sharp[axis], sin(x) / x * sin(x) / x, 1e-3, 0);
    free(sharp), free(blurred);
}

/* A weak aberration reduces the peak by the fraction (2 pi a/lambda)^2, whichever Zernike term it is (Marechal): the
 * coefficients are rms values. */
TEST(coefficients_are_rms) {
    double *const sharp = image_with("", 0.5, 0.5);
    const int axis = SIDE / 2 * SIDE + SIDE / 2;
    for (int noll = 4; noll <= 21; noll++) {
        char telescope[100];
        snprintf(telescope, sizeof telescope, "'aberrations': {'zernike_rms_nm': {'%d': 4}}, ", noll);
        double *const image = image_with(telescope, 0.5, 0.5);
        const double phase = 2 * M_PI * 4e-9 / kWavelength;
        assert_close(1 - image[axis] / sharp[axis], phase * phase, 0.03, 0);
        free(image);
    }
    free(sharp);
}

static void write_map(const char *name, double (*of)(double x, double y)) {
    static double map[N * N];
    for (int row = 0; row < N; row++)
        for (int col = 0; col < N; col++)
            map[row * N + col] = of((2 * col - (N - 1)) / (double)N, (2 * row - (N - 1)) / (double)N);
    char shape[20];
    snprintf(shape, sizeof shape, "(%d, %d)", N, N);
    write_npy(name, "<f8", shape, map, sizeof map);
}

static double half(double x, double y) {
    (void)x, (void)y;
    return 0.5;
}

static double soft(double x, double y) {
    const double u = 1 - x * x - y * y;
    return u > 0 ? u * (1 - 0.3 * x) / 1.3 : 0;
}

static double surface_height(double x, double y) {
    return 40e-9 * sin(7 * x + 1) * cos(5 * y) + 30e-9 * x * x * x;
}

static const char *const kAmplitude = "'amplitude': {'file': 'amplitude.npy'}, ";

/* Intensity is a fraction of the light that passes the pupil, so a uniform loss changes only the pupil. */
TEST(even_loss_changes_nothing) {
    static double open[N * N], grey[N * N];
    write_map("amplitude.npy", half);
    toliman_sim *const lossy = star_with(kAmplitude, 1, 2), *const clear = star_with("", 1, 2);
    assert_ok(toliman_sim_get_pupil(clear, open, NULL));
    assert_ok(toliman_sim_get_pupil(lossy, grey, NULL));
    for (int i = 0; i < N * N; i++)
        assert_close(grey[i], 0.5 * open[i], 0, 0);
    assert_same(image_of(lossy, TOLIMAN_SIM_IMAGE_BOTH), image_of(clear, TOLIMAN_SIM_IMAGE_BOTH), 1e-14);
    assert_close(sim_bounds_of(lossy).crb_px, sim_bounds_of(clear).crb_px, 1e-12, 0);
    toliman_sim_destroy(lossy), toliman_sim_destroy(clear);
}

/* A soft pupil edge has no far wings, so nearly all light falls in the frame and the intensities sum to 1. */
TEST(light_sums_to_one) {
    write_map("amplitude.npy", soft);
    toliman_sim *const sim = star_with(kAmplitude, 0, 0), *const hard = star_with("", 0, 0);
    assert_close(sim_info_of(sim).total_photons, 1e6, 3e-3, 0);
    assert_true(sim_info_of(hard).total_photons < 0.97e6); /* the wings of a hard edge extend further */
    toliman_sim_destroy(sim), toliman_sim_destroy(hard);
}

/* The formula of sim.h, summed directly in long double: mask, Zernike polynomials and both files together. */
TEST(everything_adds) {
    static double amplitude[N * N], opd[N * N], clear[N * N];
    write_map("amplitude.npy", soft);
    write_map("surface.npy", surface_height);
    const char *const optics =
        "'amplitude': {'file': 'amplitude.npy'},"
        " 'mask': {'kind': 'spiral', 'edges': 'cell', 'height_nm': 80, 'terms': [{'a': 1, 'm': 1}]},"
        " 'aberrations': {'zernike_rms_nm': {'6': 25, '9': -10, '11': 5},"
        " 'opd_file': 'surface.npy'}, ";
    toliman_sim *const sim = star_with(optics, -2.5, 1.25), *const plain = star_with("", 0, 0);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    double sum = 0;
    assert_ok(toliman_sim_get_pupil(plain, clear, NULL));
    assert_ok(toliman_sim_get_pupil(sim, amplitude, opd));
    for (int row = 0; row < N; row++)
        for (int col = 0; col < N; col++) {
            const int i = row * N + col;
            const double x = (2 * col - (N - 1)) / (double)N, y = (2 * row - (N - 1)) / (double)N, r2 = x * x + y * y;
            const double mask = x > 0 ? 160e-9 : 0; /* 1 where cos(theta) > 0; the OPD is twice the height */
            const double zernikes = 25e-9 * sqrt(6) * (x * x - y * y) - 10e-9 * sqrt(8) * (3 * x * x - y * y) * y +
                                    5e-9 * sqrt(5) * (6 * r2 * r2 - 6 * r2 + 1);
            assert_close(amplitude[i], clear[i] * soft(x, y), 1e-15, 1e-16);
            assert_close(opd[i], mask + (amplitude[i] > 0 ? zernikes : 0) + surface_height(x, y), 0, 1e-21);
            sum += amplitude[i] * soft(x, y);
        }
    const double scale = kAperture / N * kPixel / kWavelength;
    for (int pixel = 5; pixel < PIXELS; pixel += 97) {
        const long double u = pixel % SIDE - 0.5L * (SIDE - 1), v = pixel / SIDE - 0.5L * (SIDE - 1);
        long double complex field = 0;
        for (int i = 0; i < N * N; i++) {
            const long double x = (i % N) - 0.5L * (N - 1), y = (i / N) - 0.5L * (N - 1);
            const long double cycles = opd[i] / (long double)kWavelength - scale * (x * (u + 2.5L) + y * (v - 1.25L));
            field += amplitude[i] * cexpl(2 * acosl(-1) * I * cycles);
        }
        const double expected =
            1e6 * scale * scale / sum * (double)(creall(field) * creall(field) + cimagl(field) * cimagl(field));
        assert_close(image[pixel], expected, 0, 1e-10 * 1e6 * scale * scale * sum);
    }
    free(image), toliman_sim_destroy(sim), toliman_sim_destroy(plain);
}

/* A stepped mirror of height h equals a mask of OPD 2 h. */
TEST(mirror_heights_count_twice) {
    const char *const mask = "'mask': {'kind': 'spiral', 'edges': 'cell', '%s': %s, 'terms': [{'a': 1, "
                             "'f': 3, 'm': 2}]}, ";
    char step[200], mirror[200];
    snprintf(step, sizeof step, mask, "opd_nm", "275");
    snprintf(mirror, sizeof mirror, mask, "height_nm", "137.5");
    assert_same(image_with(mirror, 0, 0), image_with(step, 0, 0), 1e-14);
}

RUN_TESTS(make_folder, remove_folder)
