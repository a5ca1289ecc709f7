/* Tests groups of a scene that have variants: the message for a key that belongs to another variant. */
#include <stdbool.h>

#include "scene_text.h"

static void keys_of_other_variants(void **state) {
    (void)state;
    const char *const places = "\"separation_arcsec\": 4, \"position_angle_deg\": 30";
    const char *const kelvin = "\"kind\": \"blackbody\", \"temperature_k\": 5790";
    const char *const cases[][3] = {
        {"\"frames\": 100", "\"times_days\": [1, 2]", "scene: cadence.interval_days: not allowed with times_days"},
        {"\"interval_days\": 2", "\"times_days\": [1, 2]", "cadence.frames: not allowed with times_days"},
        {places, "\"separation_arcsec\": 4, \"moving\": true", "scene: binary.moving: needs date and orbit"},
        {places, "\"offsets_px\": {\"A\": [0, 0], \"B\": [9, 1]}, \"centre\": \"A\"",
         "binary.centre: not allowed with offsets_px"},
        {"\"min_nm\": 550", "\"wavelength_nm\": 550", "scene: band.max_nm: not allowed with wavelength_nm"},
        {"\"opd_nm\": 297.5", "\"opd_nm\": 297.5, \"file\": \"x.npy\"", "telescope.mask.file: needs kind \"file\""},
        {"\"kind\": \"spiral\"", "\"kind\": \"clear\"", "telescope.mask.edges: needs kind \"spiral\""},
        {kelvin, "\"kind\": \"lines\", \"temperature_k\": 5790",
         "stars.A.spectrum.temperature_k: needs kind \"blackbody\""},
        {kelvin, "\"kind\": \"blackbody\", \"file\": \"x.csv\"", "stars.A.spectrum.file: needs kind \"table\""},
        {kelvin, "\"kind\": \"blackbody\", \"weight\": [1]", "stars.A.spectrum.weight: needs kind \"lines\""},
        {"\"period_days\": 40", "\"eccentricity\": 0.1", "signal.eccentricity: needs kind \"planet\""},
        {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.2, \"focal_length_m\": 10, \"pixel_um\": 10",
         "detector.pixel_scale_arcsec: give either pixel_scale_arcsec or focal_length_m"},
        {"\"pixel_scale_arcsec\": 0.2", "\"focal_length_m\": 10", "detector.pixel_um: is missing"},
        {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.2, \"pixel_um\": 10",
         "detector.pixel_um: needs focal_length_m"},
        {"\"pixel_scale_arcsec\": 0.2", "\"focal_length_m\": 1e-3, \"pixel_um\": 10",
         "detector.pixel_um = 10: with focal_length_m = 0.001, gives 2062.65 arcsec: must be in [1e-06, 100] arcsec"},
        {"\"relative_flux\": 3", "\"relative_flux\": 3, \"magnitude\": 0, \"zero_point_photons_per_s\": 1",
         "stars.A.relative_flux: not allowed with magnitude"},
        {"\"relative_flux\": 3", "\"photons_per_s\": 3, \"magnitude\": 0, \"zero_point_photons_per_s\": 1",
         "stars.A.photons_per_s: give either photons_per_s or magnitude"},
        {"\"relative_flux\": 3", "\"magnitude\": 0", "stars.A.zero_point_photons_per_s: is missing"},
        {"\"relative_flux\": 3", "\"zero_point_photons_per_s\": 1",
         "stars.A.zero_point_photons_per_s: needs magnitude"},
        {"\"relative_flux\": 3", "\"magnitude\": -40, \"zero_point_photons_per_s\": 1",
         "stars.A.magnitude = -40: gives 1e+16 photons/s: must be in (0, 1e+15] photons/s"},
        {"\"kind\": \"sinusoid\", \"star\": \"B\"", "\"kind\": \"none\"",
         "signal.amplitude_px: needs kind \"sinusoid\""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *const text = replaced(kBinaryScene, cases[i][0], cases[i][1]);
        toliman_sim *sim = NULL;
        assert_fails(toliman_sim_create_json(text, strlen(text), NULL, NULL, &sim), TOLIMAN_E_SCENE, cases[i][2]);
        assert_null(sim);
        free(text);
    }
}

static toliman_sim_info info_of(toliman_sim *sim) {
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    assert_ok(toliman_sim_get_info(sim, &info));
    toliman_sim_destroy(sim);
    return info;
}

/* 10 um at 10 m are 1e-6 rad. */
static void pixels_by_focal_length(void **state) {
    (void)state;
    const toliman_sim_info info =
        info_of(sim_with(kBinaryScene, "\"pixel_scale_arcsec\": 0.2", "\"focal_length_m\": 10, \"pixel_um\": 10"));
    assert_close(info.pixel_scale_arcsec, 0.20626480624709636, 1e-15, 0);
}

/* Five magnitudes are a factor of 100. */
static void fluxes_by_magnitude(void **state) {
    (void)state;
    char *text = replaced(kBinaryScene, "\"relative_flux\": 3", "\"magnitude\": 1, \"zero_point_photons_per_s\": 2e7");
    text = replaced_again(text, "5260}", "5260}, \"magnitude\": 6, \"zero_point_photons_per_s\": 1.5e7");
    const toliman_sim_info info = info_of(sim_of(text));
    free(text);
    assert_close(info.flux_ratio, 400.0 / 3, 1e-12, 0);
}

typedef struct refusal {
    const char *from, *to, *message;
} refusal;

static void check_refusals(const char *scene, const refusal *cases, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *const text = replaced(scene, cases[i].from, cases[i].to);
        toliman_sim *sim = NULL;
        assert_fails(toliman_sim_create_json(text, strlen(text), NULL, NULL, &sim), TOLIMAN_E_SCENE, cases[i].message);
        assert_null(sim);
        free(text);
    }
}

