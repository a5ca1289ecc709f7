/* libtoliman, tracking: outcome of a pushed frame.
 *
 * Data flow
 *
 *   toliman_track_push -> toliman_track_outcome: verdict, reason, value, goodness of fit
 *   frame of a misfit -> toliman_misfit_fn -> the same frame with other pixels */
#ifndef TOLIMAN_TRACK_OUTCOME_H
#define TOLIMAN_TRACK_OUTCOME_H

#include <toliman/frame.h>
#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Verdicts, see track.h. */
#define TOLIMAN_TRACK_VERDICT_ACCEPTED 501
#define TOLIMAN_TRACK_VERDICT_DUPLICATE 502
#define TOLIMAN_TRACK_VERDICT_QUARANTINED 503
#define TOLIMAN_TRACK_VERDICT_OUTLIER 504
#define TOLIMAN_TRACK_VERDICT_REJECTED 505
#define TOLIMAN_TRACK_VERDICT_MERGED 506    /* never an outcome: a record of counts */
#define TOLIMAN_TRACK_VERDICT_UNREDUCED 507 /* */
#define TOLIMAN_TRACK_VERDICT_INTERVALS 508 /* never an outcome: on-target intervals of the next frame */
#define TOLIMAN_TRACK_VERDICT_MISFIT 509    /* */

/* Reasons for rejection; the last two: why a frame is unreduced. */
#define TOLIMAN_TRACK_REASON_NONE 511
#define TOLIMAN_TRACK_REASON_SHAPE 512      /* other rows or columns than the tracker's */
#define TOLIMAN_TRACK_REASON_OVER_RANGE 513 /* pixel above the bit depth */
#define TOLIMAN_TRACK_REASON_ZERO_RUN 514   /* zero_run_bytes of zero pixels (lost packet) */
#define TOLIMAN_TRACK_REASON_NOT_FINITE 515 /* NaN or infinite pixel */
/* Time that overflows in TAI, or outside the periodogram or its trend. */
#define TOLIMAN_TRACK_REASON_CLOCK 516
#define TOLIMAN_TRACK_REASON_ESTIMATE 517 /* estimator failed, or gave a non-finite value or a sigma out of range */

#define TOLIMAN_TRACK_REASON_NO_ORBIT 518 /* no state in the observer file */
/* An exposure that toliman_sky_reduce refuses, or an interval shorter than 1 ns or longer than 400 days. */
#define TOLIMAN_TRACK_REASON_NO_INTERVALS 519

/* Outcome of a pushed frame. */
typedef struct toliman_track_outcome {
    uint32_t struct_size;
    int32_t verdict; /* TOLIMAN_TRACK_VERDICT_... */
    int32_t reason;  /* TOLIMAN_TRACK_REASON_... of a rejected or unreduced frame */
    int32_t reserved;
    int64_t row, col; /* first pixel over range, not finite, or completing a zero run; SHAPE: the shape */
    double pixel;
    double value; /* the estimate, reduced if the folder has a system, except of an unreduced frame. Only accepted,
                     outlier, misfit and unreduced frames have this member and those below */
    int64_t tai_ns;
    /* See goodness.h; NaN and UNKNOWN without a model. */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;
    uint32_t bad_pixels;
    double sigma; /* of the value; 0 without one */
} toliman_track_outcome;
#define TOLIMAN_TRACK_OUTCOME_INIT TOLIMAN_INIT(toliman_track_outcome)

/* Called for a misfit, before it is recorded. *other is a copy of *frame: pixels, rows, cols, stride and pixel may be
 * changed, as by toliman_ingest_find_frame, to what is valid until the push returns. Returns 1 to record *other
 * instead, unless it is a misfit, too; otherwise, also after an exception, the frame is recorded. */
typedef int32_t (*toliman_misfit_fn)(const toliman_frame *frame, const toliman_track_outcome *outcome,
                                     toliman_frame *other, void *user_data);

TOLIMAN_END_DECLS

#endif
