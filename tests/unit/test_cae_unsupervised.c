/* Tests unsupervised training with both layouts and all inputs: equal bits, resuming, learning, refusals. */
#include "cae_scene.h"
#include "images.h"

static toliman_sim *sim;

FIXTURE(set_up) {
    sim = make_sim(kSide, kSide, 0, "");
    return 0;
}

FIXTURE(tear_down) {
    toliman_sim_destroy(sim);
    return 0;
}

/* Noisy frames with a sinusoidal displacement. */
enum { kMostFrames = 40 };
typedef struct Source {
    double amplitude_px, displacements[kMostFrames];
    toliman_status failure;
    int poisoned; /* one count is NaN */
    int dark;     /* every count is 0 */
} Source;

static Source make_source(double amplitude_px) {
    Source source = {.amplitude_px = amplitude_px};
    for (int i = 0; i < kMostFrames; i++)
        source.displacements[i] = amplitude_px * sin(0.7 * i);
    return source;
}

static toliman_status give_frames(size_t first, size_t count, double *counts, void *user_data) {
    const Source *source = user_data;
    if (source->failure != TOLIMAN_OK)
        return source->failure;
    const toliman_status status =
        toliman_sim_frame(sim, source->displacements + first, 5, (int64_t)first, count, counts);
    if (source->poisoned)
        counts[777] = NAN;
    for (size_t i = 0; source->dark && i < kPixels; i++)
        counts[i] = 0;
    return status;
}

static toliman_cae_train_options options_for(Source *source, uint64_t frames, uint32_t epochs) {
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
    options.steps = epochs;
    options.frames = give_frames;
    options.frames_data = source;
    options.frame_count = frames;
    options.batch = 4;
    return options;
}

static toliman_cae *make_network(int32_t layout, int32_t input) {
    toliman_cae_options options = TOLIMAN_CAE_OPTIONS_INIT;
    toliman_cae *cae = NULL;
    options.layout = layout;
    options.input = input;
    assert_ok(toliman_cae_create(sim, 3, &options, &cae));
    return cae;
}

static double first_latent(const toliman_cae *cae) {
    static double frame[kPixels];
    double latent, displacement = 3e-3;
    assert_ok(toliman_sim_frame(sim, &displacement, 5, 1000, 1, frame));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    assert_true(isfinite(latent));
    return latent;
}

TEST(test_one_epoch) {
    Source source = make_source(1e-2);
    for (int32_t layout = TOLIMAN_CAE_LAYOUT_FLIGHT; layout <= TOLIMAN_CAE_LAYOUT_PAPER; layout++) {
        toliman_cae_training one = {.struct_size = sizeof one}, other = one;
        double latents[2];
        for (uint32_t workers = 1; workers <= 3; workers += 2) {
            toliman_cae *cae = make_network(layout, TOLIMAN_CAE_INPUT_WHITENED);
            toliman_cae_train_options options = options_for(&source, 10, 1);
            options.threads = workers;
            assert_ok(toliman_cae_train(cae, &options, workers == 1 ? &one : &other));
            latents[workers / 2] = first_latent(cae);
            toliman_cae_destroy(cae);
        }
        assert_memory_equal(&one, &other, sizeof one);
        assert_memory_equal(&latents[0], &latents[1], sizeof latents[0]);
        assert_int_equal(one.epochs, 1);
        assert_int_equal(one.steps, 3); /* nine frames in batches of four, one held out */
        assert_true(one.loss > 0 && one.validation_loss > 0 && one.mmse > 0 && one.photon_floor > 0);
    }
}

typedef struct Epochs {
    toliman_cae *cae;
    toliman_cae_training results[3];
    double latents[3];
    int count, last;
} Epochs;

static int32_t note_epoch(const toliman_cae *so_far, const toliman_cae_training *result, void *user_data) {
    Epochs *epochs = user_data;
    epochs->latents[epochs->count] = first_latent(so_far);
    toliman_cae_info info = TOLIMAN_CAE_INFO_INIT;
    assert_int_equal(toliman_cae_get_info(epochs->cae, NULL, &info), TOLIMAN_E_STATE);
    epochs->results[epochs->count++] = *result;
    return epochs->count == epochs->last;
}

