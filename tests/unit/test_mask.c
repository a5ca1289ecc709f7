/* Tests the design of a mask: scores against images and spectra of the scenes, quantum bounds, the same result on any
 * number of threads, a design that is stopped, and scenes with other masks or none. */
#include <toliman/mask.h>

#include "scene_files.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, WAVELENGTHS = 5, SAMPLES = 96, CELLS = SAMPLES * SAMPLES };

static const char kMask[] =
    "{\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,"
    "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": 5}]}";

static toliman_mask_options options_of(uint64_t seed, uint32_t iterations, uint32_t threads) {
    toliman_mask_options options = TOLIMAN_MASK_OPTIONS_INIT;
    options.seed = seed;
    options.iterations = iterations;
    options.threads = threads;
    options.free = "flux_a, flux_b shift_x,shift_y";
    options.light_in_frame = 0.3;
    return options;
}

static toliman_mask *design(const toliman_sim *sim, toliman_mask_options options) {
    toliman_mask *mask = NULL;
    assert_ok(toliman_mask_create(sim, &options, &mask));
    return mask;
}

static toliman_mask_info info_of(const toliman_mask *mask) {
    toliman_mask_info info = TOLIMAN_MASK_INFO_INIT;
    assert_ok(toliman_mask_get_info(mask, &info));
    return info;
}

/* Writes the cells as the file that the JSON of the mask names. */
static void write_cells(const toliman_mask *mask) {
    static double cells[CELLS];
    static unsigned char steps[CELLS];
    assert_ok(toliman_mask_get_cells(mask, SAMPLES, cells));
    for (int i = 0; i < CELLS; i++) {
        assert_true(cells[i] == 0 || cells[i] == 1);
        steps[i] = cells[i] > 0;
    }
    write_npy("mask.npy", "|u1", "(96, 96)", steps, sizeof steps);
}

static toliman_sim *sim_of_mask(const toliman_mask *mask) {
    char *const text = replaced(kBinaryScene, kMask, toliman_mask_get_json(mask));
    toliman_sim *sim = NULL;
    write_cells(mask);
    assert_ok(create_in_folder(text, &sim));
    free(text);
    return sim;
}

/* Scores by the images and the spectrum of the scene. */
typedef struct {
    double alone, flux_shift, peak_to_mean, light, gradient, radius_50, radius_80;
} Expected;

static double radius(const double *image, double fraction) {
    double sum = 0, x = 0, y = 0;
    for (int i = 0; i < PIXELS; i++) {
        sum += image[i];
        x += image[i] * (i % SIDE);
        y += image[i] * (i / SIDE);
    }
    for (double square = 0; square < 1e4; square += 0.5) { /* slow and obvious */
        double within = 0;
        for (int i = 0; i < PIXELS; i++)
            if (pow(i % SIDE - x / sum, 2) + pow(i / SIDE - y / sum, 2) <= square)
                within += image[i];
        if (within >= fraction * sum)
            return sqrt(square);
    }
    return NAN;
}

static Expected expected_of(const toliman_sim *sim) {
    static double both[PIXELS];
    double a[WAVELENGTHS], b[WAVELENGTHS], total = 0, peak = 0, emitted = 0;
    toliman_sim_bounds bounds = TOLIMAN_SIM_BOUNDS_INIT;
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, both, SIDE));
    assert_ok(toliman_sim_get_spectrum(sim, WAVELENGTHS, NULL, a, b, NULL));
    for (int i = 0; i < PIXELS; i++) {
        total += both[i];
        peak = fmax(peak, both[i]);
    }
    for (int i = 0; i < WAVELENGTHS; i++)
        emitted += a[i] + b[i];
    return (Expected){bounds.crb_px,          bounds.crb_flux_shift_px, peak / total * PIXELS, total / emitted,
                      bounds.gradient_energy, radius(both, 0.5),        radius(both, 0.8)};
}

