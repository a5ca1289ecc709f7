/* Calls every public function while memory or file calls fail: one call after the other, once or from that call on. The
 * function must return the error or succeed with the usual result. After an error its arguments must be unchanged,
 * nothing may leak, and the next call must succeed.
 *
 *   faults SYMBOLS memory|files [all] [FUNCTION]
 *
 * SYMBOLS is lib/api/toliman.sym; each of its functions must have a scenario. Without `all`, the step between tested
 * calls grows with their number. */
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "failing.h"
#include "scenario.h"

static const scenario_list *const lists[] = {
    &base_scenarios,          &sim_scenarios,       &cae_scenarios,    &linear_scenarios, &fit_scenarios,
    &bank_scenarios,          &calibrate_scenarios, &period_scenarios, &track_scenarios,  &ingest_scenarios,
    &ingest_time_scenarios,   &mask_scenarios,      &planet_scenarios, &series_scenarios, &sky_scenarios,
    &track_reduced_scenarios, &measure_scenarios};
enum { LISTS = sizeof lists / sizeof *lists };

/* The current scenario and failure, for messages. */
static const scenario *now;
static char failure[120] = "";
static long runs, failed_calls;
static int defects;

static void complain(const char *when, const char *what, toliman_status status) {
    defects++;
    fprintf(stderr, "%s%s%s: %s%s [%s; %s failed]: %s \"%s\"\n", now->function, now->variant ? ", " : "",
            now->variant ? now->variant : "", when, what, failure, failed_call(), toliman_constant_name(status),
            toliman_last_error());
}

void must(int holds, const char *what) {
    if (!holds)
        complain("", what, TOLIMAN_OK);
}

/* The temporary folder. */
static char folder[200];

const char *in_folder(const char *name) {
    static char paths[8][300];
    static unsigned turn;
    char *const path = paths[turn++ % 8];
    snprintf(path, sizeof *paths, "%s/%s", folder, name);
    return path;
}

static void require(int holds, const char *what, const char *name) {
    if (holds)
        return;
    fprintf(stderr, "faults: %s: %s: %s\n", name, what, strerror(errno));
    exit(2);
}

void write_file(const char *name, const void *bytes, size_t size) {
    FILE *const file = fopen(in_folder(name), "wb");
    require(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0, "cannot be written", name);
}

size_t read_file(const char *name, void *bytes, size_t capacity) {
    FILE *const file = fopen(in_folder(name), "rb");
    if (file == NULL)
        return SIZE_MAX;
    const size_t size = fread(bytes, 1, capacity, file);
    fclose(file);
    return size;
}

