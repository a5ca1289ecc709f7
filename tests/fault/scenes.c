/* Scenes, networks, fits and calibrations: what the table `scenarios` names of sim.h, cae.h, components.h, bank.h and
 * calibrate.h. */
#include "cae_scene.h"
#include "objects.h"
#include "scene_text.h"

int32_t keep_going(const char *stage, double fraction, void *unused) {
    (void)stage, (void)fraction, (void)unused;
    return 0;
}

void ignore_log(int32_t level, const char *text, void *unused) {
    (void)level, (void)text, (void)unused;
}

/* Reading the message of an error must not allocate. */
toliman_status read_message(attempt *a) {
    double power;
    (void)a;
    must(toliman_period_batch(-0.5, 1, 1, NULL, NULL, NULL, 0, NULL, &power) == TOLIMAN_E_ARGUMENT, "not refused");
    must(strstr(toliman_last_error(), "-0.5") != NULL, "the message does not name the value");
    must(strcmp(toliman_last_error_field(), "f0") == 0, "the field is not the argument");
    return TOLIMAN_OK;
}

/* Replacements, in pairs, in a text that it frees. */
static char *changed(char *text, const char *const *pairs) {
    for (; *pairs != NULL; pairs += 2)
        text = replaced_again(text, pairs[0], pairs[1]);
    return text;
}

static char *smaller(const char *scene) {
    return changed(replaced(scene, "\"pupil_samples\": 96", "\"pupil_samples\": 32"),
                   (const char *const[]){"[64, 64]", "[24, 24]", NULL});
}

static char *everything(void) {
    return changed(smaller(kBinaryScene),
                   (const char *const[]){
                       "\"peak_photons\": 1e5", "\"exposure_s\": 1", "\"relative_flux\": 3", "\"photons_per_s\": 3e6",
                       "\"temperature_k\": 5260}", "\"temperature_k\": 5260}, \"photons_per_s\": 1e6",
                       "\"pixel_scale_arcsec\": 0.2",
                       "\"pixel_scale_arcsec\": 0.2, \"pixel\": \"integrated\", \"qe\": 0.8, \"flat_rms\": 0.01,"
                       " \"gain_e_per_dn\": 2, \"bias_dn\": 100, \"full_well_e\": 1e6, \"bit_depth\": 16,"
                       " \"dark_e_per_s\": 1",
                       "\"noise\"",
                       "\"systematics\": {\"pointing_rms_px\": 1e-4, \"jitter_sigma_px\": 0.1, \"roll_rms_deg\": 1e-5,"
                       " \"scale_rms\": 1e-6, \"focus_rms_nm\": 0.01, \"flux_rms\": 1e-4},"
                       " \"preprocess\": {\"project\": [\"flux_a\", \"shift_x\", \"roll\"]}, \"noise\"",
                       NULL});
}

static char *on_orbit(void) {
    return changed(smaller(kBinaryScene),
                   (const char *const[]){
                       "{\"separation_arcsec\": 4, \"position_angle_deg\": 30}",
                       "{\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true}", "\"pixel_scale_arcsec\": 0.2",
                       "\"pixel_scale_arcsec\": 0.8", "\"pupil_samples\": 32", "\"pupil_samples\": 48",
                       "\"frames\": 100, \"interval_days\": 2", "\"frames\": 20000, \"interval_days\": 0.05", NULL});
}

static char *with_files(void) {
    return changed(smaller(kBinaryScene),
                   (const char *const[]){"\"aperture_m\"",
                                         "\"amplitude\": {\"file\": \"amplitude.npy\"}, \"aperture_m\"",
                                         "\"pupil_samples\": 32",
                                         "\"pupil_samples\": 32, \"aberrations\": {\"opd_file\": \"surface.npy\"}",
                                         "{\"kind\": \"blackbody\", \"temperature_k\": 5260}",
                                         "{\"kind\": \"table\", \"file\": \"star.csv\"}", NULL});
}

static char *clear_aperture(void) {
    return changed(replaced(kSingleScene, "\"pupil_samples\": 64", "\"pupil_samples\": 32"),
                   (const char *const[]){"[32, 32]", "[24, 24]", NULL});
}

const char *scene_text(int scene) {
    static char *texts[SCENES];
    if (texts[scene] == NULL)
        texts[scene] = scene == BINARY       ? smaller(kBinaryScene)
                       : scene == IMPOSSIBLE ? replaced(kBinaryScene, "0.125", "-0.125")
                       : scene == EVERYTHING ? everything()
                       : scene == ORBIT      ? on_orbit()
                                             : clear_aperture();
    return texts[scene];
}

