"""Frames -> values, as networks and templates make them."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from ._arguments import plain, pointer, shaped
from ._progress import Progress, Watch

_FRAMES_AT_A_TIME = 64  # between two looks at progress and Ctrl-C


def encode(object_of: typing.Callable[[], typing.Any], one: typing.Any, many: typing.Any, frames: ArrayLike,
           shape: tuple[int, int], progress: Progress | bool | None) -> typing.Any:
    """The value of a frame by one(object, frame, stride, value), or those of several by many(object, frames, count,
    values)."""
    object_of()  # not closed
    images = plain("frames", frames)
    with Watch(progress) as watch:
        if images.ndim == 2:
            image, value = shaped("frames", images, shape), ctypes.c_double()
            watch.check(one(object_of(), pointer(image), shape[1], ctypes.byref(value)))
            return value.value
        images = shaped("frames", images, (-1, *shape))
        values = numpy.empty(len(images))
        for first in range(0, len(images), _FRAMES_AT_A_TIME):
            part = images[first:first + _FRAMES_AT_A_TIME]
            watch.check(many(object_of(), pointer(part), len(part), pointer(values[first:])))
            watch.step("encode", (first + len(part)) / len(images))
    return values
