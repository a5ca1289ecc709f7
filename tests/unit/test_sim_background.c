/* Tests uniform light that varies from frame to frame: its amount, its effect on each way to make a frame, refusals. */
#include "scene_text.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, FRAMES = 100 };

static const double kDark = 40;
static const char *const kPlace = "'separation_arcsec': 4, 'position_angle_deg': 30";

/* kBinaryScene without noise, 10 s, with qe, flat field and 40 dark electrons; the stars are placed by `binary`. */
static toliman_sim *simulator(const char *binary, const char *systematics, const char *accuracy) {
    char extra[250];
    snprintf(extra, sizeof extra, "'noise': {'seed': 7}, 'systematics': {%s}, 'accuracy': %s}", systematics, accuracy);
    char *text = EDITED(kBinaryScene, {"'peak_photons': 1e5", "'exposure_s': 10"},
                        {"'relative_flux': 3", "'photons_per_s': 3e7"}, {"5260}}}", "5260}, 'photons_per_s': 1e7}}"},
                        {"[64, 64]", "[64, 64], 'qe': 0.8, 'flat_rms': 0.02, 'dark_e_per_s': 4"},
                        {"'noise': {'photon': true, 'read_e': 2.5, 'seed': 7}}", extra}, {kPlace, binary});
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

/* The photons by which frame k of `sim` exceeds that of `other`, the same in all pixels after the detector's response.
 */
static double background_of(const toliman_sim *sim, const toliman_sim *other, int64_t k) {
    static double frame[PIXELS], without[PIXELS];
    assert_ok(toliman_sim_frame(sim, &(double){0}, 3, k, 1, frame));
    assert_ok(toliman_sim_frame(other, &(double){0}, 3, k, 1, without));
    double *const response = image_of(sim, TOLIMAN_SIM_IMAGE_BACKGROUND);
    const double photons = (frame[0] - without[0]) / response[0];
    for (int i = 0; i < PIXELS; i++)
        assert_close((frame[i] - without[i]) / response[i], photons, 0, 1e-6);
    free(response);
    return photons;
}

/* Interpolated frames of static stars and on an orbit, and a frame that is re-propagated. The other systematics
 * draw the same numbers with and without the background. */
TEST(background_adds_uniform_light) {
    static const char *const cases[][3] = {
        {"'separation_arcsec': 4, 'position_angle_deg': 30", "'flux_rms': 1e-3", "1e-9"},
        {"'date': 2027, 'orbit': 'alpha-cen', 'moving': true", "'flux_rms': 1e-3", "1e-9"},
        {"'separation_arcsec': 4, 'position_angle_deg': 30", "'pointing_rms_px': 1, 'flux_rms': 1e-3", "1e-15"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char both[200];
        snprintf(both, sizeof both, "%s, 'background_rms_photons': {'rms': 0, 'drift_per_day': -0.5}", cases[i][1]);
        toliman_sim *const sim = simulator(cases[i][0], both, cases[i][2]);
        toliman_sim *const other = simulator(cases[i][0], cases[i][1], cases[i][2]);
        assert_close(background_of(sim, other, 0), 0, 0, 0);
        assert_close(background_of(sim, other, 7), -0.5 * 14, 0, 1e-6); /* frames are 2 days apart */
        toliman_sim_destroy(sim), toliman_sim_destroy(other);
    }
}

TEST(rms_and_seed) {
    toliman_sim *const sim = simulator(kPlace, "'background_rms_photons': 6", "1e-12");
    toliman_sim *const other = simulator(kPlace, "", "1e-12");
    double sum = 0, squares = 0;
    for (int64_t k = 0; k < FRAMES; k++) {
        const double photons = background_of(sim, other, k);
        sum += photons;
        squares += photons * photons;
    }
    assert_close(sum / FRAMES, 0, 0, 4 * 6 / sqrt(FRAMES));
    assert_close(squares / FRAMES, 36, 4 * sqrt(2.0 / FRAMES), 0);
    assert_true(kDark > 4 * 6); /* no pixel is clipped at 0 */
    toliman_sim_destroy(sim), toliman_sim_destroy(other);
}

/* Estimators are made for the scene without it. */
TEST(the_reference_does_not_know_it) {
    toliman_sim *const sim = simulator(kPlace, "'background_rms_photons': 6", "1e-12");
    toliman_sim *const other = simulator(kPlace, "", "1e-12");
    const int32_t kinds[] = {TOLIMAN_SIM_IMAGE_BOTH, TOLIMAN_SIM_IMAGE_VARIANCE, TOLIMAN_SIM_IMAGE_SEPARATION};
    for (size_t i = 0; i < 3; i++) {
        double *const with = image_of(sim, kinds[i]), *const without = image_of(other, kinds[i]);
        assert_memory_equal(with, without, PIXELS * sizeof *with);
        free(with), free(without);
    }
    toliman_sim_destroy(sim), toliman_sim_destroy(other);
}

TEST(refusals) {
    const refusal cases[] = {
        {"'noise'", "'systematics': {'background_rms_photons': -1}, 'noise'", "systematics.background_rms_photons"},
        {"'noise'", "'systematics': {'background_rms_photons': '1'}, 'noise'", "systematics.background_rms_photons"},
        {"'noise'", "'systematics': {'background_rms_photons': {'rms': 1, 'drift_per_day': 1e9}}, 'noise'",
         "systematics.background_rms_photons.drift_per_day"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
}

RUN_TESTS(NULL, NULL)
