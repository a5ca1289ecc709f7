"""Dates, time scales, clock tables, on-target windows and units. Reference: include/toliman/ingest.h.

astropy is never imported: its objects are recognised by their attributes and converted by their own methods.
"""
from __future__ import annotations

import ctypes
import os
import typing

import numpy
from numpy.typing import NDArray

from . import _raw
from ._arguments import file_name, refuse_lost, text
from ._library import check, library
from ._log import log
from ._results import HeaderTime
from ._words import number

_DAY = 86400 * 10**9  # ns
_MJD_1970 = 40587
_int64 = ctypes.POINTER(ctypes.c_int64)


def parse_time(time: str, format: str = "iso", scale: str = "utc") -> int:
    """Converts a time in text to TAI nanoseconds since 1970-01-01T00:00:00 TAI, exact to the nanosecond.

        Tracker(..., time_offset_ns=toliman.parse_time("2028-03-01"))

    format: "iso" (2028-03-01T12:00:00), "mjd" or "jd". scale: "utc", "tai", "tt", "tdb" or "gps".
    """
    tai_ns = ctypes.c_int64()
    check(library.toliman_ingest_parse_time(
        text("time", time), number("format", format, "TOLIMAN_INGEST_FORMAT"),
        number("scale", scale, "TOLIMAN_INGEST_SCALE"), None, 0, ctypes.byref(tai_ns)))
    return tai_ns.value


def read_header(header: typing.Mapping[str, typing.Any]) -> HeaderTime:
    """Reads the time of the first frame from the keywords of a FITS header, a dict or astropy's Header. Leap seconds
    are those of ERFA. NotFoundError if the header has no time."""
    given = _raw.toliman_ingest_header()
    for key in ("TIMESYS", "MJD-AVG", "DATE-AVG", "MJD-BEG", "MJD-OBS", "DATE-OBS", "XPOSURE", "EXPTIME"):
        value = header.get(key)
        if isinstance(value, (str, int, float)):  # astropy has an object for a keyword without value
            setattr(given, key.lower().replace("-", "_"), text(key, str(value)))
    found = _raw.toliman_ingest_header_time()
    check(library.toliman_ingest_read_header(ctypes.byref(given), None, 0, 0, ctypes.byref(found)))
    return HeaderTime._of(found)


def read_clock(path: str | os.PathLike[str]) -> NDArray[numpy.int64]:
    """Reads a clock table for Tracker(clock=...): lines camera_ns,tai_ns. Returns pairs [n][2]."""
    points = ctypes.c_size_t()
    no_log = ctypes.cast(0, _raw.toliman_log_fn)
    check(library.toliman_ingest_read_clock(file_name(path), None, 0, ctypes.byref(points), no_log, None))
    clock = numpy.empty((points.value, 2), numpy.int64)
    check(library.toliman_ingest_read_clock(file_name(path), clock.ctypes.data_as(_int64), len(clock),
                                            ctypes.byref(points), log, None))
    return clock[:points.value]


def read_on_target(path: str | os.PathLike[str]) -> NDArray[numpy.int64]:
    """Reads a table of on-target windows. Returns start and end of each in TAI nanoseconds [n][2], for
    example for Sky.predict_mean(). Leap seconds are those of ERFA."""
    count = ctypes.c_size_t()
    check(library.toliman_ingest_read_on_target(file_name(path), None, 0, None, 0, ctypes.byref(count)))
    windows = numpy.empty((count.value, 2), numpy.int64)
    check(library.toliman_ingest_read_on_target(file_name(path), None, 0, windows.ctypes.data_as(_int64), len(windows),
                                                ctypes.byref(count)))
    return windows[:count.value]


def plain_times(name: str, times: typing.Any) -> typing.Any:
    """Returns times without date or unit: numpy's datetime64 (UTC) and astropy's Time as Modified Julian Days of TAI,
    a Quantity in days, anything else as it is."""
    if hasattr(times, "jd1") and hasattr(times, "mjd"):
        return times.tai.mjd
    if hasattr(times, "unit") and hasattr(times, "to_value"):
        return times.to_value("d")
    if isinstance(times, (list, tuple)) and times and isinstance(times[0], numpy.datetime64):
        times = numpy.asarray(times)
    if getattr(getattr(times, "dtype", None), "kind", "") != "M":
        return times
    refuse_lost(name, times)
    return _mjd_of_utc(name, numpy.asarray(times))


def _mjd_of_utc(name: str, times: NDArray[numpy.datetime64]) -> typing.Any:
    years = times.astype("M8[Y]").astype(numpy.int64) + 1970
    if numpy.isnat(times).any() or ((years < 1972) | (years > 2099)).any():
        raise ValueError(f"{name} has NaT, or a date before 1972 or after 2099")
    ns = numpy.require(times.astype("M8[ns]").astype(numpy.int64), requirements=["C", "A"])
    tai = numpy.empty_like(ns)
    check(library.toliman_ingest_convert_times(ns.ctypes.data_as(_int64), ns.size, _raw.TOLIMAN_INGEST_SCALE_UTC, None,
                                               0, tai.ctypes.data_as(_int64)))
    return _MJD_1970 + tai // _DAY + tai % _DAY / _DAY


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
