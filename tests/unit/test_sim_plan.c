/* Tests the plan: its choices keep the requested accuracy, and the errors that it predicts are correct. */
#include <stdbool.h>
#include <stdio.h>

#include "scene_text.h"

static toliman_sim_plan_info plan_of(const toliman_sim *sim) {
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_sim_get_plan(sim, &plan));
    return plan;
}

static double *doubles(size_t count) {
    double *const values = malloc(count * sizeof *values);
    assert_non_null(values);
    return values;
}

/* Largest difference between the frames of two simulators over the first one's peak. */
static double error_to_peak(const toliman_sim *sim, const toliman_sim *other) {
    double *const a = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH), *const b = image_of(other, TOLIMAN_SIM_IMAGE_BOTH);
    const toliman_sim_info info = sim_info_of(sim);
    double error = 0;
    for (int64_t i = 0; i < info.rows * info.cols; i++)
        error = fmax(error, fabs(a[i] - b[i]));
    free(a), free(b);
    return error / info.peak_photons;
}

/* Light by exposure, so that a changed image is not rescaled to the same peak; the other settings may vary. */
typedef struct {
    double accuracy, pixel_arcsec, min_nm, max_nm, step_nm;
    int side, samples;
    bool mask, integrated;
} variation;

static char *scene_of(const variation *v, int samples) {
    static const char mask[] = ", 'mask': {'kind': 'spiral', 'edges': 'cell', 'opd_nm': 297.5, 'terms': "
                               "[{'a': 0.819, 'f': 2.918, 'm': -7, "
                               "'p': 4.874}, {'a': 0.93, 'f': 1.829, 'm': 5}]}";
    char text[4096];
    snprintf(text, sizeof text,
             "{'schema': 'toliman-scene/1', 'telescope': {'aperture_m': 0.125, 'secondary_m': 0.02,"
             " 'pupil_samples': %d%s}, 'band': {'min_nm': %g, 'max_nm': %g, 'step_nm': %g},"
             " 'stars': {'A': {'spectrum': {'kind': 'blackbody', 'temperature_k': 5790},"
             "  'photons_per_s': 3e7}, 'B': {'spectrum': {'kind': 'blackbody', 'temperature_k': 5260},"
             "  'photons_per_s': 1e7}}, 'binary': {'separation_arcsec': %g, 'position_angle_deg': 25},"
             " 'signal': {'kind': 'sinusoid', 'amplitude_px': 1e-3, 'period_days': 9},"
             " 'cadence': {'frames': 10, 'exposure_s': 100},"
             " 'detector': {'shape': [%d, %d], 'pixel_scale_arcsec': %g, 'pixel': '%s'},"
             " 'noise': {'photon': true}, 'accuracy': %g}",
             samples, v->mask ? mask : "", v->min_nm, v->max_nm, v->step_nm, 0.2 * v->side * v->pixel_arcsec, v->side,
             v->side, v->pixel_arcsec, v->integrated ? "integrated" : "point", v->accuracy);
    return quoted(text);
}

