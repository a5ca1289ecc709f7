/* libtoliman, convolutional autoencoder (CAE): compresses a crop of a frame to one number, the latent: the displacement
 * (the separation of the stars minus that of the undisturbed scene), in px. For frames of a downlink use track.h.
 *
 * Data flow (toliman_cae_...)
 *
 *   toliman_sim -> create; weights blob -> load, load_file -> toliman_cae <-> train; get_info, destroy
 *   encode                          latent, px -> period.h
 *   decode, reconstruct, get_target decoder output and training target
 *   save, save_file                 weights blob
 *
 * A network contains the preprocessing of its scene: crop, reference image, variance, nuisance images, input scale. */
#ifndef TOLIMAN_CAE_H
#define TOLIMAN_CAE_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Network with the preprocessing of its scene. */
typedef struct toliman_cae toliman_cae;

/* Layouts: size of the crop and pooling. */
#define TOLIMAN_CAE_LAYOUT_FLIGHT 201 /* 256x256; 2x2 mean before ELU, up-sampling; reaches the photon limit */
/* Layout of the chapter, 256x256: 2x2 max pooling, un-pooling at the positions of the maxima in the frame, so that
 * toliman_cae_decode is not available. */
#define TOLIMAN_CAE_LAYOUT_PAPER 202
#define TOLIMAN_CAE_LAYOUT_CORE 203 /* FLIGHT for the 128x128 windows of the camera */

/* Inputs: scaling of the crop. */
#define TOLIMAN_CAE_INPUT_WHITENED 211 /* (counts - reference)/sigma, nuisances projected out */
#define TOLIMAN_CAE_INPUT_RESIDUAL 212 /* (counts - reference)/mean sigma of the frame */
#define TOLIMAN_CAE_INPUT_RAW 213      /* counts; the reference image spans 0..1, as in the chapter */

/* Place of the crop: the barycentre of the scene's light, to half a pixel. */
#define TOLIMAN_CAE_CENTRE_SCENE 241
/* Moved by whole pixels to the barycentre of the frame's light above the scene's uniform background, for pointing that
 * wanders. A fraction remains: project out the shift, or train on such frames. */
#define TOLIMAN_CAE_CENTRE_IMAGE 242

/* Options of a network. */
typedef struct toliman_cae_options {
    uint32_t struct_size;
    int32_t
        layout;    /* TOLIMAN_CAE_LAYOUT_..., 0 = CORE if the frames have fewer than 256 rows or columns, else FLIGHT */
    int32_t input; /* TOLIMAN_CAE_INPUT_..., 0 = WHITENED */
    uint32_t threads;
    const toliman_allocator *allocator;
    toliman_log_fn log; /* receives warnings about preprocess.project */
    void *log_data;
    int32_t centre; /* TOLIMAN_CAE_CENTRE_..., 0 = SCENE */
    uint32_t reserved;
} toliman_cae_options;
#define TOLIMAN_CAE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_options)

/* Creates a network with the preprocessing of a scene and random weights of seed. With mean pooling and input WHITENED
 * its latent is scaled to px (an untrained control), otherwise it has no unit.
 * Errors: TOLIMAN_E_UNSUPPORTED for frames smaller than the crop, preprocess.project with another input than WHITENED,
 * CENTRE_IMAGE with frames of the crop's size; TOLIMAN_E_SCENE if the nuisances span the derivative of the signal.
 *
 * An image of preprocess.project is dropped if less than 1e-10 of its norm remains after the projection of those before
 * it. The log warns of it, and of an image whose norm falls below 1e-2 by the projection of all others. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_create(const toliman_sim *sim, uint64_t seed,
                                                                 const toliman_cae_options *options,
                                                                 toliman_cae **out) TOLIMAN_NOEXCEPT;

/* Destroys a network. */
TOLIMAN_API void toliman_cae_destroy(toliman_cae *cae) TOLIMAN_NOEXCEPT;

/* Training mode TIED: the encoder is the transpose of the decoder, which is fitted to the whitened derivative image.
 * Needs no frames, layout FLIGHT or CORE and input WHITENED. Tied training does not diverge at any learning rate
 * (promise: tied-training-never-diverges). The predicted efficiency (cosine) is 0.99 for the scenes chapter and mission
 * from any seed (promise: tied-efficiency-is-stated). */
#define TOLIMAN_CAE_MODE_TIED 221
/* Training mode UNSUPERVISED, of the chapter: minimises the mean squared error between input and output over frames.
 * The latent has no unit and an arbitrary sign. */
#define TOLIMAN_CAE_MODE_UNSUPERVISED 222

/* Callback that fills counts[count][rows][cols] with training frames first ... first + count - 1, the same each time,
 * and returns TOLIMAN_OK. Any other status stops the training, which returns it. */
typedef toliman_status (*toliman_frames_fn)(size_t first, size_t count, double *counts, void *user_data);

