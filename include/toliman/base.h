/* libtoliman, common ground: status codes, messages, callbacks, versions, the machine.
 *
 * Data flow: each header is a room, whose first lines show its own
 *
 *   scene.json -> sim.h -> frames -> cae.h, linear.h -> latent, px -> period.h -> period, false alarm probability
 *                             |                                           ^
 *                             +---- off a downlink: track.h --------------+
 *
 *   toliman_load_options_init -> toliman_load_options -> the toliman_X_load functions
 *
 *   A call fails -> status -> toliman_status_name
 *                          -> toliman_last_error, toliman_last_error_copy, toliman_last_error_field
 *   Which library runs        toliman_version, toliman_version_number, toliman_abi_version, toliman_get_struct_size
 *   On which machine          toliman_get_machine, toliman_get_blas_speed
 *
 * Manners of the whole library
 *   - Every function that can fail returns a toliman_status and writes its results through pointers, which come last.
 *     On failure no output is written and the object is as it was before the call.
 *   - After a failure toliman_last_error() tells, on the same thread, which argument or file field was wrong, its value
 *     and what is allowed. A success leaves the last message alone.
 *   - Objects are opaque: toliman_X_create(..., &x) makes one, toliman_X_destroy(x) ends it and takes NULL.
 *   - Options are structs whose first member is struct_size. Set them up with the matching _init function and their
 *     sizeof; then zero or the default stands in every member. New members are only ever appended. An array of structs
 *     has the struct_size of its first element throughout.
 *   - An enumeration is an int32_t. Its constants begin with the name of its header and of what they choose, as
 *     TOLIMAN_PERIOD_FAP_NAIVE, and no other enumeration has a constant of the same value, so that a constant of
 * another one is refused (TOLIMAN_E_ARGUMENT). 0 in a member of an options struct is the default; a result may hold a
 * value that a newer library has added. Flags are uint32_t, one bit each.
 *   - Arrays are the caller's memory in C order, images as [row][column] with an explicit row stride in elements.
 *   - Distinct objects may be used on distinct threads at any time. Functions that take a const object may run on the
 *     same object from several threads at once; others may not. A call on an object that another call excludes returns
 *     TOLIMAN_E_STATE at once and changes nothing; it never waits. So does a call from a callback on the object whose
 *     call runs the callback. toliman_X_destroy on an object in use does nothing but set toliman_last_error().
 *   - A pointer to an object of another type, or to a destroyed one, gives TOLIMAN_E_ARGUMENT as long as its memory
 * still shows that. This is a help for debugging, not a promise.
 *   - Callbacks may be written in C++: an exception that leaves one ends the running call with TOLIMAN_E_CANCELLED.
 *   - No function may be called from a signal handler. After fork() the child may use every object on which no call was
 *     running in the parent at that time. The library depends on no locale and sets none.
 *   - The library never prints, exits, reads the environment or changes the state of BLAS, locale, signals or rounding.
 *     Calls of a thread that does not round to nearest, as all do from their start, fail (TOLIMAN_E_UNSUPPORTED).
 *   - SI units unless the name says otherwise: _px, _days, _nm, _arcsec.
 */
#ifndef TOLIMAN_BASE_H
#define TOLIMAN_BASE_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/export.h>
#include <toliman/version.h>

TOLIMAN_BEGIN_DECLS

/* Initialiser of a struct in C: its struct_size, and 0, the default, in every other member. Each struct has its own,
 * toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT. In C++ it is toliman::sized<toliman_period_options>(),
 * of toliman.hpp. */
#define TOLIMAN_INIT(type)                                                                                             \
    { .struct_size = (uint32_t)sizeof(type) }

