/* libtoliman, base: status codes, error messages, callbacks, memory, versions, machine.
 *
 * Data flow: one header per module. The first comment of each header shows its functions. core.h: the few that suffice
 * for a start.
 *
 *   scene.json -> sim.h -> frames -> cae.h, linear.h -> latent, px -> period.h -> period, false alarm probability
 *                             ^                                           ^
 *                             |                                           |
 *   downlink -> ingest.h -----+-----------------> track.h ----------------+
 *
 *   Failed call -> status -> toliman_constant_name
 *                         -> toliman_last_error, toliman_last_error_field
 *   Constant -> toliman_constant_name
 *   Version of the library   toliman_version, toliman_abi_version, toliman_get_struct_size
 *   Machine                  toliman_get_machine
 *
 * Conventions of all headers
 *   - Errors. A function that can fail returns a toliman_status. It writes its results through pointers, which follow
 *     the inputs. A failed call writes no output and leaves its object unchanged, unless its comment says otherwise
 *     (promise: failed-calls-change-nothing). toliman_last_error() describes the wrong argument or file field, its
 *     value and the allowed values. A message belongs to its thread, and success does not clear it
 *     (promise: messages-belong-to-threads).
 *   - Common errors. Any function may return TOLIMAN_E_ARGUMENT (a pointer is NULL that must not be NULL, a
 *     struct_size is unknown, a number is not finite), TOLIMAN_E_MEMORY and TOLIMAN_E_STATE (the object is in use by
 *     another call). Comments list the other errors.
 *   - Objects are opaque. toliman_X_create(..., &x) creates an object, which the caller destroys with
 *     toliman_X_destroy(x). Destroying NULL does nothing (promise: destroying-null-does-nothing).
 *   - Structs begin with struct_size, the size that the caller compiled with. Initialise a struct with its _INIT
 *     macro. In a language without C macros, set all bytes to 0 and struct_size to the size of the struct. In an
 *     options struct, 0 in a member selects the default (promise: zero-is-the-default). New members are only appended
 *     (promise: members-are-only-appended). In an array of structs the struct_size of the first element applies to all.
 *     A struct in another has none.
 *   - Enumerations are int32_t. A constant is named after its header and its enumeration (TOLIMAN_PERIOD_FAP_NAIVE).
 *     A constant of the wrong enumeration is refused with TOLIMAN_E_ARGUMENT, as no two share a value
 *     (promise: wrong-enumerations-are-refused). A library newer than your headers may return constants that they do
 *     not define. Flags are uint32_t, one bit each.
 *   - Arrays belong to the caller and are in C order. Images are [row][column] with a row stride in elements.
 *   - Lists of names in a text are separated by spaces or commas ("flux_a flux_b").
 *   - Results of unknown number are written to the arguments (..., array, capacity, count), files in memory to
 *     (..., bytes, capacity, needed). *count becomes the number of results. If capacity is smaller, the function
 *     returns TOLIMAN_E_CAPACITY and writes nothing else. To ask for the number, pass array NULL and capacity 0: the
 *     result is TOLIMAN_E_CAPACITY, or TOLIMAN_OK if there is none. Call again if the number may have grown since.
 *   - Threads. Different objects may be used by different threads at the same time. Functions that take a const object
 *     may run on one object from several threads (promise: const-calls-run-together). While another function runs on an
 *     object, every other call on it returns TOLIMAN_E_STATE at once and changes nothing
 *     (promise: calls-need-exclusive-use), also from callbacks. It also fails while const calls run.
 *   - Worker threads. A function that uses several takes their number from the member `threads` of its options struct
 *     or, without one, of the options with which its object was created or loaded; 0 = one per processor. Results do
 *     not depend on the number of threads unless a comment says so (promise: threads-change-no-bit).
 *   - Invalid handles. A pointer to a destroyed object, or to an object of another type, is refused with
 *     TOLIMAN_E_ARGUMENT as long as its memory is not reused (promise: invalid-handles-are-refused). Do not rely on it.
 *   - Functions without a status. toliman_mask_get_json returns "" where others return TOLIMAN_E_STATE or
 *     TOLIMAN_E_ARGUMENT, and sets toliman_last_error(). Destroying an object in use, or of another type, only sets
 *     toliman_last_error() (promise: objects-in-use-stay).
 *   - Callbacks may be written in C++. An exception of a progress, log or frames callback stops the call with
 *     TOLIMAN_E_CANCELLED (promise: exceptions-cancel-calls). An exception of an estimator (frame.h) rejects the frame.
 *     Allocators must not throw. A callback must return or throw: longjmp out of one is not allowed. The object remains
 *     in use and cannot be destroyed, and worker threads keep pointers into the stack.
 *   - Signals and fork. Do not call the library from a signal handler. After fork(), the child may use every object on
 *     which no call ran in the parent, except trackers with a folder (promise: objects-survive-fork).
 *   - Process state. The library never prints, exits, reads the environment, or changes the locale, signal handlers,
 *     rounding mode or BLAS (promise: host-state-is-not-changed). Results and messages do not depend on the locale
 *     (promise: locale-changes-nothing). Calls fail with TOLIMAN_E_UNSUPPORTED unless the rounding mode is
 *     round-to-nearest, the default (promise: other-rounding-is-refused).
 *   - Documents. The files glossary.md (terms) and formats.md (file formats) are installed in share/doc/toliman, the
 *     schema of a scene in share/toliman/schema. "The chapter" is the book chapter by Delli Veneri et al., Periodic
 *     Astrometric Signal Recovery Through Convolutional Autoencoders, in Intelligent Astrophysics, Springer (2021).
 *   - Units are SI unless the name states another: _px, _days, _nm, _arcsec, _ns. Times and values of a periodogram
 *     or tracker have the unit of the caller or of the estimator (px for cae.h and linear.h).
 */
