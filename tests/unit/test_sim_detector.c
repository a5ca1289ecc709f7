/* Tests the stages of the detector: each stage alone against its mean, variance and arithmetic, and all stages
 * together. */
#include <stdio.h>

#include <toliman/cae.h>
#include <toliman/linear.h>

#include "frame_statistics.h"
#include "images.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

/* The two stars observed for 10 s; `stages` is added to the detector, `noise` to the noise. */
static char *text_with(const char *stages, const char *noise) {
    char text[400];
    char *scene = EDITED(kBinaryScene, {"'peak_photons': 1e5", "'exposure_s': 10"},
                         {"'relative_flux': 3", "'photons_per_s': 3e5"}, {"5260}}}", "5260}, 'photons_per_s': 1e5}}"});
    snprintf(text, sizeof text, "'pixel_scale_arcsec': 0.2%s%s", stages[0] != '\0' ? ", " : "", stages);
    scene = replaced_again(scene, "'pixel_scale_arcsec': 0.2", text);
    snprintf(text, sizeof text, "{%s}", noise);
    return replaced_again(scene, "{'photon': true, 'read_e': 2.5, 'seed': 7}", text);
}

static char heard[2000];

static void record_log(int32_t level, const char *text, void *user_data) {
    (void)user_data;
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    strncat(heard, text, sizeof heard - strlen(heard) - 2);
    strcat(heard, "\n");
}

static toliman_sim *make(const char *stages, const char *noise) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.log = record_log;
    heard[0] = '\0';
    char *const text = text_with(stages, noise);
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
    free(text);
    return sim;
}

static const char *const kNoise = "'photon': true, 'read_e': 2.5, 'seed': 7", *const kPhotons = "'photon': true";

/* A frame; the caller frees it. */
static double *frame(const char *stages, const char *noise) {
    toliman_sim *const sim = make(stages, noise);
    double *const image = malloc(PIXELS * sizeof *image);
    assert_non_null(image);
    assert_ok(toliman_sim_frame(sim, &(double){1e-3}, 3, 5, 1, image));
    toliman_sim_destroy(sim);
    return image;
}

static double *image_with(const char *stages, const char *noise, int32_t kind) {
    toliman_sim *const sim = make(stages, noise);
    double *const image = image_of(sim, kind);
    toliman_sim_destroy(sim);
    return image;
}

/* Frames with the stages must have the mean factor * bare + offset in units of `unit`, and the variance that follows
 * from it plus `added`. */
static void check_stage(const char *stages, const char *noise, double factor, double offset, double added, double unit,
                        int whole) {
    toliman_sim *const sim = make(stages, noise);
    double *const bare = image_with("", "", TOLIMAN_SIM_IMAGE_BOTH), *const slope = image_with(
                                                                         "", "", TOLIMAN_SIM_IMAGE_SEPARATION);
    double *const mean = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH), *const variance =
                                                                    image_of(sim, TOLIMAN_SIM_IMAGE_VARIANCE);
    double *const moved = image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION);
    for (size_t i = 0; i < PIXELS; i++) {
        const double expected = factor * bare[i] + offset;
        assert_close(mean[i], expected / unit, 1e-14, 0);
        assert_close(moved[i], factor * slope[i] / unit, 1e-14, 0);
        assert_close(variance[i], (expected + added) / unit / unit, 1e-13, 0);
    }
    check_frames(sim, mean, variance, 0.5, whole);
    assert_int_equal(sim_info_of(sim).whole_counts, whole);
    free(bare), free(slope), free(mean), free(variance), free(moved), toliman_sim_destroy(sim);
}

TEST(stages_have_their_mean_and_variance) {
    check_stage("", kPhotons, 1, 0, 0, 1, 1);
    check_stage("'qe': 0.6", kPhotons, 0.6, 0, 0, 1, 1);
    check_stage("'dark_e_per_s': 4", kPhotons, 1, 40, 0, 1, 1);
    check_stage("'coadds': 9", kNoise, 1, 0, 9 * 6.25, 1, 0);
    check_stage("'gain_e_per_dn': 1.7", kNoise, 1, 0, 6.25, 1.7, 0);
    check_stage("'full_well_e': 1e6, 'coadds': 2", kPhotons, 1, 0, 0, 1, 1);
    /* The rounding error of a value with noise of many steps is uniformly distributed. */
    check_stage("'qe': 0.5, 'dark_e_per_s': 60, 'gain_e_per_dn': 8, 'bit_depth': 20", kNoise, 0.5, 600,
                6.25 + 64.0 / 12, 8, 1);
}

