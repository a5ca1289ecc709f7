/* Tests scenes that must be refused, each with its code and message, and the files that a scene may name. */
#include "scene_files.h"

static void refused(const char *json, size_t size, toliman_status code, const char *field) {
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json(json, size, NULL, NULL, &sim), code, field);
    assert_null(sim);
}

TEST(impossible_values) {
    const refusal changes[] = {
        {"'aperture_m': 0.125", "'aperture_m': -0.125", "telescope.aperture_m"},
        {"'aperture_m': 0.125", "'aperture_m': 0", "telescope.aperture_m"},
        {"'aperture_m': 0.125", "'aperture_m': 'big'", "telescope.aperture_m"},
        {"'aperture_m': 0.125", "'aperture_m': null", "telescope.aperture_m"},
        {"'aperture_m': 0.125,", "", "telescope.aperture_m"},
        {"'secondary_m': 0.01875", "'secondary_m': 0.125", "telescope.secondary_m"},
        {"'secondary_m': 0.01875", "'struts': {'count': 2.5, 'width_m': 0.01}", "telescope.struts.count"},
        {"'secondary_m': 0.01875", "'struts': {'count': 3, 'width_m': 0.125}", "telescope"},
        {"'pupil_samples': 96", "'pupil_samples': 4", "telescope.pupil_samples"},
        {"'pupil_samples': 96", "'pupil_samples': 1e300", "telescope.pupil_samples"},
        {"'pupil_samples': 96", "'pupil_samples': 12", "telescope.pupil_samples"},
        {"'kind': 'spiral'", "'kind': 'spirl'", "telescope.mask.kind"},
        {"'opd_nm': 297.5", "'opd_nm': 297.5, 'height_nm': 10", "telescope.mask.opd_nm"},
        {"'opd_nm': 297.5,", "", "telescope.mask.opd_nm"},
        {"{'a': 0.93, ", "{'b': 0.93, ", "telescope.mask.terms[1].b"},
        {"{'a': 0.93, 'f': 1.829, 'm': 5}", "7", "telescope.mask.terms[1]"},
        {"'aperture_m'", "'amplitude': {}, 'aperture_m'", "telescope.amplitude.file"},
        {"'aperture_m'", "'amplitude': {'file': 0.5}, 'aperture_m'", "telescope.amplitude.file"},
        {"'aperture_m'", "'aberrations': {'opd_file': 1}, 'aperture_m'", "telescope.aberrations.opd_file"},
        {"'aperture_m'", "'aberrations': {'zernike_rms_nm': [5]}, 'aperture_m'",
         "telescope.aberrations.zernike_rms_nm"},
        {"'aperture_m'", "'aberrations': {'zernike_rms_nm': {'4': '5'}}, 'aperture_m'",
         "telescope.aberrations.zernike_rms_nm.4"},
        {"'aperture_m'", "'aberrations': {'zernike_rms_nm': {'4': 2e6}}, 'aperture_m'",
         "telescope.aberrations.zernike_rms_nm.4"},
        {"'max_nm': 600", "'max_nm': 540", "band.max_nm"},
        {"'step_nm': 12.5", "'step_nm': 13", "band.step_nm"},
        {"'step_nm': 12.5", "'step_nm': 1e-9", "band.step_nm"},
        {"'band': {'min_nm': 550, 'max_nm': 600, 'step_nm': 12.5},", "", "band"},
        {"'temperature_k': 5790", "'temperature_k': -5790", "stars.A.spectrum.temperature_k"},
        {"'relative_flux': 3", "'relative_flux': 0", "stars.A.relative_flux"},
        {"'relative_flux': 3", "'relative_flux': 3, 'photons_per_s': 1", "stars.A.relative_flux"},
        {"'relative_flux': 3", "'photons_per_s': 3", "stars"},
        {"'binary': {'separation_arcsec': 4, 'position_angle_deg': 30},", "", "binary"},
        {"'separation_arcsec': 4, 'position_angle_deg': 30", "'offsets_px': {'A': [1, 2], 'B': [1, 2]}",
         "binary.offsets_px"},
        {"'separation_arcsec': 4, 'position_angle_deg': 30", "'offsets_px': {'A': [1, 2, 3], 'B': [1, 2]}",
         "binary.offsets_px.A"},
        {"'amplitude_px': 1e-3", "'amplitude_px': 101", "signal.amplitude_px"},
        {"'amplitude_px': 1e-3", "'amplitude_px': 1e-3, 'amplitude_uas': 1", "signal.amplitude_px"},
        {"'star': 'B'", "'star': 'C'", "signal.star"},
        {"'frames': 100", "'frames': 0", "cadence.frames"},
        {"'frames': 100, ", "", "cadence.frames"},
        {"'peak_photons': 1e5", "'exposure_s': 10", "cadence.exposure_s"},
        {", 'peak_photons': 1e5", "", "cadence.peak_photons"},
        {"'peak_photons': 1e5", "'peak_photons': 1e12", "cadence"},
        {"[64, 64]", "[-64, 64]", "detector.shape[0]"},
        {"[64, 64]", "[64.5, 64]", "detector.shape"},
        {"[64, 64]", "64", "detector.shape"},
        {"'photon': true", "'photon': 1", "noise.photon"},
        {"'seed': 7", "'seed': 1e17", "noise.seed"},
        {"'seed': 7", "'seed': 9007199254740993", "noise.seed"},
        {"'period_days': 40", "'period_days': 1e-300", "signal.period_days"},
        {"'noise'", "'preprocess': {'project': ['flux']}, 'noise'", "preprocess.project"},
        {"'noise'", "'preprocess': {'project': ['flux_a', 'flux_a']}, 'noise'", "preprocess.project"},
        {"toliman-scene/1", "toliman-scene/2", "schema"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
}

/* promise: unknown-keys-are-refused */
TEST(unknown_keys) {
    const refusal changes[] = {
        {"'aperture_m'", "'apertur_m'", "telescope.apertur_m"},
        {"'telescope'", "'Telescope'", "Telescope"},
        {"'separation_arcsec'", "'seperation_arcsec'", "binary.seperation_arcsec"},
        {"'read_e'", "'darkness'", "noise.darkness"},
        {"'detector'", "'stages': [], 'detector'", "stages"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
}

TEST(zernikes_have_an_index) {
    const char *const bad[] = {"0", "232", "04", "+4", "-4", "4 ", "4.0", "0x4", "", "99999999999", "defocus"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char key[80], field[80];
        snprintf(key, sizeof key, "'aberrations': {'zernike_rms_nm': {'%s': 5}}, 'aperture_m'", bad[i]);
        snprintf(field, sizeof field, "telescope.aberrations.zernike_rms_nm.%s", bad[i]);
        const refusal changes[] = {{"'aperture_m'", key, field}};
        CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
    }
}

TEST(unsupported_features) {
    const refusal changes[] = {
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'bin': 2", "detector.bin"},
        {"'noise'", "'systematics': {'jitter_sigma_px': {'rms': 1, 'drift_per_day': 1e-3}}, 'noise'",
         "systematics.jitter_sigma_px"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_UNSUPPORTED, changes);
}

/* The binary scene with its positions from an orbit; one place of the orbital elements replaced. */
static const char *const kElements =
    "{'period_years': 80, 'semi_major_arcsec': 10, 'eccentricity': 0.5, 'inclination_deg': 30,"
    " 'node_deg': 40, 'periastron_deg': 50, 'epoch': 1955}";

TEST(impossible_orbits) {
    const refusal changes[] = {
        {"'date': 2027, ", "", "binary.date"},
        {"'date': 2027", "'date': 1e5", "binary.date"},
        {"'date': 2027", "'date': 2027, 'separation_arcsec': 4", "binary.separation_arcsec"},
        {"'date': 2027", "'date': 2027, 'offsets_px': {'A': [0, 0], 'B': [1, 1]}", "binary.date"},
        {"'date': 2027", "'date': 2027, 'position_angle_deg': 4", "binary.position_angle_deg"},
        {"'date': 2027", "'date': 2027, 'moving': 1", "binary.moving"},
        {kElements, "'beta-cen'", "binary.orbit"},
        {kElements, "7", "binary.orbit"},
        {"'period_years': 80", "'period_years': 0", "binary.orbit.period_years"},
        {"'period_years': 80", "'period_days': 80", "binary.orbit.period_days"},
        {"'eccentricity': 0.5", "'eccentricity': 1", "binary.orbit.eccentricity"},
        {"'inclination_deg': 30", "'inclination_deg': 181", "binary.orbit.inclination_deg"},
        {", 'epoch': 1955", "", "binary.orbit.epoch"},
        {"'semi_major_arcsec': 10", "'semi_major_arcsec': 5000", "binary"},
    };
    char binary[400];
    snprintf(binary, sizeof binary, "'date': 2027, 'orbit': %s", kElements);
    char *const scene = replaced(kBinaryScene, "'separation_arcsec': 4, 'position_angle_deg': 30", binary);
    toliman_sim_destroy(sim_of(scene));
    CHECK_REFUSALS(scene, TOLIMAN_E_SCENE, changes);
    free(scene);
}

TEST(impossible_planets) {
    const refusal changes[] = {
        {", 'mass_sun': 0.9", "", "signal.kind"},
        {", 'distance_pc': 1.33", "", "signal.kind"},
        {"'mass_sun': 0.9", "'mass_sun': 0", "stars.B.mass_sun"},
        {"'distance_pc': 1.33", "'distance_pc': -1", "binary.distance_pc"},
        {"'mass_earth': 1, ", "", "signal.mass_earth"},
        {"'mass_earth': 1", "'mass_earth': -1", "signal.mass_earth"},
        {"'mass_earth': 1, 'semi_major_au': 1", "'mass_earth': 1e4, 'semi_major_au': 1e4", "signal.mass_earth"},
        {"'semi_major_au': 1", "'semi_major_au': 0", "signal.semi_major_au"},
        {"'eccentricity': 0.5", "'eccentricity': 1", "signal.eccentricity"},
        {"'eccentricity': 0.5", "'amplitude_px': 1", "signal.amplitude_px"},
        {"'star': 'B'", "'star': 'C'", "signal.star"},
        {"'kind': 'planet'", "'kind': 'none'", "signal.star"},
        {"'kind': 'planet'", "'kind': 'moon'", "signal.kind"},
    };
    char *scene = EDITED(kBinaryScene, {"5260}}", "5260}, 'mass_sun': 0.9}"},
                         {"'position_angle_deg': 30", "'position_angle_deg': 30, 'distance_pc': 1.33"},
                         {"'kind': 'sinusoid', 'star': 'B', 'amplitude_px': 1e-3, 'period_days': 40",
                          "'kind': 'planet', 'star': 'B', 'mass_earth': 1, 'semi_major_au': 1,"
                          " 'eccentricity': 0.5"});
    toliman_sim_destroy(sim_of(scene));
    CHECK_REFUSALS(scene, TOLIMAN_E_SCENE, changes);
    free(scene);
}

TEST(text_that_is_not_json) {
    const refusal changes[] = {
        {"'aperture_m': 0.125", "'aperture_m': 1e999", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': NaN", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': 00.125", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': .125", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': 1.", "scene"},
        {"'aperture_m': 0.125", "'aperture_m' 0.125", "scene"},
        {"'aperture_m': 0.125,", "\n'aperture_m': 0.125,,", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': 0.125, 'aperture_m': 1", "scene"},
        {"'aperture_m': 0.125", "'aperture_m': 0.125, '\\u0061perture_m': 1", "scene"},
        {"'name': 'binary'", "'name': 'bin\xc0\x80'", "scene"},
        {"'name': 'binary'", "'name': 'bin\xed\xa0\x80'", "scene"},
        {"'name': 'binary'", "'name': 'bin\xf4\x90\x80\x80'", "scene"},
        {"'name': 'binary'", "'name': 'bin\\u0000'", "scene"},
        {"'name': 'binary'", "'name': 'bin\\ud800'", "scene"},
        {"'name': 'binary'", "'name': 'bin\nary'", "scene"},
        {"'name': 'binary'", "'name': [[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]", "scene"},
        {"'seed': 7}}", "'seed': 7}}}", "scene"},
        {"'seed': 7}}", "'seed': 7}", "scene"},
        {"'seed': 7}}", "'seed': 7}} {}", "scene"},
        {"'seed': 7}}", "'seed", "scene"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_FORMAT, changes);
    refused("", 0, TOLIMAN_E_FORMAT, "scene");
    refused("[]", 2, TOLIMAN_E_SCENE, "the scene");
    refused("{}\0{}", 5, TOLIMAN_E_FORMAT, "scene");
    refused("{}", 2, TOLIMAN_E_SCENE, "schema");
    toliman_sim *sim = NULL;
    assert_invalid(toliman_sim_create_json(NULL, 0, NULL, NULL, &sim), "json");
    assert_invalid(toliman_sim_create_json("{}", 2, NULL, NULL, NULL), "out");

    enum { LARGE = 256 * 1024 + 1 };
    char *const large = malloc(LARGE + 2);
    memset(large, ' ', LARGE);
    refused(large, LARGE, TOLIMAN_E_FORMAT, "");
    refused("{}", SIZE_MAX, TOLIMAN_E_FORMAT, "");
    large[0] = '[';
    for (int i = 0; i < 5000; i++)
        memcpy(large + 1 + 2 * i, "1,", 2);
    refused(large, 20000, TOLIMAN_E_FORMAT, "scene");
    memset(large, '[', LARGE);
    refused(large, 200000, TOLIMAN_E_FORMAT, "scene");
    free(large);
}

/* A name becomes a folder name: paths are refused, and no name is truncated. */
TEST(names_are_not_paths) {
    const char *const bad[] = {"../escaped", "/escaped",
                               ".",          "..",
                               ".hidden",    "a/b",
                               "",           "a b",
                               "a\\n",       "\xce\xb1 Cen",
                               "caf\\u00e9", "x0123456789012345678901234567890123456789012345678901234567890123"};
    char name[100];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(name, sizeof name, "'name': '%s'", bad[i]);
        const refusal changes[] = {{"'name': 'binary'", name, "name"}};
        CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
    }
    const char *const longest = "0123456789.ABCDEFGHIJKLMNOPQRSTUVWXYZ_abcdefghijklmnopqrstuvwxy-";
    snprintf(name, sizeof name, "'name': '%s'", longest);
    toliman_sim *const sim = sim_with(kBinaryScene, "'name': 'binary'", name);
    assert_string_equal(sim_info_of(sim).name, longest);
    toliman_sim_destroy(sim);
}

/* Numbers so small that images or bounds would underflow to NaN are refused; the smallest allowed numbers work. */
TEST(extremely_small_numbers) {
    const refusal changes[] = {
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 1e-150", "detector.pixel_scale_arcsec"},
        {"'peak_photons': 1e5", "'peak_photons': 5e-324", "cadence.peak_photons"},
        {"'aperture_m': 0.125", "'aperture_m': 1e-150", "telescope.aperture_m"},
        {"'separation_arcsec': 4", "'separation_arcsec': 1e-322", "binary.separation_arcsec"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
    char *faint =
        EDITED(kSingleScene, {"'peak_photons': 1e6", "'exposure_s': 1e-300"}, {"5790}", "5790}, 'photons_per_s': 1"});
    refused(faint, strlen(faint), TOLIMAN_E_SCENE, "cadence");
    free(faint);
    /* One pixel at the centre of a star: its light does not change to first order. */
    char *still = replaced(kSingleScene, "[32, 32]", "[1, 1]");
    toliman_sim *const silent = sim_of(still);
    assert_true(isinf(sim_bounds_of(silent).crb_px));
    toliman_sim_destroy(silent), free(still);

    const struct {
        const char *from, *to;
    } least[] = {{"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 1e-6"},
                 {"'peak_photons': 1e5", "'peak_photons': 1e-6"},
                 {"'aperture_m': 0.125, 'secondary_m': 0.01875", "'aperture_m': 0.001"},
                 {"'separation_arcsec': 4", "'separation_arcsec': 1e-6"}};
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
    "{'kind': 'spiral', 'edges': 'cell', 'opd_nm': 297.5,   'terms': [{'a': 0.819, 'f': 2.918, "
    "'m': -7, 'p': 4.874}, {'a': 0.93, 'f': 1.829, 'm': 5}]}";

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

TEST(masks_are_read) {
    static double f8[96 * 96];
    static float f4[96 * 96];
    static unsigned char u1[96 * 96];
    for (int i = 0; i < 96 * 96; i++) {
        u1[i] = i % 7 == 3;
        f8[i] = 250e-9 * u1[i];
        f4[i] = 3.14159265f * u1[i];
    }
    write_npy("mask.npy", "|u1", "(96, 96)", u1, sizeof u1);
    check_mask("{'kind': 'file', 'file': 'mask.npy', 'quantity': 'binary', 'opd_nm': 250}", 250e-9);
    check_mask("{'kind': 'file', 'file': 'mask.npy', 'quantity': 'binary', 'height_nm': 100}", 200e-9);
    write_npy("mask.npy", "|b1", "(96, 96)", u1, sizeof u1);
    check_mask("{'kind': 'file', 'file': 'mask.npy', 'quantity': 'binary', 'opd_nm': 250}", 250e-9);
    write_npy("mask.npy", "<f8", "(96, 96)", f8, sizeof f8);
    check_mask("{'kind': 'file', 'file': 'mask.npy', 'quantity': 'opd_m'}", 250e-9);
    write_npy("mask.npy", "<f4", "(96, 96)", f4, sizeof f4);
    check_mask("{'kind': 'file', 'file': 'mask.npy', 'quantity': 'phase_rad', 'reference_nm': 585}", 292.5e-9);
}

TEST(masks_are_refused) {
    static const char *const opd = "{'kind': 'file', 'file': 'mask.npy', 'quantity': 'opd_m'}";
    static const char *const phase =
        "{'kind': 'file', 'file': 'mask.npy', 'quantity': 'phase_rad', 'reference_nm': 585}";
    static const char *const binary = "{'kind': 'file', 'file': 'mask.npy', 'quantity': 'binary', 'opd_nm': 1}";
    static double data[96 * 96];
    const struct {
        const char *mask, *type, *shape;
        size_t size;
        double value; /* of element 100 */
    } cases[] = {
        {opd, "<f8", "(96, 96)", sizeof data - 8, 0}, {opd, "<f8", "(9216,)", sizeof data, 0},
        {opd, "<c8", "(96, 96)", sizeof data, 0},     {opd, "<f8", "(96, 96)", sizeof data, 292.5},  /* nm for m */
        {phase, "<f8", "(96, 96)", sizeof data, 180}, {binary, "<f8", "(96, 96)", sizeof data, 0.5}, /* degrees */
    };
    toliman_sim *sim = NULL;
    unlink(path_of("mask.npy"));
    assert_refused(create_with(kSpiral, opd, &sim), TOLIMAN_E_NOT_FOUND, path_of("mask.npy"));
    write_npy("mask.npy", "<f8", "(48, 96)", data, sizeof data / 2);
    assert_refused(create_with(kSpiral, opd, &sim), TOLIMAN_E_FORMAT, "telescope.mask.file");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        data[100] = cases[i].value;
        write_npy("mask.npy", cases[i].type, cases[i].shape, data, cases[i].size);
        assert_refused(create_with(kSpiral, cases[i].mask, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    }
    data[100] = NAN;
    write_npy("mask.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_fails(create_with(kSpiral, opd, &sim), TOLIMAN_E_FORMAT, "element 100 = nan");
    static const char *const others[] = {"\x93NUMPY\x01", "P5 96 96 255"};
    for (int i = 0; i < 2; i++) {
        write_file("mask.npy", others[i], strlen(others[i]));
        assert_refused(create_with(kSpiral, opd, &sim), TOLIMAN_E_FORMAT, path_of("mask.npy"));
    }
    assert_null(sim);
}

TEST(amplitudes_and_surfaces_are_refused) {
    const char *const from = "'aperture_m'";
    const char *const amplitude = "'amplitude': {'file': 'amplitude.npy'}, 'aperture_m'";
    const char *const surface = "'aberrations': {'opd_file': 'surface.npy'}, 'aperture_m'";
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
TEST(the_band_ends_at_its_limit) {
    char *text =
        EDITED(kSingleScene, {"{'wavelength_nm': 550}", "{'min_nm': 308.9, 'max_nm': 1772.7, 'step_nm': 1463.8}"},
               {"{'kind': 'blackbody', 'temperature_k': 5790}", "{'kind': 'table', 'file': 'star.csv'}"});
    write_file("star.csv", "308.9,1\n1772.7,3\n", 17);
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(text, strlen(text), folder, NULL, &sim));
    double wavelength[2], a[2];
    assert_ok(toliman_sim_get_spectrum(sim, 2, wavelength, a, NULL, NULL));
    assert_true(wavelength[1] == 1772.7 * 1e-9);
    assert_close(a[1] / a[0], 3, 1e-14, 0);
    toliman_sim_destroy(sim), free(text);
}

/* Listed times, in the scene or in a file. */
TEST(times_are_listed) {
    const char *const cadence = "'frames': 100, 'interval_days': 2";
    double times[3];
    for (int i = 0; i < 2; i++) {
        write_file("times.csv", "# days\n0.5\n\n 40.5\r\n-3e1\n", 24);
        char list[200];
        snprintf(list, sizeof list, i == 0 ? "'times_days': [0.5, 40.5, -30]" : "'times_days': '%s'",
                 path_of("times.csv"));
        toliman_sim *const sim = sim_with(kBinaryScene, cadence, list);
        double displacements[3];
        assert_int_equal(sim_info_of(sim).frames, 3);
        assert_ok(toliman_sim_get_series(sim, 0, 3, times, displacements));
        assert_true(times[0] == 0.5 && times[1] == 40.5 && times[2] == -30);
        assert_close(displacements[0], displacements[1], 1e-12, 0); /* one period apart */
        toliman_sim_destroy(sim);
    }
    const refusal changes[] = {
        {cadence, "'times_days': []", "cadence.times_days"},
        {cadence, "'times_days': [1, '2']", "cadence.times_days[1]"},
        {cadence, "'times_days': [1e10]", "cadence.times_days[0]"},
        {cadence, "'times_days': [1, 2], 'frames': 2", "cadence.frames"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, changes);
    const refusal missing[] = {{cadence, "'times_days': 'none.csv'", "./none.csv"}};
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_NOT_FOUND, missing);
    const char *const bad[] = {"1\n2 3\n", "nan\n", "# none\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char list[200];
        write_file("times.csv", bad[i], strlen(bad[i]));
        snprintf(list, sizeof list, "'times_days': '%s'", path_of("times.csv"));
        const refusal file[] = {{cadence, list, path_of("times.csv")}};
        CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_FORMAT, file);
    }
    unlink(path_of("times.csv"));
}

/* Opening a pipe without a writer would block: it is refused. */
TEST(pipes_are_refused) {
    toliman_sim *sim = NULL;
    unlink(path_of("star.csv"));
    assert_int_equal(mkfifo(path_of("star.csv"), 0600), 0);
    alarm(20);
    assert_refused(
        create_with("{'kind': 'blackbody', 'temperature_k': 5260}", "{'kind': 'table', 'file': 'star.csv'}", &sim),
        TOLIMAN_E_NOT_FOUND, path_of("star.csv"));
    assert_refused(toliman_sim_create_file(path_of("star.csv"), NULL, &sim), TOLIMAN_E_NOT_FOUND, path_of("star.csv"));
    alarm(0);
    assert_null(sim);
    unlink(path_of("star.csv"));
}

/* Messages name a scene file as it was given, and its files are found relative to its folder. */
TEST(files_are_found_beside_the_scene) {
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_file(path_of("none.json"), NULL, &sim), TOLIMAN_E_NOT_FOUND,
                   path_of("none.json"));
    assert_refused(toliman_sim_create_file(folder, NULL, &sim), TOLIMAN_E_NOT_FOUND, folder);
    assert_invalid(toliman_sim_create_file(NULL, NULL, &sim), "path");
    char *const bad = replaced(kBinaryScene, "'aperture_m': 0.125", "'aperture_m': -0.125");
    write_file("scene.json", bad, strlen(bad));
    free(bad);
    assert_refused(toliman_sim_create_file(path_of("scene.json"), NULL, &sim), TOLIMAN_E_SCENE, "telescope.aperture_m");
    assert_null(sim);
    char *const good =
        replaced(kBinaryScene, "{'kind': 'blackbody', 'temperature_k': 5260}", "{'kind': 'table', 'file': 'star.csv'}");
    write_file("scene.json", good, strlen(good));
    write_file("star.csv", "500,1\n700,2\n", 12);
    free(good);
    assert_ok(toliman_sim_create_file(path_of("scene.json"), NULL, &sim));
    toliman_sim_destroy(sim);
}

RUN_TESTS(make_folder, remove_folder)
