/* The weights blob: round trips, a blob written here from the format's page, and refusal of everything damaged. */
#include <unistd.h>

#include "cae_scene.h"

enum { kHeader = 104, kParameters = 97858 };

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

static void put(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static uint64_t get(const uint8_t *at, int bytes) {
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)at[i] << (8 * i);
    return value;
}

/* CRC32 as of zlib and PNG. */
static uint32_t crc32_of(const uint8_t *bytes, size_t size) {
    static uint32_t table[256];
    for (uint32_t i = 0; table[255] == 0; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++)
            table[i] = (table[i] >> 1) ^ (table[i] & 1 ? 0xedb88320u : 0);
    }
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++)
        crc = (crc >> 8) ^ table[(crc ^ bytes[i]) & 255];
    return ~crc;
}

/* Byte-shuffled floats as a zlib stream of stored blocks; returns its size. */
static size_t store(const float *values, size_t count, uint8_t *out) {
    uint8_t *shuffled = malloc(4 * count), *next = out;
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < 4 * count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i % count], 4);
        shuffled[i] = (uint8_t)(bits >> (8 * (i / count)));
        a = (a + shuffled[i]) % 65521;
        b = (b + a) % 65521;
    }
    *next++ = 0x78;
    *next++ = 0x01;
    for (size_t done = 0; done < 4 * count;) {
        const size_t left = 4 * count - done, block = left < 65535 ? left : 65535;
        *next++ = block == left;
        put(next, block | (~block & 0xffff) << 16, 4);
        memcpy(next + 4, shuffled + done, block);
        next += 4 + block;
        done += block;
    }
    const uint32_t sum = b << 16 | a;
    for (int i = 3; i >= 0; i--)
        *next++ = (uint8_t)(sum >> (8 * i));
    free(shuffled);
    return (size_t)(next - out);
}

/* The test's blob with other weights (NULL = its own) or other planes; sizes and checksum made to fit. */
static uint8_t *with_payloads(const float *weights, const float *planes, size_t plane_floats, size_t *size) {
    const size_t old_weights = get(blob + 96, 4), old_planes = get(blob + 100, 4);
    uint8_t *out = malloc(blob_size + 5 * (kParameters + plane_floats) + 1000), *next = out + kHeader;
    memcpy(out, blob, kHeader);
    size_t part = old_weights;
    if (weights != NULL)
        part = store(weights, kParameters, next);
    else
        memcpy(next, blob + kHeader, part);
    put(out + 96, part, 4);
    next += part;
    part = old_planes;
    if (planes != NULL)
        part = store(planes, plane_floats, next);
    else
        memcpy(next, blob + kHeader + old_weights, part);
    put(out + 100, part, 4);
    next += part;
    *size = (size_t)(next - out) + 4;
    put(out + 8, *size, 8);
    put(next, crc32_of(out, *size - 4), 4);
    return out;
}

static void refused(const uint8_t *bytes, size_t size, const char *text) {
    toliman_cae *out = NULL;
    assert_fails(toliman_cae_load(bytes, size, &out), TOLIMAN_E_FORMAT, text);
    assert_null(out);
}

