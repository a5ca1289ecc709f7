/* Tests misuse: objects used by two calls at once, pointers to another kind of object, destroyed objects, and sizes
 * beyond all memory. */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "cae_scene.h"
#include "images.h"
#include "samples.h"

#include <toliman/bank.h>
#include <toliman/linear.h>
#include <toliman/toliman.h>

static toliman_period *new_period(int64_t nf) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.01, 0.001, nf, NULL, &period));
    return period;
}

static double value(int i) {
    return (i * 37 % 101) / 101.0;
}

enum { THREADS = 4, SAMPLES = 200, FREQUENCIES = 20000 };

typedef struct Pusher {
    toliman_period *period;
    int first, in[SAMPLES], others;
} Pusher;

static void *push_until_in(void *given) {
    Pusher *p = given;
    for (int i = 0; i < SAMPLES; i++) {
        toliman_status status;
        do {
            status = toliman_period_push(p->period, p->first + i, value(p->first + i), 1);
        } while (status == TOLIMAN_E_STATE);
        if (status != TOLIMAN_OK)
            p->others++;
    }
    return NULL;
}

static void *push_once(void *given) {
    Pusher *p = given;
    for (int i = 0; i < SAMPLES; i++) {
        const toliman_status status = toliman_period_push(p->period, p->first + i, value(p->first + i), 1);
        p->in[i] = status == TOLIMAN_OK;
        if (status != TOLIMAN_OK && status != TOLIMAN_E_STATE)
            p->others++;
    }
    return NULL;
}

static void *state_of(const toliman_period *period, size_t *size) {
    assert_asks(toliman_period_save(period, NULL, 0, size));
    void *bytes = malloc(*size);
    assert_non_null(bytes);
    assert_ok(toliman_period_save(period, bytes, *size, size));
    return bytes;
}

static void assert_same_state(const toliman_period *a, const toliman_period *b) {
    size_t size_a, size_b;
    void *bytes_a = state_of(a, &size_a), *bytes_b = state_of(b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
    free(bytes_a), free(bytes_b);
}

/* A push during another push fails and changes nothing: the sums equal those of the pushes that returned TOLIMAN_OK, to
 * the last bit. */
/* promise: calls-need-exclusive-use */
TEST(pushes_of_many_threads_exclude_each_other) {
    void *(*const ways[])(void *) = {push_once, push_until_in};
    for (int way = 0; way < 2; way++) {
        toliman_period *shared = new_period(FREQUENCIES), *alone = new_period(FREQUENCIES);
        pthread_t threads[THREADS];
        static Pusher pushers[THREADS];
        for (int i = 0; i < THREADS; i++) {
            pushers[i] = (Pusher){.period = shared, .first = i * SAMPLES};
            assert_int_equal(pthread_create(&threads[i], NULL, ways[way], &pushers[i]), 0);
        }
        for (int i = 0; i < THREADS; i++)
            assert_int_equal(pthread_join(threads[i], NULL), 0);
        for (int i = 0; i < THREADS; i++) {
            assert_int_equal(pushers[i].others, 0);
            for (int k = 0; k < SAMPLES; k++)
                if (way == 1 || pushers[i].in[k])
                    assert_ok(toliman_period_push(alone, pushers[i].first + k, value(pushers[i].first + k), 1));
        }
        assert_same_state(shared, alone);
        toliman_period_destroy(shared), toliman_period_destroy(alone);
    }
}

typedef struct Callback {
    toliman_period *period;
    toliman_cae *cae;
    int calls;
    toliman_status pushed, read, destroyed_is_there;
    char message[160];
} Callback;

static int32_t while_it_runs(const char *stage, double fraction, void *given) {
    (void)stage;
    (void)fraction;
    Callback *c = given;
    if (c->calls++ > 0)
        return 0;
    if (c->period != NULL) {
        toliman_period_peak peak = {.struct_size = sizeof peak};
        c->pushed = toliman_period_push(c->period, 1, 1, 1);
        snprintf(c->message, sizeof c->message, "%s", toliman_last_error());
        c->read = toliman_period_query_peak(c->period, &peak);
        toliman_period_destroy(c->period); /* does nothing */
        c->destroyed_is_there = toliman_period_query_peak(c->period, &peak);
    } else {
        toliman_cae_info info = {.struct_size = sizeof info};
        c->read = toliman_cae_get_info(c->cae, NULL, &info);
        snprintf(c->message, sizeof c->message, "%s", toliman_last_error());
    }
    return 0;
}

/* A const call permits concurrent readers, but no writers. */
/* promises: calls-need-exclusive-use, objects-in-use-stay */
TEST(callback_may_read_while_a_const_call_runs) {
    enum { N = 20 };
    double t[N], y[N], residuals[3];
    Callback callback = {.period = new_period(50)};
    for (int i = 0; i < N; i++) {
        t[i] = i;
        y[i] = value(i);
    }
    assert_ok(toliman_period_push_many(callback.period, t, y, NULL, N));
    toliman_period_bootstrap_options options = TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT;
    options.threads = 1;
    options.progress = while_it_runs;
    options.progress_data = &callback;
    assert_ok(toliman_period_query_bootstrap(callback.period, t, y, NULL, N, &options, 3, residuals));
    assert_true(callback.calls > 0);
    assert_int_equal(callback.pushed, TOLIMAN_E_STATE);
    assert_string_equal(callback.message, "period is in use by another thread or by the call that runs this callback");
    assert_int_equal(callback.read, TOLIMAN_OK);
    assert_int_equal(callback.destroyed_is_there, TOLIMAN_OK);
    assert_int_equal(count_of(callback.period), N);
    assert_ok(toliman_period_push(callback.period, N, 0.5, 1));
    toliman_period_destroy(callback.period);
}

/* promise: calls-need-exclusive-use */
TEST(callback_cannot_use_what_is_being_trained) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    Callback callback = {.cae = make_cae(sim, 1, 0, NULL)};
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 1;
    options.progress = while_it_runs;
    options.progress_data = &callback;
    assert_ok(toliman_cae_train(callback.cae, &options, NULL));
    assert_int_equal(callback.read, TOLIMAN_E_STATE);
    toliman_cae_destroy(callback.cae), toliman_sim_destroy(sim);
}

