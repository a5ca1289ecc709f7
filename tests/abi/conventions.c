/* A host program that watches the whole library at work, in the host's locale: which functions it must not call are
 * called and by whom (watch.c), and whether the state of the process changes. It makes the calls of tests/fault in the
 * C locale, and again in the host's: the results must be the same. Usage: conventions report messages [function]
 *
 * messages receives the messages of some failures, which must have a decimal point in every locale. With the name of a
 * function, a library that violates the conventions calls that function instead. */
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "assert_close.h"
#include "attempts.h"
#include "objects.h"
#include "samples.h"
#include "watch.h"

enum { SIGNALS = 65 };

void call_forbidden(const char *what);
int openblas_get_num_threads(void);
extern char **environ;

static FILE *messages;

/* No call fails here. */
void arm(enum what what, long at, int permanent, int error) {
    (void)what, (void)at, (void)permanent, (void)error;
}
long disarm(void) {
    return 0;
}
const char *failed_call(void) {
    return "";
}

static void refused(toliman_status status, toliman_status expected) {
    if (status != expected)
        fail_msg("%s, expected %s", toliman_constant_name(status), toliman_constant_name(expected));
    assert_true(toliman_last_error()[0] != 0);
    fprintf(messages, "%s\n", toliman_last_error());
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

static process current(void) {
    process state;
    memset(&state, 0, sizeof state);
    snprintf(state.locale, sizeof state.locale, "%s", setlocale(LC_ALL, NULL));
    assert_non_null(getcwd(state.folder, sizeof state.folder));
    state.thread_locale = uselocale((locale_t)0);
    for (int i = 1; i < SIGNALS; i++)
        sigaction(i, NULL, &state.actions[i]);
    sigprocmask(SIG_SETMASK, NULL, &state.blocked);
    for (char **entry = environ; *entry != NULL; entry++)
        state.environment = fnv1a(state.environment, *entry, strlen(*entry) + 1);
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

/* Rounding modes other than to-nearest are not supported: calls must fail, and leave the mode as it is. */
/* promise: other-rounding-is-refused */
static void refuse_rounding(int mode) {
    double image[SMALL * SMALL], t = 0, y = 0, power[2];
    const toliman_sim *const sim = shared(create_sim_json_threads);
    toliman_period *period = NULL, *second = NULL;
    assert_ok(toliman_period_create(0.01, 0.1, 2, NULL, &period));
    assert_int_equal(fesetround(mode), 0);
    refused(toliman_get_machine(NULL), TOLIMAN_E_UNSUPPORTED);
    refused(toliman_sim_frame(sim, &(double){0}, 1, 1, 1, image), TOLIMAN_E_UNSUPPORTED);
    refused(toliman_period_create(0.01, 0.1, 2, NULL, &second), TOLIMAN_E_UNSUPPORTED);
    refused(toliman_period_push(period, t, y, 1), TOLIMAN_E_UNSUPPORTED);
    refused(toliman_period_batch(0.01, 0.1, 2, &t, &y, NULL, 1, NULL, power), TOLIMAN_E_UNSUPPORTED);
    assert_int_equal(fegetround(), mode);
    assert_int_equal(fesetround(FE_TONEAREST), 0);
    assert_int_equal(count_of(period), 0);
    assert_ok(toliman_period_push(period, t, y, 1));
    toliman_period_destroy(period);
}

/* Messages with numbers. */
static void refuse_numbers(void) {
    const char *const scene = scene_text(IMPOSSIBLE);
    toliman_track_options options = *in_memory();
    toliman_sim *sim = NULL;
    toliman_track *track = NULL;
    options.estimator.sigma = -0.5;
    refused(toliman_sim_create_json(scene, strlen(scene), NULL, NULL, &sim), TOLIMAN_E_SCENE);
    refused(toliman_period_push(shared(make_shifted), 0.5, 0.5, -0.5), TOLIMAN_E_ARGUMENT);
    refused(toliman_track_create(&options, &track), TOLIMAN_E_ARGUMENT);
}

/* The calls in the C locale, in which objects and files are made, and again, watched, in the host's. */
static void everything(const char *report) {
    setlocale(LC_ALL, "C");
    for (size_t i = 0; i < scenario_count; i++) {
        attempt a;
        now = scenarios[i];
        if (now->slow && now->variant != NULL)
            continue; /* which takes longer, and shows nothing new here */
        reference good = undisturbed_call(FAIL_NOTHING);
        begin(&a);
        setlocale(LC_ALL, "");
        watch_into(report);
        const toliman_status status = now->call(&a);
        stop_watching();
        setlocale(LC_ALL, "C");
        must(status == now->refused, "another status in the host's locale");
        compare(&a, &good, "in the host's locale, ");
        check_files(&a, &good, status);
        end(&a);
        end_of_calls(&good);
    }
    setlocale(LC_ALL, "");
}

int main(int count, char **arguments) {
    assert_true(count >= 3);
    if (count > 3) {
        watch_into(arguments[1]);
        call_forbidden(arguments[3]);
        return 0;
    }
    messages = fopen(arguments[2], "w");
    assert_non_null(messages);
    assert_non_null(setlocale(LC_ALL, ""));
    fprintf(messages, "decimal sign %s\n", localeconv()->decimal_point);
    create_folders(1);
    refuse_rounding(FE_UPWARD);
    refuse_rounding(FE_DOWNWARD);
    refuse_rounding(FE_TOWARDZERO);
    refuse_numbers();
    const process before = current();
    everything(arguments[1]);
    const process after = current();
    assert_unchanged(&before, &after);
    remove_folders();
    fclose(messages);
    return defects != 0;
}
