"""Dates, time scales, clock tables, on-target windows and units. Reference: include/toliman/ingest.h.

astropy is never imported: its objects are recognised by their attributes and converted by their own methods.
"""
from __future__ import annotations

import ctypes
import datetime
import os
import typing

import numpy
from numpy.typing import NDArray

from . import _raw
from ._arguments import file_name, in_unit, plain, refuse_lost, text
from ._library import check, check_asked, library
from ._log import log
from ._results import HeaderTime
from ._units import label_of
from ._words import number

_DAY = 86400 * 10**9  # ns
_MJD_1970, _JD_1970 = 40587, 2440587.5
_int64 = ctypes.POINTER(ctypes.c_int64)


@typing.overload
def parse_time(time: str | bytes | datetime.date | numpy.datetime64, format: str = "iso", scale: str = "utc") -> int: ...


@typing.overload
def parse_time(time: list[typing.Any] | tuple[typing.Any, ...] | NDArray[typing.Any], format: str = "iso",
               scale: str = "utc") -> NDArray[numpy.int64]: ...


def parse_time(time: typing.Any, format: str = "iso", scale: str = "utc") -> typing.Any:
    """Converts a time to TAI nanoseconds since 1970-01-01T00:00:00 TAI, text exact to the nanosecond; a list or an array
    of times to an array.

        Tracker(..., time_offset_ns=toliman.parse_time("2028-03-01"))

    time: text, datetime, datetime64, or Time of astropy in any scale. datetime and datetime64 are UTC: a datetime
    without time zone is taken as UTC, as numpy does, and one with a time zone is converted.
    format: of text, "iso" (2028-03-01T12:00:00, 2028-061 12:00:00+00:00), "mjd" or "jd". scale: "utc", "tai", "tt",
    "tdb" or "gps".
    """
    if isinstance(time, (str, bytes)):
        return _parse_text(time, format, scale)
    if _is_time(time):
        tai = tai_ns_of_time(time)
        return tai if tai.ndim else int(tai)
    dates = _datetimes(time)
    if dates is not None:
        if scale != "utc" or format != "iso":
            raise ValueError(f"format={format!r}, scale={scale!r}: must not be given for datetime, which is UTC")
        refuse_lost("time", time)
        tai = _tai_of_utc("time", dates)
        return tai if tai.ndim else int(tai)
    if not isinstance(time, (list, tuple, numpy.ndarray)):
        raise TypeError(f"time is a {type(time).__name__}: must be text, datetime, datetime64 or Time, or a "
                        "list of them")
    return numpy.array([parse_time(one, format, scale) for one in time], numpy.int64)


def _parse_text(time: str | bytes, format: str, scale: str) -> int:
    tai_ns = ctypes.c_int64()
    check(library.toliman_ingest_parse_time(
        text("time", time), number("format", format, "TOLIMAN_INGEST_FORMAT"),
        number("scale", scale, "TOLIMAN_INGEST_SCALE"), None, 0, ctypes.byref(tai_ns)))
    return tai_ns.value


def read_header(header: typing.Mapping[str, typing.Any]) -> HeaderTime:
    """Reads the time of the first frame from the keywords of a FITS header, a dict or astropy's Header. Leap seconds
    are those of ERFA. NotFoundError if the header has no time."""
    given = _raw.toliman_ingest_header()
    for name, kind in given._fields_:
        key = name.upper().replace("_", "-")
        value = header.get(key) if kind is ctypes.c_char_p else None
        if isinstance(value, (str, int, float)):  # astropy has an object for a keyword without value
            setattr(given, name, text(key, str(value)))
    found = _raw.toliman_ingest_header_time()
    check(library.toliman_ingest_read_header(ctypes.byref(given), None, 0, 0, ctypes.byref(found)))
    return HeaderTime._of(found)


