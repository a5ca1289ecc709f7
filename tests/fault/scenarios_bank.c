/* bank.h */
#include <stdlib.h>

#include "assert_close.h"
#include "images.h"
#include "scenario.h"

static const toliman_fit_prediction shifted[FRAMES] = {{.struct_size = sizeof *shifted, .x_px = 0.25}};

static const toliman_fit *fitter(void) {
    static toliman_fit *fit;
    const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = 2, .threads = 1};
    if (fit == NULL)
        assert_ok(toliman_fit_create((const toliman_sim *[]){large_sim()}, NULL, 1, &options, &fit));
    return fit;
}

static toliman_status create_with(int32_t layout, void **made) {
    const toliman_bank_options options = {
        .struct_size = sizeof options, .layout = layout, .places = 2, .steps = 2, .threads = 1};
    return toliman_bank_create(fitter(), &options, (toliman_bank **)made);
}

static void *make(void) {
    void *made = NULL;
    assert_ok(create_with(TOLIMAN_CAE_LAYOUT_FLIGHT, &made));
    return made;
}

static const toliman_bank *bank(void) {
    static void *made;
    return made != NULL ? made : (made = make());
}

static void end(void *object) {
    toliman_bank_destroy(object);
}

static uint64_t digest(const void *object) {
    toliman_bank_info info = {.struct_size = sizeof info};
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_get_info(object, &info));
    assert_ok(toliman_bank_encode(object, fitter(), PLAIN_IMAGE(large_frames()), 1, NULL, &result, NULL));
    return fnv1a(fnv1a(FNV_START, &info, sizeof info), &result, sizeof result);
}

static const object_kind banks = {end, digest};

/* Saved banks: untrained, and of another seed, which is in the file before. */
typedef struct {
    unsigned char *bytes;
    size_t size;
} blob;

static blob blob_of(const toliman_bank *given) {
    blob made = {malloc(OUT_CAPACITY), 0};
    assert_ok(toliman_bank_save(given, TOLIMAN_CAE_ENCODING_FP16, made.bytes, OUT_CAPACITY, &made.size));
    return made;
}

static blob plain_blob(void) {
    static blob made;
    return made.bytes != NULL ? made : (made = blob_of(bank()));
}

static blob old_blob(void) {
    static blob made;
    const toliman_bank_options options = {.struct_size = sizeof options, .places = 1, .seed = 2};
    if (made.bytes == NULL) {
        toliman_bank *other = NULL;
        assert_ok(toliman_bank_create(fitter(), &options, &other));
        made = blob_of(other);
        toliman_bank_destroy(other);
    }
    return made;
}

static const char kFile[] = "bank.tlmb", kFolder[] = "banks", kSaved[] = "banks/bank.tlmb";

static void put_file(void) {
    write_file(kFile, plain_blob().bytes, plain_blob().size);
}

static void put_old(void) {
    (void)plain_blob();
    empty_folder(kFolder);
    write_file(kSaved, old_blob().bytes, old_blob().size);
}

static void put_all(void) {
    (void)large_frames(), (void)plain_blob();
}

/* The file must be the old or the new one, complete. No other file may remain, unless every call fails and it cannot be
 * removed. */
static void check_saved(attempt *a, toliman_status status) {
    static unsigned char found[OUT_CAPACITY];
    const blob old = old_blob(), new = plain_blob();
    const size_t size = read_file(kSaved, found, sizeof found);
    const int is_new = size == new.size &&memcmp(found, new.bytes, size) == 0;
    const int is_old = size == old.size && memcmp(found, old.bytes, size) == 0;
    (void)a;
    must(status == TOLIMAN_OK ? is_new : is_new || is_old, "neither the old file nor the new one");
    must(files_in(kFolder) == 1 || status == TOLIMAN_E_WRITE, "another file is left");
}

