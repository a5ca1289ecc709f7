/* Tests threads that create, use and destroy objects of every kind concurrently, while the host plans FFTs and
 * multiplies matrices itself: each must get the bits that a single thread gets, and so must the host. Also for
 * ThreadSanitizer. Usage: threads ROUNDS [WORKERS]; ROUNDS objects per worker. */
#include <complex.h>
#include <fftw3.h>
#include <pthread.h>

#include "cae_scene.h"
#include "images.h"
#include "scene_text.h"
#include "track_frames.h"

#include <toliman/toliman.h>

void cblas_dgemm(int layout, int transposed_a, int transposed_b, int m, int n, int k, double alpha, const double *a,
                 int lda, const double *b, int ldb, double beta, double *c, int ldc);

enum { SIDE_PX = 32, KINDS = 8, MOST_WORKERS = 64, SIZE = 48, MOST_RESULTS = 64 };

typedef struct results {
    double values[MOST_RESULTS];
    size_t count;
} results;

typedef struct worker {
    pthread_t thread;
    int rounds, failed;
    uint64_t seed;
} worker;

static results alone[KINDS];
static toliman_sim *shared_sim;
static toliman_period *shared_period;
static double shared_frame[SIDE_PX * SIDE_PX], wide_frames[2 * kPixels], times[MOST_RESULTS], values[MOST_RESULTS];
static toliman_cae *shared_cae;
static uint8_t *blob;
static size_t blob_size;
static int host_ends;

static void add(results *all, double value) {
    all->values[all->count++] = value;
}

static int use_sim(results *found) {
    double frame[SIDE_PX * SIDE_PX];
    toliman_sim *sim = NULL;
    int32_t status = toliman_sim_create_json(kSingleScene, strlen(kSingleScene), NULL, NULL, &sim);
    if (status == TOLIMAN_OK)
        status = toliman_sim_frame(sim, &(double){0}, 3, 9, 1, frame);
    add(found, frame[SIDE_PX * SIDE_PX / 2 + SIDE_PX / 2]);
    toliman_sim_destroy(sim);
    return status != TOLIMAN_OK;
}

/* A simulator shared by all threads. */
static int use_shared(results *found) {
    double frames[2 * SIDE_PX * SIDE_PX], power[3];
    int32_t status = toliman_sim_frame(shared_sim, NULL, 5, 1, 2, frames);
    if (status == TOLIMAN_OK)
        status = toliman_period_query_power(shared_period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 3, power);
    for (size_t i = 0; i < 2 * SIDE_PX * SIDE_PX; i += 100)
        add(found, frames[i]);
    for (int i = 0; i < 3; i++)
        add(found, power[i]);
    return status != TOLIMAN_OK;
}

static int use_linear(results *found) {
    double value = 0;
    toliman_linear *linear = NULL;
    int32_t status = toliman_linear_create(shared_sim, NULL, &linear);
    if (status == TOLIMAN_OK)
        status = toliman_linear_encode(linear, PLAIN_IMAGE(shared_frame), 1, &value, NULL);
    add(found, value);
    toliman_linear_destroy(linear);
    return status != TOLIMAN_OK;
}

static int use_components(results *found) {
    double frame[SIDE_PX * SIDE_PX], series[3] = {0};
    toliman_components_train_options how = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    toliman_components *components = NULL;
    how.threads = 2;
    int32_t status = toliman_components_create(shared_sim, NULL, &components);
    for (int64_t k = 0; k < 3 && status == TOLIMAN_OK; k++) {
        status = toliman_sim_frame(shared_sim, &(double){0}, 2, k, 1, frame);
        if (status == TOLIMAN_OK)
            status = toliman_components_push(components, PLAIN_IMAGE(frame), 1);
    }
    if (status == TOLIMAN_OK)
        status = toliman_components_train(components, &how, NULL);
    if (status == TOLIMAN_OK)
        status = toliman_components_get_series(components, 0, series, NULL);
    for (int i = 0; i < 3; i++)
        add(found, series[i]);
    toliman_components_destroy(components);
    return status != TOLIMAN_OK;
}