static int entries(const char *path, int end) {
    int count = 0;
    DIR *const open = opendir(path);
    require(open != NULL, "cannot be opened", path);
    for (const struct dirent *entry; (entry = readdir(open)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            count++;
            if (end && unlinkat(dirfd(open), entry->d_name, 0) != 0)
                require(entries(in_folder(entry->d_name), 1) >= 0 && rmdir(in_folder(entry->d_name)) == 0,
                        "cannot be removed", entry->d_name);
        }
    closedir(open);
    return count;
}

int files_in(const char *name) {
    return entries(in_folder(name), 0);
}

void empty_folder(const char *name) {
    require(mkdir(in_folder(name), 0700) == 0 || errno == EEXIST, "cannot be created", name);
    entries(in_folder(name), 1);
}

void must_be_old_or_new(const char *where, const char *name, const char *mark, toliman_status status) {
    static char text[20000];
    const size_t size = read_file(name, text, sizeof text - 1);
    text[size < sizeof text ? size : 0] = '\0';
    const int is_old = strcmp(text, "old") == 0;
    const char *const end_of_text = strrchr(text, '}');
    const int is_new = strstr(text, mark) != NULL && end_of_text != NULL && strlen(end_of_text) <= 2;
    must(status == TOLIMAN_OK ? is_new : is_new || is_old, "neither the old file nor the new one");
    must(files_in(where) == 1 || status == TOLIMAN_E_WRITE, "another file is left");
}

static const saved_file *last_put;

void keep_file(const char *name, saved_file *kept) {
    kept->bytes = malloc(OUT_CAPACITY);
    kept->size = read_file(name, kept->bytes, OUT_CAPACITY);
    require(kept->size > 0 && kept->size < OUT_CAPACITY, "has an unexpected size", name);
}

void put_file_again(const char *name, const saved_file *kept) {
    write_file(name, kept->bytes, kept->size);
    last_put = kept;
}

void must_begin_as_put(const char *name) {
    unsigned char *const found = malloc(OUT_CAPACITY);
    const size_t size = read_file(name, found, OUT_CAPACITY);
    must(size != SIZE_MAX && size >= last_put->size && memcmp(found, last_put->bytes, last_put->size) == 0,
         "what the file had is lost");
    free(found);
}

/* A call without failures, and its expected results. */
typedef struct {
    uint64_t before, after, made;
    long files; /* number of file calls */
} reference;

static _Alignas(64) unsigned char out[OUT_CAPACITY], untouched[OUT_CAPACITY], right[OUT_CAPACITY];

static void begin(attempt *a) {
    if (now->stage != NULL)
        now->stage();
    memset(out, UNTOUCHED, sizeof out);
    if (now->struct_size != 0)
        memcpy(out, &now->struct_size, sizeof now->struct_size);
    memcpy(untouched, out, sizeof out);
    *a = (attempt){now->make != NULL ? now->make() : NULL, untouched, out};
}

static uint64_t digest_of(const object_kind *of, const void *object) {
    return of != NULL && object != NULL ? of->digest(object) : 0;
}

static int created_something(const attempt *a) {
    return a->made != untouched;
}

static void end(attempt *a) {
    if (now->made != NULL && created_something(a))
        now->made->end(a->made);
    if (now->of != NULL && a->object != NULL)
        now->of->end(a->object);
}

static reference result_of(const attempt *a) {
    const reference result = {0, digest_of(now->of, a->object),
                              now->made != NULL && created_something(a) ? digest_of(now->made, a->made) : 0, 0};
    return result;
}

/* Compares the results of a successful call with those of the undisturbed call. */
static void compare(const attempt *a, const reference *good, const char *when) {
    const reference result = result_of(a);
    if (memcmp(out, right, sizeof out) != 0)
        complain(when, "outputs differ", TOLIMAN_OK);
    if (result.made != good->made)
        complain(when, "the created object differs", TOLIMAN_OK);
    if (result.after != good->after)
        complain(when, "the object differs", TOLIMAN_OK);
}

static reference undisturbed_call(void) {
    attempt a;
    begin(&a);
    const uint64_t before = digest_of(now->of, a.object);
    arm(FAIL_FILES, LONG_MAX, 0, EIO);
    const toliman_status status = now->call(&a);
    const long files = disarm();
    if (status != now->refused)
        complain("", "unexpected status without a failure", status);
    reference good = result_of(&a);
    good.before = before;
    memcpy(right, out, sizeof out);
    good.files = files;
    end(&a);
    return good;
}

static int open_files(void) {
    return entries("/proc/self/fd", 0);
}

static void check_failure(const attempt *a, toliman_status status, enum what what) {
    const int expected =
        what == FAIL_MEMORY ? status == TOLIMAN_E_MEMORY : status == TOLIMAN_E_WRITE || status == TOLIMAN_E_NOT_FOUND;
    if (!expected)
        complain("", "unexpected error status", status);
    if (created_something(a))
        complain("", "an object was created", status);
    if (now->partial == NULL && memcmp(out, untouched, sizeof out) != 0)
        complain("", "outputs were modified", status);
}

/* Interrupted and short calls are retried. A failing close may be ignored only where the file was read or is synced. */
static int may_be_silent(int error) {
    return error == EINTR || error == SHORT_COUNT || strcmp(failed_call(), "close") == 0;
}

/* One call with one failure; returns whether the failing call was reached. */
static int attempt_once(const reference *good, enum what what, long at, int permanent, int error) {
    attempt a;
    const int files = open_files();
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
    if (now->check != NULL)
        now->check(&a, status);
    if (status != now->refused) {
        if (now->partial == NULL && digest_of(now->of, a.object) != good->before)
            complain("", "the object was modified", status);
        memcpy(out, untouched, sizeof out);
        if ((status = now->call(&a)) != now->refused)
            complain("", "unexpected status of the repeated call", status);
        else
            compare(&a, good, "after the repeated call, ");
    }
    end(&a);
    if (open_files() != files)
        complain("", "files are left open", status);
    return calls > at;
}

/* For slow functions the short form tests few calls, alternating between single and permanent failures. */
static int is_sparse(int all) {
    return now->slow && !all;
}

static long first(int permanent, int all) {
    return is_sparse(all) ? permanent : 0;
}

static long next(long at, int all) {
    return at + 1 + (all ? 0 : now->slow ? 8 * at + 3 : at < 6 ? 0 : at / 2);
}

static void run_memory(int all) {
    const reference good = undisturbed_call();
    for (int permanent = 0; permanent < 2; permanent++)
        for (long at = first(permanent, all), more = 1; more; at = next(at, all)) {
            snprintf(failure, sizeof failure, "allocation %ld%s", at, permanent ? " and all that follow" : "");
            watch_memory();
            more = attempt_once(&good, FAIL_MEMORY, at, permanent, 0);
            if (more && now->allocates_nothing)
                complain("", "the call allocates memory", TOLIMAN_OK);
            if (blocks_held() != 0) {
                char text[60];
                snprintf(text, sizeof text, "%ld blocks of memory are leaked", blocks_held());
                complain("", text, TOLIMAN_OK);
            }
        }
}

static void run_files(int all) {
    static const struct {
        int error, permanent;
        const char *name;
    } failures[] = {{EIO, 0, "EIO"},
                    {EIO, 1, "EIO"},
                    {ENOSPC, 0, "ENOSPC"},
                    {ENOSPC, 1, "ENOSPC"},
                    {EINTR, 0, "EINTR"},
                    {SHORT_COUNT, 0, "a short count"},
                    {SHORT_COUNT, 1, "a short count"}};
    const reference good = undisturbed_call();
    for (size_t i = 0; good.files > 0 && i < sizeof failures / sizeof *failures; i += is_sparse(all) ? 3 : 1)
        for (long at = first(failures[i].permanent, all), more = 1; more; at = next(at, all)) {
            snprintf(failure, sizeof failure, "%s of call %ld%s", failures[i].name, at,
                     failures[i].permanent ? " and all that follow" : "");
            more = attempt_once(&good, FAIL_FILES, at, failures[i].permanent, failures[i].error);
        }
}

static int has_scenario(const char *function) {
    for (size_t i = 0; i < LISTS; i++)
        for (size_t j = 0; j < lists[i]->count; j++)
            if (strcmp(lists[i]->first[j].function, function) == 0)
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
        if (sscanf(line, " toliman_%[a-z_];", function) != 1)
            continue;
        char whole[210];
        snprintf(whole, sizeof whole, "toliman_%s", function);
        count++;
        if (has_scenario(whole))
            continue;
        fprintf(stderr, "%s has no scenario\n", whole);
        defects++;
    }
    fclose(file);
    return count;
}

int main(int count, char **arguments) {
    if (count < 3)
        return 2;
    const int memory = strcmp(arguments[2], "memory") == 0, all = count > 3 && strcmp(arguments[3], "all") == 0;
    const char *const only = count > 3 + all ? arguments[3 + all] : NULL;
    int chosen = 0;
    const int functions = check_all_have_scenarios(arguments[1]);
    const char *const above = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/toliman-faults-XXXXXX", above != NULL ? above : "/tmp");
    require(mkdtemp(folder) != NULL, "cannot be created", folder);
    for (size_t i = 0; i < LISTS; i++)
        for (size_t j = 0; j < lists[i]->count; j++) {
            now = &lists[i]->first[j];
            if (only != NULL && strcmp(only, now->function) != 0)
                continue;
            (memory ? run_memory : run_files)(all);
            chosen++;
        }
    printf("%d functions, %ld calls, %ld of them with a failure: %d defects\n", functions, runs, failed_calls, defects);
    entries(folder, 1);
    rmdir(folder);
    return defects != 0 || functions == 0 || chosen == 0;
}
