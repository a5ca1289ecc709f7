"""Pixel types and frame arrays: passes numpy arrays to C without a copy where C can address them."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import has_shape, plain, refuse_lost, shaped
from ._progress import Watch
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


FRAMES_PER_CALL = 64  # progress and Ctrl-C are checked after each call


class Frames:
    """Frames of one shape, as images that C takes in one call: FRAMES_PER_CALL at most.

    frames: frames [frame][row][column] as an array in any memory order, a memory map, or another object with shape and
        slices, such as a dataset of HDF5; a list, or an iterator, of frames; with takes_one also one frame [row][column].
    windows: row and column on the detector of each frame's first pixel, [frame][2], or one pair for all; None: unknown.
    lengths: of further arguments with a member per frame, None of others. An iterator must have as many frames.
    Only one block is copied, and only if C cannot address it. ValueError for another shape, masked values or units.
    """

    def __init__(self, frames: typing.Any, shape: tuple[int, int], *lengths: int | None, windows: ArrayLike | None = None,
                 takes_one: bool = False):
        known = [length for length in (*lengths, length_of(windows, 2)) if length is not None]
        self.shape, self.count = shape, known[0] if known else None  # None: an iterator whose length is unknown
        self.is_one = False
        self._iterator: typing.Iterator[typing.Any] | None = None
        self._array: typing.Any = None
        frames = pixels_of(frames)
        is_array = hasattr(frames, "shape") and hasattr(frames, "__getitem__")
        if isinstance(frames, (list, tuple)):
            has_frames = len(frames) == 0 or numpy.ndim(frames[0]) == 2
        else:
            has_frames = (hasattr(frames, "__iter__") and not isinstance(frames, (str, bytes))
                          and not is_array and not hasattr(frames, "__array__"))
        if has_frames:
            self.count = len(frames) if isinstance(frames, (list, tuple)) else self.count
            self._iterator = iter(frames)
        else:
            self._set_array(frames if is_array else plain("frames", frames), takes_one)
        self._windows = windows
        self._places = None if self.count is None else _windows_of(windows, self.count)

    def _set_array(self, frames: typing.Any, takes_one: bool) -> None:
        self.is_one = takes_one and len(frames.shape) == 2
        has_shape("frames", frames, self.shape if self.is_one else (-1, *self.shape))
        self._array = _addressed(frames)[None] if self.is_one else frames
        self.count = len(self._array)

    def images(self, watch: Watch) -> typing.Iterator[tuple[int, typing.Any, int]]:
        """Yields the index of the first frame of each block, a pointer to the toliman_image, and the number of frames."""
        for first, block in self._blocks(watch):
            places = _windows_of(self._windows, len(block)) if self._places is None else self._places[first:]
            image, array = image_of(block, places)  # the array is in use until the next block
            yield first, ctypes.byref(image), len(array)

    def _blocks(self, watch: Watch) -> typing.Iterator[tuple[int, NDArray]]:
        if self._iterator is not None:
            yield from self._iterated(self._iterator, watch)
        else:
            for first in range(0, self.count or 0, FRAMES_PER_CALL):
                yield first, _addressed(self._array[first:first + FRAMES_PER_CALL])

    def whole(self) -> NDArray:
        """Returns all frames in one array."""
        if isinstance(self._array, numpy.ndarray):
            return _addressed(self._array)
        blocks = [block for _, block in self._blocks(Watch(None))]
        return numpy.concatenate(blocks) if blocks else numpy.empty((0, *self.shape))

    def _iterated(self, frames: typing.Iterator[typing.Any], watch: Watch) -> typing.Iterator[tuple[int, NDArray]]:
        first = 0
        while True:
            block, raised = watch.take(frames, FRAMES_PER_CALL)
            if raised is not None:
                raise raised
            if not block:
                break
            if self.count is not None and first + len(block) > self.count:
                raise ValueError(f"frames: are more than {self.count}, the length of other arguments")
            images = [pixels_of(frame) for frame in block]
            for k, image in enumerate(images):
                refuse_lost("frames", image)
                has_shape(f"frame {first + k}", numpy.asarray(image), self.shape)
            yield first, _addressed(numpy.stack([numpy.asarray(image) for image in images]))
            first += len(block)
        if self.count is not None and first < self.count:
            raise ValueError(f"frames: are {first}: must be {self.count}, the length of other arguments")

    def share(self, done: int) -> float:
        """Returns the share of the frames that is done; 0 as long as their number is unknown."""
        return done / self.count if self.count else 0


def length_of(values: typing.Any, dimensions: int) -> int | None:
    """Returns the length of an argument that has a member per frame, an array of these dimensions; None of others."""
    return len(values) if values is not None and numpy.ndim(values) == dimensions else None


def pixels_of(frame: typing.Any) -> typing.Any:
    """Returns the pixels of a Frame, with their mask and unit; anything else as it is."""
    return getattr(frame, "pixels", frame)


def _addressed(frames: typing.Any) -> NDArray:
    """Returns frames unchanged if C knows their pixel type, else as float64."""
    known = isinstance(frames, numpy.ndarray) and _kind_of(frames) is not None
    if known:
        refuse_lost("frames", frames)
    return numpy.asarray(frames) if known else plain("frames", frames)


def _windows_of(windows: ArrayLike | None, count: int) -> NDArray | None:
    """Returns the places [frame][2] of the frames' windows as the library takes them; None: unknown places."""
    if windows is None:
        return None
    refuse_lost("windows", windows)
    places = numpy.asarray(windows)
    if places.dtype.kind not in "iu":
        raise ValueError(f"windows: dtype {places.dtype}: must be integers")
    has_shape("windows", places, (count, 2) if places.ndim == 2 else (2,))
    return numpy.ascontiguousarray(numpy.broadcast_to(places, (count, 2)), dtype=numpy.int64)


def frame_of(name: str, frame: ArrayLike, shape: tuple[int, int], window: ArrayLike | None) -> tuple[typing.Any, NDArray]:
    """Returns the toliman_image struct for one frame, and the array that it points into."""
    return image_of(shaped(name, pixels_of(frame), shape)[None], _windows_of(window, 1))


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