static toliman_sim *varied(const variation *v, int samples) {
    char *const text = scene_of(v, samples);
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

static const variation kVariations[] = {
    {1e-9, 0.2, 550, 600, 1, 64, 96, true, false},     {1e-6, 0.2, 550, 600, 1, 64, 96, true, false},
    {1e-3, 0.2, 550, 600, 1, 64, 96, true, false},     {1e-12, 0.2, 550, 600, 1, 64, 96, true, false},
    {1e-9, 0.375, 530, 640, 1, 64, 128, true, false},  {1e-9, 0.375, 530, 640, 1, 64, 128, false, false},
    {1e-9, 0.2, 550, 600, 1, 64, 96, true, true},      {1e-6, 0.375, 530, 640, 2, 48, 96, true, true},
    {1e-9, 0.6, 550, 600, 1, 48, 160, true, true},     {1e-9, 0.1, 500, 700, 2, 80, 64, true, false},
    {1e-5, 0.375, 580, 590, 0.5, 64, 128, true, true}, {1e-9, 0.05, 530, 640, 1, 65, 49, false, true},
    {1e-9, 0.375, 550, 600, 1, 64, 256, true, false},  {1e-6, 0.375, 530, 640, 2, 64, 257, false, false},
};

/* Against every wavelength and a pixel filter at double precision. */
/* promise: images-keep-their-accuracy */
TEST(predictions_hold) {
    for (size_t i = in_long() ? 0 : 1; i < sizeof kVariations / sizeof *kVariations; i += in_long() ? 1 : 2) {
        variation v = kVariations[i];
        toliman_sim *const sim = varied(&v, v.samples);
        const toliman_sim_plan_info plan = plan_of(sim);
        const double predicted = plan.spectrum_error + plan.pixel_error + plan.rounding_error;
        v.accuracy = 1e-15;
        toliman_sim *const exact = varied(&v, v.samples);
        const double error = error_to_peak(sim, exact);
        print_message("scene %zu: %d nodes for %d, filter %d: error/peak %.2g, predicted %.2g\n", i, plan.wavelengths,
                      plan.scene_wavelengths, plan.filter_taps, error, predicted);
        assert_at_most(plan.spectrum_error, kVariations[i].accuracy);
        assert_at_most(plan.pixel_error, kVariations[i].accuracy);
        assert_at_most(error, predicted);
        if (predicted > 1e-12)
            assert_at_most(predicted, 1000 * error);
        toliman_sim_destroy(exact), toliman_sim_destroy(sim);
    }
}

/* From 256 samples on, half of them predict the errors that the whole pupil predicts. */
TEST(coarse_predictions_agree) {
    const double accuracies[] = {1e-3, 1e-7, 1e-11};
    for (size_t i = 0; i < sizeof accuracies / sizeof *accuracies; i++)
        for (int mask = 0; mask < 2; mask++) {
            const variation v = {accuracies[i], 0.375, 550, 600, 1, 64, 0, mask != 0, false};
            toliman_sim *const whole = varied(&v, 254), *const coarse = varied(&v, 256);
            const toliman_sim_plan_info a = plan_of(whole), b = plan_of(coarse);
            print_message("accuracy %g: %d or %d nodes, predicted %.3g or %.3g, pupil %.3g or %.3g\n", accuracies[i],
                          a.wavelengths, b.wavelengths, a.spectrum_error, b.spectrum_error, a.pupil_error,
                          b.pupil_error);
            assert_int_equal(a.wavelengths, b.wavelengths);
            assert_close(b.spectrum_error, a.spectrum_error, 0.3, 0);
            assert_close(b.pupil_error, a.pupil_error, 0.1, 0); /* inversely as the square root of the peak */
            toliman_sim_destroy(whole), toliman_sim_destroy(coarse);
        }
}

/* Against a pupil with four times the samples. */
TEST(pupil_errors_hold) {
    const size_t chosen[] = {0, 4, 5, 9};
    for (size_t i = 0; i < sizeof chosen / sizeof *chosen; i++) {
        variation v = kVariations[chosen[i]];
        v.step_nm = 10;
        toliman_sim *const sim = varied(&v, v.samples), *const finer = varied(&v, 4 * v.samples);
        const double error = error_to_peak(sim, finer), predicted = plan_of(sim).pupil_error;
        print_message("%d samples, %s: error/peak %.2g, predicted %.2g\n", v.samples, v.mask ? "mask" : "clear", error,
                      predicted);
        assert_at_most(error, predicted);
        assert_at_most(predicted, 30 * error);
        toliman_sim_destroy(sim), toliman_sim_destroy(finer);
    }
}

/* A stage that the scene does not name costs nothing. */
TEST(cost_of_stages_is_planned) {
    variation v = kVariations[6];
    toliman_sim *const whole = varied(&v, v.samples);
    v.integrated = false;
    toliman_sim *const point = varied(&v, v.samples);
    v.step_nm = 50;
    toliman_sim *const two_lines = varied(&v, v.samples);
    const toliman_sim_plan_info a = plan_of(whole), b = plan_of(point), c = plan_of(two_lines);
    assert_true(a.setup_flops > b.setup_flops && b.setup_flops > c.setup_flops);
    assert_true(b.filter_taps == 0 && b.pixel_error <= 0 && c.spectrum_error <= 0);
    assert_int_equal(c.wavelengths, 2);
    toliman_sim_stage of_a[32] = {TOLIMAN_SIM_STAGE_INIT}, of_b[32] = {TOLIMAN_SIM_STAGE_INIT};
    size_t count = 0, pixels = 0;
    assert_asks(toliman_sim_get_stages(&a, NULL, 0, &count));
    assert_ok(toliman_sim_get_stages(&a, of_a, 32, &count));
    assert_ok(toliman_sim_get_stages(&b, of_b, 32, &count));
    for (size_t i = 0; i < count; i++) {
        const int32_t differs = strcmp(of_a[i].name, "pixel integration") == 0;
        assert_int_equal(of_a[i].modelled, differs ^ of_b[i].modelled);
        pixels += (size_t)(differs && of_a[i].modelled);
    }
    assert_true(count > 10 && pixels == 1);
    assert_refused(toliman_sim_get_stages(&a, of_a, 2, &count), TOLIMAN_E_CAPACITY, "capacity");
    assert_invalid(toliman_sim_get_stages(NULL, of_a, 32, &count), "plan");
    toliman_sim_destroy(whole), toliman_sim_destroy(point), toliman_sim_destroy(two_lines);
}

/* Each of up to eight workers holds at least one complex field of the pupil per image. */
TEST(memory_includes_all_workers) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    toliman_sim_plan_info plans[3];
    const uint32_t threads[] = {1, 8, 9};
    for (int i = 0; i < 3; i++) {
        options.threads = threads[i];
        plans[i].struct_size = sizeof *plans;
        assert_ok(toliman_sim_plan_file("examples/scenes/chapter.json", &options, &plans[i]));
    }
    /* At least two slopes, focus, and the field itself. */
    const double field = 16.0 * 256 * 256, images = plans[0].order + 4;
    assert_true(plans[1].bytes > plans[0].bytes + 7 * images * field);
    assert_close(plans[2].bytes, plans[1].bytes, 0, 0); /* there are eight chunks of wavelengths */
}

