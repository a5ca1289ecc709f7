/* Tests the search for a mask: scores against images and spectra, the same result on any number of threads, the search
 * stopped at each stage, and scenes with other masks or none. */
#include <toliman/mask.h>

#include "scene_files.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, WAVELENGTHS = 5, SAMPLES = 96 };

static const char kMask[] =
    "{\"kind\": \"spiral\", \"opd_nm\": 297.5,"
    "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}]}";

static toliman_mask_options options_of(uint64_t seed, uint64_t count, uint32_t threads) {
    toliman_mask_options options = TOLIMAN_MASK_OPTIONS_INIT;
    options.seed = seed;
    options.count = count;
    options.threads = threads;
    return options;
}

static toliman_mask *search(const toliman_sim *sim, toliman_mask_options options) {
    toliman_mask *mask = NULL;
    assert_ok(toliman_mask_search(sim, &options, &mask));
    return mask;
}

static toliman_mask_info info_of(const toliman_mask *mask) {
    toliman_mask_info info = TOLIMAN_MASK_INFO_INIT;
    assert_ok(toliman_mask_get_info(mask, &info));
    return info;
}

/* The three scores from the images and the spectrum of the scene. */
static void assert_scores(const toliman_sim *sim, double crb_px, double peak_to_mean, double light_in_frame) {
    static double both[PIXELS], slope[PIXELS], variance[PIXELS];
    double a[WAVELENGTHS], b[WAVELENGTHS], information = 0, total = 0, peak = 0, emitted = 0;
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, both, SIDE));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_SEPARATION, slope, SIDE));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, SIDE));
    assert_ok(toliman_sim_get_spectrum(sim, WAVELENGTHS, NULL, a, b));
    for (int i = 0; i < PIXELS; i++) {
        information += slope[i] * slope[i] / variance[i];
        total += both[i];
        peak = fmax(peak, both[i]);
    }
    for (int i = 0; i < WAVELENGTHS; i++)
        emitted += a[i] + b[i];
    assert_close(crb_px, 1 / sqrt(information), 1e-9, 0);
    assert_close(peak_to_mean, peak / (total / PIXELS), 1e-12, 0);
    assert_close(light_in_frame, total / emitted, 1e-12, 0);
}

static void scores_are_those_of_the_scenes(void **state) {
    (void)state;
    toliman_sim *const own = sim_of(kBinaryScene);
    toliman_mask *const mask = search(own, options_of(7, 40, 0));
    const toliman_mask_info info = info_of(mask);
    assert_int_equal(info.improved, 1);
    assert_int_equal(info.stopped, 0);
    assert_int_equal(info.tried, 40);
    assert_at_most(info.crb_px, 0.95 * info.crb_before_px);
    assert_at_most(info.peak_to_mean, info.peak_to_mean_before);
    assert_non_null(
        strstr(toliman_mask_get_json(mask), "{\"kind\": \"spiral\", \"opd_nm\": 297.5, \"terms\": [{\"a\": "));
    assert_scores(own, info.crb_before_px, info.peak_to_mean_before, info.light_in_frame_before);
    toliman_sim *const better = sim_with(kBinaryScene, kMask, toliman_mask_get_json(mask));
    assert_scores(better, info.crb_px, info.peak_to_mean, info.light_in_frame);
    toliman_sim_destroy(own);
    toliman_sim_destroy(better);
    toliman_mask_destroy(mask);
}

/* The expected mask is that of the program before it called the library. */
static void a_seed_gives_one_mask_on_any_number_of_threads(void **state) {
    (void)state;
    static const char kExpected[] =
        "{\"kind\": \"spiral\", \"opd_nm\": 297.5, \"terms\": [{\"a\": 0.8729, \"f\": 3.1043, \"l\": 0, \"m\": -7, "
        "\"p\": 4.9566}, {\"a\": 1.0099, \"f\": 1.8149, \"l\": 0, \"m\": 7, \"p\": -0.0189}]}";
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_mask *const one = search(sim, options_of(7, 20, 1)), *const three = search(sim, options_of(7, 20, 3));
    toliman_mask *const other = search(sim, options_of(8, 20, 1));
    const toliman_mask_info info = info_of(one), same = info_of(three);
    assert_memory_equal(&info, &same, sizeof info);
    assert_string_equal(toliman_mask_get_json(one), kExpected);
    assert_string_equal(toliman_mask_get_json(three), kExpected);
    assert_string_not_equal(toliman_mask_get_json(other), kExpected);
    toliman_mask_destroy(one);
    toliman_mask_destroy(three);
    toliman_mask_destroy(other);
    toliman_sim_destroy(sim);
}

