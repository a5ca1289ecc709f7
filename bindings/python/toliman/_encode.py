"""Encodes frames to values with a network or a template; both classes share this code."""
from __future__ import annotations

import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import Doubles, array_of, pointer
from ._goodness import warn_of
from ._pixels import Frames
from ._predictions import joined
from ._progress import Progress, Watch
from ._results import FrameGoodness

Values = typing.Union[float, Doubles]
Fits = typing.Union[FrameGoodness, NDArray]


def encode(function: typing.Any, handle: typing.Any, frames: ArrayLike | typing.Iterable[ArrayLike], shape: tuple[int, int],
           goodness: bool, windows: ArrayLike | None, progress: Progress | bool | None) -> Values | tuple[Values, Fits]:
    """Returns the value of one frame or the array of several; with goodness, a pair with the goodness of fit. `function`
    is toliman_cae_encode or toliman_linear_encode."""
    source = Frames(frames, shape, windows=windows, takes_one=True)
    parts, blocks = [numpy.empty(0)], []
    with Watch(progress) as watch:
        for first, image, count in source.images(watch):
            values, fits = numpy.empty(count), array_of(_raw.toliman_frame_goodness, count)
            watch.check(function(handle, image, count, pointer(values), fits))
            parts.append(values)
            blocks.append((fits, count))
            watch.step("encode", source.share(first + count))
    found, latents = joined(blocks, _raw.toliman_frame_goodness), numpy.concatenate(parts)
    warn_of(found, stacklevel=4)
    if source.is_one:
        return (float(latents[0]), FrameGoodness._of(blocks[0][0][0])) if goodness else float(latents[0])
    return (latents, found) if goodness else latents