/* Training result. UNSUPERVISED: epochs, validation_loss, mmse, mssim, photon_floor; TIED: cosine; otherwise 0. */
typedef struct toliman_cae_training {
    uint32_t struct_size;
    uint32_t steps; /* in all, like epochs */
    uint32_t epochs;
    uint32_t reserved;
    double loss;            /* TIED: squared distance of the unit target from the decoder output, 0.02 when well
                               trained. UNSUPERVISED: mean squared error of the last epoch, in units of the input */
    double cosine;          /* predicted Cramer-Rao bound / standard deviation of the latent */
    double validation_loss; /* of the validation frames */
    double mmse, mssim;     /* means over these, as toliman_cae_reconstruct */
    double photon_floor;    /* likewise */
} toliman_cae_training;
#define TOLIMAN_CAE_TRAINING_INIT TOLIMAN_INIT(toliman_cae_training)

/* Callback after each epoch of UNSUPERVISED training. so_far has the weights of this epoch; it may encode and be saved
 * with its training state. Both pointers are valid during the callback. Nonzero cancels the training, which can be
 * resumed after this epoch. */
typedef int32_t (*toliman_epoch_fn)(const toliman_cae *so_far, const toliman_cae_training *result, void *user_data);

/* Options of a training; from `frames` to `threads`, and `epoch`: UNSUPERVISED only. */
typedef struct toliman_cae_train_options {
    uint32_t struct_size;
    int32_t mode;   /* TOLIMAN_CAE_MODE_..., 0 = TIED */
    uint32_t steps; /* UNSUPERVISED: epochs in all; 0 = 300 */
    uint32_t reserved;
    double learning_rate; /* in (0, 1]; 0 = 0.08 (TIED), 1e-3 (UNSUPERVISED). TIED: largest rotation of a weight
                             tensor per step in rad, decreasing linearly to 0. UNSUPERVISED: constant, of Adam */
    toliman_progress_fn progress;
    void *progress_data;
    toliman_frames_fn frames; /* required; inputs are kept in memory, 4 bytes per pixel of the crop */
    void *frames_data;
    size_t frame_count;
    size_t validation; /* frames held out, chosen by the seed; 0 = a tenth, rounded to nearest, or 1 */
    uint32_t batch;    /* frames per step of Adam, in [1, 4096]; 0 = 16 */
    uint32_t threads;
    double *losses; /* [loss_count] or NULL: [k] receives the loss after step or epoch k + 1 if this call computes it */
    size_t loss_count;
    toliman_epoch_fn epoch; /* with it, validation frames are requested and reconstructed after each epoch */
    void *epoch_data;
} toliman_cae_train_options;
#define TOLIMAN_CAE_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_train_options)

/* Trains a network, or resumes its last training. report may be NULL.
 *
 * A cancelled training resumes to the same bits after its last step (TIED) or epoch
 * (promise: cancelled-training-resumes) if mode, steps, learning rate, batch and numbers of frames are unchanged. After
 * a finished one, UNSUPERVISED continues for more epochs; with the same options its result is returned. Other options
 * start again from the network's seed. If a training fails, the network keeps its weights
 * (promise: failed-training-keeps-weights).
 * Errors: TOLIMAN_E_RANGE if UNSUPERVISED diverges, or the target of a loaded network leads to weights out of range;
 * TOLIMAN_E_UNSUPPORTED for TIED with another layout or input; TOLIMAN_E_STATE if the target of a loaded network is
 * 0. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_train(toliman_cae *cae,
                                                                const toliman_cae_train_options *options,
                                                                toliman_cae_training *report) TOLIMAN_NOEXCEPT;

/* Properties of a network. */
typedef struct toliman_cae_info {
    uint32_t struct_size;
    int32_t trained;    /* 0 or 1 */
    const char *layout; /* "flight", "paper" or "core" */
    uint64_t layout_hash;
    uint64_t scene_digest;
    uint64_t parameters;
    int64_t rows, cols;
    int64_t crop_row, crop_col; /* of the crop in the scene's image */
    uint32_t projected;         /* that are projected out */
    int32_t input;              /* TOLIMAN_CAE_INPUT_... */
    double crb_px;              /* Cramer-Rao bound with these unknown */
    double cosine;              /* as in toliman_cae_training; 0 before training */
    double input_scale;         /* of the first convolution: 1e-3 for TIED, else 1 */
    uint64_t seed;
    int32_t centre; /* TOLIMAN_CAE_CENTRE_... */
    uint32_t side;  /* rows and columns of the crop */
} toliman_cae_info;
#define TOLIMAN_CAE_INFO_INIT TOLIMAN_INIT(toliman_cae_info)

/* Gets the properties of a network.
 *   resumable  or NULL: options of the training that can be resumed, without callbacks; all 0 if there is none.
 *              UNSUPERVISED: steps is the number of completed epochs; set it to the total that is wanted */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_info(const toliman_cae *cae,
                                                                   toliman_cae_train_options *resumable,
                                                                   toliman_cae_info *out) TOLIMAN_NOEXCEPT;

