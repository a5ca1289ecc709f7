"""Simulator: scene -> frames; include/toliman/sim.h is the manual and states the conventions."""
from __future__ import annotations

import ctypes
import functools
import itertools
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
from ._arguments import Doubles, file_name, options_of, pointer, real, shaped, whole
from ._handle import Handle
from ._log import log
from ._progress import Progress, Watch
from ._results import Plan, SceneInfo
from ._words import number
from .machine import warn_of_slow_blas

Scene = typing.Union[str, "os.PathLike[str]", "dict[str, typing.Any]"]

_FRAMES_AT_A_TIME = 64  # between two looks at progress and Ctrl-C


class Spectrum(typing.NamedTuple):
    """Wavelengths (m) and the photons a frame of each star there, as used."""

    wavelength_m: Doubles
    weight_a: Doubles
    weight_b: Doubles


def shipped_scenes() -> list[pathlib.Path]:
    """The scenes that come with the library; a scene is found by its name alone where there is no such file."""
    shared = pathlib.Path("share", "toliman", "scenes")
    library_prefix = pathlib.Path(library_path()).resolve().parent.parent
    folders = [above(4) / shared, above(3) / "examples" / "scenes", library_prefix / shared, "/usr" / shared,
               "/usr/local" / shared]
    return next((sorted(folder.glob("*.json")) for folder in folders if folder.is_dir()), [])


def _path_of(scene: str | os.PathLike[str]) -> bytes:
    path = os.fsdecode(file_name(scene))
    if os.sep not in path and not os.path.exists(path):
        shipped = {known.name: known for known in shipped_scenes()}
        if path not in shipped:
            raise NotFoundError(_raw.TOLIMAN_E_NOT_FOUND,
                                f"{path}: No such file, and none of the shipped scenes: {', '.join(shipped)}", path)
        path = str(shipped[path])
    return os.fsencode(path)


def _json_of(value: typing.Any, place: str) -> typing.Any:
    """A part of a scene as JSON has it: numpy's numbers and arrays, and paths, are taken for what they are."""
    if getattr(value, "unit", None) is not None:
        raise TypeError(f"{place} is in {value.unit}: give plain numbers, in the unit of its name")
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
        raise ValueError(f"{place} = {value}: JSON holds whole numbers up to 2^53")
    if value is not None and not isinstance(value, (str, int, float, bool)):
        raise TypeError(f"{place} is a {type(value).__name__}, which a scene cannot have")
    return value


def _with_scene(scene: Scene, folder: str | os.PathLike[str] | None, of_path: typing.Any, of_text: typing.Any,
                *rest: typing.Any) -> int:
    """Calls the function for a path or the one for a text."""
    if isinstance(scene, dict):
        text = json.dumps(_json_of(scene, "scene")).encode()
        return of_text(text, len(text), None if folder is None else file_name(folder), *rest)
    if folder is not None:
        raise ValueError("folder is for a scene that is a dict: a file's names start at the file's own folder")
    return of_path(_path_of(scene), *rest)


def _options(watch: Watch, threads: int, engine: str | None) -> typing.Any:
    return options_of(_raw.toliman_sim_options, library.toliman_sim_options_init,
                      threads=whole("threads", threads, 2**32),
                      progress=watch.callback, log=log,
                      engine=0 if engine is None else number("engine", engine, "TOLIMAN_SIM_ENGINE"))


def _stage_names() -> typing.Iterator[bytes]:
    for stage in itertools.count():
        name = library.toliman_sim_stage_name(stage)
        if name is None:
            return
        yield name


def _has_stage(plan: typing.Any, name: bytes) -> bool:
    modelled = ctypes.c_int32()
    check(library.toliman_sim_get_stage(ctypes.byref(plan), name, ctypes.byref(modelled)))
    return modelled.value != 0


