/* Tests windows around an order of a grating: against sums of scenes of one wavelength each, at displaced places;
 * frames of moving stars and of other optics, the fit, a warning, and refusals. */
#include <stdarg.h>

#include <toliman/fit.h>

#include "images.h"
#include "scene_text.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, COUNT = 5 };

static const double kWavelengths[COUNT] = {560, 570.5, 580, 593, 600}, kWeights[COUNT] = {1, 2, 0.5, 1.5, 3},
                    kTotal = 8, kStars[4] = {-4.5, -8.2, 5.1, 9.3};
static const char *const kWindow =
    "'sidelobe': {'period_um': 1500, 'angle_deg': 35, 'centre_nm': 575, 'efficiency': 0.25}, ";

static void put(char *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(char *text, const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsprintf(text + strlen(text), format, values);
    va_end(values);
}

/* Two stars of `photons` and half as many in these wavelengths, displaced by (x, y) px; `window` in the detector. */
static toliman_sim *stars_at(const double *wavelengths, const double *weights, int count, double photons, double x,
                             double y, double scale, const char *window, const char *extra) {
    char text[3000] = "{'schema': 'toliman-scene/1', 'accuracy': 1e-12, 'telescope': {'aperture_m': 0.125,"
                      " 'pupil_samples': 96, 'mask': {'kind': 'spiral', 'edges': 'area', 'opd_nm': 297.5, 'terms':"
                      " [{'a': 0.819, 'f': 2.918, 'm': -7, 'p': 4.874}, {'a': 0.93, 'f': 1.829, 'm': 5}]}}, 'stars': {";
    for (int star = 0; star < 2; star++) {
        put(text, "%s'%c': {'spectrum': {'kind': 'lines', 'wavelength_nm': [", star == 0 ? "" : ", ", 'A' + star);
        for (int i = 0; i < count; i++)
            put(text, "%s%.17g", i == 0 ? "" : ", ", wavelengths[i]);
        put(text, "], 'weight': [");
        for (int i = 0; i < count; i++)
            put(text, "%s%.17g", i == 0 ? "" : ", ", weights[i]);
        put(text, "]}, 'photons_per_s': %.17g}", photons / (1 + star));
    }
    put(text, "}, 'binary': {'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}}, ", kStars[0] * scale + x,
        kStars[1] * scale + y, kStars[2] * scale + x, kStars[3] * scale + y);
    put(text,
        "'cadence': {'frames': 100, 'exposure_s': 1}, 'detector': {%s'shape': [64, 64], 'pixel': 'integrated',"
        " 'scale_anisotropy': 0.01, 'shear': 0.02, 'pixel_scale_arcsec': %.17g}%s}",
        window, 0.2 / scale, extra);
    char *const scene = quoted(text);
    toliman_sim *const sim = sim_of(scene);
    free(scene);
    return sim;
}

static const char *with_shape(const char *window) {
    static char text[200];
    snprintf(text, sizeof text, "%s'shape'", window);
    return text;
}

static toliman_sim *window_with(const char *extra) {
    return stars_at(kWavelengths, kWeights, COUNT, 1e7, 0, 0, 1, kWindow, extra);
}

/* The sum of scenes of one wavelength, each displaced; stars at (x, y) px from theirs, pixels smaller by `scale`. An
 * angle (u, v) in units of the pixel scale is at the pixels (1.01 u, 0.02 u + 0.99 v). */
static void sum_of_lines(double x, double y, double scale, double *sum) {
    static double image[PIXELS];
    const double pi = acos(-1), angle = 35 * pi / 180, pixel = 0.2 / scale * pi / 648000;
    memset(sum, 0, sizeof image);
    for (int i = 0; i < COUNT; i++) {
        const double order = (kWavelengths[i] - 575) * 1e-9 / 1500e-6 / pixel;
        const double u = order * cos(angle), v = order * sin(angle);
        toliman_sim *const sim = stars_at(&kWavelengths[i], (const double[]){1}, 1, 0.25e7 * kWeights[i] / kTotal,
                                          x + 1.01 * u, y + 0.02 * u + 0.99 * v, scale, "", "");
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
        for (int k = 0; k < PIXELS; k++)
            sum[k] += image[k];
        toliman_sim_destroy(sim);
    }
}

TEST(a_window_is_a_sum_of_displaced_wavelengths) {
    static double image[PIXELS], expected[PIXELS];
    toliman_sim *const sim = window_with("");
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
    sum_of_lines(0, 0, 1, expected);
    assert_at_most(peak_difference(image, expected, PIXELS), 1e-10);
    toliman_sim_destroy(sim);
}

/* Frames of moving stars, from the atlas, and of stretched pixels, propagated. */
TEST(frames_follow) {
    static double image[PIXELS], expected[PIXELS];
    const struct {
        const char *systematics;
        double x, scale, error;
    } cases[] = {{"'pointing_rms_px': {'rms': 0, 'drift_per_day': 0.02}", 1.8, 1, 1e-10},
                 {"'scale_rms': {'rms': 0, 'drift_per_day': 1e-5}", 0, 1.0009, 1e-10}};
    for (size_t i = 0; i < 2; i++) {
        char extra[200];
        snprintf(extra, sizeof extra, ", 'systematics': {%s}", cases[i].systematics);
        toliman_sim *const sim = window_with(extra);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 90, 1, image));
        sum_of_lines(cases[i].x, cases[i].x, cases[i].scale, expected);
        assert_at_most(peak_difference(image, expected, PIXELS), cases[i].error);
        toliman_sim_destroy(sim);
    }
}