/* Photons are counted before the detector, counts after it. */
TEST(info_distinguishes_photons_from_counts) {
    toliman_sim *const bare = make("", kPhotons), *const sim = make("'qe': 0.25", kPhotons);
    const toliman_sim_info less = sim_info_of(sim), info = sim_info_of(bare);
    assert_close(less.peak_photons, info.peak_photons, 0, 0);
    assert_close(less.total_photons, info.total_photons, 0, 0);
    assert_close(less.peak_counts, 0.25 * info.peak_photons, 1e-15, 0);
    assert_close(info.peak_counts, info.peak_photons, 0, 0);
    const double crb_px = sim_bounds_of(sim).crb_px;
    assert_close(crb_px, 2 * sim_bounds_of(bare).crb_px, 1e-12, 0); /* a quarter of the photons */
    toliman_sim_destroy(bare), toliman_sim_destroy(sim);
    toliman_sim *const units = make("'qe': 0.25, 'gain_e_per_dn': 7, 'bias_dn': 50", kPhotons);
    const toliman_sim_info dn = sim_info_of(units);
    assert_close(dn.peak_counts, less.peak_counts / 7 + 50, 1e-15, 0);
    assert_close(sim_bounds_of(units).crb_px, crb_px, 1e-12, 0); /* a unit carries no information */
    assert_int_equal(dn.whole_counts, 0);
    assert_int_equal(info.unit, TOLIMAN_SIM_UNIT_PHOTON);
    assert_int_equal(less.unit, TOLIMAN_SIM_UNIT_ELECTRON);
    assert_int_equal(dn.unit, TOLIMAN_SIM_UNIT_DN);
    toliman_sim *const fractional = make("'full_well_e': 1000.5", kPhotons);
    assert_int_equal(sim_info_of(fractional).whole_counts, 0);
    toliman_sim_destroy(fractional);
    double expected[PIXELS], still[PIXELS], *const both = image_of(units, TOLIMAN_SIM_IMAGE_BOTH);
    assert_ok(toliman_sim_expect(units, 0, expected, SIDE));
    assert_memory_equal(expected, both, sizeof expected);
    assert_ok(toliman_sim_propagate(units, 0, still, SIDE));
    for (size_t i = 0; i < PIXELS; i++)
        assert_close(still[i], both[i], 1e-12, 0);
    free(both), toliman_sim_destroy(units);
}

/* Gains of the pixels: Gaussian of the given rms, from the scene's seed, independent of the frame's seed. */
TEST(flat_is_a_fixed_pattern) {
    double *const bare = image_with("", kNoise, TOLIMAN_SIM_IMAGE_BOTH);
    double *const flat = image_with("'flat_rms': 0.02", kNoise, TOLIMAN_SIM_IMAGE_BOTH);
    double *const other = image_with("'flat_rms': 0.02", "'seed': 8", TOLIMAN_SIM_IMAGE_BOTH);
    double noise[PIXELS]; /* read noise with the scene's seed in frame 0 */
    toliman_sim *const reading = make("", "'read_e': 1");
    assert_ok(toliman_sim_frame(reading, &(double){0}, 7, 0, 1, noise));
    toliman_sim_destroy(reading);
    double sum = 0, squares = 0, fourth = 0, product = 0, read = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        const double gain = (flat[i] / bare[i] - 1) / 0.02, second = (other[i] / bare[i] - 1) / 0.02;
        sum += gain;
        squares += gain * gain;
        fourth += gain * gain * gain * gain;
        product += gain * second;
        read += gain * (noise[i] - bare[i]);
    }
    assert_close(sum / PIXELS, 0, 0, 5 / sqrt(PIXELS));
    assert_close(squares / PIXELS, 1, 0, 5 * sqrt(2.0 / PIXELS));
    assert_close(fourth / PIXELS, 3, 0, 5 * sqrt(96.0 / PIXELS));
    assert_close(product / PIXELS, 0, 0, 5 / sqrt(PIXELS));
    assert_close(read / PIXELS, 0, 0, 5 / sqrt(PIXELS)); /* a random stream of its own */
    toliman_sim *const sim = make("'flat_rms': 0.02", "'seed': 7");
    double first[PIXELS], second[PIXELS];
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, first));
    assert_ok(toliman_sim_frame(sim, &(double){0}, 2, 9, 1, second));
    assert_memory_equal(first, second, sizeof first);
    assert_memory_equal(first, flat, sizeof first);
    toliman_sim_destroy(sim), free(bare), free(flat), free(other);
}

