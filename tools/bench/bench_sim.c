/* Measures the simulator on one core and prints one JSON object per line. sim.py runs this program and prints the
 * tables. Times are medians of processor time; errors are against sums in long double at some pixels. */
#include <stdio.h>
#include <sys/resource.h>

#include <toliman/sim_derivative.h>

#include "long_double_sim.h"
#include "peak.h"
#include "shipped_scene.h"
#include "timing.h"

enum { POINTS = 14, REPEATS = 5, BATCH = 32 };

static char *chapter(void) {
    return shipped_scene("chapter");
}

/* The text with "key": old replaced by "key": value. */
static char *with_number(char *text, const char *key, const char *old, double value) {
    char from[80], to[80];
    snprintf(from, sizeof from, "\"%s\": %s", key, old);
    snprintf(to, sizeof to, "\"%s\": %.17g", key, value);
    return replaced_again(text, from, to);
}

static toliman_sim_plan_info plan_of(const toliman_sim *sim) {
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_sim_get_plan(sim, &plan));
    return plan;
}

/* One broadband image of the moving star. */
static timing image_time(const toliman_sim *sim, int repeats) {
    double times[REPEATS];
    double *const image = doubles((size_t)(sim_info_of(sim).rows * sim_info_of(sim).cols));
    for (int i = 0; i < repeats; i++) {
        const double start = processor_s();
        assert_ok(toliman_sim_propagate(sim, 1e-3 * i, image, (size_t)sim_info_of(sim).cols));
        times[i] = processor_s() - start;
    }
    free(image);
    return timing_of(times, (size_t)repeats);
}

/* Hardware lower bound in seconds: the transforms alone at the peak rate of float64 multiply-adds. Each wavelength
 * needs two products; a fifth of the first one is outside the round pupil. */
static double roofline_s(const toliman_sim *sim, double gflops) {
    const toliman_sim_plan_info plan = plan_of(sim);
    const double n = (double)plan.pupil_samples, cols = 256, rows = 256;
    return plan.wavelengths * n * cols * (1.6 * n + 2 * rows) / gflops * 1e-9;
}

/* The pixels compared, all columns with all rows: the cores of both stars, and points across the frame including its
 * corners. */
typedef struct {
    int column[POINTS], row[POINTS];
    double u[POINTS], v[POINTS];
} points;

static void put_point(points *p, int i, int column, int row) {
    p->column[i] = column;
    p->row[i] = row;
    p->u[i] = column - 127.5;
    p->v[i] = row - 127.5;
}

static points points_of(const toliman_sim *sim) {
    double offset[4];
    get_offsets(sim, offset);
    points p;
    for (int i = 0; i < 6; i++)
        put_point(&p, i, (int)(127.5 + offset[i / 3 * 2]) + i % 3, (int)(127.5 + offset[i / 3 * 2 + 1]) + i % 3);
    for (int i = 6; i < POINTS; i++)
        put_point(&p, i, i < 13 ? 36 * (i - 6) : 255, i < 13 ? 36 * (i - 6) : 255);
    return p;
}

/* Replaces a point of the frame by the pixel where the two simulators differ most. */
static void put_point_of_largest_difference(const toliman_sim *a, const toliman_sim *b, points *p) {
    double *const one = image_of(a, TOLIMAN_SIM_IMAGE_BOTH), *const other = image_of(b, TOLIMAN_SIM_IMAGE_BOTH);
    int worst = 0;
    for (int i = 0; i < 256 * 256; i++)
        if (fabs(one[i] - other[i]) > fabs(one[worst] - other[worst]))
            worst = i;
    put_point(p, POINTS - 2, worst % 256, worst / 256);
    free(one);
    free(other);
}

/* The reference image with star A displaced by d px. */
static void displaced(const reference *r, const points *p, long double d, long double *sum) {
    reference moved = *r;
    const long double x = r->offset[2] - r->offset[0], y = r->offset[3] - r->offset[1], length = sqrtl(x * x + y * y);
    moved.offset[0] -= d * x / length;
    moved.offset[1] -= d * y / length;
    memset(sum, 0, POINTS * POINTS * sizeof *sum);
    add_stars(&moved, p->u, POINTS, p->v, POINTS, sum);
}