typedef struct Estimating {
    toliman_track *track;
    const toliman_period *sums;
    toliman_status info, peak;
} Estimating;

static int32_t estimate(const toliman_estimate_input *input, toliman_estimate *made, void *given) {
    Estimating *e = given;
    toliman_track_info info = {.struct_size = sizeof info};
    double power;
    e->info = toliman_track_get_info(e->track, &info);
    e->peak = toliman_period_query_power(e->sums, TOLIMAN_PERIOD_POWER_STANDARD, 0, 1, &power);
    made->values[0] = input->image[0];
    return 0;
}

/* Neither the tracker nor its periodogram can be read during a push. */
/* promise: calls-need-exclusive-use */
TEST(tracker_cannot_be_read_while_it_changes) {
    Estimating e = {NULL, NULL, TOLIMAN_OK, TOLIMAN_OK};
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.ledger.capacity = 10;
    options.estimator.estimate = estimate;
    options.estimator.estimate_data = &e;
    options.estimator.sigma = 1;
    options.frames.rows = options.frames.cols = 4;
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.grid.f0 = options.grid.df = 0.1;
    options.grid.nf = 5;
    assert_ok(toliman_track_create(&options, &e.track));
    assert_ok(toliman_track_get_period(e.track, &e.sums));
    const uint16_t pixels[16] = {7};
    const toliman_frame frame = {.struct_size = sizeof frame,
                                 .pixel = TOLIMAN_PIXEL_U16,
                                 .session = "s",
                                 .roi = "r",
                                 .pixels = pixels,
                                 .rows = 4,
                                 .cols = 4};
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done = 0;
    assert_ok(toliman_track_push(e.track, &frame, 1, &outcome, &done));
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    assert_int_equal(e.info, TOLIMAN_E_STATE);
    assert_int_equal(e.peak, TOLIMAN_E_STATE);
    toliman_track_destroy(e.track);
}

/* promises: invalid-handles-are-refused, objects-in-use-stay */
TEST(pointer_to_another_type_is_refused) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    double sigma = -1, power;
    assert_invalid(toliman_period_query_power((const toliman_period *)(const void *)linear,
                                              TOLIMAN_PERIOD_POWER_STANDARD, 0, 1, &power),
                   "period");
    assert_invalid(toliman_linear_get_sigma((const toliman_linear *)(const void *)sim, &sigma), "linear");
    assert_true(sigma == -1);
    toliman_period_destroy((toliman_period *)(void *)linear); /* does nothing */
    assert_non_null(strstr(toliman_last_error(), "toliman_period is not a toliman_period"));
    assert_ok(toliman_linear_get_sigma(linear, &sigma));
    toliman_linear_destroy(linear), toliman_sim_destroy(sim);
}

static const void *read_json(const void *object) {
    return *toliman_mask_get_json(object) == '\0' ? NULL : object;
}

