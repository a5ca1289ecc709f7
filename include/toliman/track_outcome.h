/* libtoliman, tracking: what became of a pushed frame.
 *
 * Data flow
 *
 *   toliman_track_push -> toliman_track_outcome: verdict, reason, value, goodness of fit
 *   frame of a misfit -> toliman_misfit_fn -> the same frame with other pixels
 */
#ifndef TOLIMAN_TRACK_OUTCOME_H
#define TOLIMAN_TRACK_OUTCOME_H

#include <toliman/frame.h>
#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Verdicts, explained in track.h. */
#define TOLIMAN_TRACK_VERDICT_ACCEPTED 501
#define TOLIMAN_TRACK_VERDICT_DUPLICATE 502
#define TOLIMAN_TRACK_VERDICT_QUARANTINED 503
#define TOLIMAN_TRACK_VERDICT_OUTLIER 504
#define TOLIMAN_TRACK_VERDICT_REJECTED 505
#define TOLIMAN_TRACK_VERDICT_MERGED 506    /* never an outcome: a record of counts (repeats, merged ledger) */
#define TOLIMAN_TRACK_VERDICT_UNREDUCED 507 /* */
#define TOLIMAN_TRACK_VERDICT_INTERVALS 508 /* never an outcome: on-target intervals of the next frame */
#define TOLIMAN_TRACK_VERDICT_MISFIT 509    /* */

/* Reasons for rejection, and why a frame is unreduced. */
#define TOLIMAN_TRACK_REASON_NONE 511
#define TOLIMAN_TRACK_REASON_SHAPE 512      /* number of rows or columns differs from the tracker's */
#define TOLIMAN_TRACK_REASON_OVER_RANGE 513 /* pixel above the bit depth */
#define TOLIMAN_TRACK_REASON_ZERO_RUN 514   /* run of zero pixels of at least zero_run_bytes (lost packet) */
#define TOLIMAN_TRACK_REASON_NOT_FINITE 515 /* pixel that is NaN or infinite */
/* Time that overflows in TAI, that the periodogram cannot represent, or outside the span of its trend. */
#define TOLIMAN_TRACK_REASON_CLOCK 516
#define TOLIMAN_TRACK_REASON_ESTIMATE 517 /* estimator failed, or gave a non-finite value or a sigma out of range */

#define TOLIMAN_TRACK_REASON_NO_ORBIT 518 /* unreduced: the observer file has no state at its time */
/* Unreduced: the observer is in orbit, and the exposure is unknown, or longer than 600 s without a list of on-target
 * intervals; or an interval is shorter than 1 ns or longer than 400 days. */
#define TOLIMAN_TRACK_REASON_NO_INTERVALS 519

/* Outcome of a pushed frame. */
typedef struct toliman_track_outcome {
    uint32_t struct_size; /* in: sizeof(toliman_track_outcome) */
    int32_t verdict;      /* TOLIMAN_TRACK_VERDICT_... */
    int32_t reason;       /* TOLIMAN_TRACK_REASON_... of a rejected or unreduced frame */
    int32_t reserved;
    int64_t row, col; /* first pixel over range, not finite, or completing a zero run; for SHAPE, the shape received */
    double pixel;     /* value of that pixel */
    double value;     /* accepted, outlier, misfit: reduced if the folder has a system; unreduced: the estimate */
    int64_t tai_ns;   /* these frames: time in TAI */
    /* These frames: goodness of fit (goodness.h); NaN and UNKNOWN without a model. */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;    /* TOLIMAN_GOODNESS_... */
    uint32_t bad_pixels; /* pixels that were found damaged and left out of the estimate */
    double sigma;        /* these frames: standard deviation of the value; 0 for others */
} toliman_track_outcome;
#define TOLIMAN_TRACK_OUTCOME_INIT TOLIMAN_INIT(toliman_track_outcome)

/* Called on the thread of toliman_track_push for a misfit, before it is recorded. *other is a copy of *frame: its
 * pixels, rows, cols, stride and pixel may be changed, for example to those that toliman_ingest_find_frame finds; they
 * must stay valid until the push returns. Returns 1 to try *other, which is recorded in place of the frame unless it is
 * a misfit, too; 0 to record the frame. An exception and other numbers count as 0. */
typedef int32_t (*toliman_misfit_fn)(const toliman_frame *frame, const toliman_track_outcome *outcome,
                                     toliman_frame *other, void *user_data);

TOLIMAN_END_DECLS

#endif
