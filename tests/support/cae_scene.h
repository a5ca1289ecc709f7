/* Cheap scenes for the network's tests: one wavelength, a real mask, frames of a given size. */
#ifndef TOLIMAN_TESTS_CAE_SCENE_H
#define TOLIMAN_TESTS_CAE_SCENE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <toliman/cae.h>
#include <toliman/sim.h>

#include "assert_close.h"
#include "images.h"

enum { kSide = 256, kPixels = kSide * kSide };

/* offset_px moves the binary off the centre of the frame; project is the content of preprocess.project. */
static inline size_t write_scene(char *json, size_t capacity, int rows, int cols, double offset_px,
                                 const char *project) {
    return (size_t)snprintf(
        json, capacity,
        "{\"schema\": \"toliman-scene/1\", \"name\": \"cae-test\","
        "\"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.01875, \"pupil_samples\": 128,"
        "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5, \"terms\": ["
        "    {\"a\": 0.819, \"f\": 2.918, \"l\": 0, \"m\": -27, \"p\": 4.874},"
        "    {\"a\": 0.93, \"f\": 1.829, \"l\": 0, \"m\": 25, \"p\": 5.967},"
        "    {\"a\": 0.702, \"f\": 9.468, \"l\": 10.905, \"m\": -27, \"p\": 4.193}]}},"
        "\"band\": {\"wavelength_nm\": 580},"
        "\"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 3},"
        "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"relative_flux\": 1}},"
        "\"binary\": {\"offsets_px\": {\"A\": [%g, %g], \"B\": [%g, %g]}},"
        "\"signal\": {\"kind\": \"sinusoid\", \"star\": \"A\", \"amplitude_px\": 1e-6, \"period_days\": 365,"
        "  \"phase_rad\": 0},"
        "\"cadence\": {\"frames\": 10, \"interval_days\": 1, \"peak_photons\": 1e9},"
        "\"detector\": {\"shape\": [%d, %d], \"pixel_scale_arcsec\": 0.2, \"pixel\": \"point\"},"
        "\"noise\": {\"photon\": true, \"read_e\": 10, \"seed\": 1},"
        "\"preprocess\": {\"project\": [%s]}}",
        offset_px - 5, offset_px + 8, offset_px + 15, offset_px - 24, rows, cols, project);
}

static inline toliman_sim *make_sim_on_threads(int rows, int cols, double offset_px, const char *project,
                                               uint32_t threads) {
    char json[2048];
    const size_t size = write_scene(json, sizeof json, rows, cols, offset_px, project);
    const toliman_sim_options options = {.struct_size = sizeof options, .threads = threads};
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, size, NULL, &options, &sim));
    return sim;
}

static inline toliman_sim *make_sim(int rows, int cols, double offset_px, const char *project) {
    return make_sim_on_threads(rows, cols, offset_px, project, 0);
}

static inline toliman_cae *make_cae(const toliman_sim *sim, uint64_t seed, uint32_t steps,
                                    toliman_cae_training *report) {
    toliman_cae *cae = NULL;
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    assert_ok(toliman_cae_create(sim, seed, NULL, &cae));
    options.steps = steps;
    if (steps != 0)
        assert_ok(toliman_cae_train(cae, &options, report));
    return cae;
}

static inline toliman_cae_info cae_info_of(const toliman_cae *cae) {
    toliman_cae_info info = {.struct_size = sizeof info};
    assert_ok(toliman_cae_get_info(cae, NULL, &info));
    return info;
}

static inline double *new_image(size_t pixels) {
    double *image = malloc(pixels * sizeof *image);
    assert_non_null(image);
    return image;
}

static inline double encode_expected(const toliman_cae *cae, const toliman_sim *sim, double displacement_px) {
    static double frame[kPixels];
    double latent = 0;
    assert_ok(toliman_sim_expect(sim, displacement_px, frame, kSide));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    return latent;
}

static inline uint8_t *saved_with(const toliman_cae *cae, toliman_cae_save_options options, size_t *size) {
    const size_t capacity = 12u << 20; /* more than any blob needs */
    uint8_t *bytes = malloc(capacity);
    assert_non_null(bytes);
    assert_ok(toliman_cae_save(cae, &options, bytes, capacity, size));
    bytes = realloc(bytes, *size);
    assert_non_null(bytes);
    return bytes;
}

/* Encodings by their number in a blob: 0 float32, 1 bf16, 2 fp16. */
static inline uint8_t *saved_as(const toliman_cae *cae, int32_t weights, int32_t planes, size_t *size) {
    toliman_cae_save_options options = TOLIMAN_CAE_SAVE_OPTIONS_INIT;
    options.weights_encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + weights;
    options.planes_encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + planes;
    return saved_with(cae, options, size);
}

static inline uint8_t *saved_with_training(const toliman_cae *cae, size_t *size) {
    toliman_cae_save_options options = TOLIMAN_CAE_SAVE_OPTIONS_INIT;
    options.with_training = 1;
    return saved_with(cae, options, size);
}

static inline uint8_t *saved(const toliman_cae *cae, size_t *size) {
    return saved_as(cae, 0, 0, size);
}

static inline void assert_saved(const toliman_cae *cae, const uint8_t *bytes, size_t size) {
    size_t found;
    uint8_t *const again = saved(cae, &found);
    assert_int_equal(found, size);
    assert_memory_equal(again, bytes, size);
    free(again);
}

/* A copy of a network that encodes on this number of threads. */
static inline toliman_cae *cae_on_threads(const toliman_cae *cae, uint32_t threads) {
    const toliman_load_options options = {.struct_size = sizeof options, .threads = threads};
    size_t size;
    uint8_t *const bytes = saved(cae, &size);
    toliman_cae *copy = NULL;
    assert_ok(toliman_cae_load(bytes, size, &options, &copy));
    free(bytes);
    return copy;
}

#endif
