/* Tests layout `core`, the network for windows of 128x128 px: choice by the frames' size, latents, blobs, banks and
 * what is refused. Its passes: kernel/test_backward; equal bits: same/results. */
#include "bank_scene.h"
#include "cae_scene.h"
#include "tlmw.h"

enum { kCore = 128, kCorePixels = kCore * kCore, kCoreParameters = 60994, kFrames = 400 };

static toliman_sim *sim; /* 128x128 */
static toliman_cae *trained;
static toliman_cae_training training = {.struct_size = sizeof training};

FIXTURE(set_up) {
    sim = make_sim(kCore, kCore, 0, "\"flux_a\", \"shift_x\"");
    trained = make_cae(sim, 7, 200, &training);
    return 0;
}

FIXTURE(tear_down) {
    toliman_cae_destroy(trained), toliman_sim_destroy(sim);
    return 0;
}

static toliman_status create(const toliman_sim *of, int32_t layout, toliman_cae **out) {
    const toliman_cae_options options = {.struct_size = sizeof options, .layout = layout};
    return toliman_cae_create(of, 1, &options, out);
}

TEST(layout_follows_the_frames) {
    static const struct {
        int rows, cols;
        int32_t layout;
        const char *name; /* NULL: refused */
    } cases[] = {{128, 128, 0, "core"},
                 {128, 300, 0, "core"},
                 {300, 255, 0, "core"},
                 {256, 256, 0, "flight"},
                 {256, 256, TOLIMAN_CAE_LAYOUT_CORE, "core"},
                 {128, 128, TOLIMAN_CAE_LAYOUT_FLIGHT, NULL},
                 {255, 256, TOLIMAN_CAE_LAYOUT_PAPER, NULL},
                 {127, 128, 0, NULL},
                 {300, 127, TOLIMAN_CAE_LAYOUT_CORE, NULL}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        toliman_sim *const of = make_sim(cases[k].rows, cases[k].cols, 0, "");
        toliman_cae *cae = NULL;
        if (cases[k].name == NULL) {
            assert_refused(create(of, cases[k].layout, &cae), TOLIMAN_E_UNSUPPORTED, "detector.shape");
            assert_null(cae);
        } else {
            assert_ok(create(of, cases[k].layout, &cae));
            const toliman_cae_info info = cae_info_of(cae);
            const int side = info.layout[0] == 'c' ? kCore : kSide;
            assert_string_equal(info.layout, cases[k].name);
            assert_int_equal(info.side, side);
            assert_true(info.crop_row >= 0 && info.crop_row + side <= cases[k].rows && info.crop_col >= 0 &&
                        info.crop_col + side <= cases[k].cols);
        }
        toliman_cae_destroy(cae), toliman_sim_destroy(of);
    }
}

/* The hash is that of the table in formats.md, computed with Python: a change of it makes all saved networks useless.
 * */
TEST(layout_is_pinned) {
    const toliman_cae_info info = cae_info_of(trained);
    assert_true(info.layout_hash == 0xce2782f7d45c68a2u);
    assert_int_equal(info.parameters, kCoreParameters);
    assert_true(info.input_scale == 1e-3 && info.projected == 2);
}

/* A latent is the inner product of the network's gradient, found by differences of it, with the projected residual: the
 * rows of the image arrive in the right order and place. */
TEST(latents_are_inner_products) {
    double *const target = new_image(kCorePixels), *const decoded = new_image(kCorePixels);
    double *const reference = new_image(kCorePixels), *const variance = new_image(kCorePixels);
    double *const frame = new_image(kCorePixels);
    assert_ok(toliman_cae_get_target(trained, target, kCore));
    assert_ok(toliman_cae_decode(trained, 1e-6, decoded, kCore));
    assert_ok(toliman_sim_expect(sim, 0, reference, kCore));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, kCore));
    long double along = 0, square = 0, length = 0;
    for (int i = 0; i < kCorePixels; i++) {
        along += (long double)decoded[i] * target[i];
        square += (long double)target[i] * target[i];
        length += (long double)decoded[i] * decoded[i];
    }
    assert_close((double)(along / sqrtl(square * length)), training.cosine, 0.01, 0); /* with nuisances or without */
    for (int k = -1; k <= 1; k += 2) {
        const double scale = k * 1e-4;
        for (int i = 0; i < kCorePixels; i++)
            frame[i] = reference[i] + scale * target[i] * sqrt(variance[i]);
        double latent;
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
        assert_close(latent, scale, 1e-3, 0);
    }
    free(target), free(decoded), free(reference), free(variance), free(frame);
}

