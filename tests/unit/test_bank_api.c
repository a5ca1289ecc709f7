/* Tests the interface of banks: arguments and their messages, saved banks and their results, and damaged ones. */
#include "bank_scene.h"
#include "images.h"
#include "test_folder.h"
#include "tlmw.h"

static toliman_sim *sim;
static toliman_fit *fit;
static toliman_bank *bank; /* 2 dates, 1 place; the first network is trained */
static double frame[kPixels];

static int32_t stop(const char *stage, double fraction, void *unused) {
    (void)stage, (void)unused;
    return fraction > 0;
}

FIXTURE(set_up) {
    sim = bank_sim(kSide, kSide, BANK_ORBIT);
    fit = bank_fit(sim, 2);
    bank = bank_of(fit, 1, 4, 8);
    const toliman_bank_train_options options = {.struct_size = sizeof options, .threads = 1, .progress = stop};
    assert_refused(toliman_bank_train(bank, fit, &options), TOLIMAN_E_CANCELLED, "");
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 0, 1, frame));
    return 0;
}

FIXTURE(tear_down) {
    toliman_bank_destroy(bank), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

static toliman_bank_result encoded(const toliman_bank *by) {
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_encode(by, fit, PLAIN_IMAGE(frame), 1, NULL, &result, NULL));
    return result;
}

TEST(bad_options_are_refused) {
    const struct {
        toliman_bank_options options;
        const char *field;
    } cases[] = {{{.first_days = 2, .last_days = 1}, "options->last_days"},
                 {{.first_days = 2}, "options->last_days"},
                 {{.spacing_px = 0.05, .places = 8}, "options"},
                 {{.struct_size = 4}, "options->struct_size"}};
    toliman_bank *made = NULL;
    toliman_bank_plan_info plan = {.struct_size = sizeof plan};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_bank_options options = cases[i].options;
        if (options.struct_size == 0)
            options.struct_size = sizeof options;
        assert_invalid(toliman_bank_create(fit, &options, &made), cases[i].field);
        assert_invalid(toliman_bank_plan(sim, &options, &plan), cases[i].field);
    }
    assert_invalid(toliman_bank_create(NULL, NULL, &made), "fit");
    assert_invalid(toliman_bank_create(fit, NULL, NULL), "out");
    assert_invalid(toliman_bank_plan(NULL, NULL, &plan), "sim");
    assert_invalid(toliman_bank_plan(sim, NULL, NULL), "out");
    plan.struct_size = 8;
    assert_invalid(toliman_bank_plan(sim, NULL, &plan), "out->struct_size");
    assert_null(made);
}

/* Half a turn after periastron, three times as far apart. */
TEST(dates_without_model_images_are_refused) {
    char *const orbit = replaced(BANK_ORBIT, "\"eccentricity\": 0", "\"eccentricity\": 0.5");
    toliman_sim *const eccentric = bank_sim(kSide, kSide, orbit);
    toliman_fit *const with = bank_fit(eccentric, 2);
    const toliman_bank_options late = {.struct_size = sizeof late, .places = 1, .first_days = 499, .last_days = 500};
    toliman_bank *made = NULL;
    assert_invalid(toliman_bank_create(with, &late, &made), "prediction");
    assert_null(made);
    made = bank_of(with, 1, 4, 1);
    double days = 0;
    assert_ok(toliman_bank_get_renewal(made, with, 1e-9, &days));
    assert_true(days > 50 && days < 499);
    toliman_bank_destroy(made), toliman_fit_destroy(with), toliman_sim_destroy(eccentric), free(orbit);
}

TEST(unsuitable_scenes_are_refused) {
    toliman_bank *made = NULL;
    toliman_bank_plan_info plan = {.struct_size = sizeof plan};
    toliman_sim *other = sim_of(kBinaryScene);
    toliman_fit *const small = bank_fit(other, 2);
    assert_refused(toliman_bank_create(small, NULL, &made), TOLIMAN_E_UNSUPPORTED, "detector.shape");
    assert_refused(toliman_bank_plan(other, NULL, &plan), TOLIMAN_E_UNSUPPORTED, "detector.shape");
    toliman_fit_destroy(small), toliman_sim_destroy(other);
    other = sim_of(kSingleScene);
    assert_refused(toliman_bank_plan(other, NULL, &plan), TOLIMAN_E_UNSUPPORTED, "stars");
    toliman_sim_destroy(other);
    assert_null(made);
}

