"""Tracker: frames off the downlink -> the period, losing nothing; include/toliman/track.h is the manual."""
from __future__ import annotations

import ctypes
import dataclasses
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._library import check, library
from ._arguments import (INT64, array_of, file_name, of_kind, options_of, pointer, real, refuse_lost, shaped, text, whole,
                         whole_float, within)
from ._handle import Handle
from ._log import log
from ._pixels import PIXELS
from ._progress import Progress, Watch
from ._results import Outcome, Stream, TrackInfo
from ._words import number, words
from .cae import CAE
from .linear import Template
from .periodogram import Peak, View, warn_if_inaccurate


@dataclasses.dataclass(frozen=True)
class Estimate:
    """What a function may return for an image in place of the value alone. further: values beyond the first, in the
    order of the tracker's `values`. covariance: [value][value] of all of them. sigma: of the first value, 0 is the
    frame's. chi_square: per pixel, against the function's model. flags: bits of its own. All are kept in the ledger."""

    value: float
    further: typing.Sequence[float] = ()
    covariance: ArrayLike | None = None
    sigma: float = 0.0
    chi_square: float = numpy.nan
    flags: int = 0


# What makes a number of an image [row][column]: a network, a template, or a function.
Estimator = typing.Union[CAE, Template, typing.Callable[[NDArray], typing.Union[float, Estimate]]]

VERDICTS = words("TOLIMAN_TRACK_VERDICT")
REASONS = words("TOLIMAN_TRACK_REASON")


@dataclasses.dataclass(eq=False)
class Frame:
    """A frame as it arrived. pixels: [row][column] of 8, 16 or 32 bits without sign, 16 or 32 with, float32 or float64,
    read where they lie if rows are contiguous. A frame is known by session, frame_id and roi. camera_ns: the camera's
    clock. dropped: frames that the camera dropped before this one. sigma: of this frame's value; 0 is the tracker's.
    exposure_s: length of the exposure, 0 where it is not known; intervals: [n][2] start and end of each time on the
    target, in s from the start of the exposure; window: row and column of the first pixel on the detector."""

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


class _Callers:
    """Who looks after the estimator's function: the call that runs."""

    def __init__(self) -> None:
        self.watch = Watch(None)