static void put_map(const char *name, double value) {
    static const char header[118] = "{'descr': '<f8', 'fortran_order': False, 'shape': (32, 32), }";
    unsigned char bytes[128 + 8 * PUPIL * PUPIL];
    memcpy(bytes, "\x93NUMPY\x01\x00\x76\x00", 10);
    memcpy(bytes + 10, header, sizeof header);
    for (size_t i = 0; i < PUPIL * PUPIL; i++)
        memcpy(bytes + 128 + 8 * i, &value, sizeof value);
    write_file(name, bytes, sizeof bytes);
}

void put_scene(void) {
    static const char table[] = "wavelength_nm,photons\n540,1\n570,2\n610,1.5\n";
    char *const scene = with_files();
    write_file("scene.json", scene, strlen(scene));
    write_file("star.csv", table, sizeof table - 1);
    put_map("amplitude.npy", 0.5);
    put_map("surface.npy", 1e-9);
    free(scene);
}

static const double *frames_of(const toliman_sim *sim, size_t pixels) {
    double *const frames = new_image(FRAMES * pixels);
    assert_ok(toliman_sim_frame(sim, NULL, 1, 0, FRAMES, frames));
    return frames;
}

const toliman_sim *large_sim(void) {
    static toliman_sim *sim;
    return sim != NULL ? sim : (sim = make_sim(LARGE, LARGE, 0, "\"flux_a\""));
}

const double *small_frames(void) {
    static const double *frames;
    return frames != NULL ? frames : (frames = frames_of(shared(create_sim_json_threads), SMALL * SMALL));
}

const double *large_frames(void) {
    static const double *frames;
    return frames != NULL ? frames : (frames = frames_of(large_sim(), kPixels));
}

/* With frames far apart along an orbit. */
uint64_t digest_sim(const void *sim) {
    double frame[SMALL * SMALL];
    toliman_sim_info info = sim_info_of(sim);
    info.name = NULL; /* a different pointer for each object */
    uint64_t hash = fnv1a(FNV_START, &info, sizeof info);
    for (int64_t k = 0; k < 3; k++) {
        assert_ok(toliman_sim_frame(sim, &(double){1e-4}, 3, k * (info.frames - 1) / 2, 1, frame));
        hash = fnv1a(hash, frame, sizeof frame);
    }
    return hash;
}

/* Trainings with enough steps that all state of the optimisers is in use. */
static toliman_status give_frames(size_t first, size_t count, double *counts, void *unused) {
    (void)unused;
    memcpy(counts, large_frames() + first * kPixels, count * kPixels * sizeof *counts);
    return TOLIMAN_OK;
}

const toliman_cae_train_options *unsupervised(uint32_t epochs, uint32_t threads) {
    static _Thread_local toliman_cae_train_options options;
    options = (toliman_cae_train_options){.struct_size = sizeof options,
                                          .mode = TOLIMAN_CAE_MODE_UNSUPERVISED,
                                          .steps = epochs,
                                          .frames = give_frames,
                                          .frame_count = 3,
                                          .batch = 1,
                                          .threads = threads,
                                          .progress = keep_going};
    return &options;
}

void *make_trained(void) {
    void *const cae = create_cae();
    assert_ok(toliman_cae_train(cae, unsupervised(1, 1), NULL));
    return cae;
}

void *make_collection(void) {
    toliman_components *components = NULL;
    assert_ok(toliman_components_create(shared(create_sim_json_threads), NULL, &components));
    assert_ok(toliman_components_push(components, PLAIN_IMAGE(small_frames() + SMALL * SMALL), FRAMES - 1));
    return components;
}

void *make_trained_components(void) {
    const toliman_components_train_options options = {.struct_size = sizeof options,
                                                      .method = TOLIMAN_COMPONENTS_PCA,
                                                      .components = 2,
                                                      .iterations = 5,
                                                      .threads = 1};
    void *const components = make_collection();
    assert_ok(toliman_components_train(components, &options, NULL));
    return components;
}

uint64_t digest_components(const void *components) {
    double series[FRAMES];
    toliman_components_info info = {.struct_size = sizeof info};
    assert_ok(toliman_components_get_info(components, &info));
    uint64_t hash = fnv1a(FNV_START, &info, sizeof info);
    for (int64_t i = 0; i < info.components; i++) {
        assert_ok(toliman_components_get_series(components, i, series, NULL));
        hash = fnv1a(hash, series, (size_t)info.frames * sizeof *series);
    }
    return hash;
}

/* Journals: none, or one of a call that stopped before its end. What it has must not be lost. */
static const saved_file *last_put;

void no_journal(void) {
    empty_folder("journals");
}