#ifndef TOLIMAN_BASE_H
#define TOLIMAN_BASE_H

#include <stddef.h>
#include <stdint.h>

#include <toliman/export.h>
#include <toliman/version.h>

TOLIMAN_BEGIN_DECLS

/* Initialises a struct in C: sets struct_size, and every other member to 0, its default. Use the macro of the struct:
 * toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT. In C++, toliman.hpp has
 * toliman::sized<toliman_period_options>(). */
#define TOLIMAN_INIT(type)                                                                                             \
    { .struct_size = (uint32_t)sizeof(type) }

/* Status code returned by every function that can fail. Later versions may add codes. Treat an unknown code as an
 * error. */
typedef int32_t toliman_status;
#define TOLIMAN_OK 0            /* success */
#define TOLIMAN_E_INTERNAL 1    /* bug in the library */
#define TOLIMAN_E_ARGUMENT 2    /* invalid argument, such as NULL or NaN */
#define TOLIMAN_E_MEMORY 3      /* out of memory or of another system resource */
#define TOLIMAN_E_NOT_FOUND 4   /* input file missing or not readable, or no item of this name */
#define TOLIMAN_E_FORMAT 5      /* input file or blob malformed, truncated or corrupt */
#define TOLIMAN_E_SCENE 6       /* scene physically impossible or inconsistent */
#define TOLIMAN_E_UNSUPPORTED 7 /* valid request that this version does not support */
#define TOLIMAN_E_WRITE 8       /* output file cannot be written */
#define TOLIMAN_E_CANCELLED 9   /* stopped by a callback */
#define TOLIMAN_E_RANGE 10      /* number outside the range fixed at creation, by the function or by a file format */
#define TOLIMAN_E_MISMATCH 11   /* two objects or files do not belong together */
#define TOLIMAN_E_CAPACITY 12   /* caller's buffer too small, or capacity exhausted */
#define TOLIMAN_E_STATE 13      /* object not ready for this call, such as too few samples or an untrained network */
#define TOLIMAN_E_LOST 14       /* data lost from a file: another program or the disk has changed it */

/* Returns the message of the last failed call on this thread, "" if no call has failed. Never NULL. The text is one
 * line, with a decimal point in every locale. It is valid until the next failed call on this thread. */
TOLIMAN_API const char *toliman_last_error(void) TOLIMAN_NOEXCEPT;

/* Returns the name of the wrong argument, struct member, scene key or file of the last failed call on this thread
 * (promise: errors-name-the-field), so that programs need not parse messages: "sigma", "options->bin",
 * "frames[3].sigma", "telescope.aperture_m", or the path of a file. "" if no call has failed, and for failures without
 * such a name (out of memory, cancelled, too few samples). Never NULL. Valid until the next failed call on this
 * thread. */
TOLIMAN_API const char *toliman_last_error_field(void) TOLIMAN_NOEXCEPT;

/* Returns the name of a constant, as files and messages contain it: "too good" for TOLIMAN_GOODNESS_TOO_GOOD,
 * "TOLIMAN_E_SCENE" for a status. Named are the status codes, TOLIMAN_CALIBRATION_CHANGE_..., TOLIMAN_GOODNESS_...,
 * TOLIMAN_INGEST_REASON_..., TOLIMAN_MEASURE_..., TOLIMAN_PERIOD_INTERVAL_..., TOLIMAN_PLANET_REASON_...,
 * TOLIMAN_SIM_IMAGE_..., TOLIMAN_SKY_CAUSE_..., TOLIMAN_SKY_ELEMENT_..., TOLIMAN_SKY_OBSERVER_...,
 * TOLIMAN_TRACK_REASON_... and TOLIMAN_TRACK_VERDICT_...; a bit set has no name. Returns "?" for another number. Static
 * text, never NULL. */
