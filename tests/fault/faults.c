/* Every public function while memory or files fail it: call after call, once or from there on. It tells of the error or
 * succeeds as ever; what it was given is as before, it keeps nothing, and works the next time.
 *
 *   faults SYMBOLS memory|files [all] [FUNCTION]
 *
 * SYMBOLS is lib/api/toliman.sym, whose functions must all have a scenario. Without `all` it leaves out calls more and
 * more with their number. */
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

static const scenario_list *const lists[] = {&base_scenarios,   &sim_scenarios,    &cae_scenarios,
                                             &linear_scenarios, &period_scenarios, &track_scenarios};
enum { LISTS = sizeof lists / sizeof *lists };

/* What is running, for messages. */
static const scenario *now;
static char mishap[120] = "";
static long runs, failed_calls;
static int defects;

static void complain(const char *when, const char *what, toliman_status status) {
    defects++;
    fprintf(stderr, "%s%s%s: %s%s [%s; %s failed]: %s \"%s\"\n", now->function, now->variant ? ", " : "",
            now->variant ? now->variant : "", when, what, mishap, failed_call(), toliman_status_name(status),
            toliman_last_error());
}

void must(int holds, const char *what) {
    if (!holds)
        complain("", what, TOLIMAN_OK);
}

/* The folder. */
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
    require(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0, "not written", name);
}

size_t read_file(const char *name, void *bytes, size_t room) {
    FILE *const file = fopen(in_folder(name), "rb");
    if (file == NULL)
        return SIZE_MAX;
    const size_t size = fread(bytes, 1, room, file);
    fclose(file);
    return size;
}

