/* Tests the network end to end: latents in px, preprocessing, decoder, training and reconstruction. */
#include "cae_scene.h"
#include "images.h"
#include "scene_text.h"

static toliman_sim *sim;       /* 256x256, nothing projected out */
static toliman_cae *untrained; /* seed 7 */
static toliman_cae *trained;   /* the same network after 100 steps */
static toliman_cae_training training = {.struct_size = sizeof training};

FIXTURE(set_up) {
    sim = make_sim(kSide, kSide, 0, "");
    untrained = make_cae(sim, 7, 0, NULL);
    trained = make_cae(sim, 7, 100, &training);
    return 0;
}

FIXTURE(tear_down) {
    toliman_cae_destroy(untrained), toliman_cae_destroy(trained), toliman_sim_destroy(sim), toliman_cae_destroy(NULL);
    return 0;
}

static double dot(const double *a, const double *b) {
    long double sum = 0;
    for (int i = 0; i < kPixels; i++)
        sum += (long double)a[i] * b[i];
    return (double)sum;
}

/* FNV-1a of the layout's name, the tensors' names and their dimensions as little-endian u32. */
static uint64_t expected_hash(const char *layout, uint32_t deep) {
    const struct {
        const char *name;
        uint32_t size[4];
    } tensors[] = {{layout, {0}},
                   {"conv1.weight", {8, 1, 3, 3}},
                   {"conv1.bias", {8}},
                   {"conv2.weight", {16, 8, 3, 3}},
                   {"conv2.bias", {16}},
                   {"conv3.weight", {32, 16, 3, 3}},
                   {"conv3.bias", {32}},
                   {"conv4.weight", {64, 32, 3, 3}},
                   {"conv4.bias", {64}},
                   {"latent.weight", {deep, deep, 64}},
                   {"latent.bias", {1}},
                   {"expand.weight", {deep, deep, 64}},
                   {"expand.bias", {deep, deep, 64}},
                   {"deconv4.weight", {64, 32, 3, 3}},
                   {"deconv4.bias", {32}},
                   {"deconv3.weight", {32, 16, 3, 3}},
                   {"deconv3.bias", {16}},
                   {"deconv2.weight", {16, 8, 3, 3}},
                   {"deconv2.bias", {8}},
                   {"deconv1.weight", {8, 1, 3, 3}},
                   {"deconv1.bias", {1}}};
    uint64_t hash = 14695981039346656037u;
    for (size_t t = 0; t < sizeof tensors / sizeof tensors[0]; t++) {
        for (const char *c = tensors[t].name; *c != 0; c++)
            hash = (hash ^ (uint8_t)*c) * 1099511628211u;
        for (int d = 0; d < 4 && tensors[t].size[d] != 0; d++)
            for (int byte = 0; byte < 4; byte++)
                hash = (hash ^ ((tensors[t].size[d] >> (8 * byte)) & 255)) * 1099511628211u;
    }
    return hash;
}

TEST(test_info) {
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    toliman_cae_info info = cae_info_of(untrained);
    assert_string_equal(info.layout, "flight");
    assert_true(info.layout_hash == expected_hash("flight", 16));
    assert_true(info.parameters == 97858);
    assert_true(info.trained == 0 && info.cosine == 0 && info.projected == 0);
    assert_true(info.side == kSide && info.rows == kSide && info.cols == kSide && info.crop_row == 0 &&
                info.crop_col == 0);
    assert_true(info.crb_px == bounds.crb_projected_px);
    assert_true(info.input_scale == 1e-3 && info.seed == 7);
    info = cae_info_of(trained);
    assert_true(info.trained == 1 && info.cosine == training.cosine);
}

TEST(test_latent_is_the_separation_in_px) {
    const toliman_cae *networks[] = {untrained, trained};
    const double displacements[] = {1e-7, 1e-6, 1e-5};
    for (int n = 0; n < 2; n++) {
        assert_at_most(fabs(encode_expected(networks[n], sim, 0)), 1e-14);
        for (int i = 0; i < 3; i++) {
            const double d = displacements[i];
            const double slope =
                (encode_expected(networks[n], sim, d) - encode_expected(networks[n], sim, -d)) / (2 * d);
            /* The curvature of ELU adds a relative error proportional to d. */
            assert_close(slope, 1, 0, d < 5e-6 ? 1e-3 : 1e-2);
        }
    }
}