/* Error of the image at the points relative to the peak, and error of the displacement fitted with the Taylor
 * expansion. */
static void errors_of(const toliman_sim *sim, const points *p, double d, const long double *still,
                      const long double *moved, double *error, double *shift) {
    double *const both = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH), *const there = doubles(256 * 256);
    assert_ok(toliman_sim_expect(sim, d, there, 256));
    long double worst = 0, product = 0, norm = 0;
    for (int i = 0; i < POINTS * POINTS; i++) {
        const int at = p->row[i / POINTS] * 256 + p->column[i % POINTS];
        const long double change = (long double)there[at] - both[at];
        worst = fmaxl(worst, fabsl(both[at] - still[i]));
        product += change * (moved[i] - still[i]);
        norm += change * change;
    }
    *error = (double)(worst / sim_info_of(sim).peak_photons);
    *shift = (double)fabsl(d * (product / norm - 1));
    free(both);
    free(there);
}

/* Engine x pupil samples x wavelengths x expansion order, for the chapter's scene. */
static void measure_choices(void) {
    const double far[] = {1e-6, 1e-2}, accuracies[] = {1e-3, 1e-6, 1e-9, 1e-12, 1e-15};
    const int samples[] = {128, 192, 256};
    for (int k = 0; k < 2; k++) {
        toliman_sim *const exact = one_core(with_number(chapter(), "accuracy", "1e-9", 1e-15), 0);
        const points p = points_of(exact);
        reference r = reference_of(exact, 0.125L, 0.20);
        static long double still[POINTS * POINTS], moved[POINTS * POINTS];
        displaced(&r, &p, 0, still);
        displaced(&r, &p, far[k], moved);
        release(&r);
        toliman_sim_destroy(exact);
        for (int i = 0; i < 16; i++) {
            const int fft = i == 15;
            char *text = with_number(chapter(), "pupil_samples", "256", fft ? 256 : samples[i / 5]);
            text = with_number(text, "accuracy", "1e-9", fft ? 1e-9 : accuracies[i % 5]);
            text = with_number(text, "amplitude_px", "1e-6", far[k]);
            toliman_sim *const sim = one_core(text, fft ? TOLIMAN_SIM_ENGINE_PADDED_FFT : 0);
            const toliman_sim_plan_info plan = plan_of(sim);
            double error, shift;
            errors_of(sim, &p, far[k], still, moved, &error, &shift);
            printf("{\"part\": \"choices\", \"engine\": \"%s\", \"samples\": %lld, \"wavelengths\": %d, \"order\": %d, "
                   "\"displacement_px\": %g, \"seconds\": %.5g, \"error\": %.3g, \"compared\": %d, "
                   "\"shift_error_px\": %.3g}\n",
                   fft ? "fft" : "mdft", (long long)plan.pupil_samples, plan.wavelengths, plan.order, far[k],
                   image_time(sim, fft ? 1 : REPEATS).median, error, POINTS * POINTS, shift);
            fflush(stdout);
            toliman_sim_destroy(sim);
        }
    }
}