/* A pixel's light is the mean over its area: Gauss-Legendre quadrature over images with shifted stars. */
TEST(pixels_integrate) {
    static const double nodes[6] = {-0.93246951420315202781, -0.66120938646626451366, -0.23861918608319690863,
                                    0.23861918608319690863,  0.66120938646626451366,  0.93246951420315202781};
    static const double weights[6] = {0.17132449237917034504, 0.36076157304813860757, 0.46791393457269104739,
                                      0.46791393457269104739, 0.36076157304813860757, 0.17132449237917034504};
    char *base =
        EDITED(kSingleScene, {"'peak_photons': 1e6", "'exposure_s': 1"}, {"5790}}", "5790}, 'photons_per_s': 1e6}"},
               {"0.2}}", "0.45, 'pixel': 'integrated'}, 'accuracy': 1e-12}"});
    toliman_sim *const sim = sim_with(base, "'A': [0, 0]", "'A': [1.3, -0.4]");
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH), *const sum = doubles(32 * 32);
    memset(sum, 0, 32 * 32 * sizeof *sum);
    char *const point = replaced(base, "'integrated'", "'point'");
    for (int i = 0; i < 36; i++) {
        char place[80];
        snprintf(place, sizeof place, "'A': [%.17g, %.17g]", 1.3 + nodes[i % 6] / 2, -0.4 + nodes[i / 6] / 2);
        toliman_sim *const moved = sim_with(point, "'A': [0, 0]", place);
        double *const part = image_of(moved, TOLIMAN_SIM_IMAGE_BOTH);
        for (int k = 0; k < 32 * 32; k++)
            sum[k] += weights[i % 6] * weights[i / 6] / 4 * part[k];
        free(part), toliman_sim_destroy(moved);
    }
    const double peak = sim_info_of(sim).peak_photons;
    double error = 0;
    for (int k = 0; k < 32 * 32; k++)
        error = fmax(error, fabs(image[k] - sum[k]) / peak);
    print_message("pixels of 0.45 arcsec: error/peak %.2g\n", error);
    assert_at_most(error, 2e-10); /* the quadrature's own error over 1 px of up to 0.5 cycles */
    free(image), free(sum), free(base), free(point), toliman_sim_destroy(sim);
}

