"""The methods that the experiment compares: each turns a series of frames into values.

Networks, the template and the fit encode each frame on arrival. Components are fitted to the whole series after its last
frame (principal components, sparse dictionary); a value is the frame's coefficient, with arbitrary sign and unit. For B
block means of N frames the noise of a sample is sigma sqrt(B/N), so that by the threshold in theory.py the smallest signal
that is the first component is proportional to B^(1/4): B is as small as a few periods of the signal allow. The
unsupervised network keeps the frames as float32, the precision of its input. A method is one row of METHODS.
"""
from __future__ import annotations

import functools
import threading
import typing

import numpy
from numpy.typing import NDArray

from .._arguments import Doubles
from ..bank import Bank
from ..cae import CAE
from ..fit import Fit
from ..linear import Components, Template
from ..sim import Simulator

_BLOCKS = 27  # B: it still samples a few periods
_BANK_STEPS = 300  # as many as those of a single network; 600 would gain 0.3 % of efficiency
_CHAPTER_EPOCHS = 10
SLOW_SEEDS = 1  # of a slow method
SLOW_LEAST_PX = 1e-4  # at smaller amplitudes a method without a prior learns noise


class Frames(typing.Protocol):
    """What takes the frames of a series, for one method or for several."""

    block: int  # frames per value; an incomplete last block has none

    def begin(self) -> None:
        """Begins a series."""

    def push(self, images: Doubles, times: Doubles) -> None:
        """Adds the next frames, with their times in the scene."""


class Method(typing.NamedTuple):
    """A method that is ready for frames."""

    frames: Frames
    series: typing.Callable[[], Doubles]  # values of the frames pushed since begin(); NaN: the frame gave none


class _PerFrame:
    """Encodes each frame on arrival."""

    block = 1

    def __init__(self, encode: typing.Callable[[Doubles, Doubles], typing.Any]):
        self._encode = encode
        self.begin()

    def begin(self) -> None:
        self._values: list[Doubles] = []

    def push(self, images: Doubles, times: Doubles) -> None:
        self._values.append(self._encode(images, times))

    def series(self) -> Doubles:
        """Returns the values."""
        return numpy.concatenate(self._values)


