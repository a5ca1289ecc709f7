/* Scenes as text for the tests of the simulator: small ones, and functions that change one place of them. */
#ifndef TOLIMAN_TESTS_SCENE_TEXT_H
#define TOLIMAN_TESTS_SCENE_TEXT_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <toliman/sim.h>

#include "assert_close.h"

/* Two stars behind a spiral mask, five wavelengths; 96 pupil samples, 64 x 64 px. */
static const char *const kBinaryScene =
    "{\"schema\": \"toliman-scene/1\", \"name\": \"binary\","
    " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.01875, \"pupil_samples\": 96,"
    "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,"
    "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}]}},"
    " \"band\": {\"min_nm\": 550, \"max_nm\": 600, \"step_nm\": 12.5},"
    " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 3},"
    "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}}},"
    " \"binary\": {\"separation_arcsec\": 4, \"position_angle_deg\": 30},"
    " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 40},"
    " \"cadence\": {\"frames\": 100, \"interval_days\": 2, \"peak_photons\": 1e5},"
    " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.2},"
    " \"noise\": {\"photon\": true, \"read_e\": 2.5, \"seed\": 7}}";

/* One star in one wavelength through a clear round aperture; 64 pupil samples, 32 x 32 px. */
static const char *const kSingleScene =
    "{\"schema\": \"toliman-scene/1\","
    " \"telescope\": {\"aperture_m\": 0.125, \"pupil_samples\": 64},"
    " \"band\": {\"wavelength_nm\": 550},"
    " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}}},"
    " \"binary\": {\"offsets_px\": {\"A\": [0, 0]}},"
    " \"cadence\": {\"frames\": 10, \"peak_photons\": 1e6},"
    " \"detector\": {\"shape\": [32, 32], \"pixel_scale_arcsec\": 0.2}}";

/* text with " for each '; the caller frees it. */
static inline char *quoted(const char *text) {
    char *const result = strdup(text);
    assert_non_null(result);
    for (char *at = result; (at = strchr(at, '\'')) != NULL;)
        *at = '"';
    return result;
}

/* text with the single occurrence of `from` replaced, where ' stands for "; the caller frees it. */
static inline char *replaced(const char *text, const char *from, const char *to) {
    char *const place = quoted(from), *const result = malloc(strlen(text) + strlen(to) + 1);
    const char *const at = strstr(text, place);
    if (at == NULL || strstr(at + 1, place) != NULL)
        fail_msg("\"%s\" must occur exactly once in the scene", place);
    assert_non_null(result);
    char *const by = quoted(to);
    memcpy(result, text, (size_t)(at - text));
    strcpy(result + (at - text), by);
    strcat(result, at + strlen(place));
    free(place), free(by);
    return result;
}

/* The same, and frees the given text. */
static inline char *replaced_again(char *text, const char *from, const char *to) {
    char *const result = replaced(text, from, to);
    free(text);
    return result;
}

/* text with several places replaced: pairs {from, to}; the caller frees it. */
static inline char *edited(const char *text, const char *const (*pairs)[2], size_t count) {
    char *result = strdup(text);
    for (size_t i = 0; i < count; i++)
        result = replaced_again(result, pairs[i][0], pairs[i][1]);
    return result;
}

#define EDITED(text, ...)                                                                                              \
    edited(text, (const char *const[][2]){__VA_ARGS__},                                                                \
           sizeof((const char *const[][2]){__VA_ARGS__}) / (2 * sizeof(char *)))

static inline toliman_sim *sim_on_threads(const char *json, uint32_t threads) {
    const toliman_sim_options options = {.struct_size = sizeof options, .threads = threads};
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, strlen(json), NULL, &options, &sim));
    return sim;
}

static inline toliman_sim *sim_of(const char *json) {
    return sim_on_threads(json, 0);
}

/* Simulator of the scene with one place replaced. */
static inline toliman_sim *sim_with(const char *json, const char *from, const char *to) {
    char *const text = replaced(json, from, to);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

/* Each addition, inserted by the format at the given place of the scene, must be refused with its message. */
static inline void check_additions(const char *json, const char *place, const char *format,
                                   const char *const (*cases)[2], size_t count) {
    for (size_t i = 0; i < count; i++) {
        char text[200];
        snprintf(text, sizeof text, format, cases[i][0]);
        char *const scene = replaced(json, place, text);
        toliman_sim *sim = NULL;
        assert_fails(toliman_sim_create_json(scene, strlen(scene), NULL, NULL, &sim), TOLIMAN_E_SCENE, cases[i][1]);
        assert_null(sim);
        free(scene);
    }
}

/* A place of a scene, what replaces it, and the field of the error: "" if it names none. */
typedef struct refusal {
    const char *from, *to, *field;
} refusal;

static inline void check_refusals(const char *json, toliman_status status, const refusal *cases, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *const scene = replaced(json, cases[i].from, cases[i].to);
        toliman_sim *sim = NULL;
        assert_refused(toliman_sim_create_json(scene, strlen(scene), NULL, NULL, &sim), status, cases[i].field);
        assert_null(sim);
        free(scene);
    }
}

#define CHECK_REFUSALS(json, status, cases) check_refusals(json, status, cases, sizeof(cases) / sizeof *(cases))

static inline toliman_sim_info sim_info_of(const toliman_sim *sim) {
    toliman_sim_info info = {.struct_size = sizeof info};
    assert_ok(toliman_sim_get_info(sim, &info));
    return info;
}

static inline toliman_sim_bounds sim_bounds_of(const toliman_sim *sim) {
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    return bounds;
}

static inline double *image_of(const toliman_sim *sim, int32_t kind) {
    const toliman_sim_info info = sim_info_of(sim);
    double *const image = malloc((size_t)(info.rows * info.cols) * sizeof *image);
    assert_non_null(image);
    assert_ok(toliman_sim_get_image(sim, kind, image, (size_t)info.cols));
    return image;
}

#endif