/* The promise of tied-efficiency-is-stated for the camera's windows. */
TEST(efficiency_reaches_the_bound) {
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    assert_true(cae_info_of(trained).crb_px == bounds.crb_projected_px);
    assert_in_range((int)(1000 * training.cosine), 980, 1000);
    static double latents[kFrames];
    double *const frames = new_image((size_t)kFrames * kCorePixels), sum = 0, squares = 0;
    const double still[kFrames] = {0};
    toliman_frame_goodness goodness[kFrames];
    for (int k = 0; k < kFrames; k++)
        goodness[k] = (toliman_frame_goodness)TOLIMAN_FRAME_GOODNESS_INIT;
    assert_ok(toliman_sim_frame(sim, still, 1, 0, kFrames, frames));
    assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frames), kFrames, latents, goodness));
    for (int k = 0; k < kFrames; k++) {
        double alone;
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frames + (size_t)k * kCorePixels), 1, &alone, NULL));
        assert_true(alone == latents[k]);
        assert_close(goodness[k].chi_square, 1, 0, 5 * sqrt(2.0 / kCorePixels));
        sum += latents[k], squares += latents[k] * latents[k];
    }
    const double sigma = sqrt(squares / kFrames - sum * sum / kFrames / kFrames);
    assert_close(bounds.crb_projected_px / sigma, training.cosine, 0, 3.5 / sqrt(2.0 * kFrames));
    assert_close(sum / kFrames / sigma, 0, 0, 4 / sqrt(kFrames));
    free(frames);
}

TEST(reconstructions_have_the_photon_floor) {
    double *const frame = new_image(kCorePixels), *const image = new_image(kCorePixels);
    double mmse, mssim, photon_floor;
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, 1, frame));
    assert_ok(toliman_cae_reconstruct(trained, frame, kCore, image, kCore, &mmse, &mssim, &photon_floor));
    assert_close(mmse, photon_floor, 0.05, 0);
    assert_true(mssim > 0.99 && mssim <= 1);
    assert_invalid(toliman_cae_decode(trained, 0, image, kCore - 1), "stride");
    free(frame), free(image);
}

/* A cosmic ray is left out: the latent is that without it. */
TEST(bad_pixels_are_left_out) {
    double *const frame = new_image(kCorePixels), clean, hit;
    toliman_frame_goodness goodness = TOLIMAN_FRAME_GOODNESS_INIT;
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, 1, frame));
    assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &clean, NULL));
    frame[70 * kCore + 61] += 1e6;
    assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &hit, &goodness));
    assert_int_equal(goodness.bad_pixels, 1);
    assert_close(hit, clean, 0, 0.2 * cae_info_of(trained).crb_px);
    free(frame);
}

/* promise: networks-save-same-bytes */
TEST(blobs_keep_the_network) {
    double *const frame = new_image(kCorePixels), latent, again;
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, 1, frame));
    assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
    for (int32_t encoding = 0; encoding < 3; encoding++) {
        size_t size;
        uint8_t *const bytes = saved_as(trained, encoding, encoding, &size);
        toliman_cae *loaded = NULL;
        assert_int_equal(get(bytes + 16, 4), 3);
        assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
        assert_string_equal(cae_info_of(loaded).layout, "core");
        assert_ok(toliman_cae_encode(loaded, PLAIN_IMAGE(frame), 1, &again, NULL));
        if (encoding == 0)
            assert_true(again == latent);
        else
            assert_close(again, latent, 0, 0.2 * cae_info_of(trained).crb_px);
        size_t found;
        uint8_t *const bytes_again = saved_as(loaded, encoding, encoding, &found);
        assert_int_equal(found, size);
        assert_memory_equal(bytes_again, bytes, size);
        free(bytes), free(bytes_again), toliman_cae_destroy(loaded);
    }
    free(frame);
}

static int32_t stop_after_three(const char *stage, double fraction, void *user_data) {
    (void)stage, (void)fraction;
    return ++*(int *)user_data == 3;
}

