"""Tracks frames of a downlink: estimates, records and adds each exactly once to a periodogram.

Reference: include/toliman/track.h.
"""
from __future__ import annotations

import ctypes
import dataclasses
import json
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._library import check, check_asked, library
from ._arguments import (INT64, array_of, file_name, listed, of_kind, options_of, pointer, real, refuse_lost, shaped, text,
                         whole, whole_float, within)
from ._handle import Handle
from ._log import log
from ._pixels import FRAMES_PER_CALL, PIXELS
from ._progress import Progress, Watch
from ._results import FolderGoodness, Outcome, Record, Stream, TrackInfo
from ._shown import Shown
from ._table import Column, Records, Rows, Tabular, Units, records_of
from ._words import number, words
from .bank import Bank
from .cae import CAE
from .fit import Fit
from .linear import Template
from .measure import Measurements
from .periodogram import Peak, View, warn_if_inaccurate
from .sky import Sky
from .times import unit_of_ns


@dataclasses.dataclass(frozen=True, repr=False)
class Estimate(Shown):
    """Result of a user-supplied estimator that returns more than one number. All members are stored in the ledger.

    value: the estimate, pushed to the periodogram. further: additional values, in the order of the tracker's `values`.
    covariance: [value][value] of all values. sigma: standard deviation of `value`; 0 takes the frame's. chi_square: per
    pixel, against the estimator's model. flags: bits defined by the estimator.
    """

    value: float
    further: typing.Sequence[float] = ()
    covariance: ArrayLike | None = None
    sigma: float = 0.0
    chi_square: float = numpy.nan
    flags: int = 0


# Converts an image [row][column] to a number: a network, a template, a fit, a bank, or a function.
Estimator = typing.Union[CAE, Template, Fit, Bank, typing.Callable[[NDArray], typing.Union[float, Estimate]]]

VERDICTS = words("TOLIMAN_TRACK_VERDICT")
REASONS = words("TOLIMAN_TRACK_REASON")


@dataclasses.dataclass(eq=False, repr=False)
class Frame(Shown):
    """A frame as received.

    pixels: [row][column] of uint8, uint16, uint32, int16, int32, float32 or float64; read in place if rows are
        contiguous.
    frame_id, session, roi, restarts: identify the frame. A second frame with the same four is a duplicate if its bytes
        are equal; otherwise both are quarantined. restarts: how often the camera has restarted within the session, so
        that its ids begin again.
    camera_ns: time of the camera's clock, in ns.
    dropped: number of frames that the camera dropped before this one.
    sigma: standard deviation of this frame's value; 0 takes the tracker's.
    exposure_s: exposure time in s; 0: unknown.
    intervals: [n][2], start and end of each interval on target, in s from the start of the exposure.
    window: row and column on the detector of the first pixel.
    """

    pixels: NDArray
    frame_id: int
    camera_ns: int
    session: str = "session"
    roi: str = "full"
    dropped: int = 0
    sigma: float = 0.0
    exposure_s: float = 0.0
    intervals: ArrayLike | None = None
    window: tuple[int, int] = (0, 0)
    restarts: int = 0

    def __array__(self, dtype: typing.Any = None, copy: bool | None = None) -> NDArray:
        """The pixels, so that an estimator encodes a frame as it is."""
        made = numpy.asarray(self.pixels, dtype)
        return made.copy() if copy else made


class _RunningCall:
    """Holds the Watch of the running call, which receives exceptions of the estimator function."""

    def __init__(self) -> None:
        self.watch = Watch(None)