def read_clock(path: str | os.PathLike[str]) -> NDArray[numpy.int64]:
    """Reads a clock table for Tracker(clock=...): lines camera_ns,tai_ns. Returns pairs [n][2]."""
    points = ctypes.c_size_t()
    no_log = ctypes.cast(0, _raw.toliman_log_fn)
    check_asked(library.toliman_ingest_read_clock(file_name(path), None, 0, ctypes.byref(points), no_log, None))
    clock = numpy.empty((points.value, 2), numpy.int64)
    check(library.toliman_ingest_read_clock(file_name(path), clock.ctypes.data_as(_int64), len(clock),
                                            ctypes.byref(points), log, None))
    return clock[:points.value]


def read_on_target(path: str | os.PathLike[str]) -> NDArray[numpy.int64]:
    """Reads a table of on-target windows. Returns start and end of each in TAI nanoseconds [n][2], for
    example for Sky.predict_mean(). Leap seconds are those of ERFA."""
    count = ctypes.c_size_t()
    check_asked(library.toliman_ingest_read_on_target(file_name(path), None, 0, None, 0, ctypes.byref(count)))
    windows = numpy.empty((count.value, 2), numpy.int64)
    check(library.toliman_ingest_read_on_target(file_name(path), None, 0, windows.ctypes.data_as(_int64), len(windows),
                                                ctypes.byref(count)))
    return windows[:count.value]


def plain_times(name: str, times: typing.Any) -> typing.Any:
    """Returns times without date or unit: datetime, numpy's datetime64 (both UTC) and astropy's Time as Modified Julian
    Days of TAI, a Quantity in days, anything else as it is."""
    if _is_time(times):
        return times.tai.mjd
    if hasattr(times, "unit") and hasattr(times, "to_value"):
        return in_unit(name, times, "d")
    dates = _datetimes(times)
    if dates is None:
        return times
    return mjd_of_utc(name, times)[0]


def times_of_series(name: str, times: typing.Any, time_unit_days: float) -> typing.Any:
    """Returns plain_times(); ValueError for dates and quantities, which are in days, if the times of a series are not."""
    made = plain_times(name, times)
    if time_unit_days != 1 and made is not times:
        raise ValueError(f"{name}: must be plain numbers in units of {time_unit_days:g} days, not dates or quantities")
    return made


def mjd_of_utc(name: str, times: typing.Any) -> tuple[typing.Any, NDArray[numpy.int64]]:
    """Returns datetimes as Modified Julian Days of TAI and as TAI nanoseconds. TypeError for anything else."""
    dates = _datetimes(times)
    if dates is None:
        raise TypeError(f"{name} is an array of {numpy.asarray(times).dtype}: must be numbers or dates")
    refuse_lost(name, times)
    tai = _tai_of_utc(name, dates)
    return _MJD_1970 + tai // _DAY + tai % _DAY / _DAY, tai


def _is_time(times: typing.Any) -> bool:
    """Whether an object is a Time of astropy."""
    return hasattr(times, "jd1") and hasattr(times, "mjd")


