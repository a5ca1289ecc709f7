/* libtoliman, bank: networks (cae.h) that follow moving stars. A network is accurate only at the places of the stars
 * for which it was trained: a bank has networks for dates of an orbit and, at each date, for sub-pixel places of the
 * scene's centre. Each frame is fitted (fit.h) and encoded by the nearest network (decisions.md, 29).
 *
 * Data flow (toliman_bank_...)
 *
 *   toliman_sim -> plan -> number of networks, bytes, seconds
 *   toliman_fit -> create; load, load_file -> toliman_bank <-> train; save, save_file (formats.md, "TLMB"); destroy
 *   toliman_fit, frame, time -> encode                separation, px -> period.h
 *   toliman_fit, time        -> predict, get_renewal  efficiency to expect, until when to use
 *                               get_info, get_network properties
 *
 * Times are days of scene time (toliman_fit_prediction.time_days). */
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
    int32_t layout;               /* TOLIMAN_CAE_LAYOUT_..., 0 = as toliman_cae_options */
    double first_days, last_days; /* of the frames' times, in [-1e6, 1e6] days; both 0: 0 to the last frame of the
                                     scene */
    double spacing_px;            /* largest motion of B relative to A between dates, in [0.05, 4] px; 0 = 0.5 */
    uint32_t places;              /* sub-pixel places per axis, in [1, 8]; 0 = 3 */
    uint32_t steps;               /* of the first training, a third for others, in [1, 1e6]; 0 = 600 */
    uint64_t seed;                /* of the initial weights; 0 = 1 */
    const toliman_allocator *allocator;
    uint32_t threads;
    uint32_t reserved;
} toliman_bank_options;
#define TOLIMAN_BANK_OPTIONS_INIT TOLIMAN_INIT(toliman_bank_options)

/* Predicted size and cost of a bank. */
typedef struct toliman_bank_plan_info {
    uint32_t struct_size;
    uint32_t reserved;
    int64_t dates;  /* 1 for stars that do not move */
    int64_t places; /* per date */
    int64_t networks;
    double first_days, last_days;
    uint64_t bytes_float32; /* of the saved weights, before compression */
    uint64_t bytes_half;    /* as bf16 or fp16 */
    double train_s;         /* on one processor */
} toliman_bank_plan_info;
#define TOLIMAN_BANK_PLAN_INFO_INIT TOLIMAN_INIT(toliman_bank_plan_info)

/* Gets the plan of a bank. Errors: as toliman_bank_create, except that dates outside the model images are not found;
 * TOLIMAN_E_UNSUPPORTED for a single star. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_plan(const toliman_sim *sim,
                                                                const toliman_bank_options *options,
                                                                toliman_bank_plan_info *out) TOLIMAN_NOEXCEPT;

/* Creates a bank of untrained networks for the scene and the free parameters of a fit of one scene. An untrained bank
 * is a control: its efficiency is about 0.01.
 * Errors: TOLIMAN_E_ARGUMENT for dates at which the stars leave the model images (toliman_fit_create), more than 1024
 * networks; TOLIMAN_E_UNSUPPORTED for frames smaller than the crop of the layout or larger than 4096 x 4096 px. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_create(const toliman_fit *fit,
                                                                  const toliman_bank_options *options,
                                                                  toliman_bank **out) TOLIMAN_NOEXCEPT;

/* Destroys a bank. */
TOLIMAN_API void toliman_bank_destroy(toliman_bank *bank) TOLIMAN_NOEXCEPT;

/* Options of a training. */
typedef struct toliman_bank_train_options {
    uint32_t struct_size;
    uint32_t threads;
    toliman_progress_fn progress;
    void *progress_data;
    const char *journal; /* file to which each trained network is written (formats.md, "TLMJ"); a later call does not
                            train it again. NULL: none. The caller removes the file once the bank is saved */
} toliman_bank_train_options;
#define TOLIMAN_BANK_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_bank_train_options)

/* Trains the networks that are not trained yet (TOLIMAN_CAE_MODE_TIED), also after a cancelled call or loading. Weights
 * of a bank do not depend on threads or interruptions (promise: bank-training-resumes). With a journal, a killed
 * process loses at most one network per thread.
 * Errors: TOLIMAN_E_MISMATCH for any other fit (toliman_fit_info.digest) or the journal of another bank, naming what
 * differs; those of a journal as toliman_calibration_create. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_train(
    toliman_bank *bank, const toliman_fit *fit, const toliman_bank_train_options *options) TOLIMAN_NOEXCEPT;

/* Properties of a bank. */
typedef struct toliman_bank_info {
    uint32_t struct_size;
    uint32_t steps;
    int64_t networks;
    int64_t trained_networks;
    int64_t dates, places;
    double first_days, last_days;
    double spacing_px;
    int64_t rows, cols;
    const char *layout; /* "flight", "paper" or "core" */
    uint64_t seed;
    uint64_t fit_digest;
    uint64_t digest; /* FNV-1a of all that determines results */
} toliman_bank_info;
#define TOLIMAN_BANK_INFO_INIT TOLIMAN_INIT(toliman_bank_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_info(const toliman_bank *bank,
                                                                    toliman_bank_info *out) TOLIMAN_NOEXCEPT;

