/* A host program that watches the whole library at work, in the host's locale: which functions it must not call are
 * called and by whom (watch.c), and whether the state of the process changes. Usage: conventions report results
 * [function]
 *
 * results receives one line per computed result, which must not depend on the locale. With the name of a function, a
 * library that violates the conventions calls that function instead. */
#include <errno.h>
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cae_scene.h"
#include "images.h"
#include "samples.h"
#include "track_frames.h"
#include "watch.h"

#include <toliman/toliman.h>

enum { FRAMES = 8, SAMPLES = 200, SIGNALS = 65 };
#define PERIOD_DAYS 12.5

void call_forbidden(const char *what);
int openblas_get_num_threads(void);
extern char **environ;

static FILE *results;
static uint64_t callback_bytes;

/* FNV-1a. */
static uint64_t digest(uint64_t before, const void *data, size_t size) {
    for (size_t i = 0; i < size; i++)
        before = (before ^ ((const unsigned char *)data)[i]) * 0x100000001b3u;
    return before;
}

static void result(const char *name, const void *data, size_t size) {
    fprintf(results, "%s %016llx\n", name, (unsigned long long)digest(0xcbf29ce484222325u, data, size));
}

/* An expected failure; its message must have a decimal point in every locale. */
static void refused(const char *name, toliman_status status, toliman_status wanted) {
    if (status != wanted)
        fail_msg("%s: %s, expected %s", name, toliman_constant_name(status), toliman_constant_name(wanted));
    assert_true(toliman_last_error()[0] != 0);
    fprintf(results, "%s: %s\n", name, toliman_last_error());
}

static void count_log(int32_t level, const char *text, void *unused) {
    (void)level, (void)unused;
    callback_bytes += strlen(text);
}

static int32_t keep_going(const char *stage, double fraction, void *unused) {
    (void)fraction, (void)unused;
    callback_bytes += strlen(stage);
    return 0;
}

static int32_t stop(const char *stage, double fraction, void *unused) {
    (void)stage, (void)fraction, (void)unused;
    return 1;
}

/* State of the process that a library could change. */
typedef struct process {
    char locale[400], folder[400];
    locale_t thread_locale;
    struct sigaction actions[SIGNALS];
    sigset_t blocked;
    uint64_t environment;
    int rounding, traps, blas_threads, descriptors;
    mode_t mask;
} process;

static void *handler_of(const struct sigaction *action) {
    return *(void *const *)&action->sa_handler;
}

static process now(void) {
    process state;
    memset(&state, 0, sizeof state);
    snprintf(state.locale, sizeof state.locale, "%s", setlocale(LC_ALL, NULL));
    assert_non_null(getcwd(state.folder, sizeof state.folder));
    state.thread_locale = uselocale((locale_t)0);
    for (int i = 1; i < SIGNALS; i++)
        sigaction(i, NULL, &state.actions[i]);
    sigprocmask(SIG_SETMASK, NULL, &state.blocked);
    for (char **entry = environ; *entry != NULL; entry++)
        state.environment = digest(state.environment, *entry, strlen(*entry) + 1);
    state.rounding = fegetround();
    state.traps = fegetexcept();
    state.blas_threads = openblas_get_num_threads();
    for (int file = 0; file < 256; file++)
        state.descriptors += fcntl(file, F_GETFD) != -1;
    state.mask = umask(0);
    umask(state.mask);
    return state;
}

static void assert_unchanged(const process *before, const process *after) {
    assert_string_equal(before->locale, after->locale);
    assert_string_equal(before->folder, after->folder);
    assert_true(before->thread_locale == after->thread_locale);
    for (int i = 1; i < SIGNALS; i++) {
        assert_ptr_equal(handler_of(&before->actions[i]), handler_of(&after->actions[i]));
        assert_int_equal(before->actions[i].sa_flags, after->actions[i].sa_flags);
    }
    assert_memory_equal(&before->blocked, &after->blocked, sizeof before->blocked);
    assert_int_equal(before->environment, after->environment);
    assert_int_equal(before->rounding, after->rounding);
    assert_int_equal(before->traps, after->traps);
    assert_int_equal(before->blas_threads, after->blas_threads);
    assert_int_equal(before->descriptors, after->descriptors);
    assert_int_equal(before->mask, after->mask);
}

static void machine(void) {
    toliman_machine info = {.struct_size = sizeof info};
    assert_ok(toliman_get_machine(&info));
    refused("machine", toliman_get_machine(NULL), TOLIMAN_E_ARGUMENT);
}