static void test_round_trip(void **unused) {
    (void)unused;
    toliman_cae *loaded = NULL;
    size_t size;
    assert_ok(toliman_cae_load(blob, blob_size, &loaded));
    uint8_t *again = saved(loaded, &size);
    assert_true(size == blob_size);
    assert_memory_equal(blob, again, size);

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

/* A loaded network trains to the same weights as the one it was saved from. */
static void test_training_goes_on_after_loading(void **unused) {
    (void)unused;
    toliman_cae *fresh = make_cae(sim, 3, 0, NULL), *loaded = NULL;
    size_t size;
    uint8_t *bytes = saved(fresh, &size);
    assert_ok(toliman_cae_load(bytes, size, &loaded));
    free(bytes);
    toliman_cae_train_options options;
    toliman_cae_train_options_init(&options);
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
    assert_fails(toliman_cae_load_file(path, &loaded), TOLIMAN_E_NOT_FOUND, path);
    assert_ok(toliman_cae_save_file(trained, path));
    assert_ok(toliman_cae_load_file(path, &loaded));
    size_t size;
    uint8_t *again = saved(loaded, &size);
    assert_true(size == blob_size);
    assert_memory_equal(blob, again, size);
    free(again);
    toliman_cae_destroy(loaded);
    assert_int_equal(remove(path), 0);
    assert_int_equal(rmdir(folder), 0);
    assert_fails(toliman_cae_save_file(trained, path), TOLIMAN_E_WRITE, path);
}

/* Weights put together here, floats stored uncompressed: only latent.bias is set, so every latent is that number. */
static void test_blob_written_from_the_page(void **unused) {
    (void)unused;
    static float weights[kParameters];
    static double frame[kSide * 260];
    size_t size;
    double latent;
    toliman_cae *cae = NULL;
    memset(weights, 0, sizeof weights);
    weights[8 * 9 + 8 + 16 * 72 + 16 + 32 * 144 + 32 + 64 * 288 + 64 + 16384] = 0.625f;
    uint8_t *bytes = with_payloads(weights, NULL, 0, &size);
    assert_ok(toliman_cae_load(bytes, size, &cae));
    assert_ok(toliman_cae_encode(cae, frame, 260, &latent));
    assert_true(latent == 0.625);
    free(bytes);
    toliman_cae_destroy(cae);
}

/* Weights as large as the format allows: whatever they overflow to is no result. */
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
        uint8_t *bytes = with_payloads(weights, NULL, 0, &size);
        assert_ok(toliman_cae_load(bytes, size, &cae));
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

static void test_truncated_or_longer(void **unused) {
    (void)unused;
    for (size_t size = 0; size < 200; size++)
        refused(blob, size, "weights blob");
    for (size_t size = 200; size < blob_size; size += 10007)
        refused(blob, size, "truncated");
    refused(blob, blob_size - 1, "truncated");
    uint8_t *longer = calloc(blob_size + 1, 1);
    memcpy(longer, blob, blob_size);
    refused(longer, blob_size + 1, "something behind it");
    free(longer);
}

static void test_every_flipped_byte(void **unused) {
    (void)unused;
    for (size_t i = 0; i < blob_size; i = i < 1000 ? i + 1 : i + 50021) {
        blob[i] ^= 0x10;
        refused(blob, blob_size, "weights blob");
        blob[i] ^= 0x10;
    }
    blob[0] = 'X';
    refused(blob, blob_size, "does not start with \"TLMW\"");
    blob[0] = 'T';
}

/* Header fields changed with the checksum made right again. */
static void test_impossible_headers(void **unused) {
    (void)unused;
    const uint64_t nan_bits = 0x7ff8000000000000u, two = 0x4000000000000000u;
    const struct {
        int offset, bytes;
        uint64_t value;
        const char *text;
    } cases[] = {
        {4, 4, 2, "version 2: this library reads version 1"},
        {8, 8, 5, "its header says 5"},
        {16, 4, 2, "layout 2"},
        {20, 4, 3, "flags = 0x3"},
        {24, 8, 1, "hash 0000000000000001"},
        {48, 4, 255, "255 x 260"},
        {48, 4, 4097, "4097 x 260"},
        {52, 4, 0, "256 x 0"},
        {52, 4, 0xffffffffu, "256 x 4294967295"},
        {56, 4, 1, "crop at 1, "},
        {60, 4, 5, "crop at 0, 5"},
        {64, 4, 9, "9 nuisance planes: at most 8"},
        {64, 4, 2, "compressed payload"},
        {64, 4, 0, "compressed payload"},
        {68, 4, 1, "payload encoding 1"},
        {72, 8, 0, "input scale 0"},
        {72, 8, nan_bits, "input scale nan"},
        {80, 8, nan_bits, "bound of nan"},
        {88, 8, two, "cosine 2"},
        {96, 4, 0, "do not fill"},
        {96, 4, 0xffffffffu, "do not fill"},
        {100, 4, 0xffffffffu, "do not fill"},
    };
    uint8_t *bytes = malloc(blob_size);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        memcpy(bytes, blob, blob_size);
        put(bytes + cases[k].offset, cases[k].value, cases[k].bytes);
        put(bytes + blob_size - 4, crc32_of(bytes, blob_size - 4), 4);
        refused(bytes, blob_size, cases[k].text);
    }
    /* One byte of the compressed weights belongs to the planes now. */
    memcpy(bytes, blob, blob_size);
    put(bytes + 96, get(blob + 96, 4) - 1, 4);
    put(bytes + 100, get(blob + 100, 4) + 1, 4);
    put(bytes + blob_size - 4, crc32_of(bytes, blob_size - 4), 4);
    refused(bytes, blob_size, "compressed payload");
    free(bytes);
}

