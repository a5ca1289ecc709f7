/* libtoliman, convolutional autoencoder: one frame of 256x256 counts in, one number out: the separation in pixels.
 *
 * Frames that may come twice, late or damaged belong to track.h: a frame that is encoded twice counts as two samples.
 *
 * Data flow (functions toliman_cae_...)
 *
 *   toliman_sim -> create      weights -> load, load_file
 *   (options_init)    |                     |
 *                     +----------+----------+
 *                                v
 *                           toliman_cae <-> train                    (train_options_init)
 *                                +-> encode, encode_many             latent, px -> period.h
 *                                +-> decode, reconstruct, get_target what it sees of a frame
 *                                +-> get_info, get_train_options     facts
 *                                +-> save, save_file                 weights (save_options_init)
 *                             destroy
 *
 * A network knows its scene: the preprocessing (crop, reference, variance, nuisance planes, input scale) is part of it,
 * trained and flown as one, and stored whole in the weights blob (formats.md, "TLMW").
 */
#ifndef TOLIMAN_CAE_H
#define TOLIMAN_CAE_H

#include <toliman/base.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* A network. Const calls may run on one network from several threads. Since 0.1. */
typedef struct toliman_cae toliman_cae;

/* Layouts, fixed at compile time: four stages of 3x3 convolutions with 8, 16, 32 and 64 channels, a dense layer to the
 * latent, and the same way back.
 *   FLIGHT  2x2 mean before ELU on the way down, up-sampling on the way back: reaches the photon limit
 *   PAPER   the chapter's: 2x2 maximum after ELU, un-pooling with the maxima's places. Those belong to a frame, so
 *           that there is toliman_cae_reconstruct but no toliman_cae_decode */
#define TOLIMAN_CAE_LAYOUT_FLIGHT 201
#define TOLIMAN_CAE_LAYOUT_PAPER 202

/* What the network sees of a frame's 256x256 crop.
 *   WHITENED  (counts - reference)/sigma of each pixel, less what preprocess.project names
 *   RESIDUAL  (counts - reference)/mean sigma of the frame
 *   RAW       counts scaled so that the reference spans 0 to 1, as in the chapter */
#define TOLIMAN_CAE_INPUT_WHITENED 211
#define TOLIMAN_CAE_INPUT_RESIDUAL 212
#define TOLIMAN_CAE_INPUT_RAW 213

/* What a network is. Since 0.1. */
typedef struct toliman_cae_options {
    uint32_t struct_size;
    int32_t layout;    /* 0 = TOLIMAN_CAE_LAYOUT_FLIGHT, or TOLIMAN_CAE_LAYOUT_PAPER */
    int32_t input;     /* 0 = TOLIMAN_CAE_INPUT_WHITENED, or TOLIMAN_CAE_INPUT_RESIDUAL, TOLIMAN_CAE_INPUT_RAW */
    uint32_t reserved; /* 0 */
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
} toliman_cae_options;
#define TOLIMAN_CAE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_cae_options_init(toliman_cae_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Network with random weights drawn from seed, preprocessing taken from the scene; sim is not kept; options may be
 * NULL. With FLIGHT and WHITENED, the defaults, its latent is scaled to pixels along the scene's signal, so that it may
 * be encoded with as it is: the untrained control. Otherwise the latent has no unit. TOLIMAN_E_UNSUPPORTED when frames
 * are smaller than 256x256 or preprocess.project meets an input that is not whitened, TOLIMAN_E_SCENE when its
 * nuisances leave nothing of the signal's derivative. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_create(const toliman_sim *sim, uint64_t seed,
                                                                 const toliman_cae_options *options,
                                                                 toliman_cae **out) TOLIMAN_NOEXCEPT;

