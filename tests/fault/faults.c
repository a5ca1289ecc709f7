/* Calls every public function while memory or file calls fail: one call after the other, once or from that call on. The
 * function must return the error or succeed with the usual result. After an error its arguments must be unchanged,
 * nothing may leak, and the next call must succeed. Or calls it from two threads at once, with `all` from eight, on the
 * same object if it is const: each must get the usual result.
 *
 *   faults SYMBOLS memory|files|threads [all] [FUNCTION]
 *
 * SYMBOLS is lib/api/toliman.sym; each of its functions must have a scenario. Without `all`, the first and the last
 * call fail, and some between them. */
#include <errno.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "attempts.h"

static long runs, failed_calls;

static void check_failure(const attempt *a, toliman_status status, enum what what) {
    const int expected =
        what == FAIL_MEMORY ? status == TOLIMAN_E_MEMORY : status == TOLIMAN_E_WRITE || status == TOLIMAN_E_NOT_FOUND;
    if (!expected)
        complain("", "unexpected error status", status);
    if (created_something(a))
        complain("", "an object was created", status);
    if (now->partial == NULL && !is_untouched(a))
        complain("", "outputs were modified", status);
}

/* Interrupted and short calls are retried. A failing close may be ignored only where the file was read or is synced. */
static int may_be_silent(int error) {
    return error == EINTR || error == SHORT_COUNT || strcmp(failed_call(), "close") == 0;
}

/* One call with one failure; returns the number of calls that could fail. */
static long attempt_once(const reference *good, enum what what, long at, int permanent, int error) {
    attempt a;
    const int files = files_in("/proc/self/fd");
    begin(&a);
    arm(what, at, permanent, error);
    toliman_status status = now->call(&a);
    const long calls = disarm();
    runs++;
    failed_calls += calls > at;
    if (status == now->refused && what == FAIL_FILES && calls > at && !may_be_silent(error))
        complain("", "the failure is not reported", status);
    if (status == now->refused)
        compare(&a, good, "after a success, ");
    else
        check_failure(&a, status, what);
    check_files(&a, good, status);
    if (status != now->refused) {
        if (now->partial == NULL && !is_unmodified(&a, good))
            complain("", "the object was modified", status);
        clear_outputs(&a);
        if ((status = now->call(&a)) != now->refused)
            complain("", "unexpected status of the repeated call", status);
        else
            compare(&a, good, "after the repeated call, ");
    }
    end(&a);
    if (files_in("/proc/self/fd") != files)
        complain("", "files are left open", status);
    return calls;
}

static long attempt_memory(const reference *good, long at, int permanent, int error) {
    watch_memory();
    const long calls = attempt_once(good, FAIL_MEMORY, at, permanent, error);
    if (calls > at && now->allocates_nothing)
        complain("", "the call allocates memory", TOLIMAN_OK);
    if (blocks_held() != 0) {
        char text[60];
        snprintf(text, sizeof text, "%ld blocks of memory are leaked", blocks_held());
        complain("", text, TOLIMAN_OK);
    }
    return calls;
}

static long attempt_files(const reference *good, long at, int permanent, int error) {
    return attempt_once(good, FAIL_FILES, at, permanent, error);
}

/* How a call fails. */
typedef struct {
    const char *name;
    int error, permanent;
} kind_of_failure;

typedef struct {
    enum what what;
    long (*attempt_one)(const reference *good, long at, int permanent, int error);
    kind_of_failure kinds[7];
    size_t count;
} campaign;

static long fail_at(const reference *good, const campaign *of, size_t kind, long at) {
    const kind_of_failure *const how = &of->kinds[kind % of->count];
    snprintf(failure, sizeof failure, "%s %ld%s", how->name, at, how->permanent ? " and all that follow" : "");
    return of->attempt_one(good, at, how->permanent, how->error);
}

/* Lets each of the first calls fail, then steps of a hundredth or a tenth, as a search allocates a million times, and
 * the last one. */
static void fail_many(const reference *good, const campaign *of, size_t kind) {
    const long each = now->slow || good->calls > 5000 ? 100 : 1000;
    long seen = LONG_MAX;
    for (long at = 0; seen > at; at += at < each ? 1 : 10 * at / each)
        seen = fail_at(good, of, kind, at);
    if (good->calls > each)
        fail_at(good, of, kind, good->calls - 1);
}

/* The short form: with growing steps, for slow functions larger ones, and the last, each failing in another way. */
static void fail_some(const reference *good, const campaign *of) {
    size_t kind = 0;
    for (long at = 0; at < good->calls - 1; at = now->slow ? 9 * at + 4 : at + 1 + (at < 6 ? 0 : at / 2))
        fail_at(good, of, 3 * kind++, at);
    for (long last = good->calls, seen = 0; last > 0 && (seen = fail_at(good, of, 3 * kind, last - 1)) < last;
         last = seen)
        ; /* the undisturbed call may have created shared objects */
}