static toliman_sim *padded(const char *json) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, strlen(json), NULL, &options, &sim));
    return sim;
}

/* Where N_E = N_out p D / lambda is an integer and equals the pupil samples, both engines agree; odd and even sizes. */
TEST(engines_agree) {
    const char *const shapes[] = {"[32, 32]", "[31, 29]"};
    for (int i = 0; i < 2; i++) {
        char *text = EDITED(kSingleScene, {"0.2}}", "0.35}}"}, {"[32, 32]", shapes[i]},
                            {"'wavelength_nm': 550", "'wavelength_nm': 424.211970970844"}); /* 128 p D / 64 */
        text = replaced_again(text, "'A': [0, 0]", "'A': [2.3, -1.7]");
        toliman_sim *const exact = sim_of(text), *const fft = padded(text);
        const toliman_sim_plan_info plan = plan_of(fft);
        assert_at_most(plan.plate_scale_error, 1e-12);
        assert_int_equal(plan.fft_side, 128);
        assert_int_equal(plan.fft_cells[0], 64);
        assert_int_equal(plan.fft_cells[1], 64);
        assert_int_equal(plan_of(exact).fft_side, 0);
        assert_int_equal(plan.engine, TOLIMAN_SIM_ENGINE_PADDED_FFT);
        assert_at_most(error_to_peak(exact, fft), 1e-11);
        for (int32_t kind = TOLIMAN_SIM_IMAGE_SEPARATION; kind <= TOLIMAN_SIM_IMAGE_FOCUS; kind++) {
            double *const a = image_of(exact, kind), *const b = image_of(fft, kind);
            double error = 0, largest = 0;
            for (int64_t k = 0; k < sim_info_of(exact).rows * sim_info_of(exact).cols; k++) {
                error = fmax(error, fabs(a[k] - b[k]));
                largest = fmax(largest, fabs(a[k]));
            }
            assert_at_most(error, 1e-10 * largest + 1e-9); /* a clear pupil has no first-order change with focus */
            free(a), free(b);
        }
        toliman_sim_destroy(exact), toliman_sim_destroy(fft), free(text);
    }
}

/* Otherwise the plate scale is off as the plan predicts; tested by the centroid of the light. */
TEST(padded_fft_errors_are_as_planned) {
    char *text = EDITED(kSingleScene, {"'A': [0, 0]", "'A': [9, 0]"}, {"'wavelength_nm': 550", "'wavelength_nm': 565"},
                        {"[32, 32]", "[33, 129]"});
    toliman_sim *const exact = sim_of(text), *const fft = padded(text);
    double *const a = image_of(exact, TOLIMAN_SIM_IMAGE_BOTH), *const b = image_of(fft, TOLIMAN_SIM_IMAGE_BOTH);
    double *const slope = image_of(exact, TOLIMAN_SIM_IMAGE_SHIFT_X), shift = 0, norm = 0;
    for (int k = 0; k < 33 * 129; k++) {
        shift += (b[k] / sim_info_of(fft).peak_photons * sim_info_of(exact).peak_photons - a[k]) * slope[k];
        norm += slope[k] * slope[k];
    }
    const double off = shift / norm / 9, planned = plan_of(fft).plate_scale_error;
    print_message("plate scale off by %.3g, planned %.3g\n", off, planned);
    assert_close(fabs(off), planned, 0.03, 0);
    assert_true(planned > 3e-4);
    free(a), free(b), free(slope), free(text), toliman_sim_destroy(exact), toliman_sim_destroy(fft);
}

