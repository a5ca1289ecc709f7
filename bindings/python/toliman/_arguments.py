"""Converts Python arguments to C types, and raises TypeError or ValueError where a conversion would lose information.

ctypes wraps integers silently and numpy drops masks and units, so every argument is checked here first.
"""
from __future__ import annotations

import ctypes
import operator
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._library import check, check_asked
from ._units import unit_of_name

Doubles = NDArray[numpy.float64]
doubles = ctypes.POINTER(ctypes.c_double)

INT64 = 2**63  # one more than the largest int64


def within(name: str, value: int, first: int, end: int) -> int:
    """Returns an integer in [first, end); ctypes would wrap others silently."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} = {value!r}: must be an integer") from None
    if not first <= number < end:
        raise ValueError(f"{name} = {number}: must be in [{first}, {end - 1}]")
    return number


def whole(name: str, value: int, end: int = INT64) -> int:
    """Returns an integer in [0, end)."""
    return within(name, value, 0, end)


def whole_float(name: str, value: float) -> int:
    """Returns an integer in [0, 2^63), which may be given as a float with an integral value, such as 1e4."""
    return whole(name, int(value) if isinstance(value, (float, numpy.floating)) and value.is_integer()
                 else value)  # type: ignore[arg-type]


def in_unit(name: str, value: typing.Any, unit: str) -> typing.Any:
    """Returns a Quantity of astropy, also one in a list, as numbers in a unit, anything else as it is. "", or pix: the
    argument has no unit, or takes plain numbers only: TypeError. UnitConversionError of astropy for another unit. ValueError
    for masked values."""
    if isinstance(value, (list, tuple)):
        return [in_unit(name, one, unit) for one in value]
    _refuse_mask(name, value)
    given = getattr(value, "unit", None)
    if given is None:
        return value
    if unit in ("", "pix"):
        _refuse_unit(name, value)
    if not hasattr(value, "to_value"):  # a column of a table, or a masked quantity of an old version
        value = value.quantity
    try:
        return value.to_value(unit)
    except ValueError as error:  # UnitConversionError of astropy
        raise type(error)(f"{name} is in {given}: must be in {unit}, or a plain number") from None


def real(name: str, value: typing.Any, unit: str | None = None) -> float:
    """Returns one number as a float; TypeError for an array. A Quantity is converted to the unit, None: that of the
    name, as of exposure_s; without one, TypeError."""
    if type(value) not in (int, float):
        value = in_unit(name, value, unit_of_name(name) if unit is None else unit)
    if not isinstance(value, (int, float, numpy.integer, numpy.floating)) or isinstance(value, numpy.timedelta64):
        array = numpy.asarray(value)
        if array.ndim != 0 or array.dtype.kind not in "biuf":
            raise TypeError(f"{name} is a {type(value).__name__}: give one number")
    return float(value)


def file_name(path: str | bytes | os.PathLike[typing.Any]) -> bytes:
    """Returns a path as the bytes that C expects."""
    return text("path", os.fsencode(path))


def text(name: str, value: str | bytes) -> bytes:
    """Returns a string as bytes; ValueError for an embedded zero byte, at which C would truncate it."""
    content = value.encode() if isinstance(value, str) else value
    if b"\0" in content:
        raise ValueError(f"{name} = {value!r}: must not contain a zero byte")
    return content


def _refuse_unit(name: str, values: object) -> None:
    unit = getattr(values, "unit", None)
    if unit is not None:
        raise TypeError(f"{name} is in {unit}: give plain numbers, for example {name}.to_value(...)")


def _without_unit(name: str, values: typing.Any, unit: str) -> typing.Any:
    """Returns in_unit(), also of lists, which are examined only if they are not of plain numbers."""
    is_list = isinstance(values, (list, tuple)) and not all(isinstance(one, (int, float)) for one in values)
    return in_unit(name, values, unit) if is_list or hasattr(values, "unit") else values


def refuse_lost(name: str, values: object) -> None:
    """Raises for values whose mask or unit the conversion would drop, also inside lists."""
    _refuse_mask(name, values)
    _refuse_unit(name, values)
    if isinstance(values, (list, tuple)):
        for value in values:
            if not isinstance(value, (int, float)):
                refuse_lost(name, value)


def _refuse_mask(name: str, values: object) -> None:
    """Of numpy, of a column of a table, or of a Quantity or Time of astropy."""
    mask = getattr(values, "mask", False)
    if numpy.ma.is_masked(values) or (isinstance(mask, (bool, numpy.bool_, numpy.ndarray)) and numpy.any(mask)):
        raise ValueError(f"{name} has masked values: fill or remove them first")


def plain(name: str, values: ArrayLike, unit: str | None = None) -> Doubles:
    """Returns a float64 array in C order and native byte order; raises where a mask, a unit or digits would be lost. A
    Quantity is converted as by real()."""
    values = _without_unit(name, values, unit_of_name(name) if unit is None else unit)
    refuse_lost(name, values)
    try:
        array = numpy.asarray(values)
    except ValueError as error:  # rows of unequal length
        raise ValueError(f"{name} is not an array: {error}") from None
    if array.dtype.kind not in "biuf":
        plain_object = array.dtype.kind == "O" and not isinstance(values, numpy.ndarray)
        what = f"a {type(values).__name__}" if plain_object else f"an array of {array.dtype}"
        raise TypeError(f"{name} is {what}: give plain numbers")
    exact = numpy.require(array, numpy.float64, ["C", "A"])
    if array.dtype.kind in "iuf" and array.dtype.itemsize >= 8 and array.dtype != numpy.float64:
        with numpy.errstate(invalid="ignore"):
            if not numpy.array_equal(exact.astype(array.dtype), array, equal_nan=array.dtype.kind == "f"):
                raise ValueError(f"{name} is an array of {array.dtype} whose values float64 cannot represent exactly: "
                                 "subtract an offset first")
    return exact


def pointer(array: NDArray | None) -> typing.Any:
    """Returns a pointer to an array of doubles, which keeps the array alive; None gives NULL."""
    return None if array is None else array.ctypes.data_as(doubles)


def shaped(name: str, values: ArrayLike, shape: tuple[int, ...], unit: str | None = None) -> Doubles:
    """Returns plain(values) and requires the given shape, in which -1 means any length."""
    array = plain(name, values, unit)
    has_shape(name, values, shape)
    return array


def has_shape(name: str, values: ArrayLike, shape: tuple[int, ...]) -> None:
    """Raises ValueError unless the values have the given shape, in which -1 means any length."""
    given = numpy.shape(values)
    if len(given) != len(shape) or any(want not in (-1, got) for want, got in zip(shape, given)):
        wanted = ", ".join("any" if want == -1 else str(want) for want in shape)
        raise ValueError(f"{name} has the shape {given}: must be ({wanted})")


def of_kind(name: str, value: typing.Any, kind: type) -> typing.Any:
    """Returns the value; TypeError unless it is an instance of `kind`."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} is a {type(value).__name__}: must be a {kind.__name__}")
    return value