def _plan_of(struct: typing.Any) -> Plan:
    members = {name: getattr(struct, name) for name, *_ in struct._fields_}
    members["stages"] = [name.decode() for name in _stage_names() if _has_stage(struct, name)]
    return Plan._of(types.SimpleNamespace(**members))


def plan(scene: Scene, *, folder: str | os.PathLike[str] | None = None, engine: str | None = None) -> Plan:
    """What a scene needs at its accuracy, with the error and cost of each choice, without making its images."""
    found = _raw.toliman_sim_plan_info()
    with Watch(None) as watch:
        watch.check(_with_scene(scene, folder, library.toliman_sim_plan_file, library.toliman_sim_plan_json,
                                ctypes.byref(_options(watch, 0, engine)), ctypes.byref(found)))
    return _plan_of(found)


class Simulator(Handle):
    """A scene made ready: PSFs and derivative images computed once, then frames by random access.

        simulator = Simulator("chapter.json")
        image = simulator.frame(17)                # [row][column], float64

    scene: a file's path, the name of a shipped scene, or a dict of the schema toliman-scene/1, whose file names start
    at `folder` (the current one). threads: 0 is one a processor; they never change a bit. engine: None (the matrix DFT), matrix_dft or
    padded_fft. progress: True for a line on stderr or a bar in a notebook, or a function of stage and fraction, which
    stops the work by returning something true. Remarks go to Python's logging as "toliman". Calls from several threads
    may run together.
    """

    _kind, _end = _raw.toliman_sim, "toliman_sim_destroy"

    def __init__(self, scene: Scene, *, folder: str | os.PathLike[str] | None = None, threads: int = 0,
                 engine: str | None = None, progress: Progress | bool | None = None):
        warn_of_slow_blas()
        with Watch(progress) as watch:
            options = _options(watch, threads, engine)
            made = self._made(_with_scene, scene, folder, library.toliman_sim_create_file, library.toliman_sim_create_json,
                              ctypes.byref(options), keep=options, check=watch.check)
        super().__init__(made)

    @functools.cached_property
    def info(self) -> SceneInfo:
        """Facts of the scene, the Cramer-Rao bounds of a frame among them."""
        return self._read(library.toliman_sim_get_info, _raw.toliman_sim_info, SceneInfo)

    @property
    def name(self) -> str:
        """The scene's name."""
        return library.toliman_sim_get_name(self._c).decode()

    @property
    def plan(self) -> Plan:
        """What is computed, its errors and cost."""
        plan = _raw.toliman_sim_plan_info()
        check(library.toliman_sim_get_plan(self._c, ctypes.byref(plan)))
        return _plan_of(plan)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a frame."""
        return self.info.rows, self.info.cols

    @property
    def stages(self) -> list[str]:
        """Names of what is modelled: "photon noise", ..."""
        return list(self.plan.stages)

    def series(self, first: int = 0, count: int | None = None) -> tuple[Doubles, Doubles]:
        """Times (days) and true displacements (px) of frames first ... first + count - 1; by default all from first."""
        first, count = self._range(first, count)
        times, displacements = numpy.empty(count), numpy.empty(count)
        check(library.toliman_sim_get_series(self._c, first, count, pointer(times), pointer(displacements)))
        return times, displacements

    def image(self, kind: str = "both") -> Doubles:
        """Expected image or derivative, [row][column], in the frame's unit: both, star_a, star_b, separation (per px),
        curvature (per px^2), shift_x, shift_y, variance, roll (per rad), scale, focus (per nm rms), background."""
        return self._image(library.toliman_sim_get_image, number("kind", kind, "TOLIMAN_SIM_IMAGE"))

    def pupil(self) -> tuple[Doubles, Doubles]:
        """Amplitude (0 to 1) and OPD (m) of the pupil, each [N][N]."""
        shape = (self.info.pupil_samples,) * 2
        amplitude, opd_m = numpy.empty(shape), numpy.empty(shape)
        check(library.toliman_sim_get_pupil(self._c, pointer(amplitude), pointer(opd_m)))
        return amplitude, opd_m

    def spectrum(self) -> Spectrum:
        """Wavelengths (m) and photons a frame of A and B, whole star, before cropping."""
        arrays = [numpy.empty(self.info.wavelengths) for _ in Spectrum._fields]
        check(library.toliman_sim_get_spectrum(self._c, self.info.wavelengths, *map(pointer, arrays)))
        return Spectrum(*arrays)

    def plate_scale(self) -> Doubles:
        """Relative error of the plate scale at each wavelength: that of the padded FFT; 0 for the matrix DFT."""
        errors = numpy.empty(self.info.wavelengths)
        check(library.toliman_sim_get_plate_scale(self._c, len(errors), pointer(errors)))
        return errors

    def offsets(self) -> Doubles:
        """Places of A and B without displacement, px, [[Ax, Ay], [Bx, By]]; NaN for a star that is not there."""
        at = _raw.toliman_sim_offsets()
        check(library.toliman_sim_get_offsets(self._c, ctypes.byref(at)))
        return numpy.array([[at.a_x_px, at.a_y_px], [at.b_x_px, at.b_y_px]])

    def propagate(self, displacement: float) -> Doubles:
        """Expected image with the star displaced by so many px, each wavelength propagated anew: slow and exact."""
        return self._image(library.toliman_sim_propagate, real("displacement", displacement))

    def expect(self, displacement: float) -> Doubles:
        """Expected image by the series in the displacement (px), as frames use it."""
        return self._image(library.toliman_sim_expect, real("displacement", displacement))

    def frame(self, k: int, *, displacement: float | None = None, seed: int | None = None) -> Doubles:
        """Frame k, [row][column]: a function of (scene, displacement, seed, k) alone. Without a displacement (px) it
        has the scene's own, without a seed the scene's."""
        k = whole("k", k)
        moved = self.series(k, 1)[1][0] if displacement is None else real("displacement", displacement)
        return self._image(library.toliman_sim_frame, moved, self._seed(seed), k)

    def frames(self, first: int = 0, count: int | None = None, *, displacements: ArrayLike | None = None,
               seed: int | None = None, threads: int = 0, progress: Progress | bool | None = None) -> NDArray:
        """Frames first ... first + count - 1, [frame][row][column], all from first on by default; with displacements
        (px), one a frame, instead of the scene's signal."""
        if displacements is not None:
            displacements = shaped("displacements", displacements, (-1 if count is None else count,))
            count = len(displacements)
        first, count = self._range(first, count)
        images, seed = numpy.empty((count, *self.shape)), self._seed(seed)
        with Watch(progress) as watch:
            for start in range(0, count, _FRAMES_AT_A_TIME):
                part = images[start:start + _FRAMES_AT_A_TIME]
                moved = None if displacements is None else displacements[start:start + len(part)]
                watch.check(library.toliman_sim_frame_many(self._c, pointer(moved), seed, first + start, len(part),
                                                           whole("threads", threads, 2**32), pointer(part)))
                watch.step("frames", (start + len(part)) / count)
        return images

    def _range(self, first: int, count: int | None) -> tuple[int, int]:
        first = whole("first", first)
        return first, whole("count", max(self.info.frames - first, 0) if count is None else count)

    def _seed(self, seed: int | None) -> int:
        return self.info.seed if seed is None else whole("seed", seed, 2**64)

    def _image(self, function: typing.Any, *arguments: typing.Any) -> Doubles:
        image = numpy.empty(self.shape)
        check(function(self._c, *arguments, pointer(image), self.info.cols))
        return image

    def _told(self) -> str:
        return f"Simulator of {self.name!r}: {self.info.frames} frames of {self.info.rows}x{self.info.cols}"

    def _repr_html_(self) -> str:
        return self.info._repr_html_()