/* Each wavelength has its own rounding: N_E = N_out p D / lambda. */
TEST(plate_scales_by_wavelength) {
    toliman_sim *const exact = sim_of(kBinaryScene), *const fft = padded(kBinaryScene);
    double wavelength[5], error[5];
    assert_ok(toliman_sim_get_spectrum(fft, 5, wavelength, NULL, NULL, error));
    for (int i = 0; i < 5; i++) {
        const double samples = 256 * (0.2 * acos(-1) / 648000) * 0.125 / wavelength[i];
        assert_close(error[i], samples / floor(samples + 0.5) - 1, 1e-9, 0);
    }
    assert_ok(toliman_sim_get_spectrum(exact, 5, NULL, NULL, NULL, error));
    for (int i = 0; i < 5; i++)
        assert_close(error[i], 0, 0, 0);
    toliman_sim_destroy(exact), toliman_sim_destroy(fft);
}

/* The same for the wavelengths that a signal needs: 90 px to either side of a star at the centre. */
TEST(wavelengths_suffice_for_far_signals) {
    variation v = kVariations[0];
    v.samples = 160;
    char *text = scene_of(&v, v.samples);
    text = replaced_again(text, "'amplitude_px': 1e-3", "'amplitude_px': 90");
    char *const exact = replaced(text, "'accuracy': 1e-09", "'accuracy': 1e-15");
    toliman_sim *const sim = sim_of(text), *const all = sim_of(exact);
    double *const a = doubles(64 * 64), *const b = doubles(64 * 64);
    double error = 0;
    for (int side = -1; side <= 1; side += 2) {
        assert_ok(toliman_sim_propagate(sim, 90 * side, a, 64));
        assert_ok(toliman_sim_propagate(all, 90 * side, b, 64));
        for (int i = 0; i < 64 * 64; i++)
            error = fmax(error, fabs(a[i] - b[i]) / sim_info_of(all).peak_photons);
    }
    print_message("%d nodes, 90 px away: error/peak %.2g, planned %.2g\n", plan_of(sim).wavelengths, error,
                  plan_of(sim).spectrum_error);
    assert_at_most(error, 1e-9);
    free(a), free(b), free(text), free(exact), toliman_sim_destroy(sim), toliman_sim_destroy(all);
}

