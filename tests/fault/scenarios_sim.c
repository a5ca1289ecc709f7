/* sim.h, sim_derivative.h */
#include <stdlib.h>
#include <string.h>

#include "cae_scene.h"
#include "scenario.h"
#include "scene_text.h"

enum { SAMPLES = 32, PIXELS = SMALL * SMALL };

static char *smaller(const char *scene) {
    char *text = replaced(scene, "\"pupil_samples\": 96", "\"pupil_samples\": 32");
    return replaced_again(text, "[64, 64]", "[24, 24]");
}

/* Every stage of the detector, every systematic effect, nuisances. */
static char *everything(void) {
    char *text = smaller(kBinaryScene);
    text = replaced_again(text, "\"peak_photons\": 1e5", "\"exposure_s\": 1");
    text = replaced_again(text, "\"relative_flux\": 3", "\"photons_per_s\": 3e6");
    text = replaced_again(text, "\"temperature_k\": 5260}", "\"temperature_k\": 5260}, \"photons_per_s\": 1e6");
    text = replaced_again(text, "\"pixel_scale_arcsec\": 0.2",
                          "\"pixel_scale_arcsec\": 0.2, \"pixel\": \"integrated\", \"qe\": 0.8, \"flat_rms\": 0.01,"
                          " \"gain_e_per_dn\": 2, \"bias_dn\": 100, \"full_well_e\": 1e6, \"bit_depth\": 16,"
                          " \"dark_e_per_s\": 1");
    return replaced_again(text, "\"noise\"",
                          "\"systematics\": {\"pointing_rms_px\": 1e-4, \"jitter_sigma_px\": 0.1,"
                          " \"roll_rms_deg\": 1e-5, \"scale_rms\": 1e-6, \"focus_rms_nm\": 0.01, \"flux_rms\": 1e-4},"
                          " \"preprocess\": {\"project\": [\"flux_a\", \"shift_x\", \"roll\"]}, \"noise\"");
}

/* Stars that follow their orbit; the first frame computes the atlas. */
static char *on_orbit(void) {
    char *text = smaller(kBinaryScene);
    text = replaced_again(text, "{\"separation_arcsec\": 4, \"position_angle_deg\": 30}",
                          "{\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true}");
    text = replaced_again(text, "\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.8");
    text = replaced_again(text, "\"pupil_samples\": 32", "\"pupil_samples\": 48");
    return replaced_again(text, "\"frames\": 100, \"interval_days\": 2", "\"frames\": 20000, \"interval_days\": 0.05");
}

static char *with_files(void) {
    char *text = smaller(kBinaryScene);
    text = replaced_again(text, "\"aperture_m\"", "\"amplitude\": {\"file\": \"amplitude.npy\"}, \"aperture_m\"");
    text = replaced_again(text, "\"pupil_samples\": 32",
                          "\"pupil_samples\": 32, \"aberrations\": {\"opd_file\": \"surface.npy\"}");
    return replaced_again(text, "{\"kind\": \"blackbody\", \"temperature_k\": 5260}",
                          "{\"kind\": \"table\", \"file\": \"star.csv\"}");
}

static char *plain_fft(void) {
    return smaller("{\"schema\": \"toliman-scene/1\","
                   " \"telescope\": {\"aperture_m\": 0.125, \"pupil_samples\": 96},"
                   " \"band\": {\"wavelength_nm\": 550},"
                   " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}}},"
                   " \"binary\": {\"offsets_px\": {\"A\": [0, 0]}},"
                   " \"cadence\": {\"frames\": 10, \"peak_photons\": 1e6},"
                   " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.2}}");
}

static void put_map(const char *name, double value) {
    static const char header[118] = "{'descr': '<f8', 'fortran_order': False, 'shape': (32, 32), }";
    static unsigned char bytes[128 + 8 * SAMPLES * SAMPLES];
    memcpy(bytes, "\x93NUMPY\x01\x00\x76\x00", 10);
    memcpy(bytes + 10, header, sizeof header);
    for (size_t i = 0; i < SAMPLES * SAMPLES; i++)
        memcpy(bytes + 128 + 8 * i, &value, sizeof value);
    write_file(name, bytes, sizeof bytes);
}

