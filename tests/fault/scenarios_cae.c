/* cae.h */
#include <stdlib.h>
#include <string.h>

#include "cae_scene.h"
#include "images.h"
#include "scenario.h"

static toliman_status create_with(int32_t layout, int32_t input, void **made) {
    toliman_cae_options options = TOLIMAN_CAE_OPTIONS_INIT;
    options.layout = layout;
    options.input = input;
    options.threads = 3;
    return toliman_cae_create(large_sim(), 3, &options, (toliman_cae **)made);
}

static void *make(void) {
    void *made = NULL;
    assert_ok(create_with(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED, &made));
    return made;
}

static void *make_paper(void) {
    void *made = NULL;
    assert_ok(create_with(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_WHITENED, &made));
    return made;
}

static const toliman_cae *network(void) {
    static toliman_cae *cae;
    return cae != NULL ? cae : (cae = make());
}

static void end(void *cae) {
    toliman_cae_destroy(cae);
}

static uint64_t digest(const void *cae) {
    static double image[kPixels];
    double latent = 0;
    toliman_cae_info info = {.struct_size = sizeof info};
    toliman_cae_train_options training = {.struct_size = sizeof training};
    assert_ok(toliman_cae_get_info(cae, &training, &info));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(large_frames()), 1, &latent, NULL));
    uint64_t hash = fnv1a(fnv1a(FNV_START, &info, sizeof info), &latent, sizeof latent);
    hash = fnv1a(hash, &training, sizeof training);
    assert_ok(toliman_cae_reconstruct(cae, large_frames(), LARGE, image, LARGE, NULL, NULL, NULL));
    return fnv1a(hash, image, sizeof image);
}

static const object_kind networks = {end, digest};

/* Trainings with enough steps that all state of the optimisers is in use. */
static toliman_status give_frames(size_t first, size_t count, double *counts, void *unused) {
    (void)unused;
    memcpy(counts, large_frames() + first * kPixels, count * kPixels * sizeof *counts);
    return TOLIMAN_OK;
}

static int32_t keep_going(const char *stage, double fraction, void *unused) {
    (void)stage, (void)fraction, (void)unused;
    return 0;
}

static toliman_cae_train_options unsupervised(uint32_t epochs, uint32_t threads) {
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
    options.epochs = epochs;
    options.frames = give_frames;
    options.frame_count = 3;
    options.batch = 1;
    options.threads = threads;
    options.progress = keep_going;
    return options;
}

static toliman_cae_train_options tied(void) {
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 5;
    return options;
}

static toliman_status train_tied(attempt *a) {
    const toliman_cae_train_options options = tied();
    return toliman_cae_train(a->object, &options, (void *)a->out);
}
static toliman_status train_unsupervised(attempt *a) {
    const toliman_cae_train_options options = unsupervised(2, 1);
    return toliman_cae_train(a->object, &options, (void *)a->out);
}
static toliman_status train_threads(attempt *a) {
    const toliman_cae_train_options options = unsupervised(1, 2);
    return toliman_cae_train(a->object, &options, (void *)a->out);
}

static void *make_trained(void) {
    const toliman_cae_train_options options = unsupervised(1, 1);
    void *const cae = make();
    assert_ok(toliman_cae_train(cae, &options, NULL));
    return cae;
}

static const toliman_cae *trained(void) {
    static toliman_cae *cae;
    return cae != NULL ? cae : (cae = make_trained());
}

/* Weights blobs; an earlier network's blob is in the files before. */
static toliman_cae_save_options save_options(int32_t encoding, int32_t training) {
    toliman_cae_save_options options = TOLIMAN_CAE_SAVE_OPTIONS_INIT;
    options.weights_encoding = options.planes_encoding = encoding;
    options.with_training = training;
    return options;
}

enum { BLOB_CAPACITY = 6 << 20 };

typedef struct {
    unsigned char *bytes;
    size_t size;
} blob;

static blob blob_of(const toliman_cae *cae, int32_t training) {
    const toliman_cae_save_options options = save_options(TOLIMAN_CAE_ENCODING_FLOAT32, training);
    blob made = {malloc(BLOB_CAPACITY), 0};
    assert_ok(toliman_cae_save(cae, &options, made.bytes, BLOB_CAPACITY, &made.size));
    return made;
}

#define BLOB(name, network, training)                                                                                  \
    static blob name(void) {                                                                                           \
        static blob made;                                                                                              \
        return made.bytes != NULL ? made : (made = blob_of(network, training));                                        \
    }
BLOB(plain_blob, network(), 0)
BLOB(trained_blob, trained(), 1)

static const char kFile[] = "weights.tlmw", kFolder[] = "networks", kSaved[] = "networks/weights.tlmw";

static void put_file(void) {
    const blob trained = trained_blob();
    write_file(kFile, trained.bytes, trained.size);
}

static void put_old(void) {
    const blob trained = trained_blob();
    plain_blob();
    empty_folder(kFolder);
    write_file(kSaved, trained.bytes, trained.size);
}

/* The file must be the old or the new one, complete. No other file may remain, unless every call fails and it cannot be
 * removed. */
static void check_saved(attempt *a, toliman_status status) {
    static unsigned char found[BLOB_CAPACITY];
    const blob old = trained_blob(), new = plain_blob();
    const size_t size = read_file(kSaved, found, sizeof found);
    const int is_new = size == new.size &&memcmp(found, new.bytes, size) == 0;
    const int is_old = size == old.size && memcmp(found, old.bytes, size) == 0;
    (void)a;
    must(status == TOLIMAN_OK ? is_new : is_new || is_old, "neither the old file nor the new one");
    must(files_in(kFolder) == 1 || status == TOLIMAN_E_WRITE, "another file is left");
}