/* What a call came to. Codes are append-only; a caller must treat an unknown one as an error. Since 0.1. */
typedef int32_t toliman_status;
#define TOLIMAN_OK 0            /* done */
#define TOLIMAN_E_INTERNAL 1    /* a bug in the library */
#define TOLIMAN_E_ARGUMENT 2    /* NULL, NaN or otherwise impossible argument */
#define TOLIMAN_E_MEMORY 3      /* out of memory or another resource of the system */
#define TOLIMAN_E_NOT_FOUND 4   /* an input file is missing or cannot be read */
#define TOLIMAN_E_FORMAT 5      /* an input file or blob is malformed, truncated or corrupt */
#define TOLIMAN_E_SCENE 6       /* a scene says something impossible */
#define TOLIMAN_E_UNSUPPORTED 7 /* valid, but this version cannot do it */
#define TOLIMAN_E_WRITE 8       /* an output file cannot be written */
#define TOLIMAN_E_CANCELLED 9   /* the progress callback asked to stop */
#define TOLIMAN_E_RANGE 10      /* an argument is outside the range fixed at creation or by the format */
#define TOLIMAN_E_MISMATCH 11   /* two objects or files do not belong together */
#define TOLIMAN_E_CAPACITY 12   /* a buffer given by the caller is too small, or a capacity is used up */
#define TOLIMAN_E_STATE 13      /* the object is not ready for this call (too few samples, nothing trained yet) */
#define TOLIMAN_E_LOST 14       /* a file no longer has what it had: another program or the disk has changed it */

/* Name of a code ("TOLIMAN_E_SCENE"), or "TOLIMAN_E_?" for an unknown one. Static text, never NULL. Since 0.1. */
TOLIMAN_API const char *toliman_status_name(toliman_status status) TOLIMAN_NOEXCEPT;

/* Message of the last failed call on this thread, "" when none failed yet. Valid until the next failing call on this
 * thread; never NULL. One line; numbers have a decimal point in every locale. Since 0.1. */
TOLIMAN_API const char *toliman_last_error(void) TOLIMAN_NOEXCEPT;

/* Copies the last message into text[size], cut to fit and always ended by a zero byte when size > 0 (text may be NULL
 * when size is 0). Returns the length of the whole message without its zero byte. Since 0.1. */
TOLIMAN_API size_t toliman_last_error_copy(char *text, size_t size) TOLIMAN_NOEXCEPT;

/* Name of what was wrong in the last failed call on this thread, as its message has it, so that no program needs to
 * parse the message: an argument ("sigma"), a member of a struct ("options->bin", "frames[3].sigma"), a key of a scene
 * ("telescope.aperture_m"), or the path of a file that is missing, malformed or lost, or cannot be written. "" when
 * none failed yet, and where a failure has no such name (out of memory, cancelled, too few samples). Valid until the
 * next failing call on this thread; never NULL. Since 0.2. */
TOLIMAN_API const char *toliman_last_error_field(void) TOLIMAN_NOEXCEPT;

/* Progress of long work: stage is a short word ("frames"), which may be followed by a colon and a remark ("train: epoch
 * 3 of 300, loss 0.9"); it lives for the call. fraction runs from 0 to 1. Return 0 to go on, anything else to stop: the
 * running call then returns TOLIMAN_E_CANCELLED and its object stays usable. Called on the thread that made the call,
 * with no lock held. Since 0.1. */
typedef int32_t (*toliman_progress_fn)(const char *stage, double fraction, void *user_data);

/* Remarks that are no errors. level is TOLIMAN_LOG_INFO or TOLIMAN_LOG_WARNING; text lives for the call. Since 0.1. */
#define TOLIMAN_LOG_INFO 21
#define TOLIMAN_LOG_WARNING 22
typedef void (*toliman_log_fn)(int32_t level, const char *text, void *user_data);

/* Memory of `size` bytes on a multiple of `alignment`, NULL if there is none left; and back again. Since 0.1. */
typedef void *(*toliman_allocate_fn)(size_t size, size_t alignment, void *user_data);
typedef void (*toliman_release_fn)(void *memory, size_t size, void *user_data);