class Tracker(Handle):
    """Takes frames in any order, twice or damaged, and keeps the periodogram of all that are good.

        with Tracker(template, f0, df, nf, folder="mission") as tracker:
            outcome = tracker.push(Frame(pixels, frame_id=3, camera_ns=259200000000000))
            print(outcome.verdict, tracker.period.peak())
            tracker.save()

    estimator: a CAE, a Template, or a function of an image [row][column], which then needs `estimator_id`, a number
    that tells it from others, `sigma`, the standard deviation of its values, rows, cols and image_shape; None where
    nothing is pushed. values: names of what the function's Estimate has in `further`. Frequencies
    are in cycles per unit_ns nanoseconds, a day by default; without a grid the folder's is taken. folder: of the
    ledger, made unless it is there; None keeps all in memory. clock: pairs [n][2] of camera and TAI nanoseconds. rows, cols:
    of frames; crop (row, column), bin and image_shape: what of them the estimator gets. sync: group (every `group`
    lines), frame or none. threads work on the frames of one push_many; 0: one per processor, but one of a function.
    zero_run_bytes: so many bytes of zero pixels in a row reject a frame, unless allow_zero_runs is set.
    Damage to the folder that can be done without is told to Python's logging as "toliman".
    """

    _kind, _end = _raw.toliman_track, "toliman_track_destroy"
    _at_a_time = 64  # frames between two looks at progress and Ctrl-C

    def __init__(self, estimator: Estimator | None, f0: float = 0.0, df: float = 0.0, nf: int = 0, *,
                 folder: str | os.PathLike[str] | None = None, capacity: int = 2**20, sigma: float = 0.0,
                 estimator_id: int = 0, values: typing.Sequence[str] = (), value_limit: float = 0.0, rows: int = 0, cols: int = 0,
                 crop: tuple[int, int] = (0, 0), bin: int = 1, image_shape: tuple[int, int] = (0, 0),
                 bit_depth: int = 0, zero_run_bytes: int = 4096, allow_zero_runs: bool = False, time_offset_ns: int = 0, unit_ns: float = 86400e9,
                 fit_mean: bool = True, double_limb: bool = False, threads: int = 0, clock: ArrayLike | None = None,
                 sync: str = "group", group: int = 64, read_only: bool = False, rebuild: bool = False):
        options = options_of(
            _raw.toliman_track_options, library.toliman_track_options_init,
            f0=real("f0", f0), df=real("df", df), nf=whole_float("nf", nf), capacity=whole("capacity", capacity),
            sigma=real("sigma", sigma),
            estimator_id=whole("estimator_id", estimator_id, 2**64), values=_names(values), value_limit=real("value_limit", value_limit),
            rows=whole("rows", rows), cols=whole("cols", cols), crop_row=whole("crop", crop[0]),
            crop_col=whole("crop", crop[1]), bin=whole("bin", bin), image_rows=whole("image_shape", image_shape[0]),
            image_cols=whole("image_shape", image_shape[1]), bit_depth=whole("bit_depth", bit_depth, 2**32),
            zero_run_bytes=whole("zero_run_bytes", zero_run_bytes, 2**32), time_offset_ns=within("time_offset_ns", time_offset_ns, -INT64, INT64),
            unit_ns=real("unit_ns", unit_ns), threads=whole("threads", threads, 2**32), group=whole("group", group, 2**32),
            sync=number("sync", sync, "TOLIMAN_TRACK_SYNC"), log=log,
            period_flags=(0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN) | (_raw.TOLIMAN_PERIOD_DOUBLE_LIMB if double_limb else 0),
            flags=(_raw.TOLIMAN_TRACK_READ_ONLY if read_only else 0) | (_raw.TOLIMAN_TRACK_REBUILD if rebuild else 0)
            | (_raw.TOLIMAN_TRACK_ALLOW_ZERO_RUNS if allow_zero_runs else 0))
        if folder is not None:
            options.folder = file_name(folder)
        if clock is not None:
            options.clock, options.clock_points = _clock_of(clock)
        self._callers, self._read_only = _Callers(), read_only
        kept = _set_estimator(options, estimator, self._callers)
        super().__init__(self._made(library.toliman_track_create, ctypes.byref(options), keep=kept))
        if isinstance(estimator, CAE):
            estimator._trackers.add(self)
        if callable(estimator):  # no more of them after what it raises
            self._at_a_time = threads or 1

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Tracker:
        """A folder as it stands, to be asked, beside its writer if need be."""
        options, name = _raw.toliman_track_options(), file_name(folder)
        check(library.toliman_track_load_options(name, ctypes.byref(options)))
        options.folder = name
        options.flags, options.log = options.flags | _raw.TOLIMAN_TRACK_READ_ONLY, log
        self = cls.__new__(cls)
        self._callers, self._read_only = _Callers(), True
        Handle.__init__(self, cls._made(library.toliman_track_create, ctypes.byref(options)))
        return self

    def push(self, frame: Frame) -> Outcome:
        """Takes one frame and says what became of it; a rejected frame is no error."""
        return self.push_many([frame])[0]

    def push_many(self, frames: typing.Iterable[Frame], *, progress: Progress | bool | None = None) -> list[Outcome]:
        """Takes frames, many at once, which several threads need. After an exception its `outcomes` are those of the
        frames that are in. What an estimator raises goes through, after the frame is rejected."""
        self._c  # not closed
        frames = list(frames)
        outcomes: list[Outcome] = []
        try:
            with Watch(progress) as watch:
                self._callers.watch = watch
                for start in range(0, len(frames), self._at_a_time):
                    part = frames[start:start + self._at_a_time]
                    self._push(part, outcomes)
                    watch.step("frames", (start + len(part)) / len(frames))
        except BaseException as error:
            error.outcomes = outcomes  # type: ignore[attr-defined]
            raise
        return outcomes

    def _push(self, frames: list[Frame], told: list[Outcome]) -> None:
        pixels = [_pixels_of(frame) for frame in frames]
        intervals = [_intervals_of(frame) for frame in frames]
        given = (_raw.toliman_frame * len(frames))(*map(_struct_of, frames, pixels, intervals))
        outcomes, done = array_of(_raw.toliman_track_outcome, len(frames)), ctypes.c_size_t()
        status = library.toliman_track_push(self._c, given, len(frames), outcomes, ctypes.byref(done))
        told += [Outcome._of(outcome) for outcome in outcomes[:done.value]]
        self._callers.watch.check(status)

    def commit(self) -> None:
        """Brings every line to the disk: all frames that were pushed are then safe."""
        check(library.toliman_track_commit(self._c))

    def save(self) -> None:
        """The same and a checkpoint, so that taking up is quick."""
        check(library.toliman_track_save(self._c))

    def merge(self, folder: str | os.PathLike[str], *, salvage: bool = False) -> int:
        """Takes the lines of another folder, as if its frames had been pushed here. salvage: leave out what is damaged;
        how many lines that were is returned."""
        lost, flags = ctypes.c_int64(), _raw.TOLIMAN_TRACK_SALVAGE if salvage else 0
        check(library.toliman_track_merge(self._c, file_name(folder), flags, ctypes.byref(lost)))
        return lost.value

    def close(self) -> None:
        """Commits, and frees the memory. Without it the garbage collector or the end of Python commits, in silence."""
        try:
            if self._pointer is not None and not self._read_only:
                self.commit()
        finally:
            super().close()

    @property
    def info(self) -> TrackInfo:
        """Counts; `rejected` has those of each reason."""
        return self._read(library.toliman_track_get_info, _raw.toliman_track_info, TrackInfo)

    @property
    def options(self) -> dict[str, typing.Any]:
        """What is in force, by the names of toliman_track_options: grid, geometry, limits, folder, values, sync."""
        told = _raw.toliman_track_options()
        check(library.toliman_track_get_options(self._c, ctypes.byref(told)))
        known = {name: getattr(told, name) for name, kind in told._fields_
                 if kind in (ctypes.c_double, ctypes.c_int32, ctypes.c_int64, ctypes.c_uint32, ctypes.c_uint64)}
        del known["struct_size"]
        known["values"] = tuple(filter(None, told.values.decode().split(",")))
        known["folder"] = None if told.folder is None else os.fsdecode(told.folder)
        known["sync"] = words("TOLIMAN_TRACK_SYNC")[told.sync]
        return known

    @property
    def rejected(self) -> dict[str, int]:
        """Frames rejected for each of REASONS but none."""
        counts, frames = {}, ctypes.c_int64()
        for reason in list(REASONS)[1:]:
            check(library.toliman_track_get_rejected(self._c, reason, ctypes.byref(frames)))
            counts[REASONS[reason]] = frames.value
        return counts

    @property
    def period(self) -> View:
        """The periodogram, which follows every push."""
        return _Followed(self)

    def fit(self) -> Peak:
        """The highest peak refined by least squares on the values in the periodogram."""
        peak = self._read(library.toliman_track_query_fit, _raw.toliman_period_peak, Peak)
        warn_if_inaccurate(peak.inaccurate)
        return peak

    def records(self, first: int = 0, count: int | None = None) -> NDArray:
        """Lines of the ledger in the order of arrival, an array with a field for each member of toliman_track_record and
        for each of the ledger's columns; verdict and reason are numbers, VERDICTS and REASONS their words."""
        first = whole("first", first)
        there = max(self.info.records - first, 0)
        count = there if count is None else min(whole("count", count), there)
        found, done = array_of(_raw.toliman_track_record, count), ctypes.c_size_t()
        check(library.toliman_track_get_records(self._c, first, count, found, ctypes.byref(done)))
        fixed = numpy.ctypeslib.as_array(found)[:done.value]
        names = [name for name in fixed.dtype.names or () if name != "struct_size"]
        columns = self._columns()
        records = numpy.empty(len(fixed), [(name, fixed.dtype[name]) for name in names] + columns)
        for name in names:
            records[name] = fixed[name]
        numbers = numpy.empty(len(records))
        for name, _ in columns:
            check(library.toliman_track_get_column(self._c, name.encode(), first, len(records), pointer(numbers),
                                                   ctypes.byref(done)))
            records[name] = numbers
        return records

    def _columns(self) -> list[tuple[str, type]]:
        """Names and types of the ledger's columns."""
        count = ctypes.c_size_t()
        check(library.toliman_track_get_columns(self._c, None, 0, ctypes.byref(count)))
        found = array_of(_raw.toliman_track_column, count.value)
        check(library.toliman_track_get_columns(self._c, found, count, ctypes.byref(count)))
        return [(column.name.decode(), numpy.int64 if column.type == _raw.TOLIMAN_TRACK_COLUMN_I64 else numpy.float64)
                for column in found[:count.value]]

    def streams(self) -> list[Stream]:
        """Sessions and regions, sorted by name, with the frame ids from first to last and how many are missing."""
        count = ctypes.c_size_t()
        check(library.toliman_track_get_streams(self._c, None, 0, ctypes.byref(count)))
        found = array_of(_raw.toliman_track_stream, count.value)
        check(library.toliman_track_get_streams(self._c, found, count, ctypes.byref(count)))
        return [Stream._of(stream) for stream in found[:count.value]]

    def clock(self) -> NDArray[numpy.int64]:
        """Pairs [n][2] of camera and TAI nanoseconds; none where the camera's time is TAI."""
        points = ctypes.c_size_t()
        check(library.toliman_track_get_clock(self._c, None, 0, ctypes.byref(points)))
        pairs = numpy.empty((points.value, 2), numpy.int64)
        if len(pairs) > 0:
            check(library.toliman_track_get_clock(self._c, pairs.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
                                                  len(pairs), ctypes.byref(points)))
        return pairs

    def _told(self) -> str:
        info = self.info
        return f"Tracker of {info.accepted} frames, {info.received - info.accepted} others"

    def _repr_html_(self) -> str:
        return self.info._repr_html_()