/* A network of the thread's own and one shared by all threads. */
static int use_network(results *found) {
    double latents[3] = {0};
    toliman_cae *cae = NULL;
    int32_t status = toliman_cae_load(blob, blob_size, NULL, &cae);
    if (status == TOLIMAN_OK)
        status = toliman_cae_encode(cae, PLAIN_IMAGE(wide_frames), 1, &latents[0], NULL);
    if (status == TOLIMAN_OK)
        status = toliman_cae_encode(shared_cae, PLAIN_IMAGE(wide_frames), 2, &latents[1], NULL);
    for (int i = 0; i < 3; i++)
        add(found, latents[i]);
    toliman_cae_destroy(cae);
    return status != TOLIMAN_OK;
}

static int use_period(results *found) {
    toliman_period *period = NULL, *again = NULL;
    toliman_period_peak peak = {.struct_size = sizeof peak};
    unsigned char state[8192];
    size_t size = 0;
    int32_t status = toliman_period_create(0.01, 0.002, 40, NULL, &period);
    if (status == TOLIMAN_OK)
        status = toliman_period_push_many(period, times, values, NULL, MOST_RESULTS);
    if (status == TOLIMAN_OK)
        status = toliman_period_save(period, state, sizeof state, &size);
    if (status == TOLIMAN_OK)
        status = toliman_period_load(state, size, NULL, &again);
    if (status == TOLIMAN_OK)
        status = toliman_period_query_peak(again, &peak);
    add(found, peak.power);
    add(found, peak.frequency);
    toliman_period_destroy(period);
    toliman_period_destroy(again);
    return status != TOLIMAN_OK;
}

static int use_batch(results *found) {
    enum { GRID = 3000 };
    static __thread double power[GRID];
    toliman_period_batch_options options = TOLIMAN_PERIOD_BATCH_OPTIONS_INIT;
    options.threads = 2;
    const int32_t status = toliman_period_batch(0.01, 1e-4, GRID, times, values, NULL, MOST_RESULTS, &options, power);
    for (int i = 0; i < GRID; i += 300)
        add(found, power[i]);
    return status != TOLIMAN_OK;
}

static int use_track(results *found) {
    toliman_track_options options = small_options(NULL);
    options.ledger.capacity = 100;
    options.threads = 2;
    toliman_track *track = NULL;
    const toliman_period *sums = NULL;
    double power[3] = {0};
    int32_t status = toliman_track_create(&options, &track);
    for (int64_t id = 1; id <= 10 && status == TOLIMAN_OK; id++) {
        small_frame frame;
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        size_t done;
        make_frame(&frame, id);
        status = toliman_track_push(track, &frame.frame, 1, &outcome, &done);
    }
    if (status == TOLIMAN_OK)
        status = toliman_track_get_period(track, &sums);
    if (status == TOLIMAN_OK)
        status = toliman_period_query_power(sums, TOLIMAN_PERIOD_POWER_STANDARD, 0, 3, power);
    for (int i = 0; i < 3; i++)
        add(found, power[i]);
    toliman_track_destroy(track);
    return status != TOLIMAN_OK;
}

static int (*const uses[KINDS])(results *) = {use_sim,     use_shared, use_linear, use_components,
                                              use_network, use_period, use_batch,  use_track};

/* A failing call, whose message must be that of this thread. */
static int fail_alone(uint64_t seed) {
    char text[64];
    toliman_period *none = NULL;
    const double wrong = -1 - (double)(seed % 1000);
    snprintf(text, sizeof text, "%g", wrong);
    return toliman_period_create(0.1, wrong, 10, NULL, &none) != TOLIMAN_E_ARGUMENT ||
           strstr(toliman_last_error(), text) == NULL;
}

