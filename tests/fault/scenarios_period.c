/* period.h */
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "assert_close.h"
#include "measure_arrays.h"
#include "scenario.h"

#include <toliman/period_noise.h>

enum { SAMPLES = 60, FREQUENCIES = 90, STATE_CAPACITY = 65536, PEAKS = 3, DRAWS = 4, ARCHIVE = 3000, BINS = 3000 };
#define F0 0.01
#define DF 0.005

static double t[ARCHIVE], y[ARCHIVE];

static void fill(void) {
    for (int i = 0; i < ARCHIVE; i++) {
        t[i] = i + 0.3 * ((i * 7919) % 100) / 100;
        y[i] = 1000 * sin(0.7 * t[i]) + (i * 31) % 17;
    }
}

static toliman_status create_with(uint32_t flags, double value_offset, void **made) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = flags;
    options.value_offset = value_offset;
    return toliman_period_create(F0, DF, FREQUENCIES, &options, (toliman_period **)made);
}

static void *made_with(uint32_t flags, double value_offset) {
    void *made = NULL;
    fill();
    assert_ok(create_with(flags, value_offset, &made));
    assert_ok(toliman_period_push_many(made, t, y, NULL, SAMPLES));
    return made;
}

static void *make(void) {
    return made_with(0, 0);
}
static void *make_double_limb(void) {
    return made_with(TOLIMAN_PERIOD_DOUBLE_LIMB, 0);
}

#define SHARED(name, flags, value_offset)                                                                              \
    static const toliman_period *name(void) {                                                                          \
        static toliman_period *made;                                                                                   \
        return made != NULL ? made : (made = made_with(flags, value_offset));                                          \
    }
SHARED(samples, 0, 0)
SHARED(shifted, 0, 3)
SHARED(wide, TOLIMAN_PERIOD_DOUBLE_LIMB, 3)

static void end(void *period) {
    toliman_period_destroy(period);
}

static uint64_t digest(const void *period) {
    static unsigned char bytes[STATE_CAPACITY];
    size_t size = 0;
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    return fnv1a(FNV_START, bytes, size);
}

static const object_kind periods = {end, digest};

/* States, and files with states. */
typedef struct {
    unsigned char bytes[STATE_CAPACITY];
    size_t size;
} state;

static const state *state_of(const toliman_period *period, state *made) {
    if (made->size == 0)
        assert_ok(toliman_period_save(period, made->bytes, sizeof made->bytes, &made->size));
    return made;
}

static const state *new_state(void) {
    static state made;
    return state_of(samples(), &made);
}
static const state *old_state(void) {
    static state made;
    return state_of(shifted(), &made);
}

static const char kFile[] = "state.tlmp", kFolder[] = "states", kSaved[] = "states/state.tlmp", kLink[] = "link.tlmp";
enum { MODE = 0640 };

static void put_file(void) {
    write_file(kFile, new_state()->bytes, new_state()->size);
}
static void put_old(void) {
    new_state();
    empty_folder(kFolder);
    write_file(kSaved, old_state()->bytes, old_state()->size);
    unlink(in_folder(kLink));
    must(chmod(in_folder(kSaved), MODE) == 0 && symlink(kSaved, in_folder(kLink)) == 0, "no link");
}

static void check_saved(attempt *a, toliman_status status) {
    static state found;
    struct stat attributes = {0};
    toliman_period *loaded = NULL;
    found.size = read_file(kSaved, found.bytes, sizeof found.bytes);
    const int is_new = found.size == new_state()->size && memcmp(found.bytes, new_state()->bytes, found.size) == 0;
    const int is_old = found.size == old_state()->size && memcmp(found.bytes, old_state()->bytes, found.size) == 0;
    (void)a;
    must(status == TOLIMAN_OK ? is_new : is_new || is_old, "neither the old file nor the new one");
    must(toliman_period_load_file(in_folder(kSaved), NULL, &loaded) == TOLIMAN_OK, "what is there does not load");
    must(stat(in_folder(kSaved), &attributes) == 0 && (attributes.st_mode & 0777) == MODE, "other permissions");
    must(lstat(in_folder(kLink), &attributes) == 0 && S_ISLNK(attributes.st_mode), "the link is replaced");
    must(files_in(kFolder) == 1 || status == TOLIMAN_E_WRITE, "another file is left");
    toliman_period_destroy(loaded);
}