/* Memory of the caller for the large arrays that an object makes when it is created, loaded or copied, each on a
 * multiple of `alignment` (64): a pool of the host, or the arena of a program that has no heap. They are given back,
 * with their size, at the latest when the object is destroyed; the two functions, which must not throw, may be called
 * from any thread that uses the object. allocate returns NULL if there is none left: TOLIMAN_E_MEMORY then. What
 * allocates by itself, as small things, OpenBLAS, FFTW, cJSON, zlib and the C++ library do, still takes from the
 * system. The struct is read during the call; user_data must outlive the object. Since 0.1. */
typedef struct toliman_allocator {
    uint32_t struct_size; /* sizeof(toliman_allocator) */
    uint32_t reserved;    /* 0 */
    toliman_allocate_fn allocate;
    toliman_release_fn release;
    void *user_data;
} toliman_allocator;
#define TOLIMAN_ALLOCATOR_INIT TOLIMAN_INIT(toliman_allocator)

/* How the toliman_X_load functions make an object. Since 0.2. */
typedef struct toliman_load_options {
    uint32_t struct_size;
    uint32_t reserved;                  /* 0 */
    const toliman_allocator *allocator; /* for the object's large arrays; NULL: the system's memory */
} toliman_load_options;
#define TOLIMAN_LOAD_OPTIONS_INIT TOLIMAN_INIT(toliman_load_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.2. */
TOLIMAN_API void toliman_load_options_init(toliman_load_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Version of the library that is running: "0.2.0", and 10000 major + 100 minor + patch. Compare the number with
 * TOLIMAN_VERSION_NUMBER of the header you compiled against. Since 0.1. */
TOLIMAN_API const char *toliman_version(void) TOLIMAN_NOEXCEPT;
TOLIMAN_API int32_t toliman_version_number(void) TOLIMAN_NOEXCEPT;

/* Number of the binary interface; it changes only when an old caller would break. Equals TOLIMAN_ABI_VERSION of the
 * header when the two fit. Since 0.1. */
TOLIMAN_API int32_t toliman_abi_version(void) TOLIMAN_NOEXCEPT;

/* Bytes of a public struct ("toliman_machine") in the library that is running; 0 for a name it does not know. For
 * bindings: a struct of theirs that is larger needs a newer library. Since 0.1. */
TOLIMAN_API size_t toliman_get_struct_size(const char *name) TOLIMAN_NOEXCEPT;

/* What the library found on this machine; the texts are static, the processors those that are online. Since 0.1. */
typedef struct toliman_machine {
    uint32_t struct_size; /* in: sizeof(toliman_machine) */
    int32_t processors;
    const char *isa;         /* kernels in use: "baseline", "avx2" or "avx512" */
    const char *blas_core;   /* OpenBLAS kernels in use, e.g. "SkylakeX" */
    const char *blas_config; /* OpenBLAS version and build options */
    int32_t blas_threads;    /* threads OpenBLAS would use in a call */
    int32_t blas_is_slow;    /* 1: the kernels are older than the CPU (set OPENBLAS_CORETYPE before start) */
    const char *blas_better; /* OPENBLAS_CORETYPE that fits this CPU, "" when the kernels already do */
    const char *fftw;        /* FFTW version */
} toliman_machine;
#define TOLIMAN_MACHINE_INIT TOLIMAN_INIT(toliman_machine)

/* Fills *out; out->struct_size must be set. TOLIMAN_E_ARGUMENT if out is NULL or its size unknown. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_get_machine(toliman_machine *out) TOLIMAN_NOEXCEPT;

/* Speed of OpenBLAS in double precision, in 1e9 operations a second: best of a few 512 x 512 x 512 products, about 50
 * ms in all. TOLIMAN_E_ARGUMENT if gflops is NULL, TOLIMAN_E_MEMORY. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_get_blas_speed(double *gflops) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