/* Encodes `count` frames of image. A latent does not depend on the other frames (promise: latents-ignore-other-frames).
 * Encoding one frame of doubles allocates no memory (promise: encoding-allocates-nothing), except once per simultaneous
 * call. Bad pixels get the counts of a linear fit to the others.
 *   latents_px  [count]
 *   goodness    [count] or NULL, of this fit: with r = (counts - reference)/sigma, K orthonormal nuisance images u_k
 *               and the target t, chi_square is
 *
 *     |r - sum_k <u_k, r> u_k - <t, r> t/|t|^2|^2 / (pixels of the crop - K - 1)
 *
 * The slope of latent over displacement is 1 for small displacements; latent/displacement is about 0.9996 at 1e-4 px,
 * 0.996 at 1e-3 px and 0.96 at 1e-2 px (promise: latent-slope-is-stated); between trainings, its deviation from 1
 * varies by a third.
 * Errors: image.h, for counts in the crop; TOLIMAN_E_ARGUMENT with CENTRE_IMAGE for a crop without light;
 * TOLIMAN_E_RANGE if the latent overflows. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_encode(const toliman_cae *cae, const toliman_image *image,
                                                                 size_t count, double *latents_px,
                                                                 toliman_frame_goodness *goodness) TOLIMAN_NOEXCEPT;

/* Decodes a latent to image[side][stride]: with input WHITENED the whitened residual, in standard deviations, linear up
 * to 1 px, otherwise in the scaling of the input.
 * Errors: TOLIMAN_E_UNSUPPORTED for layout PAPER; TOLIMAN_E_ARGUMENT if |latent_px| > 1e6; TOLIMAN_E_RANGE if the
 * output overflows. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_decode(const toliman_cae *cae, double latent_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Writes the training target to image[side][stride], per px: the whitened derivative image with nuisances projected
 * out. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_target(const toliman_cae *cae, double *image,
                                                                     size_t stride) TOLIMAN_NOEXCEPT;

/* Reconstructs a frame: encodes counts[rows][counts_stride] and decodes the latent to image[side][stride], in counts,
 * without nuisances that were projected out. The last three may be NULL.
 *   mmse, mssim   mean squared error and mean structural similarity (Wang et al. 2004, Gaussian window of 1.5 px) of
 *                 crop and reconstruction, scaled to 0..1 by the extremes of the crop
 *   photon_floor  mmse expected from noise alone
 * Errors: as toliman_cae_encode; TOLIMAN_E_ARGUMENT for a constant frame if one of the three is requested;
 * TOLIMAN_E_RANGE if the latent exceeds 1e6 px or a result overflows. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_reconstruct(const toliman_cae *cae, const double *counts,
                                                                      size_t counts_stride, double *image,
                                                                      size_t stride, double *mmse, double *mssim,
                                                                      double *photon_floor) TOLIMAN_NOEXCEPT;

/* Number formats of a weights blob (formats.md). The reference image is always float32. */
#define TOLIMAN_CAE_ENCODING_FLOAT32 231
#define TOLIMAN_CAE_ENCODING_BF16 232 /* half the size, 8-bit significand */
#define TOLIMAN_CAE_ENCODING_FP16 233 /* half the size, 11-bit significand */

/* Options of toliman_cae_save. */
typedef struct toliman_cae_save_options {
    uint32_t struct_size;
    int32_t weights_encoding; /* TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32 */
    int32_t planes_encoding;  /* of variance, target and nuisance images: TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32 */
    int32_t with_training;    /* 0 or 1: with the training state, for toliman_cae_train to resume */
} toliman_cae_save_options;
#define TOLIMAN_CAE_SAVE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_save_options)

/* Saves a network as a weights blob (formats.md, "TLMW"). The same network always gives the same bytes, also after
 * loading them (promise: networks-save-same-bytes). TOLIMAN_E_RANGE for numbers above 2^100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save(const toliman_cae *cae,
                                                               const toliman_cae_save_options *options, void *bytes,
                                                               size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a network. Loading never allocates more than the layout implies (promise: weights-have-bounded-memory). Damaged
 * bytes, other versions and layouts, and numbers that are subnormal or above 2^100 are TOLIMAN_E_FORMAT
 * (promise: damaged-weights-are-refused). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load(const void *bytes, size_t size,
                                                               const toliman_load_options *options,
                                                               toliman_cae **out) TOLIMAN_NOEXCEPT;

/* As toliman_cae_save and _load, with a file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save_file(const toliman_cae *cae,
                                                                    const toliman_cae_save_options *options,
                                                                    const char *path) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load_file(const char *path,
                                                                    const toliman_load_options *options,
                                                                    toliman_cae **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