/* All functions that take an object and return no status; tests/header/test_types.py compares with the headers. */
static const struct {
    const char *type;
    const void *(*read)(const void *); /* NULL for ""; otherwise NULL */
    void (*destroy)(void *);
} kWithoutStatus[] = {
#define DESTROYS(type, function)                                                                                       \
    { #type, NULL, (void (*)(void *))function }
    {"toliman_mask", read_json, NULL},
    DESTROYS(toliman_bank, toliman_bank_destroy),
    DESTROYS(toliman_cae, toliman_cae_destroy),
    DESTROYS(toliman_calibration, toliman_calibration_destroy),
    DESTROYS(toliman_coadd, toliman_coadd_destroy),
    DESTROYS(toliman_components, toliman_components_destroy),
    DESTROYS(toliman_measure, toliman_measure_destroy),
    DESTROYS(toliman_fit, toliman_fit_destroy),
    DESTROYS(toliman_ingest, toliman_ingest_destroy),
    DESTROYS(toliman_linear, toliman_linear_destroy),
    DESTROYS(toliman_mask, toliman_mask_destroy),
    DESTROYS(toliman_period, toliman_period_destroy),
    DESTROYS(toliman_planet, toliman_planet_destroy),
    DESTROYS(toliman_series, toliman_series_destroy),
    DESTROYS(toliman_sim, toliman_sim_destroy),
    DESTROYS(toliman_sky, toliman_sky_destroy),
    DESTROYS(toliman_track, toliman_track_destroy)};

/* promises: destroying-null-does-nothing, invalid-handles-are-refused, objects-in-use-stay */
TEST(functions_without_status_check_their_object) {
    toliman_sky *sky = NULL;
    toliman_period *period = new_period(5);
    assert_ok(toliman_sky_create("alpha-cen", NULL, &sky));
    assert_ok(toliman_period_push(period, 1, 1, 1));
    for (size_t i = 0; i < sizeof kWithoutStatus / sizeof *kWithoutStatus; i++) {
        const int is_sky = strcmp(kWithoutStatus[i].type, "toliman_sky") == 0;
        void *const other = is_sky ? (void *)period : (void *)sky, *const none[8] = {NULL};
        char expected[64];
        snprintf(expected, sizeof expected, "is not a %s, or was destroyed", kWithoutStatus[i].type);
        for (int zeros = 0; zeros < 2; zeros++) { /* another type, and memory that is not an object */
            void *const wrong = zeros ? (void *)none : other;
            assert_invalid(toliman_sky_get_element(NULL, TOLIMAN_SKY_ELEMENT_PERIOD, NULL, NULL), "sky");
            if (kWithoutStatus[i].read != NULL)
                assert_null(kWithoutStatus[i].read(wrong));
            else
                kWithoutStatus[i].destroy(wrong);
            if (strstr(toliman_last_error(), expected) == NULL)
                fail_msg("%s: \"%s\"", kWithoutStatus[i].type, toliman_last_error());
            if (kWithoutStatus[i].read != NULL)
                assert_null(kWithoutStatus[i].read(NULL));
            else
                kWithoutStatus[i].destroy(NULL);
        }
    }
    double value = 0;
    assert_ok(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_PERIOD, &value, NULL));
    assert_int_equal(count_of(period), 1);
    toliman_sky_destroy(sky), toliman_period_destroy(period);
}

/* Works as long as the freed memory still shows it; a sanitizer would stop the program at the first access. */
/* promise: invalid-handles-are-refused */
TEST(destroyed_object_is_refused) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    toliman_period *period = new_period(5);
    toliman_period *volatile hidden = period; /* hides from the compiler that the object was freed */
    toliman_period_destroy(period);
    assert_invalid(toliman_period_push(hidden, 1, 1, 1), "period");
    toliman_period_destroy(hidden); /* does nothing */
    period = new_period(5);
    assert_ok(toliman_period_push(period, 1, 1, 1));
    toliman_period_destroy(period);
#endif
}

/* Of frames: test_images. */
TEST(counts_beyond_memory_are_refused) {
    const size_t many = (size_t)1 << 60;
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_period *period = new_period(5);
    double numbers[4] = {0}, out[4];
    assert_refused(toliman_sim_frame(sim, numbers, 1, 0, many, out), TOLIMAN_E_RANGE, "images");
    assert_refused(toliman_period_push_many(period, numbers, numbers, NULL, many), TOLIMAN_E_RANGE, "t");
    assert_refused(toliman_period_batch(0, 0.1, 3, numbers, numbers, NULL, many, NULL, out), TOLIMAN_E_RANGE, "t");
    assert_int_equal(count_of(period), 0);
    toliman_period_destroy(period), toliman_sim_destroy(sim);
}

/* Options of a newer header are larger than the library's, which would have to ignore their additional members. */
TEST(newer_options_are_refused) {
    static unsigned char bytes[1024];
    toliman_period *period = NULL;
    memcpy(bytes, &(uint32_t){sizeof(toliman_period_options) + 8}, sizeof(uint32_t));
    assert_invalid(toliman_period_create(0, 0.1, 3, (const void *)bytes, &period), "options->struct_size");
    assert_null(period);
    assert_int_equal(toliman_get_struct_size("toliman_mach"), 0);
    assert_int_equal(toliman_get_struct_size(NULL), 0);
}

RUN_TESTS(NULL, NULL)