/* Ends a network; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_cae_destroy(toliman_cae *cae) TOLIMAN_NOEXCEPT;

/* Ways to train.
 *   TIED          layout FLIGHT and WHITENED input: the linear decoder, whose kernels are the encoder's transposed, is
 *                 fitted to the whitened derivative image; then both halves are scaled so that the latent is the
 *                 separation in px. A step turns each tensor along its momentum, made orthogonal from channel to
 *                 channel (after Jordan et al. 2024, "Muon"); lengths stay, so that no learning rate diverges. The
 *                 cosine of the shipped scenes is 0.99 from any seed. Needs no data set and no noise
 *   UNSUPERVISED  the chapter's: mean squared error between input and output over frames that the caller gives, without
 *                 any prior. The latent then has no unit and may have either sign */
#define TOLIMAN_CAE_MODE_TIED 221
#define TOLIMAN_CAE_MODE_UNSUPERVISED 222

/* Frames from the caller: fills counts[count][rows][cols] with frames first, first + 1, ... and returns TOLIMAN_OK; any
 * other status ends the running call with it. The same frame must be the same each time, also when a training is taken
 * up. Called on the caller's thread, with no lock held; may not train or destroy the network, nor may `progress`. Since
 * 0.1. */
typedef toliman_status (*toliman_frames_fn)(size_t first, size_t count, double *counts, void *user_data);

/* How to train; 0 is the default throughout. Since 0.1. */
typedef struct toliman_cae_train_options {
    uint32_t struct_size;
    int32_t mode;         /* 0 = TOLIMAN_CAE_MODE_TIED, or TOLIMAN_CAE_MODE_UNSUPERVISED */
    uint32_t steps;       /* TIED: 0 = 300 */
    uint32_t epochs;      /* UNSUPERVISED: passes over the training frames, in all; 0 = 300 */
    double learning_rate; /* in [0, 1]; TIED: 0 = 0.08, rad, the most a step turns a tensor, falls linearly to 0;
                             UNSUPERVISED: 0 = 1e-3, of Adam, constant */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    toliman_frames_fn frames; /* UNSUPERVISED: at least 2 frames; the input of all is kept in memory, 256 KiB each */
    void *frames_data;
    uint64_t frame_count;
    uint64_t validation; /* of them, drawn from the seed and kept back; 0 = a tenth, at least 1 */
    uint32_t batch;      /* UNSUPERVISED: frames a step of Adam, at most 4096; 0 = 16 */
    uint32_t threads;    /* UNSUPERVISED: workers, 0 = one a processor; the same bits for any number */
    double *losses;      /* [loss_count], may be NULL: losses[k] becomes that after step (TIED) or epoch k + 1 */
    uint64_t loss_count; /* what is beyond them, or was done before a training is taken up, is not written */
} toliman_cae_train_options;
#define TOLIMAN_CAE_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_train_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_cae_train_options_init(toliman_cae_train_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* What a training came to. Since 0.1. */
typedef struct toliman_cae_training {
    uint32_t struct_size;   /* in: sizeof(toliman_cae_training) */
    uint32_t steps;         /* in all */
    uint32_t epochs;        /* UNSUPERVISED: in all; else 0 */
    uint32_t reserved;      /* 0 */
    double loss;            /* TIED: squared distance of the unit target and its part along the painted image, 0.02
                               when well trained; UNSUPERVISED: mean squared error of the last epoch, in units of the
                               input */
    double cosine;          /* TIED: between d latent/d residual and the whitened derivative, the predicted efficiency;
                               else 0 */
    double validation_loss; /* UNSUPERVISED: of the frames kept back; else 0, and so the next three */
    double mmse, mssim;     /* means over those frames, as of toliman_cae_reconstruct */
    double photon_floor;
} toliman_cae_training;
#define TOLIMAN_CAE_TRAINING_INIT TOLIMAN_INIT(toliman_cae_training)