TEST(test_target_is_the_whitened_derivative) {
    double *target = new_image(kPixels), *derivative = new_image(kPixels), *variance = new_image(kPixels);
    assert_ok(toliman_cae_get_target(trained, target, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_SEPARATION, derivative, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, kSide));
    for (int i = 0; i < kPixels; i++)
        assert_close(target[i], derivative[i] / sqrt(variance[i]), 1e-6, 0);
    free(target), free(derivative), free(variance);
}

TEST(test_training_reaches_the_target) {
    assert_int_equal(training.steps, 100);
    assert_at_most(training.loss, 0.1);
    assert_close(training.cosine, sqrt(1 - training.loss), 1e-6, 0); /* cosine and tangent of one right triangle */
}

static void assert_trained_as_stated(const toliman_cae_training *report) {
    assert_int_equal(report->steps, 300);
    assert_at_most(0.985, report->cosine);
    assert_close(report->loss, 0.02, 0, 5e-3);
}

/* Figures of the default training stated in the header: the cosine for any seed, and with coarse pixels; the
 * nonlinearity of ELU, latent over displacement, for both signs. */
/* promise: tied-efficiency-is-stated */
TEST(test_figures_of_the_header) {
    const struct {
        double displacement, slope;
    } said[] = {{1e-4, 0.9996}, {1e-3, 0.996}, {1e-2, 0.96}, {-1e-4, 0.9996}, {-1e-3, 0.997}, {-1e-2, 0.97}};
    const char *const scenes[] = {"examples/scenes/mission.json", "examples/scenes/chapter.json"};
    for (uint64_t seed = in_long() ? 1 : 2; seed <= 2; seed++) {
        toliman_sim *scene = NULL;
        assert_ok(toliman_sim_create_file(scenes[seed - 1], NULL, &scene));
        toliman_cae *cae = make_cae(scene, seed, 0, NULL);
        toliman_cae_training report = {.struct_size = sizeof report};
        assert_ok(toliman_cae_train(cae, NULL, &report));
        assert_trained_as_stated(&report);
        for (size_t k = 0; seed == 2 && k < sizeof said / sizeof *said; k++) {
            const double change = encode_expected(cae, scene, said[k].displacement) - encode_expected(cae, scene, 0);
            assert_close(1 - change / said[k].displacement, 1 - said[k].slope, 0.35, 0);
        }
        toliman_cae_destroy(cae), toliman_sim_destroy(scene);
    }
}

/* Training with the largest learning rate converges badly, but every number stays finite. */
/* promise: tied-training-never-diverges */
TEST(test_no_rate_diverges) {
    toliman_cae *cae = make_cae(sim, 7, 0, NULL);
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    toliman_cae_training report = {.struct_size = sizeof report};
    options.steps = 300;
    options.learning_rate = 1;
    assert_ok(toliman_cae_train(cae, &options, &report));
    assert_true(report.cosine > 0 && report.cosine <= 1);
    assert_close(encode_expected(cae, sim, 1e-6), 1e-6, 0.05, 0);
    toliman_cae_destroy(cae);
}

/* The decoder's output is the target: gain 1, the cosine of the training result, and the same shape for every small
 * latent. */
TEST(test_decode_is_linear) {
    double *target = new_image(kPixels), *zero = new_image(kPixels), *image = new_image(kPixels);
    assert_ok(toliman_cae_get_target(trained, target, kSide));
    assert_ok(toliman_cae_decode(trained, 0, zero, kSide));
    const double latents[] = {1e-8, 1e-6, 1e-4, 1, -1};
    for (int k = 0; k < 5; k++) {
        assert_ok(toliman_cae_decode(trained, latents[k], image, kSide));
        for (int i = 0; i < kPixels; i++)
            image[i] = (image[i] - zero[i]) / latents[k];
        assert_close(dot(image, target) / dot(target, target), 1, 0, 5e-3);
        assert_close(dot(image, target) / sqrt(dot(image, image) * dot(target, target)), training.cosine, 0, 1e-3);
    }
    free(target), free(zero), free(image);
}

/* For small residuals r the latent is <D, r>/<D, target>, where D is the decoder's image: encoder and decoder are
 * transposes. */
