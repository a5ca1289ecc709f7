/* Tests damaged and malicious weights blobs: each is refused. Random ones: tests/fuzz. */
#include <sys/resource.h>

#include "tlmw.h"

enum { kFloats = 5 * kPixels }; /* reference high and low, variance, target, one nuisance */

static toliman_sim *sim;
static uint8_t *blob, *small; /* of a trained network, and a small one */
static size_t blob_size, small_size;

/* Weights of 0 and planes of 1 make a blob of a few kilobytes, small enough to test every byte. */
static uint8_t *small_blob(size_t *size) {
    static float weights[kParameters], planes[kFloats];
    for (int i = 0; i < kFloats; i++)
        planes[i] = 1;
    toliman_cae *cae = NULL;
    uint8_t *bytes = with_payloads(blob, weights, planes, 5, size);
    assert_ok(toliman_cae_load(bytes, *size, NULL, &cae));
    free(bytes);
    bytes = saved(cae, size);
    toliman_cae_destroy(cae);
    assert_true(*size < 20000);
    return bytes;
}

FIXTURE(set_up) {
    sim = make_sim(kSide, 260, 0, "\"flux_a\"");
    toliman_cae *trained = make_cae(sim, 3, 15, NULL);
    blob = saved(trained, &blob_size);
    toliman_cae_destroy(trained);
    small = small_blob(&small_size);
    return 0;
}

FIXTURE(tear_down) {
    free(blob), free(small), toliman_sim_destroy(sim);
    return 0;
}

/* Every wrong length of the small blob, in a buffer of exactly that length, so that reads beyond it are detected. */
/* promise: damaged-weights-are-refused */
TEST(test_every_truncation) {
    for (size_t size = 0; size < blob_size; size += size < 1000 ? 1 : 97)
        refused(blob, size, size < 4 ? "weights blob: truncated" : "truncated");
    for (size_t size = 0; size < small_size; size++) {
        uint8_t *bytes = malloc(size + 1);
        memcpy(bytes + 1, small, size);
        refused(bytes + 1, size, "truncated");
        if (size >= 16) { /* a header consistent with the length */
            put(bytes + 1 + kAtSize, size, 8);
            if (size >= 20)
                seal(bytes + 1, size);
            refused(bytes + 1, size, "weights blob");
        }
        free(bytes);
    }
    uint8_t *longer = calloc(blob_size + 1, 1);
    memcpy(longer, blob, blob_size);
    refused(longer, blob_size + 1, "the header states");
    put(longer + kAtSize, blob_size + 1, 8);
    seal(longer, blob_size + 1);
    refused(longer, blob_size + 1, "do not match the blob's ");
    free(longer);
}

/* promise: damaged-weights-are-refused */
TEST(test_every_flipped_bit) {
    for (size_t i = 0; i < small_size; i++)
        for (int bit = 0; bit < 8; bit++) {
            small[i] ^= (uint8_t)(1 << bit);
            refused(small, small_size,
                    i < 4                ? "does not start with \"TLMW\""
                    : i == 4 && bit == 0 ? "checksum mismatch" /* a known version */
                    : i < 8              ? "unsupported version"
                    : i < 16             ? "the header states"
                                         : "checksum mismatch: the data are damaged");
            small[i] ^= (uint8_t)(1 << bit);
        }
    for (size_t i = 0; i < blob_size; i += 40009) {
        blob[i] ^= 0x10;
        refused(blob, blob_size, "weights blob");
        blob[i] ^= 0x10;
    }
}