/* The simulator and all estimators, with two threads each. */
static toliman_sim *simulate(double *frames, const char *folder) {
    char json[2048], path[300];
    const size_t size = write_scene(json, sizeof json, kSide, kSide, 0, "\"shift_x\"");
    toliman_sim *sim = NULL;
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.threads = 2;
    options.log = count_log;
    options.progress = stop;
    refused("cancelled scene", toliman_sim_create_json(json, size, NULL, &options, &sim), TOLIMAN_E_CANCELLED);
    options.progress = keep_going;
    assert_ok(toliman_sim_create_json(json, size, NULL, &options, &sim));
    assert_ok(toliman_sim_frame(sim, NULL, 5, 0, FRAMES, frames));
    result("frames", frames, sizeof *frames * FRAMES * kPixels);

    toliman_sim *none = NULL;
    refused("half a scene", toliman_sim_create_json(json, size / 2, NULL, NULL, &none), TOLIMAN_E_FORMAT);
    snprintf(path, sizeof path, "%s/none.json", folder);
    assert_true(toliman_sim_create_file(path, NULL, &none) == TOLIMAN_E_NOT_FOUND);
    memcpy(strstr(json, "0.125"), "-0.25", 5);
    refused("bad scene", toliman_sim_create_json(json, size, NULL, NULL, &none), TOLIMAN_E_SCENE);
    return sim;
}

static void learn(const toliman_sim *sim, const double *frames, const char *folder) {
    toliman_cae *cae = make_cae(sim, 1, 0, NULL), *again = NULL;
    toliman_cae_train_options options = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 5;
    options.progress = stop;
    refused("cancelled training", toliman_cae_train(cae, &options, NULL), TOLIMAN_E_CANCELLED);
    options.progress = keep_going;
    assert_ok(toliman_cae_train(cae, &options, NULL));
    double latents[FRAMES], image[kPixels], mmse, mssim, floor_of_noise;
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frames), FRAMES, latents, NULL));
    result("latents", latents, sizeof latents);
    assert_ok(toliman_cae_reconstruct(cae, frames, kSide, image, kSide, &mmse, &mssim, &floor_of_noise));
    result("reconstruction", image, sizeof image);
    options.learning_rate = 1.5;
    refused("learning rate", toliman_cae_train(cae, &options, NULL), TOLIMAN_E_ARGUMENT);

    char path[300];
    snprintf(path, sizeof path, "%s/weights", folder);
    assert_ok(toliman_cae_save_file(cae, NULL, path));
    assert_ok(toliman_cae_load_file(path, NULL, &again));
    assert_ok(toliman_cae_encode(again, PLAIN_IMAGE(frames), 1, &latents[1], NULL));
    result("loaded", &latents[1], sizeof *latents);
    toliman_cae_destroy(cae);
    toliman_cae_destroy(again);
}

static void fit(const toliman_sim *sim, const double *frames) {
    toliman_linear *linear = NULL;
    toliman_components *components = NULL;
    double value, series[FRAMES];
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frames), 1, &value, NULL));
    result("template", &value, sizeof value);
    toliman_linear_destroy(linear);
    assert_ok(toliman_components_create(sim, NULL, &components));
    for (int i = 0; i < FRAMES; i++)
        assert_ok(toliman_components_push(components, PLAIN_IMAGE(frames + (size_t)i * kPixels), 1));
    toliman_components_train_options options = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    options.threads = 2;
    options.progress = keep_going;
    for (options.method = TOLIMAN_COMPONENTS_PCA; options.method <= TOLIMAN_COMPONENTS_DICTIONARY; options.method++) {
        assert_ok(toliman_components_train(components, &options, NULL));
        assert_ok(toliman_components_get_series(components, 0, series, NULL));
        result("series", series, sizeof series);
    }
    toliman_components_destroy(components);
}

static void follow_stars(const toliman_sim *sim, const double *frames, const char *folder) {
    const toliman_bank_options options = {.struct_size = sizeof options, .places = 1, .steps = 3};
    const toliman_bank_train_options training = {.struct_size = sizeof training, .threads = 2, .progress = keep_going};
    toliman_fit *fit = NULL;
    toliman_bank *bank = NULL, *again = NULL;
    toliman_bank_result found[FRAMES] = {{.struct_size = sizeof *found}};
    double days;
    char path[300];
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    assert_ok(toliman_bank_create(fit, &options, &bank));
    assert_ok(toliman_bank_train(bank, fit, &training));
    snprintf(path, sizeof path, "%s/bank", folder);
    assert_ok(toliman_bank_save_file(bank, 0, path));
    assert_ok(toliman_bank_load_file(path, NULL, &again));
    assert_ok(toliman_bank_encode(again, fit, PLAIN_IMAGE(frames), FRAMES, NULL, found, NULL));
    result("bank", found, sizeof found);
    assert_ok(toliman_bank_get_renewal(again, fit, 0.5, &days));
    refused("renewal", toliman_bank_get_renewal(again, fit, 2, &days), TOLIMAN_E_ARGUMENT);
    toliman_bank_destroy(bank);
    toliman_bank_destroy(again);
    toliman_fit_destroy(fit);
}

