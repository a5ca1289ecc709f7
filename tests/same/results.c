/* Writes the library's results as files of numbers, for a given instruction set, number of workers and order. Usage:
 * same_results FOLDER MODEL ISA WORKERS ORDER
 *
 *   ISA      0 baseline, 1 avx2, 2 avx512; the program exits with 77 if this processor does not support it
 *   ORDER    0: original order; else frames and samples are shuffled, and objects saved and loaded at random points
 *   MODEL    FOLDER of an earlier run with frames and weights for the estimators, or - for those of this run */
#include <sys/stat.h>

#include "cae_scene.h"
#include "images.h"
#include "track_frames.h"

#include <toliman/toliman.h>

enum { FRAMES = 8, SAMPLES = 1500, GRID = 400, FINE = 10000, TRACKED = 150, MOST_BYTES = 8 << 20 };

int shim_choose_isa(int isa);

static const char *into, *model;
static uint32_t workers;
static uint64_t order;
static unsigned char bytes[MOST_BYTES];

static FILE *opened(const char *folder, const char *name, const char *how) {
    char path[600];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, how);
    if (file == NULL)
        fail_msg("%s cannot be opened", path);
    return file;
}

static void keep(const char *name, const void *data, size_t size) {
    FILE *file = opened(into, name, "wb");
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static size_t read_values(const char *name, void *data, size_t capacity) {
    FILE *file = opened(model, name, "rb");
    const size_t size = fread(data, 1, capacity, file);
    fclose(file);
    return size;
}

/* places[count]: 0 ... count - 1, shuffled unless order is 0. */
static void make_order(size_t *places, size_t count) {
    uint64_t random = order;
    for (size_t i = 0; i < count; i++)
        places[i] = i;
    for (size_t i = count; order != 0 && i > 1; i--) {
        const size_t other = draw(&random, i), place = places[i - 1];
        places[i - 1] = places[other];
        places[other] = place;
    }
}

static void make_frames(const toliman_sim *sim, double *frames) {
    double *image = new_image(kPixels);
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, kSide));
    keep("image.f64", image, kPixels * sizeof *image);
    free(image);
    size_t places[FRAMES];
    make_order(places, FRAMES);
    double times[FRAMES], displacements[FRAMES];
    assert_ok(toliman_sim_get_series(sim, 0, FRAMES, times, displacements));
    if (order == 0)
        assert_ok(toliman_sim_frame(sim, NULL, 5, 0, FRAMES, frames));
    for (size_t i = 0; order != 0 && i < FRAMES; i++)
        assert_ok(toliman_sim_frame(sim, &(double){displacements[places[i]]}, 5, (int64_t)places[i], 1,
                                    frames + places[i] * kPixels));
    keep("frames.f64", frames, sizeof *frames * FRAMES * kPixels);
    if (strcmp(model, "-") != 0)
        read_values("frames.f64", frames, sizeof *frames * FRAMES * kPixels);
}

static toliman_status give(size_t first, size_t count, double *counts, void *frames) {
    memcpy(counts, (const double *)frames + first * kPixels, count * kPixels * sizeof *counts);
    return TOLIMAN_OK;
}

static void keep_weights(const toliman_cae *cae, const char *name) {
    size_t size;
    assert_ok(toliman_cae_save(cae, NULL, bytes, sizeof bytes, &size));
    keep(name, bytes, size);
}

static void train(const toliman_sim *sim, double *frames) {
    toliman_cae *cae = make_cae(sim, 1, 10, NULL);
    keep_weights(cae, "tied.tlmw");
    toliman_cae_destroy(cae);
    toliman_cae_options options = TOLIMAN_CAE_OPTIONS_INIT;
    toliman_cae_train_options how = {.struct_size = sizeof how, .steps = 10};
    options.layout = TOLIMAN_CAE_LAYOUT_CORE;
    assert_ok(toliman_cae_create(sim, 1, &options, &cae));
    assert_ok(toliman_cae_train(cae, &how, NULL));
    keep_weights(cae, "core.tlmw");
    toliman_cae_destroy(cae);
    options.layout = TOLIMAN_CAE_LAYOUT_PAPER;
    assert_ok(toliman_cae_create(sim, 1, &options, &cae));
    how.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
    how.steps = 1;
    how.frames = give;
    how.frames_data = frames;
    how.frame_count = FRAMES;
    how.batch = 4;
    how.threads = workers;
    assert_ok(toliman_cae_train(cae, &how, NULL));
    keep_weights(cae, "unsupervised.tlmw");
    toliman_cae_destroy(cae);
}

static void estimate(const toliman_sim *sim, const double *frames) {
    toliman_cae *cae = NULL;
    double values[FRAMES];
    const char *const blobs[][2] = {
        {"tied.tlmw", "latents.f64"}, {"core.tlmw", "core_latents.f64"}, {"unsupervised.tlmw", "paper_latents.f64"}};
    if (strcmp(model, "-") == 0)
        model = into;
    for (int blob = 0; blob < 3; blob++) {
        const toliman_load_options how = {.struct_size = sizeof how, .threads = workers};
        assert_ok(toliman_cae_load(bytes, read_values(blobs[blob][0], bytes, sizeof bytes), &how, &cae));
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frames), FRAMES, values, NULL));
        keep(blobs[blob][1], values, sizeof values);
        toliman_cae_destroy(cae);
    }
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    for (int i = 0; i < FRAMES; i++)
        assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frames + (size_t)i * kPixels), 1, &values[i], NULL));
    keep("template.f64", values, sizeof values);
    toliman_linear_destroy(linear);
}

