/* Tests journals of calibrations: after any interruption, damage and with more iterations the bits of an undisturbed
 * call; what is refused. */
#include <sys/stat.h>

#include "calibrate_group.h"
#include "crc32.h"

static char path[400];

typedef struct {
    int calls, cancel_at, recalled;
    double last; /* chi-square of the last step from the journal */
} steps;

static int32_t watch(const toliman_calibration *so_far, const toliman_calibration_step *step, void *user_data) {
    (void)so_far;
    steps *const all = user_data;
    all->recalled += step->recalled != 0;
    all->last = step->recalled != 0 ? step->chi_square : all->last;
    return ++all->calls == all->cancel_at;
}

static toliman_status run(steps *all, int32_t most_iterations, toliman_calibration **made) {
    const toliman_calibration_options options = {.struct_size = sizeof options,
                                                 .free = kKnown,
                                                 .journal = path,
                                                 .step = watch,
                                                 .step_data = all,
                                                 .most_iterations = most_iterations};
    return toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, made);
}

static void begin(void) {
    snprintf(path, sizeof path, "%s", in_folder("c.part"));
    remove(path);
}

static int64_t size_of_journal(void) {
    struct stat file;
    return stat(path, &file) == 0 ? file.st_size : -1;
}

/* Cancelled after each step in turn. */
/* promise: journals-continue-calibrations */
TEST(each_call_continues) {
    toliman_calibration *made = NULL;
    const int32_t iterations = calibrate_info_of(whole).iterations;
    begin();
    for (int cancel_at = 1; cancel_at < iterations; cancel_at++) {
        steps all = {.cancel_at = cancel_at};
        assert_refused(run(&all, 0, &made), TOLIMAN_E_CANCELLED, "");
        assert_int_equal(all.recalled, cancel_at - 1);
    }
    steps all = {.cancel_at = 0};
    assert_ok(run(&all, 0, &made));
    assert_int_equal(all.calls, iterations);
    assert_int_equal(all.recalled, iterations - 1);
    assert_same(whole, made);
    toliman_calibration_destroy(made);
}

/* promise: journals-continue-calibrations */
TEST(more_iterations_continue) {
    toliman_calibration *made = NULL;
    steps all = {.cancel_at = 0};
    begin();
    assert_ok(run(&all, 2, &made));
    assert_int_equal(calibrate_info_of(made).flags, TOLIMAN_CALIBRATION_NOT_CONVERGED);
    toliman_calibration_destroy(made);
    all = (steps){.cancel_at = 0};
    assert_ok(run(&all, 0, &made));
    assert_int_equal(all.recalled, 2);
    assert_same(whole, made);
    toliman_calibration_destroy(made);
}

/* A journal that ends anywhere, as after a kill or a power cut, or with any byte changed. */
/* promise: journals-continue-calibrations */
TEST(damage_costs_time_only) {
    enum { CASES = 4 };
    toliman_calibration *made = NULL;
    steps all = {.cancel_at = 4};
    begin();
    assert_refused(run(&all, 0, &made), TOLIMAN_E_CANCELLED, "");
    const int64_t size = size_of_journal();
    unsigned char *const bytes = malloc((size_t)size);
    FILE *file = fopen(path, "rb");
    assert_int_equal(fread(bytes, 1, (size_t)size, file), size);
    fclose(file);
    for (int i = 0; i < CASES; i++) {
        const int64_t at = i == 0 ? 10 : size * i / CASES; /* 0: in the header */
        const int is_flip = i % 2 == 1;
        file = fopen(path, "wb");
        bytes[at] ^= is_flip ? 0x10 : 0;
        fwrite(bytes, 1, (size_t)(is_flip ? size : at), file);
        bytes[at] ^= is_flip ? 0x10 : 0;
        fclose(file);
        all = (steps){.cancel_at = 0};
        assert_ok(run(&all, 0, &made));
        assert_same(whole, made);
        assert_true(all.recalled < 5);
        toliman_calibration_destroy(made);
    }
    free(bytes);
}

static int32_t call_again(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused) {
    (void)so_far, (void)step, (void)unused;
    toliman_calibration *second = NULL;
    steps all = {.cancel_at = 0};
    assert_refused(run(&all, 0, &second), TOLIMAN_E_STATE, path);
    return 1;
}

/* Writes another number of the version into the header, with its checksum. */
static void change_version(void) {
    enum { INPUTS = 6, AT = 16, HEADER = AT + 8 * INPUTS };
    uint8_t header[HEADER + 4];
    FILE *const file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fread(header, 1, sizeof header, file), sizeof header);
    assert_int_equal(header[AT] | header[AT + 1] << 8, TOLIMAN_VERSION_NUMBER);
    header[AT]++;
    const uint32_t crc = crc32_of(header, HEADER);
    for (int i = 0; i < 4; i++)
        header[HEADER + i] = (uint8_t)(crc >> 8 * i);
    rewind(file);
    assert_int_equal(fwrite(header, 1, sizeof header, file), sizeof header);
    fclose(file);
}