class Tracker(Handle, Tabular):
    """Maintains the periodogram of all valid frames, received in any order, duplicated or damaged.

        with Tracker(template, f0, df, nf, folder="mission") as tracker:
            outcome = tracker.push(Frame(pixels, frame_id=3, camera_ns=259200000000000))
            print(outcome.verdict, tracker.period.peak())
            tracker.save()

    Each frame is checked, estimated, time-stamped, recorded in a ledger, and added to the periodogram exactly once. The
    periodogram is bit-identical for any order of arrival.

    Parameters

    estimator: a CAE, a Template, a Fit, a Bank, which measures with its fit, or a function of an image [row][column]
        that returns a float or an Estimate. A function also needs estimator_id, sigma, rows, cols and image_shape. None
        if no frames will be pushed.
    f0, df, nf: frequencies f0 + k df in cycles per unit_ns nanoseconds (a day by default). nf = 0 takes the folder's.
    folder: folder of the ledger, created if missing; None keeps everything in memory.
    capacity: maximum number of frames.
    sigma: standard deviation of a value; 0 takes the Cramer-Rao bound of a CAE or Template, half of
        that of a Fit or of the fit of a Bank.
    estimator_id: a number that distinguishes this estimator from others.
    values: names of the values in Estimate.further.
    value_limit: frames with |value| above the limit are outliers; 0 means 10,000 sigma, with sky at least 0.25 px.
    rows, cols: shape of the frames. Only a function needs it, and image_shape.
    crop, bin, image_shape: first (row, column) of the crop, side of the square of pixels that are summed, and shape of
        the resulting image, which the estimator receives.
    bit_depth: reject frames with a pixel of 2^bit_depth or more; 0: no limit.
    zero_run_bytes: reject frames with a run of zero pixels of at least this many bytes (a lost packet), unless
        allow_zero_runs is set.
    time_offset_ns: TAI time subtracted from all times, in ns.
    fit_mean, double_limb: as for Periodogram.
    threads: threads for the frames of one push_many; 0 means one per processor, but one thread for a function.
    clock: pairs [n][2] of camera and TAI nanoseconds, interpolated linearly; None takes the folder's, or for a new
        folder assumes that camera times are TAI.
    sync: durability of ledger records: "group" (fsync every `group` records), "frame" (every record) or "none".
    read_only: open the folder for queries; a writer may be active.
    rebuild: recompute the sums from the ledger with the given grid and clock.
    stamp, exposure_s: the time stamps from which the camera times of all frames were computed: "start", "middle" or
        "end" of an exposure of this length, in s. Recorded in the folder; they change no time. None and 0 take the
        folder's, or for a new folder "middle" and unknown.
    sky: the Sky, a system and its observer, by which separations are reduced: the value of a frame is then its measured
        separation divided by the factor, minus the separation on the orbit (Sky.reduce), in px. Needs a Fit or Bank, or
        a function with the value separation_px. With rebuild, all frames of the folder are reduced again.
    plate_scale_arcsec: arcsec per px of the reduction; 0 takes the folder's, or that of the scene of a Fit.
    trend: nuisance functions, fitted with the mean at each frequency: the highest order of a polynomial in time, 0 for
        the mean alone. None: the errors of the orbit (Sky.error_columns) in a new folder with sky, or with rebuild and
        sky; otherwise those of the folder, in a new one the mean alone.
    span: first and last time of the trend, in units of unit_ns since time_offset_ns; later frames are rejected. None:
        from -0.05/df to 0.15/df, twice the time span that suits the grid.
    scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1); 0 takes the folder's.
    chi_limit: chi-square above which a frame is a misfit, not in the periodogram; "median": 4 times the median of the
        folder's frames, at least 2 and at most 100. None: that of the folder, in a new one 2 for the Fit of a calibrated
        scene, otherwise "median".

    Recoverable damage to the folder is logged as warnings to Python's logging, logger "toliman".

    Raises InputError if the folder belongs to another estimator, grid or geometry, StateError if another process is
    writing to the folder, LostError for a truncated ledger, CapacityError if the folder holds more frames.
    """

    _kind, _destroy = _raw.toliman_track, "toliman_track_destroy"
    _frames_per_call = FRAMES_PER_CALL

    def __init__(self, estimator: Estimator | None, f0: float = 0.0, df: float = 0.0, nf: int = 0, *,
                 folder: str | os.PathLike[str] | None = None, capacity: int = 2**20, sigma: float = 0.0,
                 estimator_id: int = 0, values: typing.Sequence[str] = (), value_limit: float = 0.0, rows: int = 0,
                 cols: int = 0, crop: tuple[int, int] = (0, 0), bin: int = 1, image_shape: tuple[int, int] = (0, 0),
                 bit_depth: int = 0, zero_run_bytes: int = 4096, allow_zero_runs: bool = False, time_offset_ns: int = 0,
                 unit_ns: float = 86400e9, fit_mean: bool = True, double_limb: bool = False, threads: int = 0,
                 clock: ArrayLike | None = None, sync: str = "group", group: int = 64, read_only: bool = False,
                 rebuild: bool = False, stamp: str | None = None, exposure_s: float = 0.0, sky: Sky | None = None,
                 plate_scale_arcsec: float = 0.0, trend: int | None = None,
                 span: tuple[float, float] | None = None, scale_sigma: float = 0.0,
                 chi_limit: float | str | None = None):
        start, end = (0.0, 0.0) if span is None else (real("span", end) for end in span)
        pairs, count = (None, 0) if clock is None else _clock_of(clock)
        options = options_of(
            _raw.toliman_track_options,
            flags=(_raw.TOLIMAN_TRACK_READ_ONLY if read_only else 0) | (_raw.TOLIMAN_TRACK_REBUILD if rebuild else 0)
            | (_raw.TOLIMAN_TRACK_ALLOW_ZERO_RUNS if allow_zero_runs else 0),
            folder=None if folder is None else file_name(folder),
            estimator={"id": whole("estimator_id", estimator_id, 2**64), "sigma": real("sigma", sigma),
                       "values": _names(values)},
            frames={"rows": whole("rows", rows), "cols": whole("cols", cols), "crop_row": whole("crop", crop[0]),
                    "crop_col": whole("crop", crop[1]), "bin": whole("bin", bin),
                    "image_rows": whole("image_shape", image_shape[0]),
                    "image_cols": whole("image_shape", image_shape[1]), "bit_depth": whole("bit_depth", bit_depth, 2**32),
                    "zero_run_bytes": whole("zero_run_bytes", zero_run_bytes, 2**32),
                    "stamp": 0 if stamp is None else number("stamp", stamp, "TOLIMAN_FRAME_STAMP"),
                    "exposure_s": real("exposure_s", exposure_s)},
            grid={"f0": real("f0", f0), "df": real("df", df), "nf": whole_float("nf", nf),
                  "time_offset_ns": within("time_offset_ns", time_offset_ns, -INT64, INT64),
                  "unit_ns": real("unit_ns", unit_ns),
                  "flags": ((0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN)
                            | (_raw.TOLIMAN_PERIOD_DOUBLE_LIMB if double_limb else 0)),
                  "trend": 0 if trend is None else whole("trend", trend, 2**31) or -1, "trend_start": start,
                  "trend_end": end},
            clock={"pairs": pairs, "count": count},
            reduction={"sky": None if sky is None else of_kind("sky", sky, Sky)._c,
                       "plate_scale_arcsec": real("plate_scale_arcsec", plate_scale_arcsec),
                       "scale_sigma": real("scale_sigma", scale_sigma)},
            limits={"value": real("value_limit", value_limit), "chi_square": _chi_limit_of(chi_limit)},
            ledger={"capacity": whole("capacity", capacity), "sync": number("sync", sync, "TOLIMAN_TRACK_SYNC"),
                    "group": whole("group", group, 2**32)},
            threads=whole("threads", threads, 2**32), log=log)
        self._running, self._read_only = _RunningCall(), read_only
        kept = _set_estimator(options.estimator, estimator, self._running), sky and sky._c
        super().__init__(self._create(library.toliman_track_create, ctypes.byref(options), keep=kept))
        if isinstance(estimator, CAE):
            estimator._trackers.add(self)
        if callable(estimator):  # so that no further frame is processed after an exception of the function
            self._frames_per_call = threads or 1

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Tracker:
        """Opens a folder read-only for queries; a writer may be active."""
        options, name = options_of_folder(folder), file_name(folder)
        options.folder = name
        options.flags, options.log = options.flags | _raw.TOLIMAN_TRACK_READ_ONLY, log
        self = cls.__new__(cls)
        self._running, self._read_only = _RunningCall(), True
        Handle.__init__(self, cls._create(library.toliman_track_create, ctypes.byref(options)))
        return self

    def push(self, frame: Frame) -> Outcome:
        """Processes one frame and returns its outcome. A rejected frame does not raise; see outcome.verdict."""
        return self.push_many([frame])[0]

    def push_many(self, frames: typing.Iterable[Frame], *, progress: Progress | bool | None = None) -> Rows[Outcome]:
        """Processes frames, in parallel if the tracker has several threads, and returns their outcomes.

        If the call raises, the exception's attribute `outcomes` has the outcomes of the frames already processed. An
        exception of the estimator function is re-raised after its frame has been rejected.

        Raises InputError for an impossible frame, CapacityError, WriteError if the ledger cannot be written, LostError
        if another program changed the ledger.
        """
        return self._push_all(iter(frames), len(frames) if isinstance(frames, typing.Sized) else 0, progress)

    def _push_all(self, frames: typing.Iterator[Frame], count: int, progress: Progress | bool | None) -> Rows[Outcome]:
        """As push_many; count: of the frames, 0 if unknown."""
        self._c  # not closed
        outcomes: Rows[Outcome] = Rows()
        try:
            with Watch(progress) as watch:
                self._running.watch = watch
                at_end = False
                while not at_end:
                    part, raised = watch.take(frames, self._frames_per_call)
                    at_end = len(part) < self._frames_per_call
                    if part:
                        self._push(part, outcomes)
                    if raised is not None:
                        raise raised
                    watch.step("frames", len(outcomes) / count if count else 0)
        except BaseException as error:
            error.outcomes = outcomes  # type: ignore[attr-defined]
            raise
        return outcomes

    def _push(self, frames: list[Frame], processed: Rows[Outcome]) -> None:
        kept, structs, refused = [], [], None
        for frame in frames:
            try:
                pixels, intervals = _pixels_of(frame), _intervals_of(frame)
                structs.append(_struct_of(frame, pixels, intervals))
            except (TypeError, ValueError) as error:  # after the frames before it
                refused = error
                break
            kept.append((pixels, intervals))  # what the structs point to
        given = (_raw.toliman_frame * len(structs))(*structs)
        outcomes, done = array_of(_raw.toliman_track_outcome, len(structs)), ctypes.c_size_t()
        status = library.toliman_track_push(self._c, given, len(structs), outcomes, ctypes.byref(done))
        processed += [Outcome._of(outcome) for outcome in outcomes[:done.value]]
        self._running.watch.check(status)
        if refused is not None:
            raise refused

    def commit(self) -> None:
        """Makes all ledger records durable with fsync: all frames pushed so far are then acknowledged."""
        check(library.toliman_track_commit(self._c))

    def save(self) -> None:
        """Commits, and writes a checkpoint of the sums so that reopening the folder is fast."""
        check(library.toliman_track_save(self._c))

    def merge(self, folder: str | os.PathLike[str], *, salvage: bool = False) -> int:
        """Adds the ledger records of another folder, as if its frames had been pushed here, and commits.

        salvage: skip damaged records instead of raising. Returns the number of records that were skipped. A folder may
        be merged again after it has grown; only new records count.
        """
        lost, flags = ctypes.c_int64(), _raw.TOLIMAN_TRACK_SALVAGE if salvage else 0
        check(library.toliman_track_merge(self._c, file_name(folder), flags, ctypes.byref(lost)))
        return lost.value

    def close(self) -> None:
        """Commits and frees the memory. If close() is never called, the garbage collector or the exit of Python commits
        without reporting errors."""
        try:
            if self._pointer is not None and not self._read_only:
                self.commit()
        finally:
            super().close()

    @property
    def info(self) -> TrackInfo:
        """Counts of received, accepted and other frames; `rejected` has the counts by reason."""
        return self._read(library.toliman_track_get_info, _raw.toliman_track_info, TrackInfo)

    @property
    def options(self) -> dict[str, typing.Any]:
        """Options in effect, defaults resolved, by the names of the constructor: grid, geometry, limits, folder, values,
        sync."""
        struct = _raw.toliman_track_options()
        check(library.toliman_track_get_options(self._c, ctypes.byref(struct)))
        numbers = (ctypes.c_double, ctypes.c_int32, ctypes.c_int64, ctypes.c_uint32, ctypes.c_uint64)
        options = {}
        for group in (struct, *(getattr(struct, name) for name, kind in struct._fields_
                                if isinstance(kind, type) and issubclass(kind, ctypes.Structure))):
            for name, kind in group._fields_:
                if kind in numbers and name not in ("struct_size", "reserved"):
                    options[_OPTION_NAMES.get((type(group), name), name)] = getattr(group, name)
        options["values"] = tuple(filter(None, struct.estimator.values.decode().split()))
        options["folder"] = None if struct.folder is None else os.fsdecode(struct.folder)
        options["sync"] = words("TOLIMAN_TRACK_SYNC")[struct.ledger.sync]
        options["stamp"] = words("TOLIMAN_FRAME_STAMP")[struct.frames.stamp]
        return options

    @property
    def goodness(self) -> FolderGoodness:
        """Goodness of fit of the folder's frames: median and trend of chi-square, counts, and that of the calibration."""
        return self._read(library.toliman_track_query_goodness, _raw.toliman_track_goodness, FolderGoodness)

    @property
    def rejected(self) -> dict[str, int]:
        """Number of frames rejected for each reason."""
        info = _raw.toliman_track_info()
        check(library.toliman_track_get_info(self._c, ctypes.byref(info)))
        return {REASONS[reason]: info.rejected_for[reason - _raw.TOLIMAN_TRACK_REASON_NONE]
                for reason in range(_raw.TOLIMAN_TRACK_REASON_SHAPE, _raw.TOLIMAN_TRACK_REASON_ESTIMATE + 1)}

    @property
    def period(self) -> View:
        """The tracker's periodogram, a View that reflects every push."""
        return _TrackerView(self)

    def fit(self) -> Peak:
        """Refines the highest peak by least squares against the accepted values. Returns period, amplitude and phase
        with standard errors."""
        found = _raw.toliman_period_peak()
        check(library.toliman_track_query_fit(self._c, ctypes.byref(found)))
        peak = Peak._of(found, self._units)
        warn_if_inaccurate(peak.inaccurate)
        return peak

    def measurements(self, kind: str = "", unit: float = 0) -> Measurements:
        """The frames as a series for the search for planets, or with kind="separation" for a refit of the orbit.

        unit: arcsec per px; 0: that of the reduction."""
        return Measurements._of_tracker(self._c, kind, unit)

    def records(self, first: int = 0, count: int | None = None) -> Records:
        """Returns ledger records in the order of arrival, by default all from index `first`.

        The structured array has a field for each member of toliman_track_record and each column of the ledger. verdict
        and reason are numbers; VERDICTS and REASONS map them to words.
        """
        first = whole("first", first)
        available = max(self.info.records - first, 0)
        count = available if count is None else min(whole("count", count), available)
        found, done = array_of(_raw.toliman_track_record, count), ctypes.c_size_t()
        check(library.toliman_track_get_records(self._c, first, count, found, ctypes.byref(done)))
        fixed = numpy.ctypeslib.as_array(found)[:done.value]
        names = [name for name in fixed.dtype.names or () if name != "struct_size"]
        columns = [(name, kind) for name, kind in self._ledger_columns() if name not in names]
        records = numpy.empty(len(fixed), [(name, fixed.dtype[name]) for name in names] + columns)
        for name in names:
            records[name] = fixed[name]
        numbers = numpy.empty(len(records))
        for name, _ in columns:
            check(library.toliman_track_get_column(self._c, name.encode(), first, len(records), pointer(numbers),
                                                   ctypes.byref(done)))
            records[name] = numbers
        return records_of(records, Record, self._units)

    def intervals(self, record: int) -> NDArray[numpy.float64]:
        """Returns the on-target intervals with which the frame of a record came, [n][2] in s from the start of the exposure by
        the camera clock; empty without a list. record: index in records()."""
        record, count = within("record", record, 0, INT64), ctypes.c_size_t()
        check_asked(library.toliman_track_get_intervals(self._c, record, None, 0, ctypes.byref(count)))
        found = numpy.empty((count.value, 2))
        if count.value > 0:
            check(library.toliman_track_get_intervals(self._c, record, pointer(found), count, ctypes.byref(count)))
        return found

    def _ledger_columns(self) -> list[tuple[str, type]]:
        """Returns names and types of the ledger's columns."""
        return [(column.name.decode(), numpy.int64 if column.type == _raw.TOLIMAN_TRACK_COLUMN_I64 else numpy.float64)
                for column in listed(_raw.toliman_track_column, library.toliman_track_get_columns, self._c)]

    def _columns(self) -> dict[str, Column]:
        return self.records()._columns()

    def _facts(self) -> dict[str, typing.Any]:
        info, options = self.info, self.options
        return {"accepted": info.accepted, "received": info.received, "system": json.loads(info.system).get("name") if info.system else "",
                "folder": os.path.basename(options["folder"] or ""), "sigma": info.sigma,
                "scale": info.plate_scale_arcsec or None, "chi2max": info.chi_limit,
                "time0_ns": options["time_offset_ns"]}

    @property
    def _units(self) -> Units:
        return {"t": unit_of_ns(self.options["unit_ns"]), "y": "pix" if self.info.plate_scale_arcsec > 0 else ""}

    def streams(self) -> Rows[Stream]:
        """Returns the sessions and regions, sorted by name, each with its range of frame ids and the number missing."""
        return Rows(Stream._of(stream) for stream in listed(_raw.toliman_track_stream,
                                                            library.toliman_track_get_streams, self._c))

    def clock(self) -> NDArray[numpy.int64]:
        """Returns the clock pairs [n][2] of camera and TAI nanoseconds; empty if camera times are TAI."""
        options = _raw.toliman_track_options()
        check(library.toliman_track_get_options(self._c, ctypes.byref(options)))
        count = options.clock.count
        return numpy.array(options.clock.pairs[:2 * count] if count > 0 else [], numpy.int64).reshape(count, 2)

    def _summary(self) -> str:
        info = self.info
        return f"Tracker of {info.accepted} frames, {info.received - info.accepted} others"


