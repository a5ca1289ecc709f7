/* Measures many frames in calls from C: the network of examples/scenes/chapter.json and the fit of sky.json on all
 * processors, and prints one JSON object per line. python.py runs this program, makes the same calls from Python, and
 * prints the table. Times are medians of wall time of REPEATS calls for all frames. Usage: bench_frames FRAMES */
#include <stdio.h>
#include <stdlib.h>

#include <toliman/cae.h>
#include <toliman/fit.h>

#include "assert_close.h"
#include "images.h"
#include "timing.h"

enum { REPEATS = 5 };

static double wall_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static toliman_sim *sim_of_file(const char *path) {
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_file(path, NULL, &sim));
    return sim;
}

static double *frames_of(const toliman_sim *sim, int count) {
    double *const frames = malloc((size_t)count * 256 * 256 * sizeof *frames);
    assert_non_null(frames);
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, (size_t)count, frames));
    return frames;
}

static void report(const char *part, double *times, int frames, double last) {
    const timing of = timing_of(times, REPEATS);
    printf("{\"part\": \"%s\", \"seconds\": %.9g, \"spread\": %.3g, \"frames\": %d, \"last\": %.17g}\n", part,
           of.median, of.spread, frames, last);
}

static void measure_network(int count) {
    toliman_sim *const sim = sim_of_file("examples/scenes/chapter.json");
    toliman_cae *cae = NULL;
    assert_ok(toliman_cae_create(sim, 1, NULL, &cae));
    double *const frames = frames_of(sim, count), *const latents = calloc((size_t)count, sizeof *latents);
    double times[REPEATS];
    for (int i = 0; i < REPEATS; i++) {
        const double start = wall_s();
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frames), (size_t)count, latents, NULL));
        times[i] = wall_s() - start;
    }
    report("network", times, count, latents[count - 1]);
    free(frames);
    free(latents);
    toliman_cae_destroy(cae);
    toliman_sim_destroy(sim);
}

static void measure_fit(int count) {
    toliman_sim *const sim = sim_of_file("examples/scenes/sky.json");
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    double *const frames = frames_of(sim, count);
    toliman_fit_prediction *const predictions = calloc((size_t)count, sizeof *predictions);
    toliman_fit_result *const results = calloc((size_t)count, sizeof *results);
    double times[REPEATS];
    for (int k = 0; k < count; k++)
        assert_ok(toliman_sim_get_series(sim, k, 1, &predictions[k].time_days, NULL));
    for (int i = 0; i < REPEATS; i++) {
        predictions[0].struct_size = sizeof *predictions;
        results[0].struct_size = sizeof *results;
        const double start = wall_s();
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames), (size_t)count, predictions, results, NULL, NULL));
        times[i] = wall_s() - start;
    }
    report("fit", times, count, results[count - 1].separation_px);
    free(frames);
    free(predictions);
    free(results);
    toliman_fit_destroy(fit);
    toliman_sim_destroy(sim);
}

int main(int argc, char **argv) {
    const int count = argc > 1 ? atoi(argv[1]) : 1000;
    measure_network(count);
    measure_fit(count);
    return 0;
}
