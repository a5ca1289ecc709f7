/* libtoliman, tracking: turns downlinked frames into a period, one frame at a time. Each frame counts once, however
 * often it arrives (promise: frames-count-once). Committed frames are not lost if the process is killed
 * (promise: committed-frames-survive-kills).
 *
 * Data flow (toliman_track_...)
 *
 *   load_options -> create <- folder (ledger, setup, checkpoint)
 *   frames[count] -> push -> toliman_track -> outcomes[count]; get_period -> period.h
 *   other folders -> merge                    query_fit, get_info, get_options; track_records.h
 *                                             commit, save -> folder; destroy
 *
 * Frames may arrive in any order, repeatedly or damaged. Each (key and content: frame.h) is checked, measured by an
 * estimator, assigned a time, and added to a periodogram. Its verdict:
 *
 *   accepted     the first valid frame with its key
 *   duplicate    same key and content as an earlier valid frame; ignored
 *   quarantined  same key as an earlier valid frame, other content. The value of the earlier frame is retracted exactly
 *                (promise: quarantines-retract-exactly); later valid copies are quarantined, too
 *   misfit       its chi-square exceeds the limit of the folder, which may follow the median
 *   outlier      |value| exceeds its limit, or the time of an accepted frame no longer fits after a change of grid or
 *                clock table
 *   unreduced    the observer file does not cover its exposure (rebuild with another file), or its on-target intervals
 *                are not known (push it to a new folder with them)
 *   rejected     damaged (see the reasons); an intact copy may still arrive
 *
 * Misfits, outliers and unreduced frames are recorded, but not in the periodogram.
 *
 * The time of a frame is its camera time, converted to TAI by the clock table, ns since the epoch of that table:
 * 1970-01-01 for `toliman track` and for trackers with a system. No barycentric correction (up to +-8.3 minutes) is
 * applied.
 *
 * Reduction. Without a system, the value of a frame is the estimate; with a system and an observer (sky.h), in px,
 *
 *   value = separation_px / factor - geometric_arcsec / plate_scale_arcsec
 *
 * Factor and geometric separation are means over the on-target intervals (good-time intervals) or, without these, the
 * exposure; toliman_sky_reduce says which exposures are refused. System and plate scale are fixed for a folder; the
 * observer file may change. A rebuild with `sky` reduces all frames again. A rebuilt periodogram has the bits of a
 * folder that had these settings from the start (promise: rebuilds-equal-new-folders).
 *
 * The periodogram has the same bits for any order of arrival (promise: arrival-order-changes-no-bit), if all values are
 * computed with one instruction set.
 *
 * A folder holds the ledger (formats.md, "TLML"), the authoritative record of each frame, setup (grid, clock table),
 * streams.txt (names of sessions and regions) and checkpoint (accumulators). A lost checkpoint is computed again from
 * the ledger (promise: lost-checkpoints-cost-time-only). */
#ifndef TOLIMAN_TRACK_H
#define TOLIMAN_TRACK_H

#include <toliman/track_options.h>

TOLIMAN_BEGIN_DECLS

/* Tracker of downlinked frames. */
typedef struct toliman_track toliman_track;

/* Reads the options of a folder, for toliman_track_create: folder (the given pointer), id, values and sigma of the
 * estimator, frames, grid (nf = 0 and stamp = 0 if the setup file is lost), limits, plate_scale_arcsec (0: no system),
 * scale_sigma, TOLIMAN_TRACK_ALLOW_ZERO_RUNS, a capacity of twice the records, 2^20 to 2^28; others are defaults.
 * Errors:
 *   - TOLIMAN_E_NOT_FOUND; its field is the folder if that has no ledger: toliman_track_create may begin one;
 *   - TOLIMAN_E_FORMAT if the ledger is damaged, or missing next to other files. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_load_options(const char *folder, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Creates a tracker, or opens an existing folder (start from toliman_track_load_options). A tracker allocates all
 * memory at creation (promise: trackers-allocate-at-creation), and locks the ledger. Errors:
 *   - TOLIMAN_E_MISMATCH if the folder has another estimator, other values, geometry or limits
 *     (promise: estimators-are-not-mixed), another stamp or exposure_s, or, without REBUILD, another grid, clock table,
 *     system, plate scale or limit of chi-square; for the bank of another fit;
 *   - TOLIMAN_E_STATE if another tracker writes to the folder (promise: folders-have-one-writer);
 *   - TOLIMAN_E_LOST if the ledger has lost records (toliman_track_merge with SALVAGE recovers the others),
 *     TOLIMAN_E_FORMAT also if it is missing next to other files;
 *   - TOLIMAN_E_CAPACITY if the folder holds more frames than capacity; TOLIMAN_E_INTERNAL without random numbers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_create(const toliman_track_options *options,
                                                                   toliman_track **out) TOLIMAN_NOEXCEPT;

/* Destroys a tracker. Uncommitted records are lost. */
TOLIMAN_API void toliman_track_destroy(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Processes frames[count] in order and writes outcomes[count]. A rejected frame is an outcome, not an error. On an
 * error, *done frames have been processed and the next one has not. Errors:
 *   - TOLIMAN_E_ARGUMENT if a frame is invalid: none is processed;
 *   - TOLIMAN_E_CAPACITY for too many frames, or sessions and regions (65,536);
 *   - TOLIMAN_E_WRITE if the ledger cannot be written. After a failed write the tracker takes no more frames
 *     (promise: failed-writes-stop-the-tracker); open the folder again;
 *   - TOLIMAN_E_LOST, before another frame is acknowledged, if another program removed, renamed, replaced or changed
 *     the ledger (promise: changed-ledgers-stop-writers);
 *   - TOLIMAN_E_STATE without an estimator, with READ_ONLY, and during queries of the tracker's periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_push(toliman_track *track, const toliman_frame *frames,
                                                                 size_t count, toliman_track_outcome *outcomes,
                                                                 size_t *done) TOLIMAN_NOEXCEPT;

