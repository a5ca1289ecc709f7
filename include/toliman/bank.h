/* libtoliman, bank: networks (cae.h) that follow moving stars. A network is accurate only at the places of the stars
 * for which it was trained. A bank contains networks for several dates of an orbit and, at each date, for several
 * sub-pixel places of the scene's centre. Each frame is fitted (fit.h) and encoded by the network of the nearest place.
 *
 * Data flow (functions toliman_bank_...)
 *
 *   toliman_sim -> plan -> number of networks, bytes, seconds
 *   toliman_fit -> create       bytes, file -> load, load_file
 *                    +---------------+------------+
 *                              toliman_bank <-> train
 *   toliman_fit, frame, time ->    +-> encode                separation, px -> period.h
 *   toliman_fit, time        ->    +-> predict, get_renewal  efficiency to expect, until when to use
 *                                  +-> get_info, get_network properties
 *                                  +-> save, save_file       bytes (formats.md, "TLMB")
 *                               destroy
 *
 * Estimate for a frame with counts n:
 *
 *   p0     parameters of the fit, with the separation at its predicted value and all others at the values that fit the
 *          frame best for this separation
 *   r      (n - m(p0))/sigma per pixel, with the expected counts m and their standard deviations sigma; moved by the
 *          displacement from the stars' places in the frame to those of the network
 *   latent network(r)/slope: the separation minus its prediction, px
 *   separation_px = predicted separation + latent
 *
 * If the prediction is more than 5e-3 px from the fitted separation, the separation that is 5e-3 px from the fitted
 * one, on the side of the prediction, takes its place, and displacement_px is the latent plus what is left.
 *
 * All times are days of scene time, as toliman_fit_prediction.time_days: 0 is the time of frame 0 of the scene, its
 * binary.date. The predicted separation is that of the toliman_fit_prediction of the frame.
 *
 * In first order, r does not depend on any free parameter of the fit except the separation. Slope and efficiency are
 * computed for each frame, from the model images of the fit at its parameters and the gradient of the network, moved to
 * the stars' places in the frame. See decisions.md, 29.
 */
#ifndef TOLIMAN_BANK_H
#define TOLIMAN_BANK_H

#include <toliman/cae.h>
#include <toliman/fit.h>

TOLIMAN_BEGIN_DECLS

/* Bank of networks. */
typedef struct toliman_bank toliman_bank;

/* Options of a bank. */
typedef struct toliman_bank_options {
    uint32_t struct_size;
    int32_t layout; /* TOLIMAN_CAE_LAYOUT_..., 0 = FLIGHT */
    double first_days,
        last_days; /* range of the frames' times (toliman_fit_prediction.time_days), in [-1e6, 1e6] days; both 0: 0 to the last frame of the scene */
    double
        spacing_px; /* largest change of the place of B relative to A from one date to the next, in [0.05, 4] px; 0 = 0.5 */
    uint32_t places;                    /* sub-pixel places per axis, in [1, 8]; 0 = 3 */
    uint32_t steps;                     /* steps of the training of each network, in [1, 1e6]; 0 = 600 */
    uint64_t seed;                      /* seed of the initial weights; 0 = 1 */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    uint32_t threads;                   /* worker threads of toliman_bank_encode, 0 = one per processor */
    uint32_t reserved;                  /* 0 */
} toliman_bank_options;
#define TOLIMAN_BANK_OPTIONS_INIT TOLIMAN_INIT(toliman_bank_options)

/* Predicted size and cost of a bank. */
typedef struct toliman_bank_plan_info {
    uint32_t struct_size;         /* in: sizeof(toliman_bank_plan_info) */
    uint32_t reserved;            /* 0 */
    int64_t dates;                /* dates along the orbit, 1 for a scene whose stars do not move */
    int64_t places;               /* sub-pixel places at each date: the square of toliman_bank_options.places */
    int64_t networks;             /* dates times places */
    double first_days, last_days; /* dates covered, days of scene time */
    uint64_t bytes_float32;       /* size of the weights when saved, before compression */
    uint64_t bytes_half;          /* the same as bf16 or fp16 */
    double train_s;               /* training on one processor, s, estimated */
} toliman_bank_plan_info;
#define TOLIMAN_BANK_PLAN_INFO_INIT TOLIMAN_INIT(toliman_bank_plan_info)