/* One image in 101 wavelengths 1 nm apart, for both geometries: with spectral nodes and with every wavelength. */
static void measure_image(const char *name, double pixel_arcsec, double min_nm) {
    char *text = with_number(chapter(), "pixel_scale_arcsec", "0.20", pixel_arcsec);
    text = with_number(text, "min_nm", "550", min_nm);
    text = with_number(text, "max_nm", "600", min_nm + 100);
    char *const all = with_number(strcpy(malloc(strlen(text) + 1), text), "accuracy", "1e-9", 1e-15);
    const double start = processor_s();
    toliman_sim *const nodes = one_core(text, 0);
    const double create = processor_s() - start;
    toliman_sim *const exact = one_core(all, 0);
    points p = points_of(exact);
    put_point_of_largest_difference(nodes, exact, &p);
    reference r = reference_of(exact, 0.125L, (long double)pixel_arcsec);
    static long double still[POINTS * POINTS];
    displaced(&r, &p, 0, still);
    release(&r);
    double node_error, error, shift;
    errors_of(nodes, &p, 1e-6, still, still, &node_error, &shift);
    errors_of(exact, &p, 1e-6, still, still, &error, &shift);
    const double before = peak_double(peak_widest());
    const timing few = image_time(nodes, REPEATS), many = image_time(exact, REPEATS);
    const double gflops = fmax(before, peak_double(peak_widest()));
    printf("{\"part\": \"image\", \"geometry\": \"%s\", \"pixel_arcsec\": %g, \"min_nm\": %g, \"nodes\": %d, "
           "\"node_seconds\": %.5g, \"node_spread\": %.2g, \"node_roofline\": %.5g, \"node_error\": %.3g, "
           "\"wavelengths\": %d, \"seconds\": %.5g, \"spread\": %.2g, \"roofline\": %.5g, \"error\": %.3g, "
           "\"compared\": %d, \"create_s\": %.5g, \"gflops\": %.4g}\n",
           name, pixel_arcsec, min_nm, plan_of(nodes).wavelengths, few.median, few.spread, roofline_s(nodes, gflops),
           node_error, plan_of(exact).wavelengths, many.median, many.spread, roofline_s(exact, gflops), error,
           POINTS * POINTS, create, gflops);
    fflush(stdout);
    toliman_sim_destroy(nodes);
    toliman_sim_destroy(exact);
}

static double frames_s(const toliman_sim *sim, int64_t count) {
    const toliman_sim_info info = sim_info_of(sim);
    double *const images = doubles((size_t)(BATCH * info.rows * info.cols));
    const double zero[BATCH] = {0}, start = processor_s();
    for (int64_t first = 0; first < count; first += BATCH) {
        const size_t batch = (size_t)(count - first < BATCH ? count - first : BATCH);
        assert_ok(toliman_sim_frame(sim, zero, 1, first, batch, images));
    }
    const double spent = processor_s() - start;
    free(images);
    return spent;
}