static void *work(void *given) {
    worker *self = given;
    for (int round = 0; round < self->rounds; round++) {
        const size_t kind = draw(&self->seed, KINDS);
        results found = {.count = 0};
        int failed = uses[kind](&found) || found.count != alone[kind].count ||
                     memcmp(found.values, alone[kind].values, found.count * sizeof *found.values) != 0;
        failed |= round % 16 == 0 && fail_alone(self->seed);
        self->failed += failed;
    }
    return NULL;
}

static double plan_and_transform(int size) {
    fftw_complex *data = fftw_alloc_complex((size_t)size);
    fftw_plan plan = fftw_plan_dft_1d(size, data, data, FFTW_FORWARD, FFTW_ESTIMATE);
    for (int i = 0; i < size; i++)
        data[i] = i % 7;
    fftw_execute(plan);
    const double sum = creal(data[0]) + cimag(data[1]);
    fftw_destroy_plan(plan);
    fftw_free(data);
    return sum;
}

static double multiply(void) {
    static double a[SIZE * SIZE], c[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; i++)
        a[i] = i % 11;
    cblas_dgemm(101, 111, 111, SIZE, SIZE, SIZE, 1, a, SIZE, a, SIZE, 0, c, SIZE);
    return c[SIZE + 1];
}

static void *host(void *failed) {
    const double product = multiply(), transformed = plan_and_transform(100);
    for (int size = 16; !__atomic_load_n(&host_ends, __ATOMIC_ACQUIRE); size = size % 500 + 1) {
        plan_and_transform(size);
        *(int *)failed += multiply() != product || plan_and_transform(100) != transformed;
    }
    return NULL;
}

static void prepare_network(void) {
    toliman_sim *wide = make_sim(kSide, kSide, 0, "");
    assert_ok(toliman_sim_frame(wide, NULL, 5, 0, 2, wide_frames));
    shared_cae = make_cae(wide, 1, 0, NULL);
    blob = saved(shared_cae, &blob_size);
    toliman_sim_destroy(wide);
}

static void prepare(void) {
    prepare_network();
    shared_sim = sim_of(kSingleScene);
    assert_ok(toliman_sim_frame(shared_sim, &(double){0}, 1, 1, 1, shared_frame));
    assert_ok(toliman_period_create(0.01, 0.01, 3, NULL, &shared_period));
    for (int i = 0; i < MOST_RESULTS; i++) {
        times[i] = i;
        values[i] = sin(i * 0.7) + 0.001 * (double)(mixed((uint64_t)i) % 100);
        assert_ok(toliman_period_push(shared_period, times[i], values[i], 1));
    }
    for (int kind = 0; kind < KINDS; kind++)
        assert_int_equal(uses[kind](&alone[kind]), 0);
}

/* promises: const-calls-run-together, messages-belong-to-threads, threads-do-not-interfere */
int main(int count, char **arguments) {
    const int rounds = count > 1 ? atoi(arguments[1]) : 40, workers = count > 2 ? atoi(arguments[2]) : 8;
    static worker all[MOST_WORKERS];
    pthread_t host_thread;
    int failed = 0, host_failed = 0;
    assert_in_range(workers, 1, MOST_WORKERS);
    prepare();
    assert_int_equal(pthread_create(&host_thread, NULL, host, &host_failed), 0);
    for (int i = 0; i < workers; i++) {
        all[i] = (worker){.rounds = rounds, .seed = mixed((uint64_t)i)};
        assert_int_equal(pthread_create(&all[i].thread, NULL, work, &all[i]), 0);
    }
    for (int i = 0; i < workers; i++) {
        pthread_join(all[i].thread, NULL);
        failed += all[i].failed;
    }
    __atomic_store_n(&host_ends, 1, __ATOMIC_RELEASE);
    pthread_join(host_thread, NULL);
    failed += host_failed;
    toliman_sim_destroy(shared_sim);
    toliman_period_destroy(shared_period);
    toliman_cae_destroy(shared_cae);
    free(blob);
    printf("%d threads of %d objects: %d failed\n", workers, rounds, failed);
    return failed != 0;
}
