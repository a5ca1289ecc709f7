/* One call of one public function, repeatable while calls that it makes fail. */
#ifndef TOLIMAN_TESTS_SCENARIO_H
#define TOLIMAN_TESTS_SCENARIO_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/toliman.h>

enum { OUT_CAPACITY = 1 << 20, UNTOUCHED = 0x5a };

/* A kind of objects: its destructor, and a digest of everything that a caller can read from an object. */
typedef struct {
    void (*end)(void *object);
    uint64_t (*digest)(const void *object);
} object_kind;

typedef struct {
    void *object;       /* the object of the call; a call that destroys it leaves NULL */
    void *made;         /* the object that the call creates */
    unsigned char *out; /* [OUT_CAPACITY], other outputs; all bytes are UNTOUCHED before the call, except struct_size */
} attempt;

typedef struct {
    const char *function, *variant;
    toliman_status (*call)(attempt *a);
    void *(*make)(void);          /* creates a.object for each call; NULL: there is none */
    const object_kind *of, *made; /* kinds of a.object and a.made; NULL: there is none */
    uint32_t struct_size;         /* of the struct at the start of `out` */
    const char *partial;          /* why an error may leave outputs or the object changed; NULL: it may not */
    void (*stage)(void);          /* prepares the files that the call reads; may be NULL */
    /* Checks the files after a call, and may reopen a.object; may be NULL. */
    void (*check)(attempt *a, toliman_status status);
    toliman_status refused; /* status without failures; 0 = TOLIMAN_OK */
    int slow;               /* slow call: fewer failures in the short form */
    int allocates_nothing;  /* the call allocates no memory once its object exists */
} scenario;

typedef struct {
    const scenario *first;
    size_t count;
} scenario_list;
extern const scenario_list base_scenarios, sim_scenarios, cae_scenarios, linear_scenarios, fit_scenarios,
    bank_scenarios, calibrate_scenarios, period_scenarios, track_scenarios, ingest_scenarios, ingest_time_scenarios,
    mask_scenarios, measure_scenarios, planet_scenarios, series_scenarios, sky_scenarios, track_reduced_scenarios;
#define SCENARIO_LIST(name, array) const scenario_list name = {array, sizeof array / sizeof *array}

/* Reports a defect with the name of the scenario unless `holds`. */
void must(int holds, const char *what);

/* A temporary folder of the program, and the path of a file in it; a path is valid for eight further calls. */
const char *in_folder(const char *name);
void write_file(const char *name, const void *bytes, size_t size);
size_t read_file(const char *name, void *bytes, size_t capacity); /* SIZE_MAX if the file does not exist */
int files_in(const char *folder);
/* The JSON file `name` must have the text "old", or be a complete document that contains `mark`; after TOLIMAN_OK the
 * latter. No other file may remain in folder `where`, unless every call fails and it cannot be removed. */
void must_be_old_or_new(const char *where, const char *name, const char *mark, toliman_status status);
void empty_folder(const char *name); /* creates the folder if necessary */

/* The content of a file, to put it again before each call; a call may append to it, and must not change what it has. */
typedef struct {
    unsigned char *bytes;
    size_t size;
} saved_file;
void keep_file(const char *name, saved_file *kept);
void put_file_again(const char *name, const saved_file *kept);
void must_begin_as_put(const char *name);

static inline uint64_t fnv1a(uint64_t before, const void *data, size_t size) {
    for (size_t i = 0; i < size; i++)
        before = (before ^ ((const unsigned char *)data)[i]) * 0x100000001b3u;
    return before;
}
#define FNV_START 0xcbf29ce484222325u

/* Series of measurements, of several lists. */
extern const object_kind measures;

/* Trackers, and copies of their folders, of several lists. */
extern const object_kind trackers;
void copy_tracker(const char *from, const char *to);

/* Scenes and images shared by several lists. */
toliman_sim *large_sim(void);     /* 256 x 256, for networks */
const double *large_frames(void); /* [8][256][256] of it */
toliman_sim *small_sim(void);     /* 24 x 24 */
const double *small_frames(void); /* [8][24][24] of it */
enum { LARGE = 256, SMALL = 24, FRAMES = 8 };

#endif
