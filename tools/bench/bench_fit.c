/* Measures the fit of frames of examples/scenes/sky.json on one core and prints one JSON object per line. fit.py runs
 * this program and prints the table. Times are medians of processor time over frames that are spread over the orbit,
 * each with noise of its own; errors are against the true separation, in units of the fit's standard deviation.
 * Usage: bench_fit FRAMES FOLDER; the folder receives the inputs of numpy_fit.py. */
#include <toliman/bank.h>

#include "images.h"
#include "peak.h"
#include "shipped_scene.h"
#include "timing.h"
#include "uniform.h"

enum { SIDE = 256, PIXELS = SIDE * SIDE, MARGIN = 32, WIDE = SIDE + 2 * MARGIN, MOST = 1095, PROPAGATED = 5 };

static const char *const kFree = "focus scale jitter_xx jitter_yy jitter_xy";

/* The scene without errors of pointing and roll, so that a prediction may be exact. */
static char *sky(void) {
    return replaced_again(shipped_scene("sky"), "\"pointing_rms_px\": 0.3, \"roll_rms_deg\": 0.01",
                          "\"pointing_rms_px\": 0");
}

static toliman_fit *fit_of(const toliman_sim *sim, const char *parameters) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = parameters};
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &options, &fit));
    return fit;
}

static toliman_fit_info info_of(const toliman_fit *fit) {
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_get_info(fit, &info));
    return info;
}

static double *new_images(size_t pixels) {
    double *const images = malloc(pixels * sizeof *images);
    assert_non_null(images);
    return images;
}

/* Number of frame i of `count` in the scene's cadence. */
static int64_t number_of(int i, int count) {
    return (int64_t)i * MOST / count;
}

/* The prediction of frame k, with a shift of `off` px rms per axis that the frame does not have. */
static toliman_fit_prediction prediction_of(const toliman_sim *sim, int64_t k, double off) {
    toliman_fit_prediction prediction = {.struct_size = sizeof prediction};
    uint64_t seed = (uint64_t)k;
    assert_ok(toliman_sim_get_series(sim, k, 1, &prediction.time_days, NULL));
    prediction.x_px = off * noise(&seed);
    prediction.y_px = off * noise(&seed);
    return prediction;
}

/* Multiply-adds of the interpolation alone: along y for the samples of each row, then along x for each pixel, of both
 * stars with both slopes; with the jitter also second derivatives, and the planes of the other parameters. */
static double operations_of_image(const toliman_fit_info *info) {
    const double orders = info->parameters > 7 ? 3 : 2, planes = 0.5 * info->images - 1;
    const double samples = info->oversampling * (double)info->cols, pixels = (double)info->cols;
    const double sums = orders * samples + 0.5 * orders * (orders + 1) * pixels + planes * (samples + pixels);
    return 2.0 * (double)info->rows * info->taps * sums;
}

typedef struct {
    const char *what;
    const toliman_fit *fit;
    double off;
    double times[MOST], steps[MOST], square, largest;
    int searched;
} fit_case;

static void fit_frame(fit_case *c, const toliman_sim *sim, const double *counts, int64_t k, int i) {
    const toliman_fit_prediction prediction = prediction_of(sim, k, c->off);
    toliman_fit_result result = {.struct_size = sizeof result};
    const double start = processor_s();
    assert_ok(toliman_fit_frame(c->fit, PLAIN_IMAGE(counts), 1, &prediction, &result, NULL, NULL));
    c->times[i] = processor_s() - start;
    assert_int_equal(result.flags & ~TOLIMAN_FIT_SEARCHED, 0);
    const double pull = fabs(result.displacement_px) / result.separation_sigma_px;
    c->steps[i] = result.iterations;
    c->square += pull * pull;
    c->largest = fmax(c->largest, pull);
    c->searched += result.flags != 0;
}

