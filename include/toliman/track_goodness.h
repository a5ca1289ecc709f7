/* libtoliman, goodness of fit of a tracker's frames: whether the model that measures them is right, and stays right.
 *
 * Data flow (toliman_track_...)
 *
 *   toliman_track -> query_goodness -> median and trend of chi-square, counts, verdict of the calibration */
#ifndef TOLIMAN_TRACK_GOODNESS_H
#define TOLIMAN_TRACK_GOODNESS_H

#include <toliman/track.h>

TOLIMAN_BEGIN_DECLS

/* Goodness of fit (goodness.h) of the accepted and unreduced frames of a folder that have a chi-square. */
typedef struct toliman_track_goodness {
    uint32_t struct_size;
    int32_t goodness;
    int64_t frames;
    double chi_square;       /* median; without frames, of misfits and outliers */
    double chi_square_sigma; /* median */
    double largest_residual;
    double years;                /* from first to last, of 365.25 days */
    double trend_per_year;       /* of chi-square, least squares; NaN for fewer than 3 frames */
    double trend_sigma_per_year; /* from the scatter of the frames */
    int64_t poor, too_good;
    int64_t misfit;     /* frames above the limit, not among these */
    int64_t bad_pixels; /* of these frames */
    int64_t cleaned;    /* of these frames, with a bad pixel */
    double chi_limit;
    int32_t is_calibrated; /* 1 if the scene is that of a calibration */
    int32_t is_complete;   /* 0: TOLIMAN_CALIBRATION_INCOMPLETE */
    double calibration_chi_square, calibration_chi_square_sigma;
    int32_t calibration_goodness;
    int32_t reserved;
} toliman_track_goodness;
#define TOLIMAN_TRACK_GOODNESS_INIT TOLIMAN_INIT(toliman_track_goodness)

/* Gets the goodness of fit of the folder's frames. Reads all records. TOLIMAN_E_FORMAT if the ledger has been
 * damaged. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_query_goodness(const toliman_track *track, toliman_track_goodness *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