static void put_files(void) {
    static const char table[] = "wavelength_nm,photons\n540,1\n570,2\n610,1.5\n";
    char *const scene = with_files();
    write_file("scene.json", scene, strlen(scene));
    write_file("star.csv", table, sizeof table - 1);
    put_map("amplitude.npy", 0.5);
    put_map("surface.npy", 1e-9);
    free(scene);
}

static toliman_sim *made_of(char *text) {
    toliman_sim *const sim = sim_on_threads(text, 3);
    free(text);
    return sim;
}

toliman_sim *small_sim(void) {
    static toliman_sim *sim;
    return sim != NULL ? sim : (sim = made_of(smaller(kBinaryScene)));
}

toliman_sim *large_sim(void) {
    static toliman_sim *sim;
    return sim != NULL ? sim : (sim = make_sim(LARGE, LARGE, 0, "\"flux_a\""));
}

static const double *frames_of(const toliman_sim *sim, size_t pixels) {
    double *const frames = new_image(FRAMES * pixels);
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, FRAMES, frames));
    return frames;
}

const double *small_frames(void) {
    static const double *frames;
    return frames != NULL ? frames : (frames = frames_of(small_sim(), PIXELS));
}

const double *large_frames(void) {
    static const double *frames;
    return frames != NULL ? frames : (frames = frames_of(large_sim(), kPixels));
}

static void end(void *sim) {
    toliman_sim_destroy(sim);
}

/* With frames far apart along an orbit. */
static uint64_t digest(const void *sim) {
    static double frame[PIXELS];
    toliman_sim_info info = sim_info_of(sim);
    info.name = NULL; /* a different pointer for each object */
    uint64_t hash = fnv1a(FNV_START, &info, sizeof info);
    for (int64_t k = 0; k < 3; k++) {
        assert_ok(toliman_sim_frame(sim, &(double){1e-4}, 3, k * (info.frames - 1) / 2, 1, frame));
        hash = fnv1a(hash, frame, sizeof frame);
    }
    return hash;
}

static const object_kind sims = {end, digest};

static int32_t keep_going(const char *stage, double fraction, void *unused) {
    (void)stage, (void)fraction, (void)unused;
    return 0;
}

static void ignore_log(int32_t level, const char *text, void *unused) {
    (void)level, (void)text, (void)unused;
}

static toliman_status create_of(char *text, int32_t engine, uint32_t threads, void **made) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.engine = engine;
    options.threads = threads;
    options.progress = keep_going;
    options.log = ignore_log;
    return toliman_sim_create_json(text, strlen(text), NULL, &options, (toliman_sim **)made);
}

/* Text of a scene, created once so that its creation is not part of the call. */
#define SCENE(name, make)                                                                                              \
    static char *name(void) {                                                                                          \
        static char *text;                                                                                             \
        return text != NULL ? text : (text = make);                                                                    \
    }
SCENE(binary_text, smaller(kBinaryScene))
SCENE(everything_text, everything())
SCENE(orbit_text, on_orbit())
SCENE(fft_text, plain_fft())
SCENE(impossible_text, replaced(kBinaryScene, "0.125", "-0.125"))

/* Creates all texts before calls fail. */
static void put_texts(void) {
    (void)binary_text(), (void)everything_text(), (void)orbit_text(), (void)fft_text();
    (void)impossible_text();
}

static toliman_status create_json(attempt *a) {
    return create_of(binary_text(), 0, 1, &a->made);
}
static toliman_status create_threads(attempt *a) {
    return create_of(binary_text(), 0, 3, &a->made);
}
static toliman_status create_everything(attempt *a) {
    return create_of(everything_text(), 0, 1, &a->made);
}
static toliman_status create_orbit(attempt *a) {
    return create_of(orbit_text(), 0, 1, &a->made);
}
static toliman_status create_fft(attempt *a) {
    return create_of(fft_text(), TOLIMAN_SIM_ENGINE_PADDED_FFT, 1, &a->made);
}
static toliman_status create_half(attempt *a) {
    return toliman_sim_create_json(binary_text(), strlen(binary_text()) / 2, NULL, NULL, (toliman_sim **)&a->made);
}
static toliman_status create_impossible(attempt *a) {
    return create_of(impossible_text(), 0, 1, &a->made);
}
static toliman_status create(attempt *a) {
    return toliman_sim_create_file(in_folder("scene.json"), NULL, (toliman_sim **)&a->made);
}

