/* libtoliman, convolutional autoencoder (CAE): compresses the 256x256 crop of a frame to one number, the latent. The
 * latent measures the displacement: the separation of the stars minus that of the undisturbed scene, in px.
 *
 * The encoder does not recognise repeated frames: if both latents are pushed to a periodogram, they count as two
 * samples. For downlinked frames, which may be duplicated, out of order or damaged, use track.h.
 *
 * Data flow (functions toliman_cae_...)
 *
 *   toliman_sim -> create      weights blob -> load, load_file
 *                     |                     |
 *                     +----------+----------+
 *                                v
 *                           toliman_cae <-> train
 *                                +-> encode                          latent, px -> period.h
 *                                +-> decode, reconstruct, get_target decoder output and training target
 *                                +-> get_info                        properties
 *                                +-> save, save_file                 weights blob
 *                             destroy
 *
 * A network contains the preprocessing of its scene: crop, reference image, variance, nuisance images, input scale.
 * The weights are trained for this preprocessing; both are stored in the weights blob (formats.md, "TLMW").
 */
#ifndef TOLIMAN_CAE_H
#define TOLIMAN_CAE_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Network with the preprocessing of its scene. */
typedef struct toliman_cae toliman_cae;

/* Layouts. The library contains these two; toliman_cae_options.layout selects one. Both have an encoder of four
 * stages of 3x3 convolutions with 8, 16, 32 and 64 channels and a dense layer to the latent, and a decoder in reverse
 * order. They differ in pooling and in the position of ELU, the exponential linear unit. */
#define TOLIMAN_CAE_LAYOUT_FLIGHT 201 /* 2x2 mean pooling before ELU, up-sampling; reaches the photon limit */
/* Layout of the chapter: 2x2 max pooling, un-pooling at the positions of the maxima. The chapter pools after ELU, this
 * library before it: the same maxima, but where ELU has saturated at -1, other positions. The positions belong to a
 * frame: toliman_cae_reconstruct works, toliman_cae_decode does not. */
#define TOLIMAN_CAE_LAYOUT_PAPER 202

/* Inputs: how the 256x256 crop of a frame is scaled for the network. */
#define TOLIMAN_CAE_INPUT_WHITENED 211 /* (counts - reference)/sigma per pixel, nuisances projected out */
#define TOLIMAN_CAE_INPUT_RESIDUAL 212 /* (counts - reference)/mean sigma of the frame */
#define TOLIMAN_CAE_INPUT_RAW 213      /* counts, scaled so that the reference image spans 0..1, as in the chapter */

/* Place of the crop in a frame. It is centred on the barycentre of the scene's light, to half a pixel. */
#define TOLIMAN_CAE_CENTRE_SCENE 241 /* the same for all frames */
/* Moved by whole pixels, within the frame, until the barycentre of its light is that of the reference image, to half a
 * pixel. The light is what exceeds the scene's uniform background (dark current, bias). For frames whose pointing
 * wanders by pixels. A fraction of a pixel remains: for the latent to measure the separation, project out the shift
 * (preprocess.project), or train the network on such frames. */
#define TOLIMAN_CAE_CENTRE_IMAGE 242

/* Network options. */
typedef struct toliman_cae_options {
    uint32_t struct_size;
    int32_t layout;                     /* TOLIMAN_CAE_LAYOUT_..., 0 = FLIGHT */
    int32_t input;                      /* TOLIMAN_CAE_INPUT_..., 0 = WHITENED */
    uint32_t threads;                   /* worker threads of toliman_cae_encode, 0 = one per processor */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    toliman_log_fn log;                 /* receives warnings about preprocess.project; may be NULL */
    void *log_data;
    int32_t centre;    /* TOLIMAN_CAE_CENTRE_..., 0 = SCENE */
    uint32_t reserved; /* 0 */
} toliman_cae_options;
#define TOLIMAN_CAE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_options)

