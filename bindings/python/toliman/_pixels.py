"""Pixel types and frame arrays: passes numpy arrays to C without a copy where C can address them."""
from __future__ import annotations

import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import has_shape, plain, refuse_lost
from ._words import words


def _type_of(word: str) -> str:
    """Returns numpy's code of a pixel type: u16 gives "u2", u16be gives ">u2"."""
    big = word.endswith("be")
    bits = int(word[1:-2] if big else word[1:])
    return f"{'>' if big else ''}{word[0]}{bits // 8}"


PIXELS = {_type_of(word): number for number, word in words("TOLIMAN_PIXEL").items()}


def _kind_of(array: NDArray) -> int | None:
    text = array.dtype.str
    return PIXELS.get(text if text.startswith(">") else text[1:])


def frames_of(frames: ArrayLike, shape: tuple[int, int]) -> NDArray:
    """Returns frames [frame][row][column], or one [row][column], unchanged if C knows their pixel type, else as
    float64. ValueError for another shape, masked values or units."""
    known = isinstance(frames, numpy.ndarray) and _kind_of(frames) is not None
    if known:
        refuse_lost("frames", frames)
    images = numpy.asarray(frames) if known else plain("frames", frames)
    has_shape("frames", images, shape if images.ndim == 2 else (-1, *shape))
    return images


def image_of(images: NDArray) -> tuple[typing.Any, NDArray]:
    """Returns the toliman_image struct for frames [frame][row][column] and the array that it points into: a copy if the
    strides are not multiples of the pixel size, rows are not contiguous, or memory is not aligned."""
    size = images.itemsize
    frame, row, column = images.strides
    if (column != size or row < images.shape[2] * size or row % size or frame < size or frame % size
            or not images.flags.aligned):
        images = numpy.require(images, requirements=["C", "A"])
        frame, row, _ = images.strides
    rows, cols = images.shape[1:]
    image = _raw.toliman_image(pixel=_kind_of(images), pixels=images.ctypes.data, rows=rows, cols=cols,
                               stride=row // size, frame_stride=frame // size)
    return image, images
