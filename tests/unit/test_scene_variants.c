/* Groups of a scene that have variants: what is said of a key that stands in the wrong one. */
#include "scene_text.h"

static void keys_of_other_variants(void **state) {
    (void)state;
    const char *const places = "\"separation_arcsec\": 4, \"position_angle_deg\": 30";
    const char *const kelvin = "\"kind\": \"blackbody\", \"temperature_k\": 5790";
    const char *const cases[][3] = {
        {"\"frames\": 100", "\"times_days\": [1, 2]", "scene: cadence.interval_days: not with times_days"},
        {"\"interval_days\": 2", "\"times_days\": [1, 2]", "cadence.frames: not with times_days"},
        {places, "\"separation_arcsec\": 4, \"moving\": true", "scene: binary.moving: needs date and orbit"},
        {places, "\"offsets_px\": {\"A\": [0, 0], \"B\": [9, 1]}, \"centre\": \"A\"",
         "binary.centre: not with offsets_px"},
        {"\"min_nm\": 550", "\"wavelength_nm\": 550", "scene: band.max_nm: not with wavelength_nm"},
        {"\"opd_nm\": 297.5", "\"opd_nm\": 297.5, \"file\": \"x.npy\"", "telescope.mask.file: needs kind \"file\""},
        {"\"kind\": \"spiral\"", "\"kind\": \"clear\"", "telescope.mask.terms: needs kind \"spiral\""},
        {kelvin, "\"kind\": \"lines\", \"temperature_k\": 5790",
         "stars.A.spectrum.temperature_k: needs kind \"blackbody\""},
        {kelvin, "\"kind\": \"blackbody\", \"file\": \"x.csv\"", "stars.A.spectrum.file: needs kind \"table\""},
        {kelvin, "\"kind\": \"blackbody\", \"weight\": [1]", "stars.A.spectrum.weight: needs kind \"lines\""},
        {"\"period_days\": 40", "\"eccentricity\": 0.1", "signal.eccentricity: needs kind \"planet\""},
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_of_other_variants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