/* Creates a network with the preprocessing of a scene, and with random weights drawn from seed. The simulator is not
 * needed afterwards. options may be NULL. The caller destroys *out.
 *
 * With the default layout and input, the untrained network is scaled so that its latent changes by 1 px per px of
 * displacement; it can serve as an untrained control. Otherwise the latent of an untrained network has no unit.
 * Errors: TOLIMAN_E_UNSUPPORTED if frames are smaller than 256x256, for preprocess.project with another input than
 * WHITENED, or for CENTRE_IMAGE with frames of 256x256; TOLIMAN_E_SCENE if the nuisances span the derivative of the
 * signal.
 *
 * Images of preprocess.project that depend on each other, all divided by sigma per pixel over the whole frame: an image
 * is dropped if less than 1e-10 of its norm remains after the projection of those before it in the list. The log
 * receives a warning for it, and for an image of which less than 1e-2 remains after the projection of the others:
 *     scene.json: preprocess.project: scale is nearly a combination of focus (0.71), roll (-0.70): 0.004 of its norm
 *     remains
 * In parentheses: the coefficients of at most three images, all scaled to norm 1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_create(const toliman_sim *sim, uint64_t seed,
                                                                 const toliman_cae_options *options,
                                                                 toliman_cae **out) TOLIMAN_NOEXCEPT;

/* Destroys a network. NULL is allowed. */
TOLIMAN_API void toliman_cae_destroy(toliman_cae *cae) TOLIMAN_NOEXCEPT;

/* Training mode TIED: the kernels of the decoder are the transposed kernels of the encoder. Training fits the output
 * of the decoder, in its linear range, to the whitened derivative image. Then it scales both halves so that the
 * latent is the displacement in px. In each step, the momentum of every weight tensor is orthogonalised (as in
 * "Muon", Jordan et al. 2024), and the tensor is rotated in the opposite direction, which keeps its norm. Therefore
 * tied training does not diverge at any learning rate (promise: tied-training-never-diverges). Needs no data set and no
 * noise. The predicted efficiency (toliman_cae_training.cosine) is 0.99 for the scenes chapter and mission from any
 * seed (promise: tied-efficiency-is-stated). Needs layout FLIGHT and input WHITENED. */
#define TOLIMAN_CAE_MODE_TIED 221
/* Training mode UNSUPERVISED, of the chapter: minimises the mean squared error between input and output over the
 * caller's frames, without prior knowledge. The latent then has no unit, and its sign is arbitrary. */
#define TOLIMAN_CAE_MODE_UNSUPERVISED 222

/* Callback that provides training frames: fills counts[count][rows][cols] with frames first ... first + count - 1 and
 * returns TOLIMAN_OK. Any other status stops the training, which returns that status. A frame must be identical each
 * time it is requested, also after a resumed training. Runs on the thread of the call, with no lock held. If the
 * callback calls a function on the network being trained, that call returns TOLIMAN_E_STATE. */
typedef toliman_status (*toliman_frames_fn)(size_t first, size_t count, double *counts, void *user_data);

/* Training result. Members that do not apply to the mode are 0. */
typedef struct toliman_cae_training {
    uint32_t struct_size;   /* in: sizeof(toliman_cae_training) */
    uint32_t steps;         /* total number of steps */
    uint32_t epochs;        /* UNSUPERVISED: total number of epochs */
    uint32_t reserved;      /* 0 */
    double loss;            /* TIED: squared distance between the unit target and its projection on the decoder output,
                               0.02 when well trained. UNSUPERVISED: mean squared error of the last epoch, in units of
                               the input */
    double cosine;          /* TIED: cosine between d latent/d residual and the whitened derivative image: the predicted
                               efficiency, Cramer-Rao bound / standard deviation of the latent */
    double validation_loss; /* UNSUPERVISED: loss of the validation frames */
    double mmse, mssim;     /* UNSUPERVISED: means over the validation frames, see toliman_cae_reconstruct */
    double photon_floor;    /* UNSUPERVISED: mean over the validation frames, see toliman_cae_reconstruct */
} toliman_cae_training;
#define TOLIMAN_CAE_TRAINING_INIT TOLIMAN_INIT(toliman_cae_training)

