/* Tests the weights blob: round trips, and blobs written by this test from the format's specification. */
#include "test_folder.h"
#include "tlmw.h"

static toliman_sim *sim;
static toliman_cae *trained;
static uint8_t *blob;
static size_t blob_size;

FIXTURE(set_up) {
    sim = make_sim(kSide, 260, 0, "\"flux_a\"");
    trained = make_cae(sim, 3, 15, NULL);
    blob = saved(trained, &blob_size);
    return 0;
}

FIXTURE(tear_down) {
    free(blob), toliman_cae_destroy(trained), toliman_sim_destroy(sim);
    return 0;
}

/* promise: networks-save-same-bytes */
TEST(test_round_trip) {
    toliman_cae *loaded = NULL;
    size_t size;
    assert_ok(toliman_cae_load(blob, blob_size, NULL, &loaded));
    assert_saved(loaded, blob, blob_size);
    assert_asks(toliman_cae_save(loaded, NULL, NULL, 0, &size));
    assert_true(size == blob_size);

    enum { kFrame = kSide * 260 };
    double *frame = new_image(kFrame), *image = new_image(kPixels), *image_loaded = new_image(kPixels);
    for (int64_t k = 0; k < 3; k++) {
        double latent, latent_loaded;
        assert_ok(toliman_sim_frame(sim, &(double){1e-6}, 1, k, 1, frame));
        assert_ok(toliman_cae_encode(trained, PLAIN_IMAGE(frame), 1, &latent, NULL));
        assert_ok(toliman_cae_encode(loaded, PLAIN_IMAGE(frame), 1, &latent_loaded, NULL));
        assert_memory_equal(&latent, &latent_loaded, sizeof latent);
    }
    assert_ok(toliman_cae_decode(trained, 1e-6, image, kSide));
    assert_ok(toliman_cae_decode(loaded, 1e-6, image_loaded, kSide));
    assert_memory_equal(image, image_loaded, kPixels * sizeof *image);
    assert_ok(toliman_cae_get_target(trained, image, kSide));
    assert_ok(toliman_cae_get_target(loaded, image_loaded, kSide));
    assert_memory_equal(image, image_loaded, kPixels * sizeof *image);

    const toliman_cae_info info = cae_info_of(trained), info_loaded = cae_info_of(loaded);
    assert_memory_equal(&info, &info_loaded, sizeof info);
    free(frame), free(image), free(image_loaded), toliman_cae_destroy(loaded);
}

/* A loaded network trains to the same weights as the network it was saved from. */
TEST(test_training_after_loading) {
    toliman_cae *fresh = make_cae(sim, 3, 0, NULL), *loaded = NULL;
    size_t size;
    uint8_t *bytes = saved(fresh, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
    free(bytes);
    toliman_cae_train_options options = {.struct_size = sizeof options, .steps = 15};
    assert_ok(toliman_cae_train(loaded, &options, NULL));
    assert_saved(loaded, blob, blob_size);
    toliman_cae_destroy(fresh), toliman_cae_destroy(loaded);
}

TEST(test_files) {
    char folder[256], path[300];
    toliman_cae *loaded = NULL;
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/network.tlmw", folder);
    assert_refused(toliman_cae_load_file(path, NULL, &loaded), TOLIMAN_E_NOT_FOUND, path);
    assert_ok(toliman_cae_save_file(trained, NULL, path));
    assert_ok(toliman_cae_load_file(path, NULL, &loaded));
    assert_saved(loaded, blob, blob_size);
    toliman_cae_destroy(loaded);
    assert_int_equal(truncate(path, 0), 0);
    assert_refused(toliman_cae_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    remove_folder(folder);
    assert_refused(toliman_cae_save_file(trained, NULL, path), TOLIMAN_E_WRITE, path);
}

static toliman_cae *load_from_file(const uint8_t *bytes, size_t size) {
    char folder[256], path[300];
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/blob", folder);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
    toliman_cae *cae = NULL;
    assert_ok(toliman_cae_load_file(path, NULL, &cae));
    remove_folder(folder);
    return cae;
}

/* A blob written here with uncompressed floats: only latent.bias is non-zero, so every latent equals it. */
TEST(test_blob_written_from_the_specification) {
    static float weights[kParameters];
    static double frame[kSide * 260];
    size_t size;
    double latent;
    toliman_cae *cae = NULL;
    memset(weights, 0, sizeof weights);
    weights[kLatentBias] = 0.625f;
    uint8_t *bytes = with_payloads(blob, weights, NULL, 0, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    assert_true(latent == 0.625);
    free(bytes), toliman_cae_destroy(cae);
}

/* The largest weights that the format allows: an overflow must not be returned as a result. */
TEST(test_weights_that_overflow) {
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
        assert_refused(toliman_cae_decode(cae, 1, image, kSide), TOLIMAN_E_RANGE, "");
        assert_true(image[0] == -5);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, frame));
        const toliman_status status = toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL);
        assert_true(status == TOLIMAN_OK ? isfinite(latent) : status == TOLIMAN_E_RANGE && latent == -5);
        assert_int_equal(toliman_cae_reconstruct(cae, frame, 260, image, kSide, NULL, NULL, NULL), TOLIMAN_E_RANGE);
        assert_true(image[0] == -5);
        toliman_cae_destroy(cae), free(bytes);
    }
}