/* A signal of a pixel or more, beyond the expansion: interpolated, also outside the planned range, or propagated. */
TEST(far_signals_are_interpolated) {
    char *text =
        EDITED(kBinaryScene, {"'amplitude_px': 1e-3", "'amplitude_px': 1.5"}, {"'photon': true, 'read_e': 2.5, ", ""});
    char *const finest = replaced(text, "'cadence'", "'accuracy': 1e-15, 'cadence'");
    toliman_sim *const sim = sim_of(text), *const propagated = sim_of(finest);
    const toliman_sim_plan_info plan = plan_of(sim);
    assert_true(plan.atlas_taps > 0 && plan.exact_frames == 0 && plan.series_error <= 0);
    assert_int_equal(plan_of(propagated).exact_frames, 1);
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    assert_true(bounds.truncation <= 0);
    double *const frame = doubles(64 * 64), *const exact = doubles(64 * 64);
    const double places[] = {-1.5, 0.7, 1.2345678, -30};
    for (size_t i = 0; i < 4; i++) {
        double error = 0;
        assert_ok(toliman_sim_frame(sim, &places[i], 1, 5, 1, frame));
        assert_ok(toliman_sim_propagate(sim, places[i], exact, 64));
        for (int k = 0; k < 64 * 64; k++)
            error = fmax(error, fabs(frame[k] - exact[k]) / sim_info_of(sim).peak_photons);
        print_message("displacement %g px: error/peak %.2g, planned %.2g\n", places[i], error, plan.atlas_error);
        assert_at_most(error, plan.atlas_error);
    }
    double at;
    assert_ok(toliman_sim_get_series(propagated, 5, 1, NULL, &at));
    assert_true(fabs(at) > 1);
    assert_ok(toliman_sim_frame(propagated, NULL, 1, 5, 1, frame));
    assert_ok(toliman_sim_propagate(propagated, at, exact, 64));
    assert_memory_equal(frame, exact, 64 * 64 * sizeof *frame);
    assert_refused(toliman_sim_expect(sim, at, frame, 64), TOLIMAN_E_RANGE, "displacement_px");
    assert_refused(toliman_sim_frame(sim, &(double){-101}, 1, 0, 1, frame), TOLIMAN_E_RANGE, "displacements_px[0]");
    free(frame), free(exact), free(text), free(finest), toliman_sim_destroy(sim), toliman_sim_destroy(propagated);
}

/* The padded FFT has another plate scale on the grid of an interpolation. */
TEST(padded_frames_are_propagated) {
    char *text = replaced(kSingleScene, "'cadence'", "'systematics': {'pointing_rms_px': 0.1}, 'cadence'");
    toliman_sim *const exact = sim_of(text), *const fft = padded(text);
    assert_true(plan_of(exact).exact_frames == 0 && plan_of(fft).exact_frames == 1 && plan_of(fft).atlas_taps == 0);
    free(text), toliman_sim_destroy(exact), toliman_sim_destroy(fft);
}

/* A star so far from the frame that its samples would not fit in memory. */
TEST(far_stars_are_propagated) {
    char *text = EDITED(kSingleScene, {"'cadence'", "'systematics': {'pointing_rms_px': 0.1}, 'cadence'"},
                        {"'pupil_samples': 64", "'pupil_samples': 2048"});
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    const char *const places[] = {"[3900, 0]", "[4400, 4400]"};
    for (int i = 0; i < 2; i++) {
        char *const far = replaced(text, "[0, 0]", places[i]);
        assert_ok(toliman_sim_plan_json(far, strlen(far), NULL, NULL, &plan));
        assert_int_equal(plan.exact_frames, i);
        free(far);
    }
    free(text);
}

/* The text of a file is planned like the file. */
TEST(plan_of_a_text) {
    const char *const mission = "examples/scenes/mission.json";
    toliman_sim_plan_info plan = {.struct_size = sizeof plan}, same = plan;
    char text[4096];
    FILE *const file = fopen(mission, "rb");
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    assert_ok(toliman_sim_plan_file(mission, NULL, &plan));
    assert_ok(toliman_sim_plan_json(text, size, "examples/scenes", NULL, &same));
    plan.setup_s = same.setup_s; /* measured */
    plan.frame_s = same.frame_s;
    assert_memory_equal(&same, &plan, sizeof plan);
    assert_refused(toliman_sim_plan_json(text, size, NULL, NULL, &same), TOLIMAN_E_NOT_FOUND, "./g2v.csv");
    assert_invalid(toliman_sim_plan_json(NULL, size, NULL, NULL, &same), "json");
    assert_invalid(toliman_sim_plan_json(text, size, NULL, NULL, NULL), "out");
}