typedef struct {
    const char *stage; /* to be stopped, at its call number `call` */
    int call, calls, calls_after;
    double fraction; /* of the last call */
} Watch;

static int32_t stop_in_stage(const char *stage, double fraction, void *given) {
    Watch *const watch = given;
    watch->fraction = fraction;
    assert_non_null(strstr(stage, ": best "));
    if (watch->calls_after > 0 ||
        (strncmp(stage, watch->stage, strlen(watch->stage)) == 0 && watch->calls++ == watch->call))
        watch->calls_after++;
    return watch->calls_after > 0;
}

/* A stopped search calls the callback no more, and its result is the best mask so far, which the full scene confirmed.
 */
static void a_stopped_search_keeps_the_best(void **state) {
    (void)state;
    static const struct {
        const char *stage;
        int call, improved;
        uint64_t tried;
    } cases[] = {
        {"draw", 0, 0, 0}, {"draw", 1, 1, 16}, {"refine", 0, 1, 35}, {"refine", 2, 1, 67}, {"polish", 0, 1, 98}};
    toliman_sim *const sim = sim_of(kBinaryScene);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Watch watch = {.stage = cases[i].stage, .call = cases[i].call};
        toliman_mask_options options = options_of(3, 100, 0);
        options.progress = stop_in_stage;
        options.progress_data = &watch;
        toliman_mask *const mask = search(sim, options);
        const toliman_mask_info info = info_of(mask);
        assert_int_equal(watch.calls_after, 1);
        assert_int_equal(info.stopped, 1);
        assert_int_equal(info.tried, cases[i].tried);
        assert_int_equal(info.improved, cases[i].improved);
        if (info.improved) {
            toliman_sim *const better = sim_with(kBinaryScene, kMask, toliman_mask_get_json(mask));
            assert_true(info.crb_px < info.crb_before_px);
            assert_scores(better, info.crb_px, info.peak_to_mean, info.light_in_frame);
            toliman_sim_destroy(better);
        } else {
            assert_string_equal(toliman_mask_get_json(mask), "");
            assert_true(info.crb_px == info.crb_before_px && info.peak_to_mean == info.peak_to_mean_before);
        }
        toliman_mask_destroy(mask);
    }
    toliman_sim_destroy(sim);
}

/* 0 masks are 4000 without a time limit, and no limit with one. */
static void limits_have_defaults(void **state) {
    (void)state;
    toliman_sim *const sim = sim_of(kBinaryScene);
    Watch watch = {.stage = "draw", .call = 1};
    toliman_mask_options options = options_of(3, 0, 0);
    options.progress = stop_in_stage;
    options.progress_data = &watch;
    toliman_mask_destroy(search(sim, options));
    assert_close(watch.fraction, 16 / (0.35 * 4000), 1e-12, 0);
    options.progress = NULL;
    options.minutes = 0.003;
    toliman_mask *const mask = search(sim, options);
    assert_int_equal(info_of(mask).stopped, 0);
    assert_true(info_of(mask).tried > 0);
    toliman_mask_destroy(mask);
    for (uint64_t count = 1; count < 40; count += 15) {
        toliman_mask *const few = search(sim, options_of(1, count, 0));
        assert_int_equal(info_of(few).tried, count);
        toliman_mask_destroy(few);
    }
    toliman_sim_destroy(sim);
}

/* The step of the masks found in a scene whose mask is replaced by `mask`; all of them have a smaller bound. */
static void assert_step(const char *mask, const char *step) {
    char *const text = replaced(kBinaryScene, kMask, mask);
    toliman_sim *sim = NULL;
    assert_ok(create_in_folder(text, &sim));
    toliman_mask *const found = search(sim, options_of(3, 20, 0));
    const toliman_mask_info info = info_of(found);
    assert_true(info.crb_px < info.crb_before_px);
    assert_non_null(strstr(toliman_mask_get_json(found), step));
    toliman_mask_destroy(found);
    toliman_sim_destroy(sim);
    free(text);
}

