"""Reads the mission's pairs of files, also while they grow, and batches of frames. Reference: include/toliman/ingest.h."""
from __future__ import annotations

import ctypes
import dataclasses
import logging
import os
import time
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import INT64, file_name, of_kind, options_of, real, refuse_lost, text, whole, within
from ._handle import Handle
from ._library import check, library
from ._results import PairInfo
from ._shown import Shown
from ._words import number, words
from .tracker import Frame

_log = logging.getLogger("toliman")
_PIXELS = {None: 0, "u16le": _raw.TOLIMAN_PIXEL_U16, "u32le": _raw.TOLIMAN_PIXEL_U32}
_TYPES = {_raw.TOLIMAN_PIXEL_U16: ctypes.c_uint16, _raw.TOLIMAN_PIXEL_U32: ctypes.c_uint32}
_EVENTS = words("TOLIMAN_INGEST_EVENT")
_REASONS = words("TOLIMAN_INGEST_REASON")


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PairEvent(Shown):
    """An event of a Pair.

    kind: "frame", "damage" (a frame that cannot be read) or "warning" (a suspicious time stamp, whose frame follows, or
        extra bytes).
    reason: "bad_line", "short_file", "place_unknown", "clock_jump", "clocks_differ", "extra_bytes", "overlap", "restart" or
        "unknown_key"; "none" for a frame.
    file, line: where; line 0 is the whole file.
    text: what is wrong.
    frame: of a frame.
    key: session, roi, frame_id and restarts of a frame, and of damage if they are known.
    stamp_ns, host_s: timestamp_ns and host_time of a frame, as written.
    offset: place of a frame in the file of pixels, bytes, by the lines before it.
    """

    kind: str
    reason: str
    file: str
    line: int
    text: str
    frame: Frame | None
    key: tuple[str, str, int, int] | None
    stamp_ns: int
    host_s: float
    offset: int = 0

    def __str__(self) -> str:
        return f"{self.file}{f':{self.line}' if self.line else ''}: {self.text or self.kind}"


