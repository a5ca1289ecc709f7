"""Linear estimators: the least-squares template, and principal components or a dictionary of frames.

Reference: include/toliman/linear.h and components.h.
"""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._library import check, library
from ._arguments import Doubles, options_of, pointer, real, whole
from ._encode import Fits, Values, encode
from ._handle import Handle
from ._log import log
from ._pixels import Frames, image_of
from ._progress import Progress, Watch
from ._results import ComponentsInfo, ComponentsTraining
from ._words import number
from .sim import Scene, Simulator, simulator_of


class Template(Handle):
    """Weighted least-squares estimator of the separation; it reaches the Cramer-Rao bound to first order.

        template = Template(simulator)
        value = template.encode(frame)             # px; its standard deviation is template.sigma

    simulator: the scene, as a Simulator, a file or a dict; not needed afterwards. Nuisances listed in the scene's preprocess.project are
    fitted along with the separation. threads: number of worker threads of encode(); 0 means one per processor. Raises
    InputError if the nuisances leave nothing of the signal.
    """

    _kind, _destroy = _raw.toliman_linear, "toliman_linear_destroy"

    def __init__(self, simulator: Simulator | Scene, *, threads: int = 0):
        simulator = simulator_of("simulator", simulator)
        options = options_of(_raw.toliman_linear_options,
                             threads=whole("threads", threads, 2**32), log=log)
        super().__init__(self._create(library.toliman_linear_create, simulator._c, ctypes.byref(options)))
        self.shape = simulator.shape

    @typing.overload
    def encode(self, frames: ArrayLike, *, goodness: typing.Literal[False] = False,
               windows: ArrayLike | None = None, progress: Progress | bool | None = None) -> Values: ...

    @typing.overload
    def encode(self, frames: ArrayLike, *, goodness: typing.Literal[True],
               windows: ArrayLike | None = None, progress: Progress | bool | None = None) -> tuple[Values, Fits]: ...

    def encode(self, frames: ArrayLike, *, goodness: bool = False, windows: ArrayLike | None = None,
               progress: Progress | bool | None = None) -> Values | tuple[Values, Fits]:
        """Estimates the displacement (px) of one frame [row][column], a float; or of frames [frame][row][column], an
        array. Pixel types, goodness, windows, warnings and exceptions as in CAE.encode."""
        return encode(library.toliman_linear_encode, self._c, frames, self.shape, goodness, windows, progress)

    @property
    def sigma(self) -> float:
        """Predicted standard deviation (px) of one estimate: the Cramer-Rao bound with the nuisances of
        preprocess.project free."""
        sigma = ctypes.c_double()
        check(library.toliman_linear_get_sigma(self._c, ctypes.byref(sigma)))
        return sigma.value

    def _summary(self) -> str:
        return f"Template for {self.shape[0]}x{self.shape[1]} frames, sigma {self.sigma:.3g} px"


class Components(Handle):
    """Collects frames of a scene and finds their principal components or a sparse dictionary.

    These are the classical baselines: they do not know the signal. Each component gives one value per frame.

    Parameters

    simulator: the scene, as a Simulator, a file or a dict; not needed afterwards.
    raw: use counts instead of whitened residuals.
    bin: side of the square of pixels summed first; must divide rows and columns.
    capacity: maximum number of frames; 0 means the frames of the scene's cadence. All memory is allocated at once, 4
        bytes per binned pixel and frame.
    """

    _kind, _destroy = _raw.toliman_components, "toliman_components_destroy"

    def __init__(self, simulator: Simulator | Scene, *, raw: bool = False, bin: int = 1, capacity: int = 0):
        simulator = simulator_of("simulator", simulator)
        options = options_of(_raw.toliman_components_options,
                             raw=int(raw), bin=whole("bin", bin, 2**32), capacity=whole("capacity", capacity, 2**32),
                             log=log)
        super().__init__(self._create(library.toliman_components_create, simulator._c, ctypes.byref(options)))
        self.shape = simulator.shape

    @property
    def info(self) -> ComponentsInfo:
        """Properties of the collection. threshold_px: signal amplitude below which the leading principal component is
        uncorrelated with the signal."""
        return self._read(library.toliman_components_get_info, _raw.toliman_components_info,
                          ComponentsInfo)

    def push(self, frames: ArrayLike) -> None:
        """Adds one frame [row][column] or frames [frame][row][column], and discards the trained components. Raises
        CapacityError when the collection is full."""
        image, array = image_of(Frames(frames, self.shape, takes_one=True).whole())
        check(library.toliman_components_push(self._c, ctypes.byref(image), len(array)))

    def train(self, method: str = "pca", components: int = 1, *, iterations: int = 0, sparsity: float = 0,
              seed: int = 0, threads: int = 0, progress: Progress | bool | None = None) -> ComponentsTraining:
        """Finds components of the frames pushed so far, after subtracting their mean.

        Parameters

        method: "pca" or "dictionary".
        components: number of components, 1 to 64 and less than the number of frames.
        iterations: dictionary: maximum number of iterations; 0 means 200.
        sparsity: dictionary: weight of the codes' L1 norm, in rms pixels, in [0, 1e6]; 0 means 1.
        seed: dictionary: seed of the initial random atoms.

        Raises StateError for too few frames; Cancelled.
        """
        with self._exclusive(), Watch(progress) as watch:
            options = options_of(
                _raw.toliman_components_train_options,
                method=number("method", method, "TOLIMAN_COMPONENTS"),
                components=whole("components", components, 2**32),
                iterations=whole("iterations", iterations, 2**32), seed=whole("seed", seed, 2**64),
                threads=whole("threads", threads, 2**32), progress=watch.callback,
                **{"lambda": real("sparsity", sparsity)})
            report = _raw.toliman_components_training()
            watch.check(library.toliman_components_train(self._c, ctypes.byref(options), ctypes.byref(report)))
        return ComponentsTraining._of(report)

    def series(self, component: int = 0) -> tuple[Doubles, float]:
        """Returns the time series of a component, one value per frame in the order of the pushes, and the component's
        share of the frames' sum of squares. Raises StateError before train()."""
        values, share = numpy.empty(self.info.frames), ctypes.c_double()
        check(library.toliman_components_get_series(self._c, whole("component", component), pointer(values),
                                                ctypes.byref(share)))
        return values, share.value

    def __len__(self) -> int:
        return self.info.frames

    def _summary(self) -> str:
        info = self.info
        return f"Components of {info.frames} frames, {info.components} trained"