static void run(const campaign *of, int all) {
    reference good = undisturbed_call(of->what);
    if (good.calls == 0 && of->what == FAIL_MEMORY)
        fail_at(&good, of, 0, 0); /* which detects leaks */
    else if (!all)
        fail_some(&good, of);
    for (size_t kind = 0; all && kind < of->count && good.calls > 0; kind++)
        fail_many(&good, of, kind);
    end_of_calls(&good);
}

static void run_memory(int all) {
    static const campaign of = {FAIL_MEMORY, attempt_memory, {{"allocation", ENOMEM, 0}, {"allocation", ENOMEM, 1}}, 2};
    run(&of, all);
}

static void run_files(int all) {
    static const campaign of = {FAIL_FILES,
                                attempt_files,
                                {{"EIO of call", EIO, 0},
                                 {"EIO of call", EIO, 1},
                                 {"ENOSPC of call", ENOSPC, 0},
                                 {"ENOSPC of call", ENOSPC, 1},
                                 {"EINTR of call", EINTR, 0},
                                 {"a short count of call", SHORT_COUNT, 0},
                                 {"a short count of call", SHORT_COUNT, 1}},
                                7};
    run(&of, all);
}

/* A call of one of the threads. */
typedef struct {
    pthread_t thread;
    pthread_barrier_t *together;
    attempt a;
    toliman_status status;
    int index;
} caller;

static void *call_together(void *given) {
    caller *const own = given;
    use_folder(own->index);
    pthread_barrier_wait(own->together);
    own->status = now->call(&own->a);
    return NULL;
}

static void call_at_once(const reference *good, int threads) {
    caller callers[MOST_THREADS];
    pthread_barrier_t together;
    pthread_barrier_init(&together, NULL, (unsigned)threads);
    for (int i = threads; i-- > 0;) { /* the object of all, if it is const, is in the first folder */
        callers[i].index = i;
        callers[i].together = &together;
        use_folder(i);
        begin_in(&callers[i].a, i, i > 0 && now->is_const ? &together : NULL);
    }
    for (int i = 1; i < threads && now->is_const; i++)
        callers[i].a.object = callers[0].a.object;
    for (int i = 0; i < threads; i++)
        require(pthread_create(&callers[i].thread, NULL, call_together, &callers[i]) == 0, "no thread", now->function);
    for (int i = 0; i < threads; i++)
        pthread_join(callers[i].thread, NULL);
    for (int i = threads; i-- > 0;) {
        use_folder(i);
        if (callers[i].status != now->refused)
            complain("", "unexpected status", callers[i].status);
        else
            compare(&callers[i].a, good, "with other threads, ");
        check_files(&callers[i].a, good, callers[i].status);
        if (i > 0 && now->is_const)
            callers[i].a.object = NULL;
        end(&callers[i].a);
        runs++;
    }
    pthread_barrier_destroy(&together);
}

static void run_threads(int all) {
    reference good = undisturbed_call(FAIL_NOTHING);
    for (int round = all ? 20 : now->slow || !now->is_const ? 1 : 3; round > 0; round--)
        call_at_once(&good, all ? MOST_THREADS : 2);
    end_of_calls(&good);
}

static int has_scenario(const char *function) {
    for (size_t i = 0; i < scenario_count; i++)
        if (strcmp(scenarios[i]->function, function) == 0)
            return 1;
    return 0;
}

/* Returns the number of public functions. */
static int check_all_have_scenarios(const char *symbols) {
    char line[200], function[200];
    int count = 0;
    FILE *const file = fopen(symbols, "r");
    require(file != NULL, "cannot be opened", symbols);
    while (fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, " %199[a-z0-9_];", function) != 1 || strncmp(function, "toliman_", 8) != 0)
            continue;
        count++;
        if (has_scenario(function))
            continue;
        fprintf(stderr, "%s has no scenario\n", function);
        defects++;
    }
    fclose(file);
    return count;
}

/* promises: failed-calls-change-nothing, file-failures-are-survived, files-are-replaced-atomically */
/* promise: memory-failures-are-survived */
int main(int count, char **arguments) {
    static const struct {
        const char *name;
        void (*run)(int all);
    } modes[] = {{"memory", run_memory}, {"files", run_files}, {"threads", run_threads}};
    const int all = count > 3 && strcmp(arguments[3], "all") == 0;
    const char *const only = count > 3 + all ? arguments[3 + all] : NULL;
    size_t mode = 0;
    while (mode < 3 && (count < 3 || strcmp(arguments[2], modes[mode].name) != 0))
        mode++;
    if (mode == 3)
        return 2;
    int chosen = 0;
    const int functions = check_all_have_scenarios(arguments[1]);
    create_folders(MOST_THREADS);
    for (size_t i = 0; i < scenario_count; i++) {
        now = scenarios[i];
        if (only != NULL && strcmp(only, now->function) != 0)
            continue;
        modes[mode].run(all);
        chosen++;
    }
    printf("%d functions, %ld calls, %ld of them with a failure: %d defects\n", functions, runs, failed_calls, defects);
    remove_folders();
    return defects != 0 || functions == 0 || chosen == 0;
}
