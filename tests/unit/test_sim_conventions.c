/* Tests the conventions of sim.h: signs, centre, angles, photons and the Airy pattern. */
#include <stdio.h>

#include "offsets.h"
#include "scene_text.h"

/* Fraction of the light of a clear round aperture in a pixel r px from the star, per steradian times the pixel area: pi
 * D^2/(4 lambda^2) (2 J1(v)/v)^2, v = pi D r/lambda. */
static double airy(double aperture_m, double pixel_rad, double wavelength_m, double r) {
    const double v = M_PI * aperture_m * r * pixel_rad / wavelength_m;
    const double pattern = v > 0 ? 2 * j1(v) / v : 1;
    const double scale = aperture_m * pixel_rad / wavelength_m;
    return M_PI / 4 * scale * scale * pattern * pattern;
}

static double airy_error(double pixel_arcsec, double ox, double oy) {
    char scale[60], place[60];
    snprintf(scale, sizeof scale, "'pixel_scale_arcsec': %.17g", pixel_arcsec);
    snprintf(place, sizeof place, "{'A': [%.17g, %.17g]}", ox, oy);
    char *text = EDITED(kSingleScene, {"'pixel_scale_arcsec': 0.2", scale}, {"{'A': [0, 0]}", place},
                        {"'pupil_samples': 64", "'pupil_samples': 256"}, {"[32, 32]", "[128, 128]"},
                        {"'peak_photons': 1e6", "'exposure_s': 1"}, {"5790}}", "5790}, 'photons_per_s': 1e6}"});
    toliman_sim *const sim = sim_of(text);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    const double pixel_rad = pixel_arcsec * M_PI / 648000;
    double error = 0;
    for (int row = 0; row < 128; row++)
        for (int col = 0; col < 128; col++) {
            const double expected = 1e6 * airy(0.125, pixel_rad, 550e-9, hypot(col - 63.5 - ox, row - 63.5 - oy));
            error = fmax(error, fabs(image[row * 128 + col] - expected));
        }
    free(image), toliman_sim_destroy(sim), free(text);
    return error / (1e6 * airy(0.125, pixel_rad, 550e-9, 0));
}

TEST(airy_pattern) {
    const double scales[] = {0.05, 0.2, 0.375};
    for (int i = 0; i < 3; i++) {
        const double centred = airy_error(scales[i], 0, 0), aside = airy_error(scales[i], 7.3, -11.9);
        print_message("Airy pattern at %g arcsec/px: error/peak %.2g, off the axis %.2g\n", scales[i], centred, aside);
        assert_at_most(centred, 1e-5);
        assert_at_most(aside, 1e-5);
    }
}

static void brightest(const double *image, int n, int *row, int *col) {
    int best = 0;
    for (int i = 1; i < n * n; i++)
        best = image[i] > image[best] ? i : best;
    *row = best / n;
    *col = best % n;
}

/* A star at (+x, +y) is at higher column and row; the axis is the corner between the four central pixels. */
TEST(offsets_have_signs) {
    const struct {
        const char *offset;
        int row, col;
    } cases[] = {{"[5.5, 3.5]", 19, 21}, {"[-5.5, 3.5]", 19, 10}, {"[0.5, -10.5]", 5, 16}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_sim *const sim = sim_with(kSingleScene, "[0, 0]", cases[i].offset);
        double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
        int row, col;
        brightest(image, 32, &row, &col);
        assert_int_equal(row, cases[i].row);
        assert_int_equal(col, cases[i].col);
        free(image), toliman_sim_destroy(sim);
    }
    toliman_sim *const sim = sim_of(kSingleScene); /* on the axis: symmetric under rotation by 180 degrees */
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    for (int i = 0; i < 512; i++)
        assert_close(image[i], image[1023 - i], 0, 1e-9 * 1e6);
    assert_close(image[15 * 32 + 15], 1e6, 1e-12, 0);
    assert_close(image[16 * 32 + 15], 1e6, 1e-12, 0);
    free(image), toliman_sim_destroy(sim);
}

static void offsets_with(const char *place, const char *extra_detector, double offset[4]) {
    char *text = EDITED(kBinaryScene, {"{'separation_arcsec': 4, 'position_angle_deg': 30}", place},
                        {"[64, 64]", extra_detector});
    toliman_sim *const sim = sim_of(text);
    get_offsets(sim, offset);
    assert_close(sim_info_of(sim).separation_px, hypot(offset[2] - offset[0], offset[3] - offset[1]), 1e-14, 0);
    assert_close(sim_info_of(sim).flux_ratio, 3, 1e-14, 0);
    toliman_sim_destroy(sim), free(text);
}