static int32_t count_step(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused) {
    (void)so_far, (void)unused;
    callback_bytes += (uint64_t)step->iteration;
    return 0;
}

static void calibrate(const toliman_sim *sim, const double *frames, const char *folder) {
    toliman_calibration_options options = {
        .struct_size = sizeof options, .free = "scale=0.01 zernike_7=50.5", .threads = 2, .step = count_step};
    toliman_calibration *calibration = NULL, *none = NULL;
    toliman_calibration_value value = {.struct_size = sizeof value};
    char path[300];
    assert_ok(toliman_calibration_create(sim, PLAIN_IMAGE(frames), 2, NULL, &options, &calibration));
    assert_ok(toliman_calibration_get_value(calibration, 0, 0, &value));
    result("calibration", &value.value, sizeof value.value);
    snprintf(path, sizeof path, "%s/fitted.json", folder);
    assert_ok(toliman_calibration_save_file(calibration, 0, path));
    options.free = "focus=0";
    refused("prior", toliman_calibration_create(sim, PLAIN_IMAGE(frames), 2, NULL, &options, &none),
            TOLIMAN_E_ARGUMENT);
    toliman_calibration_destroy(calibration);
}

static void search(const char *folder) {
    static double t[SAMPLES], y[SAMPLES], power[3 * SAMPLES], lowest[4];
    static unsigned char bytes[200000];
    char path[300];
    size_t size, count;
    toliman_period *period = NULL, *again = NULL;
    toliman_period_peak peaks[3] = {
        {.struct_size = sizeof *peaks}, {.struct_size = sizeof *peaks}, {.struct_size = sizeof *peaks}};
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = i;
        y[i] = sin(2 * M_PI * i / PERIOD_DAYS) + 0.001 * (double)(mixed((uint64_t)i) % 1000);
    }
    assert_ok(toliman_period_create(0.01, 0.0005, 3 * SAMPLES, NULL, &period));
    assert_ok(toliman_period_push_many(period, t, y, NULL, SAMPLES));
    assert_ok(toliman_period_query_peak(period, peaks));
    assert_ok(toliman_period_query_fit(period, t, y, NULL, NULL, SAMPLES, peaks));
    assert_close(peaks->period, PERIOD_DAYS, 0.01, 0);
    assert_ok(toliman_period_query_peaks(period, peaks, 3, &count));
    result("peaks", peaks, count * sizeof *peaks);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 3 * SAMPLES, power));
    result("power", power, sizeof power);
    assert_ok(toliman_period_query_bootstrap(period, t, y, NULL, SAMPLES, NULL, 4, lowest));
    result("bootstrap", lowest, sizeof lowest);
    assert_ok(toliman_period_batch(0.01, 0.0005, 3 * SAMPLES, t, y, NULL, SAMPLES, NULL, power));
    result("batch", power, sizeof power);
    assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
    result("state", bytes, size);
    snprintf(path, sizeof path, "%s/state", folder);
    assert_ok(toliman_period_save_file(period, path));
    assert_ok(toliman_period_load_file(path, NULL, &again));
    toliman_period_destroy(again);
    bytes[size / 2] ^= 1;
    refused("damaged state", toliman_period_load(bytes, size, NULL, &again), TOLIMAN_E_FORMAT);
    refused("sigma", toliman_period_push(period, 0.5, 0.5, -0.5), TOLIMAN_E_ARGUMENT);
    toliman_period_destroy(period);
}

