/* Tests the weights blob: round trips, and blobs written by this test from the format's specification. */
#include <unistd.h>

#include "tlmw.h"

static toliman_sim *sim;
static toliman_cae *trained;
static uint8_t *blob;
static size_t blob_size;

static int set_up(void **unused) {
    (void)unused;
    sim = make_sim(kSide, 260, 0, "\"flux_a\"");
    trained = make_cae(sim, 3, 15, NULL);
    blob = saved(trained, &blob_size);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    free(blob);
    toliman_cae_destroy(trained);
    toliman_sim_destroy(sim);
    return 0;
}

static void test_round_trip(void **unused) {
    (void)unused;
    toliman_cae *loaded = NULL;
    size_t size;
    assert_ok(toliman_cae_load(blob, blob_size, NULL, &loaded));
    uint8_t *again = saved(loaded, &size);
    assert_true(size == blob_size);
    assert_memory_equal(blob, again, size);
    size = 0;
    assert_ok(toliman_cae_save(loaded, NULL, NULL, 0, &size));
    assert_true(size == blob_size);

    enum { kFrame = kSide * 260 };
    double *frame = new_image(kFrame), *image = new_image(kPixels), *image_loaded = new_image(kPixels);
    for (int64_t k = 0; k < 3; k++) {
        double latent, latent_loaded;
        assert_ok(toliman_sim_frame(sim, 1e-6, 1, k, frame, 260));
        assert_ok(toliman_cae_encode(trained, frame, 260, &latent));
        assert_ok(toliman_cae_encode(loaded, frame, 260, &latent_loaded));
        assert_memory_equal(&latent, &latent_loaded, sizeof latent);
    }
    assert_ok(toliman_cae_decode(trained, 1e-6, image, kSide));
    assert_ok(toliman_cae_decode(loaded, 1e-6, image_loaded, kSide));
    assert_memory_equal(image, image_loaded, kPixels * sizeof *image);
    assert_ok(toliman_cae_get_target(trained, image, kSide));
    assert_ok(toliman_cae_get_target(loaded, image_loaded, kSide));
    assert_memory_equal(image, image_loaded, kPixels * sizeof *image);

    toliman_cae_info info = {.struct_size = sizeof info}, info_loaded = {.struct_size = sizeof info};
    assert_ok(toliman_cae_get_info(trained, &info));
    assert_ok(toliman_cae_get_info(loaded, &info_loaded));
    assert_memory_equal(&info, &info_loaded, sizeof info);
    free(again), free(frame), free(image), free(image_loaded);
    toliman_cae_destroy(loaded);
}