static long peak_memory_kib(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

/* Noisy frames: time must grow linearly and memory must stay constant. */
static void measure_frames(void) {
    toliman_sim *const sim = one_core(chapter(), 0);
    double times[REPEATS];
    for (int i = 0; i < REPEATS; i++)
        times[i] = frames_s(sim, 1095);
    const timing few = timing_of(times, REPEATS);
    const long before = peak_memory_kib();
    const double many = frames_s(sim, 10000);
    printf("{\"part\": \"frames\", \"seconds_1095\": %.5g, \"spread_1095\": %.2g, \"seconds_10000\": %.5g, "
           "\"growth_kib\": %ld, \"ns_per_pixel\": %.3g}\n",
           few.median, few.spread, many, peak_memory_kib() - before, many / 10000 / 65536 * 1e9);
    fflush(stdout);
    toliman_sim_destroy(sim);
}

/* Cost of a stage: set-up, including the images of the first frame, and further frames of the chapter's scene with one
 * setting changed. */
static void measure_stage(const char *what, char *text) {
    const double start = processor_s();
    toliman_sim *const sim = one_core(text, 0);
    frames_s(sim, 1);
    const double setup = processor_s() - start;
    printf("{\"part\": \"stage\", \"what\": \"%s\", \"setup_s\": %.4g, \"frame_ms\": %.4g}\n", what, setup,
           frames_s(sim, 300) / 300 * 1e3);
    fflush(stdout);
    toliman_sim_destroy(sim);
}

static void measure_stages(void) {
    measure_stage("the chapter's scene", chapter());
    measure_stage("every wavelength", with_number(chapter(), "accuracy", "1e-9", 1e-15));
    measure_stage("accuracy 1e-6", with_number(chapter(), "accuracy", "1e-9", 1e-6));
    measure_stage("one wavelength", replaced_again(chapter(), "{\"min_nm\": 550, \"max_nm\": 600, \"step_nm\": 1}",
                                                   "{\"wavelength_nm\": 575}"));
    measure_stage("128 pupil samples", with_number(chapter(), "pupil_samples", "256", 128));
    measure_stage("signal of 0.01 px", with_number(chapter(), "amplitude_px", "1e-6", 1e-2));
    measure_stage("integrated pixels", replaced_again(chapter(), "\"point\"", "\"integrated\""));
    measure_stage("no photon noise", replaced_again(chapter(), "\"photon\": true", "\"photon\": false"));
    measure_stage(
        "gain, bias and 32 bits",
        replaced_again(chapter(), "\"point\"", "\"point\", \"gain_e_per_dn\": 2, \"bias_dn\": 100, \"bit_depth\": 32"));
    measure_stage("pointing 1e-3 px and flux 1e-4",
                  replaced_again(chapter(), "\"noise\"",
                                 "\"systematics\": {\"pointing_rms_px\": 1e-3, \"flux_rms\": 1e-4}, \"noise\""));
    measure_stage("read noise", replaced_again(chapter(), "\"photon\": true", "\"photon\": true, \"read_e\": 1.3"));
}

/* Derivative images of both stars of the chapter's scene, one call for each, and the gradient by the pupil. */
static void measure_derivative(const toliman_sim *sim, const char *what, const char *const *names, int count) {
    double *const image = doubles(256 * 256);
    const double start = processor_s();
    for (int i = 0; i < count; i++)
        assert_ok(toliman_sim_get_derivative(sim, names[i], image, 256));
    printf("{\"part\": \"derivative\", \"what\": \"%s\", \"images\": %d, \"seconds\": %.5g}\n", what, count,
           (processor_s() - start) / count);
    fflush(stdout);
    free(image);
}

static void measure_derivatives(void) {
    static const char *const zernikes[] = {"zernike_5", "zernike_6",  "zernike_7",  "zernike_8",
                                           "zernike_9", "zernike_10", "zernike_11", "zernike_12"};
    static const char *const jitter[] = {"jitter_xx", "jitter_yy", "jitter_xy"};
    static const char *const spectra[] = {"temperature_a", "spectrum_a_1", "spectrum_a_2", "spectrum_a_3"};
    toliman_sim *const sim = one_core(chapter(), 0);
    measure_derivative(sim, "Zernike polynomial", zernikes, 8);
    measure_derivative(sim, "jitter", jitter, 3);
    measure_derivative(sim, "spectrum", spectra, 4);
    double *const weights = image_of(sim, TOLIMAN_SIM_IMAGE_SEPARATION), *const gradient = doubles(256 * 256);
    const double start = processor_s();
    assert_ok(toliman_sim_get_opd_gradient(sim, weights, 256, gradient));
    printf("{\"part\": \"derivative\", \"what\": \"OPD of every cell, as a gradient\", \"images\": 1, "
           "\"seconds\": %.5g}\n",
           processor_s() - start);
    fflush(stdout);
    free(weights);
    free(gradient);
    toliman_sim_destroy(sim);
}

int main(void) {
    toliman_machine machine = {.struct_size = sizeof machine};
    assert_ok(toliman_get_machine(&machine));
    if (machine.blas_is_slow != 0) {
        fprintf(stderr, "OpenBLAS runs its %s kernels: set OPENBLAS_CORETYPE=%s\n", machine.blas_core,
                machine.blas_better);
        return 1;
    }
    printf("{\"part\": \"machine\", \"isa\": \"%s\", \"blas_core\": \"%s\"}\n", machine.isa, machine.blas_core);
    measure_image("chapter", 0.20, 545);
    measure_image("mission", 0.375, 535);
    measure_frames();
    measure_stages();
    measure_derivatives();
    measure_choices();
    return 0;
}
