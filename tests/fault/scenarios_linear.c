/* linear.h, components.h */
#include "assert_close.h"
#include "images.h"
#include "scenario.h"

enum { PIXELS = SMALL * SMALL };

static void *make(void) {
    const toliman_linear_options options = {.struct_size = sizeof options, .threads = 3};
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(small_sim(), &options, &linear));
    return linear;
}

static const toliman_linear *fitter(void) {
    static toliman_linear *linear;
    return linear != NULL ? linear : (linear = make());
}

static void end(void *linear) {
    toliman_linear_destroy(linear);
}

static uint64_t digest(const void *linear) {
    double value = 0;
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(small_frames()), 1, &value, NULL));
    return fnv1a(FNV_START, &value, sizeof value);
}

static const object_kind fitters = {end, digest};

static void *make_components(void) {
    toliman_components *components = NULL;
    assert_ok(toliman_components_create(small_sim(), NULL, &components));
    for (size_t i = 0; i + 1 < FRAMES; i++)
        assert_ok(toliman_components_push(components, PLAIN_IMAGE(small_frames() + i * PIXELS), 1));
    return components;
}

static toliman_status train_by(void *components, int32_t method, uint32_t threads, void *report) {
    toliman_components_train_options options = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    options.method = method;
    options.components = 2;
    options.iterations = 5;
    options.threads = threads;
    return toliman_components_train(components, &options, report);
}

static void *make_trained(void) {
    void *const components = make_components();
    assert_ok(train_by(components, TOLIMAN_COMPONENTS_PCA, 1, NULL));
    return components;
}

static void destroy_collection(void *components) {
    toliman_components_destroy(components);
}

static uint64_t digest_components(const void *components) {
    double series[FRAMES];
    toliman_components_info info = {.struct_size = sizeof info};
    assert_ok(toliman_components_get_info(components, &info));
    uint64_t hash = fnv1a(FNV_START, &info, sizeof info);
    for (int64_t i = 0; i < info.components; i++) {
        assert_ok(toliman_components_get_series(components, (int64_t)i, series, NULL));
        hash = fnv1a(hash, series, (size_t)info.frames * sizeof *series);
    }
    return hash;
}

static const object_kind collections = {destroy_collection, digest_components};

static toliman_status create(attempt *a) {
    return toliman_linear_create(small_sim(), NULL, (toliman_linear **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_linear_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status encode(attempt *a) {
    return toliman_linear_encode(fitter(), PLAIN_IMAGE(small_frames()), 1, (double *)a->out, NULL);
}
static toliman_status encode_many(attempt *a) {
    double *const out = (double *)a->out;
    toliman_frame_goodness fits[FRAMES] = {TOLIMAN_FRAME_GOODNESS_INIT};
    const toliman_status status = toliman_linear_encode(fitter(), PLAIN_IMAGE(small_frames()), FRAMES, out, fits);
    if (status == TOLIMAN_OK)
        memcpy(out + FRAMES, fits, sizeof fits);
    return status;
}
static toliman_status get_sigma(attempt *a) {
    return toliman_linear_get_sigma(fitter(), (double *)a->out);
}
static toliman_status create_components(attempt *a) {
    return toliman_components_create(small_sim(), NULL, (toliman_components **)&a->made);
}
static toliman_status destroy_components(attempt *a) {
    toliman_components_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status push_frame(attempt *a) {
    return toliman_components_push(a->object, PLAIN_IMAGE(small_frames() + (FRAMES - 1) * PIXELS), 1);
}
static toliman_status train_pca(attempt *a) {
    return train_by(a->object, TOLIMAN_COMPONENTS_PCA, 1, a->out);
}
static toliman_status train_dictionary(attempt *a) {
    return train_by(a->object, TOLIMAN_COMPONENTS_DICTIONARY, 3, a->out);
}
static toliman_status get_series(attempt *a) {
    double *const out = (double *)a->out;
    return toliman_components_get_series(a->object, 1, out, out + FRAMES);
}
static toliman_status get_components_info(attempt *a) {
    return toliman_components_get_info(a->object, (void *)a->out);
}

static void put_frames(void) {
    (void)small_frames();
}

enum { REPORT = sizeof(toliman_components_training), FACTS = sizeof(toliman_components_info) };

static const scenario all[] = {
    {.function = "toliman_linear_create", .call = create, .made = &fitters, .stage = put_frames},
    {.function = "toliman_linear_destroy", .call = destroy, .make = make, .of = &fitters},
    {.function = "toliman_linear_encode", .call = encode, .stage = put_frames, .allocates_nothing = 1},
    {.function = "toliman_linear_encode", "many", encode_many, .stage = put_frames},
    {.function = "toliman_linear_get_sigma", .call = get_sigma},
    {.function = "toliman_components_create", .call = create_components, .made = &collections},
    {.function = "toliman_components_destroy", .call = destroy_components, .make = make_trained, .of = &collections},
    {.function = "toliman_components_push", .call = push_frame, .make = make_trained, .of = &collections},
    {.function = "toliman_components_train", "PCA", train_pca, make_components, &collections, .struct_size = REPORT},
    {.function = "toliman_components_train",
     "dictionary",
     train_dictionary,
     make_trained,
     &collections,
     .struct_size = REPORT},
    {.function = "toliman_components_get_series", .call = get_series, .make = make_trained, .of = &collections},
    {.function = "toliman_components_get_info",
     .call = get_components_info,
     .make = make_trained,
     .of = &collections,
     .struct_size = FACTS},
};
SCENARIO_LIST(linear_scenarios, all);