def tai_ns_of_time(times: typing.Any) -> NDArray[numpy.int64]:
    """Returns a Time of astropy as TAI nanoseconds, exact to its digits. ValueError for masked times."""
    if numpy.any(times.mask):
        raise ValueError("time has masked values: fill or remove them first")
    tai = times.tai
    halves = numpy.rint(2 * (tai.jd1 - _JD_1970)).astype(numpy.int64)  # jd1 is a whole number of half days
    rest = (tai.jd1 - _JD_1970 - halves / 2) + tai.jd2
    return halves * (_DAY // 2) + numpy.rint(rest * _DAY).astype(numpy.int64)


def tai_ns_of(name: str, times: typing.Any, zero_ns: int) -> NDArray[numpy.int64]:
    """Returns times as TAI nanoseconds: datetime, datetime64, astropy's Time; plain numbers and a Quantity are the time
    since zero_ns, numbers in days. ValueError for days beyond 10^6, which are rather nanoseconds."""
    dates = tai_ns_of_dates(name, times)
    if dates is not None:
        return dates
    days = plain(name, plain_times(name, times))
    if not (numpy.abs(days) < 1e6).all():  # NaN, too
        raise ValueError(f"{name}: must be days since time 0 of the scene, below 10^6, or dates")
    return zero_ns + numpy.rint(days * _DAY).astype(numpy.int64)


def tai_ns_of_dates(name: str, times: typing.Any) -> NDArray[numpy.int64] | None:
    """Returns Time, datetime and datetime64 as TAI nanoseconds; None for anything else."""
    if _is_time(times):
        return tai_ns_of_time(times)
    dates = None if unit_of(times) is not None else _datetimes(times)
    if dates is None:
        return None
    refuse_lost(name, times)
    return _tai_of_utc(name, dates)


def days_of(name: str, times: typing.Any, zero_ns: int) -> typing.Any:
    """Returns dates as days since zero_ns, anything else as it is."""
    dates = tai_ns_of_dates(name, times)
    return times if dates is None else (dates - zero_ns) / _DAY


def _datetimes(times: typing.Any) -> NDArray[numpy.datetime64] | None:
    """Returns datetime and datetime64, also in lists, arrays and columns, as datetime64 of UTC; None for other values."""
    if getattr(getattr(times, "dtype", None), "kind", "") == "M":
        array = numpy.asarray(times)
        return array if array.dtype.kind == "M" else _datetimes(array)  # pandas has a type with a time zone
    if isinstance(times, datetime.date):
        return numpy.asarray(_datetime64(times))
    first = times[0] if isinstance(times, (list, tuple)) and times else None
    if isinstance(times, numpy.ndarray) and times.dtype == object and times.size > 0:
        first = times.flat[0]
    if isinstance(first, numpy.datetime64):
        return numpy.asarray(times)
    if not isinstance(first, datetime.date):
        return None
    array = numpy.empty(len(times) if isinstance(times, (list, tuple)) else times.shape, object)
    array[...] = times
    return numpy.array([_datetime64(one) for one in array.flat], "M8[ns]").reshape(array.shape)


def _datetime64(time: typing.Any) -> numpy.datetime64:
    if hasattr(time, "to_datetime64"):  # of pandas, to the nanosecond
        return typing.cast(numpy.datetime64, time.to_datetime64())
    if isinstance(time, datetime.datetime) and time.tzinfo is not None:
        time = time.astimezone(datetime.timezone.utc).replace(tzinfo=None)
    if not isinstance(time, (datetime.date, numpy.datetime64)):
        raise TypeError(f"a list of datetime contains a {type(time).__name__}: must be datetime")
    return numpy.datetime64(time)


def _tai_of_utc(name: str, times: NDArray[numpy.datetime64]) -> NDArray[numpy.int64]:
    """Returns nanoseconds of TAI."""
    years = times.astype("M8[Y]").astype(numpy.int64) + 1970
    if numpy.isnat(times).any() or ((years < 1972) | (years > 2099)).any():
        raise ValueError(f"{name} has NaT, or a date before 1972 or after 2099")
    ns = numpy.require(times.astype("M8[ns]").astype(numpy.int64), requirements=["C", "A"])
    tai = numpy.empty_like(ns)
    check(library.toliman_ingest_convert_times(ns.ctypes.data_as(_int64), ns.size, _raw.TOLIMAN_INGEST_SCALE_UTC, None,
                                               0, tai.ctypes.data_as(_int64)))
    return tai


def unit_of_ns(unit_ns: float) -> str:
    """Returns a unit of time in the notation of astropy, "" if it has no name."""
    return {86400e9: "d", 3600e9: "h", 60e9: "min", 1e9: "s"}.get(unit_ns, "")


def name_of_unit(unit_ns: float) -> str:
    """Returns the name of a unit of time, for labels; 0: not known."""
    return label_of(unit_of_ns(unit_ns), f"units of {unit_ns / 1e9:g} s" if unit_ns else "units of t")


def unit_of(values: typing.Any) -> typing.Any:
    """Returns the unit of a Quantity, or None."""
    return getattr(values, "unit", None) if hasattr(values, "to_value") else None


def plain_values(name: str, values: typing.Any, unit: typing.Any) -> typing.Any:
    """Returns values as numbers in `unit`; None: values without unit, a Quantity is left to be refused."""
    if unit is None or values is None:
        return values
    if unit_of(values) is None:
        raise TypeError(f"{name} has no unit: must be a Quantity, as the values are in {unit}")
    return values.to_value(unit)