class Pair(Handle):
    """Frames of a pair of files, X_frames.bin and X_meta.jsonl, or of a batch, X.nc.

        for frame in Pair("day1"):
            tracker.push(frame)

    Iterating gives the frames that are complete now; damaged frames and suspicious times are logged as warnings to
    Python's logging, logger "toliman". events() gives all of them. A pair that grows may be iterated again, which gives
    what is new, or followed:

        for frame in Pair("day1", growing=True).follow():

    path: one of the two files, or X; or a batch.
    dtype: type of the pixels, "u16le" or "u32le"; None: found in the files.
    growing: the files may still grow.
    rows, cols: expected shape of a frame, which locates the frames if lines are damaged; 0: that of the first valid one.
    stamp: point of the exposure to which the time stamps refer: "start", "middle" or "end".
    exposure_s: length of an exposure; 0: unknown. With it, Frame.camera_ns is the middle of the exposure. Lines with
        on-target intervals, Frame.intervals, need it.
    frame_ids: a range; frames with other ids are skipped.
    roi: frames of other regions are skipped.
    copy: False gives pixels without copying them. They are valid until the next frame or the next iteration.

    Raises NotFoundError if a file is missing, InputError if the file of pixels has the size of the other dtype or a
    batch is damaged, UnsupportedError for a batch if the library was built without netCDF.
    """

    _kind, _destroy = _raw.toliman_ingest, "toliman_ingest_destroy"

    def __init__(self, path: str | os.PathLike[str], dtype: str | None = None, *, growing: bool = False, rows: int = 0, cols: int = 0,
                 stamp: str = "start", exposure_s: float = 0.0, frame_ids: range | None = None, copy: bool = True,
                 roi: str | None = None):
        if dtype not in _PIXELS:
            raise ValueError(f"dtype = {dtype!r}: must be u16le, u32le or None")
        first, end = _limits(frame_ids)
        options = options_of(_raw.toliman_ingest_options, pixel=_PIXELS[dtype],
                             flags=_raw.TOLIMAN_INGEST_GROWING if growing else 0, rows=whole("rows", rows),
                             cols=whole("cols", cols), stamp=number("stamp", stamp, "TOLIMAN_FRAME_STAMP"),
                             exposure_s=real("exposure_s", exposure_s), first_id=first, end_id=end,
                             roi=None if roi is None else text("roi", roi),
                             buffers=1 if copy else 2)  # a view outlives the end of the iteration
        self._copy, self._growing = copy, growing
        self._finished = False
        super().__init__(self._create(library.toliman_ingest_create, file_name(path), ctypes.byref(options)))

    def events(self) -> typing.Iterator[PairEvent]:
        """Yields the events up to now: frames, damage and warnings in the order of the lines."""
        if self._finished:
            check(library.toliman_ingest_finish(self._c))
        while True:
            frame, event = _raw.toliman_frame(), _raw.toliman_ingest_event()
            check(library.toliman_ingest_next(self._c, ctypes.byref(frame), ctypes.byref(event)))
            if event.event == _raw.TOLIMAN_INGEST_EVENT_NOTHING:
                return
            yield self._event(frame, event)

    def __iter__(self) -> typing.Iterator[Frame]:
        for event in self.events():
            if event.frame is None:
                _log.warning("%s", event)
            else:
                yield event.frame

    def follow(self, interval_s: float = 1.0) -> typing.Iterator[Frame]:
        """Yields the frames of a growing pair as they arrive and examines the files every interval_s seconds. Ends after
        finish(), which another thread or a signal handler may call."""
        if not self._growing:
            raise ValueError("growing = False: must be True for a pair that is followed")
        while not self._finished:
            yield from self
            time.sleep(real("interval_s", interval_s))
        yield from self

    def finish(self) -> None:
        """Ends the growth of the files: the next iteration reports lines without pixels and pixels without line, unless
        the files have changed since the last two iterations."""
        self._finished = True

    def find_frame(self, offset: int, reference: ArrayLike) -> tuple[NDArray, int] | None:
        """Finds a frame that is not at its place, because the file has lost or gained bytes before it. offset: that of its
        event. reference: pixels of an undamaged frame. Returns its pixels, and how many bytes it is from its place, for
        set_shift; None if it is not found elsewhere. Let a chi-square confirm it."""
        info = _raw.toliman_ingest_info()
        check(library.toliman_ingest_get_info(self._c, ctypes.byref(info)))
        refuse_lost("reference", reference)
        given = numpy.ascontiguousarray(reference, _TYPES.get(info.pixel))
        if given.ndim != 2:
            raise ValueError(f"reference: has {given.ndim} dimensions: must have 2")
        frame = _raw.toliman_frame(pixel=info.pixel, rows=given.shape[0], cols=given.shape[1],
                                   pixels=given.ctypes.data)
        found, shift = numpy.empty_like(given), ctypes.c_int64()
        check(library.toliman_ingest_find_frame(self._c, within("offset", offset, 0, INT64), ctypes.byref(frame),
                                                found.ctypes.data, found.nbytes, ctypes.byref(shift)))
        return (found, shift.value) if shift.value else None

    def set_shift(self, shift: int) -> None:
        """Reads the frames that follow `shift` bytes from their places."""
        check(library.toliman_ingest_set_shift(self._c, within("shift", shift, -INT64, INT64)))

    def info(self) -> PairInfo:
        """Returns the properties and counts of the reader."""
        return self._read(library.toliman_ingest_get_info, _raw.toliman_ingest_info, PairInfo)

    def _event(self, frame: _raw.toliman_frame, event: _raw.toliman_ingest_event) -> PairEvent:
        key = (frame.session.decode(), frame.roi.decode(), frame.frame_id, frame.restarts) if event.has_key else None
        return PairEvent(_EVENTS[event.event], _REASONS[event.reason], os.fsdecode(event.file), event.line,
                         event.text.decode(errors="replace"), self._frame(frame) if frame.pixels else None, key,
                         event.stamp_ns, event.host_s, event.offset)

    def _frame(self, frame: _raw.toliman_frame) -> Frame:
        memory = (_TYPES[frame.pixel] * (frame.rows * frame.cols)).from_address(frame.pixels)
        memory.owner = self._c  # the reader owns the pixels
        pixels = numpy.frombuffer(memory, memory._type_).reshape(frame.rows, frame.cols)
        intervals = None
        if frame.interval_count:
            intervals = numpy.ctypeslib.as_array(frame.intervals, (frame.interval_count, 2)).copy()
        return Frame(pixels.copy() if self._copy else pixels, frame.frame_id, frame.camera_ns, frame.session.decode(),
                     frame.roi.decode(), frame.dropped, exposure_s=frame.exposure_s, intervals=intervals,
                     window=(frame.window_row, frame.window_col), restarts=frame.restarts)

    def _summary(self) -> str:
        info = self.info()
        return f"Pair {info.side_file}: {info.frames} frames, {info.damaged} damaged"


def _limits(frame_ids: range | None) -> tuple[int, int]:
    """Returns the first frame id and the one after the last."""
    if frame_ids is None:
        return 0, 0
    ids = of_kind("frame_ids", frame_ids, range)
    if ids.step != 1 or not ids:
        raise ValueError(f"frame_ids = {ids}: must be a range of consecutive numbers, not empty")
    return within("frame_ids.start", ids.start, -INT64, INT64), within("frame_ids.stop", ids.stop, -INT64, INT64)
