"""Encodes frames to values with a network or a template; both classes share this code."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import Doubles, array_of, pointer
from ._goodness import warn_of
from ._library import check
from ._pixels import frames_of, image_of, windows_of
from ._predictions import structured
from ._progress import Progress, Watch
from ._results import FrameGoodness

_FRAMES_PER_CALL = 64  # progress and Ctrl-C are checked after each call

Values = typing.Union[float, Doubles]
Fits = typing.Union[FrameGoodness, NDArray]


def encode(function: typing.Any, handle: typing.Any, frames: ArrayLike, shape: tuple[int, int], goodness: bool,
           windows: ArrayLike | None, progress: Progress | bool | None) -> Values | tuple[Values, Fits]:
    """Returns the value of one frame or the array of several; with goodness, a pair with the goodness of fit. `function`
    is toliman_cae_encode or toliman_linear_encode."""
    images = frames_of(frames, shape)
    one = images.ndim == 2
    images = images[None] if one else images
    values, places = numpy.empty(len(images)), windows_of(windows, len(images))
    fits = array_of(_raw.toliman_frame_goodness, len(images))

    def part(first: int, count: int) -> int:
        image, array = image_of(images[first:first + count], None if places is None else places[first:])
        if len(array) > 0:
            fits[first].struct_size = ctypes.sizeof(fits[first])
        return function(handle, ctypes.byref(image), len(array), pointer(values[first:]),
                        ctypes.byref(fits[first]) if len(array) > 0 else None)

    if one:
        check(part(0, 1))
    else:
        with Watch(progress) as watch:
            for first in range(0, len(images), _FRAMES_PER_CALL):
                watch.check(part(first, _FRAMES_PER_CALL))
                watch.step("encode", min(first + _FRAMES_PER_CALL, len(images)) / len(images))
    found = structured(fits)[:len(images)]
    warn_of(found, stacklevel=4)
    if one:
        return (float(values[0]), FrameGoodness._of(fits[0])) if goodness else float(values[0])
    return (values, found) if goodness else values