/* The result of each epoch is that of a training of as many epochs; a training stopped by the callback resumes. */
/* promise: cancelled-training-resumes */
TEST(test_results_of_each_epoch) {
    Source source = make_source(1e-2);
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_RAW);
    Epochs epochs = {.cae = cae, .last = 2};
    toliman_cae_train_options options = options_for(&source, 10, 3);
    options.epoch = note_epoch;
    options.epoch_data = &epochs;
    toliman_cae_training result = TOLIMAN_CAE_TRAINING_INIT;
    assert_refused(toliman_cae_train(cae, &options, &result), TOLIMAN_E_CANCELLED, "");
    assert_ok(toliman_cae_train(cae, &options, &result));
    assert_int_equal(epochs.count, 3);
    assert_memory_equal(&epochs.results[2], &result, sizeof result);
    for (uint32_t k = 1; k <= 3; k++) {
        toliman_cae *again = make_network(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_RAW);
        const toliman_cae_train_options plain = options_for(&source, 10, k);
        assert_ok(toliman_cae_train(again, &plain, &result));
        assert_memory_equal(&epochs.results[k - 1], &result, sizeof result);
        assert_true(epochs.latents[k - 1] == first_latent(again));
        toliman_cae_destroy(again);
    }
    toliman_cae_destroy(cae);
}

typedef struct Patience {
    double until;
    int epochs_named;
} Patience;

static int32_t stop_in_time(const char *stage, double fraction, void *user_data) {
    Patience *patience = user_data;
    patience->epochs_named += strstr(stage, "train: epoch ") == stage;
    return fraction >= patience->until && strstr(stage, "train") == stage;
}

/* Three epochs in one run; two epochs, cancelled in the third and resumed; two epochs plus one. */
/* promise: cancelled-training-resumes */
TEST(test_resume_after_cancellation) {
    Source source = make_source(1e-2);
    toliman_cae_training report = {.struct_size = sizeof report};
    toliman_cae *whole = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    toliman_cae_train_options options = options_for(&source, 10, 3);
    double losses[4] = {-1, -1, -1, -1};
    options.losses = losses;
    options.loss_count = 4;
    assert_ok(toliman_cae_train(whole, &options, &report));
    const double expected = first_latent(whole), loss = report.loss;
    assert_true(losses[0] > 0 && losses[1] > 0 && losses[2] == loss && losses[3] == -1);
    options.loss_count = 0;

    toliman_cae *cancelled = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    const double before = first_latent(cancelled);
    Patience patience = {.until = 0.8};
    options.progress = stop_in_time;
    options.progress_data = &patience;
    assert_int_equal(toliman_cae_train(cancelled, &options, NULL), TOLIMAN_E_CANCELLED);
    assert_true(first_latent(cancelled) == before);
    assert_true(patience.epochs_named > 6);
    patience = (Patience){.until = 2};
    assert_ok(toliman_cae_train(cancelled, &options, &report));
    assert_true(patience.epochs_named <= 3); /* only the steps of the last epoch */
    assert_true(first_latent(cancelled) == expected && report.loss == loss && report.epochs == 3);

    toliman_cae *longer = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    options = options_for(&source, 10, 2);
    assert_ok(toliman_cae_train(longer, &options, NULL));
    assert_true(first_latent(longer) != expected);
    options.steps = 3;
    assert_ok(toliman_cae_train(longer, &options, &report));
    assert_true(first_latent(longer) == expected && report.steps == 9);
    toliman_cae_destroy(whole), toliman_cae_destroy(cancelled), toliman_cae_destroy(longer);
}

/* A signal of 1e-2 px is above the noise: the latents of new frames follow it, up to sign and scale. */
TEST(test_learns_a_large_signal) {
    Source source = make_source(1e-2);
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    toliman_cae_train_options options = options_for(&source, kMostFrames, 9);
    toliman_cae_training report = {.struct_size = sizeof report};
    assert_ok(toliman_cae_train(cae, &options, &report));
    enum { kFresh = 24 };
    double *frames = new_image((size_t)kFresh * kPixels), displacements[kFresh], latents[kFresh];
    for (int i = 0; i < kFresh; i++)
        displacements[i] = 1e-2 * sin(1.3 * i + 0.4);
    assert_ok(toliman_sim_frame(sim, displacements, 6, 0, kFresh, frames));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frames), kFresh, latents, NULL));
    double sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (int i = 0; i < kFresh; i++) {
        const double x = displacements[i], y = latents[i];
        sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y;
    }
    const double r = (sxy - sx * sy / kFresh) / sqrt((sxx - sx * sx / kFresh) * (syy - sy * sy / kFresh));
    assert_true(fabs(r) > 0.95);
    assert_true(report.cosine == 0 && report.mssim > 0.99);
    free(frames), toliman_cae_destroy(cae);
}

