/* A long run of the tracker, one JSON line per case: frames per second of processor time and of wall time, growth of
 * the memory, bytes requested. Usage: bench_track [template frames] [network frames] [frequencies]; with the third,
 * records are not fsync'ed. Run by make soak and, shorter, by make bench (commands.py).
 * bench_track --folder FOLDER FIRST FRAMES makes a state folder of one frame in 86.4 s, on a grid of 2,000 frequencies,
 * for folders.py. */
/* promises: nothing-leaks-over-a-mission, trackers-allocate-at-creation */
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

#include "asked_memory.h"
#include "cae_scene.h"
#include "own_memory.h"
#include "scene_text.h"
#include "test_folder.h"

#include <toliman/linear.h>
#include <toliman/track.h>

enum { BATCH = 64 };
static int64_t frequencies = 40;
static int32_t sync_mode = TOLIMAN_TRACK_SYNC_GROUP;

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Frames with a few noise realisations of the scene; a counter in the first pixel makes every frame unique. */
typedef struct source {
    uint32_t *pixels; /* [BATCH][side * side] */
    size_t side;
    int64_t interval_ns;
} source;

static source draw_frames(const toliman_sim *sim, size_t side) {
    const size_t size = side * side;
    source out = {malloc(BATCH * size * sizeof *out.pixels), side, 100000000};
    double *counts = new_image(size);
    for (size_t f = 0; f < BATCH; f++) {
        assert_ok(toliman_sim_frame(sim, &(double){0}, 5, (int64_t)f, 1, counts));
        for (size_t i = 0; i < size; i++)
            out.pixels[f * size + i] = (uint32_t)fmax(1, counts[i]);
    }
    free(counts);
    return out;
}

static void push_batch(toliman_track *track, const source *from, int64_t first, size_t count) {
    const size_t size = from->side * from->side;
    toliman_frame frames[BATCH];
    toliman_track_outcome outcomes[BATCH] = {{.struct_size = sizeof *outcomes}};
    for (size_t i = 0; i < count; i++) {
        const int64_t id = first + (int64_t)i;
        uint32_t *pixels = from->pixels + i * size;
        pixels[0] = 1 + (uint32_t)id % 4000;
        frames[i] = (toliman_frame){.struct_size = sizeof frames[i],
                                    .pixel = TOLIMAN_PIXEL_U32,
                                    .session = "soak",
                                    .roi = "core",
                                    .frame_id = id,
                                    .camera_ns = id * from->interval_ns,
                                    .pixels = pixels,
                                    .rows = (int64_t)from->side,
                                    .cols = (int64_t)from->side};
    }
    size_t done;
    assert_ok(toliman_track_push(track, frames, count, outcomes, &done));
}

static void soak(const char *name, toliman_track_options options, const source *from, int64_t frames) {
    char folder[256];
    make_folder(folder, sizeof folder);
    options.folder = folder;
    options.ledger.capacity = frames;
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.grid.f0 = 1;
    options.grid.df = 1;
    options.grid.nf = frequencies;
    toliman_track *track = NULL;
    assert_ok(toliman_track_create(&options, &track));
    push_batch(track, from, 0, BATCH);
    const long memory = own_memory();
    const double wall = seconds(CLOCK_MONOTONIC);
    const double all = seconds(CLOCK_PROCESS_CPUTIME_ID), caller = seconds(CLOCK_THREAD_CPUTIME_ID);
    asked = 0;
    for (int64_t id = BATCH; id < frames; id += BATCH)
        push_batch(track, from, id, frames - id < BATCH ? (size_t)(frames - id) : BATCH);
    const size_t bytes = asked;
    assert_ok(toliman_track_commit(track));
    const double rate = (double)(frames - BATCH), work = seconds(CLOCK_PROCESS_CPUTIME_ID) - all;
    toliman_track_info info = {.struct_size = sizeof info};
    assert_ok(toliman_track_get_info(track, &info));
    assert_int_equal(info.accepted + info.outlier, frames);
    printf("{\"case\": \"%s\", \"frames\": %lld, \"threads\": %u, \"frames_per_cpu_s\": %.0f, "
           "\"frames_per_caller_cpu_s\": %.0f, \"frames_per_wall_s\": %.0f, \"growth_kib\": %ld, "
           "\"asked_bytes\": %zu}\n",
           name, (long long)frames, options.threads, rate / work, rate / (seconds(CLOCK_THREAD_CPUTIME_ID) - caller),
           rate / (seconds(CLOCK_MONOTONIC) - wall), own_memory() - memory, bytes);
    fflush(stdout);
    toliman_track_destroy(track);
    remove_folder(folder);
}

static toliman_track_options default_options(void) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.ledger.sync = sync_mode;
    return options;
}

static toliman_linear *make_template(source *frames) {
    toliman_sim *small = NULL;
    toliman_linear *linear = NULL;
    assert_ok(toliman_sim_create_json(kBinaryScene, strlen(kBinaryScene), NULL, NULL, &small));
    assert_ok(toliman_linear_create(small, NULL, &linear));
    *frames = draw_frames(small, 64);
    toliman_sim_destroy(small);
    return linear;
}

static void make_state(const char *folder, int64_t first, int64_t count) {
    source frames;
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.estimator.linear = make_template(&frames);
    options.folder = folder;
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.frames.exposure_s = 0.05;
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    options.ledger.capacity = count;
    options.grid.f0 = 0.001;
    options.grid.df = 0.0005;
    options.grid.nf = 2000;
    frames.interval_ns = 86400000000;
    toliman_track *track = NULL;
    assert_ok(toliman_track_create(&options, &track));
    for (int64_t done = 0; done < count; done += BATCH)
        push_batch(track, &frames, first + done, count - done < BATCH ? (size_t)(count - done) : BATCH);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    free(frames.pixels);
}

int main(int count, char **arguments) {
    if (count == 5 && strcmp(arguments[1], "--folder") == 0) {
        make_state(arguments[2], atoll(arguments[3]), atoll(arguments[4]));
        return 0;
    }
    const int64_t many = count > 1 ? atoll(arguments[1]) : 1000000, few = count > 2 ? atoll(arguments[2]) : 4000;
    if (count > 3) {
        frequencies = atoll(arguments[3]);
        sync_mode = TOLIMAN_TRACK_SYNC_NONE;
    }
    source frames;
    toliman_track_options options = default_options();
    toliman_linear *linear = make_template(&frames);
    options.estimator.linear = linear;
    soak("template 64x64", options, &frames, many);
    free(frames.pixels);
    toliman_linear_destroy(linear);

    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_cae *cae = make_cae(sim, 1, 100, NULL);
    frames = draw_frames(sim, kSide);
    options = default_options();
    options.estimator.cae = cae;
    double *counts = new_image(kPixels);
    for (size_t i = 0; i < kPixels; i++)
        counts[i] = frames.pixels[i];
    const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
    double latent;
    for (int64_t i = 0; i < few; i++)
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(counts), 1, &latent, NULL));
    printf("{\"case\": \"toliman_cae_encode alone\", \"frames_per_cpu_s\": %.0f}\n",
           (double)few / (seconds(CLOCK_PROCESS_CPUTIME_ID) - start));
    for (options.threads = 1; options.threads <= 2; options.threads++)
        soak("network 256x256", options, &frames, few);
    free(counts);
    free(frames.pixels);
    toliman_cae_destroy(cae);
    toliman_sim_destroy(sim);
    return 0;
}
