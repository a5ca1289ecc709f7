/* Short frames of a binary whose pointing jitters, for tests of sums. */
#ifndef TOLIMAN_TESTS_COADD_FRAMES_H
#define TOLIMAN_TESTS_COADD_FRAMES_H

#include <toliman/coadd.h>

#include "scene_text.h"
#include "uniform.h"

enum { COADD_SIDE = 64, COADD_PIXELS = COADD_SIDE * COADD_SIDE, COADD_BIAS = 100 };

static inline toliman_sim *coadd_sim(const char *detector) {
    char *const text = EDITED(kBinaryScene, {"'relative_flux': 3}", "'photons_per_s': 3e7}"},
                              {"5260}}}", "5260}, 'photons_per_s': 1e7}}"},
                              {"'peak_photons': 1e5", "'exposure_s': 0.01"}, {"'pixel_scale_arcsec': 0.2}", detector});
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

static const char kCoaddDetector[] = "'pixel_scale_arcsec': 0.2, 'bias_dn': 100, 'gain_e_per_dn': 1, 'bit_depth': 12}";

static inline toliman_fit *coadd_fit(const char *detector) {
    toliman_sim *const sim = coadd_sim(detector);
    const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = 8};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &fit));
    toliman_sim_destroy(sim);
    return fit;
}

static inline toliman_coadd *coadd_of(const toliman_fit *fit, toliman_coadd_options options) {
    options.struct_size = sizeof options;
    toliman_coadd *coadd = NULL;
    assert_ok(toliman_coadd_create(fit, NULL, &options, &coadd));
    return coadd;
}

static inline void coadd_expect(const toliman_fit *fit, double x, double y, double *image) {
    const toliman_fit_prediction place = {.struct_size = sizeof place, .x_px = x, .y_px = y};
    assert_ok(toliman_fit_predict(fit, &place, image, COADD_SIDE, NULL, NULL));
}

/* Counts with nearly Poisson noise and the read noise of the scene, 2.5 electrons. */
static inline void coadd_draw(const double *expected, uint64_t *state, uint16_t *counts) {
    for (int p = 0; p < COADD_PIXELS; p++) {
        const double light = fmax(0, expected[p] - COADD_BIAS);
        counts[p] = (uint16_t)fmin(4095, rint(expected[p] + sqrt(light + 2.5 * 2.5) * noise(state)));
    }
}

static inline toliman_frame coadd_frame(const uint16_t *counts, int64_t camera_ns) {
    return (toliman_frame){.struct_size = sizeof(toliman_frame),
                           .pixel = TOLIMAN_PIXEL_U16,
                           .session = "night",
                           .roi = "centre",
                           .camera_ns = camera_ns,
                           .pixels = counts,
                           .rows = COADD_SIDE,
                           .cols = COADD_SIDE,
                           .exposure_s = 0.005};
}

static inline toliman_coadd_outcome coadd_add(toliman_coadd *coadd, const uint16_t *counts, int64_t camera_ns) {
    const toliman_frame frame = coadd_frame(counts, camera_ns);
    toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
    assert_ok(toliman_coadd_add(coadd, &frame, &outcome));
    return outcome;
}

static inline toliman_coadd_sum coadd_take(toliman_coadd *coadd, toliman_frame *frame) {
    toliman_coadd_sum sum = {.struct_size = sizeof sum};
    *frame = (toliman_frame){.struct_size = sizeof *frame};
    assert_ok(toliman_coadd_take(coadd, frame, &sum));
    return sum;
}

static inline toliman_coadd_info coadd_info_of(const toliman_coadd *coadd) {
    toliman_coadd_info info = {.struct_size = sizeof info};
    assert_ok(toliman_coadd_get_info(coadd, &info));
    return info;
}

#endif