/* Changed header fields, with a correct checksum. */
/* promises: damaged-weights-are-refused, other-versions-are-refused */
TEST(test_impossible_headers) {
    const uint64_t nan_bits = 0x7ff8000000000000u, infinite = 0x7ff0000000000000u, two = 0x4000000000000000u;
    const struct {
        int offset, bytes;
        uint64_t value;
        const char *text;
    } cases[] = {{kAtVersion, 4, 1, "unsupported version 1 (supported:"},
                 {kAtVersion, 4, 4, "unsupported version 4 (supported:"},
                 {kAtVersion, 4, 3, "number of nuisance planes = "},
                 {kAtSize, 8, 5, "bytes:"},
                 {16, 4, 77, "layout = "},
                 {20, 4, 0x80000000u, "flags = "},
                 {24, 8, 1, "hash = "},
                 {48, 4, 255, "frame shape = "},
                 {48, 4, 4097, "frame shape = "},
                 {52, 4, 0, "frame shape = "},
                 {52, 4, 0xffffffffu, "frame shape = "},
                 {56, 4, 1, "crop = "},
                 {60, 4, 5, "crop = "},
                 {kAtProjected, 4, 9, "number of nuisance planes = "},
                 {64, 4, 2, "compressed payload"},
                 {64, 4, 0, "compressed payload"},
                 {kAtWeightsEncoding, 2, 1, "compressed payload"},
                 {kAtWeightsEncoding, 2, 3, "encoding of the weights = "},
                 {kAtPlanesEncoding, 2, 2, "compressed payload"},
                 {kAtPlanesEncoding, 2, 0xffff, "encoding of the planes = "},
                 {72, 8, 0, "input scale = "},
                 {72, 8, 1, "input scale = "},
                 {72, 8, nan_bits, "input scale = "},
                 {80, 8, nan_bits, "bound = "},
                 {80, 8, infinite, "bound = "},
                 {88, 8, two, "cosine = "},
                 {kAtWeights, 4, 0, "do not match the blob's "},
                 {kAtWeights, 4, 0xffffffffu, "do not match the blob's "},
                 {kAtPlanes, 4, 0xffffffffu, "do not match the blob's "}};
    uint8_t *bytes = malloc(blob_size);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        memcpy(bytes, blob, blob_size);
        put(bytes + cases[k].offset, cases[k].value, cases[k].bytes);
        seal(bytes, blob_size);
        refused(bytes, blob_size, cases[k].text);
    }
    /* Raw input combined with nuisance planes. */
    memcpy(bytes, blob, blob_size);
    put(bytes + 20, (get(bytes + 20, 4) & ~6u) | 2, 4);
    put(bytes + 64, 1, 4);
    seal(bytes, blob_size);
    refused(bytes, blob_size, "number of nuisance planes = 1: must be 0 for residual input");
    /* Moves one byte of the compressed weights to the planes. */
    memcpy(bytes, blob, blob_size);
    put(bytes + kAtWeights, get(blob + kAtWeights, 4) - 1, 4);
    put(bytes + kAtPlanes, get(blob + kAtPlanes, 4) + 1, 4);
    seal(bytes, blob_size);
    refused(bytes, blob_size, "compressed payload");
    free(bytes);
}

/* The same for the training state after the planes. */
/* promise: damaged-weights-are-refused */
TEST(test_impossible_trainings) {
    const uint64_t nan_bits = 0x7ff8000000000000u, minus_one = 0xbff0000000000000u, two = 0x4000000000000000u;
    const struct {
        int offset, bytes;
        uint64_t value;
        const char *text;
    } cases[] = {{0, 4, 2, "mode = "},
                 {0, 4, 1, "steps in all = "},
                 {4, 4, 0, "done = "},
                 {4, 4, 16, "done = "},
                 {8, 8, 14, "steps of the optimiser = "},
                 {16, 8, 0, "steps in all = "},
                 {16, 8, (uint64_t)1 << 32, "steps in all = "},
                 {24, 8, 1, "frames = "},
                 {32, 8, 1, "validation = "},
                 {40, 4, 1, "batch = "},
                 {44, 4, 0, "training:"},
                 {44, 4, 0xffffffffu, "training:"},
                 {48, 8, 0, "learning rate = "},
                 {48, 8, two, "learning rate = "},
                 {48, 8, nan_bits, "learning rate = "},
                 {56, 8, minus_one, "loss = "},
                 {56, 8, nan_bits, "loss = "},
                 {64, 8, nan_bits, "loss = "}};
    size_t size;
    toliman_cae *cae = make_cae(sim, 3, 15, NULL);
    uint8_t *bytes = saved_with_training(cae, &size), *kept = malloc(size);
    const size_t training = kHeader + get(bytes + kAtWeights, 4) + get(bytes + kAtPlanes, 4);
    memcpy(kept, bytes, size);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        put(bytes + training + cases[k].offset, cases[k].value, cases[k].bytes);
        seal(bytes, size);
        refused(bytes, size, cases[k].text);
        memcpy(bytes, kept, size);
    }
    toliman_cae_destroy(cae);

    /* A layout that does not support tied weights. */
    toliman_sim *plain = make_sim(kSide, kSide, 0, "");
    toliman_cae_options options = {.struct_size = sizeof options, .layout = TOLIMAN_CAE_LAYOUT_PAPER};
    assert_ok(toliman_cae_create(plain, 1, &options, &cae));
    put(bytes + 16, 2, 4);
    put(bytes + 24, cae_info_of(cae).layout_hash, 8);
    seal(bytes, size);
    refused(bytes, size, "mode = 0: must be in [1, 1]");
    toliman_cae_destroy(cae), toliman_sim_destroy(plain), free(bytes), free(kept);
}

/* promise: damaged-weights-are-refused */
TEST(test_unusable_numbers) {
    static float weights[kParameters], planes[kFloats];
    const float bad[] = {NAN, INFINITY, -INFINITY, 2e30f, -2e30f, 1e-38f, -1e-45f};
    size_t size;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        memset(weights, 0, sizeof weights);
        weights[1234] = bad[k];
        uint8_t *bytes = with_payloads(blob, weights, NULL, 0, &size);
        refused(bytes, size, "weights[1234]");
        free(bytes);
    }
    for (int i = 0; i < kFloats; i++)
        planes[i] = 1;
    const struct {
        int at;
        float value;
        const char *text;
    } cases[] = {{2 * kPixels + 17, -3, "variance[17] = -3: must be positive"},
                 {4 * kPixels, NAN, "planes[262144] = nan: must be 0 or of magnitude in [1.18e-38, 1.27e+30]"},
                 {0, INFINITY, "planes[0] = inf"},
                 {kPixels + 1, 1e-40f, "planes[65537] = 9.99995e-41"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        planes[cases[k].at] = cases[k].value;
        uint8_t *bytes = with_payloads(blob, NULL, planes, 5, &size);
        refused(bytes, size, cases[k].text);
        free(bytes);
        planes[cases[k].at] = 1;
    }
}