static toliman_status create(attempt *a) {
    return create_with(TOLIMAN_PERIOD_DOUBLE_LIMB, 0, &a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_period_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status copy(attempt *a) {
    return toliman_period_copy(a->object, (toliman_period **)&a->made);
}
static toliman_status load(attempt *a) {
    return toliman_period_load(new_state()->bytes, new_state()->size, NULL, (toliman_period **)&a->made);
}
static toliman_status load_damaged(attempt *a) {
    static unsigned char bytes[STATE_CAPACITY];
    memcpy(bytes, new_state()->bytes, new_state()->size);
    bytes[new_state()->size / 2] ^= 1;
    return toliman_period_load(bytes, new_state()->size, NULL, (toliman_period **)&a->made);
}
static toliman_status load_file(attempt *a) {
    return toliman_period_load_file(in_folder(kFile), NULL, (toliman_period **)&a->made);
}
static toliman_status save(attempt *a) {
    size_t size = 0;
    const toliman_status status = toliman_period_save(samples(), a->out, OUT_CAPACITY, &size);
    must(status == TOLIMAN_OK ? size > 0 : size == 0, "needed");
    return status;
}
static toliman_status save_file(attempt *a) {
    (void)a;
    return toliman_period_save_file(samples(), in_folder(kLink));
}
static toliman_status push(attempt *a) {
    return toliman_period_push(a->object, 100, 1, 1);
}
static toliman_status push_samples(attempt *a) {
    const toliman_period_sample sample = {
        .struct_size = sizeof sample, .flags = TOLIMAN_PERIOD_TIME_NS, .t_ns = 100, .y = 1, .sigma = 1};
    return toliman_period_push_samples(a->object, &sample, NULL, 1);
}
static toliman_status push_many(attempt *a) {
    return toliman_period_push_many(a->object, t + SAMPLES, y + SAMPLES, NULL, SAMPLES);
}
static toliman_status push_bad(attempt *a) {
    static const double times[] = {70, NAN};
    return toliman_period_push_many(a->object, times, y, NULL, 2);
}
static toliman_status retract_samples(attempt *a) {
    const toliman_period_sample sample = {.struct_size = sizeof sample, .t = t[3], .y = y[3]};
    return toliman_period_retract_samples(a->object, &sample, NULL, 1);
}
static toliman_status merge(attempt *a) {
    return toliman_period_merge(a->object, samples());
}
static toliman_status merge_re_referenced(attempt *a) {
    return toliman_period_merge(a->object, shifted());
}
static toliman_status merge_double_limb(attempt *a) {
    return toliman_period_merge(a->object, wide());
}

/* A trend and a column. */
static void *make_rows(void) {
    fill();
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.trend = 2;
    options.trend_end = ARCHIVE;
    options.columns = 1;
    options.column_bound[0] = 2000;
    toliman_period *made = NULL;
    assert_ok(toliman_period_create(F0, DF, FREQUENCIES, &options, &made));
    for (int i = 0; i < SAMPLES; i++) {
        const toliman_period_sample sample = {.struct_size = sizeof sample, .t = t[i], .y = y[i]};
        assert_ok(toliman_period_push_samples(made, &sample, &y[i + 7], 1));
    }
    return made;
}
static toliman_status query_coefficients(attempt *a) {
    return toliman_period_query_coefficients(a->object, 20, 4, (double *)a->out, (double *)(a->out + 64));
}
static toliman_status query_fit_rows(attempt *a) {
    return toliman_period_query_fit(a->object, t, y, NULL, &y[7], SAMPLES, (void *)a->out);
}
static toliman_status suggest(attempt *a) {
    toliman_period_options options = {.struct_size = sizeof options};
    fill();
    return toliman_period_suggest(t, y, NULL, SAMPLES, 0, (double *)a->out, (double *)(a->out + 8),
                                  (int64_t *)(a->out + 16), &options);
}
static toliman_status get_info(attempt *a) {
    return toliman_period_get_info(samples(), (void *)a->out);
}
static toliman_status query_power(attempt *a) {
    return toliman_period_query_power(a->object, TOLIMAN_PERIOD_POWER_LOG, 0, FREQUENCIES, (double *)a->out);
}
static toliman_status query_model(attempt *a) {
    return toliman_period_query_model(samples(), 20, (void *)a->out);
}
static toliman_status query_peak(attempt *a) {
    return toliman_period_query_peak(samples(), (void *)a->out);
}
static toliman_status query_peaks(attempt *a) {
    return toliman_period_query_peaks(samples(), (void *)a->out, PEAKS, (size_t *)(a->out + 8192));
}
static toliman_status query_fit(attempt *a) {
    return toliman_period_query_fit(samples(), t, y, NULL, NULL, SAMPLES, (void *)a->out);
}
static toliman_status query_fap(attempt *a) {
    return toliman_period_query_fap(samples(), TOLIMAN_PERIOD_FAP_SEQUENTIAL, -3, (double *)a->out);
}
static toliman_status query_threshold(attempt *a) {
    return toliman_period_query_threshold(samples(), TOLIMAN_PERIOD_FAP_SEQUENTIAL, -3, (double *)a->out);
}
static toliman_status query_bootstrap(attempt *a) {
    toliman_period_bootstrap_options options = TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT;
    options.threads = 2;
    return toliman_period_query_bootstrap(samples(), t, y, NULL, SAMPLES, &options, DRAWS, (double *)a->out);
}
static toliman_status query_sampling(attempt *a) {
    return toliman_period_query_sampling(samples(), t, SAMPLES, (void *)a->out);
}
static toliman_status query_aliases(attempt *a) {
    return toliman_period_query_aliases(samples(), F0, (void *)a->out, PEAKS, (size_t *)(a->out + 8192));
}

static toliman_status batch_with(size_t n, int64_t nf, double tolerance, uint32_t threads, double *power) {
    toliman_period_batch_options options = TOLIMAN_PERIOD_BATCH_OPTIONS_INIT;
    options.tolerance = tolerance;
    options.threads = threads;
    return toliman_period_batch(F0, 0.4 / (double)nf, nf, t, y, NULL, n, &options, power);
}
static toliman_status batch_direct(attempt *a) {
    return batch_with(SAMPLES, FREQUENCIES, 0, 2, (double *)a->out);
}
static toliman_status batch_fft(attempt *a) {
    return batch_with(ARCHIVE, BINS, 1e-6, 1, (double *)a->out);
}
static toliman_status batch_threads(attempt *a) {
    return batch_with(ARCHIVE, BINS, 1e-6, 3, (double *)a->out);
}
/* Values with a mean so large that the direct sums cancel. */
static toliman_status batch_exact(attempt *a) {
    static double above[SAMPLES];
    for (int i = 0; i < SAMPLES; i++)
        above[i] = y[i] * 1e-3 + 1e12;
    return toliman_period_batch(1e-9, 1e-9, 20, t, above, NULL, SAMPLES, NULL, (double *)a->out);
}

static toliman_status noise_search(attempt *a) {
    toliman_period_noise_options options = TOLIMAN_PERIOD_NOISE_OPTIONS_INIT;
    fill();
    static toliman_measure *series;
    if (series == NULL) {
        series = measure_of(t, y, NULL, SAMPLES);
        assert_ok(toliman_measure_add_column(series, "c", t + SAMPLES, SAMPLES, 0));
    }
    return toliman_measure_query_noise(series, F0, DF, FREQUENCIES, &options, (double *)(a->out + 4096),
                                       (double *)(a->out + 2048), (double *)(a->out + 2056), (void *)a->out);
}
static toliman_status noise_bootstrap(attempt *a) {
    toliman_period_noise_bootstrap_options options = TOLIMAN_PERIOD_NOISE_BOOTSTRAP_OPTIONS_INIT;
    options.threads = 2;
    fill();
    static toliman_measure *series;
    if (series == NULL)
        series = measure_of(t, y, NULL, SAMPLES);
    return toliman_measure_query_noise_bootstrap(series, F0, DF, FREQUENCIES, 0.3, &options, DRAWS, (double *)a->out);
}

static void put_states(void) {
    (void)old_state(), (void)new_state(), (void)wide();
}

enum { PEAK = sizeof(toliman_period_peak) };
#define ON_ONE(name)                                                                                                   \
    { .function = "toliman_period_" #name, .call = name, .make = make, .of = &periods }
#define ON_ROWS(name)                                                                                                  \
    { .function = "toliman_period_" #name, .call = name, .make = make_rows, .of = &periods }
#define QUERIES(name, size)                                                                                            \
    { .function = "toliman_period_" #name, .call = name, .struct_size = size, .stage = put_states }

static const scenario all[] = {
    {.function = "toliman_period_create", .call = create, .made = &periods},
    ON_ONE(destroy),
    {.function = "toliman_period_copy", .call = copy, .make = make, .of = &periods, .made = &periods},
    {.function = "toliman_period_load", .call = load, .made = &periods, .stage = put_states},
    {.function = "toliman_period_load",
     "damaged",
     load_damaged,
     .made = &periods,
     .stage = put_states,
     .refused = TOLIMAN_E_FORMAT},
    {.function = "toliman_period_push_many", "NaN", push_bad, make, &periods, .refused = TOLIMAN_E_ARGUMENT},
    {.function = "toliman_period_load_file", .call = load_file, .made = &periods, .stage = put_file},
    QUERIES(save, 0),
    {.function = "toliman_period_save_file", .call = save_file, .stage = put_old, .check = check_saved},
    ON_ONE(push),
    ON_ONE(push_samples),
    ON_ONE(push_many),
    ON_ONE(retract_samples),
    ON_ROWS(query_coefficients),
    {.function = "toliman_period_query_fit",
     .call = query_fit_rows,
     .make = make_rows,
     .of = &periods,
     .struct_size = PEAK},
    ON_ONE(merge),
    {.function = "toliman_period_merge", "re-referenced", merge_re_referenced, make, &periods, .stage = put_states},
    {.function = "toliman_period_merge",
     "double-limb into single-limb",
     merge_double_limb,
     make,
     &periods,
     .stage = put_states},
    {.function = "toliman_period_suggest", .call = suggest},
    QUERIES(get_info, sizeof(toliman_period_info)),
    ON_ONE(query_power),
    {.function = "toliman_period_query_power", "double-limb", query_power, make_double_limb, &periods},
    QUERIES(query_model, sizeof(toliman_period_model)),
    QUERIES(query_peak, PEAK),
    QUERIES(query_peaks, PEAK),
    QUERIES(query_fit, PEAK),
    QUERIES(query_fap, 0),
    QUERIES(query_threshold, 0),
    QUERIES(query_bootstrap, 0),
    QUERIES(query_sampling, sizeof(toliman_period_sampling)),
    QUERIES(query_aliases, sizeof(toliman_period_alias)),
    {.function = "toliman_period_batch", "direct", batch_direct, .stage = put_states},
    {.function = "toliman_period_batch", "FFT", batch_fft, .stage = put_states},
    {.function = "toliman_period_batch", "threads", batch_threads, .stage = put_states},
    {.function = "toliman_period_batch", "exact", batch_exact, .stage = put_states},
    {.function = "toliman_measure_query_noise", .call = noise_search, .struct_size = sizeof(toliman_period_noise)},
    {.function = "toliman_measure_query_noise_bootstrap", .call = noise_bootstrap},
};
SCENARIO_LIST(period_scenarios, all);