/* The bounds alone, and with fluxes and shifts free. No mask goes below the quantum bounds. */
TEST(scores_are_those_of_the_scenes) {
    toliman_sim *const own = sim_of(kBinaryScene);
    toliman_mask *const mask = design(own, options_of(2, 25, 0));
    const toliman_mask_info info = info_of(mask);
    assert_int_equal(info.improved, 1);
    assert_int_equal(info.stopped, 0);
    assert_at_most(info.crb_px, 0.9 * info.crb_before_px);
    assert_at_most(info.peak_to_mean, info.peak_to_mean_before);
    toliman_sim *const better = sim_of_mask(mask);
    const Expected before = expected_of(own), after = expected_of(better);
    const double scores[][2] = {{info.crb_before_px, before.flux_shift},
                                {info.crb_px, after.flux_shift},
                                {info.crb_flux_shift_before_px, before.flux_shift},
                                {info.crb_flux_shift_px, after.flux_shift},
                                {info.crb_alone_before_px, before.alone},
                                {info.crb_alone_px, after.alone},
                                {info.peak_to_mean_before, before.peak_to_mean},
                                {info.peak_to_mean, after.peak_to_mean},
                                {info.light_in_frame_before, before.light},
                                {info.light_in_frame, after.light},
                                {info.gradient_energy_before, before.gradient},
                                {info.gradient_energy, after.gradient}};
    for (size_t i = 0; i < sizeof scores / sizeof *scores; i++)
        assert_close(scores[i][0], scores[i][1], 1e-6, 0);
    assert_close(info.radius_50_before_px, before.radius_50, 0, 0.15); /* squares in steps of 0.5 */
    assert_close(info.radius_80_before_px, before.radius_80, 0, 0.15);
    assert_close(info.radius_50_px, after.radius_50, 0, 0.15);
    assert_close(info.radius_80_px, after.radius_80, 0, 0.15);
    assert_true(info.quantum_px < info.crb_alone_px && info.quantum_px > 0.3 * info.crb_alone_px);
    assert_true(info.quantum_flux_shift_px < info.crb_flux_shift_px && info.quantum_flux_shift_px > info.quantum_px);
    toliman_sim_destroy(own), toliman_sim_destroy(better), toliman_mask_destroy(mask);
}

/* With a mask of 298 nm, no decimal fraction of few digits represents this number. */
TEST(json_has_the_same_numbers) {
    const double opd_nm = 298 * (1 + 0x1p-52);
    char number[40];
    snprintf(number, sizeof number, "%.17g", opd_nm);
    char *const text = replaced(kBinaryScene, "297.5", number);
    toliman_sim *const sim = sim_of(text);
    toliman_mask *const mask = design(sim, options_of(1, 1, 1));
    const char *const found = strstr(toliman_mask_get_json(mask), "\"opd_nm\": ");
    assert_non_null(found);
    assert_true(strtod(found + strlen("\"opd_nm\": "), NULL) == opd_nm);
    toliman_mask_destroy(mask), toliman_sim_destroy(sim), free(text);
}

/* promise: masks-ignore-threads */
TEST(a_seed_gives_one_mask_on_any_number_of_threads) {
    static double cells[3][CELLS], descent[2][40];
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_mask_options odd = options_of(8, 5, 1);
    odd.symmetry = TOLIMAN_MASK_SYMMETRY_ODD;
    toliman_mask *const masks[3] = {design(sim, options_of(7, 5, 1)), design(sim, options_of(7, 5, 3)),
                                    design(sim, odd)};
    const toliman_mask_info info = info_of(masks[0]), same = info_of(masks[1]);
    assert_memory_equal(&info, &same, sizeof info);
    for (int k = 0; k < 3; k++)
        assert_ok(toliman_mask_get_cells(masks[k], SAMPLES, cells[k]));
    assert_memory_equal(cells[0], cells[1], sizeof cells[0]);
    assert_memory_not_equal(cells[0], cells[2], sizeof cells[0]);
    int same_as_opposite = 0; /* a closed cell has no kind */
    for (int i = 0; i < CELLS; i++)
        same_as_opposite += cells[2][i] > 0 && cells[2][CELLS - 1 - i] > 0;
    assert_int_equal(same_as_opposite, 0);
    assert_in_range(info.iterations, 9, 40);
    for (int k = 0; k < 2; k++)
        assert_ok(toliman_mask_get_descent(masks[k], (size_t)info.iterations, descent[k]));
    assert_memory_equal(descent[0], descent[1], sizeof descent[0]);
    assert_close(descent[0][info.iterations - 1], info.crb_px, 0.3, 0);
    for (int k = 0; k < 3; k++)
        toliman_mask_destroy(masks[k]);
    toliman_sim_destroy(sim);
}

