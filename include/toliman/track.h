/* libtoliman, tracking: turns downlinked frames into a period, one frame at a time. Each frame counts once, however
 * often it arrives (promise: frames-count-once). Committed frames are not lost if the process is killed
 * (promise: committed-frames-survive-kills).
 *
 * Data flow (functions toliman_track_...)
 *
 *                 load_options -> create <- folder (ledger, setup, checkpoint)
 *                                    |
 *   frames[count] -> push -> toliman_track -> outcomes[count]; get_period -> period.h
 *   other folders -> merge ----------+
 *                                    +-> query_fit, get_info, get_options
 *                                    |   records, sessions: track_records.h
 *                                    +-> commit, save -> folder
 *                                 destroy
 *
 * Frames may arrive in any order, repeatedly or damaged. A frame is identified by its key (session, frame id, region
 * of interest), because packet counters wrap and times repeat. Each frame is checked, measured by an estimator,
 * assigned a time, and added to a periodogram. Its verdict is one of:
 *
 *   accepted     valid, and the first valid frame with its key
 *   duplicate    valid, same key and same content (frame.h) as an earlier valid frame; ignored
 *   quarantined  valid, same key as an earlier valid frame but different content. The value of the earlier frame is
 *                retracted exactly (promise: quarantines-retract-exactly), and every later valid copy is quarantined,
 *                too
 *   misfit       valid and recorded, but not in the periodogram: its chi-square exceeds the limit of the folder,
 *                and |value| not its own. It may change with the median of the folder's frames
 *   outlier      valid, but not in the periodogram: |value| exceeds its limit, or, after a change of the grid or
 *                clock table, the periodogram can no longer represent the time of a frame accepted earlier
 *   unreduced    valid and recorded, but not in the periodogram: the observer file does not cover its exposure (a
 *                rebuild with another file reduces it), or its on-target intervals are not known (it must be pushed to
 *                a new folder with them)
 *   rejected     damaged (see the reasons). Frames with its key keep their verdicts; an intact copy may still arrive
 *
 * The time of a frame is its camera time, converted to TAI by the clock table. TAI is counted in nanoseconds from the
 * epoch of that table; `toliman track` uses 1970-01-01, and so must a tracker with a system. Exposure and on-target
 * intervals do not change the time. No barycentric correction is applied: the light travel time to the barycentre
 * varies by up to +-8.3 minutes over a year.
 *
 * Reduction. Without a system, the value of a frame is the estimate. With a system and an observer (sky.h), it is, in
 * pixels,
 *
 *   value = separation_px / factor - geometric_arcsec / plate_scale_arcsec
 *
 * Factor and geometric separation are means over the on-target intervals (good-time intervals) of the frame, or,
 * without a list of these, over the exposure. An observer in orbit needs the list for exposures longer than 600 s. The
 * system and the plate scale are the fixed reference of a folder. The observer file may differ from run to run. The
 * value contains planets, the error of the reference orbit, and noise.
 *
 * The ledger keeps the measured separation and the intervals. A rebuild with `sky` reduces all frames again without
 * their pixels, for instance with a definitive observer file or a refitted system. A rebuilt periodogram has the bits
 * of a folder that had these settings from the start (promise: rebuilds-equal-new-folders).
 *
 * The periodogram of a tracker has the same bits for any order of arrival (promise: arrival-order-changes-no-bit), if
 * all values are computed with one instruction set.
 *
 * In a folder, each frame is recorded in a ledger (formats.md, "TLML"), the authoritative record. The folder also
 * holds the grid and clock table (setup), the names of sessions and regions (streams.txt), and the accumulators
 * (checkpoint). A lost checkpoint is computed again from the ledger (promise: lost-checkpoints-cost-time-only). */
#ifndef TOLIMAN_TRACK_H
#define TOLIMAN_TRACK_H

#include <toliman/track_options.h>

TOLIMAN_BEGIN_DECLS

/* Tracker of downlinked frames. */
typedef struct toliman_track toliman_track;

