/* libtoliman, base: conventions of all headers, status codes, messages, callbacks, memory, versions, machine.
 *
 * Data flow: one header per module, whose first comment shows its functions; core.h: those for a start.
 *
 *   scene.json -> sim.h -> frames -> cae.h, linear.h -> latent, px -> period.h -> period, false alarm probability
 *   downlink -> ingest.h -> frames -> track.h -----------------------> period.h
 *
 *   Failed call -> status    toliman_constant_name, toliman_last_error, toliman_last_error_field
 *   Version and machine      toliman_version, toliman_abi_version, toliman_get_struct_size, toliman_get_machine
 *
 * Conventions of all headers, which their comments do not repeat
 *   - Errors. A function that can fail returns a toliman_status; results are written to pointers after the inputs. A
 *     failed call writes no output and leaves its object unchanged, unless its comment says otherwise
 *     (promise: failed-calls-change-nothing). A message belongs to its thread, and success does not clear it
 *     (promise: messages-belong-to-threads).
 *   - Common errors. TOLIMAN_E_ARGUMENT: NULL where not allowed, unknown struct_size, number not finite, option or
 *     argument out of its range, name unknown or given twice, stride too small. TOLIMAN_E_RANGE: index outside.
 *     TOLIMAN_E_NOT_FOUND: file cannot be read. TOLIMAN_E_FORMAT: file or bytes malformed or damaged; the message names
 *     the line of a text. TOLIMAN_E_WRITE, TOLIMAN_E_MEMORY. TOLIMAN_E_CANCELLED: by a callback. TOLIMAN_E_STATE:
 *     object in use by another call.
 *   - Objects. The caller destroys them by toliman_X_destroy. Destroying NULL does nothing
 *     (promise: destroying-null-does-nothing). Except for trackers, an object does not need those that it was created
 *     from.
 *   - Structs, also those for results, begin with struct_size: initialise them with their _INIT macro or, without C
 *     macros, set all bytes to 0, then struct_size to the size of the struct. In an array, that of the first element
 *     counts. New members are only appended (promise: members-are-only-appended).
 *   - Options. In an options struct, 0 in a member is the default (promise: zero-is-the-default). Callbacks and
 *     allocators may be NULL, and so may `options`, except of toliman_ingest_create and toliman_track_create.
 *   - Enumerations are int32_t, flags uint32_t. A constant of the wrong enumeration is refused with TOLIMAN_E_ARGUMENT
 *     (promise: wrong-enumerations-are-refused). A newer library may return others.
 *   - Arrays belong to the caller, in C order. Images are [row][column] with a row stride in elements. Indices begin at
 *     0.
 *   - Texts in results are static unless a comment says otherwise. Lists of names are separated by spaces or commas.
 *   - Results of unknown number: (..., array, capacity, count), files in memory: (..., bytes, capacity, needed). The
 *     last becomes their number; if capacity is smaller, nothing else is written: TOLIMAN_E_CAPACITY. To ask for the
 *     number, pass NULL and 0: TOLIMAN_E_CAPACITY, or TOLIMAN_OK if there is none. Later versions may append results.
 *   - Files. toliman_X_save_file replaces its file atomically; after TOLIMAN_E_WRITE the old one remains.
 *     toliman_X_load takes exactly `size` bytes.
 *   - Threads. Different threads may use different objects at the same time. Functions that take a const object may run
 *     on one object from several threads (promise: const-calls-run-together). While another function runs on an object,
 *     every other call on it, also from callbacks, returns TOLIMAN_E_STATE at once and changes nothing
 *     (promise: calls-need-exclusive-use). That function also fails while const calls run.
 *   - Worker threads. `threads` of a function's options or, without it, of those that created or loaded the object; 0 =
 *     one per processor. Results do not depend on the number of threads unless a comment says so
 *     (promise: threads-change-no-bit).
 *   - Invalid handles. A pointer to a destroyed object, or of another type, is refused with TOLIMAN_E_ARGUMENT until
 *     its memory is reused (promise: invalid-handles-are-refused). Destroying an object in use, or of another type,
 *     only sets toliman_last_error() (promise: objects-in-use-stay).
 *   - Callbacks, except allocators and estimators, run on the thread of the call, with no lock held. A C++ exception of
 *     a progress, log or frames callback stops the call with TOLIMAN_E_CANCELLED (promise: exceptions-cancel-calls),
 *     one of an estimator rejects the frame. No longjmp.
 *   - Signals and fork. Do not call the library from a signal handler. After fork(), the child may use every object on
 *     which no call ran in the parent, except trackers with a folder (promise: objects-survive-fork).
 *   - Process state. The library never prints, exits, reads the environment, or changes the locale, signal handlers,
 *     rounding mode or BLAS (promise: host-state-is-not-changed). Results and messages do not depend on the locale
 *     (promise: locale-changes-nothing). Calls fail with TOLIMAN_E_UNSUPPORTED unless the rounding mode is
 *     round-to-nearest, the default (promise: other-rounding-is-refused).
 *   - Documents (*.md): share/doc/toliman; schemas: share/toliman/schema. "The chapter": Delli Veneri et al., in
 *     Intelligent Astrophysics, Springer (2021).
 *   - Units are SI unless the name states another (_px, _days, _nm). TAI nanoseconds count from 1970-01-01T00:00:00
 *     TAI; those of a tracker, from the epoch of its clock table. Times and values of a periodogram or tracker have
 *     those of the caller or of the estimator. */
