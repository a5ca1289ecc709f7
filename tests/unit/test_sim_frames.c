/* Tests noisy frames: their statistics, that they depend only on scene, displacement, seed and number, and refused
 * calls. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>

#include "frame_statistics.h"
#include "offsets.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

static double *frames_of(const toliman_sim *sim, uint64_t seed, int64_t first, size_t count) {
    double *const frames = malloc(count * PIXELS * sizeof *frames);
    assert_non_null(frames);
    assert_ok(toliman_sim_frame(sim, NULL, seed, first, count, frames));
    return frames;
}

static void check_statistics(const toliman_sim *sim, double read_e, int whole_counts) {
    double *const mean = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH), *const variance =
                                                                    image_of(sim, TOLIMAN_SIM_IMAGE_VARIANCE);
    for (size_t i = 0; i < PIXELS; i++)
        assert_close(variance[i], mean[i] + read_e * read_e, 1e-14, 0);
    check_frames(sim, mean, variance, 0.3, whole_counts); /* means are above 1/0.3 or below the read noise */
    free(mean), free(variance);
}

TEST(counts_have_the_right_mean_and_variance) {
    toliman_sim *sim = sim_of(kBinaryScene);
    check_statistics(sim, 2.5, 0);
    toliman_sim_destroy(sim);
    sim = sim_with(kBinaryScene, "'read_e': 2.5, ", "");
    check_statistics(sim, 0, 1);
    toliman_sim_destroy(sim);
    sim = sim_with(kBinaryScene, "1e5", "10"); /* so few photons that read noise dominates */
    check_statistics(sim, 2.5, 0);
    toliman_sim_destroy(sim);
}

/* A stage that the scene does not name is not computed. */
TEST(without_noise_frames_are_expectations) {
    toliman_sim *const sim =
        sim_with(kBinaryScene, ", 'noise': {'photon': true, 'read_e': 2.5, 'seed': 7}}", ", 'noise': {}}");
    (void)sim;
    double frame[PIXELS], expected[PIXELS];
    assert_ok(toliman_sim_frame(sim, &(double){1e-3}, 5, 3, 1, frame));
    assert_ok(toliman_sim_expect(sim, 1e-3, expected, SIDE));
    assert_memory_equal(frame, expected, sizeof frame);
    toliman_sim_destroy(sim);
}

/* promise: frames-depend-on-seed-alone */
TEST(frames_do_not_depend_on_threads_or_order) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    double *const one = frames_of(sim, 7, 20, 13);
    for (uint32_t threads = 1; threads <= 64; threads += threads < 8 ? 1 : 56) {
        toliman_sim *const other = sim_on_threads(kBinaryScene, threads);
        double *const many = frames_of(other, 7, 20, 13);
        assert_memory_equal(one, many, 13 * PIXELS * sizeof *one);
        free(many), toliman_sim_destroy(other);
    }
    static double image[PIXELS], two[2 * PIXELS];
    for (int64_t k = 32; k >= 20; k -= 4) { /* one by one, backwards */
        double displacement;
        assert_ok(toliman_sim_get_series(sim, k, 1, NULL, &displacement));
        assert_ok(toliman_sim_frame(sim, &displacement, 7, k, 1, image));
        assert_memory_equal(image, one + (size_t)(k - 20) * PIXELS, sizeof image);
    }
    free(one);
    /* With given displacements a frame may have any number, inside the cadence or not. */
    const double displacements[] = {0.01, 0.05};
    assert_ok(toliman_sim_frame(sim, displacements, 7, 123456789011, 2, two));
    assert_ok(toliman_sim_frame(sim, &displacements[1], 7, 123456789012, 1, image));
    assert_memory_equal(image, two + PIXELS, sizeof image);
    toliman_sim_destroy(sim);
}

/* promise: frames-depend-on-seed-alone */
TEST(seeds_and_numbers_make_different_frames) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    double *const frames = frames_of(sim, 7, 0, 2), *const others = frames_of(sim, 8, 0, 2);
    size_t equal = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        equal += frames[i] == others[i];
        equal += frames[i] == frames[PIXELS + i];
    }
    assert_true(equal < PIXELS / 100);
    free(frames), free(others), toliman_sim_destroy(sim);
}