/* The model of a fit has the window, too. */
TEST(the_fit_finds_the_stars) {
    static double image[PIXELS], values[8];
    toliman_sim *const sim = window_with("");
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    sum_of_lines(0.02, -0.03, 1, image);
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(image), 1, NULL, &result, values, NULL));
    assert_close(values[2], 0.02, 0, 1e-8);
    assert_close(values[3], -0.03, 0, 1e-8);
    toliman_fit_destroy(fit), toliman_sim_destroy(sim);
}

static char heard[1000];

static void record_log(int32_t level, const char *text, void *user_data) {
    (void)level;
    (void)user_data;
    strncat(heard, text, sizeof heard - strlen(heard) - 1);
}

/* 12.5 nm are displaced by more than lambda/D, unless the period is long: 550 nm times 0.0015 or 0.015 / 0.125. */
TEST(separate_images_are_warned_of) {
    const char *const windows[] = {"'sidelobe': {'period_um': 1500, 'angle_deg': 35, 'centre_nm': 575}, 'shape'",
                                   "'sidelobe': {'period_um': 15000, 'angle_deg': 35, 'centre_nm': 575}, 'shape'"};
    for (int i = 0; i < 2; i++) {
        char *const text = replaced(kBinaryScene, "'shape'", windows[i]);
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.log = record_log;
        heard[0] = '\0';
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
        assert_true((strstr(heard, "band.step_nm = 12.5: must be at most 6.6 nm") != NULL) == (i == 0));
        toliman_sim_destroy(sim), free(text);
    }
}

/* 14 px per 100 nm: from the band around 580 nm, a window of 64 px around 100 nm has no light. */
TEST(windows_without_light_are_warned_of) {
    const char *const centres[] = {"575", "100"};
    for (int i = 0; i < 2; i++) {
        char window[120];
        snprintf(window, sizeof window, "'sidelobe': {'period_um': 7000, 'angle_deg': 0, 'centre_nm': %s}, 'shape'",
                 centres[i]);
        char *const text = replaced(kBinaryScene, "'shape'", window);
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.log = record_log;
        heard[0] = '\0';
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
        for (int star = 0; star < 2; star++) {
            char words[40];
            snprintf(words, sizeof words, "star %c is at (", 'A' + star);
            assert_true((strstr(heard, words) != NULL) == (i == 1));
        }
        assert_true((strstr(heard, " px in the order of detector.sidelobe, outside the frame") != NULL) == (i == 1));
        toliman_sim_destroy(sim), free(text);
    }
}

/* Counts are those of a part of the light; a peak is that of the frame, so that nothing changes. */
TEST(efficiency_scales_counts) {
    static double image[PIXELS], expected[PIXELS];
    static const char *const whole = "'sidelobe': {'period_um': 1500, 'angle_deg': 35, 'centre_nm': 575}, ";
    for (int peak = 0; peak < 2; peak++) {
        for (int part = 0; part < 2; part++) {
            toliman_sim *const sim =
                peak ? sim_with(kBinaryScene, "'shape'", part ? with_shape(kWindow) : with_shape(whole))
                     : stars_at(kWavelengths, kWeights, COUNT, 1e7, 0, 0, 1, part ? kWindow : whole, "");
            assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, part ? image : expected, SIDE));
            toliman_sim_destroy(sim);
        }
        for (int k = 0; k < PIXELS; k++)
            expected[k] *= peak ? 1 : 0.25;
        assert_at_most(peak_difference(image, expected, PIXELS), 1e-12);
    }
}

TEST(refusals) {
    const refusal cases[] = {
        {"'shape'", "'sidelobe': {}, 'shape'", "detector.sidelobe.period_um"},
        {"'shape'", "'sidelobe': {'period_um': 0, 'angle_deg': 35, 'centre_nm': 575}, 'shape'",
         "detector.sidelobe.period_um"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 35, 'centre_nm': 0}, 'shape'",
         "detector.sidelobe.centre_nm"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 361, 'centre_nm': 575}, 'shape'",
         "detector.sidelobe.angle_deg"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 35, 'centre_nm': 575, 'efficiency': 0}, 'shape'",
         "detector.sidelobe.efficiency"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 35, 'centre_nm': 575, 'order': 0}, 'shape'",
         "detector.sidelobe.order"}, /* the first order alone */
        {"'shape'", "'sidelobe': {'angle_deg': 35, 'centre_nm': 575}, 'shape'", "detector.sidelobe.period_um"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'centre_nm': 575}, 'shape'", "detector.sidelobe.angle_deg"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 35}, 'shape'", "detector.sidelobe.centre_nm"},
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 35, 'centre_nm': 575, 'efficiency': 1.1}, 'shape'",
         "detector.sidelobe.efficiency"},
        /* the light is 400 px away, beyond the period of the samples */
        {"'shape'", "'sidelobe': {'period_um': 300, 'angle_deg': 45, 'centre_nm': 300}, 'shape'",
         "telescope.pupil_samples"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
    char *const text = replaced(kBinaryScene, "'shape'",
                                "'sidelobe': {'period_um': 3000, 'angle_deg': 35, 'centre_nm': 575}, 'shape'");
    const toliman_sim_options options = {.struct_size = sizeof options, .engine = TOLIMAN_SIM_ENGINE_PADDED_FFT};
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim), TOLIMAN_E_UNSUPPORTED,
                   "detector.sidelobe");
    free(text);
}

RUN_TESTS(NULL, NULL)