static toliman_status create_flight(attempt *a) {
    return create_with(TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_INPUT_WHITENED, &a->made);
}
static toliman_status create_paper(attempt *a) {
    return create_with(TOLIMAN_CAE_LAYOUT_PAPER, TOLIMAN_CAE_INPUT_WHITENED, &a->made);
}
static toliman_status load(attempt *a) {
    return toliman_cae_load(trained_blob().bytes, trained_blob().size, NULL, (toliman_cae **)&a->made);
}
static toliman_status load_damaged(attempt *a) {
    static unsigned char bytes[BLOB_CAPACITY];
    memcpy(bytes, plain_blob().bytes, plain_blob().size);
    bytes[plain_blob().size / 2] ^= 1;
    return toliman_cae_load(bytes, plain_blob().size, NULL, (toliman_cae **)&a->made);
}
static toliman_status load_file(attempt *a) {
    return toliman_cae_load_file(in_folder(kFile), NULL, (toliman_cae **)&a->made);
}
static toliman_status save(attempt *a) {
    size_t size = 0;
    const toliman_cae_save_options options = save_options(TOLIMAN_CAE_ENCODING_BF16, 0);
    const toliman_status status = toliman_cae_save(network(), &options, a->out, OUT_CAPACITY, &size);
    must(status == TOLIMAN_OK ? size > 0 : size == 0, "needed");
    return status;
}
static toliman_status save_file(attempt *a) {
    (void)a;
    return toliman_cae_save_file(network(), NULL, in_folder(kSaved));
}
static toliman_status destroy(attempt *a) {
    toliman_cae_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status decode(attempt *a) {
    return toliman_cae_decode(network(), 0.01, (double *)a->out, LARGE);
}
static toliman_status get_target(attempt *a) {
    return toliman_cae_get_target(network(), (double *)a->out, LARGE);
}
static toliman_status encode(attempt *a) {
    return toliman_cae_encode(network(), PLAIN_IMAGE(large_frames()), 1, (double *)a->out, NULL);
}
static toliman_status encode_many(attempt *a) {
    return toliman_cae_encode(network(), PLAIN_IMAGE(large_frames()), FRAMES, (double *)a->out, NULL);
}
static toliman_status reconstruct(attempt *a) {
    double *const out = (double *)a->out;
    return toliman_cae_reconstruct(a->object, large_frames(), LARGE, out, LARGE, out + kPixels, out + kPixels + 1,
                                   out + kPixels + 2);
}
static toliman_status get_info(attempt *a) {
    return toliman_cae_get_info(network(), NULL, (void *)a->out);
}
static toliman_status get_resumable(attempt *a) {
    toliman_cae_train_options *const resumable = (void *)(a->out + 1024);
    resumable->struct_size = sizeof *resumable;
    const toliman_status status = toliman_cae_get_info(trained(), resumable, (void *)a->out);
    must(status == TOLIMAN_OK && resumable->mode == TOLIMAN_CAE_MODE_UNSUPERVISED, "resumable");
    return status;
}

static void put_blobs(void) {
    (void)plain_blob(), (void)trained_blob(), (void)large_frames();
}

#define PARTIAL "cae.h: complete steps or epochs are kept, so that training can be resumed"
enum { REPORT = sizeof(toliman_cae_training) };

static const scenario all[] = {
    {.function = "toliman_cae_create", .call = create_flight, .made = &networks, .stage = put_blobs, .slow = 1},
    {.function = "toliman_cae_create", "paper", create_paper, .made = &networks, .stage = put_blobs, .slow = 1},
    {.function = "toliman_cae_load", .call = load, .made = &networks, .stage = put_blobs, .slow = 1},
    {.function = "toliman_cae_load",
     "damaged",
     load_damaged,
     .made = &networks,
     .stage = put_blobs,
     .refused = TOLIMAN_E_FORMAT},
    {.function = "toliman_cae_load_file", .call = load_file, .made = &networks, .stage = put_file, .slow = 1},
    {.function = "toliman_cae_save", .call = save, .slow = 1},
    {.function = "toliman_cae_save_file", .call = save_file, .stage = put_old, .check = check_saved, .slow = 1},
    {.function = "toliman_cae_destroy", .call = destroy, .make = make_trained, .of = &networks},
    {.function = "toliman_cae_decode", .call = decode},
    {.function = "toliman_cae_get_target", .call = get_target},
    {.function = "toliman_cae_encode", .call = encode, .stage = put_blobs, .slow = 1, .allocates_nothing = 1},
    {.function = "toliman_cae_encode", "many", encode_many, .stage = put_blobs, .slow = 1},
    {.function = "toliman_cae_reconstruct", .call = reconstruct, .make = make_paper, .of = &networks, .slow = 1},
    {.function = "toliman_cae_get_info", .call = get_info, .struct_size = sizeof(toliman_cae_info)},
    {.function = "toliman_cae_get_info", "resumable", get_resumable, .struct_size = sizeof(toliman_cae_info)},
    {.function = "toliman_cae_train", "tied", train_tied, make, &networks, .struct_size = REPORT, .partial = PARTIAL},
    {.function = "toliman_cae_train",
     "unsupervised",
     train_unsupervised,
     make,
     &networks,
     .struct_size = REPORT,
     .partial = PARTIAL,
     .slow = 1},
    {.function = "toliman_cae_train",
     "threads",
     train_threads,
     make,
     &networks,
     .struct_size = REPORT,
     .partial = PARTIAL,
     .slow = 1},
};
SCENARIO_LIST(cae_scenarios, all);
