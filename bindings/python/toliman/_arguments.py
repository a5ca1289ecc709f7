"""What callers give, as C takes it: numbers that fit, plain arrays in C order; whatever would be lost is refused."""
from __future__ import annotations

import ctypes
import operator
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import check

Doubles = NDArray[numpy.float64]
doubles = ctypes.POINTER(ctypes.c_double)

INT64 = 2**63  # one more than the largest


def within(name: str, value: int, first: int, end: int) -> int:
    """A whole number from `first` to below `end`, which C would wrap around in silence."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} = {value!r}: must be a whole number") from None
    if not first <= number < end:
        raise ValueError(f"{name} = {number}: must be in [{first}, {end - 1}]")
    return number


def whole(name: str, value: int, end: int = INT64) -> int:
    """The same from 0 on."""
    return within(name, value, 0, end)


def whole_float(name: str, value: float) -> int:
    """The same of a number that may come as a float, as of a formula."""
    return whole(name, int(value) if isinstance(value, (float, numpy.floating)) and value.is_integer()
                 else value)  # type: ignore[arg-type]


def real(name: str, value: typing.Any) -> float:
    """One number; a unit is refused."""
    _refuse_unit(name, value)
    if not isinstance(value, (int, float, numpy.integer, numpy.floating)):
        array = numpy.asarray(value)
        if array.ndim != 0 or array.dtype.kind not in "biuf":
            raise TypeError(f"{name} is a {type(value).__name__}: give one number")
    return float(value)


def file_name(path: str | bytes | os.PathLike[typing.Any]) -> bytes:
    """A path as C has it."""
    return text("path", os.fsencode(path))


def text(name: str, value: str | bytes) -> bytes:
    """A text, which C would cut at a zero byte."""
    content = value.encode() if isinstance(value, str) else value
    if b"\0" in content:
        raise ValueError(f"{name} = {value!r}: has a zero byte")
    return content


def _refuse_unit(name: str, values: object) -> None:
    unit = getattr(values, "unit", None)
    if unit is not None:
        raise TypeError(f"{name} is in {unit}: give plain numbers, e.g. {name}.to_value(...)")


def refuse_lost(name: str, values: object) -> None:
    """Refuses what would lose its mask or its unit on the way, also within lists."""
    if numpy.ma.is_masked(values):
        raise ValueError(f"{name} has masked values: fill them, or leave them out, first")
    _refuse_unit(name, values)
    if isinstance(values, (list, tuple)):
        for value in values:
            if not isinstance(value, (int, float)):
                refuse_lost(name, value)


def plain(name: str, values: ArrayLike) -> Doubles:
    """Array of doubles in C order and the machine's byte order; what would lose its mask, unit or meaning is refused."""
    refuse_lost(name, values)
    try:
        array = numpy.asarray(values)
    except ValueError as error:  # rows of unequal length
        raise ValueError(f"{name} is no array: {error}") from None
    if array.dtype.kind not in "biuf":
        plain_object = array.dtype.kind == "O" and not isinstance(values, numpy.ndarray)
        what = f"a {type(values).__name__}" if plain_object else f"an array of {array.dtype}"
        raise TypeError(f"{name} is {what}: give plain numbers")
    exact = numpy.require(array, numpy.float64, ["C", "A"])
    if array.dtype.kind in "iuf" and array.dtype.itemsize >= 8 and array.dtype != numpy.float64:
        with numpy.errstate(invalid="ignore"):
            if not numpy.array_equal(exact.astype(array.dtype), array, equal_nan=array.dtype.kind == "f"):
                raise ValueError(f"{name} is an array of {array.dtype} that doubles do not hold: subtract an offset first")
    return exact


def pointer(array: NDArray | None) -> typing.Any:
    """Where an array of doubles lies, which it holds; None is NULL."""
    return None if array is None else array.ctypes.data_as(doubles)


def shaped(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Doubles:
    """The same as plain() of a shape that is known; -1 stands for any number."""
    array = plain(name, values)
    has_shape(name, values, shape)
    return array


def has_shape(name: str, values: ArrayLike, shape: tuple[int, ...]) -> None:
    """Refuses an array of another shape."""
    given = numpy.shape(values)
    if len(given) != len(shape) or any(want not in (-1, got) for want, got in zip(shape, given)):
        wanted = ", ".join("any" if want == -1 else str(want) for want in shape)
        raise ValueError(f"{name} has the shape {given}: must be ({wanted})")


def of_kind(name: str, value: typing.Any, kind: type) -> typing.Any:
    """An object of ours."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} is a {type(value).__name__}: must be a {kind.__name__}")
    return value


def array_of(kind: type, count: int) -> typing.Any:
    """Structs for C to fill, at least one."""
    made = (kind * max(count, 1))()  # type: ignore[operator]
    made[0].struct_size = ctypes.sizeof(kind)
    return made


def options_of(kind: type, initialise: typing.Any, **members: typing.Any) -> typing.Any:
    """Options of the library's defaults, but for some members."""
    options = kind()
    initialise(ctypes.byref(options), ctypes.sizeof(options))
    for name, value in members.items():
        setattr(options, name, value)
    return options


def saved(save: typing.Any) -> bytes:
    """The bytes that a save function, called with (bytes, capacity, needed), has to give."""
    needed = ctypes.c_size_t()
    check(save(None, 0, ctypes.byref(needed)))
    content = ctypes.create_string_buffer(needed.value)
    check(save(content, needed, ctypes.byref(needed)))
    return content.raw