/* promise: other-versions-are-refused */
TEST(other_versions_are_refused) {
    toliman_calibration *made = NULL;
    steps all = {.cancel_at = 1};
    begin();
    assert_refused(run(&all, 0, &made), TOLIMAN_E_CANCELLED, "");
    change_version();
    assert_fails(run(&all, 0, &made), TOLIMAN_E_MISMATCH, "version of the library");
}

/* promise: other-journals-are-refused */
TEST(others_are_refused) {
    static double changed[FRAMES * PIXELS];
    toliman_calibration *made = NULL;
    steps all = {.cancel_at = 1};
    begin();
    toliman_calibration_options options = {
        .struct_size = sizeof options, .free = kKnown, .journal = path, .step = call_again};
    assert_refused(toliman_calibration_create(nominal, PLAIN_IMAGE(frames), FRAMES, NULL, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    memcpy(changed, frames, sizeof changed);
    changed[FRAMES * PIXELS - 1] += 1;
    toliman_fit_prediction predictions[FRAMES] = {{.struct_size = sizeof *predictions}};
    for (int k = 0; k < FRAMES; k++)
        predictions[k].time_days = 15.0 * k + (k == 1);
    const struct {
        const toliman_sim *sim;
        const double *frames;
        size_t count;
        const toliman_fit_prediction *predictions;
        const char *free;
        double window_days;
        const toliman_sim *start;
        const char *what;
    } cases[] = {{truth, frames, FRAMES, NULL, NULL, 0, NULL, "scene"},
                 {nominal, changed, FRAMES, NULL, NULL, 0, NULL, "frames"},
                 {nominal, frames, FRAMES - 1, NULL, NULL, 0, NULL, "frames"},
                 {nominal, frames, FRAMES, predictions, NULL, 0, NULL, "frames"},
                 {nominal, frames, FRAMES, NULL, "focus scale", 0, NULL, "free parameters"},
                 {nominal, frames, FRAMES, NULL, "focus=50", 0, NULL, "free parameters"},
                 {nominal, frames, FRAMES, NULL, NULL, 20, NULL, "windows"},
                 {nominal, frames, FRAMES, NULL, NULL, 0, truth, "start"}};
    const int64_t size = size_of_journal();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        options = (toliman_calibration_options){.struct_size = sizeof options,
                                                .journal = path,
                                                .free = cases[i].free != NULL ? cases[i].free : kKnown,
                                                .window_days = cases[i].window_days,
                                                .start = cases[i].start,
                                                .step = watch,
                                                .step_data = &all};
        assert_fails(toliman_calibration_create(cases[i].sim, PLAIN_IMAGE(cases[i].frames), cases[i].count,
                                                cases[i].predictions, &options, &made),
                     TOLIMAN_E_MISMATCH, cases[i].what);
        assert_string_equal(toliman_last_error_field(), path);
    }
    assert_true(size > 0 && size_of_journal() == size);
    FILE *const file = fopen(path, "wb");
    fputs("something else that is longer than the header of a journal with six inputs, or so", file);
    fclose(file);
    assert_refused(run(&all, 0, &made), TOLIMAN_E_FORMAT, path);
    snprintf(path, sizeof path, "%s", folder);
    assert_refused(run(&all, 0, &made), TOLIMAN_E_WRITE, path);
    snprintf(path, sizeof path, "%s", in_folder("none/c.part"));
    assert_refused(run(&all, 0, &made), TOLIMAN_E_WRITE, path);
}

/* The list of times is a file that the scene names. */
static toliman_sim *sim_at_times(const char *times) {
    char *const text = calibrate_text(NULL), list[500];
    FILE *const file = fopen(in_folder("times.csv"), "w");
    assert_non_null(file);
    assert_true(fputs(times, file) >= 0 && fclose(file) == 0);
    snprintf(list, sizeof list, "\"times_days\": \"%s\"", in_folder("times.csv"));
    char *const scene = replaced(text, "\"frames\": 8, \"interval_days\": 15", list);
    toliman_sim *const sim = sim_of(scene);
    free(scene), free(text);
    return sim;
}

/* promise: other-journals-are-refused */
TEST(other_times_are_refused) {
    toliman_sim *const sims[] = {sim_at_times("0\n15\n30\n45\n"), sim_at_times("0\n15\n30\n46\n")};
    toliman_fit_prediction predictions[FRAMES] = {{.struct_size = sizeof *predictions}};
    toliman_calibration *made = NULL;
    steps all = {.cancel_at = 1};
    begin();
    for (int k = 0; k < FRAMES; k++)
        predictions[k] = (toliman_fit_prediction){.struct_size = sizeof *predictions, .time_days = 15.0 * k};
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .free = kKnown, .journal = path, .step = watch, .step_data = &all};
    assert_refused(toliman_calibration_create(sims[0], PLAIN_IMAGE(frames), FRAMES, predictions, &options, &made),
                   TOLIMAN_E_CANCELLED, "");
    assert_refused(toliman_calibration_create(sims[1], PLAIN_IMAGE(frames), FRAMES, predictions, &options, &made),
                   TOLIMAN_E_MISMATCH, path);
    for (int i = 0; i < 2; i++)
        toliman_sim_destroy(sims[i]);
}

RUN_TESTS(set_up, tear_down)