/* Trains from the network's own seed, or goes on: a training that was cancelled is taken up where it stood, and an
 * unsupervised one can be given more epochs, when mode, steps, learning rate, batch and numbers of frames are as before
 * (toliman_cae_get_train_options); anything else starts anew. options and report may be NULL. On any failure the
 * network is as before, and its last training too, unless the new one has done a step (TIED) or an epoch
 * (UNSUPERVISED): then that can be taken up. TOLIMAN_E_CANCELLED, TOLIMAN_E_RANGE when a learning rate makes
 * UNSUPERVISED diverge or a loaded target leaves weights out of range, TOLIMAN_E_UNSUPPORTED for TIED with another
 * layout or input, TOLIMAN_E_STATE when a loaded network has no signal to be trained on. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_train(toliman_cae *cae,
                                                                const toliman_cae_train_options *options,
                                                                toliman_cae_training *report) TOLIMAN_NOEXCEPT;

/* Options of the training that toliman_cae_train can go on with: mode, steps, learning_rate, frame_count, validation
 * and batch as they were, epochs those that are done; no callbacks. out->struct_size must be set. TOLIMAN_E_STATE when
 * there is none: nothing was trained, or the blob was saved without. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_cae_get_train_options(const toliman_cae *cae, toliman_cae_train_options *out) TOLIMAN_NOEXCEPT;

/* Facts of a network. Since 0.1. */
typedef struct toliman_cae_info {
    uint32_t struct_size;       /* in: sizeof(toliman_cae_info) */
    uint32_t trained;           /* 0 or 1 */
    const char *layout;         /* "flight" or "paper"; static text */
    uint64_t layout_hash;       /* FNV-1a of the layout's tensor table */
    uint64_t scene_digest;      /* of the scene the preprocessing came from */
    uint64_t parameters;        /* number of weights */
    int64_t rows, cols;         /* of the frames it takes */
    int64_t crop_row, crop_col; /* first row and column of the 256x256 crop */
    uint32_t projected;         /* nuisance images projected out */
    int32_t input;              /* TOLIMAN_CAE_INPUT_WHITENED, ... */
    double crb_px;              /* Cramer-Rao bound with exactly those free */
    double cosine;              /* after training; 0 before */
    double input_scale;         /* factor between the input and the first convolution: 1e-3 for TIED, else 1 */
    uint64_t seed;              /* of the random weights */
} toliman_cae_info;
#define TOLIMAN_CAE_INFO_INIT TOLIMAN_INIT(toliman_cae_info)

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_info(const toliman_cae *cae,
                                                                   toliman_cae_info *out) TOLIMAN_NOEXCEPT;

