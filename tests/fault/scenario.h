/* One call of one public function, repeatable while calls that it makes fail, and the files that it reads and writes.
 * tools/gen/scenarios makes the scenarios from the table `scenarios`. */
#ifndef TOLIMAN_TESTS_SCENARIO_H
#define TOLIMAN_TESTS_SCENARIO_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/toliman.h>

typedef struct {
    void *object;       /* the object of the call; a call that destroys it leaves NULL */
    void *made;         /* the object that the call creates */
    unsigned char *out; /* other outputs; all bytes are UNTOUCHED before the call, except those of `structs` */
} attempt;

struct scenario;

/* A kind of objects. Its digest is of everything that a caller can read: of the outputs of `reads` without `digest`. */
typedef struct {
    void (*end)(void *object);
    uint64_t (*digest)(const void *object);
    const struct scenario *reads[5];
} object_kind;

typedef struct scenario {
    const char *function, *variant;
    toliman_status (*call)(attempt *a);
    size_t size;                  /* of the outputs and the gaps between them */
    void *(*make)(void);          /* creates a.object; NULL: there is none */
    const object_kind *of, *made; /* kinds of a.object and a.made; NULL: there is none */
    struct {
        size_t at, size;
        int zero;            /* an input as well: its other members are 0 */
    } structs[3];            /* outputs with a struct_size */
    int is_const, is_shared; /* the object is const; and is the same for all calls */
    int saves;               /* the call writes the file SAVED */
    const char *partial;     /* why an error may leave outputs or the object changed; NULL: it may not */
    void (*stage)(void);     /* prepares the files that the call reads; may be NULL */
    /* Checks the files after a call, and may reopen a.object; may be NULL. */
    void (*check)(attempt *a, toliman_status status);
    toliman_status refused; /* status without failures; 0 = TOLIMAN_OK */
    int slow;               /* slow call: fewer failures in the short form */
    int allocates_nothing;  /* the call allocates no memory once its object exists */
} scenario;

extern const scenario *const scenarios[];
extern const size_t scenario_count;

/* Reports a defect with the name of the scenario unless `holds`. */
void must(int holds, const char *what);

/* The object that `make` creates, created once. */
void *shared(void *(*make)(void));
/* The object that a scenario creates without failures. */
void *made_by(const scenario *creates);

/* Temporary folders of the program, one for each thread, and the path of a file in this thread's; a path is valid for
 * eight further calls. */
const char *in_folder(const char *name);
void use_folder(int thread);
void write_file(const char *name, const void *bytes, size_t size);
size_t read_file(const char *name, void *bytes, size_t capacity); /* SIZE_MAX if the file does not exist */
int files_in(const char *folder);
void empty_folder(const char *name); /* creates the folder if necessary */
void require(int holds, const char *what, const char *name);
void create_folders(int count);
void remove_folders(void);

/* The content of a file, to put it again before each call. */
typedef struct {
    unsigned char *bytes;
    size_t size;
} saved_file;
void keep_file(const char *name, saved_file *kept);
void put_file(const char *name, const saved_file *kept);
void must_begin_with(const char *name, const saved_file *kept);
const unsigned char *damaged(const saved_file *kept); /* a copy with another byte in the middle */

/* A call that saves replaces the file SAVED, to which the path is a symbolic link, or leaves it. */
#define SAVED_LINK "link.json"
#define SAVED "saved/file"
#define LOADED "loaded"
#define JOURNAL "journals/journal"
void put_old(void);
void check_saved(const saved_file *complete, toliman_status status);
const saved_file *saved_by(saved_file *kept, void *object, toliman_status (*save)(attempt *a));

/* Replaces a text, or a number that is returned, by what is the same in each call and folder. */
void hide_text(const char **text);
void put_text(unsigned char *out, const char *text);
void put_number(unsigned char *out, int64_t number);

static inline uint64_t fnv1a(uint64_t before, const void *data, size_t size) {
    for (size_t i = 0; i < size; i++)
        before = (before ^ ((const unsigned char *)data)[i]) * 0x100000001b3u;
    return before;
}
#define FNV_START 0xcbf29ce484222325u

#endif
