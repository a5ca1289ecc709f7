"""Simulates frames of a scene. Reference, with the conventions for axes, signs and units: include/toliman/sim.h."""
from __future__ import annotations

import ctypes
import functools
import json
import math
import os
import pathlib
import types
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._library import NotFoundError, above, check, library, library_path
from ._arguments import Doubles, file_name, listed, of_kind, options_of, plain, pointer, real, shaped, text, whole
from ._handle import Handle
from ._log import log
from ._pixels import FRAMES_PER_CALL
from ._plots import Axes, plots
from ._progress import Progress, Watch
from ._results import Bounds, Parameter, Plan, SceneInfo
from ._shown import brief_repr, documented, members_html
from ._table import Column, Rows, Tabular
from ._words import number
from .budget import Budget, budget_of
from .machine import warn_of_slow_blas

Scene = typing.Union[str, "os.PathLike[str]", "dict[str, typing.Any]"]



@documented(times_days="days since time 0 of the scene", displacements_px="true displacements",
            frames="[frame][row][column], in the unit of the scene")
class Simulated(typing.NamedTuple):
    """Frames of simulate(), with their times and true displacements."""

    times_days: Doubles
    displacements_px: Doubles
    frames: Doubles

    def __repr__(self) -> str:
        return brief_repr(self)

    def _repr_html_(self) -> str:
        return members_html(self)


class _Spectrum(typing.NamedTuple):
    wavelength_m: Doubles
    weight_a: Doubles
    weight_b: Doubles


@documented(wavelength_m="wavelengths, m", weight_a="photons per frame of star A",
            weight_b="photons per frame of star B")
class Spectrum(_Spectrum, Tabular):
    """The sampled spectrum: wavelengths (m) and, for stars A and B, photons per frame at each wavelength."""

    def _columns(self) -> dict[str, Column]:
        return {"wavelength_m": Column(self.wavelength_m, "m"),
                "weight_a": Column(self.weight_a, "photon", "of star A in a frame, before cropping"),
                "weight_b": Column(self.weight_b, "photon", "of star B in a frame, before cropping")}

    def __repr__(self) -> str:
        return f"<Spectrum of {len(self.wavelength_m)} wavelengths>"


class _Series(typing.NamedTuple):
    times_days: Doubles
    displacements_px: Doubles


@documented(times_days="times, days since time 0 of the scene", displacements_px="true displacements, px")
class Series(_Series, Tabular):
    """Times (days) and true displacements (px) of frames."""

    def _columns(self) -> dict[str, Column]:
        return {"times_days": Column(self.times_days, "d", "since time 0 of the scene"),
                "displacements_px": Column(self.displacements_px, "pix", "true displacement")}

    def __repr__(self) -> str:
        return f"<Series of {len(self.times_days)} frames>"


def shipped_scenes() -> list[pathlib.Path]:
    """Returns the paths of the scenes shipped with the library. Simulator and plan() also accept their file names."""
    shared = pathlib.Path("share", "toliman", "scenes")
    library_prefix = pathlib.Path(library_path()).resolve().parent.parent
    folders = [above(0) / "scenes", above(4) / shared, above(2) / shared, library_prefix / shared, "/usr" / shared,
               "/usr/local" / shared]
    return next((sorted(folder.glob("*.json")) for folder in folders if folder.is_dir()), [])


def scene_path(scene: str | os.PathLike[str]) -> str:
    """Returns the path of a scene file or of a shipped scene of that name."""
    path = os.fsdecode(file_name(scene))
    if os.sep not in path and not os.path.exists(path):
        shipped = {known.name: known for known in shipped_scenes()}
        if path not in shipped:
            raise NotFoundError(_raw.TOLIMAN_E_NOT_FOUND,
                                f"{path}: No such file, nor a shipped scene ({', '.join(shipped)})", path)
        path = str(shipped[path])
    return path


