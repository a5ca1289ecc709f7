"""Tracks the frames of a scene in one call, with the defaults of `toliman track --fit`."""
from __future__ import annotations

import os
import typing
import warnings

import numpy
from numpy.typing import ArrayLike, NDArray

from ._arguments import whole
from ._library import StateError, UnsupportedError
from ._progress import Progress
from ._results import Outcome
from .fit import Fit
from .periodogram import grid_of_days
from .sim import Scene, Simulator, simulator_of
from .sky import Sky
from .times import tai_ns_of
from .tracker import Frame, Tracker, options_of_folder

_LEAST_DAYS = 4.0  # of a grid
_TREND = 4  # of stars that move without a reference orbit


class FrameWarning(RuntimeWarning):
    """Frames were not accepted: they are not in the periodogram."""


FrameWarning.__module__ = "toliman"


def track(scene: Simulator | Scene, frames: ArrayLike | typing.Iterable[Frame] | typing.Iterable[ArrayLike],
          times: typing.Any = None, *, folder: str | os.PathLike[str] | None = None, session: str = "session",
          first_id: int = 0, progress: Progress | bool | None = None) -> Tracker:
    """Measures the separation in each frame and adds it to the periodogram, exactly once.

        tracker = toliman.track("fitted.json", frames, times, folder="mission")
        print(tracker.fit())                                       # period, amplitude, false alarm probability
        found = toliman.planets(tracker)

    scene: the scene of the frames, with two stars, as `calibrate` saves it: a file, a dict, or a Simulator. Each frame
        also fits jitter, focus and other aberrations if it is calibrated. Its binary.observer reduces separations
        (Sky.of); its cadence gives the grid of a new folder.
    frames: Frames, as of a Pair; or images [frame][row][column], as an array, a list or an iterator, with times.
    times: middle of each exposure: days since time 0 of the scene (Simulator.series), datetime, datetime64, Time.
    folder: state folder, which a later call continues; None keeps everything in memory.
    session, first_id: of images: frame k has the id first_id + k of the session, by which it is recognised.

    Raises ValueError if the folder has frames with these ids and other times. Values of moving stars without a reference
    orbit are fitted with a trend of order 4.

    Returns the Tracker. Issues a FrameWarning if frames were not accepted. If the call raises, the folder is closed with
    the frames so far; without a folder, the exception's attribute `tracker` has them. Other estimators and options:
    Tracker.
    """
    simulator = simulator_of("scene", scene)
    given = _frames_of(frames, times, simulator.info.time_zero_ns, session, whole("first_id", first_id))
    count = len(frames) if isinstance(frames, typing.Sized) else 0
    try:
        tracker = _tracker_of(simulator, folder)
    except StateError as error:
        raise StateError(error.status, f"{error}; a Tracker of this program that has it open must be closed first",
                         error.field) from None
    try:
        if times is not None:
            tai_ns = numpy.atleast_1d(tai_ns_of("times", times, simulator.info.time_zero_ns))
            _check_ids(tracker, session, first_id, tai_ns)
        outcomes = tracker._push_all(given, count, progress)
        if folder is not None:
            tracker.save()
    except BaseException as error:
        if folder is None:
            error.tracker = tracker  # type: ignore[attr-defined]
        else:
            tracker.close()
        raise
    _warn_of(outcomes)
    return tracker


def _tracker_of(simulator: Simulator, folder: str | os.PathLike[str] | None) -> Tracker:
    info = simulator.info
    fit = Fit(simulator, free=[] if info.calibration == "none" else ["self"])
    try:
        sky: Sky | None = Sky.of(simulator)
    except UnsupportedError:  # the scene has no observer
        sky = None
    if folder is not None and os.path.exists(os.path.join(folder, "setup.tlms")):
        return Tracker(fit, folder=folder, sky=sky, bit_depth=options_of_folder(folder).frames.bit_depth)
    grid = grid_of_days(max(_LEAST_DAYS, _span_days(simulator)))
    has_trend = sky is None and "moving stars" in simulator.stages
    return Tracker(fit, *grid, folder=folder, sky=sky, time_offset_ns=info.time_zero_ns, exposure_s=info.exposure_s,
                   bit_depth=info.bit_depth, double_limb=True, trend=_TREND if has_trend else None,
                   span=(-1 / grid.df, 3 / grid.df) if has_trend else None)


def _check_ids(tracker: Tracker, session: str, first_id: int, tai_ns: NDArray[numpy.int64]) -> None:
    """Raises ValueError if the folder has these ids of the session with other times: both would be quarantined."""
    for stream in tracker.streams():
        if stream.session != session or stream.first_id >= first_id + tai_ns.size or stream.last_id < first_id:
            continue
        known = tracker.records()
        known = known[known["stream"] == stream.stream]
        known = known[(known["frame_id"] >= first_id) & (known["frame_id"] < first_id + tai_ns.size)]
        if (known["camera_ns"] != tai_ns[known["frame_id"] - first_id]).any():
            raise ValueError(f"first_id = {first_id}: the folder has frames of session {session!r} with these ids and other "
                             f"times: give {stream.last_id + 1}, the next one, or another session")


def _span_days(simulator: Simulator) -> float:
    """The length of the cadence, with one interval after the last frame."""
    times, _ = simulator.series()
    return float(numpy.ptp(times)) * len(times) / max(len(times) - 1, 1) if len(times) else 0.0


def _frames_of(frames: typing.Any, times: typing.Any, zero_ns: int, session: str,
               first_id: int) -> typing.Iterator[Frame]:
    """Returns an iterator of Frames; of those of images and times, unless times is None."""
    if times is None:
        if hasattr(frames, "dtype"):
            raise TypeError("times: must be given with images")
        return iter(frames)
    given = numpy.atleast_1d(tai_ns_of("times", times, zero_ns))
    if isinstance(frames, typing.Sized) and len(frames) != len(given):
        raise ValueError(f"times: are {len(given)}: must be {len(frames)}, one for each frame")
    return _with_times(iter(frames), given, session, first_id)


def _with_times(images: typing.Iterator[typing.Any], times: NDArray[numpy.int64], session: str,
                first_id: int) -> typing.Iterator[Frame]:
    number = -1
    for number, (time, image) in enumerate(zip(times, images)):
        if isinstance(image, Frame):
            raise TypeError("times: must not be given with Frames, which have their own")
        yield Frame(image, frame_id=first_id + number, camera_ns=int(time), session=session)
    if number + 1 < len(times) or next(images, None) is not None:
        raise ValueError(f"times: are {len(times)}: must be one for each frame")


def _warn_of(outcomes: list[Outcome]) -> None:
    """Warns at the line of the user's call of frames that were not accepted, with their reasons."""
    counts: dict[str, int] = {}
    for outcome in outcomes:
        if outcome.verdict not in ("accepted", "duplicate"):
            why = outcome.verdict if outcome.reason in ("", "none") else f"{outcome.verdict} ({outcome.reason})"
            counts[why] = counts.get(why, 0) + 1
    if counts:
        parts = ", ".join(f"{count} {why}" for why, count in counts.items())
        warnings.warn(f"{sum(counts.values())} of {len(outcomes)} frames were not accepted: {parts}", FrameWarning,
                      stacklevel=3)