static void find_planets(void) {
    double t[SAMPLES], y[SAMPLES], residuals[SAMPLES], samples[8 * TOLIMAN_PLANET_COLUMNS];
    toliman_planet *planets = NULL;
    toliman_planet_candidate planet = {.struct_size = sizeof planet};
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = 5 * i;
        y[i] = sin(2 * M_PI * t[i] / 90) + 0.001 * (double)(mixed((uint64_t)i) % 1000);
    }
    const toliman_measure_data data = {.struct_size = sizeof data, .n = SAMPLES, .t = t, .y = y};
    toliman_measure *series = NULL;
    assert_ok(toliman_measure_create(&data, &series));
    toliman_planet_options options = TOLIMAN_PLANET_OPTIONS_INIT;
    options.flags = 0;
    options.prior.period_max = 150;
    options.threads = 2;
    assert_ok(toliman_planet_create(series, &options, &planets));
    assert_ok(toliman_planet_get_candidate(planets, 0, &planet));
    assert_close(planet.period[1], 90, 1, 0);
    result("planet", &planet, sizeof planet);
    assert_ok(toliman_planet_get_samples(planets, 0, 8, samples));
    result("samples", samples, sizeof samples);
    assert_ok(toliman_planet_get_residuals(planets, SAMPLES, residuals));
    result("residuals", residuals, sizeof residuals);
    toliman_planet_destroy(planets);
    t[3] = NAN;
    toliman_measure_destroy(series);
    refused("time", toliman_measure_create(&data, &series), TOLIMAN_E_ARGUMENT);
}

static void follow(const char *folder) {
    static unsigned char bytes[STATE_CAPACITY];
    size_t size;
    char place[300];
    snprintf(place, sizeof place, "%s/mission", folder);
    toliman_track_options options = small_options(place);
    options.threads = 2;
    toliman_track *track = make_track(&options), *second = NULL;
    for (int64_t id = 1; id <= 40; id++)
        push_number(track, id);
    assert_ok(toliman_track_commit(track));
    assert_ok(toliman_track_save(track));
    assert_true(toliman_track_create(&options, &second) == TOLIMAN_E_STATE);
    small_frame frame;
    make_frame(&frame, 41);
    frame.pixels[3] = 5000;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_ok(toliman_period_save(period_of(track), bytes, sizeof bytes, &size));
    result("sums", bytes, size);
    const toliman_track_info info = info_of(track);
    result("counts", &info, sizeof info);
    toliman_track_destroy(track);
    options.estimator.sigma = -0.5;
    refused("tracker's sigma", toliman_track_create(&options, &track), TOLIMAN_E_ARGUMENT);
    remove_folder(place);
}

/* Rounding modes other than to-nearest are not supported: calls must fail, and leave the mode as it is. */
static void refuse_rounding(int mode) {
    static double image[kPixels];
    double t = 0, y = 0, power[2];
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_period *period = NULL, *second = NULL;
    assert_ok(toliman_period_create(0.01, 0.1, 2, NULL, &period));
    assert_int_equal(fesetround(mode), 0);
    refused("machine", toliman_get_machine(NULL), TOLIMAN_E_UNSUPPORTED);
    refused("frame", toliman_sim_frame(sim, &(double){0}, 1, 1, 1, image), TOLIMAN_E_UNSUPPORTED);
    refused("create", toliman_period_create(0.01, 0.1, 2, NULL, &second), TOLIMAN_E_UNSUPPORTED);
    refused("push", toliman_period_push(period, t, y, 1), TOLIMAN_E_UNSUPPORTED);
    refused("batch", toliman_period_batch(0.01, 0.1, 2, &t, &y, NULL, 1, NULL, power), TOLIMAN_E_UNSUPPORTED);
    toliman_sim_destroy(sim);
    assert_int_equal(fegetround(), mode);
    assert_int_equal(fesetround(FE_TONEAREST), 0);
    assert_int_equal(count_of(period), 0);
    assert_ok(toliman_period_push(period, t, y, 1));
    toliman_period_destroy(period);
}

static void everything(const char *folder) {
    double *frames = new_image(FRAMES * kPixels);
    machine();
    toliman_sim *sim = simulate(frames, folder);
    learn(sim, frames, folder);
    fit(sim, frames);
    follow_stars(sim, frames, folder);
    calibrate(sim, frames, folder);
    toliman_sim_destroy(sim);
    search(folder);
    find_planets();
    follow(folder);
    free(frames);
    assert_true(callback_bytes > 0);
}

int main(int count, char **arguments) {
    assert_true(count >= 3);
    if (count > 3) {
        watch_into(arguments[1]);
        call_forbidden(arguments[3]);
        return 0;
    }
    results = fopen(arguments[2], "w");
    assert_non_null(results);
    assert_non_null(setlocale(LC_ALL, ""));
    fprintf(results, "decimal sign %s\n", localeconv()->decimal_point);
    char folder[256];
    make_folder(folder, sizeof folder);
    refuse_rounding(FE_UPWARD);
    refuse_rounding(FE_DOWNWARD);
    refuse_rounding(FE_TOWARDZERO);
    const process before = now();
    watch_into(arguments[1]);
    everything(folder);
    stop_watching();
    const process after = now();
    assert_unchanged(&before, &after);
    remove_folder(folder);
    fclose(results);
    return 0;
}