TEST(bad_plans_are_refused) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    const char *const chapter = "examples/scenes/chapter.json";
    assert_ok(toliman_sim_plan_file(chapter, &options, &plan));
    assert_true(plan.wavelengths < plan.scene_wavelengths && plan.scene_wavelengths == 51);
    options.reserved = 1;
    assert_invalid(toliman_sim_plan_file(chapter, &options, &plan), "options->reserved");
    options.reserved = 0;
    options.engine = 333;
    assert_invalid(toliman_sim_plan_file(chapter, &options, &plan), "options->engine");
    options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    assert_ok(toliman_sim_plan_file(chapter, &options, &plan));
    assert_close(plan.plate_scale_error, 2.3e-3, 0.05, 0); /* the rounding of the chapter's scene: up to 0.26 % */
    const double cells = 1024 * (0.20 / 206264.80624709636) * 0.125; /* N_E lambda, m; 550 to 600 nm */
    assert_int_equal(plan.fft_side, 1024);
    assert_int_equal(plan.fft_cells[0], lround(cells / 600e-9));
    assert_int_equal(plan.fft_cells[1], lround(cells / 550e-9));
    assert_refused(toliman_sim_plan_file("none.json", NULL, &plan), TOLIMAN_E_NOT_FOUND, "none.json");
    assert_invalid(toliman_sim_plan_file(chapter, NULL, NULL), "out");
    plan.struct_size = 4;
    assert_invalid(toliman_sim_plan_file(chapter, NULL, &plan), "out->struct_size");
    toliman_sim *sim = NULL;
    char *const text = replaced(kBinaryScene, "'kind': 'spiral', 'edges': 'cell', 'opd_nm': 297.5,",
                                "'kind': 'file', 'file': 'x.npy', 'quantity': 'opd_m'}}, 'x': {'y': {");
    assert_refused(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim), TOLIMAN_E_SCENE, "x");
    free(text);
}

/* A single pixel, and pixels too large for the fft engine to sample. */
TEST(odd_detectors_are_planned) {
    variation v = kVariations[0];
    char *const text = scene_of(&v, 96);
    char *const pixel = replaced(text, "'shape': [64, 64]", "'shape': [1, 1]");
    char *const exact = replaced(pixel, "'accuracy': 1e-09", "'accuracy': 1e-15");
    toliman_sim *const sim = sim_of(pixel), *const all = sim_of(exact);
    assert_at_most(error_to_peak(sim, all), plan_of(sim).spectrum_error + 1e-13);
    toliman_sim_destroy(sim), toliman_sim_destroy(all), free(pixel), free(exact), free(text);
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
    toliman_sim *none = NULL;
    char *const coarse = replaced(kSingleScene, "0.2}}", "1.5}}");
    assert_refused(toliman_sim_create_json(coarse, strlen(coarse), NULL, &options, &none), TOLIMAN_E_SCENE,
                   "detector.pixel_scale_arcsec");
    free(coarse);
    char *const far = replaced(kSingleScene, "[0, 0]", "[110, 0]"); /* its next alias is at -18 px */
    assert_refused(toliman_sim_create_json(far, strlen(far), NULL, &options, &none), TOLIMAN_E_SCENE, "binary");
    free(far);
}

/* Filters of pixels far smaller than any detail change nothing. */
TEST(tiny_pixels_need_no_filter) {
    const char *const scales[] = {"1e-2", "1e-4", "1e-6"};
    for (int i = 0; i < 3; i++) {
        char pixel[100];
        snprintf(pixel, sizeof pixel, "%s}}", scales[i]);
        char *const point = replaced(kSingleScene, "0.2}}", pixel);
        snprintf(pixel, sizeof pixel, "%s, 'pixel': 'integrated'}}", scales[i]);
        char *const whole = replaced(kSingleScene, "0.2}}", pixel);
        toliman_sim *const a = sim_of(point), *const b = sim_of(whole);
        assert_at_most(error_to_peak(a, b), 1e-5 / pow(100, i)); /* the blur by a pixel's width */
        assert_at_most(plan_of(b).pixel_error, 1e-9);
        toliman_sim_destroy(a), toliman_sim_destroy(b), free(point), free(whole);
    }
}

RUN_TESTS(NULL, NULL)