static void values_of_other_kinds(void **state) {
    (void)state;
    const refusal cases[] = {
        {"\"aperture_m\": 0.125", "\"aperture_m\": true", "telescope.aperture_m = true: must be a number"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": false", "telescope.aperture_m = false: must be a number"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": {}", "telescope.aperture_m = an object: must be a number"},
        {"\"noise\"", "\"preprocess\": {\"project\": [\"shift_x\", 1]}, \"noise\"",
         "preprocess.project: contains 1: must contain only strings"},
        {"\"noise\"", "\"preprocess\": {\"project\": true}, \"noise\"",
         "preprocess.project = true: must be an array of strings"},
        {"{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}", "",
         "telescope.mask.terms: has 0 entries: must have 1 to"},
    };
    check_refusals(kBinaryScene, cases, sizeof cases / sizeof *cases);
}

#define FOUR_NAMES "\"flux_a\", \"flux_a\", \"flux_a\", \"flux_a\", "
#define EIGHT_NAMES FOUR_NAMES FOUR_NAMES

static void other_impossible_values(void **state) {
    (void)state;
    const refusal cases[] = {
        {"[64, 64]", "[64, 64.5]", "detector.shape = [64, 64.5]: must be whole numbers"},
        {"\"step_nm\": 12.5", "\"step_nm\": 100", "band.step_nm = 100: must divide the band of 50 nm"},
        {"\"noise\"", "\"systematics\": {\"flux_rms\": {\"rms\": 0, \"drift_per_day\": 0.09}}, \"noise\"",
         "drift_per_day = 0.09: amounts to"},
        {"\"noise\"",
         "\"preprocess\": {\"project\": [" EIGHT_NAMES EIGHT_NAMES EIGHT_NAMES EIGHT_NAMES "\"flux_b\"]}, \"noise\"",
         "preprocess.project: has 33 names: must have 0 to 32"},
    };
    check_refusals(kBinaryScene, cases, sizeof cases / sizeof *cases);
    const refusal faint[] = {
        {"5790}", "5790}, \"relative_flux\": 5e-324", "no light falls on the detector"},
    };
    check_refusals(kSingleScene, faint, 1);
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

static void texts_are_utf8(void **state) {
    (void)state;
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

static void a_single_star_has_no_second_star(void **state) {
    (void)state;
    const refusal cases[] = {
        {"\"cadence\"", "\"preprocess\": {\"project\": [\"flux_b\"]}, \"cadence\"",
         "preprocess.project: \"flux_b\": the scene has star A only"},
        {"\"offsets_px\": {\"A\": [0, 0]}", "\"separation_arcsec\": 4", "binary: a single star allows offsets_px only"},
        {"\"cadence\"",
         "\"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 40}, "
         "\"cadence\"",
         "signal.star = \"B\": the scene has star A only"},
        {"\"A\": [0, 0]", "\"A\": [0, 0], \"B\": [1, 1]", "binary.offsets_px.B: unknown key"},
    };
    check_refusals(kSingleScene, cases, sizeof cases / sizeof *cases);
}

static void emission_lines_need_no_band(void **state) {
    (void)state;
    const char *const kelvin = "\"kind\": \"blackbody\", \"temperature_k\": 5790";
    const refusal cases[] = {
        {kelvin, "\"kind\": \"lines\", \"wavelength_nm\": [550, 560], \"weight\": [1]",
         "stars.A.spectrum.weight: has 1 numbers: must have 2, one per spectral line"},
        {kelvin, "\"kind\": \"lines\", \"wavelength_nm\": [550, 560], \"weight\": [0, 0]",
         "stars.A.spectrum.weight: all are 0: at least one must be above 0"},
        {kelvin, "\"kind\": \"lines\", \"wavelength_nm\": [550, 560], \"weight\": [0, 1]",
         "band: not allowed: all spectra are lines"},
    };
    check_refusals(kSingleScene, cases, sizeof cases / sizeof *cases);
}

/* An orbit so small that it is a point. */
static void coincident_stars(void **state) {
    (void)state;
    const refusal cases[] = {
        {"\"separation_arcsec\": 4, \"position_angle_deg\": 30",
         "\"date\": 2000, \"orbit\": {\"period_years\": 80, \"semi_major_arcsec\": 5e-324, \"eccentricity\": 0.9,"
         " \"inclination_deg\": 0, \"node_deg\": 0, \"periastron_deg\": 0, \"epoch\": 2000}",
         "binary.orbit: both stars are at the same position: the separation has no direction"},
    };
    check_refusals(kBinaryScene, cases, 1);
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
    free(image);
    free(same);
    toliman_sim_destroy(one);
    toliman_sim_destroy(other);
}

static void equivalent_scenes_give_equal_bytes(void **state) {
    (void)state;
    assert_same_images(kBinaryScene, "\"step_nm\": 12.5", "\"step_nm\": 125E-1");
    assert_same_images(kBinaryScene, "\"step_nm\": 12.5", "\"step_nm\": 0.125e+2");
    assert_same_images(kBinaryScene, "\"amplitude_px\": 1e-3", "\"amplitude_uas\": 200"); /* at 0.2 arcsec per pixel */
    assert_same_images(kSingleScene, "\"aperture_m\"", "\"mask\": {\"kind\": \"clear\"}, \"aperture_m\"");
    const refusal cases[] = {
        {"\"aperture_m\"", "\"mask\": {\"kind\": \"clear\", \"opd_nm\": 1}, \"aperture_m\"",
         "telescope.mask.opd_nm: needs kind \"spiral\" or \"file\""},
        {"\"aperture_m\"", "\"mask\": {\"kind\": \"clear\", \"height_nm\": 1}, \"aperture_m\"",
         "telescope.mask.height_nm: needs kind \"spiral\" or \"file\""},
    };
    check_refusals(kSingleScene, cases, sizeof cases / sizeof *cases);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_of_other_variants),
        cmocka_unit_test(pixels_by_focal_length),
        cmocka_unit_test(fluxes_by_magnitude),
        cmocka_unit_test(values_of_other_kinds),
        cmocka_unit_test(a_single_star_has_no_second_star),
        cmocka_unit_test(emission_lines_need_no_band),
        cmocka_unit_test(coincident_stars),
        cmocka_unit_test(equivalent_scenes_give_equal_bytes),
        cmocka_unit_test(other_impossible_values),
        cmocka_unit_test(texts_are_utf8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