class _Followed(View):
    """The periodogram of a tracker, which ends with it."""

    def __init__(self, tracker: Tracker):
        super().__init__(None)
        self._tracker = tracker

    @property
    def _c(self) -> typing.Any:
        tracker = self._tracker._c
        return self._made(library.toliman_track_get_period, tracker, keep=tracker)


def _set_estimator(options: typing.Any, estimator: Estimator | None, callers: _Callers) -> typing.Any:
    """Puts the estimator into the options; returns what must live as long as the tracker."""
    if isinstance(estimator, CAE):
        options.cae = estimator._c
        return estimator._c
    if isinstance(estimator, Template):
        options.linear = estimator._c
        return estimator._c
    if callable(estimator):
        function = estimator

        def estimate(given: typing.Any, made: typing.Any, _: object) -> int:
            given, made = given.contents, made.contents
            image = numpy.ctypeslib.as_array(given.image, (given.rows, given.stride))[:, :given.cols].copy()  # to keep
            _give(function(image), made)
            return 0
        options.estimate = callback = _raw.toliman_estimate_fn(lambda *arguments: callers.watch.run(estimate, *arguments))
        return callback
    if estimator is not None:
        raise TypeError(f"estimator is a {type(estimator).__name__}: must be a CAE, a Template, a function or None")
    return None