typedef struct {
    const char *stage; /* to be stopped, at its call number `call` */
    int call, calls, calls_after;
} Watch;

static int32_t stop_in_stage(const char *stage, double fraction, void *given) {
    Watch *const watch = given;
    assert_true(fraction >= 0 && fraction <= 1);
    if (watch->calls_after > 0 ||
        (strncmp(stage, watch->stage, strlen(watch->stage)) == 0 && watch->calls++ == watch->call))
        watch->calls_after++;
    return watch->calls_after > 0;
}

/* A stopped design calls the callback no more, and its result is the mask so far. */
/* promise: stopped-objects-stay-usable */
TEST(a_stopped_design_keeps_its_mask) {
    static const struct {
        const char *stage;
        int call;
        uint64_t iterations;
    } cases[] = {{"draw", 0, 0}, {"draw", 3, 0}, {"descend", 0, 0}, {"descend", 7, 7}, {"polish", 3, 13}};
    toliman_sim *const sim = sim_of(kBinaryScene);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Watch watch = {.stage = cases[i].stage, .call = cases[i].call};
        toliman_mask_options options = options_of(3, 10, 0);
        options.progress = stop_in_stage;
        options.progress_data = &watch;
        toliman_mask *const mask = design(sim, options);
        const toliman_mask_info info = info_of(mask);
        assert_int_equal(watch.calls_after, 1);
        assert_int_equal(info.stopped, 1);
        assert_int_equal(info.iterations, cases[i].iterations);
        toliman_sim *const made = sim_of_mask(mask);
        assert_close(info.crb_px, expected_of(made).flux_shift, 1e-6, 0);
        toliman_sim_destroy(made), toliman_mask_destroy(mask);
    }
    toliman_sim_destroy(sim);
}

/* The step of the masks designed for a scene whose mask is replaced by `mask`. */
static void assert_step(const char *mask, const char *step) {
    char *const text = replaced(kBinaryScene, kMask, mask);
    toliman_sim *sim = NULL;
    assert_ok(create_in_folder(text, &sim));
    toliman_mask *const made = design(sim, options_of(3, 1, 0));
    assert_non_null(strstr(toliman_mask_get_json(made), step));
    toliman_mask_destroy(made), toliman_sim_destroy(sim), free(text);
}

/* Half of 575 nm, the middle of the band, where the scene's mask gives no step. */
TEST(scenes_with_other_masks) {
    static double opd_m[CELLS];
    static unsigned char steps[CELLS];
    for (int i = 0; i < CELLS; i++) {
        steps[i] = i / 7 % 2 != 0;
        opd_m[i] = 1e-9 * (i % SAMPLES);
    }
    write_npy("other.npy", "|u1", "(96, 96)", steps, sizeof steps);
    write_npy("surface.npy", "<f8", "(96, 96)", opd_m, sizeof opd_m);
    assert_step("{\"kind\": \"clear\"}", "{\"kind\": \"file\", \"file\": \"mask.npy\", \"quantity\": \"binary\", "
                                         "\"opd_nm\": 287.5}");
    assert_step(
        "{\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 250.3, \"terms\": [{\"a\": 1, \"f\": 2, \"m\": 1}]}",
        "\"opd_nm\": 250.3}");
    assert_step("{\"kind\": \"file\", \"file\": \"other.npy\", \"quantity\": \"binary\", \"opd_nm\": 250.3}",
                "\"opd_nm\": 250.3}");
    assert_step("{\"kind\": \"file\", \"file\": \"other.npy\", \"quantity\": \"binary\", \"height_nm\": 144}",
                "\"height_nm\": 144}");
    assert_step("{\"kind\": \"file\", \"file\": \"surface.npy\", \"quantity\": \"opd_m\"}", "\"opd_nm\": 287.5}");
}

