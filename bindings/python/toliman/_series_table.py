"""Converts series of measurements to tables, and tables of astropy and pandas to series."""
from __future__ import annotations

import math
import os
import typing

import numpy

from . import _raw
from ._arguments import Doubles, plain, real
from ._library import NotFoundError
from ._optional import optional
from ._table import Column, Units, column_of
from ._units import label_of
from ._words import words
from .times import mjd_of_utc, tai_ns_of_time

if typing.TYPE_CHECKING:
    from ._results import MeasureInfo
    from .measure import Measurements

_UNITS = {"uas": "uarcsec", "px": "pix"}  # astropy's names of the library's
_ANGLES = {1.0: "arcsec", 1e-3: "mas", 1e-6: "uarcsec", 3600.0: "deg"}
_SPEEDS = {1.0: "m / s", 1e3: "km / s", 1e-2: "cm / s"}
_COLUMNS = {"position_angle_deg": "of B from A", "separation_arcsec": "as measured",
            "factor": "measured separation over that on the orbit", "geometric_arcsec": "separation on the orbit"}
_OF_FITS = (".fits", ".fit", ".fits.gz")


def _value_unit_of(series: Measurements, info: MeasureInfo) -> str:
    """Returns the unit of y in the notation of astropy, "" if it has no name."""
    if info.unit_name or series._value_unit is not None:
        return _UNITS.get(info.unit_name, info.unit_name) or str(series._value_unit)
    if info.kind == _raw.TOLIMAN_MEASURE_VELOCITY:
        return _SPEEDS.get(info.unit, "")
    is_separation = info.kind in (_raw.TOLIMAN_MEASURE_SEPARATION, _raw.TOLIMAN_MEASURE_REDUCED)
    return "pix" if series._of_frames and is_separation else _ANGLES.get(info.unit, "")


def units_of(series: Measurements) -> Units:
    """Returns the units of times and values, "" if they have no name, and the scale of dates."""
    info = series.info
    scale = "tai" if series._has_dates else words("TOLIMAN_INGEST_SCALE").get(info.time_scale, "")
    return {"t": "d" if info.time_unit_days == 1 else "", "y": _value_unit_of(series, info),
            "date": "tai" if scale == "utc" else scale}


def labels_of(series: Measurements) -> tuple[str, str]:
    """Returns the units of times and values for plots."""
    info, units = series.info, units_of(series)
    base = "m/s" if info.kind == _raw.TOLIMAN_MEASURE_VELOCITY else "arcsec"
    times = f"MJD ({units['date'].upper()})" if units["date"] else label_of(
        units["t"], f"units of {info.time_unit_days:g} days")
    return times, label_of(units["y"], f"units of {info.unit:g} {base}" if info.unit else "units of y")


def columns_of_series(series: Measurements) -> dict[str, Column]:
    """Returns times, values, sigmas, what is known of the samples, and the functions."""
    info, units = series.info, series._units
    found = {"t": column_of("t", series.t, "", units), "y": column_of("y", series.y, "", units)}
    if info.is_weighted:
        found["sigma"] = column_of("sigma", series.sigma, "standard deviation of y", units)
    for name, doc in _COLUMNS.items():
        try:
            found[name] = column_of(name, series.values(name), doc, units)
        except NotFoundError:
            pass
    if info.instruments > 0:
        names = numpy.array(info.instrument_names.strip(",").split(","))
        found["instrument"] = Column(names[series.values("instrument").astype(int)])
    for function in series.functions:
        found[function.name] = Column(series.values(function.name), "", "function that is fitted with the mean")
    return found