/* Callback after each epoch of UNSUPERVISED training. Receives a network with the weights of this epoch, which may
 * encode frames and may be saved with its training state, and the training result so far. Both are valid during the
 * callback. Return 0 to continue, any other value to stop: the training returns TOLIMAN_E_CANCELLED and can be resumed
 * after this epoch. Runs on the thread of the call, with no lock held. A call on the network being trained returns
 * TOLIMAN_E_STATE. */
typedef int32_t (*toliman_epoch_fn)(const toliman_cae *so_far, const toliman_cae_training *result, void *user_data);

/* Training options. */
typedef struct toliman_cae_train_options {
    uint32_t struct_size;
    int32_t mode; /* TOLIMAN_CAE_MODE_..., 0 = TIED */
    uint32_t
        steps; /* TIED: number of steps. UNSUPERVISED: total number of epochs, passes over the training frames. 0 = 300 */
    double
        learning_rate; /* in (0, 1]; 0 = 0.08 (TIED), 1e-3 (UNSUPERVISED). TIED: largest rotation of a tensor per step in rad, decreasing linearly to 0. UNSUPERVISED: constant rate of Adam */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    toliman_frames_fn frames; /* UNSUPERVISED: provides the frames; their inputs are kept in memory, 256 KiB each */
    void *frames_data;
    size_t frame_count; /* UNSUPERVISED: number of frames */
    size_t
        validation; /* UNSUPERVISED: number of frames held out, chosen by the seed; 0 = a tenth, rounded to nearest, or 1 */
    uint32_t batch;    /* UNSUPERVISED: frames per step of Adam, in [1, 4096]; 0 = 16 */
    uint32_t threads;  /* UNSUPERVISED: worker threads, 0 = one per processor */
    double *losses;    /* [loss_count], may be NULL: losses[k] receives the loss after step (TIED) or epoch k + 1 */
    size_t loss_count; /* elements of losses. Losses of later steps, and of steps before a training was resumed, are
                             not written */
    toliman_epoch_fn epoch; /* UNSUPERVISED: may be NULL. If given, the validation frames are requested and
                               reconstructed again after each epoch */
    void *epoch_data;
} toliman_cae_train_options;
#define TOLIMAN_CAE_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_train_options)

/* Trains a network, or resumes its last training. Writes the training result to *report.
 * options and report may be NULL.
 *
 * A cancelled training resumes to the same bits after its last step (TIED) or epoch
 * (promise: cancelled-training-resumes) if mode, steps, learning rate, batch and numbers of frames are unchanged (see
 * toliman_cae_get_info). A finished training with the same options is not continued: its result is returned
 * (UNSUPERVISED requests and validates the frames again). A finished UNSUPERVISED training continues if more epochs are
 * requested. Any other options start a new training from the network's seed.
 *
 * If a training fails, the network keeps its weights (promise: failed-training-keeps-weights). Its training state
 * changes only after a step (TIED) or an epoch (UNSUPERVISED) of the new one, which the next call then resumes.
 * Errors: TOLIMAN_E_CANCELLED; TOLIMAN_E_RANGE if UNSUPERVISED diverges at this learning rate, or the target image of
 * a loaded network leads to weights out of range; TOLIMAN_E_UNSUPPORTED for TIED with another layout or input than it
 * needs; TOLIMAN_E_STATE if the target image of a loaded network is 0. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_train(toliman_cae *cae,
                                                                const toliman_cae_train_options *options,
                                                                toliman_cae_training *report) TOLIMAN_NOEXCEPT;

/* Properties of a network. */
typedef struct toliman_cae_info {
    uint32_t struct_size;       /* in: sizeof(toliman_cae_info) */
    int32_t trained;            /* 0 or 1 */
    const char *layout;         /* "flight" or "paper"; static text */
    uint64_t layout_hash;       /* FNV-1a hash of the tensor table of the layout */
    uint64_t scene_digest;      /* toliman_sim_info.scene_digest of the scene */
    uint64_t parameters;        /* number of weights */
    int64_t rows, cols;         /* shape of the frames that the network takes */
    int64_t crop_row, crop_col; /* first row and column of the 256x256 crop of the scene's image */
    uint32_t projected;         /* number of nuisance images projected out */
    int32_t input;              /* TOLIMAN_CAE_INPUT_... */
    double crb_px;              /* Cramer-Rao bound with these nuisances unknown */
    double cosine;              /* toliman_cae_training.cosine; 0 before training */
    double input_scale;         /* factor between the input and the first convolution: 1e-3 for TIED, else 1 */
    uint64_t seed;              /* seed of the random weights */
    int32_t centre;             /* TOLIMAN_CAE_CENTRE_... */
    uint32_t reserved;          /* 0 */
} toliman_cae_info;
#define TOLIMAN_CAE_INFO_INIT TOLIMAN_INIT(toliman_cae_info)