def _json_of(value: typing.Any, place: str) -> typing.Any:
    """Converts a part of a scene to JSON types: numpy numbers and arrays, tuples and paths included. `place` is the key
    for error messages."""
    if getattr(value, "unit", None) is not None:
        raise TypeError(f"{place} is in {value.unit}: give plain numbers in the unit that the key names")
    if isinstance(value, (numpy.generic, numpy.ndarray)):
        value = value.tolist()
    if isinstance(value, dict):
        return {name: _json_of(member, f"{place}.{name}") for name, member in value.items()}
    if isinstance(value, (list, tuple)):
        return [_json_of(item, f"{place}[{number}]") for number, item in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{place} = {value}: must be finite")
    if isinstance(value, int) and abs(value) > 2**53:
        raise ValueError(f"{place} = {value}: must be in [-2^53, 2^53], the integers that JSON represents exactly")
    if value is not None and not isinstance(value, (str, int, float, bool)):
        raise TypeError(f"{place} is a {type(value).__name__}: must be a number, string, list, dict or None")
    return value


def _with_scene(scene: Scene, folder: str | os.PathLike[str] | None, of_path: typing.Any, of_text: typing.Any,
                *rest: typing.Any) -> int:
    """Calls the C function for a scene file, or the one for JSON text if the scene is a dict."""
    if isinstance(scene, dict):
        text = json.dumps(_json_of(scene, "scene")).encode()
        return of_text(text, len(text), None if folder is None else file_name(folder), *rest)
    if folder is not None:
        raise ValueError("folder: allowed only if the scene is a dict; names in a file are relative to its folder")
    return of_path(os.fsencode(scene_path(scene)), *rest)


def _options(watch: Watch, threads: int, engine: str | None,
             bad_pixels: str | os.PathLike[str] | None = None) -> typing.Any:
    return options_of(_raw.toliman_sim_options,
                      threads=whole("threads", threads, 2**32),
                      progress=watch.callback, log=log,
                      engine=0 if engine is None else number("engine", engine, "TOLIMAN_SIM_ENGINE"),
                      bad_pixels=None if bad_pixels is None else file_name(bad_pixels))


def _plan_of(struct: typing.Any) -> Plan:
    members = {name: getattr(struct, name) for name, *_ in struct._fields_}
    stages = listed(_raw.toliman_sim_stage, library.toliman_sim_get_stages, ctypes.byref(struct))
    members["stages"] = [stage.name.decode() for stage in stages if stage.modelled]
    return Plan._of(types.SimpleNamespace(**members))


def plan(scene: Scene, *, folder: str | os.PathLike[str] | None = None, engine: str | None = None) -> Plan:
    """Plans a simulation without computing its images.

    Returns the numerical choices that the scene's accuracy requires (wavelengths, expansion order, filter), the
    expected error of each, and the cost in time and memory. scene, folder, engine: as for Simulator.
    """
    found = _raw.toliman_sim_plan_info()
    with Watch(None) as watch:
        watch.check(_with_scene(scene, folder, library.toliman_sim_plan_file, library.toliman_sim_plan_json,
                                ctypes.byref(_options(watch, 0, engine)), ctypes.byref(found)))
    return _plan_of(found)


def parameters() -> Rows[Parameter]:
    """Returns the parameters of the forward model, whose names Simulator.derivative() takes. What a unit change of each
    does: include/toliman/sim_derivative.h."""
    return Rows(Parameter._of(one) for one in listed(_raw.toliman_sim_parameter, library.toliman_sim_get_parameters))


class Simulator(Handle):
    """Simulates the frames of a scene. PSFs and derivative images are computed once; frames by random access.

        simulator = Simulator("chapter.json")
        image = simulator.frame(17)                # [row][column], float64

    Parameters

    scene: path of a scene file, file name of a shipped scene, or a dict of the schema toliman-scene/1.
    folder: base of relative file names in a dict; the current folder by default.
    threads: number of worker threads; 0 means one per processor. The result does not depend on it.
    engine: "matrix_dft" (default), with exact pixel positions, or "padded_fft", as in the chapter.
    bad_pixels: path of a .npy file that replaces the scene's detector.bad_pixels.
    progress: True for a progress bar, or a function of (stage, fraction) that cancels by returning a true value.

    Frames and expected images are in photons; in electrons if the detector has qe or the stars detected_per_s; in DN if
    it has a gain, bias or bit depth (info.unit). Displacements are in px along the axis through both stars; positive ones
    increase the separation.
    Threads may use one simulator concurrently.

    Raises NotFoundError for a missing file, InputError for an invalid scene, UnsupportedError, Cancelled.
    """

    _kind, _destroy = _raw.toliman_sim, "toliman_sim_destroy"

    def __init__(self, scene: Scene, *, folder: str | os.PathLike[str] | None = None, threads: int = 0,
                 engine: str | None = None, bad_pixels: str | os.PathLike[str] | None = None,
                 progress: Progress | bool | None = None):
        warn_of_slow_blas()
        with Watch(progress) as watch:
            options = _options(watch, threads, engine, bad_pixels)
            created = self._create(_with_scene, scene, folder, library.toliman_sim_create_file,
                                     library.toliman_sim_create_json, ctypes.byref(options), keep=options,
                                     check=watch.check)
        super().__init__(created)

    @functools.cached_property
    def info(self) -> SceneInfo:
        """Properties of the scene."""
        return self._read(library.toliman_sim_get_info, _raw.toliman_sim_info, SceneInfo)

    @functools.cached_property
    def bounds(self) -> Bounds:
        """Cramer-Rao bounds of the separation per frame. Computes the derivatives."""
        return self._read(library.toliman_sim_get_bounds, _raw.toliman_sim_bounds, Bounds)

    def budget(self, free: typing.Sequence[str] | None = None, *, frames: int = 1, earth_px: float = 0) -> Budget:
        """Returns the error budget of the separation: which unknown parameters limit it, and by how much.

            budget = simulator.budget(["flux_a", "flux_b", "shift_x", "shift_y"])
            worst = min((row for row in budget.rows if not row.is_free), key=lambda row: row.tenth_crb_amount)

        free: names of the parameters that are fitted together with the separation; by default those of
        preprocess.project.
        frames: number of frames that share the parameters of the instrument.
        earth_px: displacement due to an Earth, px; 0 means that of the scene.
        """
        return budget_of(self._c, free, frames, earth_px)

    @property
    def name(self) -> str:
        """The scene's name."""
        return self.info.name

    @property
    def plan(self) -> Plan:
        """The numerical choices in use, their errors and their cost; see plan()."""
        plan = _raw.toliman_sim_plan_info()
        check(library.toliman_sim_get_plan(self._c, ctypes.byref(plan)))
        return _plan_of(plan)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a frame."""
        return self.info.rows, self.info.cols

    @property
    def stages(self) -> list[str]:
        """Names of the modelled stages: "photon noise", ..."""
        return list(self.plan.stages)

    def series(self, first: int = 0, count: int | None = None) -> Series:
        """Returns the times (days) and true displacements (px) of frames first ... first + count - 1, by default of all
        from `first`. Raises InputError outside the scene's cadence."""
        first, count = self._range(first, count)
        times, displacements = numpy.empty(count), numpy.empty(count)
        check(library.toliman_sim_get_series(self._c, first, count, pointer(times), pointer(displacements)))
        return Series(times, displacements)

    def image(self, kind: str = "both") -> Doubles:
        """Returns an expected image or derivative, [row][column], in the frame's unit.

        kind: "both" (the noiseless frame without displacement), "star_a", "star_b"; the derivatives "separation" (per
        px), "curvature" (second derivative, per px^2), "shift_x", "shift_y" (per px), "roll" (per rad), "scale"
        (relative), "focus" (per nm rms), "background" (per photon); or "variance" of the counts.
        """
        return self._image(library.toliman_sim_get_image, number("kind", kind, "TOLIMAN_SIM_IMAGE"))

    def derivative(self, name: str) -> Doubles:
        """Returns the derivative of the expected frame by a parameter, [row][column], in the frame's unit per unit of
        the parameter. name: one of parameters(), such as "zernike_7". Raises UnsupportedError if the scene has no such
        derivative."""
        return self._image(library.toliman_sim_get_derivative, text("name", name))

    def opd_gradient(self, weights: ArrayLike) -> Doubles:
        """Returns the gradient of (weights * image()).sum() by the optical path difference of the pupil, [N][N] per m.
        weights: [row][column]. For a mode of the OPD, (mode * gradient).sum() equals (weights * derivative).sum()."""
        given, gradient = shaped("weights", weights, self.shape), numpy.empty((self.info.pupil_samples,) * 2)
        check(library.toliman_sim_get_opd_gradient(self._c, pointer(given), self.info.cols, pointer(gradient)))
        return gradient

    def pupil(self) -> tuple[Doubles, Doubles]:
        """Returns the amplitude (0 to 1) and the optical path difference (m) of the pupil, each [N][N]."""
        shape = (self.info.pupil_samples,) * 2
        amplitude, opd_m = numpy.empty(shape), numpy.empty(shape)
        check(library.toliman_sim_get_pupil(self._c, pointer(amplitude), pointer(opd_m)))
        return amplitude, opd_m

    def spectrum(self) -> Spectrum:
        """Returns the sampled spectrum: wavelengths (m) and photons per frame of stars A and B, before cropping."""
        arrays = [numpy.empty(self.info.wavelengths) for _ in Spectrum._fields]
        check(library.toliman_sim_get_spectrum(self._c, self.info.wavelengths, *map(pointer, arrays), None))
        return Spectrum(*arrays)

    def plate_scale(self) -> Doubles:
        """Returns the relative error of the plate scale at each wavelength: nonzero for engine "padded_fft" only."""
        errors = numpy.empty(self.info.wavelengths)
        check(library.toliman_sim_get_spectrum(self._c, len(errors), None, None, None, pointer(errors)))
        return errors

    def offsets(self) -> Doubles:
        """Returns the undisplaced positions of the stars, [[Ax, Ay], [Bx, By]], in px from the frame's centre: x
        towards higher columns, y towards higher rows. NaN for a star that the scene does not have."""
        offsets = _raw.toliman_sim_offsets()
        check(library.toliman_sim_get_offsets(self._c, ctypes.byref(offsets)))
        return numpy.array([[offsets.a_x_px, offsets.a_y_px], [offsets.b_x_px, offsets.b_y_px]])

    def propagate(self, displacement: float) -> Doubles:
        """Returns the expected image at a displacement (|displacement| <= 100 px) by propagating every wavelength
        again: slow, exact. Raises InputError outside the range."""
        return self._image(library.toliman_sim_propagate, real("displacement", displacement))

    def expect(self, displacement: float) -> Doubles:
        """Returns the expected image at a displacement (|displacement| <= 0.1 px) by the Taylor expansion that frames
        use. Raises InputError outside the range."""
        return self._image(library.toliman_sim_expect, real("displacement", displacement))

    def frame(self, k: int, *, displacement: float | None = None, seed: int | None = None) -> Doubles:
        """Simulates frame k, [row][column], with noise.

        displacement: in px; None takes the scene's signal at the time of frame k. seed: None takes the scene's. A frame
        depends on (scene, displacement, seed, k) only, not on the order of calls or on threads.
        """
        moved = None if displacement is None else numpy.array([real("displacement", displacement)])
        image = numpy.empty(self.shape)
        check(library.toliman_sim_frame(self._c, pointer(moved), self._seed(seed), whole("k", k), 1, pointer(image)))
        return image

    def frames(self, first: int = 0, count: int | None = None, *, displacements: ArrayLike | None = None,
               seed: int | None = None, progress: Progress | bool | None = None) -> NDArray:
        """Simulates frames first ... first + count - 1, [frame][row][column]; by default all from `first`.

        displacements: one value (px) per frame instead of the scene's signal. seed, progress: as above. Raises
        InputError outside the scene's cadence unless displacements are given.
        """
        if displacements is not None:
            displacements = shaped("displacements", displacements, (-1 if count is None else count,))
            count = len(displacements)
        first, count = self._range(first, count)
        images, seed = numpy.empty((count, *self.shape)), self._seed(seed)
        with Watch(progress) as watch:
            for start in range(0, count, FRAMES_PER_CALL):
                part = images[start:start + FRAMES_PER_CALL]
                moved = None if displacements is None else displacements[start:start + len(part)]
                watch.check(library.toliman_sim_frame(self._c, pointer(moved), seed, first + start, len(part), pointer(part)))
                watch.step("frames", (start + len(part)) / count)
        return images

    def expose(self, expected: ArrayLike, first: int = 0, *, seed: int | None = None) -> Doubles:
        """Adds noise and detector to expected images, [frame][row][column] or [row][column], as to frames first,
        first + 1, ...; Fit.predict() gives such images of moved stars. seed: as above."""
        one = numpy.ndim(expected) == 2
        images_given = plain("expected", expected)
        given = shaped("expected", images_given[None] if one else images_given, (-1, *self.shape))
        images = numpy.empty(given.shape)
        check(library.toliman_sim_expose(self._c, pointer(given), self._seed(seed), whole("first", first), len(given),
                                         pointer(images)))
        return images[0] if one else images

    def plot_frame(self, k: int = 0, ax: Axes | None = None) -> Axes:
        """Draws frame k in logarithmic colours, down to 1e-5 of its brightest pixel. The axes are in px from the
        centre.

        ax: Axes to draw into, in their style; None: a new figure of pyplot."""
        return plots().frame(self, k, ax)

    def plot_pupil(self, ax: Axes | None = None) -> Axes:
        """Draws the optical path difference of the pupil in nm, grey where no light passes. ax: as for plot_frame()."""
        return plots().pupil(self, ax)

    def _range(self, first: int, count: int | None) -> tuple[int, int]:
        first = whole("first", first)
        return first, whole("count", max(self.info.frames - first, 0) if count is None else count)

    def _seed(self, seed: int | None) -> int:
        return self.info.seed if seed is None else whole("seed", seed, 2**64)

    def _image(self, function: typing.Any, *arguments: typing.Any) -> Doubles:
        image = numpy.empty(self.shape)
        check(function(self._c, *arguments, pointer(image), self.info.cols))
        return image

    def _summary(self) -> str:
        return f"Simulator of {self.name!r}: {self.info.frames} frames of {self.info.rows}x{self.info.cols}"

def simulator_of(name: str, scene: Simulator | Scene) -> Simulator:
    """Returns the argument `name`, a Simulator, or makes that of a scene."""
    return of_kind(name, Simulator(scene) if isinstance(scene, (str, bytes, os.PathLike, dict)) else scene, Simulator)


def simulate(scene: Simulator | Scene, first: int = 0, count: int | None = None, *, seed: int | None = None,
             progress: Progress | bool | None = None) -> Simulated:
    """Simulates frames of a scene: those of its cadence from `first`, or `count` of them.

        times, displacements, frames = toliman.simulate("sky.json", count=20)

    scene: a file, the name of a shipped scene, a dict, or a Simulator, which is quicker for several calls. seed: of the
    noise; None takes the scene's. Returns times (days), true displacements (px) and frames [frame][row][column].
    """
    simulator = simulator_of("scene", scene)
    frames = simulator.frames(first, count, seed=seed, progress=progress)
    return Simulated(*simulator.series(first, len(frames)), frames)
