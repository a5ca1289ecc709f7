"""A series of measurements for every step from the frames to the planets. Reference: include/toliman/measure.h."""
from __future__ import annotations

import ctypes
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import (INT64, Doubles, file_name, listed, options_of, plain, pointer, real, refuse_lost, shaped, text,
                         whole)
from ._handle import Handle
from ._library import check, library
from ._log import log
from ._plots import Axes, plots
from ._results import Instrument, MeasureFunction, MeasureInfo
from ._series_table import (columns_of_series, factor_of, facts_of_series, labels_of, number_of_unit, series_of_table,
                            table_at, units_of)
from ._table import Column, Rows, Tabular, Units
from .times import plain_values, tai_ns_of, tai_ns_of_dates, times_of_series, unit_of

KINDS = ("value", "separation", "reduced", "velocity")
_FORMATS = {"": 0, "iso": _raw.TOLIMAN_INGEST_FORMAT_ISO, "mjd": _raw.TOLIMAN_INGEST_FORMAT_MJD,
            "jd": _raw.TOLIMAN_INGEST_FORMAT_JD, "days": 0}
_SCALES = {"": 0, "utc": _raw.TOLIMAN_INGEST_SCALE_UTC, "tai": _raw.TOLIMAN_INGEST_SCALE_TAI,
           "tt": _raw.TOLIMAN_INGEST_SCALE_TT, "tdb": _raw.TOLIMAN_INGEST_SCALE_TDB, "gps": _raw.TOLIMAN_INGEST_SCALE_GPS}
_int64 = ctypes.POINTER(ctypes.c_int64)
_size = ctypes.POINTER(ctypes.c_size_t)


def nanoseconds(name: str, values: ArrayLike) -> NDArray[numpy.int64]:
    """Returns times as int64, also Time, datetime and datetime64. Days are refused: numpy would truncate them."""
    dates = tai_ns_of_dates(name, values)
    if dates is not None:
        return dates
    refuse_lost(name, values)
    array = numpy.asarray(values)
    if array.dtype.kind not in "iu" and array.size > 0:
        raise TypeError(f"{name} is an array of {array.dtype}: must be integers, nanoseconds of TAI (parse_time)")
    if array.dtype.kind == "u" and array.size > 0 and int(array.max()) >= INT64:
        raise ValueError(f"{name} = {int(array.max())}: must be below 2^63")
    return numpy.require(array, numpy.int64, "C")


class Exposures:
    """Intervals of measurements: times [n], pairs of start and end [n][2], or a sequence of n arrays [intervals][2].

    on_target: whether they are on-target intervals. None: only if each measurement has an array [intervals][2]."""

    def __init__(self, tai_ns: typing.Any, on_target: bool | None):
        dates = tai_ns_of_dates("tai_ns", tai_ns)
        tai_ns = tai_ns if dates is None else dates
        refuse_lost("tai_ns", tai_ns)
        given = tai_ns if isinstance(tai_ns, (list, tuple)) else numpy.asarray(tai_ns)
        are_lists = {numpy.ndim(one) > 1 for one in given}
        if on_target is None and len(are_lists) > 1:
            raise ValueError("tai_ns: must be a time or a pair for each measurement, or an array [intervals][2] for each")
        pairs = [nanoseconds("tai_ns", [one, one] if numpy.ndim(one) == 0 else one).reshape(-1, 2) for one in given]
        is_known = True in are_lists if on_target is None else on_target
        if not is_known and any(len(pair) != 1 for pair in pairs):
            raise ValueError("on_target=False: must have one interval for each measurement")
        self.count = len(pairs)
        self._lengths = (ctypes.c_size_t * len(pairs))(*(len(pair) for pair in pairs))
        self.counts = ctypes.cast(self._lengths, _size) if is_known else None
        self._pairs = numpy.ascontiguousarray(numpy.concatenate([*pairs, numpy.empty((0, 2), numpy.int64)]))
        self.intervals = self._pairs.ctypes.data_as(_int64)


def _word(name: str, value: str, words: typing.Iterable[str]) -> str:
    if value not in words:
        raise ValueError(f"{name} = {value!r}: must be one of {', '.join(repr(word) for word in words if word)}")
    return value