/* Writes the properties of a network to *out, whose struct_size must be set.
 *   resumable  receives the options of the training that can be resumed: mode, steps, learning_rate, frame_count,
 *              validation and batch as given, no callbacks. epochs is the number of completed epochs: before resuming,
 *              set it to the total that is wanted. All are 0 if there is no such training: the network is untrained, or
 *              was loaded from a blob without training state. Its struct_size must be set; may be NULL */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_info(const toliman_cae *cae,
                                                                   toliman_cae_train_options *resumable,
                                                                   toliman_cae_info *out) TOLIMAN_NOEXCEPT;

/* Encodes `count` frames of image, on the threads of the network's options; one frame on the calling thread. A latent
 * does not depend on the other frames (promise: latents-ignore-other-frames). Bad pixels get the counts of a linear fit
 * to the others.
 *   latents_px  [count], px
 *   goodness    [count], goodness of this fit, or NULL; struct_size of the first must be set. It does not depend on the
 *               weights or on toliman_cae_options.input
 * The chi_square of goodness is
 *
 *     |r - sum_k <u_k, r> u_k - <t, r> t/|t|^2|^2 / (65536 - K - 1),    r = (counts - reference)/sigma per pixel
 *
 * u_k are the K orthonormal nuisance images that are projected out, t is the image of toliman_cae_get_target.
 * Encoding one frame of doubles allocates no memory (promise: encoding-allocates-nothing); calls that run at once
 * allocate working memory for each further thread once.
 *
 * Accuracy: the slope of latent over displacement is 1 for small displacements. ELU makes it nonlinear:
 * latent/displacement is about 0.9996 at 1e-4 px, 0.996 at 1e-3 px and 0.96 at 1e-2 px
 * (promise: latent-slope-is-stated), and 0.9996, 0.997 and 0.97 at negative displacements (scene chapter.json). Between
 * trainings, the deviation from 1 varies by a third. A flux error shifts the latent unless preprocess.project removes
 * it: 0.1 % more light shifts it by -6e-6 px in chapter.json.
 * Errors, which name the frame if there are several: TOLIMAN_E_ARGUMENT for another shape, for a non-finite count in
 * the crop, naming its row and column, and with CENTRE_IMAGE for a crop without light; TOLIMAN_E_RANGE if the counts
 * are so far from the scene that the latent overflows, and for an image larger than the address space. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_encode(const toliman_cae *cae, const toliman_image *image,
                                                                 size_t count, double *latents_px,
                                                                 toliman_frame_goodness *goodness) TOLIMAN_NOEXCEPT;

/* Decodes a latent: writes the decoder output to image[256][stride]. With input WHITENED, the output is the whitened
 * residual, in standard deviations of each pixel; it is linear in the latent up to 1 px. With the other inputs, the
 * output has the scaling of that input.
 * Errors: TOLIMAN_E_UNSUPPORTED for layout PAPER; TOLIMAN_E_ARGUMENT if |latent_px| > 1e6; TOLIMAN_E_RANGE if the
 * weights of a loaded network make the output overflow. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_decode(const toliman_cae *cae, double latent_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Writes the training target to image[256][stride]: the whitened derivative image with nuisances projected out, per
 * px. It is the ideal decoder output for a latent of 1 px. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_get_target(const toliman_cae *cae, double *image,
                                                                     size_t stride) TOLIMAN_NOEXCEPT;

/* Reconstructs a frame: encodes counts[rows][counts_stride], decodes the latent and writes image[256][stride] in
 * counts. With input WHITENED, the decoder output is multiplied by sqrt(variance) and added to the reference image;
 * nuisances that were projected out are not restored.
 *   mmse, mssim   mean squared error and mean structural similarity (the chapter's names) between crop and
 *                 reconstruction, both scaled to 0..1 by the extremes of the crop. Similarity after Wang et al.
 *                 (2004): 11x11 Gaussian window of 1.5 px, K1 = 0.01, K2 = 0.03, over the pixels whose window lies
 *                 inside the image
 *   photon_floor  mmse expected from noise alone
 * mmse, mssim and photon_floor may be NULL.
 * Errors: as toliman_cae_encode; TOLIMAN_E_ARGUMENT for a constant frame if one of the three is requested;
 * TOLIMAN_E_RANGE if the latent exceeds 1e6 px or a result overflows. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_reconstruct(const toliman_cae *cae, const double *counts,
                                                                      size_t counts_stride, double *image,
                                                                      size_t stride, double *mmse, double *mssim,
                                                                      double *photon_floor) TOLIMAN_NOEXCEPT;

/* Number formats of a weights blob. formats.md lists the bytes and the loss of accuracy of each. The reference image
 * is always float32, because its errors enter every latent. */
