"""Sums of short frames. Reference: include/toliman/coadd.h."""
from __future__ import annotations

import ctypes
import functools
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import INT64, of_kind, options_of, real, refuse_lost, saved, whole, within
from ._handle import Handle
from ._library import check, library
from ._predictions import prediction_of
from ._progress import Progress, Watch
from ._results import CoaddInfo, CoaddOutcome, CoaddSum
from ._shown import brief_repr, documented, members_html
from ._spread import Spread
from .fit import Fit


@documented(counts="[row][column]", left_out="number of frames in which each pixel was left out [row][column]",
            spread="of the places of the stars", sum="other properties")
class Taken(typing.NamedTuple):
    """A sum: counts [row][column], number of frames in which each pixel was left out [row][column], spread of the
    places, and the other properties."""

    counts: NDArray[numpy.uint32]
    left_out: NDArray[numpy.uint32]
    spread: Spread
    sum: CoaddSum

    def __repr__(self) -> str:
        return brief_repr(self)

    def _repr_html_(self) -> str:
        return members_html(self)


class Coadd(Handle):
    """Adds short frames, 100 per second, to one frame per hour or day, each registered on the forward model and tested.

        coadd = Coadd(fit, time_days=days, duration_s=3600, aligned=True)
        for time_ns, frame in zip(times_ns, frames):
            if coadd.add(frame, time_ns).verdict == "next":
                sums.append(coadd.take())
                coadd.add(frame, time_ns)
        result, values, covariance = fit.frame(sum.counts, time_days=days, shift=(sum.sum.x_px, sum.sum.y_px), spread=sum.spread)

    fit: Fit of the scene of one short frame; not needed afterwards.
    time_days, shift: predicted time and shift of the stars, as those of Fit.
    range_px, chi_square_max, duration_s, aligned, gap_s, motion_px, pause_s: as in toliman_coadd_options; 0 is the
        default.
    threads, progress: of the preparation of the model images.
    """

    _kind, _destroy = _raw.toliman_coadd, "toliman_coadd_destroy"

    def __init__(self, fit: Fit, *, time_days: typing.Any = None, shift: tuple[float, float] = (0, 0), range_px: int = 0,
                 chi_square_max: float = 0, duration_s: float = 0, aligned: bool = False, gap_s: float = 0,
                 motion_px: float = 0, pause_s: float = 0, threads: int = 0,
                 progress: Progress | bool | None = None):
        of_kind("fit", fit, Fit)
        prediction = prediction_of(fit._days("time_days", time_days, 0), shift, 0, 0)
        with Watch(progress) as watch:
            options = options_of(_raw.toliman_coadd_options, flags=_raw.TOLIMAN_COADD_ALIGNED if aligned else 0,
                                 threads=whole("threads", threads, 2**32), range_px=whole("range_px", range_px, 2**32),
                                 chi_square_max=real("chi_square_max", chi_square_max),
                                 duration_s=real("duration_s", duration_s), gap_s=real("gap_s", gap_s),
                                 motion_px=real("motion_px", motion_px), pause_s=real("pause_s", pause_s),
                                 progress=watch.callback)
            super().__init__(self._create(library.toliman_coadd_create, fit._c, ctypes.byref(prediction),
                                          ctypes.byref(options), check=watch.check))
        self.shape = fit.shape

    @property
    def info(self) -> CoaddInfo:
        """Properties of the object and of the present sum."""
        return self._read(library.toliman_coadd_get_info, _raw.toliman_coadd_info, CoaddInfo)

    def add(self, frame: ArrayLike, camera_ns: int, *, exposure_s: float = 0, session: str = "session",
            roi: str = "roi", dropped: int = 0) -> CoaddOutcome:
        """Registers, tests and adds one frame [row][column] of unsigned integers. camera_ns: middle of its exposure.
        With the verdict "next", the frame was not added: take() the sum, then add it again."""
        refuse_lost("frame", frame)
        counts = numpy.asarray(frame)
        if counts.dtype.kind != "u":
            raise TypeError(f"frame is of {counts.dtype}: must be of unsigned integers")
        if counts.dtype.itemsize > 4:
            raise TypeError(f"frame is of {counts.dtype}: must be of 8, 16 or 32 bits")
        if counts.shape != self.shape:
            raise ValueError(f"frame has the shape {counts.shape}: must be {self.shape}")
        pixels = {1: _raw.TOLIMAN_PIXEL_U8, 2: _raw.TOLIMAN_PIXEL_U16, 4: _raw.TOLIMAN_PIXEL_U32}
        counts = numpy.ascontiguousarray(counts, counts.dtype.newbyteorder("="))
        given = _raw.toliman_frame(pixel=pixels[counts.dtype.itemsize], session=session.encode(), roi=roi.encode(),
                                   camera_ns=within("camera_ns", camera_ns, -INT64, INT64),
                                   dropped=whole("dropped", dropped), pixels=counts.ctypes.data, rows=self.shape[0],
                                   cols=self.shape[1], exposure_s=real("exposure_s", exposure_s))
        outcome = _raw.toliman_coadd_outcome()
        with self._exclusive():
            check(library.toliman_coadd_add(self._c, ctypes.byref(given), ctypes.byref(outcome)))
        return CoaddOutcome._of(outcome)

    def take(self) -> Taken:
        """Ends the sum and begins the next one. Raises StateError if no frame was added."""
        frame, found = _raw.toliman_frame(), _raw.toliman_coadd_sum()
        with self._exclusive():
            check(library.toliman_coadd_take(self._c, ctypes.byref(frame), ctypes.byref(found)))
            images = ctypes.POINTER(ctypes.c_uint32)
            counts, left_out = (numpy.ctypeslib.as_array(ctypes.cast(pixels, images), self.shape).copy()
                                for pixels in (frame.pixels, found.left_out))
            return Taken(counts, left_out, Spread.of(frame.spread.contents), CoaddSum._of(found))

    def to_bytes(self) -> bytes:
        """Returns the present sum as bytes, for load_bytes()."""
        return saved(functools.partial(library.toliman_coadd_save, self._c))

    def load_bytes(self, content: bytes) -> None:
        """Continues the sum that to_bytes() of an object for the same fit and options returned."""
        content = memoryview(content).tobytes()
        with self._exclusive():
            check(library.toliman_coadd_load(self._c, content, len(content)))

    def _summary(self) -> str:
        info = self.info
        return f"Coadd of {info.rows}x{info.cols} frames, {info.frames} in the present sum"