/* An exposed expectation is the frame with this number, on any threads, in place or not. */
/* promise: frames-depend-on-seed-alone */
TEST(exposures_are_frames) {
    enum { COUNT = 5 };
    static double expected[COUNT * PIXELS], frames[COUNT * PIXELS], exposed[COUNT * PIXELS];
    const double displacements[COUNT] = {0.01, -0.02, 0, 0.03, 0.1};
    char *const counts = replaced(kBinaryScene, "'pixel_scale_arcsec': 0.2",
                                  "'gain_e_per_dn': 2, 'bias_dn': 64, 'bit_depth': 20, 'pixel_scale_arcsec': 0.2");
    const char *const scenes[] = {kBinaryScene, counts};
    for (int s = 0; s < 2; s++)
        for (uint32_t threads = 1; threads < 4; threads++) {
            toliman_sim *const sim = sim_on_threads(scenes[s], threads);
            for (size_t i = 0; i < COUNT; i++)
                assert_ok(toliman_sim_expect(sim, displacements[i], expected + i * PIXELS, SIDE));
            assert_ok(toliman_sim_frame(sim, displacements, 7, 123456789011, COUNT, frames));
            assert_ok(toliman_sim_expose(sim, expected, 7, 123456789011, COUNT, exposed));
            assert_memory_equal(exposed, frames, sizeof frames);
            assert_ok(toliman_sim_expose(sim, expected + PIXELS, 7, 123456789012, 1, expected + PIXELS));
            assert_memory_equal(expected + PIXELS, frames + PIXELS, PIXELS * sizeof *frames);
            toliman_sim_destroy(sim);
        }
    toliman_sim *const sim = sim_of(counts);
    assert_ok(toliman_sim_expose(sim, NULL, 7, 0, 0, NULL));
    assert_refused(toliman_sim_expose(sim, expected, 7, -1, 1, exposed), TOLIMAN_E_RANGE, "first");
    const struct {
        double value;
        toliman_status status;
        const char *field;
    } wrong[] = {{NAN, TOLIMAN_E_ARGUMENT, "expected"},
                 {INFINITY, TOLIMAN_E_ARGUMENT, "expected"},
                 {63.9, TOLIMAN_E_ARGUMENT, "expected"},
                 {1e12, TOLIMAN_E_RANGE, ""}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        expected[4 * PIXELS + 3 * SIDE + 17] = wrong[i].value;
        assert_refused(toliman_sim_expose(sim, expected, 7, 0, COUNT, exposed), wrong[i].status, wrong[i].field);
        assert_true(i > 2 || strstr(toliman_last_error(), "expected[4][3][17]") != NULL);
    }
    expected[4 * PIXELS + 3 * SIDE + 17] = 64 - 1e-8; /* rounding */
    assert_ok(toliman_sim_expose(sim, expected, 7, 0, COUNT, exposed));
    toliman_sim_destroy(sim), free(counts);
}

/* The image has the same bits with any number of library workers and of BLAS threads. */
/* promise: threads-change-no-bit */
TEST(images_do_not_depend_on_threads) {
    void (*set_blas_threads)(int);
    *(void **)&set_blas_threads = dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
    char *const text = replaced(kBinaryScene, "'pupil_samples': 96", "'pupil_samples': 203");
    double first[3][PIXELS];
    for (uint32_t threads = 1; threads < 6; threads += 2) {
        if (set_blas_threads != NULL)
            set_blas_threads((int)threads);
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.threads = threads;
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
        const int32_t kinds[3] = {TOLIMAN_SIM_IMAGE_BOTH, TOLIMAN_SIM_IMAGE_SEPARATION, TOLIMAN_SIM_IMAGE_CURVATURE};
        for (int i = 0; i < 3; i++) {
            double *const image = image_of(sim, kinds[i]);
            if (threads == 1)
                memcpy(first[i], image, sizeof first[i]);
            assert_memory_equal(first[i], image, sizeof first[i]);
            free(image);
        }
        toliman_sim_destroy(sim);
    }
    free(text);
}

TEST(info_holds_what_a_header_needs) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_sim_info info = sim_info_of(sim);
    assert_close(info.aperture_m, 0.125, 0, 0);
    assert_close(info.pixel_scale_arcsec, 0.2, 0, 0);
    assert_int_equal(info.whole_counts, 0); /* read noise */
    uint64_t digest = 0xcbf29ce484222325;
    for (const char *letter = kBinaryScene; *letter != '\0'; letter++)
        digest = (digest ^ (unsigned char)*letter) * 0x100000001b3;
    assert_true(info.scene_digest == digest);
    toliman_sim_destroy(sim);

    toliman_sim *const counts = sim_with(kBinaryScene, ", 'read_e': 2.5", "");
    assert_int_equal(sim_info_of(counts).whole_counts, 1);
    toliman_sim_destroy(counts);
    toliman_sim *const still = sim_with(kBinaryScene, "'photon': true, 'read_e': 2.5", "'photon': false");
    assert_int_equal(sim_info_of(still).whole_counts, 0);
    toliman_sim_destroy(still);
}

