/* One call of one public function, so that it can be made again and again while something fails. */
#ifndef TOLIMAN_TESTS_SCENARIO_H
#define TOLIMAN_TESTS_SCENARIO_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/toliman.h>

enum { OUT_ROOM = 1 << 20, UNTOUCHED = 0x5a };

/* Objects of a kind: their end, and a number made of all that a caller can see of them. */
typedef struct {
    void (*end)(void *object);
    uint64_t (*digest)(const void *object);
} object_kind;

typedef struct {
    void *object;       /* what the function works on; the call that ends it leaves NULL */
    void *made;         /* what it creates */
    unsigned char *out; /* [OUT_ROOM], what else it writes; all bytes UNTOUCHED before but those of struct_size */
} attempt;

typedef struct {
    const char *function, *variant;
    toliman_status (*call)(attempt *a);
    void *(*make)(void);          /* a.object, made anew for every call; NULL: there is none */
    const object_kind *of, *made; /* of a.object, and of a.made; NULL: there is none */
    uint32_t struct_size;         /* of the struct that is written first */
    const char *partial;          /* why an error may leave outputs or the object changed; NULL: it may not */
    void (*stage)(void);          /* puts down the files that a call finds; may be NULL */
    /* Looks at the files after a call, and may open a.object anew; may be NULL. */
    void (*check)(attempt *a, toliman_status status);
    toliman_status refused; /* what the call comes to when nothing fails; 0 = TOLIMAN_OK */
    int slow;               /* takes long: fewer calls in the short form */
} scenario;

typedef struct {
    const scenario *first;
    size_t count;
} scenario_list;
extern const scenario_list base_scenarios, sim_scenarios, cae_scenarios, linear_scenarios, period_scenarios,
    track_scenarios;
#define SCENARIO_LIST(name, array) const scenario_list name = {array, sizeof array / sizeof *array}

/* Ends the program with a message that names the scenario, unless it holds. */
void must(int holds, const char *what);

/* A folder of the program's own, and the path of a file there; a path lives for eight further calls. */
const char *in_folder(const char *name);
void write_file(const char *name, const void *bytes, size_t size);
size_t read_file(const char *name, void *bytes, size_t room); /* SIZE_MAX if there is none */
int files_in(const char *folder);
void empty_folder(const char *name); /* makes it, if need be */

static inline uint64_t fnv1a(uint64_t before, const void *data, size_t size) {
    for (size_t i = 0; i < size; i++)
        before = (before ^ ((const unsigned char *)data)[i]) * 0x100000001b3u;
    return before;
}
#define FNV_START 0xcbf29ce484222325u

/* Scenes and images that several lists share. */
toliman_sim *wide_sim(void);      /* 256 x 256, for networks */
const double *wide_frames(void);  /* [8][256][256] of it */
toliman_sim *small_sim(void);     /* 24 x 24 */
const double *small_frames(void); /* [8][24][24] of it */
enum { WIDE = 256, SMALL = 24, FRAMES = 8 };

#endif