/* Half of 575 nm, the middle of the band, where the scene's mask gives no step. */
static void scenes_with_other_masks(void **state) {
    (void)state;
    static double opd_m[SAMPLES * SAMPLES];
    static unsigned char steps[SAMPLES * SAMPLES];
    for (int i = 0; i < SAMPLES * SAMPLES; i++) {
        steps[i] = i / 7 % 2 != 0;
        opd_m[i] = 1e-9 * (i % SAMPLES);
    }
    write_npy("mask.npy", "|u1", "(96, 96)", steps, sizeof steps);
    write_npy("surface.npy", "<f8", "(96, 96)", opd_m, sizeof opd_m);
    assert_step("{\"kind\": \"clear\"}", "\"opd_nm\": 287.5, \"edges\": \"area\",");
    assert_step("{\"kind\": \"spiral\", \"opd_nm\": 250.3, \"rotation_deg\": -0.3, \"shift_m\": [0.001, 0], \"edges\": "
                "\"area\", \"terms\": [{\"a\": 1, \"f\": 2, \"m\": 1}]}",
                "\"opd_nm\": 250.3, \"edges\": \"area\", \"rotation_deg\": -0.3, \"shift_m\": [0.001, 0], \"terms\"");
    assert_step("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"opd_nm\": 250.3}",
                "\"opd_nm\": 250.3,");
    assert_step("{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", \"height_nm\": 144}",
                "\"height_nm\": 144,");
    assert_step("{\"kind\": \"file\", \"file\": \"surface.npy\", \"quantity\": \"opd_m\"}", "\"opd_nm\": 287.5,");
}

/* Files of the pupil have a fixed size, so the coarse scene has all samples. The search reads them again. */
static void scenes_with_files_of_the_pupil(void **state) {
    (void)state;
    static double grey[SAMPLES * SAMPLES];
    for (int i = 0; i < SAMPLES * SAMPLES; i++)
        grey[i] = 0.5;
    write_npy("amplitude.npy", "<f8", "(96, 96)", grey, sizeof grey);
    char *const text =
        replaced(kBinaryScene, "\"aperture_m\"", "\"amplitude\": {\"file\": \"amplitude.npy\"}, \"aperture_m\"");
    toliman_sim *sim = NULL;
    toliman_mask *found = NULL;
    assert_ok(create_in_folder(text, &sim));
    found = search(sim, options_of(3, 20, 0));
    assert_int_equal(info_of(found).improved, 1);
    toliman_mask_destroy(found);
    found = NULL;
    assert_int_equal(unlink(path_of("amplitude.npy")), 0);
    assert_fails(toliman_mask_search(sim, NULL, &found), TOLIMAN_E_NOT_FOUND, "amplitude.npy");
    assert_null(found);
    toliman_sim_destroy(sim);
    free(text);
}

static void refusals(void **state) {
    (void)state;
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_mask *mask = NULL;
    toliman_mask_info info = TOLIMAN_MASK_INFO_INIT;
    toliman_mask_options options = options_of(1, 1, 1);
    const double minutes[] = {-1, 100001, NAN, INFINITY};
    for (size_t i = 0; i < sizeof minutes / sizeof *minutes; i++) {
        options.minutes = minutes[i];
        assert_fails(toliman_mask_search(sim, &options, &mask), TOLIMAN_E_ARGUMENT, ": must be in [0, 100000]");
        assert_string_equal(toliman_last_error_field(), "options->minutes");
    }
    options.struct_size--;
    assert_fails(toliman_mask_search(sim, &options, &mask), TOLIMAN_E_ARGUMENT, "options->struct_size");
    assert_fails(toliman_mask_search(NULL, NULL, &mask), TOLIMAN_E_ARGUMENT, "sim is NULL");
    assert_fails(toliman_mask_search(sim, NULL, NULL), TOLIMAN_E_ARGUMENT, "out is NULL");
    assert_fails(toliman_mask_get_info(NULL, &info), TOLIMAN_E_ARGUMENT, "mask is NULL");
    assert_string_equal(toliman_mask_get_json(NULL), "");
    toliman_mask_destroy(NULL);
    toliman_sim_destroy(sim);

    toliman_sim_options fft = TOLIMAN_SIM_OPTIONS_INIT;
    toliman_sim *padded = NULL;
    fft.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    assert_ok(toliman_sim_create_json(kSingleScene, strlen(kSingleScene), NULL, &fft, &padded));
    assert_fails(toliman_mask_search(padded, NULL, &mask), TOLIMAN_E_UNSUPPORTED, "PADDED_FFT");
    toliman_sim_destroy(padded);

    toliman_sim *const pixel =
        sim_with(kSingleScene, "[32, 32]", "[1, 1]"); /* its light does not change to first order */
    assert_fails(toliman_mask_search(pixel, NULL, &mask), TOLIMAN_E_SCENE, "the separation has no Cramer-Rao bound");
    toliman_sim_destroy(pixel);
    assert_null(mask);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scores_are_those_of_the_scenes),
        cmocka_unit_test(a_seed_gives_one_mask_on_any_number_of_threads),
        cmocka_unit_test(a_stopped_search_keeps_the_best),
        cmocka_unit_test(limits_have_defaults),
        cmocka_unit_test(scenes_with_other_masks),
        cmocka_unit_test(scenes_with_files_of_the_pupil),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