TEST(test_paper_has_no_decoder_without_a_frame) {
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_RAW);
    const toliman_cae_info info = cae_info_of(cae);
    assert_string_equal(info.layout, "paper");
    assert_true(info.input == TOLIMAN_CAE_INPUT_RAW && info.parameters == 97858 && info.input_scale == 1);
    double *image = new_image(kPixels), *frame = new_image(kPixels), mmse = -1;
    assert_refused(toliman_cae_decode(cae, 0, image, kSide), TOLIMAN_E_UNSUPPORTED, "");
    assert_ok(toliman_sim_expect(sim, 0, frame, kSide));
    assert_ok(toliman_cae_reconstruct(cae, frame, kSide, image, kSide, &mmse, NULL, NULL));
    assert_true(isfinite(mmse) && mmse > 0);
    assert_refused(toliman_cae_train(cae, NULL, NULL), TOLIMAN_E_UNSUPPORTED, "");
    free(image), free(frame), toliman_cae_destroy(cae);
}

static int32_t cancel(const char *stage, double fraction, void *user_data) {
    (void)stage, (void)fraction, (void)user_data;
    return 1;
}

/* A training that cannot start leaves the last training resumable. */
/* promise: failed-training-keeps-weights */
TEST(test_failures_keep_the_last_training) {
    Source source = make_source(1e-2);
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_WHITENED), *loaded = NULL;
    toliman_cae_train_options options = options_for(&source, 10, 2), known = {.struct_size = sizeof known};
    toliman_cae_info info = {.struct_size = sizeof info};
    assert_ok(toliman_cae_get_info(cae, &known, &info));
    assert_true(known.mode == 0 && known.steps == 0 && known.learning_rate == 0 && known.frame_count == 0 &&
                known.validation == 0 && known.batch == 0 && known.threads == 0 && known.frames == NULL);
    assert_ok(toliman_cae_train(cae, &options, NULL));
    size_t size, size_after;
    uint8_t *before = saved_with_training(cae, &size);

    assert_refused(toliman_cae_train(cae, NULL, NULL), TOLIMAN_E_UNSUPPORTED, "");
    options.batch = 5;
    source.failure = TOLIMAN_E_NOT_FOUND;
    assert_refused(toliman_cae_train(cae, &options, NULL), TOLIMAN_E_NOT_FOUND, "frames");
    source.failure = TOLIMAN_OK;
    options.progress = cancel;
    assert_refused(toliman_cae_train(cae, &options, NULL), TOLIMAN_E_CANCELLED, "");
    uint8_t *after = saved_with_training(cae, &size_after);
    assert_true(size == size_after);
    assert_memory_equal(before, after, size);

    assert_ok(toliman_cae_load(before, size, NULL, &loaded));
    assert_ok(toliman_cae_get_info(loaded, &known, &info));
    assert_true(known.mode == TOLIMAN_CAE_MODE_UNSUPERVISED && known.steps == 2 && known.batch == 4 &&
                known.learning_rate == 1e-3 && known.frame_count == 10 && known.validation == 1 &&
                known.frames == NULL && known.progress == NULL);
    toliman_cae_training report = {.struct_size = sizeof report};
    known.steps = 3;
    known.frames = give_frames;
    known.frames_data = &source;
    assert_ok(toliman_cae_train(loaded, &known, &report));
    options = options_for(&source, 10, 3);
    assert_ok(toliman_cae_train(cae, &options, NULL));
    assert_true(report.steps == 9 && first_latent(loaded) == first_latent(cae));
    assert_invalid(toliman_cae_get_info(cae, &known, NULL), "out");
    known.struct_size = 4;
    assert_invalid(toliman_cae_get_info(cae, &known, &info), "resumable->struct_size");
    free(before), free(after), toliman_cae_destroy(cae), toliman_cae_destroy(loaded);
}

/* Tied training gives the same network, regardless of earlier training. */
TEST(test_tied_after_unsupervised) {
    Source source = make_source(1e-2);
    toliman_cae *fresh = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    toliman_cae *used = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    toliman_cae_train_options options = options_for(&source, 4, 1);
    assert_ok(toliman_cae_train(used, &options, NULL));
    options = (toliman_cae_train_options)TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 20;
    assert_ok(toliman_cae_train(used, &options, NULL));
    assert_ok(toliman_cae_train(fresh, &options, NULL));
    size_t size;
    uint8_t *expected = saved(fresh, &size);
    assert_saved(used, expected, size);
    free(expected), toliman_cae_destroy(fresh), toliman_cae_destroy(used);
}

