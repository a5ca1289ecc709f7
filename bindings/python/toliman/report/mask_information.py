"""Information on the separation in the frame of a scene."""
from __future__ import annotations

import math
import pathlib
import typing

import numpy

from .._output import signals_deferred
from .results import Array

_NOTHING = 1e-10  # relative norm below which a residual is that of rounding


class Information(typing.NamedTuple):
    """share: of each pixel in the information, [row][column], sum 1. bound_px: with all nuisances free. known_px: bound with
    this nuisance known and the others free, by name. Bounds may be infinite."""

    share: Array
    bound_px: float
    known_px: dict[str, float]


class Simulated(typing.NamedTuple):
    """Of a scene: amplitude of the pupil; noise-free frame in `unit`; stars {name: (x, y)}, px from the frame's centre."""

    amplitude: Array
    frame: Array
    unit: str
    stars: dict[str, tuple[float, float]]
    information: Information


def simulate(path: pathlib.Path, free: typing.Sequence[str]) -> tuple[Simulated | None, str]:
    """Simulates a scene; free: names of the nuisances. Returns None and the reason if that is not possible."""
    try:
        from .. import Error, Simulator
    except ImportError as error:
        return None, "libtoliman cannot be loaded. " + " ".join(str(error).split())
    with signals_deferred() as received:  # an exception of a signal handler cannot propagate through C
        try:
            with Simulator(path, progress=lambda *_: bool(received)) as simulator:
                return _of(simulator, free), ""
        except Error as error:
            return None, str(error)


def _of(simulator: typing.Any, free: typing.Sequence[str]) -> Simulated:
    nuisances = {name: simulator.derivative(name) for name in free}
    stars = {name: (float(x), float(y)) for name, (x, y) in zip("AB", simulator.offsets()) if math.isfinite(x)}
    information = information_of(simulator.image("separation"), nuisances, simulator.image("variance"))
    return Simulated(simulator.pupil()[0], simulator.image(), simulator.info.unit, stars, information)


def information_of(signal: Array, nuisances: dict[str, Array], variance: Array) -> Information:
    """Returns the information of each pixel and the bounds, from derivative images by the separation and by the nuisances.

    The efficient score is r = signal less its least-squares fit by the nuisances, with weights 1 / variance. r^2 / variance is
    the information of a pixel, and the bound is 1 / sqrt of its sum. The fit is that of whitened images: the Fisher matrix
    would square their condition number."""
    sigma = numpy.sqrt(variance)
    whitened = {name: _whitened(image, sigma) for name, image in nuisances.items()}
    target = _whitened(signal, sigma)
    score = _residual(target, whitened)
    known = {name: _bound(_residual(target, {other: image for other, image in whitened.items() if other != name}), target)
             for name in whitened}
    return Information((score**2 / ((score @ score) or 1.0)).reshape(signal.shape), _bound(score, target), known)


def _whitened(image: Array, sigma: Array) -> Array:
    """The image over the standard deviation of each pixel, where there is noise."""
    return numpy.divide(image, sigma, out=numpy.zeros_like(image), where=sigma > 0).ravel()


def _residual(target: Array, images: dict[str, Array]) -> Array:
    """Least-squares residual of the target; images that depend linearly on others have no effect."""
    columns = [image / norm for image in images.values() if (norm := float(numpy.linalg.norm(image))) > 0]
    if not columns:
        return target
    matrix = numpy.stack(columns, axis=1)
    return target - matrix @ numpy.linalg.lstsq(matrix, target, rcond=None)[0]


def _bound(score: Array, target: Array) -> float:
    left = float(numpy.linalg.norm(score))
    return 1 / left if left > _NOTHING * float(numpy.linalg.norm(target)) else math.inf