/* One network of a bank. */
typedef struct toliman_bank_network {
    uint32_t struct_size;
    int32_t trained; /* 0: initial weights */
    double days;
    double first_days, last_days; /* times to which no other date is nearer */
    double x_px, y_px;            /* shift of the scene's centre, in [-0.5, 0.5) */
    double cosine;                /* efficiency at its places; 0 if untrained */
} toliman_bank_network;
#define TOLIMAN_BANK_NETWORK_INIT TOLIMAN_INIT(toliman_bank_network)

/* Gets network `index` < toliman_bank_info.networks, in the order of date, y, x. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_network(const toliman_bank *bank, int64_t index,
                                                                       toliman_bank_network *out) TOLIMAN_NOEXCEPT;

#define TOLIMAN_BANK_NOT_FITTED 1u     /* no fit: numbers are NaN, network is -1 */
#define TOLIMAN_BANK_OUTSIDE 2u        /* time outside the dates of the bank; the result is valid */
#define TOLIMAN_BANK_LOW_EFFICIENCY 4u /* efficiency below 0.95 */

/* Estimate for one frame. */
typedef struct toliman_bank_result {
    uint32_t struct_size;
    uint32_t flags;
    double displacement_px; /* separation_px minus the predicted separation */
    double separation_px;
    double sigma_px;     /* of both, due to the noise of the frame */
    double efficiency;   /* Cramer-Rao bound with the parameters of the fit free / sigma_px */
    double distance_px;  /* of the stars' places from those of the network: root of the sum of squares of the
                            differences in B relative to A and in the sub-pixel shift */
    int64_t network;     /* that of the smallest distance_px */
    int32_t goodness;    /* of the fit */
    uint32_t bad_pixels; /* of fit and network */
    double chi_square, chi_square_sigma, largest_residual;
} toliman_bank_result;
#define TOLIMAN_BANK_RESULT_INIT TOLIMAN_INIT(toliman_bank_result)

/* Encodes `count` frames of image; a call with one frame allocates memory only if more calls run at the same time than
 * ever before. A frame that cannot be fitted is not an error: see the flags. The result of a bank depends on the frame
 * and its prediction only (promise: bank-results-ignore-others).
 *   fit          with the scene, free parameters and capture_px of the bank's fit
 *   image        in the unit of the scene's frames
 *   predictions  [count]; NULL: time 0, no shift
 *   results      [count]
 *   fitted       [count], results of the fits, or NULL
 * Errors: TOLIMAN_E_MISMATCH for any other fit; others as toliman_fit_frame. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_encode(const toliman_bank *bank, const toliman_fit *fit,
                                                                  const toliman_image *image, size_t count,
                                                                  const toliman_fit_prediction *predictions,
                                                                  toliman_bank_result *results,
                                                                  toliman_fit_result *fitted) TOLIMAN_NOEXCEPT;

/* Gets network, efficiency and sigma_px for a noise-free frame of this prediction (NULL: time 0, no shift). Errors: as
 * toliman_bank_encode. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_predict(const toliman_bank *bank, const toliman_fit *fit,
                                                                   const toliman_fit_prediction *prediction,
                                                                   toliman_bank_result *out) TOLIMAN_NOEXCEPT;

/* Gets the time at which to renew a bank: the first of 1, 2, ... 4096 days after its last date at which the efficiency,
 * assumed to decrease, is below least_efficiency, in (0, 1), or the stars leave the model images. Errors: as
 * toliman_bank_predict. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_get_renewal(const toliman_bank *bank, const toliman_fit *fit,
                                                                       double least_efficiency,
                                                                       double *days) TOLIMAN_NOEXCEPT;

/* Saves a bank, untrained networks included. encoding: of the weights, TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32. The same
 * bank always gives the same bytes, also after loading them (promise: banks-save-same-bytes). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_save(const toliman_bank *bank, int32_t encoding, void *bytes,
                                                                size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a bank; a network takes 0.8 MB, of layout CORE 0.4 MB. Damaged bytes, other versions and layouts, and numbers
 * that are subnormal or above 2^100 are TOLIMAN_E_FORMAT (promise: damaged-banks-are-refused). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_load(const void *bytes, size_t size,
                                                                const toliman_load_options *options,
                                                                toliman_bank **out) TOLIMAN_NOEXCEPT;

/* As toliman_bank_save and _load, with a file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_save_file(const toliman_bank *bank, int32_t encoding,
                                                                     const char *path) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_bank_load_file(const char *path,
                                                                     const toliman_load_options *options,
                                                                     toliman_bank **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