static int entries(const char *path, int end) {
    int count = 0;
    DIR *const open = opendir(path);
    require(open != NULL, "not opened", path);
    for (const struct dirent *entry; (entry = readdir(open)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            count++;
            if (end && unlinkat(dirfd(open), entry->d_name, 0) != 0)
                require(entries(in_folder(entry->d_name), 1) >= 0 && rmdir(in_folder(entry->d_name)) == 0,
                        "not removed", entry->d_name);
        }
    closedir(open);
    return count;
}

int files_in(const char *name) {
    return entries(in_folder(name), 0);
}

void empty_folder(const char *name) {
    require(mkdir(in_folder(name), 0700) == 0 || errno == EEXIST, "not made", name);
    entries(in_folder(name), 1);
}

/* A call and what must come of it. */
typedef struct {
    uint64_t before, after, made;
    long files; /* calls on files */
} reference;

static _Alignas(64) unsigned char out[OUT_ROOM], untouched[OUT_ROOM], right[OUT_ROOM];

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

static int made_something(const attempt *a) {
    return a->made != untouched;
}

static void end(attempt *a) {
    if (now->made != NULL && made_something(a))
        now->made->end(a->made);
    if (now->of != NULL && a->object != NULL)
        now->of->end(a->object);
}

static reference result_of(const attempt *a) {
    const reference result = {0, digest_of(now->of, a->object),
                              now->made != NULL && made_something(a) ? digest_of(now->made, a->made) : 0, 0};
    return result;
}

/* Results of a call that succeeded, against those of one that nothing befell. */
static void compare(const attempt *a, const reference *good, const char *when) {
    const reference result = result_of(a);
    if (memcmp(out, right, sizeof out) != 0)
        complain(when, "outputs are others", TOLIMAN_OK);
    if (result.made != good->made)
        complain(when, "another object is made", TOLIMAN_OK);
    if (result.after != good->after)
        complain(when, "another object is left", TOLIMAN_OK);
}

static reference unharmed(void) {
    attempt a;
    begin(&a);
    const uint64_t before = digest_of(now->of, a.object);
    arm(FAIL_FILES, LONG_MAX, 0, EIO);
    const toliman_status status = now->call(&a);
    const long files = disarm();
    if (status != now->refused)
        complain("", "another status though nothing is wrong", status);
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
        complain("", "another error", status);
    if (made_something(a))
        complain("", "something was made", status);
    if (now->partial == NULL && memcmp(out, untouched, sizeof out) != 0)
        complain("", "outputs are touched", status);
}

/* Only closing what was read or is synced may fail unseen. */
static int may_be_silent(int error) {
    return error == EINTR || error == SHORT_COUNT || strcmp(failed_call(), "close") == 0;
}

/* One call with the mishap; returns whether it came to that. */
static int attempt_once(const reference *good, enum what what, long at, int for_ever, int error) {
    attempt a;
    const int files = open_files();
    begin(&a);
    arm(what, at, for_ever, error);
    toliman_status status = now->call(&a);
    const long calls = disarm();
    runs++;
    failed_calls += calls > at;
    if (status == now->refused && what == FAIL_FILES && calls > at && !may_be_silent(error))
        complain("", "the failure is not told", status);
    if (status == now->refused)
        compare(&a, good, "after a success, ");
    else
        check_failure(&a, status, what);
    if (now->check != NULL)
        now->check(&a, status);
    if (status != now->refused) {
        if (now->partial == NULL && digest_of(now->of, a.object) != good->before)
            complain("", "the object is not as before", status);
        memcpy(out, untouched, sizeof out);
        if ((status = now->call(&a)) != now->refused)
            complain("", "another status the next time", status);
        else
            compare(&a, good, "the next time, ");
    }
    end(&a);
    if (open_files() != files)
        complain("", "files are left open", status);
    return calls > at;
}

/* Of slow functions the short form takes few, those that fail once by turns with those that fail for ever. */
static int is_sparse(int all) {
    return now->slow && !all;
}

static long first(int for_ever, int all) {
    return is_sparse(all) ? for_ever : 0;
}

static long next(long at, int all) {
    return at + 1 + (all ? 0 : now->slow ? 8 * at + 3 : at < 12 ? 0 : at / 3);
}

static void run_memory(int all) {
    const reference good = unharmed();
    for (int for_ever = 0; for_ever < 2; for_ever++)
        for (long at = first(for_ever, all), more = 1; more; at = next(at, all)) {
            snprintf(mishap, sizeof mishap, "allocation %ld%s", at, for_ever ? " and all that follow" : "");
            watch_memory();
            more = attempt_once(&good, FAIL_MEMORY, at, for_ever, 0);
            if (blocks_held() != 0) {
                char text[60];
                snprintf(text, sizeof text, "%ld blocks of memory are kept", blocks_held());
                complain("", text, TOLIMAN_OK);
            }
        }
}

static void run_files(int all) {
    static const struct {
        int error, for_ever;
        const char *name;
    } mishaps[] = {{EIO, 0, "EIO"},
                   {EIO, 1, "EIO"},
                   {ENOSPC, 0, "ENOSPC"},
                   {ENOSPC, 1, "ENOSPC"},
                   {EINTR, 0, "EINTR"},
                   {SHORT_COUNT, 0, "a short count"},
                   {SHORT_COUNT, 1, "a short count"}};
    const reference good = unharmed();
    for (size_t i = 0; good.files > 0 && i < sizeof mishaps / sizeof *mishaps; i += is_sparse(all) ? 3 : 1)
        for (long at = first(mishaps[i].for_ever, all), more = 1; more; at = next(at, all)) {
            snprintf(mishap, sizeof mishap, "%s of call %ld%s", mishaps[i].name, at,
                     mishaps[i].for_ever ? " and all that follow" : "");
            more = attempt_once(&good, FAIL_FILES, at, mishaps[i].for_ever, mishaps[i].error);
        }
}

static int has_scenario(const char *function) {
    for (size_t i = 0; i < LISTS; i++)
        for (size_t j = 0; j < lists[i]->count; j++)
            if (strcmp(lists[i]->first[j].function, function) == 0)
                return 1;
    return 0;
}

/* Returns how many functions there are. */
static int check_all_are_here(const char *symbols) {
    char line[200], function[200];
    int count = 0;
    FILE *const file = fopen(symbols, "r");
    require(file != NULL, "not opened", symbols);
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
    const int functions = check_all_are_here(arguments[1]);
    const char *const above = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/toliman-faults-XXXXXX", above != NULL ? above : "/tmp");
    require(mkdtemp(folder) != NULL, "not made", folder);
    for (size_t i = 0; i < LISTS; i++)
        for (size_t j = 0; j < lists[i]->count; j++) {
            now = &lists[i]->first[j];
            if (only != NULL && strcmp(only, now->function) != 0)
                continue;
            (memory ? run_memory : run_files)(all);
            chosen++;
        }
    printf("%d functions, %ld calls, of which %ld met a failure: %d defects\n", functions, runs, failed_calls, defects);
    entries(folder, 1);
    rmdir(folder);
    return defects != 0 || functions == 0 || chosen == 0;
}