/* All cases on the same frames. */
static void measure_fits(const toliman_sim *sim, const toliman_fit *fit, const toliman_fit *more, int count) {
    static fit_case cases[] = {{.what = "0.3", .off = 0.3},
                               {.what = "0.03", .off = 0.03},
                               {.what = "exact", .off = 0},
                               {.what = "free", .off = 0.3}};
    double *const counts = new_images(PIXELS);
    const double before = peak_double(peak_widest());
    for (int i = 0; i < count; i++) {
        const int64_t k = number_of(i, count);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, k, 1, counts));
        for (size_t c = 0; c < 4; c++) {
            cases[c].fit = c == 3 ? more : fit;
            fit_frame(&cases[c], sim, counts, k, i);
        }
    }
    const double gflops = fmax(before, peak_double(peak_widest()));
    for (size_t c = 0; c < 4; c++) {
        const toliman_fit_info info = info_of(cases[c].fit);
        const timing spent = timing_of(cases[c].times, (size_t)count);
        const double steps = timing_of(cases[c].steps, (size_t)count).median;
        printf("{\"part\": \"fit\", \"what\": \"%s\", \"parameters\": %lld, \"frames\": %d, \"seconds\": %.5g, "
               "\"spread\": %.2g, \"steps\": %g, \"searched\": %d, \"rms_pull\": %.4g, \"largest_pull\": %.4g, "
               "\"roofline\": %.5g, \"gflops\": %.4g}\n",
               cases[c].what, (long long)info.parameters, count, spent.median, spent.spread, steps, cases[c].searched,
               sqrt(cases[c].square / count), cases[c].largest, steps * 2 * operations_of_image(&info) / gflops * 1e-9,
               gflops);
    }
    fflush(stdout);
    free(counts);
}

/* The time that a network takes beyond the fit, which does not depend on its training, with the predicted separation
 * off by `off` px: from 3e-4 px on it needs a second model image. */
static void measure_bank(const toliman_sim *sim, const toliman_fit *fit, const char *what, double off, int count) {
    const toliman_bank_options options = {
        .struct_size = sizeof options, .last_days = MOST, .spacing_px = 4, .places = 1, .steps = 1};
    toliman_bank *bank = NULL;
    assert_ok(toliman_bank_create(fit, &options, &bank));
    double *const counts = new_images(PIXELS), times[MOST];
    for (int i = 0; i < count; i++) {
        const int64_t k = number_of(i, count);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, k, 1, counts));
        toliman_fit_prediction prediction = prediction_of(sim, k, 0.3);
        double values[7];
        assert_ok(toliman_fit_predict(fit, &prediction, NULL, SIDE, values, NULL));
        prediction.separation_px = values[0] + off;
        prediction.position_angle_deg = values[1];
        toliman_fit_result fitted = {.struct_size = sizeof fitted};
        toliman_bank_result result = {.struct_size = sizeof result};
        const double start = processor_s();
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(counts), 1, &prediction, &fitted, NULL, NULL));
        const double between = processor_s();
        assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(counts), 1, &prediction, &result, &fitted));
        times[i] = (processor_s() - between) - (between - start);
        assert_int_equal(result.flags & TOLIMAN_BANK_NOT_FITTED, 0);
    }
    const timing spent = timing_of(times, (size_t)count);
    printf("{\"part\": \"bank\", \"what\": \"%s\", \"seconds\": %.5g, \"spread\": %.2g}\n", what, spent.median,
           spent.spread);
    fflush(stdout);
    free(counts);
    toliman_bank_destroy(bank);
}

/* The expected frame alone: the time that a prediction takes longer with it than without. */
static timing image_time(const toliman_sim *sim, const toliman_fit *fit, double *image, int count) {
    double times[MOST], covariance[32 * 32];
    for (int i = 0; i < count; i++) {
        const toliman_fit_prediction prediction = prediction_of(sim, number_of(i, count), 0.3);
        const double start = processor_s();
        assert_ok(toliman_fit_predict(fit, &prediction, NULL, SIDE, NULL, covariance));
        const double without = processor_s();
        assert_ok(toliman_fit_predict(fit, &prediction, image, SIDE, NULL, covariance));
        times[i] = (processor_s() - without) - (without - start);
    }
    return timing_of(times, (size_t)count);
}

/* Model images: their time, and their largest difference from frames without noise whose every wavelength is
 * propagated, relative to the peak. */
