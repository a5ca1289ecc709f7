/* Tests weights blobs of 16-bit numbers: their content, the effect on the network, and invalid content. */
#include "tlmw.h"

static toliman_sim *sim;
enum { float32, bf16, fp16, PAIRS = 5 };
static const int32_t pairs[PAIRS][2] = {
    {float32, float32}, {float32, bf16}, {float32, fp16}, {bf16, fp16}, {fp16, bf16}}; /* of weights, of planes */
static toliman_cae *trained, *rounded[PAIRS];
static uint8_t *blobs[PAIRS];
static size_t sizes[PAIRS];

static toliman_cae *loaded_from(const uint8_t *bytes, size_t size) {
    toliman_cae *out = NULL;
    assert_ok(toliman_cae_load(bytes, size, NULL, &out));
    return out;
}

FIXTURE(set_up) {
    sim = make_sim(kSide, kSide, 0, "\"flux_a\"");
    trained = make_cae(sim, 3, 100, NULL);
    for (int k = 0; k < PAIRS; k++) {
        blobs[k] = saved_as(trained, pairs[k][0], pairs[k][1], &sizes[k]);
        rounded[k] = loaded_from(blobs[k], sizes[k]);
    }
    return 0;
}

FIXTURE(tear_down) {
    for (int k = 0; k < PAIRS; k++) {
        free(blobs[k]), toliman_cae_destroy(rounded[k]);
    }
    toliman_cae_destroy(trained), toliman_sim_destroy(sim);
    return 0;
}

static void assert_blob(const toliman_cae *cae, int pair) {
    size_t size;
    uint8_t *bytes = saved_as(cae, pairs[pair][0], pairs[pair][1], &size);
    assert_true(size == sizes[pair]);
    assert_memory_equal(bytes, blobs[pair], size);
    free(bytes);
}

/* promise: networks-save-same-bytes */
TEST(test_same_bytes_after_loading) {
    for (int k = 0; k < PAIRS; k++) {
        assert_int_equal(get(blobs[k] + kAtWeightsEncoding, 2), pairs[k][0]);
        assert_int_equal(get(blobs[k] + kAtPlanesEncoding, 2), pairs[k][1]);
        assert_blob(rounded[k], k);
        const size_t saved_bytes = (pairs[k][0] ? kParameters : 0u) + (pairs[k][1] ? 3u * kPixels : 0u);
        assert_true(sizes[k] + saved_bytes <= sizes[0]);
    }
    for (int k = 3; k < PAIRS; k++) { /* float32 represents every 16-bit number exactly */
        size_t size;
        uint8_t *bytes = saved(rounded[k], &size);
        toliman_cae *wide = loaded_from(bytes, size);
        assert_blob(wide, k);
        toliman_cae_destroy(wide), free(bytes);
    }
}

/* The bit patterns of 0.625 from the definition of the formats; one tensor in fp16 stores it as 5 times 2^-3. */
TEST(test_blobs_written_from_the_specification) {
    static uint8_t raw[2 * kParameters + 2 * kTensors];
    static double frame[kPixels];
    size_t size;
    uint8_t *header = blobs[0];
    for (int32_t encoding = bf16; encoding <= fp16; encoding++) {
        memset(raw, 0, sizeof raw);
        if (encoding == bf16)
            put(raw + 2 * kLatentBias, 0x3f20, 2);
        else {
            put(raw + 2 * kLatentBias + 2 * 9, 0xfffd, 2); /* the scales of nine tensors precede that of latent.bias */
            put(raw + 2 * kLatentBias + 2 * 9 + 2, 0x4500, 2);
        }
        put(header + kAtWeightsEncoding, (uint64_t)encoding, 2);
        double latent = 0;
        uint8_t *bytes = with_raw(header, raw, 2 * kParameters + (encoding == fp16 ? 2 * kTensors : 0), NULL, 0, &size);
        toliman_cae *cae = loaded_from(bytes, size);
        free(bytes);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, frame));
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
        assert_true(latent == 0.625);
        toliman_cae_destroy(cae);
    }
    put(header + kAtWeightsEncoding, float32, 2);
}

/* The derivative image can be read as a plane: 8 bits, or 11 bits down to 2^-30 of its maximum. */
TEST(test_rounding_of_planes) {
    static double exact[kPixels], target[kPixels];
    assert_ok(toliman_cae_get_target(trained, exact, kSide));
    double largest = 0;
    for (int i = 0; i < kPixels; i++)
        largest = fmax(largest, fabs(exact[i]));
    for (int32_t encoding = bf16; encoding <= fp16; encoding++) {
        const double precision = encoding == bf16 ? 0x1p-8 : 0x1p-11;
        assert_ok(toliman_cae_get_target(rounded[encoding], target, kSide));
        double worst = 0;
        for (int i = 0; i < kPixels; i++) {
            assert_close(target[i], exact[i], precision, largest * 0x1p-39);
            worst = fmax(worst, fabs(target[i] / exact[i] - 1));
        }
        assert_true(worst > precision / 2);
    }
}

/* The reference reaches 1e9 counts and stays exact: without noise and displacement the latent equals that of
 * float32. */