/* promise: cancelled-training-resumes */
TEST(trainings_resume) {
    int calls = 0;
    toliman_cae_train_options options = {
        .struct_size = sizeof options, .steps = 8, .progress = stop_after_three, .progress_data = &calls};
    toliman_cae *cae = make_cae(sim, 3, 0, NULL), *whole = make_cae(sim, 3, 8, NULL), *loaded = NULL;
    assert_refused(toliman_cae_train(cae, &options, NULL), TOLIMAN_E_CANCELLED, "");
    size_t size;
    uint8_t *const bytes = saved_with_training(cae, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
    options.progress = NULL;
    assert_ok(toliman_cae_train(loaded, &options, NULL));
    size_t expected;
    uint8_t *const as_whole = saved(whole, &expected);
    assert_saved(loaded, as_whole, expected);
    free(bytes), free(as_whole);
    toliman_cae_destroy(cae), toliman_cae_destroy(whole), toliman_cae_destroy(loaded);
}

/* Blobs of one layout under the header of another, and impossible sizes. */
/* promise: damaged-weights-are-refused */
TEST(damaged_blobs_are_refused) {
    static const struct {
        int at, bytes;
        uint64_t value;
        const char *text;
    } cases[] = {{16, 4, 1, "layout = 1"},
                 {16, 4, 4, "layout = 4"},
                 {24, 8, 1, "3 (core)"},
                 {48, 4, 127, "frame shape = [127, 128]: must be in [128, 4096] px"},
                 {52, 4, 4097, "frame shape = "},
                 {56, 4, 1, "crop = [1, 0]"},
                 {kAtProjected, 4, 3, "compressed payload"},
                 {kAtWeightsEncoding, 2, 1, "compressed payload"}};
    size_t size;
    uint8_t *const bytes = saved(trained, &size), *const kept = malloc(size);
    memcpy(kept, bytes, size);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        put(bytes + cases[k].at, cases[k].value, cases[k].bytes);
        seal(bytes, size);
        refused(bytes, size, cases[k].text);
        memcpy(bytes, kept, size);
    }
    /* The whole header of layout `flight`: the payloads are too short. */
    toliman_sim *const wide = make_sim(kSide, kSide, 0, "\"flux_a\", \"shift_x\"");
    toliman_cae *const flight = make_cae(wide, 1, 0, NULL);
    put(bytes + 16, 1, 4), put(bytes + 24, cae_info_of(flight).layout_hash, 8);
    put(bytes + 48, kSide, 4), put(bytes + 52, kSide, 4);
    seal(bytes, size);
    refused(bytes, size, "compressed payload");
    for (size_t part = 0; part < size; part += 997)
        refused(kept, part, "truncated");
    free(bytes), free(kept), toliman_cae_destroy(flight), toliman_sim_destroy(wide);
}

/* Networks for dates and places, with their encoder alone. */
TEST(banks_use_the_layout) {
    toliman_sim *const resting = bank_sim(kCore, kCore, BANK_AT_REST);
    toliman_fit *const fit = bank_fit(resting, 2);
    toliman_bank *const bank = bank_of(fit, 2, 0.5, 200), *loaded = NULL;
    train_bank(bank, fit, 1);
    assert_string_equal(bank_info_of(bank).layout, "core");
    toliman_bank_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_bank_plan(resting, NULL, &plan));
    assert_int_equal(plan.bytes_float32, plan.networks * 4 * 28481);
    const toliman_bank_options larger = {.struct_size = sizeof larger, .layout = TOLIMAN_CAE_LAYOUT_FLIGHT};
    assert_refused(toliman_bank_plan(resting, &larger, &plan), TOLIMAN_E_UNSUPPORTED, "detector.shape");

    static double frame[kCorePixels];
    toliman_bank_result result = {.struct_size = sizeof result}, again = result;
    toliman_fit_result fitted = {.struct_size = sizeof fitted};
    assert_ok(toliman_sim_frame(resting, NULL, 1, 3, 1, frame));
    assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(frame), 1, NULL, &result, &fitted));
    assert_true(result.efficiency > 0.9);
    assert_close(result.separation_px, fitted.separation_px, 0, 3 * result.sigma_px);
    size_t size;
    assert_refused(toliman_bank_save(bank, 0, NULL, 0, &size), TOLIMAN_E_CAPACITY, "capacity");
    uint8_t *const bytes = malloc(size);
    assert_ok(toliman_bank_save(bank, 0, bytes, size, &size));
    assert_ok(toliman_bank_load(bytes, size, NULL, &loaded));
    assert_ok(toliman_bank_encode(loaded, fit, PLAIN_IMAGE(frame), 1, NULL, &again, NULL));
    assert_memory_equal(&again, &result, sizeof result);
    free(bytes), toliman_bank_destroy(bank), toliman_bank_destroy(loaded), toliman_fit_destroy(fit);
    toliman_sim_destroy(resting);
}

RUN_TESTS(set_up, tear_down)