/* Position angle 0 is +y, 90 is -x; the barycentre of the light is on the axis unless a star is. */
TEST(angles_have_signs) {
    double o[4];
    offsets_with("{'separation_arcsec': 4, 'position_angle_deg': 0}", "[64, 64]", o);
    assert_close(o[2] - o[0], 0, 0, 1e-13);
    assert_close(o[3] - o[1], 20, 1e-14, 0);
    assert_close(3 * o[1] + o[3], 0, 0, 1e-13);
    offsets_with("{'separation_arcsec': 4, 'position_angle_deg': 90}", "[64, 64]", o);
    assert_close(o[2] - o[0], -20, 1e-14, 0);
    assert_close(o[3] - o[1], 0, 0, 1e-13);
    offsets_with("{'separation_arcsec': 4, 'position_angle_deg': 90, 'centre': 'A'}", "[64, 64]", o);
    assert_close(o[0], 0, 0, 1e-13);
    assert_close(o[2], -20, 1e-14, 0);
    offsets_with("{'separation_arcsec': 4, 'position_angle_deg': 90, 'centre': 'B'}", "[64, 64]", o);
    assert_close(o[0], 20, 1e-14, 0);
    /* With the rows' +y axis at position angle 90, a star at that angle is at +y. */
    offsets_with("{'separation_arcsec': 4, 'position_angle_deg': 90}", "[64, 64], 'rotation_deg': 90", o);
    assert_close(o[3] - o[1], 20, 1e-14, 0);
}

/* A positive displacement moves star A away from B, or B away from A: by whole pixels, so that the image shows it. */
TEST(displacement_lengthens_the_separation) {
    const char *const place = "{'offsets_px': {'A': [-8.5, 0.5], 'B': [11.5, 0.5]}}";
    for (int star = 0; star < 2; star++) {
        char *text = EDITED(kBinaryScene, {"{'separation_arcsec': 4, 'position_angle_deg': 30}", place},
                            {"'star': 'B'", star == 0 ? "'star': 'A'" : "'star': 'B'"});
        toliman_sim *const sim = sim_of(text);
        double *const moving = image_of(sim, star == 0 ? TOLIMAN_SIM_IMAGE_STAR_A : TOLIMAN_SIM_IMAGE_STAR_B);
        double *const still = image_of(sim, star == 0 ? TOLIMAN_SIM_IMAGE_STAR_B : TOLIMAN_SIM_IMAGE_STAR_A);
        double image[64 * 64];
        assert_ok(toliman_sim_propagate(sim, 3, image, 64));
        const int shift = star == 0 ? -3 : 3;
        for (int row = 0; row < 64; row++)
            for (int col = 3; col < 61; col++)
                assert_close(image[row * 64 + col] - still[row * 64 + col], moving[row * 64 + col - shift], 0, 1e-7);
        free(moving), free(still), toliman_sim_destroy(sim), free(text);
    }
}

/* Nearly all light of a star falls in a large frame, with any mask: the sum approaches the star's photons. */
TEST(energy_is_conserved) {
    char *text = EDITED(kSingleScene, {"[32, 32]", "[256, 256]"}, {"'pupil_samples': 64", "'pupil_samples': 128"},
                        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.4"});
    toliman_sim *const sim = sim_of(text);
    double wavelength, photons, none;
    assert_ok(toliman_sim_get_spectrum(sim, 1, &wavelength, &photons, &none, NULL));
    assert_close(wavelength, 550e-9, 1e-15, 0);
    assert_close(none, 0, 0, 0);
    /* Airy: 1 - J0^2 - J1^2 of the light within a radius, here 51 arcsec. */
    const double v = M_PI * 0.125 * 128 * 0.4 * M_PI / 648000 / 550e-9;
    assert_close(sim_info_of(sim).total_photons / photons, 1 - j0(v) * j0(v) - j1(v) * j1(v), 2e-3, 0);
    assert_true(sim_info_of(sim).total_photons < photons);
    toliman_sim_destroy(sim), free(text);
}

/* Photons are counted before the frame is cropped: a smaller frame has the same pixels and less light. */
TEST(cropping_removes_light) {
    char *whole = EDITED(kBinaryScene, {"'relative_flux': 3", "'photons_per_s': 3e4"},
                         {"5260}}", "5260}, 'photons_per_s': 1e4}"}, {"'peak_photons': 1e5", "'exposure_s': 100"});
    toliman_sim *const large = sim_of(whole), *const small = sim_with(whole, "[64, 64]", "[32, 32]");
    double *const of_large = image_of(large, TOLIMAN_SIM_IMAGE_BOTH), *const of_small =
                                                                          image_of(small, TOLIMAN_SIM_IMAGE_BOTH);
    for (int row = 0; row < 32; row++)
        for (int col = 0; col < 32; col++)
            assert_close(of_small[row * 32 + col], of_large[(row + 16) * 64 + col + 16], 1e-9, 1e-9);
    double wavelength[5], a[5], b[5], photons = 0;
    assert_ok(toliman_sim_get_spectrum(small, 5, wavelength, a, b, NULL));
    for (int i = 0; i < 5; i++)
        photons += a[i] + b[i];
    assert_close(photons, 4e4 * 100, 1e-14, 0);
    assert_true(sim_info_of(small).total_photons < sim_info_of(large).total_photons);
    assert_true(sim_info_of(large).total_photons < photons);
    free(of_large), free(of_small), toliman_sim_destroy(large), toliman_sim_destroy(small), free(whole);
}

/* Uniform steps with half weights at the ends, photons of a black body, and the flux ratio over the band. */
TEST(spectrum_is_a_trapezium) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    double wavelength[5], a[5], b[5];
    assert_ok(toliman_sim_get_spectrum(sim, 5, wavelength, a, b, NULL));
    for (int i = 0; i < 5; i++) {
        assert_close(wavelength[i], (550 + 12.5 * i) * 1e-9, 1e-15, 0);
        const double hc_k = 6.62607015e-34 * 299792458.0 / 1.380649e-23, end = i == 0 || i == 4 ? 0.5 : 1;
        const double expected = pow(wavelength[i] / wavelength[2], -4) * expm1(hc_k / (wavelength[2] * 5790)) /
                                expm1(hc_k / (wavelength[i] * 5790));
        assert_close(a[i] / a[2], end * expected, 1e-13, 0);
    }
    assert_invalid(toliman_sim_get_spectrum(sim, 4, wavelength, a, b, NULL), "count");
    toliman_sim_destroy(sim);
}

