/* Scenes and banks for the tests of banks: two wavelengths, stars on an orbit or at rest, networks with few steps. */
#ifndef TOLIMAN_TESTS_BANK_SCENE_H
#define TOLIMAN_TESTS_BANK_SCENE_H

#include <stdio.h>
#include <stdlib.h>

#include <toliman/bank.h>

#include "scene_text.h"

/* 13.5 px apart; on a circular orbit, B moves by 4.24 px relative to A during the 50 days of the frames. */
#define BANK_ORBIT                                                                                                     \
    "\"date\": 2027, \"moving\": true, \"orbit\": {\"period_years\": 2.739726, \"semi_major_arcsec\": 2.7, "           \
    "\"eccentricity\": 0, \"inclination_deg\": 0, \"node_deg\": 40, \"periastron_deg\": 0, \"epoch\": 2027}"
#define BANK_AT_REST "\"offsets_px\": {\"A\": [-5.25, 3], \"B\": [6, -4.5]}"

static inline toliman_sim *bank_sim(int rows, int cols, const char *binary) {
    char json[2048];
    const int size = snprintf(
        json, sizeof json,
        "{\"schema\": \"toliman-scene/1\", \"name\": \"bank\","
        " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.01875, \"pupil_samples\": 96,"
        "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,"
        "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": "
        "5}]}},"
        " \"band\": {\"min_nm\": 570, \"max_nm\": 590, \"step_nm\": 10},"
        " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 3},"
        "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}}},"
        " \"binary\": {%s},"
        " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 20},"
        " \"cadence\": {\"frames\": 51, \"interval_days\": 1, \"peak_photons\": 1e6},"
        " \"detector\": {\"shape\": [%d, %d], \"pixel_scale_arcsec\": 0.2},"
        " \"noise\": {\"photon\": true, \"read_e\": 2.5, \"seed\": 7}}",
        binary, rows, cols);
    assert_in_range(size, 1, sizeof json - 1);
    return sim_of(json);
}

static inline toliman_fit *bank_fit(const toliman_sim *sim, double capture_px) {
    const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = capture_px};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &fit));
    return fit;
}

static inline toliman_bank *bank_of(const toliman_fit *fit, uint32_t places, double spacing_px, uint32_t steps) {
    const toliman_bank_options options = {
        .struct_size = sizeof options, .places = places, .spacing_px = spacing_px, .steps = steps};
    toliman_bank *bank = NULL;
    assert_ok(toliman_bank_create(fit, &options, &bank));
    return bank;
}

static inline void train_bank(toliman_bank *bank, const toliman_fit *fit, uint32_t threads) {
    const toliman_bank_train_options options = {.struct_size = sizeof options, .threads = threads};
    assert_ok(toliman_bank_train(bank, fit, &options));
}

static inline toliman_bank_info bank_info_of(const toliman_bank *bank) {
    toliman_bank_info info = {.struct_size = sizeof info};
    assert_ok(toliman_bank_get_info(bank, &info));
    return info;
}

static inline toliman_bank_network bank_network_of(const toliman_bank *bank, int64_t index) {
    toliman_bank_network network = {.struct_size = sizeof network};
    assert_ok(toliman_bank_get_network(bank, index, &network));
    return network;
}

/* The caller frees the bytes. */
static inline uint8_t *bank_bytes(const toliman_bank *bank, int32_t encoding, size_t *size) {
    assert_asks(toliman_bank_save(bank, encoding, NULL, 0, size));
    uint8_t *const bytes = malloc(*size);
    assert_non_null(bytes);
    assert_ok(toliman_bank_save(bank, encoding, bytes, *size, size));
    return bytes;
}

static inline void assert_bank_bytes(const toliman_bank *bank, int32_t encoding, const uint8_t *bytes, size_t size) {
    size_t found;
    uint8_t *const again = bank_bytes(bank, encoding, &found);
    assert_int_equal(found, size);
    assert_memory_equal(again, bytes, size);
    free(again);
}

static inline toliman_bank *bank_from(const uint8_t *bytes, size_t size) {
    toliman_bank *bank = NULL;
    assert_ok(toliman_bank_load(bytes, size, NULL, &bank));
    return bank;
}

#endif