/* The number in pixels i, i + planes, ... that makes a plane of unit norm. */
static double unit_on(int planes, int i) {
    return 1 / sqrt((kPixels - 1 - i % planes) / planes + 1);
}

/* Orthonormal planes on disjoint pixels, written from the specification and read from a file: as many as the format
   allows are removed from a frame. Up to 8 of them are version 2, more are version 3. */
TEST(test_many_planes) {
    enum { kFrame = kSide * 260, kMost = 32 };
    static float planes[(4 + kMost) * kPixels];
    double *frame = new_image(kFrame);
    const int counts[] = {8, 9, kMost};
    for (int c = 0; c < 3; c++) {
        const int projected = counts[c];
        const uint32_t version = projected > 8 ? 3 : 2;
        memset(planes, 0, sizeof planes);
        for (int i = 0; i < kPixels; i++) {
            planes[i] = 1000;
            planes[2 * kPixels + i] = 4;
            planes[(4 + i % projected) * kPixels + i] = (float)unit_on(projected, i);
        }
        uint8_t *header = malloc(blob_size);
        memcpy(header, blob, blob_size);
        put(header + kAtVersion, version, 4);
        put(header + kAtProjected, (uint64_t)projected, 4);
        size_t size;
        uint8_t *bytes = with_payloads(header, NULL, planes, 4 + (size_t)projected, &size);
        toliman_cae *cae = load_from_file(bytes, size), *again = NULL;
        const toliman_cae_info info = cae_info_of(cae);
        assert_int_equal(info.projected, projected);

        double latent;
        toliman_frame_goodness goodness = TOLIMAN_FRAME_GOODNESS_INIT;
        for (int i = 0; i < kFrame; i++) /* residual: 1e4 times the planes, in sigmas of 2 counts, weighted 1, 2, ... */
            frame[i] = 1000;
        for (int i = 0; i < kPixels; i++)
            frame[i / kSide * 260 + (int)info.crop_col + i % kSide] +=
                2 * 1e4 * unit_on(projected, i) * (1 + i % projected);
        const toliman_image image = {
            .struct_size = sizeof image, .pixels = frame, .pixel = TOLIMAN_PIXEL_F64, .rows = kSide, .cols = 260};
        assert_ok(toliman_cae_encode(cae, &image, 1, &latent, &goodness));
        assert_at_most(goodness.chi_square, 1e-6);

        uint8_t *first = saved(cae, &size);
        assert_int_equal(get(first + kAtVersion, 4), version);
        assert_ok(toliman_cae_load(first, size, NULL, &again));
        assert_saved(again, first, size);
        put(first + kAtVersion, 5 - version, 4); /* the other version refuses as many */
        seal(first, size);
        refused(first, size, version == 3 ? "must be in [0, 8] in version 2" : "must be in [9, 32] in version 3");
        toliman_cae_destroy(cae), toliman_cae_destroy(again), free(header), free(bytes), free(first);
    }
    free(frame);
}

/* A network whose target is zero cannot be trained. */
/* promise: failed-training-keeps-weights */
TEST(test_no_target) {
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    for (int i = 0; i < kFloats; i++)
        planes[i] = i / kPixels != 3;
    size_t size;
    toliman_cae *cae = NULL;
    uint8_t *bytes = with_payloads(blob, NULL, planes, 5, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
    free(bytes);
    bytes = saved(cae, &size);
    assert_refused(toliman_cae_train(cae, NULL, NULL), TOLIMAN_E_STATE, "");
    assert_saved(cae, bytes, size);
    free(bytes), toliman_cae_destroy(cae);
}

TEST(test_arguments) {
    toliman_cae *out = NULL;
    assert_invalid(toliman_cae_load(NULL, 5, NULL, &out), "bytes");
    assert_invalid(toliman_cae_load(blob, blob_size, NULL, NULL), "out");
    assert_invalid(toliman_cae_load_file(NULL, NULL, &out), "path");
    assert_invalid(toliman_cae_save_file(trained, NULL, NULL), "path");
}

RUN_TESTS(set_up, tear_down)