class _ComponentFrames:
    """Frames, or means of blocks of them, from which components are computed: products of frames once for all."""

    def __init__(self, simulator: Simulator, raw: bool = False, blocks: bool = False):
        frames = simulator.info.frames
        self.block = max(1, frames // _BLOCKS) if blocks else 1
        self._new = functools.partial(Components, simulator, raw=raw, capacity=frames // self.block)
        self._components: typing.Any = None
        self._rest: Doubles | None = None
        self._lock = threading.Lock()

    def begin(self) -> None:
        self._components = None  # its memory first
        self._components, self._rest = self._new(), None

    def push(self, images: Doubles, _: Doubles) -> None:
        if self.block > 1:
            frames = images if self._rest is None else numpy.concatenate([self._rest, images])
            whole = len(frames) // self.block * self.block
            images = frames[:whole].reshape(-1, self.block, *frames.shape[1:]).mean(axis=1)
            self._rest = frames[whole:]
        if len(images) > 0:
            self._components.push(images)

    def series(self, method: str, seed: int) -> Doubles:
        """Returns the values of the first component that a method finds."""
        with self._lock:
            self._components.train(method, seed=seed)
            return self._components.series()[0]


class _Unsupervised:
    """The book chapter's network, layout and input, trained on the series by the mean squared error of the
    reconstruction."""

    block = 1

    def __init__(self, simulator: Simulator, seed: int):
        self._simulator, self._seed = simulator, seed

    def begin(self) -> None:
        self._frames: list[NDArray] = []

    def push(self, images: Doubles, _: Doubles) -> None:
        self._frames.append(images.astype(numpy.float32))

    def series(self) -> Doubles:
        """Returns the latents."""
        frames = numpy.concatenate(self._frames)
        self._frames = []
        network = CAE(self._simulator, seed=self._seed, layout="paper", input="raw")
        network.train("unsupervised", epochs=_CHAPTER_EPOCHS, count=len(frames),
                      frames=lambda first, number: frames[first:first + number])
        return typing.cast(Doubles, network.encode(frames))


def _per_frame(encode: typing.Callable[[Doubles, Doubles], typing.Any]) -> Method:
    frames = _PerFrame(encode)
    return Method(frames, frames.series)


def _template(simulator: Simulator, _: int, __: Shared) -> Method:
    template = Template(simulator)
    return _per_frame(lambda images, times: template.encode(images))


def _network(simulator: Simulator, seed: int, _: Shared, trained: bool = False, **options: typing.Any) -> Method:
    network = CAE(simulator, seed=seed, **options)
    if trained:
        network.train()
    return _per_frame(lambda images, times: network.encode(images))


def _fit(simulator: Simulator, _: int, __: Shared) -> Method:
    fit = Fit(simulator)
    return _per_frame(lambda images, times: fit.frames(images, times_days=times)["displacement_px"])


def _bank(simulator: Simulator, seed: int, _: Shared, trained: bool) -> Method:
    bank = Bank(Fit(simulator), steps=_BANK_STEPS, seed=seed)
    if trained:
        bank.train()
    return _per_frame(lambda images, times: bank.encode(images, times_days=times)[0]["displacement_px"])


def _component(simulator: Simulator, seed: int, _: Shared, **options: bool) -> Method:
    frames = _ComponentFrames(simulator, **options)
    return Method(frames, lambda: frames.series("pca", seed))


def _whitened(simulator: Simulator, seed: int, shared: Shared, method: str) -> Method:
    frames = shared.setdefault("whitened", _ComponentFrames(simulator))
    return Method(frames, lambda: frames.series(method, seed))


def _unsupervised(simulator: Simulator, seed: int, _: Shared) -> Method:
    frames = _Unsupervised(simulator, seed)
    return Method(frames, frames.series)


# Frames that several methods of one scene and seed use, so that they are stored and their products computed once.
Shared = typing.Dict[str, _ComponentFrames]


class Kind(typing.NamedTuple):
    """A method: its description, and how it is made for a scene and a seed, trained on the scene if it is to be."""

    what: str
    make: typing.Callable[[Simulator, int, Shared], Method]
    knows_scene: bool = True  # values are in px of a known scene, so that frames of other scenes make sense
    learns: bool = False  # from the series that it evaluates, so that it has no response to expected images
    slow: bool = False  # a minute or more per series: see SLOW_SEEDS and SLOW_LEAST_PX
    on_request: bool = False  # not among the default methods


METHODS = {
    "cae": Kind("the autoencoder, trained once for each seed of weights, without frames",
                functools.partial(_network, trained=True)),
    "template": Kind("least squares on the scene's derivative image: the reference method", _template),
    "fit": Kind("the forward model fitted to each frame: places, fluxes and background; follows moving stars", _fit),
    "untrained": Kind("the autoencoder with random weights: shows what is found without training", _network),
    "bank": Kind("networks trained for the dates and sub-pixel places of the frames; each takes the residual of a fit",
                 functools.partial(_bank, trained=True), on_request=True),
    "untrained-bank": Kind("the same with random weights", functools.partial(_bank, trained=False), on_request=True),
    "pca": Kind("first principal component of the series' own frames, in counts",
                functools.partial(_component, raw=True), knows_scene=False, learns=True),
    "pca-white": Kind("the same for residuals divided by their sigma", functools.partial(_whitened, method="pca"),
                      knows_scene=False, learns=True),
    "pca-blocks": Kind("the same for means over 1/27 of the series each, one value per mean",
                       functools.partial(_component, blocks=True), knows_scene=False, learns=True),
    "dictionary": Kind("one sparse dictionary atom (lambda 1) of residuals divided by their sigma",
                       functools.partial(_whitened, method="dictionary"), knows_scene=False, learns=True),
    "untrained-paper": Kind("the book chapter's network and input (maximum pooling, counts), random weights",
                            functools.partial(_network, layout="paper", input="raw"), knows_scene=False),
    "cae-unsupervised": Kind("the same trained on the series' own frames for 10 epochs, without a prior", _unsupervised,
                             knows_scene=False, learns=True, slow=True),
}