static void measure_image(const toliman_sim *sim, const toliman_fit *fit, int count) {
    char *const text = replaced_again(sky(), "\"photon\": true, \"read_e\": 1.3", "\"photon\": false, \"read_e\": 0");
    toliman_sim *const exact = one_core(replaced_again(text, "\"accuracy\": 1e-9", "\"accuracy\": 1e-15"), 0);
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_sim_get_plan(exact, &plan));
    assert_true(plan.exact_frames != 0);
    const toliman_fit_info info = info_of(fit);
    double *const image = new_images(PIXELS), *const truth = new_images(PIXELS), worst = 0, peak = 0;
    for (int i = 0; i < PROPAGATED; i++) {
        const int64_t k = number_of(i, PROPAGATED);
        const toliman_fit_prediction prediction = prediction_of(sim, k, 0);
        assert_ok(toliman_sim_frame(exact, &(double){0}, 1, k, 1, truth));
        assert_ok(toliman_fit_predict(fit, &prediction, image, SIDE, NULL, NULL));
        for (int p = 0; p < PIXELS; p++) {
            worst = fmax(worst, fabs(image[p] - truth[p]));
            peak = fmax(peak, truth[p]);
        }
    }
    toliman_sim_destroy(exact);
    const double before = peak_double(peak_widest());
    const timing spent = image_time(sim, fit, image, count);
    const double gflops = fmax(before, peak_double(peak_widest()));
    printf("{\"part\": \"image\", \"seconds\": %.5g, \"spread\": %.2g, \"error\": %.3g, \"compared\": %d, "
           "\"predicted_error\": %.3g, \"taps\": %u, \"oversampling\": %u, \"roofline\": %.5g, \"gflops\": %.4g}\n",
           spent.median, spent.spread, worst / peak, PROPAGATED, info.image_error, info.taps, info.oversampling,
           2 * operations_of_image(&info) / gflops * 1e-9, gflops);
    fflush(stdout);
    free(image);
    free(truth);
}

static FILE *opened(const char *folder, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    return file;
}

static void write_doubles(FILE *file, const double *values, size_t count) {
    assert_int_equal(fwrite(values, sizeof *values, count, file), count);
}

/* Inputs of numpy_fit.py, in float64: images of A and B with a margin; for each frame x and y of the shifts of A and B
 * from these images at which the fit starts, of their places in the images, and the predicted separation; the frames.
 */
static void write_peer_inputs(const toliman_sim *sim, const toliman_fit *fit, int count, const char *folder) {
    toliman_sim *const wide = one_core(replaced_again(sky(), "\"shape\": [256, 256]", "\"shape\": [320, 320]"), 0);
    toliman_sim_offsets at = {.struct_size = sizeof at};
    assert_ok(toliman_sim_get_offsets(wide, &at));
    FILE *const stars = opened(folder, "stars.bin");
    double *const star = new_images(WIDE * WIDE);
    for (int32_t kind = TOLIMAN_SIM_IMAGE_STAR_A; kind <= TOLIMAN_SIM_IMAGE_STAR_B; kind++) {
        assert_ok(toliman_sim_get_image(wide, kind, star, WIDE));
        write_doubles(stars, star, WIDE * WIDE);
    }
    assert_int_equal(fclose(stars), 0);
    free(star);
    toliman_sim_destroy(wide);
    const double distance_a = hypot(at.a_x_px, at.a_y_px),
                 share = distance_a / (distance_a + hypot(at.b_x_px, at.b_y_px));
    FILE *const starts = opened(folder, "starts.bin"), *const frames = opened(folder, "frames.bin");
    double *const counts = new_images(PIXELS);
    for (int i = 0; i < count; i++) {
        const int64_t k = number_of(i, count);
        const toliman_fit_prediction prediction = prediction_of(sim, k, 0.3);
        double values[7];
        assert_ok(toliman_fit_predict(fit, &prediction, NULL, SIDE, values, NULL));
        const double angle = values[1] * M_PI / 180, x = -values[0] * sin(angle), y = values[0] * cos(angle);
        const double start[] = {values[2] - share * x - at.a_x_px,
                                values[3] - share * y - at.a_y_px,
                                values[2] + (1 - share) * x - at.b_x_px,
                                values[3] + (1 - share) * y - at.b_y_px,
                                at.a_x_px,
                                at.a_y_px,
                                at.b_x_px,
                                at.b_y_px,
                                values[0]};
        write_doubles(starts, start, 9);
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, k, 1, counts));
        write_doubles(frames, counts, PIXELS);
    }
    assert_int_equal(fclose(starts), 0);
    assert_int_equal(fclose(frames), 0);
    free(counts);
}

int main(int count, char **arguments) {
    assert_int_equal(count, 3);
    const int frames = atoi(arguments[1]);
    assert_true(frames >= 1 && frames <= MOST);
    toliman_sim *const sim = one_core(sky(), 0);
    const double start = processor_s();
    toliman_fit *const fit = fit_of(sim, NULL);
    printf("{\"part\": \"create\", \"seconds\": %.5g}\n", processor_s() - start);
    toliman_fit *const more = fit_of(sim, kFree);
    write_peer_inputs(sim, fit, frames, arguments[2]);
    measure_fits(sim, fit, more, frames);
    measure_image(sim, fit, frames);
    measure_bank(sim, fit, "near", 0, frames);
    measure_bank(sim, fit, "far", 5e-3, frames);
    toliman_fit_destroy(more);
    toliman_fit_destroy(fit);
    toliman_sim_destroy(sim);
    return 0;
}