static void test_unusable_numbers(void **unused) {
    (void)unused;
    enum { kFloats = 5 * kPixels }; /* reference high and low, variance, target, one nuisance */
    static float weights[kParameters], planes[kFloats];
    const float bad[] = {NAN, INFINITY, -INFINITY, 2e30f, -2e30f};
    size_t size;
    for (int k = 0; k < 5; k++) {
        memset(weights, 0, sizeof weights);
        weights[1234] = bad[k];
        uint8_t *bytes = with_payloads(weights, NULL, 0, &size);
        refused(bytes, size, "weights[1234]");
        free(bytes);
    }
    for (int i = 0; i < kFloats; i++)
        planes[i] = 1;
    uint8_t *bytes = with_payloads(NULL, planes, kFloats, &size);
    toliman_cae *cae = NULL;
    assert_ok(toliman_cae_load(bytes, size, &cae));
    toliman_cae_destroy(cae);
    free(bytes);
    planes[2 * kPixels + 17] = 0;
    bytes = with_payloads(NULL, planes, kFloats, &size);
    refused(bytes, size, "variance[17] = 0: must be positive");
    free(bytes);
    planes[4 * kPixels] = NAN;
    bytes = with_payloads(NULL, planes, kFloats, &size);
    refused(bytes, size, "planes[262144] = nan");
    free(bytes);
}

/* A network whose target is zero has nothing to be trained on. */
static void test_no_target(void **unused) {
    (void)unused;
    enum { kFloats = 5 * kPixels };
    static float planes[kFloats];
    for (int i = 0; i < kFloats; i++)
        planes[i] = i / kPixels != 3;
    size_t size, size_after;
    toliman_cae *cae = NULL;
    uint8_t *bytes = with_payloads(NULL, planes, kFloats, &size);
    assert_ok(toliman_cae_load(bytes, size, &cae));
    free(bytes);
    bytes = saved(cae, &size);
    assert_fails(toliman_cae_train(cae, NULL, NULL), TOLIMAN_E_STATE, "nothing to train on");
    uint8_t *after = saved(cae, &size_after);
    assert_true(size == size_after);
    assert_memory_equal(bytes, after, size);
    free(bytes), free(after);
    toliman_cae_destroy(cae);
}

/* An input scale so small that float32 has no weights that make up for it. */
static void test_scale_out_of_range(void **unused) {
    (void)unused;
    const double scale = 1e-300;
    toliman_cae *cae = NULL;
    toliman_cae_train_options options;
    toliman_cae_train_options_init(&options);
    options.steps = 1;
    uint8_t *bytes = malloc(blob_size);
    memcpy(bytes, blob, blob_size);
    uint64_t bits;
    memcpy(&bits, &scale, sizeof bits);
    put(bytes + 72, bits, 8);
    put(bytes + blob_size - 4, crc32_of(bytes, blob_size - 4), 4);
    assert_ok(toliman_cae_load(bytes, blob_size, &cae));
    assert_fails(toliman_cae_train(cae, &options, NULL), TOLIMAN_E_RANGE, "input scale 1e-300");
    free(bytes);
    toliman_cae_destroy(cae);
}

static void test_arguments(void **unused) {
    (void)unused;
    toliman_cae *out = NULL;
    assert_fails(toliman_cae_load(NULL, 5, &out), TOLIMAN_E_ARGUMENT, "bytes is NULL");
    assert_fails(toliman_cae_load(blob, blob_size, NULL), TOLIMAN_E_ARGUMENT, "out is NULL");
    assert_fails(toliman_cae_load_file(NULL, &out), TOLIMAN_E_ARGUMENT, "path is NULL");
    assert_fails(toliman_cae_save_file(trained, NULL), TOLIMAN_E_ARGUMENT, "path is NULL");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_training_goes_on_after_loading),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_blob_written_from_the_page),
        cmocka_unit_test(test_weights_that_overflow),
        cmocka_unit_test(test_truncated_or_longer),
        cmocka_unit_test(test_every_flipped_byte),
        cmocka_unit_test(test_impossible_headers),
        cmocka_unit_test(test_unusable_numbers),
        cmocka_unit_test(test_no_target),
        cmocka_unit_test(test_scale_out_of_range),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests_name("cae_blob", tests, set_up, tear_down);
}