/* Lines are sampled exactly; together with a band, the samples are those of both. */
TEST(lines_are_exact) {
    char *text = replaced(kBinaryScene, "{'kind': 'blackbody', 'temperature_k': 5260}",
                          "{'kind': 'lines', 'wavelength_nm': [589.6, 575, 589.0], 'weight': [1, 3, 2]}");
    toliman_sim *const sim = sim_of(text);
    assert_int_equal(sim_info_of(sim).wavelengths, 7);
    double wavelength[7], a[7], b[7];
    assert_ok(toliman_sim_get_spectrum(sim, 7, wavelength, a, b, NULL));
    assert_close(wavelength[3], 587.5e-9, 1e-15, 0);
    assert_close(wavelength[4], 589e-9, 1e-15, 0);
    assert_close(a[4], 0, 0, 0);
    assert_close(b[4] / b[5], 2, 1e-14, 0);
    assert_close(b[2] / b[5], 3, 1e-14, 0);
    assert_close(b[3], 0, 0, 0);
    toliman_sim_destroy(sim), free(text);
}

/* Grey edges: the sum of the amplitudes is the open area. The first strut points to +x; the opposite side of the pupil
 * is open. */
TEST(pupil_matches_the_scene) {
    enum { N = 96 };
    static double amplitude[N * N], opd[N * N];
    toliman_sim *const sim = sim_with(kBinaryScene, "'secondary_m': 0.01875",
                                      "'secondary_m': 0.032, 'struts': {'count': 3, 'width_m': 0.002, 'angle_deg': 0}");
    assert_ok(toliman_sim_get_pupil(sim, amplitude, opd));
    const double cell = 0.125 / N, outer = 0.0625, inner = 0.016;
    double sum = 0, struts = 0;
    for (int i = 0; i < N * N; i++) {
        assert_true(amplitude[i] >= 0 && amplitude[i] <= 1);
        sum += amplitude[i];
    }
    for (int i = 0; i < 1000; i++) { /* length of a strut over its width */
        const double t = 0.001 * ((i + 0.5) / 500 - 1);
        struts += 3 * 2e-6 * (sqrt(outer * outer - t * t) - sqrt(inner * inner - t * t));
    }
    assert_close(sum * cell * cell, M_PI * (outer * outer - inner * inner) - struts, 3e-6, 0);
    const int along = N / 2 - 1, towards = N / 2 + 30, opposite = N / 2 - 31;
    assert_at_most(amplitude[along * N + towards], 1 - 0.001 / cell + 0.05);
    assert_close(amplitude[along * N + opposite], 1, 0, 0);
    assert_close(amplitude[0], 0, 0, 0);
    for (int row = 0; row < N; row++)
        for (int col = 0; col < N; col++) {
            const double x = (col - 47.5) * cell / outer, y = (row - 47.5) * cell / outer, r = hypot(x, y);
            const double g = 0.819 * cos(2 * M_PI * 2.918 * r - 7 * atan2(y, x) + 4.874) +
                             0.93 * cos(2 * M_PI * 1.829 * r + 5 * atan2(y, x));
            assert_close(opd[row * N + col], g > 0 ? 297.5e-9 : 0, 1e-15, 0);
        }
    toliman_sim_destroy(sim);
}

TEST(times_and_displacements) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    double times[3], displacements[3];
    assert_ok(toliman_sim_get_series(sim, 97, 3, times, displacements));
    for (int i = 0; i < 3; i++) {
        assert_close(times[i], 2 * (97 + i), 0, 0);
        assert_close(displacements[i], 1e-3 * sin(2 * M_PI * 2 * (97 + i) / 40), 0, 1e-16);
    }
    assert_close(sim_info_of(sim).max_displacement_px, 1e-3, 1e-12, 0);
    assert_close(sim_info_of(sim).min_displacement_px, -1e-3, 1e-12, 0);
    assert_refused(toliman_sim_get_series(sim, 98, 3, times, NULL), TOLIMAN_E_RANGE, "first");
    assert_refused(toliman_sim_get_series(sim, -1, 1, times, NULL), TOLIMAN_E_RANGE, "first");
    toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