TEST(test_encoder_is_the_transposed_decoder) {
    double *target = new_image(kPixels), *decoded = new_image(kPixels), *frame = new_image(kPixels);
    double *reference = new_image(kPixels), *variance = new_image(kPixels), *residual = new_image(kPixels);
    assert_ok(toliman_cae_get_target(trained, target, kSide));
    assert_ok(toliman_cae_decode(trained, 1e-6, decoded, kSide));
    assert_ok(toliman_sim_expect(sim, 0, reference, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, kSide));
    for (int wave = 1; wave <= 5; wave++) {
        double latent;
        for (int i = 0; i < kPixels; i++) {
            residual[i] = 1e-4 * target[i] / fabs(target[i] + 1e-300) * cos(wave * 0.37 * i);
            frame[i] = reference[i] + sqrt(variance[i]) * residual[i];
        }
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
        const double scale = 1e-4 * sqrt(dot(decoded, decoded) * kPixels) / dot(decoded, target);
        assert_close(latent, dot(decoded, residual) / dot(decoded, target), 0, 1e-4 * scale);
    }
    free(target), free(decoded), free(frame), free(reference), free(variance), free(residual);
}

static int32_t stop_half_way(const char *stage, double fraction, void *calls) {
    assert_true(strstr(stage, "train: step ") == stage);
    ++*(int *)calls;
    return fraction >= 0.5;
}

/* promises: failed-training-keeps-weights, stopped-objects-stay-usable */
TEST(test_cancelled_training_changes_nothing) {
    size_t size;
    int calls = 0;
    uint8_t *before = saved(trained, &size);
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 8;
    options.progress = stop_half_way;
    options.progress_data = &calls;
    assert_refused(toliman_cae_train(trained, &options, NULL), TOLIMAN_E_CANCELLED, "");
    assert_int_equal(calls, 4);
    assert_saved(trained, before, size);
    free(before);
}

static int32_t count_calls(const char *stage, double fraction, void *calls) {
    (void)stage, (void)fraction;
    ++*(int *)calls;
    return 0;
}

/* Resumes a cancelled training, also from a file, with the same bits as an uninterrupted one. */
/* promises: cancelled-training-resumes, stopped-objects-stay-usable */
TEST(test_resume_after_cancellation) {
    toliman_cae *broken = make_cae(sim, 7, 0, NULL), *loaded = NULL;
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    int calls = 0;
    options.steps = 100;
    options.progress = stop_half_way;
    options.progress_data = &calls;
    double losses[100];
    for (int k = 0; k < 100; k++)
        losses[k] = -1;
    options.losses = losses;
    options.loss_count = 99; /* one less than in the resumed training */
    assert_refused(toliman_cae_train(broken, &options, NULL), TOLIMAN_E_CANCELLED, "");
    assert_true(losses[0] > 0.5 && losses[0] < 1 && losses[49] < losses[0] && losses[50] == -1);

    size_t size, trained_size;
    uint8_t *bytes = saved_with_training(broken, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
    free(bytes);

    uint8_t *expected = saved(trained, &trained_size);
    toliman_cae *both[] = {broken, loaded};
    for (int i = 0; i < 2; i++) {
        toliman_cae_training report = {.struct_size = sizeof report};
        calls = 0;
        options.progress = count_calls;
        losses[0] = -2;
        assert_ok(toliman_cae_train(both[i], &options, &report));
        assert_int_equal(calls, 50);
        assert_true(losses[0] == -2 && losses[98] < losses[50] && losses[99] == -1); /* counts only its own steps */
        assert_true(fabs(losses[98] / training.loss - 1) < 0.01);
        assert_true(report.loss == training.loss && report.steps == 100);
        assert_saved(both[i], expected, trained_size);
        toliman_cae_destroy(both[i]);
    }
    free(expected);
}

/* Dark current so large that the stars are below the rounding of the expected image. */
TEST(test_no_light_to_centre_the_crop_on) {
    char json[2048];
    write_scene(json, sizeof json, kSide, kSide + 4, 0, "");
    char *text = replaced(json, "\"relative_flux\": 3", "\"photons_per_s\": 1e-4");
    text = replaced_again(text, "\"relative_flux\": 1", "\"photons_per_s\": 1e-4");
    text = replaced_again(text, "\"peak_photons\": 1e9", "\"exposure_s\": 100");
    text = replaced_again(text, "\"pixel\": \"point\"", "\"pixel\": \"point\", \"dark_e_per_s\": 1e9");
    toliman_sim *dark = sim_of(text);
    toliman_cae *cae = NULL;
    assert_refused(toliman_cae_create(dark, 1, NULL, &cae), TOLIMAN_E_SCENE, "");
    assert_null(cae);
    toliman_sim_destroy(dark), free(text);
}

/* The scatter of the latents of noisy frames is as the cosine predicts: sigma = crb / cosine. */
TEST(test_efficiency_is_the_cosine) {
    enum { kFrames = 100 };
    static double displacements[kFrames];
    double *frame = new_image(kPixels), sum = 0, squares = 0;
    const toliman_cae_info info = cae_info_of(trained);
    for (int k = 0; k < kFrames; k++) {
        double latent;
        assert_ok(toliman_sim_frame(sim, &displacements[k], 99, k, 1, frame));
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
        sum += latent;
        squares += latent * latent;
    }
    const double sigma = sqrt(squares / kFrames - sum / kFrames * sum / kFrames);
    assert_close(sigma, info.crb_px / info.cosine, 0.25, 0); /* 3.5 standard errors of 100 frames */
    assert_at_most(fabs(sum / kFrames), 4 * sigma / sqrt(kFrames));
    free(frame);
}

TEST(test_reconstruction) {
    double *frame = new_image(kPixels), *image = new_image(kPixels), *variance = new_image(kPixels);
    double mmse, mssim, floor_, low = 1e300, high = -1e300, error = 0, noise = 0;
    assert_ok(toliman_sim_frame(sim, &(double){0}, 5, 0, 1, frame));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, kSide));
    assert_ok(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, &mmse, &mssim, &floor_));
    for (int i = 0; i < kPixels; i++) {
        low = fmin(low, frame[i]);
        high = fmax(high, frame[i]);
        error += (image[i] - frame[i]) * (image[i] - frame[i]);
        noise += variance[i];
    }
    assert_close(mmse, error / kPixels / (high - low) / (high - low), 1e-9, 0);
    assert_close(floor_, noise / kPixels / (high - low) / (high - low), 1e-6, 0);
    assert_close(mmse, floor_, 0.03, 0);
    assert_true(mssim < 1);
    assert_at_most(1 - mssim, 1e-6);
    assert_ok(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, NULL, NULL, NULL));
    for (int i = 0; i < kPixels; i++)
        frame[i] = 3;
    assert_invalid(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, &mmse, NULL, NULL), "counts");
    free(frame), free(image), free(variance);
}