/* Latent (px) of one frame of counts[rows][stride]. TOLIMAN_E_ARGUMENT for a non-finite count in the crop, with its row
 * and column; TOLIMAN_E_RANGE for counts so far from the scene's that the latent overflows. The slope is 1 for small
 * displacements. Frames brighter or fainter than the scene's are off by what preprocess.project would project out, and
 * by far more than their slope: the chapter's by -6e-6 px for 0.1 % more light. ELU bends latent over displacement to
 * about 0.9996 at 1e-4 px, 0.996 at 1e-3 and 0.96 at 1e-2, and to 0.9996, 0.997 and 0.97 at the same negative ones
 * (chapter's scene; in another training it bends a third more or less). Allocates nothing that lasts. Since 0.1.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_encode(const toliman_cae *cae, const double *counts,
                                                                 size_t stride, double *latent_px) TOLIMAN_NOEXCEPT;

/* Latents of `count` frames of image on `threads` workers (0 = one per processor): the bits of toliman_cae_encode for
 * the same counts, for any number of workers. Unless it is NULL, chi_square[count] becomes the mean square per degree
 * of freedom of what the scene's linear model leaves of each frame's crop,
 *
 *   |r - sum_k <u_k, r> u_k - <t, r> t/|t|^2|^2 / (65536 - K - 1),    r = (counts - reference)/sigma per pixel.
 *
 * u_k are the K orthonormal images that are projected out, t is that of toliman_cae_get_target. Weights and input do
 * not enter. Frames of the scene have 1 with the standard deviation sqrt(2/65536), damaged ones far more; see
 * toliman_linear_encode_many. Errors as of toliman_cae_encode, with the number of the frame; TOLIMAN_E_ARGUMENT for an
 * image of another shape, TOLIMAN_E_RANGE for one that does not fit in memory. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_encode_many(const toliman_cae *cae,
                                                                      const toliman_image *image, size_t count,
                                                                      uint32_t threads, double *latents_px,
                                                                      double *chi_square) TOLIMAN_NOEXCEPT;

/* Whitened residual image[256][stride] (dimensionless, in sigmas of a pixel) that the decoder paints for a latent in
 * px; linear in it up to 1 px. With another input, the input that it paints. TOLIMAN_E_UNSUPPORTED for layout PAPER;
 * |latent_px| <= 1e6, else TOLIMAN_E_ARGUMENT; TOLIMAN_E_RANGE when a loaded network's
 * weights are so large that it overflows. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_decode(const toliman_cae *cae, double latent_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Whitened, projected derivative image[256][stride], per px: what the decoder should paint for a latent of 1. Since
 * 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_target(const toliman_cae *cae, double *image,
                                                                     size_t stride) TOLIMAN_NOEXCEPT;

/* The frame as the network sees it again, image[256][stride] in counts: what the decoder paints for the frame's latent,
 * with whitened input times sqrt(variance) and added to the reference; what was projected out stays away. mmse and
 * mssim (either may be NULL) compare it with the frame, both scaled to 0..1 by the frame's own extremes: mean squared
 * error, and mean structural similarity (Wang et al. 2004: 11x11 Gaussian window of 1.5 px, K1 0.01, K2 0.03, over the
 * pixels whose whole window lies in the image). photon_floor (may be NULL) is the mmse that noise alone leaves. With
 * any of the three a constant frame is TOLIMAN_E_ARGUMENT. Errors as of toliman_cae_encode; TOLIMAN_E_RANGE also for
 * counts so far from the scene's that their latent is beyond 1e6 or a result overflows. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_reconstruct(const toliman_cae *cae, const double *counts,
                                                                      size_t counts_stride, double *image,
                                                                      size_t stride, double *mmse, double *mssim,
                                                                      double *photon_floor) TOLIMAN_NOEXCEPT;

/* How the numbers of a blob are stored: float32 keeps every bit, bf16 and fp16 round to 8 and 11 bits and take half the
 * bytes. The reference image is float32 whatever is chosen, as its errors would stand in every latent. formats.md
 * has the bytes and what each costs in accuracy. Since 0.1. */
#define TOLIMAN_CAE_ENCODING_FLOAT32 231
#define TOLIMAN_CAE_ENCODING_BF16 232
#define TOLIMAN_CAE_ENCODING_FP16 233

/* What a blob holds. Since 0.1. */
typedef struct toliman_cae_save_options {
    uint32_t struct_size;
    int32_t weights_encoding; /* TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32 */
    int32_t planes_encoding;  /* of variance, target and nuisance images; 0 = FLOAT32 */
    uint32_t training;        /* 0 = nothing of it; 1: also where the last training stands, for toliman_cae_train to go
                                 on with */
} toliman_cae_save_options;
#define TOLIMAN_CAE_SAVE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_save_options)

/* Fills *options, which has `size` bytes, with the defaults: float32. Since 0.1. */
TOLIMAN_API void toliman_cae_save_options_init(toliman_cae_save_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Weights blob; options NULL = the defaults. With bytes NULL only *needed is set; otherwise capacity must be at least
 * that (TOLIMAN_E_CAPACITY). The same network gives the same bytes, and so does the network loaded from them.
 * TOLIMAN_E_RANGE for numbers above 2^100, which no blob holds. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save(const toliman_cae *cae,
                                                               const toliman_cae_save_options *options, void *bytes,
                                                               size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Network from a blob of exactly size bytes. TOLIMAN_E_FORMAT for a wrong magic, version, layout, size or checksum and
 * for numbers that are not finite, above 2^100 or subnormal; nothing larger than the layout implies is allocated.
 * options may be NULL. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load(const void *bytes, size_t size,
                                                               const toliman_load_options *options,
                                                               toliman_cae **out) TOLIMAN_NOEXCEPT;

/* The same to and from a file; saving replaces it as a whole or not at all (TOLIMAN_E_WRITE). Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save_file(const toliman_cae *cae,
                                                                    const toliman_cae_save_options *options,
                                                                    const char *path) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load_file(const char *path,
                                                                    const toliman_load_options *options,
                                                                    toliman_cae **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