/* Frames computed here stage by stage, from frames with fewer stages. */
TEST(stages_come_in_order) {
    const char *const light = "'qe': 0.9, 'flat_rms': 0.05, 'dark_e_per_s': 3";
    char stages[300];
    double *const electrons = frame(light, "'photon': true, 'seed': 7");
    double *const still = frame("", ""), *const reading = frame("'coadds': 4", "'read_e': 2.5, 'seed': 7");
    snprintf(stages, sizeof stages, "%s, 'coadds': 4, 'full_well_e': 500, 'gain_e_per_dn': 3, 'bias_dn': 20.25", light);
    double *const analogue = frame(stages, kNoise);
    strcat(stages, ", 'bit_depth': 9");
    double *const digital = frame(stages, kNoise);
    size_t full = 0, cut = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        full += electrons[i] > 2000;
        const double kept = fmin(electrons[i], 2000), read = reading[i] - still[i];
        assert_close(analogue[i], (kept + read) / 3 + 20.25, 1e-12, 1e-10);
        cut += rint(analogue[i]) > 511;
        assert_true(digital[i] == fmin(rint(analogue[i]), 511));
    }
    assert_true(full > 3 && cut > full);
    free(electrons), free(still), free(reading), free(analogue), free(digital);
}

/* At two electrons per DN every other count is a half. */
TEST(halves_are_rounded_to_even) {
    double *const counts = frame("", kPhotons), *const dn = frame("'gain_e_per_dn': 2, 'bit_depth': 20", kPhotons);
    size_t down = 0, up = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        const double whole = floor(counts[i] / 2);
        const int odd = fmod(whole, 2) != 0, half = counts[i] / 2 != whole;
        assert_true(dn[i] == whole + (half && odd ? 1 : 0));
        up += half && odd;
        down += half && !odd;
    }
    assert_true(up > PIXELS / 8 && down > PIXELS / 8);
    free(counts), free(dn);
}

TEST(negative_counts_are_clipped_to_zero) {
    double *const dn = frame("'bit_depth': 20, 'qe': 1e-6", kNoise);
    size_t zeros = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        assert_true(dn[i] >= 0 && !signbit(dn[i]));
        zeros += dn[i] == 0;
    }
    assert_close((double)zeros / PIXELS, 0.5 * erfc(-0.2 / sqrt(2)), 0,
                 5 * 0.5 / sqrt(PIXELS)); /* up to 0.5 = 0.2 sigma */
    assert_non_null(strstr(heard, "detector.bias_dn: read noise may take 4096 pixels below 0 DN"));
    free(dn);
}

TEST(limits_are_reported) {
    double *const bare = image_with("", "", TOLIMAN_SIM_IMAGE_BOTH);
    double largest = 0;
    size_t saturated = 0, overflown = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        largest = fmax(largest, bare[i]);
        saturated += bare[i] > 2400;
        overflown += bare[i] / 2 + 10 > 1023.5;
    }
    free(bare);
    assert_true(saturated > 3 && overflown > saturated);
    char expected[300];
    toliman_sim_destroy(make("'full_well_e': 800, 'coadds': 3", ""));
    snprintf(expected, sizeof expected,
             "scene: detector.full_well_e: %zu pixels are saturated: the brightest pixel expects %g e-, the full well "
             "of all coadds is 2400 e-",
             saturated, largest);
    assert_non_null(strstr(heard, expected));
    toliman_sim_destroy(make("'gain_e_per_dn': 2, 'bias_dn': 10, 'bit_depth': 10", ""));
    snprintf(expected, sizeof expected,
             "scene: detector.bit_depth: %zu pixels overflow: the brightest pixel expects %g DN, the largest count is "
             "1023 DN",
             overflown, largest / 2 + 10);
    assert_non_null(strstr(heard, expected));
    toliman_sim_destroy(make("'gain_e_per_dn': 2, 'bias_dn': 20, 'bit_depth': 20, 'full_well_e': 1e9", kNoise));
    assert_null(strstr(heard, "detector."));
}