def options_of_folder(folder: str | os.PathLike[str]) -> typing.Any:
    """Returns the options with which a folder was made, as a C struct. NotFoundError if there is none."""
    options = _raw.toliman_track_options()
    check(library.toliman_track_load_options(file_name(folder), ctypes.byref(options)))
    return options


class _TrackerView(View):
    """The periodogram of a tracker, destroyed with the tracker."""

    def __init__(self, tracker: Tracker):
        super().__init__(None)
        self._tracker = tracker

    @property
    def _c(self) -> typing.Any:
        tracker = self._tracker._c
        return self._create(library.toliman_track_get_period, tracker, keep=tracker)

    @property
    def _units(self) -> Units:
        return self._tracker._units


# Options whose names in Python are not those of the members of C.
_OPTION_NAMES = {(_raw.toliman_track_estimator, "id"): "estimator_id", (_raw.toliman_track_grid, "flags"): "period_flags",
                 (_raw.toliman_track_limits, "value"): "value_limit",
                 (_raw.toliman_track_limits, "chi_square"): "chi_limit"}


def _set_estimator(options: typing.Any, estimator: Estimator | None, running: _RunningCall) -> typing.Any:
    """Stores the estimator in the options; returns the object that must live as long as the tracker."""
    if isinstance(estimator, CAE):
        options.cae = estimator._c
        return estimator._c
    if isinstance(estimator, Template):
        options.linear = estimator._c
        return estimator._c
    if isinstance(estimator, Fit):
        options.fit = estimator._c
        return estimator._c
    if isinstance(estimator, Bank):
        options.fit, options.bank = estimator.fit._c, estimator._c
        return estimator.fit._c, estimator._c
    if callable(estimator):
        function = estimator

        def estimate(given: typing.Any, made: typing.Any, _: object) -> int:
            given, made = given.contents, made.contents
            # A copy, since the function may keep the image.
            image = numpy.ctypeslib.as_array(given.image, (given.rows, given.stride))[:, :given.cols].copy()
            _store(function(image), made)
            return 0
        callback = _raw.toliman_estimate_fn(lambda *arguments: running.watch.run(estimate, *arguments))
        options.estimate = callback
        return callback
    if estimator is not None:
        raise TypeError(f"estimator is a {type(estimator).__name__}: must be a CAE, a Template, a Fit, a Bank, a function "
                        "or None")
    return None


