"""Predictions of frames, and arrays of results, for fits and banks."""
from __future__ import annotations

import ctypes
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._arguments import array_of, has_shape, plain, real, shaped
from ._pixels import length_of
from ._results import OF_STRUCTS
from ._spread import Spread
from ._table import Records, Units, records_of

# The numbers of a prediction: numpy has no type for its pointer.
_MEMBERS = ("time_days", "x_px", "y_px", "separation_px", "position_angle_deg")
_NUMBERS = numpy.dtype({"names": _MEMBERS, "formats": [numpy.float64] * len(_MEMBERS),
                        "offsets": [getattr(_raw.toliman_fit_prediction, name).offset for name in _MEMBERS],
                        "itemsize": ctypes.sizeof(_raw.toliman_fit_prediction)})

def prediction_of(time_days: float, shift: tuple[float, float], separation: float, position_angle: float,
                  spread: Spread | None = None) -> typing.Any:
    """A struct for one frame."""
    x, y = shaped("shift", shift, (2,))
    made = _raw.toliman_fit_prediction(time_days=real("time_days", time_days), x_px=x, y_px=y,
                                       separation_px=real("separation", separation),
                                       position_angle_deg=real("position_angle", position_angle, "deg"))
    if spread is not None:
        made.spread = ctypes.pointer(spread.struct())
    return made


def predictions_of(count: int, times_days: ArrayLike, shifts: ArrayLike, separations: ArrayLike,
                   position_angles: ArrayLike, spreads: typing.Sequence[Spread] | None = None) -> typing.Any:
    """An array of structs from one number per frame, or one for all; spreads: one per frame, or None."""
    made = array_of(_raw.toliman_fit_prediction, count)
    rows = numpy.frombuffer(made, _NUMBERS, count)
    for member, name, values, unit in (("time_days", "times_days", times_days, "d"),
                                       ("separation_px", "separations", separations, ""),
                                       ("position_angle_deg", "position_angles", position_angles, "deg")):
        numbers = plain(name, values, unit)
        has_shape(name, numbers, (count,) if numbers.ndim else ())
        rows[member] = numbers
    pairs = plain("shifts", shifts)
    has_shape("shifts", pairs, (count, 2) if pairs.ndim == 2 else (2,))
    rows["x_px"], rows["y_px"] = pairs[..., 0], pairs[..., 1]
    if spreads is not None:
        if len(spreads) != count:
            raise ValueError(f"spreads: {len(spreads)}: must be {count}, one per frame")
        for i, spread in enumerate(spreads):
            made[i].spread = ctypes.pointer(spread.struct())
    return made


class Predictions:
    """Predictions of blocks of frames. count: number of frames, None if unknown; the others as those of predictions_of."""

    @staticmethod
    def lengths(times_days: ArrayLike, shifts: ArrayLike, separations: ArrayLike, position_angles: ArrayLike,
                spreads: typing.Sequence[Spread] | None = None) -> list[int | None]:
        """Returns the numbers of frames that arguments with a member per frame have; None for others."""
        return [length_of(times_days, 1), length_of(shifts, 2), length_of(separations, 1), length_of(position_angles, 1),
                None if spreads is None else len(spreads)]

    def __init__(self, count: int | None, *given: typing.Any):
        self._given, self._all = given, None if count is None else predictions_of(count, *given)

    def block(self, first: int, count: int) -> typing.Any:
        """Returns a pointer to the structs of `count` frames from the frame `first`."""
        structs, place = (self._all, first) if self._all is not None else (predictions_of(count, *self._given), 0)
        structs[place].struct_size = ctypes.sizeof(structs[place])
        return ctypes.byref(structs[place])


def structured(structs: typing.Any, units: Units = {}) -> Records:
    """The members of an array of structs, without struct_size and reserved ones. units: as of column_of()."""
    given = numpy.ctypeslib.as_array(structs)
    names = [name for name in given.dtype.names or () if name not in ("struct_size", "reserved")]
    made = numpy.empty(len(given), [(name, given.dtype[name]) for name in names])
    for name in names:
        made[name] = given[name]
    return records_of(made, OF_STRUCTS.get(structs._type_.__name__), units)


def joined(blocks: typing.Sequence[typing.Any], kind: type) -> Records:
    """The members of the structs of blocks, pairs of an array of structs and their number, in one array."""
    parts = [structured(structs)[:count] for structs, count in blocks] or [structured(array_of(kind, 0))[:0]]
    return records_of(numpy.concatenate(parts), OF_STRUCTS.get(kind.__name__), {})