TEST(impossible_calls_are_refused) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    double image[PIXELS] = {-1};
    assert_refused(toliman_sim_frame(sim, &(double){0.2}, 1, 0, 1, image), TOLIMAN_E_RANGE, "displacements_px[0]");
    assert_invalid(toliman_sim_frame(sim, &(double){NAN}, 1, 0, 1, image), "displacements_px[0]");
    assert_refused(toliman_sim_frame(sim, &(double){0}, 1, -1, 1, image), TOLIMAN_E_RANGE, "first");
    assert_invalid(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, NULL), "images");
    assert_invalid(toliman_sim_frame(NULL, &(double){0}, 1, 0, 1, image), "sim");
    assert_refused(toliman_sim_expect(sim, -0.11, image, SIDE), TOLIMAN_E_RANGE, "displacement_px");
    assert_refused(toliman_sim_propagate(sim, INFINITY, image, SIDE), TOLIMAN_E_RANGE, "displacement_px");
    assert_invalid(toliman_sim_get_image(sim, 12, image, SIDE), "kind");
    assert_refused(toliman_sim_frame(sim, NULL, 1, 99, 2, image), TOLIMAN_E_RANGE, "first");
    assert_refused(toliman_sim_frame(sim, NULL, 1, 0, SIZE_MAX, image), TOLIMAN_E_RANGE, "first");
    const double far_away = -0.3;
    assert_refused(toliman_sim_frame(sim, &far_away, 1, 0, 1, image), TOLIMAN_E_RANGE, "displacements_px[0]");
    assert_close(image[0], -1, 0, 0);
    toliman_sim_info info = {0};
    assert_invalid(toliman_sim_get_info(sim, &info), "out->struct_size");
    toliman_sim_destroy(sim), toliman_sim_destroy(NULL);

    toliman_sim *const single = sim_of(kSingleScene);
    assert_invalid(toliman_sim_get_image(single, TOLIMAN_SIM_IMAGE_STAR_B, image, SIDE), "kind");
    double offsets[4];
    get_offsets(single, offsets);
    assert_true(isnan(offsets[2]) && isnan(offsets[3]));
    assert_string_equal(sim_info_of(single).name, "");
    toliman_sim_destroy(single);
}

static int32_t count_and_stop(const char *stage, double fraction, void *user_data) {
    assert_string_equal(stage, "propagate");
    assert_true(fraction > 0 && fraction <= 1);
    return ++*(int *)user_data == 2;
}

TEST(progress_may_cancel) {
    int calls = 0;
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.progress = count_and_stop;
    options.progress_data = &calls;
    toliman_sim *sim = NULL;
    assert_refused(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, &options, &sim),
                   TOLIMAN_E_CANCELLED, "");
    assert_int_equal(calls, 2);
    assert_null(sim);
}

static void record_log(int32_t level, const char *text, void *user_data) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    strncat((char *)user_data, text, 400);
}

/* The sum of both stars' light may exceed the range of the Poisson generator: reported, with the image unchanged. */
TEST(too_bright_frames_are_refused) {
    char *text = EDITED(kBinaryScene, {"'amplitude_px': 1e-3", "'amplitude_px': 20"},
                        {"'peak_photons': 1e5", "'peak_photons': 9e11"});
    toliman_sim *const sim = sim_of(text);
    free(text);
    static double image[64 * 64];
    image[0] = -1;
    assert_fails(toliman_sim_frame(sim, &(double){-20}, 1, 3, 1, image), TOLIMAN_E_RANGE,
                 "frame 3: a pixel expects 1.");
    assert_close(image[0], -1, 0, 0);
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 3, 1, image));
    toliman_sim_destroy(sim);
}

/* A large signal at an accuracy beyond interpolation and a star outside the frame are reported. */
TEST(odd_scenes_are_reported) {
    char messages[512] = "";
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.log = record_log;
    options.log_data = messages;
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, &options, &sim));
    assert_string_equal(messages, "");
    toliman_sim_destroy(sim);
    char *text =
        EDITED(kBinaryScene, {"'amplitude_px': 1e-3", "'amplitude_px': 3"}, {"'noise'", "'accuracy': 1e-15, 'noise'"});
    assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
    assert_non_null(strstr(messages, "accuracy = 1e-15: every frame is re-propagated: interpolation would exceed"));
    toliman_sim_destroy(sim);
    messages[0] = '\0';
    char *const outside = replaced(kBinaryScene, "'separation_arcsec': 4", "'separation_arcsec': 12");
    assert_ok(toliman_sim_create_json(outside, strlen(outside), NULL, &options, &sim));
    assert_non_null(strstr(messages, "star B is at (-22.5, 39.0) px, outside the frame of 64 x 64 by 7.0 px"));
    free(outside), toliman_sim_destroy(sim), free(text);
}

