"""What all objects share: they own a pointer of C; arrays that C reads and fills."""
from __future__ import annotations

import ctypes
import operator
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._library import check, library
from ._shown import Result

Doubles = NDArray[numpy.float64]
doubles = ctypes.POINTER(ctypes.c_double)


class Handle:
    """Owns a C object; close(), a with statement or the garbage collector frees it. One thread at a time, but for calls
    that change nothing; long calls let other threads of Python run."""

    _kind: type  # of _raw
    _end: str = ""  # the C function that frees it; none of what belongs to another object

    def __init__(self, pointer: typing.Any, keep: typing.Any = None):
        self._pointer = pointer
        self._keep = keep  # what C holds pointers to

    @classmethod
    def _adopt(cls, pointer: typing.Any):
        """An object of a pointer that C made."""
        self = cls.__new__(cls)
        Handle.__init__(self, pointer)
        return self

    @classmethod
    def _made(cls, create: typing.Any, *arguments: typing.Any,
              check: typing.Callable[[int], None] = check) -> typing.Any:
        """The pointer that a create or load function of C gives as its last argument."""
        made: typing.Any = ctypes.POINTER(cls._kind)()
        check(create(*arguments, ctypes.byref(made)))
        return made

    @property
    def _c(self) -> typing.Any:
        pointer = getattr(self, "_pointer", None)
        if not pointer:
            raise ValueError(f"this {type(self).__name__} is closed")
        return pointer

    def _read(self, function: typing.Any, struct: type, result: type[Result]) -> typing.Any:
        """What a function with one struct as its result tells."""
        filled = struct()
        check(function(self._c, ctypes.byref(filled)))
        return result._of(filled)

    def close(self) -> None:
        """Frees the memory; the object is of no use afterwards."""
        pointer, self._pointer = getattr(self, "_pointer", None), None
        if pointer and self._end:
            getattr(library, self._end)(pointer)

    def __bool__(self) -> bool:
        return True

    def __enter__(self):
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()


def whole(name: str, value: int, end: int = 2**63) -> int:
    """A whole number from 0 to below `end`, which C would wrap around in silence."""
    number = operator.index(value)
    if not 0 <= number < end:
        raise ValueError(f"{name} = {number}: must be in [0, {end - 1}]")
    return number


def plain(name: str, values: ArrayLike, dtype: typing.Any = numpy.float64) -> NDArray:
    """Array in C order and the machine's byte order; what would lose its mask or its unit on the way is refused."""
    if numpy.ma.is_masked(values):
        raise ValueError(f"{name} has masked values: leave them out, e.g. by {name}.compressed()")
    unit = getattr(values, "unit", None)
    if unit is not None:
        raise TypeError(f"{name} is in {unit}: give plain numbers, e.g. {name}.to_value(...)")
    if numpy.iscomplexobj(values):
        raise TypeError(f"{name} is complex: give real numbers")
    return numpy.ascontiguousarray(values, dtype=dtype)


def pointer(array: NDArray | None) -> typing.Any:
    """Where an array of doubles lies; None is NULL. The array must outlive the call."""
    return None if array is None else array.ctypes.data_as(doubles)


def shaped(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Doubles:
    """The same as plain() of a shape that is known; -1 stands for any number."""
    array = plain(name, values)
    if array.ndim != len(shape) or any(want not in (-1, got) for want, got in zip(shape, array.shape)):
        wanted = ", ".join("any" if want == -1 else str(want) for want in shape)
        raise ValueError(f"{name} has the shape {array.shape}: must be ({wanted})")
    return array


def encode(handle: Handle, one: typing.Any, frames: ArrayLike, rows: int, cols: int,
           many: typing.Any = None) -> float | Doubles:
    """The value of a frame, or the values of several."""
    if numpy.ndim(frames) == 2:
        frame, value = shaped("frames", frames, (rows, cols)), ctypes.c_double()
        check(one(handle._c, pointer(frame), cols, ctypes.byref(value)))
        return value.value
    images = shaped("frames", frames, (-1, rows, cols))
    values = numpy.empty(len(images))
    if many is not None:
        check(many(handle._c, pointer(images), len(images), pointer(values)))
        return values
    for place, image in enumerate(images):
        values[place] = encode(handle, one, image, rows, cols)
    return values


def array_of(kind: type, count: int) -> typing.Any:
    """Structs for C to fill, at least one."""
    made = (kind * max(count, 1))()  # type: ignore[operator]
    made[0].struct_size = ctypes.sizeof(kind)
    return made


def saved(save: typing.Any) -> bytes:
    """The bytes that a save function, called with (bytes, capacity, needed), has to give."""
    needed = ctypes.c_size_t()
    check(save(None, 0, ctypes.byref(needed)))
    content = ctypes.create_string_buffer(needed.value)
    check(save(content, needed, ctypes.byref(needed)))
    return content.raw


def options_of(kind: type, initialise: typing.Any, **members: typing.Any) -> typing.Any:
    """Options of the library's defaults, but for some members."""
    options = kind()
    initialise(ctypes.byref(options), ctypes.sizeof(options))
    for name, value in members.items():
        setattr(options, name, value)
    return options

