/* libtoliman, goodness of fit of a tracker's frames: whether the model that measures them is right, and stays right.
 *
 * Data flow (functions toliman_track_...)
 *
 *   toliman_track -> query_goodness -> median and trend of chi-square, counts, verdict of the calibration
 */
#ifndef TOLIMAN_TRACK_GOODNESS_H
#define TOLIMAN_TRACK_GOODNESS_H

#include <toliman/track.h>

TOLIMAN_BEGIN_DECLS

/* Goodness of fit (goodness.h) of the frames of a folder. */
typedef struct toliman_track_goodness {
    uint32_t struct_size;        /* in: sizeof(toliman_track_goodness) */
    int32_t goodness;            /* verdict on chi_square, as for a single frame */
    int64_t frames;              /* accepted and unreduced frames with a chi-square */
    double chi_square;           /* their median; without them, that of misfits and outliers; NaN without these */
    double chi_square_sigma;     /* median standard deviation of a frame's chi-square, if the model is right */
    double largest_residual;     /* largest one of these frames */
    double years;                /* from their first time to the last, in years of 365.25 days */
    double trend_per_year;       /* change of chi-square per year, least squares; NaN for fewer than 3 frames */
    double trend_sigma_per_year; /* its standard error, from the scatter of the frames */
    int64_t poor, too_good;      /* verdicts of these frames */
    int64_t misfit;              /* frames above the limit, which are not among these frames */
    int64_t bad_pixels;          /* pixels that were left out of these frames */
    int64_t cleaned;             /* number of these frames with a bad pixel */
    double chi_limit;            /* the limit in force */
    /* The scene with which the frames are measured, if it is that of a calibration. */
    int32_t is_calibrated; /* 1: it is */
    int32_t is_complete; /* 0: the calibration found an effect that its model lacks (TOLIMAN_CALIBRATION_INCOMPLETE) */
    double calibration_chi_square, calibration_chi_square_sigma; /* of the calibration; NaN if unknown */
    int32_t calibration_goodness;                                /* verdict on it */
    int32_t reserved;
} toliman_track_goodness;
#define TOLIMAN_TRACK_GOODNESS_INIT TOLIMAN_INIT(toliman_track_goodness)

/* Writes the goodness of fit of the folder's frames to *out, whose struct_size must be set. Reads all records. Errors:
 * TOLIMAN_E_FORMAT if the ledger has been damaged since it was opened. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_query_goodness(const toliman_track *track, toliman_track_goodness *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