def facts_of_series(series: Measurements) -> dict[str, typing.Any]:
    """Returns what a table needs to become the series again. t_scale: that of t_first and t_last, if they are dates."""
    info = series.info
    facts: dict[str, typing.Any] = {"kind": series.kind, "unit": info.unit or None, "source": info.name}
    if info.time_unit_days != 1:
        facts["unit_d"] = info.time_unit_days
    if info.frame_chi_square > 0:
        facts["chi2"] = info.frame_chi_square
    if info.is_refitted:
        facts["refitted"] = True
    if info.trend > 0:
        facts.update(trend=info.trend, t_first=info.trend_start, t_last=info.trend_end, t_scale=series._units["date"])
    for place, function in enumerate(series.functions, 1):
        facts.update({f"fn{place}": function.name, f"prior{place}": function.sigma})
    return facts


class SeriesTable:
    """The columns of a table by name, and what it says of them. table: of astropy, or a DataFrame of pandas."""

    def __init__(self, table: typing.Any):
        is_frame = hasattr(table, "attrs") and hasattr(table, "columns")
        if not is_frame and not hasattr(table, "colnames"):
            raise TypeError(f"table is a {type(table).__name__}: must be a Table of astropy or a DataFrame of pandas")
        self._table, self._is_frame = table, is_frame
        self.names = [str(name) for name in (table.columns if is_frame else table.colnames)]
        facts = {str(name).lower(): value for name, value in (table.attrs if is_frame else table.meta).items()}
        units = facts.get("units") if is_frame else None
        self._units = units if isinstance(units, dict) else {}
        self.facts = facts if facts.get("object") == "Measurements" else {}  # others have names of their own

    def _given(self, name: str) -> typing.Any:
        if name not in self.names:
            raise ValueError(f"{name} is not a column: the table has {', '.join(self.names)}; give "
                             'columns="T,Y,SIGMA"')
        return self._table[name]

    def column(self, name: str) -> typing.Any:
        """Returns the values of a column: an array without missing values, or a Time."""
        given = self._given(name)
        missing = given.isna() if self._is_frame else getattr(given, "mask", numpy.zeros(0, bool))
        if self._is_frame:
            given = _array_of_pandas(given, bool(numpy.any(missing)))
        elif not hasattr(given, "jd1"):
            given = numpy.asarray(numpy.ma.getdata(given))
        if not hasattr(given, "jd1") and numpy.asarray(given).dtype.kind == "f":
            missing = numpy.isnan(given) if numpy.size(missing) == 0 else missing | numpy.isnan(given)
        if numpy.any(missing):
            raise ValueError(f"{name} has {int(numpy.sum(missing))} missing or masked values: remove these rows first")
        return given

    def unit(self, name: str) -> typing.Any:
        """Returns the unit of a column, None without one."""
        given = self._given(name)
        stated = self._units.get(name) if self._is_frame else getattr(given, "unit", None)
        return optional("astropy.units", "units of tables").Unit(stated) if stated else None

    def times(self, name: str, time_format: str, time_scale: str) -> tuple[Doubles, typing.Any]:
        """Returns the times as Modified Julian Days or plain numbers, and the dates as TAI ns or None."""
        values, unit = self.column(name), self.unit(name)
        scale = self.facts.get("scales", {}).get(name, "") if self._is_frame else ""
        kind = numpy.asarray(values).dtype.kind if not hasattr(values, "jd1") else ""
        _check_dates(name, values, time_format, time_scale)
        if (scale and not time_format) or time_format in ("mjd", "jd", "iso"):
            values = _dates(values, time_format or "mjd", time_scale or scale or "utc")
        elif kind in ("M", "O"):
            values = mjd_of_utc(name, values)
            return plain(name, values[0]), values[1]
        if hasattr(values, "jd1"):
            return plain(name, values.tai.mjd), tai_ns_of_time(values)
        if unit is None:
            return plain(name, values), None
        return plain(name, _converted(name, values, unit, "d")), None

    def values(self, name: str, sigma: str) -> tuple[Doubles, Doubles | None, typing.Any]:
        """Returns values and sigmas in the unit of the values, and that unit, None without one."""
        unit, sigmas = self.unit(name), None
        if sigma:
            sigmas, other = self.column(sigma), self.unit(sigma)
            if (other is None) != (unit is None):
                without, one, given = (sigma, name, unit) if other is None else (name, sigma, other)
                raise TypeError(f"{without} has no unit: must have one, as {one} is in {given}")
            if other is not None:
                sigmas = _converted(sigma, sigmas, other, unit)
        return plain(name, self.column(name)), None if sigmas is None else plain(sigma, sigmas), unit


