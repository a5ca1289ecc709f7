/* Tests the linear map between angles and pixels: images against direct sums at the angle of each pixel, positions and
 * amplitudes against the formula, derivatives against differences, and refusals. */
#include "long_double_sim.h"

static const double kAnisotropy = 0.03, kShear = -0.05, kScale = 0.2;

/* kBinaryScene with a distorted detector of rows x cols and n pupil samples. */
static char *text_of(int rows, int cols, int n, const char *pixel) {
    char detector[200], samples[40];
    snprintf(detector, sizeof detector, "[%d, %d], 'pixel': '%s', 'scale_anisotropy': %g, 'shear': %g", rows, cols,
             pixel, kAnisotropy, kShear);
    snprintf(samples, sizeof samples, "'pupil_samples': %d", n);
    char *const text = replaced(kBinaryScene, "'pupil_samples': 96", samples);
    return replaced_again(text, "[64, 64]", detector);
}

/* The angle of a pixel in units of the pixel scale, by solving x = (1 + a) u, y = s u + (1 - a) v. */
static void to_angle(long double x, long double y, long double *u, long double *v) {
    *u = x / (1 + (long double)kAnisotropy);
    *v = (y - (long double)kShear * *u) / (1 - (long double)kAnisotropy);
}

/* Sums over stars, wavelengths and pupil cells at the angles of every 97th pixel. */
static void check_image(int rows, int cols, int n) {
    char *const text = text_of(rows, cols, n, "point");
    toliman_sim *const sim = sim_of(text);
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    reference r = reference_of(sim, 0.125L, 0.2L);
    const double area = 1 / ((1 + kAnisotropy) * (1 - kAnisotropy));
    for (int star = 0; star < 2; star++)
        to_angle(r.offset[2 * star], r.offset[2 * star + 1], &r.offset[2 * star], &r.offset[2 * star + 1]);
    double peak = 0;
    for (int i = 0; i < rows * cols; i++)
        peak = fmax(peak, image[i]);
    for (int pixel = 7; pixel < rows * cols; pixel += 97) {
        long double u, v, sum = 0;
        to_angle(pixel % cols - 0.5L * (cols - 1), pixel / cols - 0.5L * (rows - 1), &u, &v);
        const double at_u = (double)u, at_v = (double)v;
        add_stars(&r, &at_u, 1, &at_v, 1, &sum);
        assert_close(image[pixel], (double)(area * sum), 0, 1e-12 * peak);
    }
    release(&r);
    free(image), free(text), toliman_sim_destroy(sim);
}

TEST(images_are_sums_at_the_angles_of_pixels) {
    check_image(64, 64, 96);
    check_image(33, 40, 65);
}

/* 4 arcsec at a position angle of 30 deg, mapped to pixels. */
TEST(positions_follow_the_map) {
    char *const text = text_of(64, 64, 96, "point");
    toliman_sim *const sim = sim_of(text);
    double at[4];
    get_offsets(sim, at);
    const double u = -4 / kScale * sin(30 * M_PI / 180), v = 4 / kScale * cos(30 * M_PI / 180);
    assert_close(at[2] - at[0], (1 + kAnisotropy) * u, 1e-13, 0);
    assert_close(at[3] - at[1], kShear * u + (1 - kAnisotropy) * v, 1e-13, 0);
    assert_close(sim_info_of(sim).separation_px, hypot(at[2] - at[0], at[3] - at[1]), 1e-13, 0);
    toliman_sim_destroy(sim), free(text);
}

/* An amplitude in microarcsec is as many pixels as that angle along the binary spans, for either way to place it. */
TEST(amplitudes_follow_the_map) {
    const double u = -sin(30 * M_PI / 180), v = cos(30 * M_PI / 180),
                 px = 150e-6 / kScale * hypot((1 + kAnisotropy) * u, kShear * u + (1 - kAnisotropy) * v);
    char *text = text_of(64, 64, 96, "point");
    text = replaced_again(text, "'amplitude_px': 1e-3", "'amplitude_uas': 150");
    toliman_sim *sim = sim_of(text);
    double at[4];
    char places[160];
    get_offsets(sim, at);
    assert_close(sim_info_of(sim).amplitude_px, px, 1e-13, 0);
    assert_close(sim_info_of(sim).amplitude_uas, 150, 1e-13, 0);
    toliman_sim_destroy(sim);
    snprintf(places, sizeof places, "'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}", at[0], at[1], at[2],
             at[3]);
    text = replaced_again(text, "'separation_arcsec': 4, 'position_angle_deg': 30", places);
    sim = sim_of(text);
    assert_close(sim_info_of(sim).amplitude_px, px, 1e-12, 0);
    toliman_sim_destroy(sim), free(text);
}

