/* Tests weights blobs of 16-bit numbers: their content, the effect on the network, and invalid content. */
#include "tlmw.h"

static toliman_sim *sim;
static toliman_cae *trained, *rounded[3][3]; /* [weights encoding][planes encoding] */
static uint8_t *blobs[3][3];
static size_t sizes[3][3];
enum { float32, bf16, fp16 };

static toliman_cae *loaded_from(const uint8_t *bytes, size_t size) {
    toliman_cae *out = NULL;
    assert_ok(toliman_cae_load(bytes, size, NULL, &out));
    return out;
}

static int set_up(void **unused) {
    (void)unused;
    sim = make_sim(kSide, kSide, 0, "\"flux_a\"");
    trained = make_cae(sim, 3, 100, NULL);
    for (int32_t weights = 0; weights < 3; weights++)
        for (int32_t planes = 0; planes < 3; planes++) {
            size_t *size = &sizes[weights][planes];
            blobs[weights][planes] = saved_as(trained, weights, planes, size);
            rounded[weights][planes] = loaded_from(blobs[weights][planes], *size);
        }
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    for (int k = 0; k < 9; k++) {
        free(blobs[k / 3][k % 3]);
        toliman_cae_destroy(rounded[k / 3][k % 3]);
    }
    toliman_cae_destroy(trained);
    toliman_sim_destroy(sim);
    return 0;
}

static void assert_blob(const toliman_cae *cae, int32_t weights, int32_t planes) {
    size_t size;
    uint8_t *bytes = saved_as(cae, weights, planes, &size);
    assert_true(size == sizes[weights][planes]);
    assert_memory_equal(bytes, blobs[weights][planes], size);
    free(bytes);
}

static void test_same_bytes_after_loading(void **unused) {
    (void)unused;
    for (int32_t weights = 0; weights < 3; weights++)
        for (int32_t planes = 0; planes < 3; planes++) {
            assert_int_equal(get(blobs[weights][planes] + kAtWeightsEncoding, 2), weights);
            assert_int_equal(get(blobs[weights][planes] + kAtPlanesEncoding, 2), planes);
            assert_blob(rounded[weights][planes], weights, planes);
        }
    for (int32_t encoding = bf16; encoding <= fp16; encoding++) { /* float32 represents every 16-bit number exactly */
        size_t size;
        uint8_t *bytes = saved_as(rounded[encoding][encoding], float32, float32, &size);
        toliman_cae *wide = loaded_from(bytes, size);
        assert_blob(wide, encoding, encoding);
        toliman_cae_destroy(wide);
        free(bytes);
    }
    const size_t whole = sizes[float32][float32];
    assert_true(sizes[bf16][float32] < whole - kParameters && sizes[fp16][float32] < whole - kParameters);
    assert_true(sizes[float32][bf16] < whole - 3 * kPixels && sizes[float32][fp16] < whole - 3 * kPixels);
}