/* A frame larger than the crop and off centre, with nuisances projected out. */
TEST(test_crop_and_projection) {
    enum { kRows = 270, kCols = 300, kFrame = kRows * kCols };
    toliman_sim *wide = make_sim(kRows, kCols, 9, "\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\"");
    toliman_cae *cae = make_cae(wide, 1, 20, NULL);
    double *reference = new_image(kFrame), *change = new_image(kFrame), *frame = new_image(kFrame);
    double light = 0, row = 0, col = 0, latent;
    assert_ok(toliman_sim_expect(wide, 0, reference, kCols));
    for (int i = 0; i < kFrame; i++) {
        light += reference[i];
        row += reference[i] * (i / kCols);
        col += reference[i] * (i % kCols);
    }
    const toliman_cae_info info = cae_info_of(cae);
    assert_true(info.rows == kRows && info.cols == kCols && info.projected == 4);
    assert_true(info.crop_row == (int64_t)fmin(fmax(floor(row / light - 127.5 + 0.5), 0), kRows - kSide));
    assert_true(info.crop_col == (int64_t)fmin(fmax(floor(col / light - 127.5 + 0.5), 0), kCols - kSide));
    assert_true(info.crop_col > 0 && info.crop_col < kCols - kSide);

    const struct {
        int32_t kind;
        double size;
    } nuisances[] = {{TOLIMAN_SIM_IMAGE_STAR_A, 1e-4},
                     {TOLIMAN_SIM_IMAGE_STAR_B, -1e-4},
                     {TOLIMAN_SIM_IMAGE_SHIFT_X, 1e-3},
                     {TOLIMAN_SIM_IMAGE_SHIFT_Y, -1e-3}};
    for (int k = 0; k < 4; k++) {
        assert_ok(toliman_sim_get_image(wide, nuisances[k].kind, change, kCols));
        for (int i = 0; i < kFrame; i++)
            frame[i] = reference[i] + nuisances[k].size * change[i];
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
        assert_at_most(fabs(latent), 1e-3 * info.crb_px);
    }
    assert_ok(toliman_sim_expect(wide, 1e-6, frame, kCols));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    assert_close(latent, 1e-6, 1e-3, 0);

    const size_t first = (size_t)info.crop_row * kCols + (size_t)info.crop_col;
    frame[first - 1] = NAN; /* outside the crop: ignored */
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    frame[first + 2 * kCols + 3] = INFINITY;
    char text[64];
    snprintf(text, sizeof text, "counts[%d][%d]", (int)info.crop_row + 2, (int)info.crop_col + 3);
    latent = -5;
    assert_invalid(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL), text);
    assert_true(latent == -5);
    free(reference), free(change), free(frame), toliman_cae_destroy(cae), toliman_sim_destroy(wide);
}