def array_of(kind: type, count: int) -> typing.Any:
    """Returns an array of at least one struct for C to fill; C reads the struct_size of the first element only."""
    made = (kind * max(count, 1))()  # type: ignore[operator]
    made[0].struct_size = ctypes.sizeof(kind)
    return made


def listed(kind: type, function: typing.Any, *arguments: typing.Any, capacity: int | None = None) -> typing.Any:
    """Returns the structs of a function (..., array, capacity, count). capacity: their number at most, if known."""
    count = ctypes.c_size_t(0 if capacity is None else capacity)
    if capacity is None:
        check_asked(function(*arguments, None, 0, ctypes.byref(count)))
    made = array_of(kind, count.value)
    check(function(*arguments, made, count.value, ctypes.byref(count)))
    return made[:count.value]


def options_of(kind: type, /, **members: typing.Any) -> typing.Any:
    """Returns an options struct with the given members; those of a struct in it are a dictionary. 0 in the others selects
    their defaults."""
    options = kind()
    for name, value in members.items():
        if isinstance(value, dict):
            for inner, inner_value in value.items():
                setattr(getattr(options, name), inner, inner_value)
        else:
            setattr(options, name, value)
    return options


def load_options(threads: int) -> typing.Any:
    """Returns the options of a load function."""
    return ctypes.byref(options_of(_raw.toliman_load_options,
                                   threads=whole("threads", threads, 2**32)))


def saved(save: typing.Any) -> bytes:
    """Returns the bytes written by a save function with the arguments (bytes, capacity, needed)."""
    needed, capacity = ctypes.c_size_t(), 2 << 20  # of most: the size is not asked for, as that takes as long as saving
    content = ctypes.create_string_buffer(capacity)
    check_asked(save(content, capacity, ctypes.byref(needed)))
    if needed.value > capacity:
        content = ctypes.create_string_buffer(needed.value)
        check(save(content, needed, ctypes.byref(needed)))
    return content.raw[:needed.value]
