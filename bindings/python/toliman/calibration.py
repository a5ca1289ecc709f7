"""Calibration of the telescope with frames of the binary itself. Reference: include/toliman/calibrate.h."""
from __future__ import annotations

import ctypes
import os
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._arguments import Doubles, array_of, file_name, of_kind, options_of, pointer, real, text, whole
from ._handle import Handle
from ._library import check, library
from ._pixels import Frames, image_of
from ._plots import Axes, Figure, plots
from ._predictions import predictions_of, structured
from ._progress import Progress, Watch
from ._results import CalibrationAttempt, CalibrationInfo, CalibrationStep, CalibrationValue, CalibrationWindow
from ._spread import Spread
from ._table import Column, Records, Rows, Tabular
from .sim import Scene, Simulator, simulator_of

# Called after each iteration with the state so far, which is closed afterwards, and the iteration. A true value cancels.
Step = typing.Callable[["Calibration", CalibrationStep], typing.Any]


class Calibration(Handle, Tabular):
    """Result of calibrate(): parameters of the telescope, and the places of the stars in each frame.

        print(calibration.verdict)
        print(calibration.values()["zernike_7"].value, calibration.values()["zernike_7"].sigma)
        calibration.save("fitted.json")                            # the scene for all further estimates

    window: number of a window, whose parameters are those at its start; 0 if there is only one. The numbers of a
    calibration that did not converge are NaN.
    """

    _kind, _destroy = _raw.toliman_calibration, "toliman_calibration_destroy"

    @property
    def info(self) -> CalibrationInfo:
        """Summary of the calibration."""
        return self._read(library.toliman_calibration_get_info, _raw.toliman_calibration_info, CalibrationInfo)

    @property
    def chi_square(self) -> float:
        """Sum of squared residuals over their variances, per degree of freedom."""
        return self.info.chi_square

    @property
    def flags(self) -> tuple[str, ...]:
        """Names of the flags set in info: "not_converged", "incomplete", "held", "no_sign", "too_good"; () if none."""
        info, names = self.info, ("not_converged", "incomplete", "held", "no_sign", "too_good")
        return tuple(name for name in names if getattr(info, name))

    @property
    def goodness(self) -> str:
        """The verdict on chi_square: "good", "poor", "too good"; "unknown" without convergence."""
        return self.info.goodness

    @property
    def lacks(self) -> tuple[str, ...]:
        """What an incomplete model may lack: "mask edges", "pupil samples", "spectral modes", "windows", "map"; () otherwise."""
        return _names_of(self.info.lacks)

    @property
    def changes(self) -> tuple[str, ...]:
        """The changes of the model that improve=True kept, with the names of `lacks`."""
        return _names_of(self.info.changes)

    @property
    def attempts(self) -> list[tuple[str, CalibrationAttempt]]:
        """The changes that improve=True tried: name and result of each."""
        found = []
        for index in range(self.info.attempts):
            attempt = _raw.toliman_calibration_attempt()
            check(library.toliman_calibration_get_attempt(self._c, index, ctypes.byref(attempt)))
            found.append((_names_of(attempt.change)[0], CalibrationAttempt._of(attempt)))
        return found

    @property
    def left_out(self) -> dict[str, str]:
        """The default parameters that were not fitted, as the scene does not have them, with the reason."""
        found = {}
        for index in range(self.info.left_out):
            one = _raw.toliman_calibration_left_out()
            check(library.toliman_calibration_get_left_out(self._c, index, ctypes.byref(one)))
            found[one.name.decode()] = one.reason.decode()
        return found

    @property
    def verdict(self) -> str:
        """A sentence: whether the calibration converged, whether the model describes the frames, what it may lack, and
        which parameters the frames do not determine."""
        return "; ".join([_state_of(self.info), *self._undetermined()])

    @property
    def windows(self) -> Rows[CalibrationWindow]:
        """The windows: first day, number of frames, goodness of fit."""
        found: Rows[CalibrationWindow] = Rows()
        for number in range(self.info.windows):
            window = _raw.toliman_calibration_window()
            check(library.toliman_calibration_get_window(self._c, number, ctypes.byref(window)))
            found.append(CalibrationWindow._of(window))
        return found

    @property
    def frames(self) -> Records:
        """The parameters of each frame as a structured array with the fields of Fit.frames(); the standard deviations
        include the uncertainty of the instrument."""
        count = self.info.frames
        results = array_of(_raw.toliman_fit_result, count)
        for index in range(count):
            results[index].struct_size = ctypes.sizeof(_raw.toliman_fit_result)
            check(library.toliman_calibration_get_frame(self._c, index, ctypes.byref(results[index])))
        return structured(results)[:count]

    @property
    def chi_map(self) -> Doubles:
        """The mean over all frames of the squared residual over its variance [row][column]."""
        return self._image(_raw.TOLIMAN_CALIBRATION_IMAGE_CHI)

    @property
    def response(self) -> Doubles:
        """The response of each pixel [row][column]: detector.response of the fitted scene."""
        return self._image(_raw.TOLIMAN_CALIBRATION_IMAGE_RESPONSE)

    @property
    def response_sigma(self) -> Doubles:
        """The standard deviation of the response [row][column], all other parameters free."""
        return self._image(_raw.TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA)

    def values(self, window: int = 0) -> dict[str, CalibrationValue]:
        """Returns the parameters of the instrument by name, with value, sigma and prior_sigma. Values are changes
        against the nominal scene."""
        found, window = {}, whole("window", window)
        for index in range(self.info.parameters):
            value = _raw.toliman_calibration_value()
            check(library.toliman_calibration_get_value(self._c, window, index, ctypes.byref(value)))
            found[value.name.decode()] = CalibrationValue._of(value)
        return found

    def _columns(self) -> dict[str, Column]:
        """Returns the parameters of all windows, one per row."""
        windows = [(window, self.values(number)) for number, window in enumerate(self.windows)]
        rows = Rows(value for _, values in windows for value in values.values())
        counts = [len(values) for _, values in windows]
        numbers = numpy.repeat(numpy.arange(len(windows)), counts)
        firsts = numpy.repeat([window.first_days for window, _ in windows], counts)
        return {"window": Column(numbers), "first_days": Column(firsts, "d", "start of the window"), **rows._columns()}

    def _facts(self) -> dict[str, typing.Any]:
        info = self.info
        return {"frames": info.frames, "chi2": info.chi_square, "chi2_err": info.chi_square_sigma,
                "goodness": info.goodness, "flags": " ".join(self.flags)}

    def covariance(self, window: int = 0) -> Doubles:
        """Returns the covariance of the parameters [n][n], in the order of values(), with those of the frames free."""
        n = self.info.parameters
        matrix = numpy.empty((n, n))
        check(library.toliman_calibration_get_covariance(self._c, whole("window", window), pointer(matrix)))
        return matrix

    def opd(self, window: int = 0) -> Doubles:
        """Returns the change of the OPD against the nominal scene at each pupil cell, m, parameters and map together."""
        n = self.info.cells
        opd = numpy.empty((n, n))
        check(library.toliman_calibration_get_opd(self._c, whole("window", window), pointer(opd)))
        return opd

    def residual(self, fitted: bool = True) -> Doubles:
        """Returns the residual of the first frame over its standard deviation [row][column]. fitted: with the fitted
        instrument; False: with the one from which the calibration started."""
        return self._image(_raw.TOLIMAN_CALIBRATION_IMAGE_AFTER if fitted else _raw.TOLIMAN_CALIBRATION_IMAGE_BEFORE)

    def plot(self, ax: Axes | None = None, *, unit: str | None = None, window: int = 0) -> Axes:
        """Draws the parameters of one unit with their standard deviations.

        unit: such as "nm", or "" for relative ones; None: the unit of most parameters. ax: Axes to draw into, in their
        style; None: a new figure of pyplot. Raises ValueError for a unit that no parameter has and, like the other
        plots, if the calibration did not converge."""
        return plots().calibration(self, ax, unit, window)

    def plot_opd(self, ax: Axes | None = None, *, window: int = 0) -> Axes:
        """Draws opd(), in nm. ax: as for plot()."""
        return plots().calibration_opd(self, ax, window)

    def plot_residual(self) -> Figure:
        """Draws residual() of the nominal and of the fitted instrument side by side, and returns their figure."""
        return plots().calibration_residual(self)

    def plot_correlations(self, ax: Axes | None = None, *, window: int = 0) -> Axes:
        """Draws the correlations of the parameters. ax: as for plot()."""
        return plots().calibration_correlations(self, ax, window)

    def _image(self, kind: int) -> Doubles:
        info = self.info
        image = numpy.empty((info.rows, info.cols))
        check(library.toliman_calibration_get_image(self._c, kind, pointer(image), info.cols))
        return image

    def save(self, path: str | os.PathLike[str], window: int = 0) -> None:
        """Writes the fitted scene to a file, whose name ends in ".json", and its map and response next to it,
        atomically."""
        check(library.toliman_calibration_save_file(self._c, whole("window", window), file_name(path)))

    def _undetermined(self) -> typing.Iterator[str]:
        """Yields a clause for what the frames do not determine."""
        info = self.info
        if info.lacks:
            yield f"may be missing: {', '.join(self.lacks)}"
        if info.changes:
            yield f"added to the model: {', '.join(self.changes)}"
        if info.left_out:
            yield f"not fitted: {', '.join(self.left_out)}"
        names = dict.fromkeys(name for window in range(info.windows) for name, value in self.values(window).items()
                              if value.held)
        if names:
            yield f"held by {'its prior' if len(names) == 1 else 'their priors'}: {', '.join(names)}"
        if info.no_sign:
            yield "sign of even aberrations undetermined"

    def _summary(self) -> str:
        info = self.info
        return f"Calibration of {info.parameters} parameters with {info.frames} frames: {self.verdict}"