def _dates(values: typing.Any, time_format: str, scale: str) -> typing.Any:
    """Returns times in a format and scale of the library as Time."""
    times = optional("astropy.time", "dates of tables")
    made = times.Time(values, format=None if time_format == "iso" else time_format, scale="tai" if scale == "gps" else scale)
    return made + times.TimeDelta(19, format="sec") if scale == "gps" else made


def _array_of_pandas(column: typing.Any, has_missing: bool) -> typing.Any:
    """Returns an array of a column, also of numbers of the types of pandas that may be missing."""
    is_own = getattr(column.dtype, "kind", "") in ("b", "i", "u", "f") and not isinstance(column.dtype, numpy.dtype)
    return column.to_numpy() if has_missing or not is_own else column.to_numpy(column.dtype.numpy_dtype)


def _check_dates(name: str, values: typing.Any, time_format: str, time_scale: str) -> None:
    """Raises ValueError for a format or scale that contradicts a column or would not be used."""
    given = f"time_format = {time_format!r}" if time_format else f"time_scale = {time_scale!r}"
    if hasattr(values, "jd1") and (time_format or time_scale):
        raise ValueError(f"{given}: must not be given, as {name} has dates in {values.scale.upper()}")
    if time_scale and time_format in ("", "days"):
        raise ValueError(f'time_scale = {time_scale!r}: must be given with time_format "iso", "mjd" or "jd", as the '
                         f"column {name} does not say that it has dates")


def is_velocity(unit: typing.Any) -> bool:
    """Whether a unit of values, which may be None, is one of velocity."""
    return unit is not None and unit.is_equivalent("m / s")


def number_of_unit(unit: typing.Any, kind: str) -> float:
    """Returns the argument `unit`: a number, or a unit of astropy or its name, as arcsec or m/s per unit."""
    if not isinstance(unit, str) and not hasattr(unit, "to"):
        return real("unit", unit)
    try:
        given = optional("astropy.units", "a unit that is not a number").Unit(unit)
        return float(given.to("m / s" if kind == "velocity" else "arcsec"))
    except ValueError as error:  # UnitConversionError of astropy, too
        raise ValueError(f"unit = {unit}: must be {'a velocity' if kind == 'velocity' else 'an angle'}, or a number") from error


def factor_of(name: str, given: typing.Any, unit: float, kind: str) -> float:
    """Returns the arcsec or m/s per unit of values whose unit is `given`, None: not known; the argument `unit`, 0: not
    given, must agree. TypeError for a unit that no values of this kind have."""
    if given is None or given.is_equivalent("") or given.is_equivalent("pix"):
        return unit
    known = next((one for one in ("arcsec", "m / s") if given.is_equivalent(one)), None)
    if kind != "value" and known != ("m / s" if kind == "velocity" else "arcsec"):
        wanted = "a velocity" if kind == "velocity" else "an angle"
        raise TypeError(f"{name} is in {given}: must be {wanted} or a plain number")
    factor = unit if known is None else float(given.to(known))
    if unit and not math.isclose(unit, factor):
        raise ValueError(f"unit = {unit}: must not be given, as {name} is in {given}")
    return factor


def _converted(name: str, values: typing.Any, unit: typing.Any, wanted: typing.Any) -> typing.Any:
    if not unit.is_equivalent(wanted):
        raise TypeError(f"{name} is in {unit}: must be in a unit of {wanted}")
    return values if unit == wanted else unit.to(wanted, numpy.asarray(values, numpy.float64))


