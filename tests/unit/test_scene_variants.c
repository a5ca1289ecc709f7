/* Tests groups of a scene that have variants: the message for a key that belongs to another variant. */
#include <stdbool.h>

#include "scene_text.h"

TEST(keys_of_other_variants) {
    const char *const places = "'separation_arcsec': 4, 'position_angle_deg': 30";
    const char *const kelvin = "'kind': 'blackbody', 'temperature_k': 5790";
    const refusal cases[] = {
        {"'frames': 100", "'times_days': [1, 2]", "cadence.interval_days"},
        {"'interval_days': 2", "'times_days': [1, 2]", "cadence.frames"},
        {places, "'separation_arcsec': 4, 'moving': true", "binary.moving"},
        {places, "'offsets_px': {'A': [0, 0], 'B': [9, 1]}, 'centre': 'A'", "binary.centre"},
        {"'min_nm': 550", "'wavelength_nm': 550", "band.max_nm"},
        {"'opd_nm': 297.5", "'opd_nm': 297.5, 'file': 'x.npy'", "telescope.mask.file"},
        {"'kind': 'spiral'", "'kind': 'clear'", "telescope.mask.edges"},
        {kelvin, "'kind': 'lines', 'temperature_k': 5790", "stars.A.spectrum.temperature_k"},
        {kelvin, "'kind': 'blackbody', 'file': 'x.csv'", "stars.A.spectrum.file"},
        {kelvin, "'kind': 'blackbody', 'weight': [1]", "stars.A.spectrum.weight"},
        {"'period_days': 40", "'eccentricity': 0.1", "signal.eccentricity"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'focal_length_m': 10, 'pixel_um': 10",
         "detector.pixel_scale_arcsec"},
        {"'pixel_scale_arcsec': 0.2", "'focal_length_m': 10", "detector.pixel_um"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'pixel_um': 10", "detector.pixel_um"},
        {"'pixel_scale_arcsec': 0.2", "'focal_length_m': 1e-3, 'pixel_um': 10", "detector.pixel_um"},
        {"'relative_flux': 3", "'relative_flux': 3, 'magnitude': 0, 'zero_point_photons_per_s': 1",
         "stars.A.relative_flux"},
        {"'relative_flux': 3", "'photons_per_s': 3, 'magnitude': 0, 'zero_point_photons_per_s': 1",
         "stars.A.photons_per_s"},
        {"'relative_flux': 3", "'magnitude': 0", "stars.A.zero_point_photons_per_s"},
        {"'relative_flux': 3", "'zero_point_photons_per_s': 1", "stars.A.zero_point_photons_per_s"},
        {"'relative_flux': 3", "'magnitude': -40, 'zero_point_photons_per_s': 1", "stars.A.magnitude"},
        {"'kind': 'sinusoid', 'star': 'B'", "'kind': 'none'", "signal.amplitude_px"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
}

static toliman_sim_info info_of(toliman_sim *sim) {
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    assert_ok(toliman_sim_get_info(sim, &info));
    toliman_sim_destroy(sim);
    return info;
}

/* 10 um at 10 m are 1e-6 rad. */
TEST(pixels_by_focal_length) {
    const toliman_sim_info info =
        info_of(sim_with(kBinaryScene, "'pixel_scale_arcsec': 0.2", "'focal_length_m': 10, 'pixel_um': 10"));
    assert_close(info.pixel_scale_arcsec, 0.20626480624709636, 1e-15, 0);
}

/* Five magnitudes are a factor of 100. */
TEST(fluxes_by_magnitude) {
    char *text = EDITED(kBinaryScene, {"'relative_flux': 3", "'magnitude': 1, 'zero_point_photons_per_s': 2e7"},
                        {"5260}", "5260}, 'magnitude': 6, 'zero_point_photons_per_s': 1.5e7"});
    const toliman_sim_info info = info_of(sim_of(text));
    free(text);
    assert_close(info.flux_ratio, 400.0 / 3, 1e-12, 0);
}

TEST(values_of_other_kinds) {
    const refusal cases[] = {
        {"'aperture_m': 0.125", "'aperture_m': true", "telescope.aperture_m"},
        {"'aperture_m': 0.125", "'aperture_m': false", "telescope.aperture_m"},
        {"'aperture_m': 0.125", "'aperture_m': {}", "telescope.aperture_m"},
        {"'noise'", "'preprocess': {'project': ['shift_x', 1]}, 'noise'", "preprocess.project"},
        {"'noise'", "'preprocess': {'project': true}, 'noise'", "preprocess.project"},
        {"{'a': 0.819, 'f': 2.918, 'm': -7, 'p': 4.874}, {'a': 0.93, 'f': 1.829, 'm': 5}", "", "telescope.mask.terms"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
}

#define FOUR_NAMES "'flux_a', 'flux_a', 'flux_a', 'flux_a', "
#define EIGHT_NAMES FOUR_NAMES FOUR_NAMES

TEST(other_impossible_values) {
    const refusal cases[] = {
        {"[64, 64]", "[64, 64.5]", "detector.shape"},
        {"'step_nm': 12.5", "'step_nm': 100", "band.step_nm"},
        {"'noise'", "'systematics': {'flux_rms': {'rms': 0, 'drift_per_day': 0.09}}, 'noise'",
         "systematics.flux_rms.drift_per_day"},
        {"'noise'", "'preprocess': {'project': [" EIGHT_NAMES EIGHT_NAMES EIGHT_NAMES EIGHT_NAMES "'flux_b']}, 'noise'",
         "preprocess.project"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
    const refusal faint[] = {
        {"5790}", "5790}, 'relative_flux': 5e-324", ""},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, faint);
}

/* UTF-8 as Unicode defines it, by decoding and encoding again. Invalid UTF-8 is reported before an invalid name. */
static bool is_utf8(const unsigned char *bytes, size_t count) {
    const size_t length = bytes[0] < 0xc0 ? 0 : bytes[0] < 0xe0 ? 2 : bytes[0] < 0xf0 ? 3 : bytes[0] < 0xf8 ? 4 : 0;
    if (length != count)
        return false;
    uint32_t point = bytes[0] & (0x7fu >> length);
    for (size_t i = 1; i < count; i++) {
        if (bytes[i] >> 6 != 2)
            return false;
        point = point << 6 | (bytes[i] & 0x3f);
    }
    return point >= (count == 2   ? 0x80u
                     : count == 3 ? 0x800u
                                  : 0x10000u) &&
           point <= 0x10ffff && (point < 0xd800 || point > 0xdfff);
}

TEST(texts_are_utf8) {
    static const unsigned char edges[] = {0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0};
    const char *const head = "{\"name\": \"", *const tail = "\"}";
    for (unsigned first = 0x80; first < 0x100; first++)
        for (size_t count = 1; count <= 4; count++)
            for (int edge = 0; edge < 1 << 3 * (count - 1); edge++) {
                unsigned char bytes[4] = {(unsigned char)first};
                for (size_t i = 1; i < count; i++)
                    bytes[i] = edges[edge >> 3 * (i - 1) & 7];
                char text[40];
                const int size = snprintf(text, sizeof text, "%s%.*s%s", head, (int)count, (char *)bytes, tail);
                toliman_sim *sim = NULL;
                const toliman_status status = toliman_sim_create_json(text, (size_t)size, NULL, NULL, &sim);
                if (bytes[count - 1] == 0x7f) /* may truncate the last character */
                    continue;
                assert_int_equal(status, is_utf8(bytes, count) ? TOLIMAN_E_SCENE : TOLIMAN_E_FORMAT);
            }
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json("{\"\xe2\x82", 4, NULL, NULL, &sim), TOLIMAN_E_FORMAT, "scene");
    assert_refused(toliman_sim_create_json("{\"\xf0\x9f\x98", 5, NULL, NULL, &sim), TOLIMAN_E_FORMAT, "scene");
}

TEST(a_single_star_has_no_second_star) {
    const refusal cases[] = {
        {"'cadence'", "'preprocess': {'project': ['flux_b']}, 'cadence'", "preprocess.project"},
        {"'offsets_px': {'A': [0, 0]}", "'separation_arcsec': 4", "binary"},
        {"'cadence'",
         "'signal': {'kind': 'sinusoid', 'star': 'B', 'amplitude_px': 1e-3, 'period_days': 40}, "
         "'cadence'",
         "signal.star"},
        {"'A': [0, 0]", "'A': [0, 0], 'B': [1, 1]", "binary.offsets_px.B"},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, cases);
}

TEST(emission_lines_need_no_band) {
    const char *const kelvin = "'kind': 'blackbody', 'temperature_k': 5790";
    const refusal cases[] = {
        {kelvin, "'kind': 'lines', 'wavelength_nm': [550, 560], 'weight': [1]", "stars.A.spectrum.weight"},
        {kelvin, "'kind': 'lines', 'wavelength_nm': [550, 560], 'weight': [0, 0]", "stars.A.spectrum.weight"},
        {kelvin, "'kind': 'lines', 'wavelength_nm': [550, 560], 'weight': [0, 1]", "band"},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, cases);
}

/* An orbit so small that it is a point. */
TEST(coincident_stars) {
    const refusal cases[] = {
        {"'separation_arcsec': 4, 'position_angle_deg': 30",
         "'date': 2000, 'orbit': {'period_years': 80, 'semi_major_arcsec': 5e-324, 'eccentricity': 0.9,"
         " 'inclination_deg': 0, 'node_deg': 0, 'periastron_deg': 0, 'epoch': 2000}",
         "binary.orbit.semi_major_arcsec"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
}

/* Two equivalent descriptions of a scene give the same bytes. */
static void assert_same_images(const char *json, const char *from, const char *to) {
    toliman_sim *const one = sim_of(json), *const other = sim_with(json, from, to);
    const toliman_sim_info info = sim_info_of(one);
    double *const image = image_of(one, TOLIMAN_SIM_IMAGE_BOTH), *const same = image_of(other, TOLIMAN_SIM_IMAGE_BOTH);
    assert_memory_equal(image, same, (size_t)(info.rows * info.cols) * sizeof *image);
    double displacement, its;
    assert_ok(toliman_sim_get_series(one, 3, 1, NULL, &displacement));
    assert_ok(toliman_sim_get_series(other, 3, 1, NULL, &its));
    assert_close(its, displacement, 1e-14, 0);
    free(image), free(same), toliman_sim_destroy(one), toliman_sim_destroy(other);
}

TEST(equivalent_scenes_give_equal_bytes) {
    assert_same_images(kBinaryScene, "'step_nm': 12.5", "'step_nm': 125E-1");
    assert_same_images(kBinaryScene, "'step_nm': 12.5", "'step_nm': 0.125e+2");
    assert_same_images(kBinaryScene, "'amplitude_px': 1e-3", "'amplitude_uas': 200"); /* at 0.2 arcsec per pixel */
    assert_same_images(kSingleScene, "'aperture_m'", "'mask': {'kind': 'clear'}, 'aperture_m'");
    const refusal cases[] = {
        {"'aperture_m'", "'mask': {'kind': 'clear', 'opd_nm': 1}, 'aperture_m'", "telescope.mask.opd_nm"},
        {"'aperture_m'", "'mask': {'kind': 'clear', 'height_nm': 1}, 'aperture_m'", "telescope.mask.height_nm"},
    };
    CHECK_REFUSALS(kSingleScene, TOLIMAN_E_SCENE, cases);
}

RUN_TESTS(NULL, NULL)