/* Ranges of options: bind/test_options; images: test_images. */
TEST(test_arguments) {
    static double image[kPixels];
    double latent;
    size_t needed;
    toliman_cae *out = NULL;
    assert_invalid(toliman_cae_create(NULL, 1, NULL, &out), "sim");
    assert_invalid(toliman_cae_create(sim, 1, NULL, NULL), "out");
    assert_invalid(toliman_cae_encode(trained, PLAIN_IMAGE(image), 1, NULL, NULL), "latents_px");
    assert_invalid(toliman_cae_decode(trained, NAN, image, kSide), "latent_px");
    assert_invalid(toliman_cae_decode(trained, 0, image, 3), "stride");
    assert_invalid(toliman_cae_get_target(NULL, image, kSide), "cae");
    assert_invalid(toliman_cae_save(trained, NULL, NULL, 0, NULL), "needed");
    assert_refused(toliman_cae_save(trained, NULL, image, 100, &needed), TOLIMAN_E_CAPACITY, "capacity");
    toliman_cae_training report = {.struct_size = 1};
    assert_invalid(toliman_cae_train(trained, NULL, &report), "report->struct_size");
    toliman_cae_train_options nowhere = {.struct_size = sizeof nowhere, .loss_count = 1};
    assert_invalid(toliman_cae_train(trained, &nowhere, NULL), "options->losses");
    for (int i = 0; i < kPixels; i++)
        image[i] = 1e300;
    assert_refused(toliman_cae_encode(trained, PLAIN_IMAGE(image), 1, &latent, NULL), TOLIMAN_E_RANGE, "counts");
}

/* Counts that can be encoded, but whose latent is beyond the decoder's range: the error must name the counts. */
TEST(test_counts_too_far_to_reconstruct) {
    static double frame[kPixels], image[kPixels];
    double latent = 0;
    for (double size = 1e9; fabs(latent) <= 1e6; size *= 10) {
        assert_true(size < 1e40);
        for (int i = 0; i < kPixels; i++)
            frame[i] = size;
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
    }
    image[0] = -5;
    assert_refused(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, NULL, NULL, NULL), TOLIMAN_E_RANGE,
                   "counts");
    assert_true(image[0] == -5);
}

/* A frame whose contrast is negligible compared with the image it is compared to. */
TEST(test_figures_that_overflow) {
    static double frame[kPixels], image[kPixels];
    double mmse = -5;
    frame[7] = 1e-300;
    assert_refused(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, &mmse, NULL, NULL), TOLIMAN_E_RANGE,
                   "counts");
    assert_true(mmse == -5);
    assert_ok(toliman_cae_reconstruct(trained, frame, kSide, image, kSide, NULL, NULL, NULL));
}

/* A single star with shift_x projected out: the remaining signal is zero, and rounding errors must not pass for a
 * signal. */
TEST(test_no_signal_is_left) {
    const char *const projects[] = {"\"shift_x\"", "\"shift_x\", \"shift_y\", \"flux_a\""};
    for (int k = 0; k < 2; k++) {
        char json[1024];
        const int size =
            snprintf(json, sizeof json,
                     "{\"schema\": \"toliman-scene/1\", \"telescope\": {\"aperture_m\": 0.125, \"pupil_samples\": 128},"
                     "\"band\": {\"wavelength_nm\": 550},"
                     "\"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}}},"
                     "\"cadence\": {\"frames\": 10, \"peak_photons\": 1e6},"
                     "\"detector\": {\"shape\": [256, 256], \"pixel_scale_arcsec\": 0.1},"
                     "\"preprocess\": {\"project\": [%s]}}",
                     projects[k]);
        toliman_sim *single = NULL;
        toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
        toliman_cae *out = NULL;
        assert_ok(toliman_sim_create_json(json, (size_t)size, NULL, NULL, &single));
        assert_ok(toliman_sim_get_bounds(single, &bounds));
        assert_true(isinf(bounds.crb_projected_px) && isfinite(bounds.crb_px));
        assert_refused(toliman_cae_create(single, 1, NULL, &out), TOLIMAN_E_SCENE, "preprocess.project");
        assert_null(out);
        toliman_sim_destroy(single);
    }
}

RUN_TESTS(set_up, tear_down)
