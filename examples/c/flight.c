/* A program as on board: one static binary with its own memory arena, no heap use after the first frame, and no FFT,
 * BLAS or JSON library. Reads frames; prints displacements and the period.
 *
 *     flight WEIGHTS.tlmw FRAMES.bin         frames of 256x256 pixels of 32 bits, one per day
 */
#include <stdio.h>
#include <stdlib.h>

#include <toliman/track.h>

enum { ROWS = 256, COLS = 256, ARENA = 12 << 20 };

/* The arena only grows, except that the last block can be released: all objects are created once. */
static _Alignas(64) unsigned char arena[ARENA];
static size_t used;

static void *allocate(size_t size, size_t alignment, void *unused) {
    (void)unused;
    const size_t at = (used + alignment - 1) / alignment * alignment;
    if (size > ARENA - at)
        return NULL;
    used = at + size;
    return arena + at;
}

static void release(void *memory, size_t size, void *unused) {
    (void)unused;
    if ((unsigned char *)memory + size == arena + used) /* the last block: temporary memory during creation */
        used -= size;
}

/* Counts heap calls: the linker redirects malloc and related functions to these wrappers (-Wl,--wrap). */
static size_t heap_calls;
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_malloc(size_t size) {
    heap_calls++;
    return __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size) {
    heap_calls++;
    return __real_calloc(count, size);
}
void *__wrap_realloc(void *memory, size_t size) {
    heap_calls++;
    return __real_realloc(memory, size);
}
void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    heap_calls++;
    return __real_aligned_alloc(alignment, size);
}

static void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    fprintf(stderr, "%s: %s\n", toliman_constant_name(status), toliman_last_error());
    exit(EXIT_FAILURE);
}

int main(int argc, char **argv) {
    static uint32_t pixels[ROWS * COLS];
    static char text[1 << 12], file[1 << 12];
    FILE *frames = argc == 3 ? fopen(argv[2], "rb") : NULL;
    if (frames == NULL) {
        fprintf(stderr, "usage: flight WEIGHTS.tlmw FRAMES.bin\n");
        return EXIT_FAILURE;
    }
    setvbuf(stdout, text, _IOLBF, sizeof text);
    setvbuf(frames, file, _IOFBF, sizeof file);

    const toliman_allocator allocator = {sizeof allocator, 0, allocate, release, NULL};
    toliman_cae *network = NULL;
    const toliman_load_options in_arena = {.struct_size = sizeof in_arena, .allocator = &allocator};
    check(toliman_cae_load_file(argv[1], &in_arena, &network));
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.allocator = &allocator;
    options.estimator.cae = network;
    options.ledger.capacity = 2000;
    options.grid.f0 = 0.01;
    options.grid.df = 0.001;
    options.grid.nf = 490;
    toliman_track *tracker = NULL;
    const toliman_period *period = NULL;
    check(toliman_track_create(&options, &tracker));
    check(toliman_track_get_period(tracker, &period));

    const size_t before = heap_calls;
    toliman_frame frame = {.struct_size = sizeof frame,
                           .pixel = TOLIMAN_PIXEL_U32,
                           .session = "orbit",
                           .roi = "core",
                           .pixels = pixels,
                           .rows = ROWS,
                           .cols = COLS};
    toliman_track_outcome outcome = TOLIMAN_TRACK_OUTCOME_INIT;
    for (size_t done; fread(pixels, sizeof *pixels, ROWS * COLS, frames) == ROWS * COLS; frame.frame_id++) {
        frame.camera_ns = frame.frame_id * INT64_C(86400000000000);
        check(toliman_track_push(tracker, &frame, 1, &outcome, &done));
        printf("frame %lld %.17g px\n", (long long)frame.frame_id, outcome.value);
    }
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    check(toliman_period_query_peak(period, &peak));
    printf("period %.6g d, log10 FAP %.2f\n", peak.period, peak.log10_fap);
    printf("%zu bytes of the arena, %zu heap calls after the start\n", used, heap_calls - before);
    toliman_track_destroy(tracker);
    toliman_cae_destroy(network);
    fclose(frames);
    return EXIT_SUCCESS;
}
