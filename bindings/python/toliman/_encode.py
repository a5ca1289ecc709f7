"""Frames -> values, as networks and templates make them."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from ._arguments import Doubles, pointer, whole
from ._library import check
from ._pixels import frames_of, image_of
from ._progress import Progress, Watch

_FRAMES_AT_A_TIME = 64  # between two looks at progress and Ctrl-C

Values = typing.Union[float, Doubles]


def encode(function: typing.Any, handle: typing.Any, frames: ArrayLike, shape: tuple[int, int], chi_square: bool,
           threads: int, progress: Progress | bool | None) -> Values | tuple[Values, Values]:
    """The value of a frame, or those of several, and the chi-squares too where asked for; function is C's
    encode_many."""
    images, threads = frames_of(frames, shape), whole("threads", threads, 2**32)
    one = images.ndim == 2
    images = images[None] if one else images
    values = numpy.empty(len(images))
    squares = numpy.empty(len(images)) if chi_square else None

    def part(first: int, count: int) -> int:
        image, lying = image_of(images[first:first + count])
        return function(handle, ctypes.byref(image), len(lying), threads, pointer(values[first:]),
                        None if squares is None else pointer(squares[first:]))

    if one:
        check(part(0, 1))
        return float(values[0]) if squares is None else (float(values[0]), float(squares[0]))
    with Watch(progress) as watch:
        for first in range(0, len(images), _FRAMES_AT_A_TIME):
            watch.check(part(first, _FRAMES_AT_A_TIME))
            watch.step("encode", min(first + _FRAMES_AT_A_TIME, len(images)) / len(images))
    return values if squares is None else (values, squares)
