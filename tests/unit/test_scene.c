/* Tests scenes that must be refused, each with its code and message, and the files that a scene may name. */
#include "scene_files.h"

static void refused(const char *json, size_t size, toliman_status code, const char *message) {
    toliman_sim *sim = NULL;
    assert_fails(toliman_sim_create_json(json, size, NULL, NULL, &sim), code, message);
    assert_null(sim);
}

/* A scene with one place replaced. */
typedef struct {
    const char *from, *to;
    toliman_status code;
    const char *message;
} change;

static void check_changes(const char *scene, const change *changes, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *const text = replaced(scene, changes[i].from, changes[i].to);
        refused(text, strlen(text), changes[i].code, changes[i].message);
        free(text);
    }
}

#define CHECK(changes) check_changes(kBinaryScene, changes, sizeof(changes) / sizeof *(changes))

static void impossible_values(void **state) {
    (void)state;
    const change changes[] = {
        {"\"aperture_m\": 0.125", "\"aperture_m\": -0.125", TOLIMAN_E_SCENE,
         "scene: telescope.aperture_m = -0.125: must be in [0.001, 100] m"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 0", TOLIMAN_E_SCENE, "= 0: must be in [0.001, 100] m"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": \"big\"", TOLIMAN_E_SCENE,
         "telescope.aperture_m = \"big\": must be a number in [0.001, 100] m"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": null", TOLIMAN_E_SCENE, "aperture_m = null: must be a number"},
        {"\"aperture_m\": 0.125,", "", TOLIMAN_E_SCENE, "scene: telescope.aperture_m: is missing"},
        {"\"secondary_m\": 0.01875", "\"secondary_m\": 0.125", TOLIMAN_E_SCENE,
         "telescope.secondary_m = 0.125: must be less than aperture_m = 0.125 m"},
        {"\"secondary_m\": 0.01875", "\"struts\": {\"count\": 2.5, \"width_m\": 0.01}", TOLIMAN_E_SCENE,
         "telescope.struts.count = 2.5: must be a whole number"},
        {"\"secondary_m\": 0.01875", "\"struts\": {\"count\": 3, \"width_m\": 0.125}", TOLIMAN_E_SCENE,
         "leave less than one pupil sample open"},
        {"\"pupil_samples\": 96", "\"pupil_samples\": 4", TOLIMAN_E_SCENE, "must be in [8, 2048] samples"},
        {"\"pupil_samples\": 96", "\"pupil_samples\": 1e300", TOLIMAN_E_SCENE, "= 1e+300: must be in [8, 2048]"},
        {"\"pupil_samples\": 96", "\"pupil_samples\": 12", TOLIMAN_E_SCENE, "or the frame shows aliases"},
        {"\"kind\": \"spiral\"", "\"kind\": \"spirl\"", TOLIMAN_E_SCENE,
         "telescope.mask.kind = \"spirl\": must be one of \"clear\", \"spiral\", \"file\""},
        {"\"opd_nm\": 297.5", "\"opd_nm\": 297.5, \"height_nm\": 10", TOLIMAN_E_SCENE, "either opd_nm or height_nm"},
        {"\"opd_nm\": 297.5,", "", TOLIMAN_E_SCENE, "either opd_nm or height_nm"},
        {"{\"a\": 0.93, ", "{\"b\": 0.93, ", TOLIMAN_E_SCENE, "telescope.mask.terms[1].b: unknown key"},
        {"{\"a\": 0.93, \"f\": 1.829, \"m\": 5}", "7", TOLIMAN_E_SCENE,
         "telescope.mask.terms[1] = 7: must be an object"},
        {"\"aperture_m\"", "\"amplitude\": {}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "scene: telescope.amplitude.file: is missing"},
        {"\"aperture_m\"", "\"amplitude\": {\"file\": 0.5}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "amplitude.file = 0.5: must be a string"},
        {"\"aperture_m\"", "\"aberrations\": {\"opd_file\": 1}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "telescope.aberrations.opd_file = 1: must be a string"},
        {"\"aperture_m\"", "\"aberrations\": {\"zernike_rms_nm\": [5]}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "telescope.aberrations.zernike_rms_nm = an array: must be an object"},
        {"\"aperture_m\"", "\"aberrations\": {\"zernike_rms_nm\": {\"4\": \"5\"}}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "zernike_rms_nm.4 = \"5\": must be a number in [-1000000, 1000000] nm"},
        {"\"aperture_m\"", "\"aberrations\": {\"zernike_rms_nm\": {\"4\": 2e6}}, \"aperture_m\"", TOLIMAN_E_SCENE,
         "telescope.aberrations.zernike_rms_nm.4 = 2000000: must be in [-1000000, 1000000] nm"},
        {"\"max_nm\": 600", "\"max_nm\": 540", TOLIMAN_E_SCENE, "band.max_nm = 540: must be above min_nm = 550 nm"},
        {"\"step_nm\": 12.5", "\"step_nm\": 13", TOLIMAN_E_SCENE, "band.step_nm = 13: must divide the band of 50 nm"},
        {"\"step_nm\": 12.5", "\"step_nm\": 1e-9", TOLIMAN_E_SCENE, "must be at most 4096"},
        {"\"band\": {\"min_nm\": 550, \"max_nm\": 600, \"step_nm\": 12.5},", "", TOLIMAN_E_SCENE, "band: is missing"},
        {"\"temperature_k\": 5790", "\"temperature_k\": -5790", TOLIMAN_E_SCENE,
         "stars.A.spectrum.temperature_k = -5790: must be in [100, 1000000] K"},
        {"\"relative_flux\": 3", "\"relative_flux\": 0", TOLIMAN_E_SCENE, "stars.A.relative_flux = 0: must be in (0,"},
        {"\"relative_flux\": 3", "\"relative_flux\": 3, \"photons_per_s\": 1", TOLIMAN_E_SCENE, "give either"},
        {"\"relative_flux\": 3", "\"photons_per_s\": 3", TOLIMAN_E_SCENE,
         "photons_per_s or magnitude for both stars or neither"},
        {"\"binary\": {\"separation_arcsec\": 4, \"position_angle_deg\": 30},", "", TOLIMAN_E_SCENE,
         "binary: is missing: two stars need their positions"},
        {"\"separation_arcsec\": 4, \"position_angle_deg\": 30", "\"offsets_px\": {\"A\": [1, 2], \"B\": [1, 2]}",
         TOLIMAN_E_SCENE, "the separation has no direction"},
        {"\"separation_arcsec\": 4, \"position_angle_deg\": 30", "\"offsets_px\": {\"A\": [1, 2, 3], \"B\": [1, 2]}",
         TOLIMAN_E_SCENE, "binary.offsets_px.A: has 3 numbers: must have 2 to 2"},
        {"\"amplitude_px\": 1e-3", "\"amplitude_px\": 101", TOLIMAN_E_SCENE,
         "signal.amplitude_px = 101: must be in [0, 100] px"},
        {"\"amplitude_px\": 1e-3", "\"amplitude_px\": 1e-3, \"amplitude_uas\": 1", TOLIMAN_E_SCENE, "give either"},
        {"\"star\": \"B\"", "\"star\": \"C\"", TOLIMAN_E_SCENE, "signal.star = \"C\": must be one of \"A\", \"B\""},
        {"\"frames\": 100", "\"frames\": 0", TOLIMAN_E_SCENE, "cadence.frames = 0: must be in [1, 10000000] frames"},
        {"\"frames\": 100, ", "", TOLIMAN_E_SCENE, "cadence.frames: is missing"},
        {"\"peak_photons\": 1e5", "\"exposure_s\": 10", TOLIMAN_E_SCENE,
         "needs photons_per_s or magnitude for every star"},
        {", \"peak_photons\": 1e5", "", TOLIMAN_E_SCENE, "give either peak_photons or exposure_s"},
        {"\"peak_photons\": 1e5", "\"peak_photons\": 1e12", TOLIMAN_E_SCENE, "must be at most 1e+12"},
        {"[64, 64]", "[-64, 64]", TOLIMAN_E_SCENE, "detector.shape[0] = -64: must be in [1, 2048] px"},
        {"[64, 64]", "[64.5, 64]", TOLIMAN_E_SCENE, "must be whole numbers"},
        {"[64, 64]", "64", TOLIMAN_E_SCENE, "detector.shape = 64: must be an array of numbers"},
        {"\"photon\": true", "\"photon\": 1", TOLIMAN_E_SCENE, "noise.photon = 1: must be true or false"},
        {"\"seed\": 7", "\"seed\": 1e17", TOLIMAN_E_SCENE, "noise.seed = 1e+17: must be in [0,"},
        {"\"seed\": 7", "\"seed\": 9007199254740993", TOLIMAN_E_SCENE, "must be in [0, 9007199254740991]"},
        {"\"period_days\": 40", "\"period_days\": 1e-300", TOLIMAN_E_SCENE,
         "signal.period_days = 1e-300: must be in [1e-06, 1000000000] days"},
        {"\"noise\"", "\"preprocess\": {\"project\": [\"flux\"]}, \"noise\"", TOLIMAN_E_SCENE,
         "\"flux\": must be one of"},
        {"\"noise\"", "\"preprocess\": {\"project\": [\"flux_a\", \"flux_a\"]}, \"noise\"", TOLIMAN_E_SCENE,
         "duplicate \"flux_a\""},
        {"toliman-scene/1", "toliman-scene/2", TOLIMAN_E_SCENE, "must be one of \"toliman-scene/1\""},
    };
    CHECK(changes);
}

static void unknown_keys(void **state) {
    (void)state;
    const change changes[] = {
        {"\"aperture_m\"", "\"apertur_m\"", TOLIMAN_E_SCENE,
         "scene: telescope.apertur_m: unknown key; did you mean \"aperture_m\"?"},
        {"\"telescope\"", "\"Telescope\"", TOLIMAN_E_SCENE, "Telescope: unknown key; did you mean \"telescope\"?"},
        {"\"separation_arcsec\"", "\"seperation_arcsec\"", TOLIMAN_E_SCENE, "did you mean \"separation_arcsec\"?"},
        {"\"read_e\"", "\"darkness\"", TOLIMAN_E_SCENE, "noise.darkness: unknown key"},
        {"\"detector\"", "\"stages\": [], \"detector\"", TOLIMAN_E_SCENE, "stages: unknown key"},
    };
    CHECK(changes);
}

static void zernikes_have_an_index(void **state) {
    (void)state;
    const char *const bad[] = {"0", "232", "04", "+4", "-4", "4 ", "4.0", "0x4", "", "99999999999", "defocus"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char key[80], message[120];
        snprintf(key, sizeof key, "\"aberrations\": {\"zernike_rms_nm\": {\"%s\": 5}}, \"aperture_m\"", bad[i]);
        snprintf(message, sizeof message, "zernike_rms_nm.%s: unknown key; must be a Noll index from 1 to 231", bad[i]);
        const change changes[] = {{"\"aperture_m\"", key, TOLIMAN_E_SCENE, message}};
        CHECK(changes);
    }
}

static void unsupported_features(void **state) {
    (void)state;
    const change changes[] = {
        {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.2, \"bin\": 2", TOLIMAN_E_UNSUPPORTED,
         "detector.bin: not supported yet"},
        {"\"noise\"", "\"systematics\": {\"jitter_sigma_px\": {\"rms\": 1, \"drift_per_day\": 1e-3}}, \"noise\"",
         TOLIMAN_E_UNSUPPORTED,
         "systematics.jitter_sigma_px.drift_per_day = 0.001: must be 0: the blur is the same in all frames"},
    };
    CHECK(changes);
}

/* The binary scene with its positions from an orbit; one place of the orbital elements replaced. */
static const char *const kElements =
    "{\"period_years\": 80, \"semi_major_arcsec\": 10, \"eccentricity\": 0.5, \"inclination_deg\": 30,"
    " \"node_deg\": 40, \"periastron_deg\": 50, \"epoch\": 1955}";

static void impossible_orbits(void **state) {
    (void)state;
    const change changes[] = {
        {"\"date\": 2027, ", "", TOLIMAN_E_SCENE, "scene: binary.date: is missing"},
        {"\"date\": 2027", "\"date\": 1e5", TOLIMAN_E_SCENE, "binary.date = 100000: must be in [-10000, 10000] years"},
        {"\"date\": 2027", "\"date\": 2027, \"separation_arcsec\": 4", TOLIMAN_E_SCENE,
         "binary.separation_arcsec: not allowed with date and orbit"},
        {"\"date\": 2027", "\"date\": 2027, \"offsets_px\": {\"A\": [0, 0], \"B\": [1, 1]}", TOLIMAN_E_SCENE,
         "binary.date: not allowed with offsets_px"},
        {"\"date\": 2027", "\"date\": 2027, \"position_angle_deg\": 4", TOLIMAN_E_SCENE,
         "binary.position_angle_deg: not allowed with date and orbit"},
        {"\"date\": 2027", "\"date\": 2027, \"moving\": 1", TOLIMAN_E_SCENE, "moving = 1: must be true or false"},
        {kElements, "\"beta-cen\"", TOLIMAN_E_SCENE, "binary.orbit = \"beta-cen\": must be one of \"alpha-cen\""},
        {kElements, "7", TOLIMAN_E_SCENE, "binary.orbit = 7: must be a string"},
        {"\"period_years\": 80", "\"period_years\": 0", TOLIMAN_E_SCENE,
         "binary.orbit.period_years = 0: must be in (0, 1000000] years"},
        {"\"period_years\": 80", "\"period_days\": 80", TOLIMAN_E_SCENE,
         "binary.orbit.period_days: unknown key; did you mean \"period_years\"?"},
        {"\"eccentricity\": 0.5", "\"eccentricity\": 1", TOLIMAN_E_SCENE,
         "binary.orbit.eccentricity = 1: must be in [0, 0.9999]"},
        {"\"inclination_deg\": 30", "\"inclination_deg\": 181", TOLIMAN_E_SCENE,
         "inclination_deg = 181: must be in [0, 180] deg"},
        {", \"epoch\": 1955", "", TOLIMAN_E_SCENE, "binary.orbit.epoch: is missing"},
        {"\"semi_major_arcsec\": 10", "\"semi_major_arcsec\": 5000", TOLIMAN_E_SCENE,
         "binary: star B is outside the frame of 64 x 64 by 13373 px: must be at most 4583 px, or "},
    };
    char binary[400];
    snprintf(binary, sizeof binary, "\"date\": 2027, \"orbit\": %s", kElements);
    char *const scene = replaced(kBinaryScene, "\"separation_arcsec\": 4, \"position_angle_deg\": 30", binary);
    toliman_sim_destroy(sim_of(scene));
    check_changes(scene, changes, sizeof changes / sizeof *changes);
    free(scene);
}

static void impossible_planets(void **state) {
    (void)state;
    const change changes[] = {
        {", \"mass_sun\": 0.9", "", TOLIMAN_E_SCENE, "scene: signal.kind = \"planet\": needs stars.B.mass_sun"},
        {", \"distance_pc\": 1.33", "", TOLIMAN_E_SCENE, "signal.kind = \"planet\": needs binary.distance_pc"},
        {"\"mass_sun\": 0.9", "\"mass_sun\": 0", TOLIMAN_E_SCENE,
         "stars.B.mass_sun = 0: must be in (0, 1000] solar masses"},
        {"\"distance_pc\": 1.33", "\"distance_pc\": -1", TOLIMAN_E_SCENE,
         "binary.distance_pc = -1: must be in (0, 1000000] pc"},
        {"\"mass_earth\": 1, ", "", TOLIMAN_E_SCENE, "signal.mass_earth: is missing"},
        {"\"mass_earth\": 1", "\"mass_earth\": -1", TOLIMAN_E_SCENE,
         "signal.mass_earth = -1: must be in [0, 1000000] Earth masses"},
        {"\"mass_earth\": 1, \"semi_major_au\": 1", "\"mass_earth\": 1e4, \"semi_major_au\": 1e4", TOLIMAN_E_SCENE,
         "signal.mass_earth = 10000: moves star B by up to 1.82e+03 px: must be at most 100 px"},
        {"\"semi_major_au\": 1", "\"semi_major_au\": 0", TOLIMAN_E_SCENE, "must be in [1e-06, 10000] au"},
        {"\"eccentricity\": 0.5", "\"eccentricity\": 1", TOLIMAN_E_SCENE,
         "signal.eccentricity = 1: must be in [0, 0.9999]"},
        {"\"eccentricity\": 0.5", "\"amplitude_px\": 1", TOLIMAN_E_SCENE,
         "signal.amplitude_px: needs kind \"sinusoid\""},
        {"\"star\": \"B\"", "\"star\": \"C\"", TOLIMAN_E_SCENE, "signal.star = \"C\": must be one of"},
        {"\"kind\": \"planet\"", "\"kind\": \"none\"", TOLIMAN_E_SCENE, "signal.star: needs a signal"},
        {"\"kind\": \"planet\"", "\"kind\": \"moon\"", TOLIMAN_E_SCENE,
         "signal.kind = \"moon\": must be one of \"none\", \"sinusoid\", \"planet\""},
    };
    char *scene = replaced(kBinaryScene, "5260}}", "5260}, \"mass_sun\": 0.9}");
    scene = replaced_again(scene, "\"position_angle_deg\": 30", "\"position_angle_deg\": 30, \"distance_pc\": 1.33");
    scene =
        replaced_again(scene, "\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 40",
                       "\"kind\": \"planet\", \"star\": \"B\", \"mass_earth\": 1, \"semi_major_au\": 1,"
                       " \"eccentricity\": 0.5");
    toliman_sim_destroy(sim_of(scene));
    check_changes(scene, changes, sizeof changes / sizeof *changes);
    free(scene);
}

static void text_that_is_not_json(void **state) {
    (void)state;
    const change changes[] = {
        {"\"aperture_m\": 0.125", "\"aperture_m\": 1e999", TOLIMAN_E_FORMAT, "outside the range of double"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": NaN", TOLIMAN_E_FORMAT, "unexpected character"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 00.125", TOLIMAN_E_FORMAT, "number with a leading zero"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": .125", TOLIMAN_E_FORMAT, "unexpected character"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 1.", TOLIMAN_E_FORMAT, "expected a digit"},
        {"\"aperture_m\": 0.125", "\"aperture_m\" 0.125", TOLIMAN_E_FORMAT, "JSON syntax error"},
        {"\"aperture_m\": 0.125,", "\n\"aperture_m\": 0.125,,", TOLIMAN_E_FORMAT, "scene: line 2, column 22: JSON"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 0.125, \"aperture_m\": 1", TOLIMAN_E_FORMAT,
         "duplicate key \"aperture_m\""},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 0.125, \"\\u0061perture_m\": 1", TOLIMAN_E_FORMAT, "duplicate key"},
        {"\"name\": \"binary\"", "\"name\": \"bin\xc0\x80\"", TOLIMAN_E_FORMAT, "invalid UTF-8"},
        {"\"name\": \"binary\"", "\"name\": \"bin\xed\xa0\x80\"", TOLIMAN_E_FORMAT, "invalid UTF-8"},
        {"\"name\": \"binary\"", "\"name\": \"bin\xf4\x90\x80\x80\"", TOLIMAN_E_FORMAT, "invalid UTF-8"},
        {"\"name\": \"binary\"", "\"name\": \"bin\\u0000\"", TOLIMAN_E_FORMAT, "U+0000"},
        {"\"name\": \"binary\"", "\"name\": \"bin\\ud800\"", TOLIMAN_E_FORMAT, "JSON syntax error"},
        {"\"name\": \"binary\"", "\"name\": \"bin\nary\"", TOLIMAN_E_FORMAT, "control character"},
        {"\"name\": \"binary\"", "\"name\": [[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]", TOLIMAN_E_FORMAT,
         "nested deeper than 16 levels"},
        {"\"seed\": 7}}", "\"seed\": 7}}}", TOLIMAN_E_FORMAT, "closing bracket without an opening one"},
        {"\"seed\": 7}}", "\"seed\": 7}", TOLIMAN_E_FORMAT, "JSON syntax error"},
        {"\"seed\": 7}}", "\"seed\": 7}} {}", TOLIMAN_E_FORMAT, "JSON syntax error"},
        {"\"seed\": 7}}", "\"seed", TOLIMAN_E_FORMAT, "unterminated string"},
    };
    CHECK(changes);
    refused("", 0, TOLIMAN_E_FORMAT, "scene: is empty");
    refused("[]", 2, TOLIMAN_E_SCENE, "the scene = an array: must be an object");
    refused("{}\0{}", 5, TOLIMAN_E_FORMAT, "line 1, column 3: unexpected zero byte");
    refused("{}", 2, TOLIMAN_E_SCENE, "schema: is missing");
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json(NULL, 0, NULL, NULL, &sim), TOLIMAN_E_ARGUMENT, "json");
    assert_refused(toliman_sim_create_json("{}", 2, NULL, NULL, NULL), TOLIMAN_E_ARGUMENT, "out");

    enum { LARGE = 256 * 1024 + 1 };
    char *const large = malloc(LARGE + 2);
    memset(large, ' ', LARGE);
    refused(large, LARGE, TOLIMAN_E_FORMAT, "must be at most 262144");
    refused("{}", SIZE_MAX, TOLIMAN_E_FORMAT, "18446744073709551615 bytes: must be at most 262144");
    large[0] = '[';
    for (int i = 0; i < 5000; i++)
        memcpy(large + 1 + 2 * i, "1,", 2);
    refused(large, 20000, TOLIMAN_E_FORMAT, "more than 4096 values");
    memset(large, '[', LARGE);
    refused(large, 200000, TOLIMAN_E_FORMAT, "nested deeper than 16 levels");
    free(large);
}

/* A name becomes a folder name: paths are refused, and no name is truncated. */
static void names_are_not_paths(void **state) {
    (void)state;
    const char *const rule = "must be 1 to 64 of A-Z a-z 0-9 . _ - and not begin with a dot";
    const char *const bad[] = {"../escaped", "/escaped",
                               ".",          "..",
                               ".hidden",    "a/b",
                               "",           "a b",
                               "a\\n",       "\xce\xb1 Cen",
                               "caf\\u00e9", "x0123456789012345678901234567890123456789012345678901234567890123"};
    char name[100];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(name, sizeof name, "\"name\": \"%s\"", bad[i]);
        const change changes[] = {{"\"name\": \"binary\"", name, TOLIMAN_E_SCENE, rule}};
        CHECK(changes);
    }
    const char *const longest = "0123456789.ABCDEFGHIJKLMNOPQRSTUVWXYZ_abcdefghijklmnopqrstuvwxy-";
    snprintf(name, sizeof name, "\"name\": \"%s\"", longest);
    toliman_sim *const sim = sim_with(kBinaryScene, "\"name\": \"binary\"", name);
    assert_string_equal(sim_info_of(sim).name, longest);
    toliman_sim_destroy(sim);
}

/* Numbers so small that images or bounds would underflow to NaN are refused; the smallest allowed numbers work. */
static void extremely_small_numbers(void **state) {
    (void)state;
    const change changes[] = {
        {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 1e-150", TOLIMAN_E_SCENE,
         "detector.pixel_scale_arcsec = 1e-150: must be in [1e-06, 100] arcsec"},
        {"\"peak_photons\": 1e5", "\"peak_photons\": 5e-324", TOLIMAN_E_SCENE, "must be in [1e-06, 1e+12] photons"},
        {"\"aperture_m\": 0.125", "\"aperture_m\": 1e-150", TOLIMAN_E_SCENE, "must be in [0.001, 100] m"},
        {"\"separation_arcsec\": 4", "\"separation_arcsec\": 1e-322", TOLIMAN_E_SCENE,
         "must be in [1e-06, 100000] arcsec"},
    };
    CHECK(changes);
    char *faint = replaced(kSingleScene, "\"peak_photons\": 1e6", "\"exposure_s\": 1e-300");
    faint = replaced_again(faint, "5790}", "5790}, \"photons_per_s\": 1");
    refused(faint, strlen(faint), TOLIMAN_E_SCENE, "must be at least 1e-06");
    free(faint);
    /* One pixel at the centre of a star: its light does not change to first order. */
    char *still = replaced(kSingleScene, "[32, 32]", "[1, 1]");
    toliman_sim *const silent = sim_of(still);
    assert_true(isinf(sim_bounds_of(silent).crb_px));
    toliman_sim_destroy(silent);
    free(still);

    const struct {
        const char *from, *to;
    } least[] = {{"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 1e-6"},
                 {"\"peak_photons\": 1e5", "\"peak_photons\": 1e-6"},
                 {"\"aperture_m\": 0.125, \"secondary_m\": 0.01875", "\"aperture_m\": 0.001"},
                 {"\"separation_arcsec\": 4", "\"separation_arcsec\": 1e-6"}};
    for (size_t i = 0; i < sizeof least / sizeof *least; i++) {
        toliman_sim *const sim = sim_with(kBinaryScene, least[i].from, least[i].to);
        const toliman_sim_bounds bounds = sim_bounds_of(sim);
        assert_true(bounds.crb_px > 0 && isfinite(bounds.crb_px) && isfinite(bounds.truncation));
        for (int32_t kind = TOLIMAN_SIM_IMAGE_BOTH; kind <= TOLIMAN_SIM_IMAGE_VARIANCE; kind++) {
            double *const image = image_of(sim, kind);
            for (int k = 0; k < 64 * 64; k++)
                assert_true(isfinite(image[k]));
            free(image);
        }
        toliman_sim_destroy(sim);
    }
}

static const char *const kSpiral =
    "{\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,   \"terms\": [{\"a\": 0.819, \"f\": 2.918, "
    "\"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}]}";

/* The mask's OPD sampled on the pupil, compared with expected[i] = scale * pattern(i). */
static void check_mask(const char *mask, double scale) {
    toliman_sim *sim = NULL;
    static double opd[96 * 96];
    assert_ok(create_with(kSpiral, mask, &sim));
    assert_ok(toliman_sim_get_pupil(sim, NULL, opd));
    for (int i = 0; i < 96 * 96; i++)
        assert_close(opd[i], i % 7 == 3 ? scale : 0, 1e-6, 0);
    toliman_sim_destroy(sim);
}

static void masks_are_read(void **state) {
    (void)state;
    static double f8[96 * 96];
    static float f4[96 * 96];
    static unsigned char u1[96 * 96];
    for (int i = 0; i < 96 * 96; i++) {
        u1[i] = i % 7 == 3;
        f8[i] = 250e-9 * u1[i];
        f4[i] = 3.14159265f * u1[i];
    }
    write_npy("mask.npy", "|u1", "(96, 96)", u1, sizeof u1);
    check_mask("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"opd_nm\": 250}", 250e-9);
    check_mask("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"height_nm\": 100}", 200e-9);
    write_npy("mask.npy", "|b1", "(96, 96)", u1, sizeof u1);
    check_mask("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"opd_nm\": 250}", 250e-9);
    write_npy("mask.npy", "<f8", "(96, 96)", f8, sizeof f8);
    check_mask("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"opd_m\"}", 250e-9);
    write_npy("mask.npy", "<f4", "(96, 96)", f4, sizeof f4);
    check_mask("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"phase_rad\", \"reference_nm\": 585}",
               292.5e-9);
}

static void masks_are_refused(void **state) {
    (void)state;
    const char *const mask = "{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"opd_m\"}";
    const char *const binary = "{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"opd_nm\": 1}";
    static double data[96 * 96];
    toliman_sim *sim = NULL;
    unlink(path_of("mask.npy"));
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_NOT_FOUND, path_of("mask.npy"));
    write_npy("mask.npy", "<f8", "(48, 96)", data, sizeof data / 2);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, "telescope.mask.file");
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data - 8);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    write_npy("mask.npy", "<f8", "(9216,)", data, sizeof data);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    write_npy("mask.npy", "<c8", "(96, 96)", data, sizeof data);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    write_file("mask.npy", "\x93NUMPY\x01", 7);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    write_file("mask.npy", "P5 96 96 255", 12);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    data[100] = NAN;
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_fails(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, "element 100 = nan: must be in [-0.001, 0.001] m");
    data[100] = 292.5; /* nm for m */
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_refused(create_with(kSpiral, mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    data[100] = 180; /* degrees */
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_refused(create_with(kSpiral,
                               "{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"phase_rad\","
                               " \"reference_nm\": 585}",
                               &sim),
                   TOLIMAN_E_FORMAT, path_of("mask.npy"));
    data[100] = 0.5;
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_refused(create_with(kSpiral, binary, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    assert_null(sim);
}

static void amplitudes_and_surfaces_are_refused(void **state) {
    (void)state;
    const char *const from = "\"aperture_m\"";
    const char *const amplitude = "\"amplitude\": {\"file\": \"amplitude.npy\"}, \"aperture_m\"";
    const char *const surface = "\"aberrations\": {\"opd_file\": \"surface.npy\"}, \"aperture_m\"";
    static double data[96 * 96];
    toliman_sim *sim = NULL;
    assert_refused(create_with(from, amplitude, &sim), TOLIMAN_E_NOT_FOUND, path_of("amplitude.npy"));
    assert_refused(create_with(from, surface, &sim), TOLIMAN_E_NOT_FOUND, path_of("surface.npy"));
    write_npy("amplitude.npy", "<f8", "(48, 96)", data, sizeof data / 2);
    assert_refused(create_with(from, amplitude, &sim), TOLIMAN_E_FORMAT, "telescope.amplitude.file");
    write_npy("surface.npy", "<f8", "(48, 48)", data, sizeof data / 4);
    assert_refused(create_with(from, surface, &sim), TOLIMAN_E_FORMAT, "telescope.aberrations.opd_file");
    write_npy("amplitude.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_refused(create_with(from, amplitude, &sim), TOLIMAN_E_SCENE, "telescope.amplitude.file");
    const double bad[] = {NAN, INFINITY, -INFINITY, -1e-9, 1.0000001};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        data[4000] = bad[i];
        write_npy("amplitude.npy", "<f8", "(96, 96)", data, sizeof data);
        assert_refused(create_with(from, amplitude, &sim), TOLIMAN_E_FORMAT, path_of("amplitude.npy"));
        assert_non_null(strstr(toliman_last_error(), "must be in [0, 1]"));
        data[4000] *= 5; /* nanometres given as metres */
        write_npy("surface.npy", "<f8", "(96, 96)", data, sizeof data);
        if (i != 3)
            assert_refused(create_with(from, surface, &sim), TOLIMAN_E_FORMAT, path_of("surface.npy"));
    }
    assert_null(sim);
}

/* 308.9 + (1772.7 - 308.9) rounds above 1772.7: the last sample must be the end of band and table. */
static void the_band_ends_at_its_limit(void **state) {
    (void)state;
    char *text = replaced(kSingleScene, "{\"wavelength_nm\": 550}",
                          "{\"min_nm\": 308.9, \"max_nm\": 1772.7, \"step_nm\": 1463.8}");
    text = replaced_again(text, "{\"kind\": \"blackbody\", \"temperature_k\": 5790}",
                          "{\"kind\": \"table\", \"file\": \"star.csv\"}");
    write_file("star.csv", "308.9,1\n1772.7,3\n", 17);
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(text, strlen(text), folder, NULL, &sim));
    double wavelength[2], a[2];
    assert_ok(toliman_sim_get_spectrum(sim, 2, wavelength, a, NULL, NULL));
    assert_true(wavelength[1] == 1772.7 * 1e-9);
    assert_close(a[1] / a[0], 3, 1e-14, 0);
    toliman_sim_destroy(sim);
    free(text);
}

/* Listed times, in the scene or in a file. */
static void times_are_listed(void **state) {
    (void)state;
    const char *const cadence = "\"frames\": 100, \"interval_days\": 2";
    double times[3];
    for (int i = 0; i < 2; i++) {
        write_file("times.csv", "# days\n0.5\n\n 40.5\r\n-3e1\n", 24);
        char list[200];
        snprintf(list, sizeof list, i == 0 ? "\"times_days\": [0.5, 40.5, -30]" : "\"times_days\": \"%s\"",
                 path_of("times.csv"));
        toliman_sim *const sim = sim_with(kBinaryScene, cadence, list);
        double displacements[3];
        assert_int_equal(sim_info_of(sim).frames, 3);
        assert_ok(toliman_sim_get_series(sim, 0, 3, times, displacements));
        assert_true(times[0] == 0.5 && times[1] == 40.5 && times[2] == -30);
        assert_close(displacements[0], displacements[1], 1e-12, 0); /* one period apart */
        toliman_sim_destroy(sim);
    }
    const change changes[] = {
        {cadence, "\"times_days\": []", TOLIMAN_E_SCENE, "cadence.times_days"},
        {cadence, "\"times_days\": [1, \"2\"]", TOLIMAN_E_SCENE, "cadence.times_days"},
        {cadence, "\"times_days\": [1e10]", TOLIMAN_E_SCENE, "days"},
        {cadence, "\"times_days\": [1, 2], \"frames\": 2", TOLIMAN_E_SCENE, "cadence.frames: not allowed with"},
        {cadence, "\"times_days\": \"none.csv\"", TOLIMAN_E_NOT_FOUND, "none.csv"},
    };
    CHECK(changes);
    const struct {
        const char *text, *message;
    } bad[] = {{"1\n2 3\n", "times.csv:2: \"2 3\": must be a number"},
               {"nan\n", "times.csv:1: \"nan\": must be a number"},
               {"# none\n", "contains 0 times"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char list[200];
        write_file("times.csv", bad[i].text, strlen(bad[i].text));
        snprintf(list, sizeof list, "\"times_days\": \"%s\"", path_of("times.csv"));
        const change file[] = {{cadence, list, TOLIMAN_E_FORMAT, bad[i].message}};
        CHECK(file);
    }
    unlink(path_of("times.csv"));
}

/* Opening a pipe without a writer would block: it is refused. */
static void pipes_are_refused(void **state) {
    (void)state;
    toliman_sim *sim = NULL;
    unlink(path_of("star.csv"));
    assert_int_equal(mkfifo(path_of("star.csv"), 0600), 0);
    alarm(20);
    assert_refused(create_with("{\"kind\": \"blackbody\", \"temperature_k\": 5260}",
                               "{\"kind\": \"table\", \"file\": \"star.csv\"}", &sim),
                   TOLIMAN_E_NOT_FOUND, path_of("star.csv"));
    assert_refused(toliman_sim_create_file(path_of("star.csv"), NULL, &sim), TOLIMAN_E_NOT_FOUND, path_of("star.csv"));
    alarm(0);
    assert_null(sim);
    unlink(path_of("star.csv"));
}

/* Messages name a scene file as it was given, and its files are found relative to its folder. */
static void files_are_found_beside_the_scene(void **state) {
    (void)state;
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_file(path_of("none.json"), NULL, &sim), TOLIMAN_E_NOT_FOUND,
                   path_of("none.json"));
    assert_refused(toliman_sim_create_file(folder, NULL, &sim), TOLIMAN_E_NOT_FOUND, folder);
    assert_refused(toliman_sim_create_file(NULL, NULL, &sim), TOLIMAN_E_ARGUMENT, "path");
    char *const bad = replaced(kBinaryScene, "\"aperture_m\": 0.125", "\"aperture_m\": -0.125");
    write_file("scene.json", bad, strlen(bad));
    free(bad);
    assert_refused(toliman_sim_create_file(path_of("scene.json"), NULL, &sim), TOLIMAN_E_SCENE, "telescope.aperture_m");
    assert_null(sim);
    char *const good = replaced(kBinaryScene, "{\"kind\": \"blackbody\", \"temperature_k\": 5260}",
                                "{\"kind\": \"table\", \"file\": \"star.csv\"}");
    write_file("scene.json", good, strlen(good));
    write_file("star.csv", "500,1\n700,2\n", 12);
    free(good);
    assert_ok(toliman_sim_create_file(path_of("scene.json"), NULL, &sim));
    toliman_sim_destroy(sim);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impossible_values),          cmocka_unit_test(unknown_keys),
        cmocka_unit_test(zernikes_have_an_index),     cmocka_unit_test(unsupported_features),
        cmocka_unit_test(impossible_orbits),          cmocka_unit_test(impossible_planets),
        cmocka_unit_test(text_that_is_not_json),      cmocka_unit_test(names_are_not_paths),
        cmocka_unit_test(extremely_small_numbers),    cmocka_unit_test(masks_are_read),
        cmocka_unit_test(masks_are_refused),          cmocka_unit_test(amplitudes_and_surfaces_are_refused),

        cmocka_unit_test(the_band_ends_at_its_limit), cmocka_unit_test(times_are_listed),
        cmocka_unit_test(pipes_are_refused),          cmocka_unit_test(files_are_found_beside_the_scene),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