#ifndef TOLIMAN_BASE_H
#define TOLIMAN_BASE_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/export.h>
#include <toliman/version.h>

TOLIMAN_BEGIN_DECLS

/* Initialises a struct in C: toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT. C++:
 * toliman::sized<toliman_period_options>() of toliman.hpp. */
#define TOLIMAN_INIT(type)                                                                                             \
    { .struct_size = (uint32_t)sizeof(type) }

/* Status codes; later versions may add some. */
typedef int32_t toliman_status;
#define TOLIMAN_OK 0
#define TOLIMAN_E_INTERNAL 1 /* bug in the library */
#define TOLIMAN_E_ARGUMENT 2 /* such as NULL or NaN */
#define TOLIMAN_E_MEMORY 3
#define TOLIMAN_E_NOT_FOUND 4   /* input file missing or not readable, or no item of this name */
#define TOLIMAN_E_FORMAT 5      /* input malformed, truncated or corrupt */
#define TOLIMAN_E_SCENE 6       /* physically impossible or inconsistent */
#define TOLIMAN_E_UNSUPPORTED 7 /* valid request that this version does not support */
#define TOLIMAN_E_WRITE 8       /* output file cannot be written */
#define TOLIMAN_E_CANCELLED 9   /* stopped by a callback */
#define TOLIMAN_E_RANGE 10      /* number outside the range of the object, function or file format */
#define TOLIMAN_E_MISMATCH 11   /* objects or files that do not belong together */
#define TOLIMAN_E_CAPACITY 12   /* caller's buffer too small, or object full */
#define TOLIMAN_E_STATE 13      /* object not ready, such as too few samples, or in use */
#define TOLIMAN_E_LOST 14       /* data lost from a file, changed by another program or the disk */

/* Returns the message of the last failed call on this thread, one line: field, value and allowed values; "" if no call
 * has failed, never NULL. Valid until the next failed call on this thread. */
TOLIMAN_API const char *toliman_last_error(void) TOLIMAN_NOEXCEPT;

/* Returns the wrong argument, struct member, scene key or file of this message (promise: errors-name-the-field):
 * "sigma", "options->bin", "frames[3].sigma", "telescope.aperture_m", or a path; "" if there is none. Otherwise as
 * toliman_last_error. */
TOLIMAN_API const char *toliman_last_error_field(void) TOLIMAN_NOEXCEPT;