/* Writes size and cost of the bank with these options (NULL: defaults) to *out, whose struct_size must be set.
 * Errors: as toliman_bank_create, except that dates outside the model images are not detected; TOLIMAN_E_UNSUPPORTED
 * for a single star. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_plan(const toliman_sim *sim,
                                                                const toliman_bank_options *options,
                                                                toliman_bank_plan_info *out) TOLIMAN_NOEXCEPT;

/* Creates a bank of untrained networks for the scene and the free parameters of a fit. options may be NULL. The caller
 * destroys *out. An untrained network also measures the separation, with an efficiency of about 0.01, and serves as a
 * control.
 * Errors: TOLIMAN_E_ARGUMENT for options out of range, for a last date before the first one, for dates at which the
 * stars leave the model images of the fit (toliman_fit_create), and for more than 1024 networks;
 * TOLIMAN_E_UNSUPPORTED for frames smaller than 256 x 256 or larger than 4096 x 4096 px. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_create(const toliman_fit *fit,
                                                                  const toliman_bank_options *options,
                                                                  toliman_bank **out) TOLIMAN_NOEXCEPT;

/* Destroys a bank. NULL is allowed. */
TOLIMAN_API void toliman_bank_destroy(toliman_bank *bank) TOLIMAN_NOEXCEPT;

/* Options of a training. */
typedef struct toliman_bank_train_options {
    uint32_t struct_size;
    uint32_t threads;             /* worker threads, 0 = one per processor */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    const char *journal; /* file to which each network is appended once it is trained; NULL: none. If the file exists,
                            its networks are not trained again. The caller removes it once the bank is saved.
                            formats.md, "TLMJ" */
} toliman_bank_train_options;
#define TOLIMAN_BANK_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_bank_train_options)

/* Trains the networks of a bank that are not trained yet, in the mode TOLIMAN_CAE_MODE_TIED. If the call is cancelled,
 * the networks that were complete remain trained, and a later call, also of a saved and loaded bank, trains the others.
 * Weights of a bank do not depend on threads or interruptions (promise: bank-training-resumes). With a journal, a
 * killed process loses at most one network per thread. fit: as for toliman_bank_encode. options may be NULL.
 * Errors: TOLIMAN_E_CANCELLED; TOLIMAN_E_MISMATCH as toliman_bank_encode, and for the journal of another bank, whose
 * message names what differs; TOLIMAN_E_FORMAT for any other file; TOLIMAN_E_STATE if another process writes to the
 * journal; TOLIMAN_E_WRITE if it cannot be written or read: what it holds remains. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_train(
    toliman_bank *bank, const toliman_fit *fit, const toliman_bank_train_options *options) TOLIMAN_NOEXCEPT;

/* Properties of a bank. */
typedef struct toliman_bank_info {
    uint32_t struct_size;         /* in: sizeof(toliman_bank_info) */
    uint32_t steps;               /* steps of the training of each network */
    int64_t networks;             /* dates times places */
    int64_t trained_networks;     /* number of them that are trained */
    int64_t dates, places;        /* as in toliman_bank_plan_info */
    double first_days, last_days; /* dates covered, days of scene time */
    double spacing_px;            /* as in the options, default resolved */
    int64_t rows, cols;           /* shape of the frames */
    const char *layout;           /* "flight" or "paper". Static text */
    uint64_t seed;                /* seed of the initial weights */
    uint64_t fit_digest;          /* toliman_fit_info.digest of the fit for which the bank was made */
    uint64_t digest;              /* FNV-1a of all that determines results: fit_digest, the stars' places of the
                                     networks, and weights */
} toliman_bank_info;
#define TOLIMAN_BANK_INFO_INIT TOLIMAN_INIT(toliman_bank_info)

/* Writes the properties of a bank to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_info(const toliman_bank *bank,
                                                                    toliman_bank_info *out) TOLIMAN_NOEXCEPT;

/* One network of a bank. */
typedef struct toliman_bank_network {
    uint32_t struct_size;         /* in: sizeof(toliman_bank_network) */
    int32_t trained;              /* 1: trained; 0: initial weights */
    double days;                  /* date for which it was made, days of scene time */
    double first_days, last_days; /* range of times for which no other date of the bank is nearer */
    double x_px, y_px;            /* shift of the scene's centre from its place in the scene, in [-0.5, 0.5) */
    double cosine;                /* of the angle between its gradient and the ideal one: its efficiency for stars at
                                     its own places, if the layout has no maximum pooling; 0 if untrained */
} toliman_bank_network;
#define TOLIMAN_BANK_NETWORK_INIT TOLIMAN_INIT(toliman_bank_network)

/* Writes network number `index`, 0 <= index < toliman_bank_info.networks, to *out, whose struct_size must be set. The
 * networks are ordered by date, then by place along y, then by place along x. TOLIMAN_E_RANGE for any other index. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_network(const toliman_bank *bank, int64_t index,
                                                                       toliman_bank_network *out) TOLIMAN_NOEXCEPT;

/* Flags of a result. */
#define TOLIMAN_BANK_NOT_FITTED 1u     /* the fit did not converge: all numbers of the result are NaN, network is -1 */
#define TOLIMAN_BANK_OUTSIDE 2u        /* the frame's time is outside the dates of the bank; the result is valid */
#define TOLIMAN_BANK_LOW_EFFICIENCY 4u /* efficiency below 0.95 */

