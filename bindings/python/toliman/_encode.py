"""Frames -> values, as networks and templates make them."""
from __future__ import annotations

import typing

import numpy
from numpy.typing import ArrayLike

from ._arguments import Doubles, plain, shaped
from ._library import check
from ._progress import Progress, Watch

_FRAMES_AT_A_TIME = 64  # between two looks at progress and Ctrl-C


def encode(many: typing.Callable[[Doubles, Doubles], int], frames: ArrayLike, shape: tuple[int, int],
           progress: Progress | bool | None) -> typing.Any:
    """The value of a frame, or those of several, which many(frames, values) makes; it returns C's status."""
    images = plain("frames", frames)
    if images.ndim == 2:
        value = numpy.empty(1)
        check(many(shaped("frames", images, shape)[None], value))
        return float(value[0])
    images = shaped("frames", images, (-1, *shape))
    values = numpy.empty(len(images))
    with Watch(progress) as watch:
        for first in range(0, len(images), _FRAMES_AT_A_TIME):
            part = images[first:first + _FRAMES_AT_A_TIME]
            watch.check(many(part, values[first:first + len(part)]))
            watch.step("encode", (first + len(part)) / len(images))
    return values
