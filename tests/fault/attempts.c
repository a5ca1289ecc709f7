/* Calls of scenarios, and the comparison of their results with those of an undisturbed call. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "attempts.h"

enum { OUT_CAPACITY = 2 << 20, UNTOUCHED = 0x5a, MOST_SHARED = 64 };

const scenario *now;
char failure[120];
int defects;

void complain(const char *when, const char *what, toliman_status status) {
    defects++;
    fprintf(stderr, "%s%s%s: %s%s [%s; %s failed]: %s \"%s\"\n", now->function, now->variant ? ", " : "",
            now->variant ? now->variant : "", when, what, failure, failed_call(), toliman_constant_name(status),
            toliman_last_error());
}

void must(int holds, const char *what) {
    if (!holds)
        complain("", what, TOLIMAN_OK);
}

static _Alignas(64) unsigned char out[MOST_THREADS][OUT_CAPACITY], untouched[OUT_CAPACITY], right[OUT_CAPACITY];

/* Fills the outputs of a scenario as they are before the call. */
static void clear(const scenario *of, unsigned char *to) {
    memset(to, UNTOUCHED, of->size);
    for (size_t i = 0; i < sizeof of->structs / sizeof *of->structs && of->structs[i].size != 0; i++) {
        const uint32_t size = (uint32_t)of->structs[i].size;
        if (of->structs[i].zero)
            memset(to + of->structs[i].at, 0, size);
        memcpy(to + of->structs[i].at, &size, sizeof size);
    }
}

static uint64_t digest_of(const object_kind *of, void *object) {
    static _Alignas(64) unsigned char seen[OUT_CAPACITY];
    uint64_t hash = FNV_START;
    if (of == NULL || object == NULL)
        return 0;
    if (of->digest != NULL)
        return of->digest(object);
    for (size_t i = 0; i < sizeof of->reads / sizeof *of->reads && of->reads[i] != NULL; i++) {
        attempt a = {.object = object, .out = seen};
        clear(of->reads[i], seen);
        const toliman_status status = of->reads[i]->call(&a);
        hash = fnv1a(fnv1a(hash, &status, sizeof status), seen, of->reads[i]->size);
    }
    return hash;
}

void *shared(void *(*make)(void)) {
    static struct {
        void *(*make)(void);
        void *object;
    } kept[MOST_SHARED];
    size_t i = 0;
    while (kept[i].make != NULL && kept[i].make != make)
        require(++i < MOST_SHARED, "too many", "shared objects");
    if (kept[i].make == NULL) {
        void *const object = make(); /* which may create others */
        for (i = 0; kept[i].make != NULL;)
            require(++i < MOST_SHARED, "too many", "shared objects");
        kept[i].object = object;
        kept[i].make = make;
    }
    return kept[i].object;
}

void *made_by(const scenario *creates) {
    attempt a = {.out = calloc(1, creates->size + 1)};
    clear(creates, a.out);
    if (creates->stage != NULL)
        creates->stage();
    if (creates->make != NULL)
        a.object = creates->make();
    require(creates->call(&a) == TOLIMAN_OK, toliman_last_error(), creates->function);
    if (creates->make != NULL)
        creates->of->end(a.object);
    free(a.out);
    return a.made;
}

void begin_in(attempt *a, int thread, void *object) {
    unsigned char *const to = out[thread];
    if (now->stage != NULL)
        now->stage();
    if (now->saves)
        put_old();
    require(now->size <= OUT_CAPACITY, "the outputs are too large", now->function);
    clear(now, to);
    memcpy(untouched, to, now->size);
    if (object == NULL && now->make != NULL)
        object = now->is_shared ? shared(now->make) : now->make();
    *a = (attempt){object, untouched, to};
}

void begin(attempt *a) {
    begin_in(a, 0, NULL);
}

int created_something(const attempt *a) {
    return a->made != untouched;
}

void end(attempt *a) {
    if (now->made != NULL && created_something(a))
        now->made->end(a->made);
    if (now->of != NULL && a->object != NULL && !now->is_shared)
        now->of->end(a->object);
}

/* Compares the results of a successful call with those of the undisturbed call. */
void compare(const attempt *a, const reference *good, const char *when) {
    if (memcmp(a->out, right, now->size) != 0)
        complain(when, "outputs differ", TOLIMAN_OK);
    if (now->made != NULL && created_something(a) && digest_of(now->made, a->made) != good->made)
        complain(when, "the created object differs", TOLIMAN_OK);
    if (!now->is_shared && digest_of(now->of, a->object) != good->after)
        complain(when, "the object differs", TOLIMAN_OK);
}

/* An array that is too small is not written. */
static void check_only_count_is_written(const attempt *a) {
    size_t changed = 0;
    for (size_t i = 0; i < now->size; i++)
        changed += a->out[i] != untouched[i];
    must(changed > 0 && changed <= sizeof(size_t), "more than the number of results is written");
}

reference undisturbed_call(enum what what) {
    attempt a;
    reference good = {0};
    begin(&a);
    good.before = digest_of(now->of, a.object);
    arm(what, LONG_MAX, 0, EIO);
    const toliman_status status = now->call(&a);
    good.calls = disarm();
    if (status != now->refused)
        complain("", "unexpected status without a failure", status);
    if (status == TOLIMAN_E_CAPACITY)
        check_only_count_is_written(&a);
    good.after = digest_of(now->of, a.object);
    good.made = now->made != NULL && created_something(&a) ? digest_of(now->made, a.made) : 0;
    memcpy(right, a.out, now->size);
    if (now->saves)
        keep_file(SAVED, &good.saved);
    end(&a);
    return good;
}

uint64_t digest_of_reference(const reference *good) {
    uint64_t hash = fnv1a(FNV_START, right, now->size);
    hash = fnv1a(fnv1a(hash, &good->after, sizeof good->after), &good->made, sizeof good->made);
    return now->saves ? fnv1a(hash, good->saved.bytes, good->saved.size) : hash;
}

void end_of_calls(reference *good) {
    failure[0] = '\0';
    if (now->is_shared && digest_of(now->of, shared(now->make)) != good->before)
        complain("", "the object differs after all calls", TOLIMAN_OK);
    free(good->saved.bytes);
}

void check_files(attempt *a, const reference *good, toliman_status status) {
    if (now->saves)
        check_saved(&good->saved, status);
    if (now->check != NULL)
        now->check(a, status);
}

int is_unmodified(const attempt *a, const reference *good) {
    return now->is_shared || digest_of(now->of, a->object) == good->before;
}

int is_untouched(const attempt *a) {
    return memcmp(a->out, untouched, now->size) == 0;
}

void clear_outputs(attempt *a) {
    memcpy(a->out, untouched, now->size);
}