/* A learning rate that is too large, stopped after some epochs: the result is usable and can be saved, or the error is
 * E_RANGE. */
TEST(test_divergence_is_never_a_result) {
    Source source = make_source(1e-2);
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED);
    toliman_cae_train_options options = options_for(&source, 2, 0);
    toliman_status status = TOLIMAN_OK;
    options.learning_rate = 1;
    for (options.steps = 3; options.steps <= 15; options.steps += 4) {
        toliman_cae_training report = {.struct_size = sizeof report};
        toliman_cae *loaded = NULL;
        status = toliman_cae_train(cae, &options, &report);
        assert_true(status == TOLIMAN_OK || status == TOLIMAN_E_RANGE);
        if (status == TOLIMAN_OK) /* one frame is held out, however few there are */
            assert_true(isfinite(report.validation_loss) && report.validation_loss > 0 && report.mmse > 0);
        size_t size;
        uint8_t *bytes = saved_with_training(cae, &size);
        assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
        free(bytes), toliman_cae_destroy(loaded);
    }
    assert_int_equal(status, TOLIMAN_E_RANGE);
    toliman_cae_destroy(cae);
}

/* Other ranges of options: bind/test_options. */
TEST(test_refusals) {
    Source source = make_source(1e-2), failing = source, poisoned = source, dark = source;
    failing.failure = TOLIMAN_E_NOT_FOUND;
    poisoned.poisoned = 1;
    dark.dark = 1;
    const struct {
        Source *source; /* NULL: no callback */
        uint64_t frames, validation;
        uint32_t batch;
        int32_t mode;
        toliman_status status;
        const char *field;
    } cases[] = {{NULL, 10, 0, 4, 0, TOLIMAN_E_ARGUMENT, "options->frames"},
                 {&source, 1, 0, 4, 0, TOLIMAN_E_ARGUMENT, "options->frame_count"},
                 {&source, 10, 10, 4, 0, TOLIMAN_E_ARGUMENT, "options->validation"},
                 {&source, 10, 0, 4, 223, TOLIMAN_E_ARGUMENT, "options->mode"},
                 {&failing, 10, 0, 4, 0, TOLIMAN_E_NOT_FOUND, "frames"},
                 {&poisoned, 10, 0, 4, 0, TOLIMAN_E_ARGUMENT, "counts[3][9]"},
                 {&dark, 10, 0, 4, 0, TOLIMAN_E_ARGUMENT, "counts"}};
    toliman_cae *cae = make_network(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_RESIDUAL), *out = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_cae_train_options options = options_for(cases[i].source, cases[i].frames, 1);
        options.frames = cases[i].source != NULL ? give_frames : NULL;
        options.validation = cases[i].validation;
        options.batch = cases[i].batch;
        options.mode = cases[i].mode != 0 ? cases[i].mode : TOLIMAN_CAE_MODE_UNSUPERVISED;
        assert_refused(toliman_cae_train(cae, &options, NULL), cases[i].status, cases[i].field);
    }
    toliman_cae_train_options options = options_for(&source, 10, 30);
    options.learning_rate = 1;
    assert_refused(toliman_cae_train(cae, &options, NULL), TOLIMAN_E_RANGE, "learning_rate");
    first_latent(cae);

    const struct {
        toliman_cae_options options;
        const char *field;
    } wrong[] = {{{.layout = 204}, "options->layout"}, {{.input = 214}, "options->input"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        toliman_cae_options how = wrong[i].options;
        how.struct_size = sizeof how;
        assert_invalid(toliman_cae_create(sim, 1, &how, &out), wrong[i].field);
    }
    toliman_sim *projecting = make_sim(kSide, kSide, 0, "\"flux_a\"");
    const toliman_cae_options raw = {.struct_size = sizeof raw, .input = TOLIMAN_CAE_INPUT_RAW};
    assert_refused(toliman_cae_create(projecting, 1, &raw, &out), TOLIMAN_E_UNSUPPORTED, "preprocess.project");
    assert_null(out);
    toliman_sim_destroy(projecting), toliman_cae_destroy(cae);
}

RUN_TESTS(set_up, tear_down)
