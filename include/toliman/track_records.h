/* libtoliman, records of a tracker: verdict and value of each frame.
 *
 * Data flow (toliman_track_...)
 *
 *   toliman_track -> get_records              verdicts, times, values
 *                    get_columns, get_column  further data of the same records
 *                    get_intervals            on-target intervals of a frame
 *                    get_streams              sessions and regions, ids that are missing
 *                    get_measure              the frames as a series (measure.h) */
#ifndef TOLIMAN_TRACK_RECORDS_H
#define TOLIMAN_TRACK_RECORDS_H

#include <toliman/measure.h>
#include <toliman/track.h>

TOLIMAN_BEGIN_DECLS

/* Record of the ledger: a frame as it arrived, with its present verdict. Two verdicts mark records without a frame:
 * VERDICT_MERGED has counts, VERDICT_INTERVALS the on-target intervals of a later frame. */
typedef struct toliman_track_record {
    uint32_t struct_size;
    int32_t verdict;
    int32_t reason;   /* as in the outcome */
    uint32_t content; /* CRC32 of the frame */
    uint64_t stream;  /* hash of session, region and restarts */
    int64_t frame_id;
    int64_t camera_ns, tai_ns;
    int64_t dropped;
    double value, sigma; /* as in the outcome; without a value: 0, and the sigma of frame or tracker */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;
    uint32_t bad_pixels;
} toliman_track_record;
#define TOLIMAN_TRACK_RECORD_INIT TOLIMAN_INIT(toliman_track_record)

/* Reads up to `count` records from number `first` on, in order of arrival; *done becomes their number. Duplicates
 * have no record; in memory, invalid frames have none either. Errors: TOLIMAN_E_FORMAT if the ledger has been damaged;
 * some records may have been written before. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_records(const toliman_track *track, int64_t first,
                                                                        size_t count, toliman_track_record *records,
                                                                        size_t *done) TOLIMAN_NOEXCEPT;

#define TOLIMAN_TRACK_COLUMN_F64 531
#define TOLIMAN_TRACK_COLUMN_I64 532

/* Column of the ledger, in addition to toliman_track_record:
 *   chi_square, flags           of toliman_estimate
 *   exposure_s                  of toliman_frame; 0 = unknown
 *   shift_s                     mean on-target time minus the middle of the exposure, not applied to the time; 0
 *                               without intervals
 *   window_row, window_col      of toliman_frame
 *   intervals                   number of on-target intervals; -1 = lost
 *   chi_square_sigma, largest_residual, bad_pixels  of the outcome
 * In a folder with a system, NaN in unreduced frames:
 *   factor                      mean apparent over mean geometric separation
 *   geometric_arcsec            mean separation on the orbit
 *   d_period_years ... d_epoch  derivatives of the reduced separation by toliman_sky_element_name, arcsec per unit
 * Then toliman_track_estimator.values, and cov_A_B, the covariance of A and B; the first value is named "value". Of a
 * fit then its parameters from flux_a on (fit.h), if the ledger was created by version 0.3 or later. */
typedef struct toliman_track_column {
    uint32_t struct_size;
    int32_t type;
    char name[64];
} toliman_track_column;
#define TOLIMAN_TRACK_COLUMN_INIT TOLIMAN_INIT(toliman_track_column)

/* Writes the columns, in the order of the ledger. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_columns(const toliman_track *track,
                                                                        toliman_track_column *columns, size_t capacity,
                                                                        size_t *count) TOLIMAN_NOEXCEPT;

/* Writes the numbers of a column to values[count], for the same records; without a number NaN, or 0 in integer columns.
 * Integers above 2^53 are rounded. Errors: as toliman_track_get_records; TOLIMAN_E_NOT_FOUND for an unknown column. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_column(const toliman_track *track, const char *name,
                                                                       int64_t first, size_t count, double *values,
                                                                       size_t *done) TOLIMAN_NOEXCEPT;

/* Writes the on-target intervals of a record to intervals[capacity][2]: start and end in s from the start of the
 * exposure by the camera clock. Errors: TOLIMAN_E_STATE in memory; TOLIMAN_E_LOST if damage has lost them. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_intervals(const toliman_track *track, int64_t record,
                                                                          double *intervals, size_t capacity,
                                                                          size_t *count) TOLIMAN_NOEXCEPT;

/* Session and region of interest between two restarts of the camera; names are empty if unknown (in memory or lost). */
typedef struct toliman_track_stream {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t stream;
    int64_t first_id, last_id;
    int64_t frames;  /* keys with a valid frame */
    int64_t missing; /* other ids between first_id and last_id */
    char session[72], roi[72];
    int64_t restarts; /* as in toliman_frame; 0 if the names are unknown */
} toliman_track_stream;
#define TOLIMAN_TRACK_STREAM_INIT TOLIMAN_INIT(toliman_track_stream)

/* Writes the sessions and regions, sorted by name and restarts. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_streams(const toliman_track *track,
                                                                        toliman_track_stream *streams, size_t capacity,
                                                                        size_t *count) TOLIMAN_NOEXCEPT;

/* Creates the series of the frames, as toliman_measure_load_file does for a state folder.
 *   options  kind, unit and log
 * Errors: TOLIMAN_E_NOT_FOUND without frames or measured separations. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_measure(const toliman_track *track,
                                                                        const toliman_measure_options *options,
                                                                        toliman_measure **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
