/* Measures the sum of frames of 128 x 128 px of examples/scenes/mission.json at 100 per second, on one core, and prints
 * one JSON object per line: frames from memory that jitter by 0.3 px rms, 1 % of them with cosmic rays; frames that do
 * not move; and the bound, reading the frames from memory. Times are medians of processor time over passes.
 * coadd.py runs this program. Usage: bench_coadd FRAMES */
#include <toliman/coadd.h>

#include "shipped_scene.h"
#include "timing.h"
#include "uniform.h"

enum { SIDE = 128, PIXELS = SIDE * SIDE, PASSES = 9 };

static char *mission(void) {
    return replaced_again(replaced_again(shipped_scene("mission"), "\"exposure_s\": 43200", "\"exposure_s\": 0.005"),
                          "\"shape\": [256, 256]", "\"bit_depth\": 12, \"bias_dn\": 100, \"shape\": [128, 128]");
}

static void draw(const toliman_fit *fit, double jitter, int rays, uint64_t *state, uint16_t *counts) {
    static double image[PIXELS];
    const toliman_fit_prediction place = {
        .struct_size = sizeof place, .x_px = jitter * noise(state), .y_px = jitter * noise(state)};
    assert_ok(toliman_fit_predict(fit, &place, image, SIDE, NULL, NULL));
    for (int p = 0; p < PIXELS; p++)
        counts[p] = (uint16_t)fmax(0, rint(image[p] + sqrt(fmax(0, image[p] - 100) + 1.7) * noise(state)));
    for (int i = 0; i < rays; i++)
        counts[(int)(PIXELS * uniform(state))] = 1500;
}

static uint16_t *frames_of(const toliman_fit *fit, double jitter, int count) {
    uint16_t *const frames = malloc((size_t)count * PIXELS * sizeof *frames);
    uint64_t state = 1;
    assert_non_null(frames);
    for (int k = 0; k < count; k++)
        draw(fit, jitter, k % 100 == 7 ? 3 : 0, &state, frames + (size_t)k * PIXELS);
    return frames;
}

static void measure(const char *what, toliman_coadd *coadd, const uint16_t *frames, int count) {
    double times[PASSES], reads[PASSES];
    int added = 0;
    uint64_t sum = 0;
    for (int pass = 0; pass < PASSES; pass++) {
        double start = processor_s();
        for (int k = 0; k < count; k++) {
            const toliman_frame frame = {.struct_size = sizeof frame,
                                         .pixel = TOLIMAN_PIXEL_U16,
                                         .session = "bench",
                                         .roi = "centre",
                                         .camera_ns = k * INT64_C(10000000),
                                         .pixels = frames + (size_t)k * PIXELS,
                                         .rows = SIDE,
                                         .cols = SIDE,
                                         .exposure_s = 0.005};
            toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
            assert_ok(toliman_coadd_add(coadd, &frame, &outcome));
            added += outcome.verdict == TOLIMAN_COADD_VERDICT_ADDED;
        }
        times[pass] = (processor_s() - start) / count;
        start = processor_s();
        uint64_t words;
        for (size_t i = 0; i < (size_t)count * PIXELS; i += 4) {
            memcpy(&words, frames + i, sizeof words);
            sum += words;
        }
        reads[pass] = (processor_s() - start) / count;
    }
    const timing spent = timing_of(times, PASSES), read = timing_of(reads, PASSES);
    printf(
        "{\"part\": \"coadd\", \"what\": \"%s\", \"frames\": %d, \"added\": %d, \"seconds\": %.5g, \"spread\": %.2g, "
        "\"roofline\": %.5g, \"sum\": %d}\n",
        what, count, added / PASSES, spent.median, spent.spread, read.median, (int)(sum & 1));
    fflush(stdout);
}

int main(int argc, char **argv) {
    const int count = argc > 1 ? atoi(argv[1]) : 2000;
    toliman_sim *const sim = one_core(mission(), 0);
    const toliman_fit_options fit_options = {.struct_size = sizeof fit_options, .capture_px = 6};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &fit_options, &fit));
    const toliman_coadd_options options = {.struct_size = sizeof options, .threads = 1};
    toliman_coadd *coadd = NULL;
    const double start = processor_s();
    assert_ok(toliman_coadd_create(fit, NULL, &options, &coadd));
    printf("{\"part\": \"create\", \"seconds\": %.4g}\n", processor_s() - start);
    static const struct {
        const char *what;
        double jitter;
    } cases[] = {{"jitter", 0.3}, {"still", 0}};
    for (size_t c = 0; c < 2; c++) {
        uint16_t *const frames = frames_of(fit, cases[c].jitter, count);
        measure(cases[c].what, coadd, frames, count);
        free(frames);
    }
    toliman_coadd_destroy(coadd), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}