/* Returns the name of a constant in files and messages: "too good" for TOLIMAN_GOODNESS_TOO_GOOD. Named are status
 * codes, TOLIMAN_CALIBRATION_CHANGE_..., TOLIMAN_COADD_..., TOLIMAN_GOODNESS_..., TOLIMAN_INGEST_REASON_...,
 * TOLIMAN_MEASURE_..., TOLIMAN_PERIOD_INTERVAL_..., TOLIMAN_PLANET_REASON_..., TOLIMAN_SIM_IMAGE_...,
 * TOLIMAN_SKY_CAUSE_..., _ELEMENT_..., _OBSERVER_..., TOLIMAN_TRACK_REASON_..., _VERDICT_.... Returns "?" for another
 * number or a bit set. */
TOLIMAN_API const char *toliman_constant_name(int32_t constant) TOLIMAN_NOEXCEPT;

/* Callback for the progress of a long call. Return 0 to continue. Any other value stops the call with
 * TOLIMAN_E_CANCELLED, and its object stays usable (promise: stopped-objects-stay-usable); toliman_mask_create returns
 * the mask so far.
 *   stage     "frames", or with details "train: epoch 3 of 300, loss 0.9"; valid during the callback
 *   fraction  completed, 0 to 1 */
typedef int32_t (*toliman_progress_fn)(const char *stage, double fraction, void *user_data);

/* Levels of messages. */
#define TOLIMAN_LOG_INFO 21
#define TOLIMAN_LOG_WARNING 22

/* Callback for diagnostic messages, which are not errors. text is valid during the callback. */
typedef void (*toliman_log_fn)(int32_t level, const char *text, void *user_data);

/* Allocates `size` bytes, aligned to `alignment` (64). Returns NULL without memory. Must not throw. */
typedef void *(*toliman_allocate_fn)(size_t size, size_t alignment, void *user_data);

/* Releases memory that was allocated with this size. Must not throw. */
typedef void (*toliman_release_fn)(void *memory, size_t size, void *user_data);

/* Allocator for the large arrays of an object; NULL = malloc. Creating, loading or copying the object uses it; its
 * memory is released with the object at the latest (promise: allocators-get-memory-back). Any thread that uses the
 * object may call both functions. user_data must outlive the object, not the struct. Small allocations, and those of
 * OpenBLAS, FFTW, cJSON, zlib and C++, use malloc. */
typedef struct toliman_allocator {
    uint32_t struct_size;
    uint32_t reserved;
    toliman_allocate_fn allocate;
    toliman_release_fn release;
    void *user_data;
} toliman_allocator;
#define TOLIMAN_ALLOCATOR_INIT TOLIMAN_INIT(toliman_allocator)

/* Options of the toliman_X_load functions. */
typedef struct toliman_load_options {
    uint32_t struct_size;
    uint32_t threads; /* of the object; a periodogram has none */
    const toliman_allocator *allocator;
} toliman_load_options;
#define TOLIMAN_LOAD_OPTIONS_INIT TOLIMAN_INIT(toliman_load_options)

/* Returns the version of the running library ("0.3.0"). */
TOLIMAN_API const char *toliman_version(void) TOLIMAN_NOEXCEPT;

/* Returns the number of the binary interface: a program can run with this library if it equals the TOLIMAN_ABI_VERSION
 * of its compilation. */
TOLIMAN_API int32_t toliman_abi_version(void) TOLIMAN_NOEXCEPT;

/* Returns the size in bytes of a public struct ("toliman_machine") in the running library, 0 for an unknown name. A
 * binding whose struct is larger needs a newer library. */
TOLIMAN_API size_t toliman_get_struct_size(const char *name) TOLIMAN_NOEXCEPT;

/* Machine, as the library detects it. */
typedef struct toliman_machine {
    uint32_t struct_size;
    int32_t processors;
    const char *isa;       /* of the kernels in use: "baseline", "avx2" or "avx512" */
    const char *blas_core; /* kernels in use, such as "SkylakeX" */
    const char *blas_config;
    int32_t blas_threads;
    int32_t blas_is_slow;    /* 1 if the kernels are older than the CPU (set OPENBLAS_CORETYPE before start) */
    const char *blas_better; /* value of OPENBLAS_CORETYPE that fits this CPU; "" if the kernels fit */
    const char *fftw;
} toliman_machine;
#define TOLIMAN_MACHINE_INIT TOLIMAN_INIT(toliman_machine)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_get_machine(toliman_machine *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