enum { SIDE = 64, PIXELS = SIDE * SIDE };

static void assert_slope(const double *ahead, const double *behind, double step, double *slope) {
    double most = 0;
    for (int i = 0; i < PIXELS; i++)
        most = fmax(most, fabs(slope[i]));
    for (int i = 0; i < PIXELS; i++)
        assert_close((ahead[i] - behind[i]) / (2 * step), slope[i], 0, 1e-6 * most);
    free(slope);
}

/* Derivatives by the displacement and by a shift of both stars are per pixel, also of integrated pixels: they equal
 * differences of propagated images. */
TEST(derivatives_are_per_pixel) {
    static double image[2][PIXELS];
    const double step = 1e-3;
    double at[4];
    char *text = text_of(SIDE, SIDE, 96, "integrated");
    text = replaced_again(text, "'peak_photons': 1e5", "'exposure_s': 10");
    text = replaced_again(text, "'relative_flux': 3", "'photons_per_s': 3e7");
    text = replaced_again(text, "5260}}}", "5260}, 'photons_per_s': 1e7}}");
    toliman_sim *const sim = sim_of(text);
    get_offsets(sim, at);
    for (int side = 0; side < 2; side++)
        assert_ok(toliman_sim_propagate(sim, side ? step : -step, image[side], SIDE));
    assert_slope(image[1], image[0], step, image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION));
    for (int axis = 0; axis < 2; axis++) {
        for (int side = 0; side < 2; side++) {
            const double d = side ? step : -step, x = axis == 0 ? d : 0, y = axis == 1 ? d : 0;
            char places[160];
            snprintf(places, sizeof places, "'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}", at[0] + x,
                     at[1] + y, at[2] + x, at[3] + y);
            toliman_sim *const moved = sim_with(text, "'separation_arcsec': 4, 'position_angle_deg': 30", places);
            assert_ok(toliman_sim_get_image(moved, TOLIMAN_SIM_IMAGE_BOTH, image[side], SIDE));
            toliman_sim_destroy(moved);
        }
        assert_slope(image[1], image[0], step,
                     image_of(sim, axis == 0 ? TOLIMAN_SIM_IMAGE_SHIFT_X : TOLIMAN_SIM_IMAGE_SHIFT_Y));
    }
    toliman_sim_destroy(sim), free(text);
}

/* Zeros are square pixels, bit for bit. */
TEST(defaults_change_nothing) {
    toliman_sim *const plain = sim_of(kBinaryScene), *const named =
                                                         sim_with(kBinaryScene, "[64, 64]",
                                                                  "[64, 64], 'scale_anisotropy': 0, 'shear': 0");
    double *const a = image_of(plain, TOLIMAN_SIM_IMAGE_BOTH), *const b = image_of(named, TOLIMAN_SIM_IMAGE_BOTH);
    assert_memory_equal(a, b, 64 * 64 * sizeof *a);
    free(a), free(b), toliman_sim_destroy(plain), toliman_sim_destroy(named);
}

TEST(refusals) {
    const refusal cases[] = {
        {"'shape'", "'scale_anisotropy': 0.2, 'shape'", "detector.scale_anisotropy"},
        {"'shape'", "'shear': -1e300, 'shape'", "detector.shear"},
        {"'shape'", "'shear': '0', 'shape'", "detector.shear"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    char *const text = text_of(64, 64, 96, "point");
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim), TOLIMAN_E_UNSUPPORTED,
                   "detector");
    assert_null(sim);
    free(text);
}

RUN_TESTS(NULL, NULL)