def _store(found: float | Estimate, made: typing.Any) -> None:
    """Writes the return value of an estimator function to the C struct."""
    if not isinstance(found, Estimate):
        made.values[0] = float(found)
        return
    values = (found.value, *found.further)
    if len(values) > made.value_count:
        raise ValueError(f"further has {len(found.further)} values: must have at most {made.value_count - 1}, the "
                         "number of names in the tracker's `values`")
    for i, value in enumerate(values):
        made.values[i] = real("value", value)
    if found.covariance is not None:
        for i, entry in enumerate(shaped("covariance", found.covariance, (made.value_count,) * 2).flat):
            made.covariance[i] = entry
    made.sigma, made.chi_square = real("sigma", found.sigma), real("chi_square", found.chi_square)
    made.flags = whole("flags", found.flags, 2**32)


def _chi_limit_of(chi_limit: float | str | None) -> float:
    if chi_limit is None:
        return 0.0
    if isinstance(chi_limit, str):
        if chi_limit != "median":
            raise ValueError(f'chi_limit = {chi_limit!r}: must be a number above 0, "median" or None')
        return -1.0
    limit = real("chi_limit", chi_limit)
    if not limit > 0:
        raise ValueError(f'chi_limit = {limit!r}: must be a number above 0, "median" or None')
    return limit