/* Writes and (except with SYNC_NONE) fsyncs all records and the count of repeated frames: every pushed frame is then
 * acknowledged. Errors as toliman_track_push. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_commit(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Commits with fsync, and writes a checkpoint, so that the folder opens fast. After an error, records may have been
 * committed. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_save(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Adds the records of another folder, which may be in use, as if its frames had been pushed here, and commits. Folders
 * may be merged in any order, and again as they grow: only new records count (promise: folders-merge-in-any-order).
 * Grid and clock table remain. Of a frame in several folders, the value that was added first remains.
 *   flags  0, or TOLIMAN_TRACK_SALVAGE: skips damaged records; the others count as new arrivals
 *   lost   may be NULL: damaged records, plus records that the checkpoint counts and the ledger lacks
 *          (promise: salvage-counts-what-is-lost)
 * Errors: as toliman_track_create and _push; TOLIMAN_E_MISMATCH also for another system or plate scale, another clock
 * table if frames are reduced, or a column that this ledger lacks; TOLIMAN_E_ARGUMENT for the tracker's own folder.
 * After an error some records may have been added; in a repeated merge, they count again as arrivals only. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_merge(toliman_track *track, const char *folder,
                                                                  uint32_t flags, int64_t *lost) TOLIMAN_NOEXCEPT;

/* Counts and properties of a tracker. received = accepted + unreduced + outlier + misfit + quarantined + repeated +
 * rejected; received, repeated and rejected count arrivals, over all runs. A crash loses the counts of uncommitted
 * frames only (promise: counts-survive-crashes). */
typedef struct toliman_track_info {
    uint32_t struct_size;
    uint32_t flags;
    int64_t received;
    int64_t accepted;
    int64_t outlier;
    int64_t quarantined;
    int64_t repeated; /* later arrivals of known keys */
    int64_t rejected;
    int64_t expected; /* ids from first to last, of each session and region */
    int64_t missing;  /* of these, without a valid frame */
    int64_t dropped;  /* by the camera, as valid frames report */
    int64_t sessions; /* pairs of session and region */
    int64_t records;  /* of the ledger; in memory, of valid frames */
    int64_t committed;
    int64_t capacity;
    uint64_t estimator_id;
    double sigma; /* of the options: for frames without their own; lower limit of others */
    double value_limit;
    int64_t unreduced;
    double plate_scale_arcsec; /* 0 = frames are not reduced */
    const char *system;        /* for toliman_sky_create, valid until the tracker is destroyed; NULL = not reduced */
    uint32_t elements;         /* bit j: a column of the periodogram is the error of element j (sky.h) */
    uint32_t reserved;
    int64_t misfit;
    double chi_limit;
    double chi_median;        /* of valid frames, to 0.2 % */
    int64_t rejected_for[16]; /* [reason - TOLIMAN_TRACK_REASON_NONE] */
} toliman_track_info;
#define TOLIMAN_TRACK_INFO_INIT TOLIMAN_INIT(toliman_track_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_info(const toliman_track *track,
                                                                     toliman_track_info *out) TOLIMAN_NOEXCEPT;

/* Gets the options in force. folder and clock.pairs (NULL if camera time is TAI) belong to the tracker; objects,
 * callbacks and allocator are NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_get_options(const toliman_track *track, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Gets the tracker's periodogram, which every push updates, for all queries of period.h. During a push they return
 * TOLIMAN_E_STATE. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_period(const toliman_track *track,
                                                                       const toliman_period **out) TOLIMAN_NOEXCEPT;

/* Refines the highest peak, as toliman_period_query_fit; the phase is at TAI time_offset_ns. Takes 100 bytes per frame.
 * Errors as toliman_period_query_fit; TOLIMAN_E_FORMAT if the ledger has been damaged. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_query_fit(const toliman_track *track,
                                                                      toliman_period_peak *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