class Measurements(Handle, Tabular):
    """A series of separations, or of other values, from the frames to the planets.

        measured = Measurements("state", kind="separation")     # a state folder of `toliman track`, or a text file
        better, fit = Sky("alpha-cen", "spacecraft.oem").refit(measured)
        found = planets(Measurements("state"))                  # its reduced separations, with the errors of the orbit

    source: path of a file, a table or JSON or .npy, or of a state folder; bytes: the content of such a file. astropy
        reads .fits, and .ecsv that to_table().write() of a series made, as of_table().
    kind: "value", "separation" (as they were measured), "reduced" (to the orbit) or "velocity"; "": of a state folder,
        "reduced" where its frames are; otherwise "velocity" if the file states such a unit, or "value".
    columns: names, or numbers from 1, of two or three columns of a file; time_format: "iso", "mjd", "jd" or "days"; time_scale: "utc", "tai",
        "tt", "tdb" or "gps"; "": as series.h says. Columns of dates of a table of astropy have both; its other
        columns are dates only with a time_format.
    unit: arcsec (velocities: m/s) per unit of the values; 0: that which a file states, and the plate scale of a state
        folder; otherwise unknown, but 1 for separations.
    exposure_s: length of each exposure of a file, whose middle is its time; 0: not known.
    instrument: name or number of the column of a file that names the instrument of each sample; "": one instrument.
    functions: path of a CSV table, t,NAME,... with a row for each sample of a file: columns, as of add_column.
    """

    _kind, _destroy = _raw.toliman_measure, "toliman_measure_destroy"
    _has_dates, _value_unit = False, None  # of arrays, as they were given
    _of_frames = False  # separations are in pixels

    def __init__(self, source: str | os.PathLike[str] | bytes, *, kind: str = "", columns: str = "", time_format: str = "",
                 time_scale: str = "", unit: float = 0, exposure_s: float = 0, instrument: str = "",
                 functions: str | os.PathLike[str] = ""):
        format_of, scale_of = (_word("time_format", time_format, _FORMATS), _word("time_scale", time_scale, _SCALES))
        table = table_at(source)
        if table is not None:
            if functions:
                raise ValueError("functions: must not be given with a table of astropy: use add_column()")
            made = series_of_table(type(self), table, columns, kind, unit, exposure_s, instrument, time_format,
                                   time_scale)
            super().__init__(made._c)
            return
        options = options_of(
            _raw.toliman_measure_options, kind=_number_of(kind),
            columns=text("columns", columns) if columns else None,
            instrument=text("instrument", instrument) if instrument else None,
            functions=file_name(functions) if functions else None,
            time_format=_FORMATS[format_of], time_scale=_SCALES[scale_of],
            flags=_raw.TOLIMAN_SERIES_PLAIN_TIMES if time_format == "days" else 0, unit=number_of_unit(unit, kind),
            exposure_s=real("exposure_s", exposure_s), log=log)
        if isinstance(source, bytes):
            super().__init__(self._create(library.toliman_measure_load, source, len(source), None, ctypes.byref(options)))
        else:
            super().__init__(self._create(library.toliman_measure_load_file, file_name(source), ctypes.byref(options)))
            self._of_frames = os.path.isdir(source)

    @classmethod
    def _of_tracker(cls, tracker: typing.Any, kind: str, unit: float) -> Measurements:
        options = options_of(_raw.toliman_measure_options, kind=_number_of(kind),
                             unit=real("unit", unit), log=log)
        made = cls._adopt(cls._create(library.toliman_track_get_measure, tracker, ctypes.byref(options)))
        made._of_frames = True
        return made

    @classmethod
    def of(cls, t: ArrayLike | None, y: ArrayLike, sigma: ArrayLike | None = None, *, kind: str = "value",
           exposures: typing.Any = None, on_target: bool | None = None, position_angle_deg: ArrayLike | None = None,
           unit: typing.Any = 0, time_unit_days: float = 1, frame_chi_square: float = 0) -> Measurements:
        """A series of arrays of equal length; y and sigma may be one number for all.

        t: times; None with exposures: their middles, Modified Julian Days of TAI.
        exposures: TAI ns, start and end of each, [n][2], or its on-target intervals, a sequence of n arrays
            [intervals][2]; times [n] for the Earth's centre only. on_target: whether the telescope pointed at the stars
            in all of them; None: True for arrays [intervals][2].
        unit: of the values: arcsec (velocities: m/s) per unit, or a unit of astropy; 0: not known.
        """
        plain_t = None if t is None else times_of_series("t", t, time_unit_days)
        has_dates = plain_t is not t and unit_of(t) is None
        if has_dates and exposures is None:  # instants, which stay dates
            plain_t, exposures = None, numpy.atleast_1d(tai_ns_of("t", t, 0))
        given = None if exposures is None else Exposures(exposures, on_target)
        times = None if plain_t is None else plain("t", plain_t)
        count = len(times) if times is not None else given.count if given is not None else 0
        value_unit = unit_of(y)
        unit = factor_of("y", value_unit, number_of_unit(unit, kind), kind)
        values, sigmas = (None if one is None else numpy.ascontiguousarray(
            numpy.broadcast_to(plain(name, plain_values(name, one, value_unit)), count)) for name, one in
            (("y", y), ("sigma", sigma)))
        if times is not None and (times.ndim != 1 or (given is not None and given.count != count)):
            raise ValueError("t, y, sigma, exposures: must be one-dimensional and of equal length")
        angles = None if position_angle_deg is None else shaped("position_angle_deg", position_angle_deg, (count,))
        data = options_of(
            _raw.toliman_measure_data, kind=_number_of(kind), n=count,
            t=pointer(times), y=pointer(values), sigma=pointer(sigmas), position_angle_deg=pointer(angles),
            intervals=None if given is None else given.intervals,
            interval_counts=None if given is None else given.counts, unit=real("unit", unit),
            time_unit_days=real("time_unit_days", time_unit_days),
            frame_chi_square=real("frame_chi_square", frame_chi_square))
        made = cls._adopt(cls._create(library.toliman_measure_create, ctypes.byref(data)))
        return made._knows(has_dates, value_unit)

    def _knows(self, has_dates: bool, value_unit: typing.Any) -> Measurements:
        """Sets what the library does not keep of arrays: whether the times are dates, and the unit of the values, which
        may be None."""
        self._has_dates, self._value_unit = has_dates, value_unit
        return self

    @classmethod
    def of_table(cls, table: typing.Any, *, columns: str = "", kind: str = "", unit: float = 0, exposure_s: float = 0,
                 instrument: str = "") -> Measurements:
        """A series of a Table of astropy or a DataFrame of pandas.

        columns: names of two or three columns: times, values, sigmas; "": "t,y,sigma", or "t,y" without that. Sigmas
            have a unit if the values have one, to which they are converted. Columns of Time and of datetime64 (UTC) are dates, which become
            Modified Julian Days of TAI; other times are plain numbers, of a column with a unit in days.
        kind: as of Measurements(); "": that of a table made by to_table(), or "velocity" for a unit of velocity,
            otherwise "value".
        unit: arcsec (velocities: m/s) per unit of the values, if the column has no unit; 0: not known.
        exposure_s: length of each exposure, whose middle is its date; 0: not known.
        instrument: name of the column of instruments.
        Functions are those of a table made by to_table(). TypeError for units of anything else; ValueError for columns
        that are missing or have masked or missing values."""
        return series_of_table(cls, table, columns, kind, unit, exposure_s, instrument)

    @property
    def info(self) -> MeasureInfo:
        """Kind, number of samples and functions, unit, and what is known of the system."""
        return self._read(library.toliman_measure_get_info, _raw.toliman_measure_info, MeasureInfo)

    @property
    def kind(self) -> str:
        """What the values are: "value", "separation", "reduced" or "velocity"."""
        return library.toliman_constant_name(self.info.kind).decode()

    def __len__(self) -> int:
        return self.info.n

    @property
    def functions(self) -> Rows[MeasureFunction]:
        """The functions that are fitted with the mean: those of a trend, then columns."""
        found: Rows[MeasureFunction] = Rows()
        for index in range(self.info.functions):
            function = _raw.toliman_measure_function()
            check(library.toliman_measure_get_function(self._c, index, ctypes.byref(function)))
            found.append(MeasureFunction._of(function))
        return found

    def values(self, name: str) -> Doubles:
        """Returns one number for each sample: "t", "y", "sigma", "position_angle_deg", "instrument", a function, and of
        reduced separations "separation_arcsec", "factor" and "geometric_arcsec". Raises NotFoundError for others."""
        values = numpy.empty(len(self))
        if values.size == 0 and name in ("t", "y"):  # of which the library has none
            return values
        check(library.toliman_measure_get_values(self._c, text("name", name), pointer(values), len(values)))
        return values

    @property
    def t(self) -> Doubles:
        """Times: plain numbers, or Modified Julian Days."""
        return self.values("t")

    @property
    def y(self) -> Doubles:
        """Values."""
        return self.values("y")

    @property
    def sigma(self) -> Doubles | None:
        """Standard deviations; None: not known."""
        return self.values("sigma") if self.info.is_weighted else None

    @property
    def tai_ns(self) -> NDArray[numpy.int64]:
        """The times in TAI, ns since 1970-01-01T00:00:00 TAI. Raises InputError for plain numbers."""
        times = numpy.empty(len(self), numpy.int64)
        check(library.toliman_measure_get_times(self._c, times.ctypes.data_as(_int64), len(times)))
        return times

    def set_trend(self, order: int, span: tuple[typing.Any, typing.Any] | None = None) -> Measurements:
        """Fits the polynomials T_1 ... T_order of the time with the mean. span: None is that of the times."""
        start, end = (0.0, 0.0) if span is None else (
            real("span", times_of_series("span", one, self.info.time_unit_days)) for one in span)
        check(library.toliman_measure_set_trend(self._c, whole("order", order, 2**31), start, end))
        return self

    def add_column(self, name: str, values: ArrayLike, sigma: float = 0) -> Measurements:
        """Fits the values of a column with the mean. sigma: standard deviation of the prior of its coefficient; 0:
        none."""
        given = plain("values", values)
        check(library.toliman_measure_add_column(self._c, text("name", name), pointer(given), given.size,
                                                 real("sigma", sigma)))
        return self

    def set_instruments(self, names: typing.Sequence[str]) -> Measurements:
        """Sets the instrument of each sample by its name: each has an offset, and a jitter in searches for planets."""
        known = list(dict.fromkeys(names))
        wrong = [name for name in known if not name or "," in name or len(name.split()) > 1 or name != name.strip()]
        if wrong:
            raise ValueError(f"names: {wrong[0]!r}: must not be empty or have spaces or commas")
        indices = (ctypes.c_int64 * len(names))(*(known.index(name) for name in names))
        check(library.toliman_measure_set_instruments(self._c, text("names", ",".join(known) + ","), indices,
                                                      len(names)))
        return self

    @property
    def instruments(self) -> Rows[Instrument]:
        """Offset, jitter and chi_square of each instrument in a fit of mean and functions without a planet."""
        units = self._units
        return Rows(Instrument._of(one, units) for one in listed(_raw.toliman_measure_instrument,
                                                                 library.toliman_measure_query_instruments, self._c))

    def set_prior(self, function: int, sigma: float) -> Measurements:
        """Sets the standard deviation of the prior of the coefficient of a function; 0: none."""
        check(library.toliman_measure_set_prior(self._c, whole("function", function), real("sigma", sigma)))
        return self

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the values over time with their standard deviations, each instrument in a colour of its own. Of more
        than 3000 samples it draws every n-th.

        ax: Axes to draw into, in their style; None: a new figure of pyplot."""
        return plots().measurements(self, ax)

    def _time_label(self) -> str:
        """Unit of the times, for labels."""
        return labels_of(self)[0]

    def _value_label(self) -> str:
        """Unit of the values, for labels."""
        return labels_of(self)[1]

    @property
    def _units(self) -> Units:
        return units_of(self)

    def _columns(self) -> dict[str, Column]:
        return columns_of_series(self)

    def _facts(self) -> dict[str, typing.Any]:
        return facts_of_series(self)

    def _summary(self) -> str:
        unit, functions = self._units["y"], self.info.functions
        return (f"Measurements: {len(self)} of kind {self.kind}" + (f" in {unit}" if unit else "")
                + (f", {functions} functions" if functions else ""))


def _number_of(kind: str) -> int:
    return 0 if kind == "" else _raw.TOLIMAN_MEASURE_VALUE + KINDS.index(_word("kind", kind, KINDS))


def with_functions(series: Measurements, trend: int, span: typing.Any, rows: ArrayLike | None,
                   priors: ArrayLike | None) -> Measurements:
    """Adds a trend and columns; priors: standard deviations of the mean, the trend and the columns, infinity for none."""
    if whole("trend", trend, 2**31):
        series.set_trend(trend, span)
    if rows is not None:
        for place, column in enumerate(shaped("rows", rows, (len(series), -1)).T):
            series.add_column(f"column {place + 1}", column)
    if priors is None:
        return series
    deviations = shaped("priors", priors, (1 + series.info.functions,))
    if not (deviations > 0).all():
        raise ValueError("priors: must be above 0; infinity for a free coefficient")
    if deviations[0] != numpy.inf:
        raise ValueError(f"priors[0] = {deviations[0]}: must be infinity, as the mean has no prior")
    for function, sigma in enumerate(deviations[1:]):
        series.set_prior(function, 0 if sigma == numpy.inf else float(sigma))
    return series