/* Reads the options of a folder to *options, whose struct_size must be set, for toliman_track_create: folder (the
 * given pointer), id, values and sigma of the estimator, frames, grid, limits, plate_scale_arcsec and scale_sigma (nf =
 * 0 and stamp = 0 if the setup file is lost), the flag TOLIMAN_TRACK_ALLOW_ZERO_RUNS, and a capacity of twice the
 * number of records, at least 2^20 and at most 2^28. Other members are set to their defaults. Errors:
 *   - TOLIMAN_E_NOT_FOUND, with the folder as the field of the error, if it does not exist, cannot be opened or has no
 *     ledger of frames: toliman_track_create may begin one in it. With a file as the field if that cannot be read;
 *   - TOLIMAN_E_FORMAT if the ledger is damaged, or is missing although other files of the folder exist. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_load_options(const char *folder, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Creates a tracker, or opens an existing folder and continues with its frames. For an existing folder, start from
 * toliman_track_load_options. A tracker allocates all memory at creation (promise: trackers-allocate-at-creation), and
 * locks the ledger until it is destroyed. The caller destroys *out. Errors:
 *   - TOLIMAN_E_MISMATCH if the folder has another estimator, other values, geometry or limits
 *     (promise: estimators-are-not-mixed), another stamp or exposure_s, or, without REBUILD, another grid, clock table,
 *     system, plate scale or limit of chi-square, and for the bank of another fit;
 *   - TOLIMAN_E_STATE if another tracker writes to the folder (promise: folders-have-one-writer);
 *   - TOLIMAN_E_LOST if the ledger has lost records. toliman_track_merge with SALVAGE recovers the others;
 *   - TOLIMAN_E_FORMAT if the ledger is damaged otherwise, is missing although other files of the folder exist, or is
 *     not a regular file;
 *   - TOLIMAN_E_CAPACITY if the folder holds more frames than capacity;
 *   - TOLIMAN_E_NOT_FOUND if a folder to be read does not exist; TOLIMAN_E_WRITE; TOLIMAN_E_INTERNAL if the system
 *     provides no random numbers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_create(const toliman_track_options *options,
                                                                   toliman_track **out) TOLIMAN_NOEXCEPT;

/* Destroys a tracker. NULL is allowed. Uncommitted records are lost, as in a crash. */
TOLIMAN_API void toliman_track_destroy(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Processes frames[count] in order and writes outcomes[count]. A rejected frame is an outcome, not an error. Pass
 * several frames per call to use several threads. On an error, *done frames have been processed and the next one has
 * not. Errors:
 *   - TOLIMAN_E_ARGUMENT if a frame is invalid; then no frame is processed;
 *   - TOLIMAN_E_CAPACITY if the number of frames, or of sessions and regions (65,536), is exhausted;
 *   - TOLIMAN_E_WRITE if the ledger cannot be written. After a failed write the tracker takes no more frames
 *     (promise: failed-writes-stop-the-tracker); open the folder again;
 *   - TOLIMAN_E_LOST, before another frame is acknowledged, if another program removed, renamed, replaced or changed
 *     the ledger (promise: changed-ledgers-stop-writers);
 *   - TOLIMAN_E_STATE without an estimator, with READ_ONLY, and while another thread queries the tracker's
 *     periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_push(toliman_track *track, const toliman_frame *frames,
                                                                 size_t count, toliman_track_outcome *outcomes,
                                                                 size_t *done) TOLIMAN_NOEXCEPT;

/* Writes all records and the count of repeated frames, and fsyncs them (except with SYNC_NONE). Every pushed frame is
 * then acknowledged. Errors as toliman_track_push. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_commit(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Commits with fsync, also with SYNC_NONE, and writes a checkpoint, so that the folder opens fast. After an error,
 * records may have been committed. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_save(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Adds the records of another folder, as if its frames had been pushed here, and commits. The other folder may be in
 * use. Folders may be merged in any order, and again as they grow: only new records count
 * (promise: folders-merge-in-any-order). Grid and clock table remain those of this tracker. The counts received,
 * repeated and rejected become those of both folders.
 *   flags  0, or TOLIMAN_TRACK_SALVAGE: skips damaged records. All others count as new arrivals, even if they were
 *          merged before; the periodogram still contains each frame once
 *   lost   may be NULL: number of damaged records that were skipped, plus records that the checkpoint counts and the
 *          ledger lacks (promise: salvage-counts-what-is-lost). For frames without any record, see the missing frame
 *          ids of toliman_track_get_streams
 * If several folders hold a frame, the value that was added first remains; networks on CPUs with different
 * instruction sets may differ by 1e-5 sigma.
 * Errors: as toliman_track_create and _push; TOLIMAN_E_MISMATCH for another estimator, other geometry or limits,
 * another stamp, exposure_s, system or plate scale, another clock table if the frames are reduced, or a column that
 * this ledger lacks; TOLIMAN_E_ARGUMENT for the tracker's own folder. After an error some records may have been added.
 * If the merge is repeated, they count again as received and as repeated or rejected, but not in the periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_merge(toliman_track *track, const char *folder,
                                                                  uint32_t flags, int64_t *lost) TOLIMAN_NOEXCEPT;

/* Counts and properties of a tracker. received = accepted + unreduced + outlier + misfit + quarantined +
 * repeated + rejected. received, repeated and rejected count arrivals: a frame that arrives again counts again, also
 * after the folder was reopened. A crash loses the counts of uncommitted frames only
 * (promise: counts-survive-crashes). */
typedef struct toliman_track_info {
    uint32_t struct_size; /* in: sizeof(toliman_track_info) */
    uint32_t flags;       /* TOLIMAN_TRACK_..., as given */
    int64_t received;     /* arrived frames, in this and earlier runs */
    int64_t accepted;     /* frames in the periodogram */
    int64_t outlier;
    int64_t quarantined; /* keys */
    int64_t repeated;    /* later arrivals of known keys, with the same or other content, here or in merged folders */
    int64_t rejected;    /* for any reason; see rejected_for */
    int64_t expected;    /* frame ids from the first to the last of each session and region */
    int64_t missing;     /* expected ids that are neither accepted nor unreduced, outlier, misfit nor quarantined */
    int64_t dropped;     /* frames dropped by the camera, as reported by all valid frames */
    int64_t sessions;    /* number of pairs of session and region */
    int64_t records;     /* records of the ledger; in memory, of accepted and unreduced frames and outliers */
    int64_t committed;   /* committed records; with READ_ONLY, records that the files show to be committed */
    int64_t capacity;
    uint64_t estimator_id;
    double sigma; /* that of the options: of values whose frame and estimator give none, and the least of others */
    double value_limit;
    int64_t unreduced;         /* frames that are not reduced */
    double plate_scale_arcsec; /* of the reduction; 0 = frames are not reduced */
    const char *system; /* of the reduction, JSON text that toliman_sky_create takes; NULL = frames are not reduced.
                           Valid until the tracker is destroyed */
    uint32_t elements;  /* bit j: the error of element j (sky.h) is a column of the periodogram */
    uint32_t reserved;
    int64_t misfit;           /* frames whose chi-square exceeds chi_limit */
    double chi_limit;         /* the limit in force */
    double chi_median;        /* median chi-square of the valid frames, to 0.2 %; NaN without one */
    int64_t rejected_for[16]; /* [reason - TOLIMAN_TRACK_REASON_NONE], frames rejected for each reason */
} toliman_track_info;
#define TOLIMAN_TRACK_INFO_INIT TOLIMAN_INIT(toliman_track_info)

/* Writes the counts and properties of a tracker to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_info(const toliman_track *track,
                                                                     toliman_track_info *out) TOLIMAN_NOEXCEPT;

/* Writes the options in force to *options, whose struct_size must be set, with defaults resolved. folder and
 * clock.pairs (NULL if camera time is TAI) point to memory of the tracker. Pointers to objects, callbacks and the
 * allocator are NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_get_options(const toliman_track *track, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Returns the tracker's periodogram in *out, for all queries of period.h. It is updated by every push and belongs to
 * the tracker, which destroys it. Queries during a push return TOLIMAN_E_STATE. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_period(const toliman_track *track,
                                                                       const toliman_period **out) TOLIMAN_NOEXCEPT;

/* Refines the highest peak with the accepted values, as toliman_period_query_fit: period, amplitude, phase at TAI
 * time_offset_ns, and standard errors. The result does not depend on the order of arrival. Reads all records and
 * temporarily takes 100 bytes per frame. Errors as toliman_period_query_fit; TOLIMAN_E_FORMAT if the ledger has been
 * damaged since it was opened. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_query_fit(const toliman_track *track,
                                                                      toliman_period_peak *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