def _names(values: typing.Sequence[str]) -> bytes:
    """Joins names of values, which C takes as one text."""
    names = text("values", " ".join([values] if isinstance(values, str) else values))
    if len(names) >= _raw.toliman_track_estimator.values.size:
        raise ValueError(f"values has {len(names)} characters: must be at most "
                         f"{_raw.toliman_track_estimator.values.size - 1}")
    return names


def _intervals_of(frame: Frame) -> NDArray | None:
    """Returns the intervals as an array [n][2], or None."""
    return None if frame.intervals is None else shaped("intervals", frame.intervals, (-1, 2), "s")


def _clock_of(clock: ArrayLike) -> tuple[typing.Any, int]:
    """Returns the clock pairs as a C array, and their number."""
    refuse_lost("clock", clock)
    pairs = numpy.asarray(clock)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iuO":
        raise ValueError(f"clock has the shape {pairs.shape} and type {pairs.dtype}: must be integers (any, 2)")
    times = [within("clock", time, -INT64, INT64) for time in pairs.flat]
    return (ctypes.c_int64 * pairs.size)(*times), len(pairs)


def _pixels_of(frame: Frame) -> NDArray:
    """Returns the pixels in native byte order with contiguous rows."""
    of_kind("frame", frame, Frame)
    refuse_lost("pixels", frame.pixels)
    pixels = numpy.asarray(frame.pixels)
    kind = pixels.dtype.newbyteorder("=")
    if pixels.ndim != 2 or kind.str[1:] not in PIXELS:
        raise TypeError(f"pixels has the shape {pixels.shape} and type {pixels.dtype}: must be (rows, columns) of "
                        f"{', '.join(PIXELS)}")
    pixels = pixels.astype(kind, copy=False)
    row, column = pixels.strides
    if column != kind.itemsize or row < pixels.shape[1] * column or row % column or not pixels.flags.aligned:
        pixels = numpy.require(pixels, requirements=["C", "A"])
    return pixels


def _struct_of(frame: Frame, pixels: NDArray, intervals: NDArray | None) -> typing.Any:
    return _raw.toliman_frame(
        pixel=PIXELS[pixels.dtype.str[1:]], session=text("session", frame.session),
        roi=text("roi", frame.roi),
        frame_id=within("frame_id", frame.frame_id, -INT64, INT64),
        camera_ns=within("camera_ns", frame.camera_ns, -INT64, INT64),
        dropped=within("dropped", frame.dropped, -INT64, INT64), pixels=pixels.ctypes.data, rows=pixels.shape[0],
        cols=pixels.shape[1], stride=pixels.strides[0] // pixels.itemsize, sigma=real("sigma", frame.sigma),
        exposure_s=real("exposure_s", frame.exposure_s), intervals=pointer(intervals),
        interval_count=0 if intervals is None else len(intervals),
        window_row=within("window", frame.window[0], -INT64, INT64),
        window_col=within("window", frame.window[1], -INT64, INT64),
        restarts=within("restarts", frame.restarts, -INT64, INT64))