/* Neutral stages leave every byte as without them. */
TEST(neutral_stages_change_no_byte) {
    double *const bare = frame("", kNoise);
    double *const neutral = frame("'qe': 1, 'coadds': 1, 'flat_rms': 0, 'dark_e_per_s': 0, 'gain_e_per_dn': 1,"
                                  "'bias_dn': 0",
                                  kNoise);
    assert_memory_equal(bare, neutral, PIXELS * sizeof *bare);
    free(bare), free(neutral);
}

/* With every stage on, the template estimator reaches the bound in frames of DN; the error of its scatter is 1.4 %. */
TEST(the_template_reaches_the_bound) {
    enum { frames = 2500 };
    toliman_sim *const sim = make("'qe': 0.8, 'flat_rms': 0.03, 'dark_e_per_s': 10, 'coadds': 4, 'full_well_e': 1e5,"
                                  "'gain_e_per_dn': 20, 'bias_dn': 64, 'bit_depth': 14",
                                  kNoise);
    assert_null(strstr(heard, "detector."));
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    double sigma, sum = 0, squares = 0, image[PIXELS];
    assert_ok(toliman_linear_get_sigma(linear, &sigma));
    assert_close(sigma, sim_bounds_of(sim).crb_px, 1e-9, 0);
    for (int64_t k = 0; k < frames; k++) {
        double value;
        assert_ok(toliman_sim_frame(sim, &(double){5 * sigma}, 77, k, 1, image));
        assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(image), 1, &value, NULL));
        sum += value - 5 * sigma;
        squares += (value - 5 * sigma) * (value - 5 * sigma);
    }
    assert_close(sum / frames, 0, 0, 4 * sigma / sqrt(frames));
    assert_close(sqrt(squares / frames), sigma, 0.05, 0);
    toliman_linear_destroy(linear), toliman_sim_destroy(sim);
}

/* Bias and dark current fill the frame uniformly, but the network's crop must be centred on the stars. */
TEST(the_crop_is_centred_on_the_light) {
    const char *const stages[] = {"", "'bias_dn': 1000, 'dark_e_per_s': 50"};
    toliman_cae_info info[2];
    for (size_t i = 0; i < 2; i++) {
        char *text = replaced_again(text_with(stages[i], ""), "[64, 64]", "[270, 300]");
        text = replaced_again(text, "'separation_arcsec': 4, 'position_angle_deg': 30",
                              "'offsets_px': {'A': [20, 5], 'B': [10, 3]}");
        toliman_sim *const sim = sim_of(text);
        toliman_cae *cae = NULL;
        assert_ok(toliman_cae_create(sim, 1, NULL, &cae));
        info[i].struct_size = sizeof info[i];
        assert_ok(toliman_cae_get_info(cae, NULL, &info[i]));
        toliman_cae_destroy(cae), toliman_sim_destroy(sim), free(text);
    }
    assert_true(info[0].crop_col > 22 + 8 && info[0].crop_row > 7 + 2);
    assert_int_equal(info[1].crop_col, info[0].crop_col);
    assert_int_equal(info[1].crop_row, info[0].crop_row);
}

TEST(impossible_detectors) {
    const refusal cases[] = {
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'qe': 0", "detector.qe"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'qe': 1.1", "detector.qe"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'coadds': 0", "detector.coadds"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'coadds': 1.5", "detector.coadds"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'flat_rms': 0.2", "detector.flat_rms"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'dark_e_per_s': -1", "detector.dark_e_per_s"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'dark_e_per_s': 80", "detector.dark_e_per_s"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'full_well_e': 0", "detector.full_well_e"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'gain_e_per_dn': 0", "detector.gain_e_per_dn"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'bias_dn': -1", "detector.bias_dn"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'bit_depth': 33", "detector.bit_depth"},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.2, 'bit_dept': 12", "detector.bit_dept"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
}

RUN_TESTS(NULL, NULL)