static toliman_status create_flight(attempt *a) {
    return create_with(TOLIMAN_CAE_LAYOUT_FLIGHT, &a->made);
}
static toliman_status plan(attempt *a) {
    return toliman_bank_plan(large_sim(), NULL, (void *)a->out);
}
static toliman_status destroy(attempt *a) {
    toliman_bank_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status train(attempt *a) {
    const toliman_bank_train_options options = {.struct_size = sizeof options, .threads = 2};
    return toliman_bank_train(a->object, fitter(), &options);
}
static const char kJournal[] = "banks/bank.part";
static toliman_status train_with_journal(attempt *a) {
    const toliman_bank_train_options options = {
        .struct_size = sizeof options, .threads = 2, .journal = in_folder(kJournal)};
    return toliman_bank_train(a->object, fitter(), &options);
}

static void no_journal(void) {
    put_all();
    empty_folder(kFolder);
}

/* The journal of a training that was stopped once a network was trained. */
static int32_t stop(const char *what, double share, void *unused) {
    (void)what, (void)unused;
    return share >= 0.25; /* of four networks */
}
static void put_journal(void) {
    static saved_file journal;
    no_journal();
    if (journal.size == 0) {
        const toliman_bank_train_options options = {
            .struct_size = sizeof options, .threads = 1, .progress = stop, .journal = in_folder(kJournal)};
        void *const made = make();
        must(toliman_bank_train(made, fitter(), &options) == TOLIMAN_E_CANCELLED, "a training is cancelled");
        toliman_bank_destroy(made);
        keep_file(kJournal, &journal);
    }
    put_file_again(kJournal, &journal);
}

static void check_journal(attempt *a, toliman_status status) {
    (void)a, (void)status;
    must_begin_as_put(kJournal);
}

static toliman_status get_info(attempt *a) {
    return toliman_bank_get_info(bank(), (void *)a->out);
}
static toliman_status get_network(attempt *a) {
    return toliman_bank_get_network(bank(), 3, (void *)a->out);
}
static toliman_status encode(attempt *a) {
    return toliman_bank_encode(bank(), fitter(), PLAIN_IMAGE(large_frames()), 1, shifted, (void *)a->out, NULL);
}
/* One thread: a second one may find no free workspace in any call, and leave one more in the pool. */
static toliman_status encode_many(attempt *a) {
    return toliman_bank_encode(bank(), fitter(), PLAIN_IMAGE(large_frames()), 3, shifted, (void *)a->out, NULL);
}
static toliman_status predict(attempt *a) {
    return toliman_bank_predict(bank(), fitter(), shifted, (void *)a->out);
}
static toliman_status get_renewal(attempt *a) {
    return toliman_bank_get_renewal(bank(), fitter(), 0.5, (double *)a->out);
}
static toliman_status save(attempt *a) {
    size_t size = 0;
    const toliman_status status = toliman_bank_save(bank(), TOLIMAN_CAE_ENCODING_BF16, a->out, OUT_CAPACITY, &size);
    must(status == TOLIMAN_OK ? size > 0 : size == 0, "needed");
    return status;
}
static toliman_status save_file(attempt *a) {
    (void)a;
    return toliman_bank_save_file(bank(), TOLIMAN_CAE_ENCODING_FP16, in_folder(kSaved));
}
static toliman_status load(attempt *a) {
    return toliman_bank_load(plain_blob().bytes, plain_blob().size, NULL, (toliman_bank **)&a->made);
}
static toliman_status load_damaged(attempt *a) {
    static unsigned char bytes[OUT_CAPACITY];
    memcpy(bytes, plain_blob().bytes, plain_blob().size);
    bytes[plain_blob().size / 2] ^= 1;
    return toliman_bank_load(bytes, plain_blob().size, NULL, (toliman_bank **)&a->made);
}
static toliman_status load_file(attempt *a) {
    return toliman_bank_load_file(in_folder(kFile), NULL, (toliman_bank **)&a->made);
}

#define PARTIAL "bank.h: networks that were trained remain, so that a later call continues"
enum { RESULT = sizeof(toliman_bank_result) };

static const scenario all[] = {
    {.function = "toliman_bank_create", .call = create_flight, .made = &banks, .stage = put_all, .slow = 1},
    {.function = "toliman_bank_plan", .call = plan, .stage = put_all, .struct_size = sizeof(toliman_bank_plan_info)},
    {.function = "toliman_bank_destroy", .call = destroy, .make = make, .of = &banks},
    {.function = "toliman_bank_train",
     .call = train,
     .make = make,
     .of = &banks,
     .stage = put_all,
     .partial = PARTIAL,
     .slow = 1},
    {.function = "toliman_bank_train",
     "new journal",
     train_with_journal,
     .make = make,
     .of = &banks,
     .stage = no_journal,
     .partial = PARTIAL,
     .slow = 1},
    {.function = "toliman_bank_train",
     "journal",
     train_with_journal,
     .make = make,
     .of = &banks,
     .stage = put_journal,
     .check = check_journal,
     .partial = PARTIAL,
     .slow = 1},
    {.function = "toliman_bank_get_info", .call = get_info, .stage = put_all, .struct_size = sizeof(toliman_bank_info)},
    {.function = "toliman_bank_get_network",
     .call = get_network,
     .stage = put_all,
     .struct_size = sizeof(toliman_bank_network)},
    {.function = "toliman_bank_encode",
     .call = encode,
     .stage = put_all,
     .struct_size = RESULT,
     .slow = 1,
     .allocates_nothing = 1},
    {.function = "toliman_bank_encode", "many", encode_many, .stage = put_all, .struct_size = RESULT, .slow = 1},
    {.function = "toliman_bank_predict",
     .call = predict,
     .stage = put_all,
     .struct_size = RESULT,
     .allocates_nothing = 1},
    {.function = "toliman_bank_get_renewal", .call = get_renewal, .stage = put_all, .slow = 1, .allocates_nothing = 1},
    {.function = "toliman_bank_save", .call = save, .stage = put_all, .slow = 1},
    {.function = "toliman_bank_save_file", .call = save_file, .stage = put_old, .check = check_saved, .slow = 1},
    {.function = "toliman_bank_load", .call = load, .made = &banks, .stage = put_all, .slow = 1},
    {.function = "toliman_bank_load",
     "damaged",
     load_damaged,
     .made = &banks,
     .stage = put_all,
     .refused = TOLIMAN_E_FORMAT},
    {.function = "toliman_bank_load_file", .call = load_file, .made = &banks, .stage = put_file, .slow = 1},
};
SCENARIO_LIST(bank_scenarios, all);
