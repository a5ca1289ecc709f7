"""Linear estimators: the template, which reaches the Cramer-Rao bound, and components; include/toliman/linear.h."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._library import check, library
from ._arguments import Doubles, of_kind, options_of, pointer, real, whole
from ._encode import Values, encode
from ._handle import Handle
from ._pixels import frames_of, image_of
from ._progress import Progress, Watch
from ._results import ComponentsInfo, ComponentsTraining
from ._words import number
from .sim import Simulator


class Template(Handle):
    """Weighted least-squares estimate of the separation: the reference for the network.

        template = Template(simulator)
        value = template.encode(frame)             # px; its standard deviation is template.sigma
    """

    _kind, _end = _raw.toliman_linear, "toliman_linear_destroy"

    def __init__(self, simulator: Simulator):
        of_kind("simulator", simulator, Simulator)
        super().__init__(self._made(library.toliman_linear_create, simulator._c, None))
        self.shape = simulator.shape

    @typing.overload
    def encode(self, frames: ArrayLike, *, chi_square: typing.Literal[False] = False, threads: int = 0,
               progress: Progress | bool | None = None) -> Values: ...

    @typing.overload
    def encode(self, frames: ArrayLike, *, chi_square: typing.Literal[True], threads: int = 0,
               progress: Progress | bool | None = None) -> tuple[Values, Values]: ...

    def encode(self, frames: ArrayLike, *, chi_square: bool = False, threads: int = 0,
               progress: Progress | bool | None = None) -> Values | tuple[Values, Values]:
        """Displacement (px) of a frame [row][column], a float; or of frames [frame][row][column], an array. Pixel types
        and chi_square as of CAE.encode."""
        return encode(library.toliman_linear_encode_many, self._c, frames, self.shape, chi_square, threads, progress)

    @property
    def sigma(self) -> float:
        """Predicted standard deviation (px) of a value: the Cramer-Rao bound with preprocess.project free."""
        sigma = ctypes.c_double()
        check(library.toliman_linear_get_sigma(self._c, ctypes.byref(sigma)))
        return sigma.value

    def _told(self) -> str:
        return f"Template for frames of {self.shape[0]}x{self.shape[1]}, sigma {self.sigma:.3g} px"


class Components(Handle):
    """Frames of a scene, collected to find their principal components or a sparse dictionary.

    raw: counts instead of whitened residuals. bin: pixels a side that are summed first. capacity: frames at most, those
    of the scene's cadence by default; all memory is taken at once, 4 bytes a pixel and frame.
    """

    _kind, _end = _raw.toliman_components, "toliman_components_destroy"

    def __init__(self, simulator: Simulator, *, raw: bool = False, bin: int = 1, capacity: int = 0):
        of_kind("simulator", simulator, Simulator)
        options = options_of(_raw.toliman_components_options, library.toliman_components_options_init,
                             raw=int(raw), bin=whole("bin", bin, 2**32), capacity=whole("capacity", capacity, 2**32))
        super().__init__(self._made(library.toliman_components_create, simulator._c, ctypes.byref(options)))
        self.shape = simulator.shape

    @property
    def info(self) -> ComponentsInfo:
        """Facts of the collection; threshold_px: the amplitude below which principal components see nothing."""
        return self._read(library.toliman_components_get_info, _raw.toliman_components_info,
                          ComponentsInfo)

    def push(self, frames: ArrayLike) -> None:
        """Adds a frame [row][column], or frames [frame][row][column], and forgets what was trained."""
        images = frames_of(frames, self.shape)
        image, lying = image_of(images[None] if images.ndim == 2 else images)
        check(library.toliman_components_push_many(self._c, ctypes.byref(image), len(lying)))

    def reset(self) -> None:
        """Forgets every frame."""
        check(library.toliman_components_reset(self._c))

    def train(self, method: str = "pca", components: int = 1, *, iterations: int = 0, sparsity: float = 0,
              seed: int = 0, threads: int = 0, progress: Progress | bool | None = None) -> ComponentsTraining:
        """Finds components of the frames: pca, or dictionary with at most so many iterations (200) and the weight
        `sparsity` (1 rms pixel) of the codes' L1 norm; 0 is the default."""
        with self._alone(), Watch(progress) as watch:
            options = options_of(
                _raw.toliman_components_train_options, library.toliman_components_train_options_init,
                method=number("method", method, "TOLIMAN_COMPONENTS"),
                components=whole("components", components, 2**32),
                iterations=whole("iterations", iterations, 2**32), seed=whole("seed", seed, 2**64),
                threads=whole("threads", threads, 2**32), progress=watch.callback,
                **{"lambda": real("sparsity", sparsity)})
            report = _raw.toliman_components_training()
            watch.check(library.toliman_components_train(self._c, ctypes.byref(options), ctypes.byref(report)))
        return ComponentsTraining._of(report)

    def series(self, component: int = 0) -> tuple[Doubles, float]:
        """One number a frame, in the order of the pushes, and the component's share of the frames' sum of squares."""
        values, share = numpy.empty(self.info.frames), ctypes.c_double()
        check(library.toliman_components_get_series(self._c, whole("component", component, 2**32), pointer(values),
                                                ctypes.byref(share)))
        return values, share.value

    def __len__(self) -> int:
        return self.info.frames

    def _told(self) -> str:
        info = self.info
        return f"Components of {info.frames} frames, {info.components} found"

    def _repr_html_(self) -> str:
        return self.info._repr_html_()