enum { KINDS = TOLIMAN_SIM_IMAGE_BACKGROUND - TOLIMAN_SIM_IMAGE_BOTH + 1 };
typedef double all_images[KINDS][PIXELS];

static void get_images(const toliman_sim *sim, int reversed, all_images images) {
    for (int i = 0; i < KINDS; i++) {
        const int kind = reversed ? KINDS - 1 - i : i;
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH + kind, images[kind], SIDE));
    }
}

static void *get_in_thread(void *sim) {
    static all_images images[2]; /* one per thread */
    static _Atomic int threads = 0;
    const int thread = threads++ % 2;
    get_images(sim, thread, images[thread]);
    return images[thread];
}

/* Derivatives are computed when first needed: alone, together, or while another thread asks for them. */
TEST(images_do_not_depend_on_what_was_asked_before) {
    static all_images expected, images;
    char *const scene =
        replaced(kBinaryScene, "'noise'", "'systematics': {'pointing_rms_px': 1e-3, 'focus_rms_nm': 0.1}, 'noise'");
    toliman_sim *sim = sim_of(scene);
    const toliman_sim_bounds bounds = sim_bounds_of(sim); /* needs all derivatives at once */
    get_images(sim, 0, expected);
    double *const frame = frames_of(sim, 1, 0, 1);
    toliman_sim_destroy(sim);
    for (int reversed = 0; reversed < 2; reversed++) {
        sim = sim_of(scene);
        double *const same = frames_of(sim, 1, 0, 1);
        assert_memory_equal(same, frame, PIXELS * sizeof *frame);
        free(same);
        get_images(sim, reversed, images);
        assert_memory_equal(images, expected, sizeof images);
        const toliman_sim_bounds same_bounds = sim_bounds_of(sim);
        assert_memory_equal(&same_bounds, &bounds, sizeof bounds);
        toliman_sim_destroy(sim);
    }
    sim = sim_of(scene);
    pthread_t threads[2];
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, get_in_thread, sim), 0);
    for (int i = 0; i < 2; i++) {
        void *result = NULL;
        assert_int_equal(pthread_join(threads[i], &result), 0);
        assert_memory_equal(result, expected, sizeof expected);
    }
    toliman_sim_destroy(sim), free(frame), free(scene);
}

/* One pixel at the centre of a star: its light does not change to first order. Its image needs no derivative. */
TEST(a_signal_that_changes_no_pixel_is_refused) {
    char *scene = EDITED(kSingleScene, {"[32, 32]", "[1, 1]"},
                         {"'cadence'", "'signal': {'kind': 'sinusoid', 'amplitude_px': 1e-3, 'period_days': 40}, "
                                       "'cadence'"});
    toliman_sim *const sim = sim_of(scene);
    toliman_sim_bounds bounds = TOLIMAN_SIM_BOUNDS_INIT;
    double count = 0;
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, &count, 1));
    const char *const message = "signal";
    assert_refused(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, &count), TOLIMAN_E_SCENE, message);
    assert_refused(toliman_sim_expect(sim, 0, &count, 1), TOLIMAN_E_SCENE, message);
    assert_refused(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_SEPARATION, &count, 1), TOLIMAN_E_SCENE, message);
    assert_refused(toliman_sim_get_bounds(sim, &bounds), TOLIMAN_E_SCENE, message);
    toliman_sim_destroy(sim), free(scene);
}

TEST(images_have_names) {
    for (int32_t kind = TOLIMAN_SIM_IMAGE_BOTH; kind <= TOLIMAN_SIM_IMAGE_BACKGROUND; kind++)
        for (int32_t other = TOLIMAN_SIM_IMAGE_BOTH; other < kind; other++)
            assert_string_not_equal(toliman_constant_name(kind), toliman_constant_name(other));
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_SEPARATION), "separation");
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_SHIFT_X), "shift_x");
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_ROLL), "roll");
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_BACKGROUND), "background");
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_BOTH - 1), "?");
    assert_string_equal(toliman_constant_name(TOLIMAN_SIM_IMAGE_BACKGROUND + 1), "?");
}

RUN_TESTS(NULL, NULL)
