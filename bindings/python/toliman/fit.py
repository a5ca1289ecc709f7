"""Maximum-likelihood fit of the forward model to each frame. Reference: include/toliman/fit.h."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._arguments import Doubles, array_of, listed, of_kind, options_of, pointer, real, shaped, text, whole
from ._goodness import warn_of
from ._handle import Handle
from ._library import check, library
from ._pixels import Frames, frame_of
from ._predictions import Predictions, joined, prediction_of, structured
from ._progress import Progress, Watch
from ._results import FitInfo, FitResult, Parameter
from ._spread import Spread
from ._table import Records, Rows
from .sim import Scene, Simulator, simulator_of
from .times import days_of

class Fit(Handle):
    """Fits the forward model of a scene to frames; it follows the stars wherever orbit, pointing and roll move them.

        fit = Fit(simulator, free=["scale"])
        result, values, covariance = fit.frame(frame, time_days=12.5)
        results = fit.frames(frames, times_days=times)             # structured array, results["displacement_px"]

    simulator: the scene, with two stars, as a Simulator, a file or a dict; not needed afterwards.
    free: names of further free parameters, such as ["scale", "focus"]. Separation, position_angle, shift_x, shift_y,
        flux_a, flux_b and background are always free.
    capture_px: largest shift of both stars from their predicted places, along x and y; 0 means 15.
    threads: number of worker threads; 0 means one per processor.
    progress: of the preparation of the model images.

    A frame is predicted by its time, in days since time 0 of the scene, or a date: a moving binary is at its place on the
    scene's orbit. Further knowledge of a frame:
    shift (x, y) of both stars in px, and the separation in px with its position angle in degrees, both 0 for those of
    the scene.

    Raises InputError for parameters that are unknown or always free, UnsupportedError for a single star; Cancelled.
    """

    _kind, _destroy = _raw.toliman_fit, "toliman_fit_destroy"

    def __init__(self, simulator: Simulator | Scene, *, free: typing.Iterable[str] = (), capture_px: float = 0, threads: int = 0,
                 progress: Progress | bool | None = None):
        simulator = simulator_of("simulator", simulator)
        super().__init__(self._of_scenes([simulator], None, free, capture_px, threads, progress))
        self._know(simulator)

    def _know(self, simulator: Simulator) -> None:
        self.shape, self._zero_ns = simulator.shape, simulator.info.time_zero_ns
        self._moves = "moving stars" in simulator.stages

    def _days(self, name: str, times: typing.Any, separations: ArrayLike) -> typing.Any:
        """Returns times of frames in days since time 0 of the scene; None: 0, of stars that do not move, or whose
        separations are given."""
        if times is None and self._moves and not numpy.all(numpy.asarray(separations)):
            raise ValueError(f"{name}: must be given, as the stars of the scene move")
        return 0.0 if times is None else days_of(name, times, self._zero_ns)

    @classmethod
    def of_windows(cls, simulators: typing.Sequence[Simulator], first_days: ArrayLike, *, free: typing.Iterable[str] = (),
                   capture_px: float = 0, threads: int = 0, progress: Progress | bool | None = None) -> Fit:
        """Returns a fit whose optics change with time, such as those of a calibration with windows: at first_days[i] the
        model is that of simulators[i], and in between it is linear in time. Arguments otherwise as those of Fit."""
        sims = list(simulators)
        for simulator in sims:
            of_kind("simulators", simulator, Simulator)
        starts = shaped("first_days", first_days, (len(sims),))
        made = cls._adopt(cls._of_scenes(sims, starts, free, capture_px, threads, progress))
        made._know(sims[0])
        return made

    @classmethod
    def _of_scenes(cls, sims: list[Simulator], starts: Doubles | None, free: typing.Iterable[str], capture_px: float,
                   threads: int, progress: Progress | bool | None) -> typing.Any:
        names = [free] if isinstance(free, str) else list(free)
        with Watch(progress) as watch:
            options = options_of(_raw.toliman_fit_options, free=text("free", " ".join(names)),
                                 capture_px=real("capture_px", capture_px), threads=whole("threads", threads, 2**32),
                                 progress=watch.callback)
            handles = (ctypes.POINTER(_raw.toliman_sim) * len(sims))(*(simulator._c for simulator in sims))
            return cls._create(library.toliman_fit_create, handles, pointer(starts), len(sims), ctypes.byref(options),
                               check=watch.check)

    @property
    def info(self) -> FitInfo:
        """Properties of the fit and of its model images."""
        return self._read(library.toliman_fit_get_info, _raw.toliman_fit_info, FitInfo)

    @property
    def parameters(self) -> Rows[Parameter]:
        """The parameters of a frame, in the order of values and covariances."""
        return Rows(Parameter._of(one) for one in listed(_raw.toliman_sim_parameter, library.toliman_fit_get_parameters,
                                                         self._c))

    def frame(self, frame: ArrayLike, *, time_days: typing.Any = None, shift: tuple[float, float] = (0, 0),
              separation: float = 0, position_angle: float = 0, spread: Spread | None = None,
              window: ArrayLike | None = None) -> tuple[FitResult, Doubles, Doubles]:
        """Fits one frame [row][column], or with spread a sum of frames. Returns the result, the values of the parameters [n], and their covariance
        [n][n]. The numbers of a frame that did not converge are NaN. Issues a FitWarning if the goodness is "poor" or
        "too good"."""
        image, _ = frame_of("frame", frame, self.shape, window)
        result, (values, covariance) = _raw.toliman_fit_result(), self._numbers()
        prediction = prediction_of(self._days("time_days", time_days, separation), shift, separation, position_angle, spread)
        check(library.toliman_fit_frame(self._c, ctypes.byref(image), 1, ctypes.byref(prediction), ctypes.byref(result),
                                        pointer(values), pointer(covariance)))
        warn_of(structured((_raw.toliman_fit_result * 1)(result)), stacklevel=3)
        return FitResult._of(result), values, covariance

    def frames(self, frames: ArrayLike, *, times_days: typing.Any = None, shifts: ArrayLike = (0, 0),
               separations: ArrayLike = 0, position_angles: ArrayLike = 0, spreads: typing.Sequence[Spread] | None = None,
               windows: ArrayLike | None = None, progress: Progress | bool | None = None) -> Records:
        """Fits frames [frame][row][column] of any pixel type, with windows as in CAE.encode. The predictions are one number
        (shifts: one pair) for all frames, or one per frame; spreads: one per frame where frames are sums. Returns a
        structured array with a field for each member of toliman_fit_result; `flags`
        are the bits TOLIMAN_FIT_..., `goodness` a number TOLIMAN_GOODNESS_... Issues a FitWarning as frame()."""
        given = self._days("times_days", times_days, separations), shifts, separations, position_angles, spreads
        source = Frames(frames, self.shape, *Predictions.lengths(*given), windows=windows)
        predictions, blocks = Predictions(source.count, *given), []
        with Watch(progress) as watch:
            for first, image, count in source.images(watch):
                results = array_of(_raw.toliman_fit_result, count)
                watch.check(library.toliman_fit_frame(self._c, image, count, predictions.block(first, count), results, None,
                                                      None))
                blocks.append((results, count))
                watch.step("fit", source.share(first + count))
        found = joined(blocks, _raw.toliman_fit_result)
        warn_of(found, stacklevel=3)
        return found

    def predict(self, *, time_days: float = 0, shift: tuple[float, float] = (0, 0), separation: float = 0,
                position_angle: float = 0, spread: Spread | None = None) -> tuple[Doubles, Doubles, Doubles]:
        """Returns the expected frame [row][column], or with spread the expected sum, the values of the parameters [n], and the covariance [n][n] of their
        fit, the Cramer-Rao bound."""
        image, (values, covariance) = numpy.empty(self.shape), self._numbers()
        prediction = prediction_of(time_days, shift, separation, position_angle, spread)
        check(library.toliman_fit_predict(self._c, ctypes.byref(prediction), pointer(image), self.shape[1],
                                          pointer(values), pointer(covariance)))
        return image, values, covariance

    def _numbers(self) -> tuple[Doubles, Doubles]:
        n = self.info.parameters
        return numpy.empty(n), numpy.empty((n, n))

    def _summary(self) -> str:
        names = ", ".join(parameter.name for parameter in self.parameters[7:])
        return f"Fit of {self.shape[0]}x{self.shape[1]} frames" + (f", free: {names}" if names else "")