def _give(found: float | Estimate, made: typing.Any) -> None:
    """What a function returned, as C takes it."""
    if not isinstance(found, Estimate):
        made.values[0] = float(found)
        return
    values = (found.value, *found.further)
    if len(values) > made.value_count:
        raise ValueError(f"further has {len(found.further)} values: the tracker's `values` name {made.value_count - 1}")
    for i, value in enumerate(values):
        made.values[i] = real("value", value)
    if found.covariance is not None:
        for i, entry in enumerate(shaped("covariance", found.covariance, (made.value_count,) * 2).flat):
            made.covariance[i] = entry
    made.sigma, made.chi_square = real("sigma", found.sigma), real("chi_square", found.chi_square)
    made.flags = whole("flags", found.flags, 2**32)


def _names(values: typing.Sequence[str]) -> bytes:
    """Names of values, which C takes in one text."""
    names = text("values", ",".join([values] if isinstance(values, str) else values))
    if len(names) >= _raw.toliman_track_options.values.size:
        raise ValueError(f"values has {len(names)} characters: must be fewer than {_raw.toliman_track_options.values.size}")
    return names


def _intervals_of(frame: Frame) -> NDArray | None:
    """Pairs [n][2] in s, or None."""
    return None if frame.intervals is None else shaped("intervals", frame.intervals, (-1, 2))


def _clock_of(clock: ArrayLike) -> tuple[typing.Any, int]:
    pairs = numpy.asarray(clock)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iuO":
        raise ValueError(f"clock has the shape {pairs.shape} and type {pairs.dtype}: must be whole numbers (any, 2)")
    times = [within("clock", time, -INT64, INT64) for time in pairs.flat]
    return (ctypes.c_int64 * pairs.size)(*times), len(pairs)


def _pixels_of(frame: Frame) -> NDArray:
    """The pixels in the machine's byte order, with contiguous rows."""
    of_kind("frame", frame, Frame)
    refuse_lost("pixels", frame.pixels)
    pixels = numpy.asarray(frame.pixels)
    kind = pixels.dtype.newbyteorder("=")
    if pixels.ndim != 2 or kind.str[1:] not in PIXELS:
        raise TypeError(f"pixels has the shape {pixels.shape} and type {pixels.dtype}: must be (rows, columns) of "
                        f"{', '.join(PIXELS)}")
    pixels = pixels.astype(kind, copy=False)
    rows_apart, apart = pixels.strides
    if apart != kind.itemsize or rows_apart < pixels.shape[1] * apart or rows_apart % apart or not pixels.flags.aligned:
        pixels = numpy.require(pixels, requirements=["C", "A"])
    return pixels


def _struct_of(frame: Frame, pixels: NDArray, intervals: NDArray | None) -> typing.Any:
    return _raw.toliman_frame(
        pixel=PIXELS[pixels.dtype.str[1:]], session=text("session", frame.session),
        roi=text("roi", frame.roi),
        frame_id=within("frame_id", frame.frame_id, -INT64, INT64),
        camera_ns=within("camera_ns", frame.camera_ns, -INT64, INT64),
        dropped=within("dropped", frame.dropped, -INT64, INT64), pixels=pixels.ctypes.data, rows=pixels.shape[0], cols=pixels.shape[1],
        stride=pixels.strides[0] // pixels.itemsize, sigma=real("sigma", frame.sigma),
        exposure_s=real("exposure_s", frame.exposure_s), intervals=pointer(intervals),
        interval_count=0 if intervals is None else len(intervals),
        window_row=within("window", frame.window[0], -INT64, INT64), window_col=within("window", frame.window[1], -INT64, INT64))