class _SoFar(Calibration):
    """The state of a running calibration, which the library destroys."""

    _destroy = ""


def calibrate(simulator: Simulator | Scene, frames: ArrayLike | typing.Iterable[ArrayLike], *, times_days: ArrayLike | None = None,
              shifts: ArrayLike = (0, 0), separations: ArrayLike = 0, position_angles: ArrayLike = 0,
              spreads: typing.Sequence[Spread] | None = None,
              free: str | typing.Iterable[str] | None = None, map: bool = False, improve: bool = False, detector: bool = False,
              start: Simulator | None = None,
              most_iterations: int = 0, capture_px: float = 0, window_days: float = 0, smoothness: float = 0,
              map_rms_nm: float = 0, response_rms: float = 0, threads: int = 0, step: Step | None = None,
              journal: str | os.PathLike[str] | None = None, progress: Progress | bool | None = None) -> Calibration:
    """Determines parameters of the telescope from frames of the binary, by maximum likelihood.

        calibration = toliman.calibrate("sky.json", frames, times_days=times)

    Parameters

    simulator: the nominal scene, with two stars, as a Simulator, a file or a dict; not needed afterwards.
    frames: at least two [frame][row][column], as those of Fit.frames().
    times_days, shifts, separations, position_angles, spreads: predictions, as for Fit.frames(). times_days None: the times of the
        scene's first frames.
    free: parameters to fit, such as ["scale=1e-3", "focus", "zernike_5-21=50"] with the standard deviations of their
        priors; None: those that the scene has of focus, zernike_5-21, scale, mask_rotation, jitter and temperatures.
    map: fit also the OPD of each pupil cell, which takes minutes.
    improve: while the model is incomplete, calibrate again with mask.edges = "area", twice the pupil samples, spectral
        modes and the map, in this order, and keep what lowers chi-square: see attempts. Takes minutes.
    detector: fit also the readout and the response of each pixel, from hundreds of frames in which the stars move by pixels.
    start: Simulator of the scene to start from, such as that of a saved Calibration; None: the nominal scene.
    most_iterations: of the parameters, of the map, of the response; 0 means 30.
    capture_px: largest shift of the stars from their predicted places; 0 means 6.
    window_days: length of the windows: parameters change linearly from start to start; 0: they are constant.
    smoothness: change of each parameter from one start to the next, in standard deviations of its prior; 0 means 0.01.
    map_rms_nm: prior of the map, rms over the open pupil; 0 means 10.
    response_rms: prior of the relative response, rms; 0 means 0.01.
    step: function of (Calibration, CalibrationStep), called after each iteration; a true return value cancels. The
        Calibration may be saved during the call.
    progress: as for Simulator; its stages are the parts of each iteration.
    journal: file to which the results of each iteration are appended. If it exists, the call continues from it, and
        gives the bits of a call that was not interrupted. Remove it once the result is saved.

    A calibration that does not converge is not an error: see Calibration.verdict. Raises InputError, UnsupportedError
    for a single star or parameters that the scene does not have, Cancelled. Ctrl-C cancels within seconds.
    """
    simulator = simulator_of("simulator", simulator)
    images = Frames(frames, simulator.shape).whole()
    count = len(images)
    if times_days is None:
        times_days = simulator.series(0, count)[0] if count else 0
    predictions = predictions_of(count, times_days, shifts, separations, position_angles, spreads)
    image, images = image_of(images)
    with Watch(progress) as watch:
        steps = _Iterations(watch, step)
        options = options_of(
            _raw.toliman_calibration_options,
            flags=((_raw.TOLIMAN_CALIBRATION_MAP if map else 0) | (_raw.TOLIMAN_CALIBRATION_IMPROVE if improve else 0)
                   | (_raw.TOLIMAN_CALIBRATION_DETECTOR if detector else 0)), free=_names(free),
            most_iterations=whole("most_iterations", most_iterations, 2**31), threads=whole("threads", threads, 2**32),
            capture_px=real("capture_px", capture_px), window_days=real("window_days", window_days),
            smoothness=real("smoothness", smoothness), map_rms_nm=real("map_rms_nm", map_rms_nm),
            response_rms=real("response_rms", response_rms),
            journal=None if journal is None else file_name(journal),
            step=_raw.toliman_calibration_step_fn(lambda *arguments: watch.run(steps.on_step, *arguments)),
            progress=_raw.toliman_progress_fn(lambda *arguments: watch.run(steps.on_part, *arguments)))
        if start is not None:
            options.start = of_kind("start", start, Simulator)._c
        return Calibration._adopt(Calibration._create(
            library.toliman_calibration_create, simulator._c, ctypes.byref(image), count, ctypes.byref(predictions[0]),
            ctypes.byref(options), check=watch.check))