/* 16-bit numbers that encode infinity or NaN, and scales that would produce them. */
/* promise: damaged-weights-are-refused */
TEST(test_unusable_narrow_numbers) {
    static uint8_t raw[2 * kParameters + 2 * kTensors];
    const struct {
        int32_t encoding;
        int at, value;
        const char *text;
    } cases[] = {{1, 0, 0x7f80, "weights[0] = inf"},
                 {1, 0, 0xffc0, "weights[0] = -nan"},
                 {1, 0, 0x7201, "weights[0] = 2.55"},
                 {1, 0, 0x007f, "weights[0] = 1.1"},
                 {2, 2, 0x7c00, "weights[0] = inf"},
                 {2, 2, 0xfc01, "weights[0] = -nan"},
                 {2, 0, 86, "scale of a block = 2^86: must be in [2^-141, 2^85]"},
                 {2, 0, -142, "scale of a block = 2^-142"},
                 {2, 0, 0x8000, "scale of a block = 2^-32768"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const int narrow = cases[k].encoding == 2, scale = narrow && cases[k].at == 0;
        memset(raw, 0, sizeof raw);
        raw[cases[k].at] = (uint8_t)cases[k].value; /* the first tensor has 72 numbers, low bytes first */
        raw[cases[k].at + (scale ? 1 : 72)] = (uint8_t)(cases[k].value >> 8);
        uint8_t *header = malloc(blob_size);
        memcpy(header, blob, blob_size);
        put(header + kAtWeightsEncoding, (uint64_t)cases[k].encoding, 2);
        size_t size;
        uint8_t *bytes = with_raw(header, raw, 2 * kParameters + (narrow ? 2 * kTensors : 0), NULL, 0, &size);
        refused(bytes, size, cases[k].text);
        free(bytes), free(header);
    }
}

/* A stream of one literal 0 followed by matches of 258 bytes, in the fixed Huffman code: expands 159 to 1. */
static size_t bomb(size_t bytes, uint8_t *out) {
    size_t bits = 16;
    memset(out, 0, bytes / 150 + 100);
    out[0] = 0x78;
    out[1] = 0x01;
    const char *start = "110"
                        "00110000";      /* last block, fixed code; literal 0 */
    const char *match = "1100010100000"; /* length 258, distance 1 */
    for (const char *c = start; *c != '\0'; c++, bits++)
        out[bits / 8] |= (uint8_t)((*c == '1') << (bits % 8));
    for (size_t done = 1; done < bytes; done += 258)
        for (const char *c = match; *c != '\0'; c++, bits++)
            out[bits / 8] |= (uint8_t)((*c == '1') << (bits % 8));
    return bits / 8 + 1;
}

static long peak_kib(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

/* promise: damaged-weights-are-refused */
TEST(test_streams_of_another_size) {
    const size_t planes_size = get(blob + kAtPlanes, 4), right = 4 * kParameters;
    const uint8_t *planes = blob + kHeader + get(blob + kAtWeights, 4);
    uint8_t *stream = malloc(4u << 20), *raw = calloc(right + 10, 1);
    size_t size;
    toliman_cae *cae = NULL;
    uint8_t *bytes = assemble(blob, stream, store(raw, right, stream), planes, planes_size, &size);
    assert_ok(toliman_cae_load(bytes, size, NULL, &cae));
    toliman_cae_destroy(cae), free(bytes);
    const size_t wrong[] = {0, 1, right - 1, right + 1, right + 10};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        bytes = assemble(blob, stream, store(raw, wrong[k], stream), planes, planes_size, &size);
        refused(bytes, size, "compressed payload is damaged or has another size than stated");
        free(bytes);
    }
    const size_t whole = store(raw, right, stream);
    for (int change = 0; change < 3; change++) { /* trailing bytes, no checksum, a wrong checksum */
        store(raw, right, stream);
        stream[change == 0 ? whole : whole - 1] ^= change == 1 ? 0 : 5;
        bytes = assemble(blob, stream, whole + (change == 0) - (change == 1), planes, planes_size, &size);
        refused(bytes, size, "compressed payload");
        free(bytes);
    }
    const long before = peak_kib();
    bytes = assemble(blob, stream, bomb(512u << 20, stream), planes, planes_size, &size);
    refused(bytes, size, "compressed payload");
    assert_true(peak_kib() - before < 32 * 1024);
    free(bytes), free(stream), free(raw);
}

RUN_TESTS(set_up, tear_down)