/* Estimate for one frame. */
typedef struct toliman_bank_result {
    uint32_t struct_size;   /* in: sizeof(toliman_bank_result) */
    uint32_t flags;         /* TOLIMAN_BANK_... */
    double displacement_px; /* the latent: separation_px minus the predicted separation */
    double separation_px;   /* distance from A to B */
    double sigma_px;        /* standard deviation of separation_px and displacement_px due to the noise of the frame */
    double efficiency;      /* Cramer-Rao bound of the separation, with all parameters of the fit free, divided by
                               sigma_px: 0 to 1 */
    double distance_px;     /* distance between the stars' places in the frame and those of the network: root sum of
                               squares of the change of the place of B relative to A, and of the sub-pixel part of
                               the displacement of both */
    int64_t network;        /* index of the network with the smallest distance_px, -1 if not fitted */
    int32_t goodness;       /* verdict on chi_square, TOLIMAN_GOODNESS_...; UNKNOWN if not fitted */
    uint32_t bad_pixels;    /* left out by the fit and by the network */
    double chi_square, chi_square_sigma, largest_residual; /* of the fit, as in toliman_fit_result */
} toliman_bank_result;
#define TOLIMAN_BANK_RESULT_INIT TOLIMAN_INIT(toliman_bank_result)

/* Encodes `count` frames of image, on the threads of the bank's options; one frame on the calling thread. Encoding one
 * frame of doubles allocates memory only if more calls run at the same time than before.
 *   fit          fit of the scene, with the free parameters and capture_px, for which the bank was made
 *   image        finite counts, in the unit of the scene's frames (photons, electrons or DN)
 *   predictions  [count], times and expected places of the stars; NULL: time 0, no shift
 *   results      [count]; struct_size of the first must be set
 *   fitted       [count], results of the fits; struct_size of the first must be set; or NULL
 * A frame that cannot be fitted is not an error: see the flags. The result of a bank depends on the frame and its
 * prediction only (promise: bank-results-ignore-others). Errors: TOLIMAN_E_MISMATCH for any other fit
 * (toliman_fit_info.digest); others as toliman_fit_frame. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_encode(const toliman_bank *bank, const toliman_fit *fit,
                                                                  const toliman_image *image, size_t count,
                                                                  const toliman_fit_prediction *predictions,
                                                                  toliman_bank_result *results,
                                                                  toliman_fit_result *fitted) TOLIMAN_NOEXCEPT;

/* Writes the result of a frame without noise, with the stars at the places of the prediction (NULL: time 0, no shift),
 * to *out, whose struct_size must be set: network, efficiency and sigma_px; displacement_px is 0. Errors: as
 * toliman_bank_encode. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_predict(const toliman_bank *bank, const toliman_fit *fit,
                                                                   const toliman_fit_prediction *prediction,
                                                                   toliman_bank_result *out) TOLIMAN_NOEXCEPT;

/* Writes the time at which a bank should be renewed to *days, in days of scene time. It is the first of the times 1, 2,
 * 3, ... days after the last date of the bank at which the efficiency (toliman_bank_predict, no shift) is below
 * least_efficiency or the stars leave the model images of the fit; at most 4096 days after the last date. The search
 * assumes that the efficiency decreases with time. Errors: TOLIMAN_E_ARGUMENT if least_efficiency is not in (0, 1);
 * others as toliman_bank_predict. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_renewal(const toliman_bank *bank, const toliman_fit *fit,
                                                                       double least_efficiency,
                                                                       double *days) TOLIMAN_NOEXCEPT;

/* Saves a bank. encoding of the weights: TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32. *needed becomes
 * the number of bytes. The same bank always gives the same bytes, also after loading them
 * (promise: banks-save-same-bytes). Untrained networks are saved, too. TOLIMAN_E_CAPACITY if capacity is too small;
 * TOLIMAN_E_ARGUMENT for an unknown encoding. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_save(const toliman_bank *bank, int32_t encoding, void *bytes,
                                                                size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a bank from exactly `size` bytes. options may be NULL. The caller destroys *out. A bank has at most 1024
 * networks, of 0.8 MB in memory each. Wrong magic numbers, versions, layouts, sizes, checksums and numbers of a bank
 * are TOLIMAN_E_FORMAT (promise: damaged-banks-are-refused), also weights that are subnormal or above 2^100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_load(const void *bytes, size_t size,
                                                                const toliman_load_options *options,
                                                                toliman_bank **out) TOLIMAN_NOEXCEPT;

/* Saves a bank to a file; encoding as for toliman_bank_save. Replaces the file atomically; on failure (TOLIMAN_E_WRITE)
 * the old file remains. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_save_file(const toliman_bank *bank, int32_t encoding,
                                                                     const char *path) TOLIMAN_NOEXCEPT;

/* Loads a bank from a file. TOLIMAN_E_NOT_FOUND if it cannot be read; otherwise as toliman_bank_load. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_load_file(const char *path,
                                                                     const toliman_load_options *options,
                                                                     toliman_bank **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