class _Iterations:
    """Calls the user's functions after each iteration, and between its parts."""

    def __init__(self, watch: Watch, step: Step | None):
        self._watch, self._step, self._last = watch, step, "begins"

    def on_step(self, so_far: typing.Any, given: typing.Any, _: object) -> int:
        """1 to cancel, also after Ctrl-C."""
        found = CalibrationStep._of(given.contents)
        what = "map: " if found.is_map else "response: " if found.is_response else ""
        self._last = f"{what}iteration {found.iteration}, chi-square {found.chi_square:.6g}"
        if self._watch.interrupted or self._watch.show(self._last, 1):
            return 1
        if self._step is None:
            return 0
        with _SoFar._adopt(so_far) as calibration:
            return int(bool(self._step(calibration, found)))

    def on_part(self, stage: bytes, fraction: float, _: object) -> int:
        """The stage of the progress names the last iteration."""
        return int(self._watch.interrupted or self._watch.show(f"{self._last}; {stage.decode()}", min(fraction, 0.99)))


def _names(free: str | typing.Iterable[str] | None) -> bytes | None:
    return None if free is None else text("free", free if isinstance(free, str) else " ".join(free))


def _names_of(changes: int) -> tuple[str, ...]:
    """Returns the names of changes of a model."""
    bits = (1 << k for k in range(changes.bit_length()))
    return tuple(library.toliman_constant_name(bit).decode() for bit in bits if changes & bit)


def _state_of(info: CalibrationInfo) -> str:
    """Returns the first clause of a verdict."""
    if info.not_converged:
        return "not converged: no maximum of the likelihood was found"
    sigmas = (info.chi_square - 1) / info.chi_square_sigma
    chi_square = (f"chi-square {info.chi_square:.6g} is {abs(sigmas):.3g} standard deviations "
                  f"{'below' if sigmas < 0 else 'above'} 1")
    if info.incomplete and (info.goodness == "poor" or info.structure <= info.structure_limit):
        return f"model incomplete: {chi_square}"
    if info.incomplete:
        return (f"model incomplete: residuals are correlated, structure {info.structure:.3g}, limit "
                f"{info.structure_limit:.3g}")
    if info.too_good:
        return f"too good: {chi_square}"
    return f"converged: chi-square {info.chi_square:.6g} +- {info.chi_square_sigma:.2g}"