/* The bit patterns of 0.625 from the definition of the formats; one tensor in fp16 stores it as 5 times 2^-3. */
static void test_blobs_written_from_the_specification(void **unused) {
    (void)unused;
    static uint8_t raw[2 * kParameters + 2 * kTensors];
    static double frame[kPixels];
    size_t size;
    uint8_t *header = blobs[float32][float32];
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
static void test_rounding_of_planes(void **unused) {
    (void)unused;
    static double exact[kPixels], target[kPixels];
    assert_ok(toliman_cae_get_target(trained, exact, kSide));
    double largest = 0;
    for (int i = 0; i < kPixels; i++)
        largest = fmax(largest, fabs(exact[i]));
    for (int32_t encoding = bf16; encoding <= fp16; encoding++) {
        const double precision = encoding == bf16 ? 0x1p-8 : 0x1p-11;
        assert_ok(toliman_cae_get_target(rounded[float32][encoding], target, kSide));
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
static void test_no_bias(void **unused) {
    (void)unused;
    const double zero = encode_expected(trained, sim, 0);
    for (int k = 0; k < 9; k++)
        assert_close(encode_expected(rounded[k / 3][k % 3], sim, 0), zero, 0, 1e-11);
}

static void test_latents_keep_their_slope_and_scatter(void **unused) {
    (void)unused;
    enum { kFrames = 40 };
    static double frame[kPixels], latents[9][kFrames];
    for (int i = 0; i < kFrames; i++) {
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, i, 1, frame));
        for (int k = 0; k < 9; k++)
            assert_ok(toliman_cae_encode(rounded[k / 3][k % 3], PLAIN_IMAGE(frame), 1, &latents[k][i], NULL));
    }
    for (int k = 0; k < 9; k++) {
        const toliman_cae *cae = rounded[k / 3][k % 3];
        const double slope = (encode_expected(cae, sim, 1e-5) - encode_expected(cae, sim, -1e-5)) / 2e-5;
        double change = 0, scatter = 0;
        for (int i = 0; i < kFrames; i++) {
            change += pow(latents[k][i] - latents[0][i], 2);
            scatter += pow(latents[0][i], 2);
        }
        const int coarse = k / 3 == bf16 || k % 3 == bf16;
        assert_close(slope, 1, coarse ? 2e-3 : 3e-4, 0);
        assert_true(sqrt(change / scatter) < (k == 0 ? 1e-300 : coarse ? 2e-2 : 3e-3));
    }
}

/* Numbers from the smallest to the largest that a blob can hold, all just below powers of two. In fp16, whose range is
 * smaller, no variance may become 0 and no number infinite. */
static void test_numbers_of_any_size(void **unused) {
    (void)unused;
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    static double frame[kPixels];
    for (int reach = 226; reach > 0; reach -= 75)
        for (int top = 100; top >= reach - 125; top -= 75) {
            for (int i = 0; i < kFloats; i++)
                planes[i] = i / kPixels < 2 ? 0 : ldexpf(1 - 0x1p-24f, top - i % reach);
            size_t size, size_again;
            uint8_t *bytes = with_payloads(blobs[float32][float32], NULL, planes, 5, &size);
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
            toliman_cae_destroy(again), toliman_cae_destroy(cae);
            free(bytes), free(bytes_again);
        }
}

/* Training on an extremely small or large derivative gives weights at either limit of float32. Saving them is refused,
 * or the blob loads again. */
static void test_weights_out_of_range(void **unused) {
    (void)unused;
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 1;
    int refusals = 0, failures = 0;
    const int exponents[] = {-126, -126, -112, -100, 0, 60, 97},
              pixels[] = {1, kPixels, kPixels, kPixels, kPixels, kPixels, kPixels};
    for (int k = 0; k < 7; k++) {
        size_t size;
        for (int i = 0; i < kFloats; i++)
            planes[i] = i / kPixels == 2                              ? 1
                        : i / kPixels == 3 && i % kPixels < pixels[k] ? ldexpf(1 + (float)(i % 7), exponents[k])
                                                                      : 0;
        uint8_t *bytes = with_payloads(blobs[float32][float32], NULL, planes, 5, &size);
        toliman_cae *cae = loaded_from(bytes, size);
        free(bytes);
        const toliman_status status = toliman_cae_train(cae, &options, NULL);
        if (status == TOLIMAN_E_RANGE) {
            assert_fails(status, TOLIMAN_E_RANGE, "the trained weights are not finite");
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

static void test_options(void **unused) {
    (void)unused;
    size_t needed = 7;
    toliman_cae_save_options options = TOLIMAN_CAE_SAVE_OPTIONS_INIT;
    options.weights_encoding = 3;
    assert_fails(toliman_cae_save(trained, &options, NULL, 0, &needed), TOLIMAN_E_ARGUMENT,
                 "options->weights_encoding = 3: must be one of TOLIMAN_CAE_ENCODING_..., 231 to 233");
    options.weights_encoding = 0;
    options.planes_encoding = -1;
    assert_fails(toliman_cae_save(trained, &options, NULL, 0, &needed), TOLIMAN_E_ARGUMENT, "planes_encoding = -1");
    options.planes_encoding = 0;
    options.with_training = 2;
    assert_fails(toliman_cae_save(trained, &options, NULL, 0, &needed), TOLIMAN_E_ARGUMENT,
                 "options->with_training = 2: must be 0 or 1");
    options.with_training = 0;
    options.struct_size = 3;
    assert_fails(toliman_cae_save(trained, &options, NULL, 0, &needed), TOLIMAN_E_ARGUMENT, "struct_size");
    assert_true(needed == 7);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bytes_after_loading),
        cmocka_unit_test(test_blobs_written_from_the_specification),
        cmocka_unit_test(test_rounding_of_planes),
        cmocka_unit_test(test_no_bias),
        cmocka_unit_test(test_latents_keep_their_slope_and_scatter),
        cmocka_unit_test(test_numbers_of_any_size),
        cmocka_unit_test(test_weights_out_of_range),
        cmocka_unit_test(test_options),
    };
    return cmocka_run_group_tests_name("cae_payload", tests, set_up, tear_down);
}