TEST(test_no_bias) {
    const double zero = encode_expected(trained, sim, 0);
    for (int k = 0; k < PAIRS; k++)
        assert_close(encode_expected(rounded[k], sim, 0), zero, 0, 1e-11);
}

TEST(test_latents_keep_their_slope_and_scatter) {
    enum { kFrames = 40 };
    static double frame[kPixels], latents[PAIRS][kFrames];
    for (int i = 0; i < kFrames; i++) {
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, i, 1, frame));
        for (int k = 0; k < PAIRS; k++)
            assert_ok(toliman_cae_encode(rounded[k], PLAIN_IMAGE(frame), 1, &latents[k][i], NULL));
    }
    for (int k = 0; k < PAIRS; k++) {
        const toliman_cae *cae = rounded[k];
        const double slope = (encode_expected(cae, sim, 1e-5) - encode_expected(cae, sim, -1e-5)) / 2e-5;
        double change = 0, scatter = 0;
        for (int i = 0; i < kFrames; i++) {
            change += pow(latents[k][i] - latents[0][i], 2);
            scatter += pow(latents[0][i], 2);
        }
        const int coarse = pairs[k][0] == bf16 || pairs[k][1] == bf16;
        assert_close(slope, 1, coarse ? 2e-3 : 3e-4, 0);
        assert_true(sqrt(change / scatter) < (k == 0 ? 1e-300 : coarse ? 2e-2 : 3e-3));
    }
}

/* Numbers from the smallest to the largest that a blob can hold, all just below powers of two. In fp16, whose range is
 * smaller, no variance may become 0 and no number infinite. */
TEST(test_numbers_of_any_size) {
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    static double frame[kPixels];
    for (int reach = 226; reach > 0; reach -= 75)
        for (int top = 100; top >= reach - 125; top -= 75) {
            for (int i = 0; i < kFloats; i++)
                planes[i] = i / kPixels < 2 ? 0 : ldexpf(1 - 0x1p-24f, top - i % reach);
            size_t size, size_again;
            uint8_t *bytes = with_payloads(blobs[0], NULL, planes, 5, &size);
            toliman_cae *cae = loaded_from(bytes, size);
            free(bytes);
            bytes = saved_as(cae, fp16, fp16, &size);
            toliman_cae *again = loaded_from(bytes, size);
            uint8_t *bytes_again = saved_as(again, fp16, fp16, &size_again);
            assert_true(size == size_again);
            assert_memory_equal(bytes, bytes_again, size);
            double latent = 0;
            const toliman_status status = toliman_cae_encode(again, PLAIN_IMAGE(frame), 1, &latent, NULL);
            assert_true(status == TOLIMAN_E_RANGE || (status == TOLIMAN_OK && isfinite(latent)));
            toliman_cae_destroy(again), toliman_cae_destroy(cae), free(bytes), free(bytes_again);
        }
}

/* Training on an extremely small or large derivative gives weights at either limit of float32. Saving them is refused,
 * or the blob loads again. */
TEST(test_weights_out_of_range) {
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    toliman_cae_train_options options = {.struct_size = sizeof options, .steps = 1};
    int refusals = 0, failures = 0;
    const int exponents[] = {-126, -126, -112, -100, 0, 60, 97},
              pixels[] = {1, kPixels, kPixels, kPixels, kPixels, kPixels, kPixels};
    for (int k = 0; k < 7; k++) {
        size_t size;
        for (int i = 0; i < kFloats; i++)
            planes[i] = i / kPixels == 2                              ? 1
                        : i / kPixels == 3 && i % kPixels < pixels[k] ? ldexpf(1 + (float)(i % 7), exponents[k])
                                                                      : 0;
        uint8_t *bytes = with_payloads(blobs[0], NULL, planes, 5, &size);
        toliman_cae *cae = loaded_from(bytes, size);
        free(bytes);
        const toliman_status status = toliman_cae_train(cae, &options, NULL);
        if (status == TOLIMAN_E_RANGE) {
            failures++;
            toliman_cae_destroy(cae);
            continue;
        }
        assert_ok(status);
        if (toliman_cae_save(cae, NULL, NULL, 0, &size) == TOLIMAN_E_CAPACITY) {
            bytes = saved(cae, &size);
            toliman_cae_destroy(loaded_from(bytes, size));
            free(bytes);
        } else {
            assert_fails(toliman_cae_save(cae, NULL, NULL, 0, &size), TOLIMAN_E_RANGE, "weights[");
            refusals++;
        }
        toliman_cae_destroy(cae);
    }
    assert_true(refusals > 0 && failures > 0);
}

/* Encodings: bind/test_options. */
TEST(test_options) {
    const struct {
        toliman_cae_save_options options;
        const char *field;
    } cases[] = {{{.struct_size = sizeof cases->options, .planes_encoding = -1}, "options->planes_encoding"},
                 {{.struct_size = sizeof cases->options, .with_training = 2}, "options->with_training"},
                 {{.struct_size = 3}, "options->struct_size"}};
    size_t needed = 7;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_invalid(toliman_cae_save(trained, &cases[i].options, NULL, 0, &needed), cases[i].field);
    assert_true(needed == 7);
}

RUN_TESTS(set_up, tear_down)