/* Measured times differ on each call. */
static toliman_status without_seconds(toliman_status status, toliman_sim_plan_info *plan) {
    if (status == TOLIMAN_OK)
        plan->setup_s = plan->frame_s = 0;
    return status;
}
static toliman_status plan(attempt *a) {
    toliman_sim_plan_info *const out = (void *)a->out;
    return without_seconds(toliman_sim_plan_file(in_folder("scene.json"), NULL, out), out);
}
static toliman_status plan_json(attempt *a) {
    toliman_sim_plan_info *const out = (void *)a->out;
    const char *const text = everything_text();
    return without_seconds(toliman_sim_plan_json(text, strlen(text), NULL, NULL, out), out);
}
static toliman_status destroy(attempt *a) {
    toliman_sim_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status expect(attempt *a) {
    return toliman_sim_expect(small_sim(), 1e-3, (double *)a->out, SMALL);
}
static toliman_status propagate(attempt *a) {
    return toliman_sim_propagate(small_sim(), 1e-3, (double *)a->out, SMALL);
}
static toliman_status frame(attempt *a) {
    return toliman_sim_frame(a->object, &(double){1e-3}, 2, 5, 1, (double *)a->out);
}
static toliman_status late_frame(attempt *a) {
    return toliman_sim_frame(a->object, &(double){1e-3}, 2, 19000, 1, (double *)a->out);
}
static toliman_status frame_many(attempt *a) {
    return toliman_sim_frame(small_sim(), NULL, 2, 0, FRAMES, (double *)a->out);
}
static toliman_status get_image(attempt *a) {
    return toliman_sim_get_image(small_sim(), TOLIMAN_SIM_IMAGE_FOCUS, (double *)a->out, SMALL);
}
static toliman_status get_derivative(attempt *a) {
    return toliman_sim_get_derivative(a->object, "zernike_7", (double *)a->out, SMALL);
}
static toliman_status get_opd_gradient(attempt *a) {
    return toliman_sim_get_opd_gradient(small_sim(), small_frames(), SMALL, (double *)a->out);
}
static toliman_status get_parameters(attempt *a) {
    size_t count = 0;
    return toliman_sim_get_parameters((void *)a->out, 128, &count);
}
static toliman_status get_info(attempt *a) {
    return toliman_sim_get_info(small_sim(), (void *)a->out);
}
static toliman_status get_plan(attempt *a) {
    toliman_sim_plan_info *const out = (void *)a->out;
    return without_seconds(toliman_sim_get_plan(small_sim(), out), out);
}
static toliman_status get_stages(attempt *a) {
    static const toliman_sim_plan_info plan = {.struct_size = sizeof plan, .stages = 1};
    size_t count = 0;
    return toliman_sim_get_stages(&plan, (void *)a->out, 32, &count);
}
static toliman_status get_bounds(attempt *a) {
    return toliman_sim_get_bounds(small_sim(), (void *)a->out);
}
static const toliman_sim_budget_options kBudget = {.struct_size = sizeof kBudget, .free_names = "flux_a shift_x"};
static toliman_status get_budget(attempt *a) {
    return toliman_sim_get_budget(small_sim(), &kBudget, (void *)a->out);
}
static toliman_status get_budget_steps(attempt *a) {
    size_t count = 0;
    return toliman_sim_get_budget_steps(small_sim(), NULL, (void *)a->out, 16, &count);
}
static toliman_status get_budget_rows(attempt *a) {
    size_t count = 0;
    double *const correlations = (double *)(a->out + 128 * sizeof(toliman_sim_budget_row));
    return toliman_sim_get_budget_rows(small_sim(), &kBudget, correlations, 3, (void *)a->out, 128, &count);
}
static toliman_status get_offsets(attempt *a) {
    return toliman_sim_get_offsets(small_sim(), (void *)a->out);
}
static toliman_status get_pupil(attempt *a) {
    double *const out = (double *)a->out;
    return toliman_sim_get_pupil(small_sim(), out, out + SAMPLES * SAMPLES);
}
static toliman_status get_series(attempt *a) {
    double *const out = (double *)a->out;
    return toliman_sim_get_series(small_sim(), 0, 50, out, out + 50);
}
static toliman_status get_spectrum(attempt *a) {
    double *const out = (double *)a->out;
    return toliman_sim_get_spectrum(small_sim(), 5, out, out + 5, out + 10, out + 15);
}

static void *make_binary(void) {
    return sim_of(binary_text());
}
static void *make_everything(void) {
    return sim_of(everything_text());
}
static void *make_orbit(void) {
    return sim_of(orbit_text());
}

#define PARTIAL "sim.h: after an error, images may hold some of the frames"

static const scenario all[] = {
    {.function = "toliman_sim_create_file", .call = create, .made = &sims, .stage = put_files},
    {.function = "toliman_sim_create_json", .call = create_json, .made = &sims, .stage = put_texts},
    {.function = "toliman_sim_create_json",
     "half a scene",
     create_half,
     .made = &sims,
     .stage = put_texts,
     .refused = TOLIMAN_E_FORMAT},
    {.function = "toliman_sim_create_json",
     "impossible",
     create_impossible,
     .made = &sims,
     .stage = put_texts,
     .refused = TOLIMAN_E_SCENE},
    {.function = "toliman_sim_create_json", "threads", create_threads, .made = &sims, .stage = put_texts, .slow = 1},
    {.function = "toliman_sim_create_json",
     "everything",
     create_everything,
     .made = &sims,
     .stage = put_texts,
     .slow = 1},
    {.function = "toliman_sim_create_json", "orbit", create_orbit, .made = &sims, .stage = put_texts, .slow = 1},
    {.function = "toliman_sim_create_json", "padded FFT", create_fft, .made = &sims, .stage = put_texts, .slow = 1},
    {.function = "toliman_sim_plan_file",
     .call = plan,
     .struct_size = sizeof(toliman_sim_plan_info),
     .stage = put_files},
    {.function = "toliman_sim_plan_json", .call = plan_json, .struct_size = sizeof(toliman_sim_plan_info)},
    {.function = "toliman_sim_destroy", .call = destroy, .make = make_everything, .of = &sims},
    {.function = "toliman_sim_expect", .call = expect},
    {.function = "toliman_sim_propagate", .call = propagate},
    {.function = "toliman_sim_frame", .call = frame, .make = make_binary, .of = &sims, .partial = PARTIAL},
    {.function = "toliman_sim_frame", "systematics", frame, make_everything, &sims, .slow = 1, .partial = PARTIAL},
    {.function = "toliman_sim_frame", "orbit", late_frame, make_orbit, &sims, .slow = 1, .partial = PARTIAL},
    {.function = "toliman_sim_frame", "many", frame_many, .partial = PARTIAL},
    {.function = "toliman_sim_get_image", .call = get_image},
    {.function = "toliman_sim_get_derivative", .call = get_derivative, .make = make_binary, .of = &sims},
    {.function = "toliman_sim_get_opd_gradient", .call = get_opd_gradient},
    {.function = "toliman_sim_get_parameters", .call = get_parameters, .struct_size = sizeof(toliman_sim_parameter)},
    {.function = "toliman_sim_get_info", .call = get_info, .struct_size = sizeof(toliman_sim_info)},
    {.function = "toliman_sim_get_plan", .call = get_plan, .struct_size = sizeof(toliman_sim_plan_info)},
    {.function = "toliman_sim_get_stages", .call = get_stages, .struct_size = sizeof(toliman_sim_stage)},
    {.function = "toliman_sim_get_bounds", .call = get_bounds, .struct_size = sizeof(toliman_sim_bounds)},
    {.function = "toliman_sim_get_budget", .call = get_budget, .struct_size = sizeof(toliman_sim_budget)},
    {.function = "toliman_sim_get_budget_steps",
     .call = get_budget_steps,
     .struct_size = sizeof(toliman_sim_budget_step)},
    {.function = "toliman_sim_get_budget_rows",
     .call = get_budget_rows,
     .struct_size = sizeof(toliman_sim_budget_row),
     .slow = 1},
    {.function = "toliman_sim_get_offsets", .call = get_offsets, .struct_size = sizeof(toliman_sim_offsets)},
    {.function = "toliman_sim_get_pupil", .call = get_pupil},
    {.function = "toliman_sim_get_series", .call = get_series},
    {.function = "toliman_sim_get_spectrum", .call = get_spectrum},
};
SCENARIO_LIST(sim_scenarios, all);
