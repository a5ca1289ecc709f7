/* What the tests of calibrations of one program have in common: frames of a truth, their calibration, and a folder. */
#ifndef TOLIMAN_TESTS_CALIBRATE_GROUP_H
#define TOLIMAN_TESTS_CALIBRATE_GROUP_H

#include "calibrate_scene.h"
#include "test_folder.h"

enum {
    SIDE = CALIBRATE_SIDE,
    PIXELS = CALIBRATE_PIXELS,
    FRAMES = CALIBRATE_FRAMES,
    ALL = 8,
    CELLS = 32,
    DEFAULT = 29,
    KNOWN = 25
};

/* The default parameters that three wavelengths determine. */
static const char kKnown[] = "focus zernike_5-21 scale mask_rotation jitter_xx jitter_yy jitter_xy temperature_a "
                             "temperature_b";

static toliman_sim *nominal, *truth;
static double frames[ALL * PIXELS];
static toliman_calibration *whole; /* FRAMES frames, kKnown free */
static char folder[300];

static toliman_calibration *calibrated(const toliman_sim *sim, const double *of, size_t count,
                                       const toliman_calibration_options *options) {
    toliman_calibration *made = NULL;
    assert_ok(toliman_calibration_create(sim, PLAIN_IMAGE(of), count, NULL, options, &made));
    return made;
}

static int set_up(void **unused) {
    (void)unused;
    nominal = calibrate_sim(NULL);
    truth = calibrate_sim(&kTrueChange);
    assert_ok(toliman_sim_frame(truth, NULL, 3, 0, ALL, frames));
    const toliman_calibration_options options = {.struct_size = sizeof options, .free = kKnown};
    whole = calibrated(nominal, frames, FRAMES, &options);
    make_folder(folder, sizeof folder);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    remove_folder(folder);
    toliman_calibration_destroy(whole);
    toliman_sim_destroy(truth);
    toliman_sim_destroy(nominal);
    return 0;
}

static const char *in_folder(const char *name) {
    static char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* Both have the same bits. */
static inline void assert_same(const toliman_calibration *one, const toliman_calibration *other) {
    const toliman_calibration_info info = calibrate_info_of(one), same = calibrate_info_of(other);
    static double numbers[2][PIXELS];
    assert_memory_equal(&info, &same, sizeof info);
    for (int64_t w = 0; w < info.windows; w++) {
        for (int64_t i = 0; i < info.parameters; i++) {
            const toliman_calibration_value value = calibrate_value_of(one, w, i),
                                            equal = calibrate_value_of(other, w, i);
            assert_memory_equal(&value, &equal, sizeof value);
        }
        const size_t size = (size_t)(info.parameters * info.parameters) * sizeof(double);
        assert_ok(toliman_calibration_get_covariance(one, w, numbers[0]));
        assert_ok(toliman_calibration_get_covariance(other, w, numbers[1]));
        assert_memory_equal(numbers[0], numbers[1], size);
    }
    for (int64_t k = 0; k < info.frames; k++) {
        const toliman_fit_result result = calibrate_frame_of(one, k), equal = calibrate_frame_of(other, k);
        assert_memory_equal(&result, &equal, sizeof result);
    }
    assert_ok(toliman_calibration_get_image(one, TOLIMAN_CALIBRATION_IMAGE_CHI, numbers[0], SIDE));
    assert_ok(toliman_calibration_get_image(other, TOLIMAN_CALIBRATION_IMAGE_CHI, numbers[1], SIDE));
    assert_memory_equal(numbers[0], numbers[1], sizeof numbers[0]);
}

#endif