/* A loaded network trains to the same weights as the network it was saved from. */
static void test_training_after_loading(void **unused) {
    (void)unused;
    toliman_cae *fresh = make_cae(sim, 3, 0, NULL), *loaded = NULL;
    size_t size;
    uint8_t *bytes = saved(fresh, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
    free(bytes);
    toliman_cae_train_options options;
    toliman_cae_train_options_init(&options, sizeof options);
    options.steps = 15;
    assert_ok(toliman_cae_train(loaded, &options, NULL));
    bytes = saved(loaded, &size);
    assert_true(size == blob_size);
    assert_memory_equal(bytes, blob, size);
    free(bytes);
    toliman_cae_destroy(fresh);
    toliman_cae_destroy(loaded);
}

static void test_files(void **unused) {
    (void)unused;
    char folder[256], path[300];
    toliman_cae *loaded = NULL;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/toliman-cae-XXXXXX", parent != NULL ? parent : P_tmpdir);
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/network.tlmw", folder);
    assert_fails(toliman_cae_load_file(path, NULL, &loaded), TOLIMAN_E_NOT_FOUND, path);
    assert_ok(toliman_cae_save_file(trained, NULL, path));
    assert_ok(toliman_cae_load_file(path, NULL, &loaded));
    size_t size;
    uint8_t *again = saved(loaded, &size);
    assert_true(size == blob_size);
    assert_memory_equal(blob, again, size);
    free(again);
    toliman_cae_destroy(loaded);
    assert_int_equal(truncate(path, 0), 0);
    assert_fails(toliman_cae_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, "network.tlmw: is empty");
    assert_int_equal(remove(path), 0);
    assert_int_equal(rmdir(folder), 0);
    assert_fails(toliman_cae_save_file(trained, NULL, path), TOLIMAN_E_WRITE, path);
}

/* A blob written here with uncompressed floats: only latent.bias is non-zero, so every latent equals it. */
static void test_blob_written_from_the_specification(void **unused) {
    (void)unused;
    static float weights[kParameters];
    static double frame[kSide * 260];
    size_t size;
    double latent;
    toliman_cae *cae = NULL;
    memset(weights, 0, sizeof weights);
    weights[kLatentBias] = 0.625f;
    uint8_t *bytes = with_payloads(blob, weights, NULL, 0, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
    assert_ok(toliman_cae_encode(cae, frame, 260, &latent));
    assert_true(latent == 0.625);
    free(bytes);
    toliman_cae_destroy(cae);
}

/* The largest weights that the format allows: an overflow must not be returned as a result. */
static void test_weights_that_overflow(void **unused) {
    (void)unused;
    static float weights[kParameters];
    static double frame[kSide * 260], image[kPixels];
    const float sizes[] = {1e30f, -1e30f};
    for (int k = 0; k < 2; k++) {
        size_t size;
        double latent;
        toliman_cae *cae = NULL;
        for (int i = 0; i < kParameters; i++)
            weights[i] = i % 3 == 0 ? -sizes[k] : sizes[k];
        uint8_t *bytes = with_payloads(blob, weights, NULL, 0, &size);
        assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
        image[0] = latent = -5;
        assert_fails(toliman_cae_decode(cae, 1, image, kSide), TOLIMAN_E_RANGE, "overflows");
        assert_true(image[0] == -5);
        assert_ok(toliman_sim_frame(sim, 0, 1, 0, frame, 260));
        const toliman_status status = toliman_cae_encode(cae, frame, 260, &latent);
        assert_true(status == TOLIMAN_OK ? isfinite(latent) : status == TOLIMAN_E_RANGE && latent == -5);
        assert_int_equal(toliman_cae_reconstruct(cae, frame, 260, image, kSide, NULL, NULL, NULL), TOLIMAN_E_RANGE);
        assert_true(image[0] == -5);
        toliman_cae_destroy(cae);
        free(bytes);
    }
}

/* A network whose target is zero cannot be trained. */
static void test_no_target(void **unused) {
    (void)unused;
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    for (int i = 0; i < kFloats; i++)
        planes[i] = i / kPixels != 3;
    size_t size, size_after;
    toliman_cae *cae = NULL;
    uint8_t *bytes = with_payloads(blob, NULL, planes, 5, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
    free(bytes);
    bytes = saved(cae, &size);
    assert_fails(toliman_cae_train(cae, NULL, NULL), TOLIMAN_E_STATE, "it must have a signal to train on");
    uint8_t *after = saved(cae, &size_after);
    assert_true(size == size_after);
    assert_memory_equal(bytes, after, size);
    free(bytes), free(after);
    toliman_cae_destroy(cae);
}

static void test_arguments(void **unused) {
    (void)unused;
    toliman_cae *out = NULL;
    assert_fails(toliman_cae_load(NULL, 5, NULL, &out), TOLIMAN_E_ARGUMENT, "bytes is NULL");
    assert_fails(toliman_cae_load(blob, blob_size, NULL, NULL), TOLIMAN_E_ARGUMENT, "out is NULL");
    assert_fails(toliman_cae_load_file(NULL, NULL, &out), TOLIMAN_E_ARGUMENT, "path is NULL");
    assert_fails(toliman_cae_save_file(trained, NULL, NULL), TOLIMAN_E_ARGUMENT, "path is NULL");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_training_after_loading),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_blob_written_from_the_specification),
        cmocka_unit_test(test_weights_that_overflow),
        cmocka_unit_test(test_no_target),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests_name("cae_blob", tests, set_up, tear_down);
}