TEST(bad_arguments_are_refused) {
    static double bad[2 * kPixels];
    toliman_bank_result results[2] = {{.struct_size = sizeof *results}}, older = {.struct_size = 8};
    toliman_fit_result fitted = {.struct_size = 8};
    memcpy(bad, frame, sizeof frame);
    memcpy(bad + kPixels, frame, sizeof frame);
    bad[kPixels + 3 * kSide + 7] = NAN;
    const toliman_fit_prediction wrong = {.struct_size = sizeof wrong, .x_px = NAN};
    const toliman_image small = {.struct_size = sizeof small, .pixels = frame, .rows = 128, .cols = 128};
    const toliman_image *const right = PLAIN_IMAGE(frame);
    const struct {
        const toliman_image *image;
        size_t count;
        const toliman_fit_prediction *predictions;
        toliman_bank_result *results;
        toliman_fit_result *fitted;
        const char *field;
    } cases[] = {{PLAIN_IMAGE(bad + kPixels), 1, NULL, results, NULL, "counts"},
                 {PLAIN_IMAGE(bad), 2, NULL, results, NULL, "counts"},
                 {NULL, 1, NULL, results, NULL, "image"},
                 {&small, 1, NULL, results, NULL, "image->rows"},
                 {right, 1, &wrong, results, NULL, "predictions->x_px"},
                 {right, 1, NULL, NULL, NULL, "results"},
                 {right, 1, NULL, &older, NULL, "results->struct_size"},
                 {right, 1, NULL, results, &fitted, "fitted->struct_size"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_invalid(toliman_bank_encode(bank, fit, cases[i].image, cases[i].count, cases[i].predictions,
                                           cases[i].results, cases[i].fitted),
                       cases[i].field);
    assert_fails(toliman_bank_encode(bank, fit, PLAIN_IMAGE(bad), 2, NULL, results, NULL), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[3][7] = nan");
    assert_true(results[0].network == 0 && results[0].efficiency <= 0); /* nothing was written */
    assert_invalid(toliman_bank_encode(NULL, fit, right, 1, NULL, results, NULL), "bank");
    assert_invalid(toliman_bank_encode(bank, NULL, right, 1, NULL, results, NULL), "fit");
    assert_ok(toliman_bank_encode(bank, fit, NULL, 0, NULL, NULL, NULL));
    assert_invalid(toliman_bank_predict(bank, fit, &wrong, results), "prediction->x_px");
    assert_invalid(toliman_bank_predict(bank, fit, NULL, NULL), "out");
    assert_invalid(toliman_bank_predict(bank, fit, NULL, &older), "out->struct_size");
    double days = 7;
    for (size_t i = 0; i < 4; i++)
        assert_invalid(toliman_bank_get_renewal(bank, fit, (const double[]){0, 1, NAN, -0.5}[i], &days),
                       "least_efficiency");
    assert_invalid(toliman_bank_get_renewal(bank, fit, 0.5, NULL), "days");
    assert_close(days, 7, 0, 0);
    assert_invalid(toliman_bank_get_info(bank, NULL), "out");
    assert_invalid(toliman_bank_get_network(bank, 0, NULL), "out");
    assert_invalid(toliman_bank_train(NULL, fit, NULL), "bank");
    assert_invalid(toliman_bank_train(bank, NULL, NULL), "fit");
    toliman_bank_destroy(NULL);
}

/* Of another capture range, of another free parameter, of stars at rest. */
TEST(other_fits_are_refused) {
    const toliman_fit_options more = {.struct_size = sizeof more, .free = "scale", .capture_px = 2};
    toliman_sim *const resting = bank_sim(kSide, kSide, BANK_AT_REST);
    toliman_fit *others[3] = {bank_fit(sim, 1), NULL, bank_fit(resting, 2)};
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &more, &others[1]));
    toliman_bank_result result = {.struct_size = sizeof result};
    double days = 0;
    for (size_t i = 0; i < 3; i++) {
        assert_refused(toliman_bank_encode(bank, others[i], PLAIN_IMAGE(frame), 1, NULL, &result, NULL),
                       TOLIMAN_E_MISMATCH, "bank");
        assert_refused(toliman_bank_predict(bank, others[i], NULL, &result), TOLIMAN_E_MISMATCH, "bank");
        assert_refused(toliman_bank_get_renewal(bank, others[i], 0.5, &days), TOLIMAN_E_MISMATCH, "bank");
        assert_refused(toliman_bank_train(bank, others[i], NULL), TOLIMAN_E_MISMATCH, "bank");
        toliman_fit_destroy(others[i]);
    }
    toliman_fit *const equal = bank_fit(sim, 2);
    assert_ok(toliman_bank_encode(bank, equal, PLAIN_IMAGE(frame), 1, NULL, &result, NULL));
    toliman_fit_destroy(equal), toliman_sim_destroy(resting);
}

/* In float32 with the same results, in 16 bits with nearly the same; saving again gives the same bytes. */
/* promise: banks-save-same-bytes */
TEST(saved_banks_give_the_same_results) {
    const toliman_bank_result expected = encoded(bank);
    const toliman_bank_info info = bank_info_of(bank);
    assert_int_equal(info.trained_networks, 1);
    size_t sizes[3], size;
    for (int32_t kind = 0; kind < 3; kind++) {
        const int32_t encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + kind;
        uint8_t *const bytes = bank_bytes(bank, encoding, &sizes[kind]);
        toliman_bank *const loaded = bank_from(bytes, sizes[kind]);
        assert_bank_bytes(loaded, encoding, bytes, sizes[kind]);
        const toliman_bank_result result = encoded(loaded);
        const toliman_bank_info other = bank_info_of(loaded);
        assert_true((other.digest == info.digest) == (kind == 0));
        assert_true(other.fit_digest == info.fit_digest && other.networks == 2 && other.trained_networks == 1);
        assert_memory_equal(&other.rows, &info.rows, 2 * sizeof info.rows);
        assert_close(other.last_days, info.last_days, 0, 0);
        const toliman_bank_network given = bank_network_of(bank, 1), found = bank_network_of(loaded, 1);
        assert_memory_equal(&given, &found, sizeof given);
        if (kind == 0)
            assert_memory_equal(&result, &expected, sizeof result);
        assert_close(result.displacement_px, expected.displacement_px, 0, 0.1 * expected.sigma_px);
        assert_close(result.efficiency, expected.efficiency, 1e-3, 0);
        free(bytes), toliman_bank_destroy(loaded);
    }
    assert_true(sizes[1] < sizes[0] && sizes[2] < sizes[0]);
    static uint8_t little[100];
    assert_refused(toliman_bank_save(bank, 0, little, sizeof little, &size), TOLIMAN_E_CAPACITY, "capacity");
    assert_invalid(toliman_bank_save(bank, 3, NULL, 0, &size), "encoding");
    assert_invalid(toliman_bank_save(bank, 0, NULL, 0, NULL), "needed");
    assert_invalid(toliman_bank_save(NULL, 0, NULL, 0, &size), "bank");
    toliman_bank *made = NULL;
    assert_invalid(toliman_bank_load(NULL, 8, NULL, &made), "bytes");
    assert_invalid(toliman_bank_load(little, 8, NULL, NULL), "out");
}

/* promise: banks-save-same-bytes */
TEST(banks_are_saved_to_files) {
    char folder[200], path[300], missing[300];
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/bank.tlmb", folder);
    snprintf(missing, sizeof missing, "%s/none/bank.tlmb", folder);
    assert_ok(toliman_bank_save_file(bank, TOLIMAN_CAE_ENCODING_BF16, path));
    size_t size;
    uint8_t *const expected = bank_bytes(bank, TOLIMAN_CAE_ENCODING_BF16, &size);
    toliman_bank *loaded = NULL;
    assert_ok(toliman_bank_load_file(path, NULL, &loaded));
    assert_bank_bytes(loaded, TOLIMAN_CAE_ENCODING_BF16, expected, size);
    toliman_bank_destroy(loaded), free(expected);
    loaded = NULL;
    assert_refused(toliman_bank_save_file(bank, 0, missing), TOLIMAN_E_WRITE, missing);
    assert_refused(toliman_bank_load_file(missing, NULL, &loaded), TOLIMAN_E_NOT_FOUND, missing);
    FILE *const file = fopen(path, "r+b");
    assert_non_null(file);
    assert_true(fseek(file, 50, SEEK_SET) == 0 && fputc(0x5a, file) != EOF && fclose(file) == 0);
    assert_refused(toliman_bank_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    assert_invalid(toliman_bank_save_file(bank, 0, NULL), "path");
    assert_invalid(toliman_bank_load_file(NULL, NULL, &loaded), "path");
    assert_invalid(toliman_bank_load_file(path, NULL, NULL), "out");
    assert_null(loaded);
    remove_folder(folder);
}

/* Offsets of a saved bank, from tools/docs/formats.md. */
enum { kBankHeader = 96, kDate = 24, kNetwork = 72, kAtPacked = 92, kAtDates = kBankHeader };
enum { kAtFirst = kAtDates + 2 * kDate, kStored = 40769 };

/* A refused load leaves *out unchanged. */
static void bank_refused(const uint8_t *bytes, size_t size, const char *text) {
    toliman_bank *const mine = (toliman_bank *)(uintptr_t)8, *out = mine;
    assert_fails(toliman_bank_load(bytes, size, NULL, &out), TOLIMAN_E_FORMAT, text);
    assert_ptr_equal(out, mine);
}

/* The bank with these float32 weights, stored without compression. The caller frees it. */
static uint8_t *with_weights(const uint8_t *given, const float *weights, size_t *size) {
    const size_t known = kAtFirst + 2 * kNetwork, raw = 2 * kStored * sizeof *weights;
    size_t blocks[20];
    for (size_t i = 0; i < 20; i++)
        blocks[i] = kTensorSizes[i % 10];
    uint8_t *const shuffled = float32_blocks(weights, blocks, 20), *const out = malloc(known + raw + raw / 1000 + 20);
    assert_non_null(out);
    memcpy(out, given, known);
    const size_t packed = store(shuffled, raw, out + known);
    *size = known + packed + 4;
    put(out + kAtSize, *size, 8);
    put(out + kAtPacked, packed, 4);
    seal(out, *size);
    free(shuffled);
    return out;
}

/* promise: damaged-banks-are-refused */
TEST(truncated_banks_are_refused) {
    size_t size;
    uint8_t *const bytes = bank_bytes(bank, 0, &size);
    for (size_t n = 0; n < size; n += n < 400 ? 1 : 9973) {
        uint8_t *const part = malloc(n + 1); /* exactly as long, so that reads beyond it are detected */
        memcpy(part + 1, bytes, n);
        bank_refused(part + 1, n, "truncated");
        if (n >= 16) { /* a header consistent with the length */
            put(part + 1 + kAtSize, n, 8);
            if (n >= 20)
                seal(part + 1, n);
            bank_refused(part + 1, n, "bank");
        }
        free(part);
    }
    uint8_t *const longer = calloc(size + 1, 1);
    memcpy(longer, bytes, size);
    bank_refused(longer, size + 1, "the header states");
    put(longer + kAtSize, size + 1, 8);
    seal(longer, size + 1);
    bank_refused(longer, size + 1, "bytes: must be ");
    for (size_t i = 0; i < size; i += i < 400 ? 1 : 7919) {
        bytes[i] ^= 0x10;
        bank_refused(bytes, size,
                     i < 4    ? "does not start with \"TLMB\""
                     : i < 8  ? "unsupported version"
                     : i < 16 ? "the header states"
                              : "checksum mismatch: the data are damaged");
        bytes[i] ^= 0x10;
    }
    free(bytes), free(longer);
}

/* Changed numbers, with a correct checksum. */
/* promises: damaged-banks-are-refused, other-versions-are-refused */
TEST(impossible_numbers_are_refused) {
    const uint64_t nan_bits = 0x7ff8000000000000u, infinite = 0x7ff0000000000000u, two = 0x4000000000000000u,
                   minus_one = 0xbff0000000000000u, large = 0x41dfffffffc00000u /* 2^31 */;
    const struct {
        int offset, bytes;
        uint64_t value;
        const char *text;
    } cases[] = {{kAtVersion, 4, 2, "unsupported version 2 (supported:"},
                 {16, 4, 0, "layout = "},
                 {16, 4, 2, "layout = "}, /* with the hash of layout 1 */
                 {20, 4, 3, "encoding = "},
                 {20, 4, 1, "compressed payload"},
                 {24, 8, 1, "layout = "},
                 {48, 8, nan_bits, "first_days = "},
                 {48, 8, large, "first_days = "},
                 {56, 8, minus_one, "last_days = "},
                 {56, 8, infinite, "last_days = "},
                 {64, 8, 0, "spacing_px = "},
                 {64, 8, nan_bits, "spacing_px = "},
                 {72, 4, 0, "places = "},
                 {72, 4, 9, "places = "},
                 {72, 4, 2, "bytes:"},
                 {76, 4, 0, "steps = "},
                 {76, 4, 1000001, "steps = "},
                 {80, 4, 255, "rows = "},
                 {80, 4, 4097, "rows = "},
                 {84, 4, 0xffffffffu, "cols = "},
                 {88, 4, 0, "dates = "},
                 {88, 4, 1025, "dates = "},
                 {88, 4, 3, "bytes:"},
                 {kAtPacked, 4, 0, "bytes:"},
                 {kAtPacked, 4, 0xffffffffu, "bytes:"},
                 {kAtDates, 8, nan_bits, "days = "},
                 {kAtDates + 8, 8, minus_one, "days = "},
                 {kAtDates + kDate + 16, 8, large, "days = "},
                 {kAtFirst, 8, large, "place = "},
                 {kAtFirst + 24, 8, nan_bits, "place = "},
                 {kAtFirst + 32, 8, two, "share = "},
                 {kAtFirst + 40, 4, 1, "crop_row = "},
                 {kAtFirst + 44, 4, 1, "crop_col = "},
                 {kAtFirst + kNetwork + 48, 8, two, "cosine = "},
                 {kAtFirst + kNetwork + 48, 8, minus_one, "cosine = "},
                 {kAtFirst + 56, 8, infinite, "gain = "},
                 {kAtFirst + 56, 8, 0, "gain = "},
                 {kAtFirst + 64, 8, nan_bits, "efficiency = "},
                 {kAtFirst + 2 * kNetwork, 1, 0x5a, "compressed payload"}};
    size_t size;
    uint8_t *const bytes = bank_bytes(bank, 0, &size), *const kept = malloc(size);
    memcpy(kept, bytes, size);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        put(bytes + cases[k].offset, cases[k].value, cases[k].bytes);
        seal(bytes, size);
        bank_refused(bytes, size, cases[k].text);
        memcpy(bytes, kept, size);
    }
    free(bytes), free(kept);
}

/* Whether element i of a network's stored weights is a bias: those of four convolutions and of the latent. */
static int is_bias(size_t i) {
    static const size_t kernels[] = {72, 1152, 4608, 18432, 16384}, biases[] = {8, 16, 32, 64, 1};
    size_t at = 0;
    for (size_t k = 0; k < 5; k++) {
        at += kernels[k];
        if (i >= at && i < at + biases[k])
            return 1;
        at += biases[k];
    }
    return 0;
}

/* promise: damaged-banks-are-refused */
TEST(impossible_weights_are_refused) {
    static float weights[2 * kStored];
    const float bad[] = {NAN, INFINITY, -INFINITY, 2e30f, 1e-38f, -1e-45f};
    size_t size, other;
    uint8_t *const bytes = bank_bytes(bank, 0, &size);
    for (size_t i = 0; i < 2 * kStored; i++)
        weights[i] = is_bias(i % kStored) ? 0 : 0.015625f;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        weights[kStored + 2000] = bad[k];
        uint8_t *const damaged = with_weights(bytes, weights, &other);
        bank_refused(damaged, other, "weights[42769]");
        free(damaged);
    }
    weights[kStored + 2000] = 0.25f;
    weights[kStored + 1234] = 1e-3f;
    uint8_t *const biased = with_weights(bytes, weights, &other);
    bank_refused(biased, other, "conv2.bias of network 1: must be 0");
    weights[kStored + 1234] = 0;
    static float nothing[2 * kStored];
    uint8_t *const blind = with_weights(bytes, nothing, &other);
    bank_refused(blind, other, "weights of network 0: the latent does not depend on the image");
    free(biased), free(blind);
    uint8_t *const valid = with_weights(bytes, weights, &other);
    toliman_bank *const loaded = bank_from(valid, other);
    assert_true(bank_info_of(loaded).digest != bank_info_of(bank).digest);
    toliman_bank_destroy(loaded), free(bytes), free(valid);
}

RUN_TESTS(set_up, tear_down)
