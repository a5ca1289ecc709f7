"""Pixel types and frame arrays: passes numpy arrays to C without a copy where C can address them."""
from __future__ import annotations

import ctypes
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


def windows_of(windows: ArrayLike | None, count: int) -> NDArray | None:
    """Returns the places [frame][2] of the frames' windows as the library takes them; None: not known."""
    if windows is None:
        return None
    places = numpy.asarray(windows)
    if places.dtype.kind not in "iu":
        raise ValueError(f"windows: dtype {places.dtype}: must be integers")
    has_shape("windows", places, (count, 2) if places.ndim == 2 else (2,))
    return numpy.ascontiguousarray(numpy.broadcast_to(places, (count, 2)), dtype=numpy.int64)


def image_of(images: NDArray, windows: NDArray | None = None) -> tuple[typing.Any, NDArray]:
    """Returns the toliman_image struct for frames [frame][row][column] and the array that it points into: a copy if the
    strides are not multiples of the pixel size, rows are not contiguous, or memory is not aligned. windows: of these frames,
    of windows_of()."""
    size = images.itemsize
    frame, row, column = images.strides
    if (column != size or row < images.shape[2] * size or row % size or frame < size or frame % size
            or not images.flags.aligned):
        images = numpy.require(images, requirements=["C", "A"])
        frame, row, _ = images.strides
    rows, cols = images.shape[1:]
    image = _raw.toliman_image(pixel=_kind_of(images), pixels=images.ctypes.data, rows=rows, cols=cols,
                               stride=row // size, frame_stride=frame // size)
    if windows is not None:
        image.windows = windows.ctypes.data_as(ctypes.POINTER(ctypes.c_int64))
        image._array_of_windows = windows  # the pointer alone does not keep a converted array
    return image, images