static void put_journal(saved_file *kept, void (*begin)(void)) {
    no_journal();
    if (kept->size == 0) {
        begin();
        keep_file(JOURNAL, kept);
    }
    put_file(JOURNAL, kept);
    last_put = kept;
}

void check_journal(attempt *a, toliman_status status) {
    (void)a, (void)status;
    must_begin_with(JOURNAL, last_put);
}

void *make_large_fit(void) {
    const toliman_fit_options options = {.struct_size = sizeof options, .capture_px = 2, .threads = 1};
    const toliman_sim *const sim = large_sim();
    toliman_fit *fit = NULL;
    assert_ok(toliman_fit_create(&sim, NULL, 1, &options, &fit));
    return fit;
}

const toliman_frame *short_frame(void) {
    static _Thread_local toliman_frame frame;
    static _Thread_local uint16_t counts[SMALL * SMALL];
    for (int p = 0; p < SMALL * SMALL; p++)
        counts[p] = (uint16_t)fmin(65000, fmax(0, rint(small_frames()[p])));
    frame = (toliman_frame){.struct_size = sizeof frame,
                            .pixel = TOLIMAN_PIXEL_U16,
                            .session = "s",
                            .roi = "r",
                            .pixels = counts,
                            .rows = SMALL,
                            .cols = SMALL,
                            .exposure_s = 0.01};
    return &frame;
}

void *make_coadd(void) {
    const toliman_coadd_options options = {
        .struct_size = sizeof options, .range_px = 2, .threads = 1, .chi_square_max = 1e6};
    toliman_coadd *coadd = NULL;
    toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
    assert_ok(toliman_coadd_create(shared(create_fit), NULL, &options, &coadd));
    assert_ok(toliman_coadd_add(coadd, short_frame(), &outcome));
    must(outcome.verdict == TOLIMAN_COADD_VERDICT_ADDED, "a short frame is added");
    return coadd;
}

toliman_status take_sum(attempt *a) {
    toliman_frame frame = TOLIMAN_FRAME_INIT;
    toliman_coadd_sum sum = TOLIMAN_COADD_SUM_INIT;
    const toliman_status status = toliman_coadd_take(a->object, &frame, &sum);
    if (status != TOLIMAN_OK)
        return status;
    uint64_t hash = fnv1a(FNV_START, frame.pixels, sizeof(uint32_t) * SMALL * SMALL);
    hash = fnv1a(hash, sum.left_out, sizeof(uint32_t) * SMALL * SMALL);
    hash = fnv1a(hash, frame.spread, sizeof *frame.spread);
    hash = fnv1a(hash, frame.intervals, 2 * frame.interval_count * sizeof *frame.intervals);
    const int64_t numbers[] = {frame.frame_id, frame.camera_ns, sum.frames, sum.cosmic_rays, (int64_t)hash};
    memcpy(a->out, numbers, sizeof numbers);
    return status;
}

static uint8_t saved_sum[1 << 16];

size_t coadd_size(void) {
    static size_t size;
    if (size == 0) {
        toliman_coadd *const coadd = make_coadd();
        assert_ok(toliman_coadd_save(coadd, saved_sum, sizeof saved_sum, &size));
        toliman_coadd_destroy(coadd);
    }
    return size;
}

const void *coadd_bytes(void) {
    return coadd_size() > 0 ? saved_sum : NULL;
}

static int32_t stop_early(const char *what, double share, void *unused) {
    (void)what, (void)unused;
    return share >= 0.25; /* of four networks */
}

static void begin_bank(void) {
    const toliman_bank_train_options options = {
        .struct_size = sizeof options, .threads = 1, .progress = stop_early, .journal = in_folder(JOURNAL)};
    void *const bank = create_bank();
    must(toliman_bank_train(bank, shared(make_large_fit), &options) == TOLIMAN_E_CANCELLED, "a training is cancelled");
    toliman_bank_destroy(bank);
}

void put_bank_journal(void) {
    static saved_file journal;
    put_journal(&journal, begin_bank);
}

int32_t stop_step(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused) {
    (void)so_far, (void)step, (void)unused;
    return 1;
}

static void begin_calibration(void) {
    toliman_calibration *made = NULL;
    const toliman_calibration_options options = {.struct_size = sizeof options,
                                                 .free = "scale",
                                                 .capture_px = 3,
                                                 .most_iterations = 1,
                                                 .journal = in_folder(JOURNAL)};
    assert_ok(toliman_calibration_create(shared(create_sim_json_threads), PLAIN_IMAGE(small_frames()), 2, NULL,
                                         &options, &made));
    toliman_calibration_destroy(made);
}

void put_calibration_journal(void) {
    static saved_file journal;
    put_journal(&journal, begin_calibration);
}