/* Files of the pupil have a fixed size, so the sketch has all samples. The design reads them again. */
TEST(scenes_with_files_of_the_pupil) {
    static double grey[CELLS];
    for (int i = 0; i < CELLS; i++)
        grey[i] = 0.5;
    write_npy("amplitude.npy", "<f8", "(96, 96)", grey, sizeof grey);
    char *const text =
        replaced(kBinaryScene, "\"aperture_m\"", "\"amplitude\": {\"file\": \"amplitude.npy\"}, \"aperture_m\"");
    toliman_sim *sim = NULL;
    toliman_mask *made = NULL;
    assert_ok(create_in_folder(text, &sim));
    made = design(sim, options_of(3, 1, 0));
    assert_true(isfinite(info_of(made).crb_px));
    toliman_mask_destroy(made);
    made = NULL;
    assert_int_equal(unlink(path_of("amplitude.npy")), 0);
    assert_refused(toliman_mask_create(sim, NULL, &made), TOLIMAN_E_NOT_FOUND, path_of("amplitude.npy"));
    assert_null(made);
    toliman_sim_destroy(sim), free(text);
}

TEST(refusals) {
    static double few[1];
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_mask *mask = NULL;
    toliman_mask_info info = TOLIMAN_MASK_INFO_INIT;
    toliman_mask_options options = options_of(1, 1, 1);
    options.struct_size--;
    assert_invalid(toliman_mask_create(sim, &options, &mask), "options->struct_size");
    options = options_of(1, 1, 1);
    options.free = "flux_a separation";
    assert_invalid(toliman_mask_create(sim, &options, &mask), "options->free");
    assert_invalid(toliman_mask_create(NULL, NULL, &mask), "sim");
    assert_invalid(toliman_mask_create(sim, NULL, NULL), "out");
    assert_invalid(toliman_mask_get_info(NULL, &info), "mask");
    assert_string_equal(toliman_mask_get_json(NULL), "");
    assert_null(mask);
    mask = design(sim, options_of(1, 1, 1));
    assert_invalid(toliman_mask_get_descent(mask, 0, few), "count");
    assert_invalid(toliman_mask_get_cells(mask, 1, few), "side");
    for (int place = -1; place < 2; place += 2)
        assert_refused(toliman_mask_get_place(mask, place, &info), TOLIMAN_E_RANGE, "place");
    toliman_mask_destroy(mask), toliman_mask_destroy(NULL), toliman_sim_destroy(sim);
    mask = NULL;

    const toliman_sim_options fft = {.struct_size = sizeof fft, .engine = TOLIMAN_SIM_ENGINE_PADDED_FFT};
    toliman_sim *padded = NULL;
    assert_ok(toliman_sim_create_json(kSingleScene, strlen(kSingleScene), NULL, &fft, &padded));
    assert_refused(toliman_mask_create(padded, NULL, &mask), TOLIMAN_E_UNSUPPORTED, "sim");
    toliman_sim_destroy(padded);

    toliman_sim *const pixel = sim_with(kSingleScene, "[32, 32]", "[1, 1]"); /* one number, eight unknown */
    assert_refused(toliman_mask_create(pixel, NULL, &mask), TOLIMAN_E_SCENE, "");
    toliman_sim_destroy(pixel);
    assert_null(mask);
}

RUN_TESTS(make_folder, remove_folder)