static void decompose(const toliman_sim *sim, const double *frames) {
    toliman_components *components = NULL;
    double series[FRAMES];
    assert_ok(toliman_components_create(sim, NULL, &components));
    for (int i = 0; i < FRAMES; i++)
        assert_ok(toliman_components_push(components, PLAIN_IMAGE(frames + (size_t)i * kPixels), 1));
    toliman_components_train_options options = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    options.threads = workers;
    for (options.method = TOLIMAN_COMPONENTS_PCA; options.method <= TOLIMAN_COMPONENTS_DICTIONARY; options.method++) {
        assert_ok(toliman_components_train(components, &options, NULL));
        assert_ok(toliman_components_get_series(components, 0, series, NULL));
        keep(options.method == TOLIMAN_COMPONENTS_PCA ? "pca.f64" : "dictionary.f64", series, sizeof series);
    }
    toliman_components_destroy(components);
}

static toliman_period *saved_and_loaded(toliman_period *period) {
    size_t size;
    toliman_period *again = NULL;
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    assert_ok(toliman_period_load(bytes, size, NULL, &again));
    toliman_period_destroy(period);
    return again;
}

static void search_with_rows(const double *t, const double *y, const double *sigma, const size_t *places) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.trend = 3;
    options.trend_end = SAMPLES + 1;
    options.columns = 1;
    options.prior_precision[4] = 1e-3;
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(1e-4, 0.0005, GRID, &options, &period));
    uint64_t random = order;
    for (int i = 0; i < SAMPLES; i++) {
        const size_t at = places[i];
        const toliman_period_sample sample = {sizeof sample, 0, t[at], 0, 0, y[at], sigma[at]};
        const double row = (double)(mixed((uint64_t)at + 11) % 1000) / 1000;
        assert_ok(toliman_period_push_samples(period, &sample, &row, 1));
        if (order != 0 && draw(&random, SAMPLES / 8) == 0)
            period = saved_and_loaded(period);
    }
    size_t size;
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    keep("rows.tlmp", bytes, size);
    double power[GRID + 10];
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, GRID, power));
    assert_ok(toliman_period_query_coefficients(period, 40, 5, power + GRID, power + GRID + 5));
    keep("rows_power.f64", power, sizeof power);
    toliman_period_destroy(period);
}

static void search(void) {
    static double t[SAMPLES], y[SAMPLES], sigma[SAMPLES], power[FINE];
    static size_t places[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = i + 0.3 * (double)(mixed((uint64_t)i) % 1000) / 1000;
        y[i] = sin(t[i] / 3) + 0.001 * (double)(mixed((uint64_t)i + 7) % 1000);
        sigma[i] = 1 + 0.001 * (double)(mixed((uint64_t)i + 9) % 1000);
    }
    make_order(places, SAMPLES);
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.01, 0.0005, GRID, NULL, &period));
    uint64_t random = order;
    for (int i = 0; i < SAMPLES; i++) {
        const size_t at = places[i];
        assert_ok(toliman_period_push(period, t[at], y[at], sigma[at]));
        if (order != 0 && draw(&random, SAMPLES / 8) == 0)
            period = saved_and_loaded(period);
    }
    size_t size;
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    keep("sums.tlmp", bytes, size);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, GRID, power));
    keep("power.f64", power, GRID * sizeof *power);
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_peak(period, &peak));
    const double found[] = {peak.frequency, peak.period, peak.power, peak.log10_residual, peak.fwhm, peak.log10_fap};
    keep("peak.f64", found, sizeof found);
    double lowest[4];
    toliman_period_bootstrap_options trials = TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT;
    trials.threads = workers;
    assert_ok(toliman_period_query_bootstrap(period, t, y, sigma, SAMPLES, &trials, 4, lowest));
    keep("bootstrap.f64", lowest, sizeof lowest);
    toliman_period_destroy(period);
    search_with_rows(t, y, sigma, places);
    toliman_period_batch_options options = TOLIMAN_PERIOD_BATCH_OPTIONS_INIT;
    options.threads = workers;
    assert_ok(toliman_period_batch(0.01, 2e-5, FINE, t, y, sigma, SAMPLES, &options, power));
    keep("batch.f64", power, sizeof power);
}

static void follow(void) {
    char folder[256];
    make_folder(folder, sizeof folder);
    toliman_track_options options = small_options(folder);
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    options.threads = workers;
    size_t places[TRACKED];
    make_order(places, TRACKED);
    toliman_track *track = make_track(&options);
    uint64_t random = order;
    for (int i = 0; i < TRACKED; i++) {
        push_number(track, (int64_t)places[i] + 1);
        if (order != 0 && draw(&random, TRACKED / 6) == 0) {
            assert_ok(draw(&random, 2) ? toliman_track_save(track) : toliman_track_commit(track));
            toliman_track_destroy(track);
            track = make_track(&options);
        }
    }
    size_t size;
    assert_ok(toliman_period_save(period_of(track), bytes, sizeof bytes, &size));
    keep("tracked.tlmp", bytes, size);
    toliman_track_destroy(track);
    remove_folder(folder);
}

int main(int count, char **arguments) {
    assert_int_equal(count, 6);
    into = arguments[1];
    model = arguments[2];
    workers = (uint32_t)atoi(arguments[4]);
    order = (uint64_t)atoi(arguments[5]);
    if (!shim_choose_isa(atoi(arguments[3])))
        return 77;
    toliman_sim *sim = make_sim_on_threads(kSide, kSide, 0, "\"shift_x\"", workers);
    double *frames = new_image((size_t)FRAMES * kPixels);
    make_frames(sim, frames);
    train(sim, frames);
    estimate(sim, frames);
    decompose(sim, frames);
    toliman_sim_destroy(sim);
    free(frames);
    search();
    follow();
    return 0;
}
