"""Encodes frames to values with a network or a template; both classes share this code."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from ._arguments import Doubles, pointer, whole
from ._library import check
from ._pixels import frames_of, image_of
from ._progress import Progress, Watch

_FRAMES_PER_CALL = 64  # progress and Ctrl-C are checked after each call

Values = typing.Union[float, Doubles]


def encode(function: typing.Any, handle: typing.Any, frames: ArrayLike, shape: tuple[int, int], chi_square: bool,
           threads: int, progress: Progress | bool | None) -> Values | tuple[Values, Values]:
    """Returns the value of one frame or the array of several; with chi_square, a pair with the chi-squares. `function`
    is toliman_cae_encode_many or toliman_linear_encode_many."""
    images, threads = frames_of(frames, shape), whole("threads", threads, 2**32)
    one = images.ndim == 2
    images = images[None] if one else images
    values = numpy.empty(len(images))
    squares = numpy.empty(len(images)) if chi_square else None

    def part(first: int, count: int) -> int:
        image, array = image_of(images[first:first + count])
        return function(handle, ctypes.byref(image), len(array), threads, pointer(values[first:]),
                        None if squares is None else pointer(squares[first:]))

    if one:
        check(part(0, 1))
        return float(values[0]) if squares is None else (float(values[0]), float(squares[0]))
    with Watch(progress) as watch:
        for first in range(0, len(images), _FRAMES_PER_CALL):
            watch.check(part(first, _FRAMES_PER_CALL))
            watch.step("encode", min(first + _FRAMES_PER_CALL, len(images)) / len(images))
    return values if squares is None else (values, squares)
