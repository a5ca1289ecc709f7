/* Scenes and frames for the tests of calibrations: 40 x 40 px, 32 pupil cells, three wavelengths, 1e9 photons per
 * frame. The mask has few edges, whose cells take most of the time of such a small calibration. */
#ifndef TOLIMAN_TESTS_CALIBRATE_SCENE_H
#define TOLIMAN_TESTS_CALIBRATE_SCENE_H

#include <toliman/calibrate.h>

#include "images.h"
#include "scene_text.h"

enum { CALIBRATE_SIDE = 40, CALIBRATE_PIXELS = CALIBRATE_SIDE * CALIBRATE_SIDE, CALIBRATE_FRAMES = 4 };

/* What a scene has that another one does not. Members that are NULL are empty. */
typedef struct {
    const char *telescope, *mask, *systematics; /* further keys, each after a comma */
    double scale;                               /* relative */
    double temperature_a;                       /* K; 0 = 5790 */
    int no_struts;
} calibrate_change;

#define CALIBRATE_POINTING "\"pointing_rms_px\": 0.3, \"flux_rms\": 1e-3"

/* The caller frees the text. */
static inline char *calibrate_text(const calibrate_change *change) {
    char *const text = malloc(3000);
    assert_non_null(text);
    const calibrate_change none = {.scale = 0};
    const calibrate_change *const of = change != NULL ? change : &none;
    const int size = snprintf(
        text, 3000,
        "{\"schema\": \"toliman-scene/1\", \"name\": \"calibrate\","
        " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.032, \"pupil_samples\": 32%s%s,"
        "  \"mask\": {\"kind\": \"spiral\", \"opd_nm\": 292.5, \"edges\": \"area\"%s,"
        "   \"terms\": [{\"a\": 1, \"f\": 1.2, \"m\": -5, \"p\": 1}]}},"
        " \"band\": {\"min_nm\": 530, \"max_nm\": 640, \"step_nm\": 55},"
        " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": %.17g},"
        "   \"photons_per_s\": 7.5e6},"
        "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"photons_per_s\": 2.5e6}},"
        " \"binary\": {\"date\": 2027, \"moving\": true, \"orbit\": {\"period_years\": 2, \"semi_major_arcsec\": 4.5,"
        "   \"eccentricity\": 0, \"inclination_deg\": 0, \"node_deg\": 40, \"periastron_deg\": 0, \"epoch\": 2027}},"
        " \"cadence\": {\"frames\": 8, \"interval_days\": 15, \"exposure_s\": 100},"
        " \"detector\": {\"shape\": [40, 40], \"pixel_scale_arcsec\": %.17g},"
        " \"systematics\": {" CALIBRATE_POINTING "%s},"
        " \"noise\": {\"photon\": true, \"read_e\": 1.3, \"seed\": 7}, \"accuracy\": 1e-7}",
        of->no_struts ? "" : ", \"struts\": {\"count\": 3, \"width_m\": 0.004}",
        of->telescope != NULL ? of->telescope : "", of->mask != NULL ? of->mask : "",
        of->temperature_a > 0 ? of->temperature_a : 5790, 0.375 / (1 + of->scale),
        of->systematics != NULL ? of->systematics : "");
    assert_in_range(size, 1, 2999);
    return text;
}

static inline toliman_sim *calibrate_sim(const calibrate_change *change) {
    char *const text = calibrate_text(change);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

/* A telescope that differs from the nominal one, and its values of the default parameters. */
static const calibrate_change kTrueChange = {
    .telescope = ", \"aberrations\": {\"zernike_rms_nm\": {\"4\": 9, \"5\": -12, \"7\": 8, \"8\": -10, \"11\": 5}}",
    .mask = ", \"rotation_deg\": 0.1",
    .systematics = ", \"jitter_covariance_px2\": {\"xx\": 0.01, \"yy\": 0.006, \"xy\": 0.002}",
    .scale = 1e-3,
    .temperature_a = 5860};

static inline double calibrate_truth(const char *name) {
    static const struct {
        const char *name;
        double value;
    } all[] = {{"focus", 9},         {"zernike_5", -12},     {"zernike_7", 8},     {"zernike_8", -10},
               {"zernike_11", 5},    {"mask_rotation", 0.1}, {"jitter_xx", 0.01},  {"jitter_yy", 0.006},
               {"jitter_xy", 0.002}, {"scale", 1e-3},        {"temperature_a", 70}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (strcmp(name, all[i].name) == 0)
            return all[i].value;
    return 0;
}

static inline toliman_calibration_info calibrate_info_of(const toliman_calibration *calibration) {
    toliman_calibration_info info = {.struct_size = sizeof info};
    assert_ok(toliman_calibration_get_info(calibration, &info));
    return info;
}

static inline toliman_calibration_value calibrate_value_of(const toliman_calibration *calibration, int64_t window,
                                                           int64_t index) {
    toliman_calibration_value value = {.struct_size = sizeof value};
    assert_ok(toliman_calibration_get_value(calibration, window, index, &value));
    return value;
}

static inline toliman_fit_result calibrate_frame_of(const toliman_calibration *calibration, int64_t index) {
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_calibration_get_frame(calibration, index, &result));
    return result;
}

#endif