TOLIMAN_API const char *toliman_constant_name(int32_t constant) TOLIMAN_NOEXCEPT;

/* Callback that reports the progress of a long call. It runs on the thread of the call, with no lock held.
 *   stage     short name of the stage ("frames"), sometimes followed by a colon and details ("train: epoch 3 of 300,
 *             loss 0.9"); valid during the callback
 *   fraction  completed fraction, from 0 to 1
 * Return 0 to continue, any other value to stop. A stopped call returns TOLIMAN_E_CANCELLED, and its object stays
 * usable (promise: stopped-objects-stay-usable); toliman_mask_create returns the mask so far. */
typedef int32_t (*toliman_progress_fn)(const char *stage, double fraction, void *user_data);

/* Levels of diagnostic messages. */
#define TOLIMAN_LOG_INFO 21
#define TOLIMAN_LOG_WARNING 22

/* Callback that receives diagnostic messages, which are not errors. level is TOLIMAN_LOG_INFO or TOLIMAN_LOG_WARNING.
 * text is valid during the callback. */
typedef void (*toliman_log_fn)(int32_t level, const char *text, void *user_data);

/* Allocates `size` bytes, aligned to `alignment` (64). Returns NULL if no memory is available. Must not throw. */
typedef void *(*toliman_allocate_fn)(size_t size, size_t alignment, void *user_data);

/* Releases memory that was allocated with this size. Must not throw. */
typedef void (*toliman_release_fn)(void *memory, size_t size, void *user_data);

/* Optional allocator for the large arrays of an object, such as a memory pool of the host program. Creating, loading or
 * copying the object uses it; its memory is released with the object at the latest
 * (promise: allocators-get-memory-back). Both functions may be called from any thread that uses the object. user_data
 * must outlive the object; the struct itself is only read during the call. If allocate returns NULL, the call fails
 * with TOLIMAN_E_MEMORY. Small allocations, and those of OpenBLAS, FFTW, cJSON, zlib and C++, use malloc. */
typedef struct toliman_allocator {
    uint32_t struct_size; /* sizeof(toliman_allocator) */
    uint32_t reserved;    /* 0 */
    toliman_allocate_fn allocate;
    toliman_release_fn release;
    void *user_data; /* passed to both functions; may be NULL */
} toliman_allocator;
#define TOLIMAN_ALLOCATOR_INIT TOLIMAN_INIT(toliman_allocator)

/* Options of the toliman_X_load functions. */
typedef struct toliman_load_options {
    uint32_t struct_size;
    uint32_t threads; /* of the object: worker threads, 0 = one per processor. A periodogram has none */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
} toliman_load_options;
#define TOLIMAN_LOAD_OPTIONS_INIT TOLIMAN_INIT(toliman_load_options)

/* Returns the version of the running library as text ("0.3.0"). */
TOLIMAN_API const char *toliman_version(void) TOLIMAN_NOEXCEPT;

/* Returns the number of the binary interface. A program can run with this library if the number equals the
 * TOLIMAN_ABI_VERSION that it was compiled with. */
TOLIMAN_API int32_t toliman_abi_version(void) TOLIMAN_NOEXCEPT;

/* Returns the size in bytes of a public struct ("toliman_machine") in the running library, 0 for an unknown name. For
 * language bindings: a binding whose struct is larger needs a newer library. */
TOLIMAN_API size_t toliman_get_struct_size(const char *name) TOLIMAN_NOEXCEPT;

/* Properties of the machine, as the library detects them. All texts are static. */
typedef struct toliman_machine {
    uint32_t struct_size;    /* in: sizeof(toliman_machine) */
    int32_t processors;      /* number of online processors */
    const char *isa;         /* instruction set of the kernels in use: "baseline", "avx2" or "avx512" */
    const char *blas_core;   /* OpenBLAS kernels in use, such as "SkylakeX" */
    const char *blas_config; /* OpenBLAS version and build options */
    int32_t blas_threads;    /* threads that OpenBLAS uses in a call */
    int32_t blas_is_slow;    /* 1 if the OpenBLAS kernels are older than the CPU (set OPENBLAS_CORETYPE before start) */
    const char *blas_better; /* value of OPENBLAS_CORETYPE that fits this CPU; "" if the kernels in use fit */
    const char *fftw;        /* FFTW version */
} toliman_machine;
#define TOLIMAN_MACHINE_INIT TOLIMAN_INIT(toliman_machine)

/* Writes the properties of the machine to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_get_machine(toliman_machine *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