#define TOLIMAN_CAE_ENCODING_FLOAT32 231 /* exact */
#define TOLIMAN_CAE_ENCODING_BF16 232    /* half the size, 8-bit significand */
#define TOLIMAN_CAE_ENCODING_FP16 233    /* half the size, 11-bit significand */

/* Options of toliman_cae_save. */
typedef struct toliman_cae_save_options {
    uint32_t struct_size;
    int32_t weights_encoding; /* of the weights: TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32 */
    int32_t planes_encoding;  /* of variance, target and nuisance images: TOLIMAN_CAE_ENCODING_..., 0 = FLOAT32 */
    int32_t with_training;    /* 0 or 1: also save the training state, so that toliman_cae_train can resume */
} toliman_cae_save_options;
#define TOLIMAN_CAE_SAVE_OPTIONS_INIT TOLIMAN_INIT(toliman_cae_save_options)

/* Saves a network as a weights blob. options may be NULL. *needed becomes the size of the blob. The same network always
 * gives the same bytes, also after loading them (promise: networks-save-same-bytes). TOLIMAN_E_CAPACITY if capacity is
 * too small; TOLIMAN_E_RANGE for numbers above 2^100, which the format excludes. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save(const toliman_cae *cae,
                                                               const toliman_cae_save_options *options, void *bytes,
                                                               size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a network from a weights blob of exactly `size` bytes. options may be NULL. The caller destroys *out. Loading
 * never allocates more than the layout implies (promise: weights-have-bounded-memory). A wrong version, layout, size,
 * checksum or number (subnormal, above 2^100, NaN) is TOLIMAN_E_FORMAT (promise: damaged-weights-are-refused). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load(const void *bytes, size_t size,
                                                               const toliman_load_options *options,
                                                               toliman_cae **out) TOLIMAN_NOEXCEPT;

/* Saves a network to a file. Replaces the file atomically; on failure (TOLIMAN_E_WRITE) the old file remains. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_save_file(const toliman_cae *cae,
                                                                    const toliman_cae_save_options *options,
                                                                    const char *path) TOLIMAN_NOEXCEPT;

/* Loads a network from a file. Otherwise as toliman_cae_load. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_cae_load_file(const char *path,
                                                                    const toliman_load_options *options,
                                                                    toliman_cae **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