def series_of_table(cls: type[Measurements], table: typing.Any, columns: str, kind: str, unit: float, exposure_s: float,
                    instrument: str, time_format: str = "", time_scale: str = "") -> Measurements:
    """Returns a series of a table; see Measurements.of_table."""
    given = SeriesTable(table)
    columns = columns if isinstance(columns, str) else ",".join(columns)
    names = [name.strip() for name in columns.split(",")] if columns else [
        "t", "y", *(["sigma"] if "sigma" in given.names else [])]
    if len(names) not in (2, 3):
        raise ValueError(f"columns = {columns!r}: must be two or three names")
    t, tai_ns = given.times(names[0], time_format, time_scale)
    y, sigma, value_unit = given.values(names[1], names[2] if len(names) == 3 else "")
    kind = kind or given.facts.get("kind", "velocity" if is_velocity(value_unit) else "value")
    factor = factor_of(names[1], value_unit, number_of_unit(unit, kind), kind)
    if given.facts.get("refitted"):
        raise ValueError("table is of a series whose orbit was refitted to it: it must not be searched for planets")
    half = round(real("exposure_s", exposure_s) * 5e8)
    if half and tai_ns is None:
        raise ValueError(f"exposure_s = {exposure_s}: must not be given for times that are no dates")
    angles = given.column("position_angle_deg") if "position_angle_deg" in given.names else None
    made = cls.of(t if tai_ns is None else None, y, sigma, kind=kind, position_angle_deg=angles,
                  exposures=None if tai_ns is None else numpy.stack([tai_ns - half, tai_ns + half], 1),
                  unit=factor or given.facts.get("unit", 0), time_unit_days=given.facts.get("unit_d", 1),
                  frame_chi_square=given.facts.get("chi2", 0))._knows(False, value_unit)
    return _with_functions(made, given, instrument or ("instrument" if "instrument" in given.names and
                                                      "fn1" in given.facts else ""))


def _with_functions(made: Measurements, given: SeriesTable, instrument: str) -> Measurements:
    """Sets instruments, trend and functions as the meta data of a table of a series say."""
    facts = given.facts
    if instrument:
        made.set_instruments([name.decode() if isinstance(name, bytes) else str(name)  # FITS has bytes
                              for name in given.column(instrument)])
    if facts.get("trend"):
        ends = numpy.array([facts["t_first"], facts["t_last"]], float)
        first, last = _dates(ends, "mjd", facts["t_scale"]).tai.mjd if "t_scale" in facts else ends
        made.set_trend(int(facts["trend"]), (first, last))
    known = [function.name for function in made.functions]
    place = 1
    while f"fn{place}" in facts:
        name, sigma = str(facts[f"fn{place}"]), float(facts.get(f"prior{place}", 0))
        if name not in known:
            made.add_column(name, given.column(name), sigma)
        elif sigma:
            made.set_prior(known.index(name), sigma)
        place += 1
    return made


def table_at(path: typing.Any) -> typing.Any:
    """Returns the table of a FITS file, or of an ECSV file that to_table() of a series made; None for other sources,
    which the library reads."""
    if not isinstance(path, (str, os.PathLike)):
        return None
    name = os.fsdecode(path).lower()
    is_own = name.endswith(".ecsv") and _is_own(path)
    if not is_own and not name.endswith(_OF_FITS):
        return None
    how: dict[str, typing.Any] = {"format": "ascii.ecsv"}
    if not is_own:
        how = {"format": "fits", "astropy_native": True}  # with columns of Time
    return optional("astropy.table", "FITS and ECSV tables").Table.read(path, **how)


def _is_own(path: str | os.PathLike[str]) -> bool:
    """Whether a file begins with the meta data of a series."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            for line in stream:
                if not line.startswith("#"):
                    return False
                if "object: Measurements" in line:
                    return True
    except OSError:  # the library reports it
        pass
    return False
