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
    assert_ok(toliman_calibrate(sim, PLAIN_IMAGE(of), count, NULL, options, &made));
    return made;
}

static int set_up(void **unused) {
    (void)unused;
    nominal = calibrate_sim(NULL);
    truth = calibrate_sim(&kTrueChange);
    assert_ok(toliman_sim_frame_many(truth, NULL, 3, 0, ALL, 0, frames));
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

#endif
