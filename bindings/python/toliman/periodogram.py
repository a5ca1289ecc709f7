"""Lomb-Scargle periodograms, streaming and in batch. Reference: include/toliman/period.h."""
from __future__ import annotations

import ctypes
import functools
import math
import os
import typing
import warnings

import numpy
from numpy.typing import ArrayLike

from . import _raw, _results
from ._library import check, library
from ._arguments import (INT64, Doubles, array_of, file_name, of_kind, options_of, plain, pointer, real, saved, shaped,
                         whole, whole_float, within)
from ._handle import Handle
from ._plots import Axes, plots
from ._progress import Progress, Watch
from ._results import Alias, Model, PeriodogramInfo, Sampling
from ._result_base import result
from ._shown import documented, members_html
from ._table import Column, Rows, Tabular, Units, column_of
from ._units import label_of
from ._words import number
from .times import name_of_unit, plain_times, plain_values, unit_of, unit_of_ns


class Samples(typing.NamedTuple):
    """The series of a Peak: times and values less nuisance functions, the time to which phases refer, and the units of
    times and values for labels."""

    t: Doubles
    y: Doubles
    time_offset: float
    time_label: str
    value_label: str


@result
class Peak(_results.Peak):
    __doc__ = (_results.Peak.__doc__ or "").split("\n\n")[0]
    _samples: typing.ClassVar[Samples | None] = None  # of period() and fit(); not in copies and pickles

    def _of_samples(self, samples: Samples) -> Peak:
        object.__setattr__(self, "_samples", samples._replace(t=samples.t.copy(), y=samples.y.copy()))
        return self

    def __getstate__(self) -> dict[str, typing.Any]:
        return {name: value for name, value in vars(self).items() if name != "_samples"}

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the series folded over the period, from its first time on, with the best sinusoid and the means,
        without weights, of 24 intervals. Values are less their mean and nuisance functions.

        ax: Axes to draw into, in their style; None: a new figure of pyplot. Raises ValueError for a peak without
        series: toliman.period() and Periodogram.fit() give those with one."""
        return plots().peak(self, ax)

    def __repr__(self) -> str:
        error = "" if math.isnan(self.period_error) else f" +- {self.period_error:.2g}"
        return f"Peak(period={self.period:.6g}{error}, power={self.power:.6g}, log10_fap={self.log10_fap:.4g})"


def _series(t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None,
            unit: typing.Any) -> tuple[Doubles, Doubles, Doubles | None]:
    """Returns float64 arrays of equal length, y and sigma in `unit`; a scalar sigma is repeated."""
    t, y, sigma = plain_times("t", t), plain_values("y", y, unit), plain_values("sigma", sigma, unit)
    if sigma is not None and numpy.ndim(sigma) == 0:
        sigma = numpy.full(numpy.shape(t), real("sigma", sigma))
    times, values = plain("t", t), plain("y", y)
    sigmas = None if sigma is None else plain("sigma", sigma)
    shapes = {array.shape for array in (times, values, sigmas) if array is not None}
    if len(shapes) != 1 or times.ndim != 1:
        raise ValueError(f"t, y, sigma have the shapes {sorted(shapes)}: must be one-dimensional and of equal length")
    return times, values, sigmas


def _sample(t: typing.Any, y: float, sigma: float | None, t_low: float, ns: bool, unit: typing.Any) -> typing.Any:
    """Returns one sample as a C struct, in which sigma = 0 means unweighted."""
    y, sigma = plain_values("y", y, unit), plain_values("sigma", sigma, unit)
    sample = _raw.toliman_period_sample(y=real("y", y), t_low=real("t_low", t_low))
    if ns:
        sample.flags, sample.t_ns = _raw.TOLIMAN_PERIOD_TIME_NS, within("t", t, -INT64, INT64)  # type: ignore[arg-type]
    else:
        sample.t = real("t", plain_times("t", t))
    if sigma is not None:
        sample.sigma = real("sigma", sigma)
        if sample.sigma == 0:
            raise ValueError("sigma = 0: must be finite and above 0")
    return ctypes.byref(sample)


def _rows(periodogram: View, rows: ArrayLike | None, n: int) -> Doubles | None:
    """Returns the values of the columns of n samples, of the shape (n, columns); None if the periodogram has none."""
    columns = periodogram.info.columns
    if rows is None:
        if columns > 0:
            raise ValueError(f"rows must be given: the periodogram has {columns} columns")
        return None
    return shaped("rows", rows, (n, columns))


def _set_functions(options: typing.Any, trend: int, span: tuple[typing.Any, typing.Any] | None,
                   priors: ArrayLike | None) -> None:
    """Sets the nuisance functions of options, whose columns are set."""
    options.trend = whole("trend", trend, 2**31)
    if span is not None:
        options.trend_start, options.trend_end = (real("span", plain_times("span", end)) for end in span)
    if priors is not None:
        deviations = shaped("priors", priors, (1 + trend + options.columns,))
        if not (deviations > 0).all():
            raise ValueError("priors: must be above 0; infinity for a free coefficient")
        options.prior_precision[:deviations.size] = list(1 / deviations**2)


def _samples(times: Doubles, values: Doubles, sigmas: Doubles | None) -> typing.Any:
    """Returns an array of samples as C structs, in which sigma = 0 means unweighted."""
    if sigmas is not None and (sigmas == 0).any():
        raise ValueError("sigma = 0: must be finite and above 0")
    samples = array_of(_raw.toliman_period_sample, len(times))
    members = numpy.frombuffer(samples, numpy.dtype(_raw.toliman_period_sample))[:len(times)]
    members["t"], members["y"], members["sigma"] = times, values, 0 if sigmas is None else sigmas
    return samples


class AccuracyWarning(RuntimeWarning):
    """Warns that powers may be wrong by more than 1e-3."""


AccuracyWarning.__module__ = "toliman"


def warn_if_inaccurate(inaccurate: bool) -> None:
    """Issues an AccuracyWarning at the line of the user's call, two frames up."""
    if inaccurate:
        warnings.warn("the power may be wrong by more than 1e-3 at frequencies at which the samples do not tell a sine from "
                      "a cosine or the mean, far below 1/T or at half the sampling rate: set double_limb=True, if it is not, "
                      "or leave these frequencies out", AccuracyWarning, stacklevel=3)


@documented(f0="first frequency", df="step", nf="number of frequencies")
class Grid(typing.NamedTuple):
    """Frequency grid f0 + k df for k = 0 ... nf - 1, in cycles per unit of time."""

    f0: float
    df: float
    nf: int

    def _repr_html_(self) -> str:
        return members_html(self)


def suited_grid(t: ArrayLike, mission_span: float = 0.0) -> Grid:
    """Suggests a frequency grid for the times t.

        grid = suited_grid(t)
        with Periodogram(*grid) as periodogram: ...

    The grid runs from 1.5/T in steps of 0.1/T, where T is the time span plus one median step. The differences of the
    times give its end: 1/(2 s) if they are multiples of a step s, otherwise 5/(2 s), where 5 % of them are below s. It
    has at most 131,072 frequencies, and at most 2^32 divided by the number of samples. mission_span: the final T, in
    units of t (a Quantity if t are dates or one), if more samples are to come; 0: t is complete.

    Raises StateError if all times are equal.
    """
    plain_t = plain_times("t", t)
    return _suggested(plain("t", plain_t), None, None, real("mission_span", mission_span, "" if plain_t is t else "d"))[0]


def grid_of_days(days: float) -> Grid:
    """Suggests a grid for daily samples over a mission of this length."""
    return _suggested(numpy.empty(0), None, None, days)[0]


def _suggested(t: Doubles, y: Doubles | None, sigma: Doubles | None,
               mission_span: float) -> tuple[Grid, typing.Any]:
    """Returns the grid and options suggested for samples."""
    f0, df, nf = ctypes.c_double(), ctypes.c_double(), ctypes.c_int64()
    options = _raw.toliman_period_options()
    check(library.toliman_period_suggest(pointer(t), pointer(y), pointer(sigma), t.size, mission_span, ctypes.byref(f0),
                                         ctypes.byref(df), ctypes.byref(nf), ctypes.byref(options)))
    return Grid(f0.value, df.value, nf.value), options


def period(t: ArrayLike, y: ArrayLike, dy: ArrayLike | None = None, *, grid: Grid | None = None) -> Peak:
    """Finds the period of a time series.

        print(toliman.period(t, y, dy))

    Phases refer to the first time. Measurements: period(series.t, series.y, series.sigma), if it has no functions.

    Takes times t, values y and standard errors dy (None: unweighted), searches the grid (None: suited_grid(t)) for the
    highest peak, and refines it by least squares against the samples. Returns the Peak: period, amplitude, their
    standard errors, and the false alarm probability, in the units of t and y, in days for dates and quantities of time.
    Of periods that the samples do not tell apart, this is the longest: Periodogram.aliases.
    """
    times, values, sigmas = _series(t, y, dy, unit_of(y))
    suited, options = _suggested(times, values, sigmas, 0.0)
    with Periodogram(*(grid or suited), time_offset=options.time_offset, value_offset=options.value_offset,
                     value_bound=options.value_bound, sigma_floor=options.sigma_floor,
                     sigma_ceiling=options.sigma_ceiling, double_limb=True, unit_ns=86400e9) as periodogram:
        periodogram.push_many(t, y, dy)
        return periodogram.fit(t, y, dy)


def batch(t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *, f0: float, df: float, nf: int,
          fit_mean: bool = True, tolerance: float = 1e-9, direct: bool = False, threads: int = 0,
          trend: int = 0, span: tuple[typing.Any, typing.Any] | None = None, rows: ArrayLike | None = None,
          priors: ArrayLike | None = None, progress: Progress | bool | None = None) -> Doubles:
    """Computes the power of a complete time series at f0 + k df, k < nf, without a streaming state.

    Much faster than a Periodogram. t, y, sigma: arrays of equal length; sigma may be one number, None means unweighted.
    fit_mean: fit the mean at each frequency (floating mean) instead of subtracting the weighted mean once. tolerance:
    largest error of any power, by nonuniform FFT. direct: sum without an FFT, to 1e-13. trend, span, rows, priors:
    nuisance functions as in Periodogram; rows of the shape (samples, columns), span None: that of t. Returns power[nf].
    """
    times, values, sigmas = _series(t, y, sigma, unit_of(y))
    power = numpy.empty(whole_float("nf", nf))
    functions = None if rows is None else shaped("rows", rows, (len(times), -1))
    with Watch(progress) as watch:
        options = options_of(_raw.toliman_period_batch_options,
                             flags=(0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN)
                             | (_raw.TOLIMAN_PERIOD_DIRECT if direct else 0), tolerance=real("tolerance", tolerance),
                             threads=whole("threads", threads, 2**32), progress=watch.callback,
                             columns=0 if functions is None else functions.shape[1], rows=pointer(functions))
        _set_functions(options, trend, span, priors)
        watch.check(library.toliman_period_batch(real("f0", f0), real("df", df), len(power), pointer(times),
                                                 pointer(values), pointer(sigmas), len(times), ctypes.byref(options),
                                                 pointer(power)))
    return power


class View(Handle, Tabular):
    """Queries of a periodogram. Tracker.period is a View: its samples come from the tracker alone.

    value_unit: unit of the values, to which quantities are converted; None: plain numbers.
    """

    _kind = _raw.toliman_period
    value_unit: typing.Any = None

    @property
    def _time_unit_ns(self) -> float:
        """Nanoseconds per unit of the times; 0: not known."""
        return self.info.unit_ns  # a tracker has dates

    def _time_label(self) -> str:
        """Unit of the times, for labels."""
        return name_of_unit(self._time_unit_ns)

    def _value_label(self) -> str:
        """Unit of the values, for labels."""
        return label_of(self._units["y"], "units of y")

    def _unit_for(self, y: typing.Any) -> typing.Any:
        """Returns the unit of the values, which the first sample determines."""
        given = unit_of(y)
        if given is None or self.value_unit is not None:
            return self.value_unit
        if len(self) > 0:
            raise TypeError(f"y is in {given}: the samples so far have no unit, or one that is not known after load(); "
                            "give plain numbers or set value_unit")
        return given

    @property
    def info(self) -> PeriodogramInfo:
        """Grid, options and number of samples."""
        return self._read(library.toliman_period_get_info, _raw.toliman_period_info, PeriodogramInfo)

    @property
    def _units(self) -> Units:
        return {"t": unit_of_ns(self._time_unit_ns), "y": "" if self.value_unit is None else str(self.value_unit)}

    def _columns(self) -> dict[str, Column]:
        frequency, units = self.frequency, self._units
        with numpy.errstate(divide="ignore"):
            periods = 1 / frequency
        return {"frequency": column_of("frequency", frequency, "", units),
                "period": column_of("period", periods, "", units),
                "power": Column(self.power(), "", 'normalisation "standard", 0 to 1')}

    def _facts(self) -> dict[str, typing.Any]:
        info = self.info
        return {"samples": info.count, "f0": info.f0, "df": info.df, "unit": self._units["y"]}

    @property
    def frequency(self) -> Doubles:
        """Frequencies of the grid, f0 + k df, in cycles per unit of time."""
        info = self.info
        return info.f0 + info.df * numpy.arange(info.nf)

    def power(self, normalisation: str = "standard", *, first: int = 0, count: int | None = None) -> Doubles:
        """Returns the power at every frequency, or at `count` frequencies from index `first`. Never NaN.

        normalisation: "standard" (in [0, 1]), "model", "log" or "psd", as in astropy's LombScargle. Issues an
        AccuracyWarning if any power of the grid may be wrong by more than 1e-3.
        """
        first = whole("first", first)
        power = numpy.empty(whole("count", max(self.info.nf - first, 0) if count is None else count))
        kind = number("normalisation", normalisation, "TOLIMAN_PERIOD_POWER")
        check(library.toliman_period_query_power(self._c, kind, first, len(power), pointer(power)))
        warn_if_inaccurate(self.sampling().inaccurate)
        return power

    def peak(self) -> Peak:
        """Returns the highest peak of the grid, or that of the longest period that the sampling does not tell from it.
        The frequency is refined by a parabola; power and FAP are those of the grid point. Raises StateError with fewer
        than five samples or constant values."""
        found = _raw.toliman_period_peak()
        check(library.toliman_period_query_peak(self._c, ctypes.byref(found)))
        warn_if_inaccurate(found.flags & _raw.TOLIMAN_PERIOD_INACCURATE != 0)
        return Peak._of(found, self._units)

    def peaks(self, most: int = 10) -> Rows[Peak]:
        """Returns peak() and the other local maxima, highest first, up to `most` <= 64. `alias` marks peaks that the sampling could produce
        from a higher one. Power and FAP of each peak assume that it is the only signal."""
        found, count = array_of(_raw.toliman_period_peak, whole("most", most, 65)), ctypes.c_size_t()
        check(library.toliman_period_query_peaks(self._c, found, len(found), ctypes.byref(count)))
        units = self._units
        peaks = Rows(Peak._of(peak, units) for peak in found[:count.value])
        warn_if_inaccurate(any(peak.inaccurate for peak in peaks))
        return peaks

    def aliases(self, frequency: float) -> Rows[Alias]:
        """Returns the aliases of a peak at `frequency`: the frequencies at which the sampling repeats it, with interval
        and power. `equal` marks those that the samples do not tell from the peak."""
        found, count = array_of(_raw.toliman_period_alias, 16), ctypes.c_size_t()
        check(library.toliman_period_query_aliases(self._c, real("frequency", frequency), found, len(found),
                                                   ctypes.byref(count)))
        units = self._units
        return Rows(Alias._of(alias, units) for alias in found[:count.value])

    def model(self, k: int) -> Model:
        """Returns the least-squares sinusoid at frequency f0 + k df: amplitude, phase (rad) and offset with standard
        errors, y = offset + amplitude sin(2 pi f (t - time_offset) + phase)."""
        found = _raw.toliman_period_model()
        check(library.toliman_period_query_model(self._c, whole("k", k), ctypes.byref(found)))
        warn_if_inaccurate(found.flags & _raw.TOLIMAN_PERIOD_INACCURATE != 0)
        return Model._of(found, self._units)

    def coefficients(self, k: int) -> tuple[Doubles, Doubles]:
        """Returns the coefficients of mean, trend T_1, T_2 ... and columns, fitted with the sinusoid at frequency
        f0 + k df, and their standard errors: 0 and infinity for functions that the samples do not determine."""
        info = self.info
        found, errors = numpy.empty((2, 1 + info.trend + info.columns))
        check(library.toliman_period_query_coefficients(self._c, whole("k", k), len(found), pointer(found),
                                                        pointer(errors)))
        return found, errors

    def fit(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *,
            rows: ArrayLike | None = None) -> Peak:
        """Refines the highest peak by least squares against t, y, sigma and rows, which must be the samples pushed;
        only their number is checked. Returns period, amplitude and phase with standard errors."""
        plain_t = plain_times("t", t)
        times, values, sigmas = _series(plain_t, y, sigma, self._unit_for(y))
        peak = _raw.toliman_period_peak()
        check(library.toliman_period_query_fit(
            self._c, pointer(times), pointer(values), pointer(sigmas), pointer(_rows(self, rows, len(times))),
            len(times), ctypes.byref(peak)))
        warn_if_inaccurate(peak.flags & _raw.TOLIMAN_PERIOD_INACCURATE != 0)
        unit_ns = self._time_unit_ns if plain_t is t else 86400e9
        found = Peak._of(peak, {**self._units, "t": unit_of_ns(unit_ns)})
        return found._of_samples(Samples(times, values - self._functions_at(found.frequency, times, rows),
                                         self.info.time_offset, name_of_unit(unit_ns), self._value_label()))

    def _functions_at(self, frequency: float, t: Doubles, rows: ArrayLike | None) -> Doubles | float:
        """Returns the nuisance functions without the mean, fitted at the grid point next to a frequency, at times t."""
        info = self.info
        if info.trend + info.columns == 0:
            return 0.0
        k = min(max(round((frequency - info.f0) / info.df), 0), info.nf - 1)
        trend, columns = numpy.split(self.coefficients(k)[0][1:], [info.trend])
        place = (2 * t - info.trend_start - info.trend_end) / ((info.trend_end - info.trend_start) or 1)
        values = numpy.polynomial.chebyshev.chebval(place, [0, *trend])
        return values if rows is None else values + plain("rows", rows) @ columns

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the power over frequency and period, with the highest peak and the power of a peak with FAP 0.001.

        ax: Axes to draw into, in their style; None: a new figure of pyplot. Raises StateError as peak(), ValueError
        without two frequencies above 0."""
        return plots().periodogram(self, ax)

    def log10_fap(self, log10_residual: float, method: str = "baluev") -> float:
        """Returns log10 of the false alarm probability (FAP) of a power P on this grid.

        log10_residual: log10(1 - P), as in Peak, which resolves powers close to 1. method: "baluev" (upper bound),
        "naive", "single" (one given frequency), or "sequential" for repeated interim queries while samples arrive.
        """
        fap = ctypes.c_double()
        check(library.toliman_period_query_fap(self._c, number("method", method, "TOLIMAN_PERIOD_FAP"),
                                               real("log10_residual", log10_residual), ctypes.byref(fap)))
        return fap.value

    def threshold(self, log10_fap: float, method: str = "baluev") -> float:
        """Returns the detection threshold, as log10(1 - P), for a false alarm probability given as log10. The inverse
        of log10_fap()."""
        residual = ctypes.c_double()
        check(library.toliman_period_query_threshold(self._c, number("method", method, "TOLIMAN_PERIOD_FAP"),
                                                 real("log10_fap", log10_fap), ctypes.byref(residual)))
        return residual.value

    def bootstrap(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *, rows: ArrayLike | None = None,
                  count: int = 1000, seed: int = 0, threads: int = 0,
                  progress: Progress | bool | None = None) -> Doubles:
        """Returns log10(1 - P) of the highest peak of each of `count` bootstrap resamplings, strongest peak first. t,
        y, sigma, rows must be the samples pushed."""
        times, values, sigmas = _series(t, y, sigma, self._unit_for(y))
        functions = _rows(self, rows, len(times))
        peaks = numpy.empty(whole("count", count))
        with Watch(progress) as watch:
            options = options_of(_raw.toliman_period_bootstrap_options,
                                 threads=whole("threads", threads, 2**32), seed=whole("seed", seed, 2**64),
                                 progress=watch.callback, rows=pointer(functions))
            watch.check(library.toliman_period_query_bootstrap(
                self._c, pointer(times), pointer(values), pointer(sigmas), len(times), ctypes.byref(options), count,
                pointer(peaks)))
        return peaks

    def sampling(self, t: ArrayLike | None = None) -> Sampling:
        """Returns diagnostics of the sampling: time span, Nyquist frequency, whether the grid is too coarse.

        t: the times pushed, for the exact time span and median step; None estimates both from the variance of the
        times, assuming even sampling.
        """
        times = None if t is None else plain("t", plain_times("t", t))
        found = _raw.toliman_period_sampling()
        check(library.toliman_period_query_sampling(self._c, pointer(times), 0 if times is None else times.size,
                                                    ctypes.byref(found)))
        return Sampling._of(found, self._units)

    def to_bytes(self) -> bytes:
        """Returns the state as bytes. The same samples give the same bytes, regardless of order."""
        return saved(functools.partial(library.toliman_period_save, self._c))

    def copy(self) -> Periodogram:
        """Returns an independent periodogram with the same grid, options and samples."""
        copy = Periodogram._adopt(self._create(library.toliman_period_copy, self._c))
        vars(copy).update(self._not_saved())
        return copy

    def _not_saved(self) -> dict[str, typing.Any]:
        """Returns the attributes that the library does not keep."""
        epoch = {"_epoch": self._epoch} if hasattr(self, "_epoch") else {}
        return {"value_unit": self.value_unit, "_time_unit_ns": self._time_unit_ns, **epoch}

    def __len__(self) -> int:
        return self.info.count

    def _summary(self) -> str:
        info = self.info
        return f"Periodogram of {info.count} samples at f = {info.f0:g} + k {info.df:g}, k < {info.nf}"


class Periodogram(View):
    """A streaming Lomb-Scargle periodogram: samples can be added and removed one at a time.

    The sums are exact integers, so that the result is bit-identical for any order of pushes.

    Parameters

    f0, df, nf: frequencies f0 + k df, k < nf, in cycles per unit of t; suited_grid(t) suggests them.
    fit_mean: fit the mean at each frequency (floating mean) instead of subtracting the weighted mean once.
    time_offset, value_offset: subtracted exactly from every t and y. Give the first time of long time stamps, and a
        typical value if the mean is large.
    value_bound: largest |y - value_offset| to come.
    sigma_floor, sigma_ceiling: smallest and largest sigma to come; sigma_ceiling = 0 means 32 sigma_floor, the maximum
        is 1e8 sigma_floor. For small sigmas give min(sigma) and max(sigma).
    double_limb: use double-limb (178-bit) accumulators. They keep the digits that are lost where the samples cover a
        small part of a cycle; sampling().needs_double_limb reports this.
    time_offset_ns, unit_ns: for times in integer nanoseconds (push with ns=True): the offset, and the number of
        nanoseconds per unit of t.

    Nuisance functions, fitted with the mean at each frequency, so that they neither hide a signal nor imitate one; at
    most 8:
    trend: highest order of a polynomial in time (Chebyshev polynomials T_1 ... on span).
    span: first and last time that samples may have, with a trend.
    columns: number of values that come with each sample (rows of push and push_many), such as the derivatives of an
        orbit.
    column_bounds: largest absolute value of each column; None: 1.
    priors: standard deviations of the coefficients of mean, T_1 ... and columns about 0 (of the mean about
        value_offset); infinity: free; None: all free.

    Times may also be dates, and values quantities; see "Dates and units" in help(toliman). The bounds are plain numbers in
    the unit of the values. Attributes: epoch is the time_offset as it was given, to which phases refer; value_unit is the
    unit of the values, taken from the first quantity. Neither is saved by save() and to_bytes(); copies and pickles have
    them.

    Raises InputError for an invalid grid or options.
    """

    _destroy = "toliman_period_destroy"
    _time_unit_ns = 0.0  # until a date, a quantity or an integer of nanoseconds is given

    def __init__(self, f0: float, df: float, nf: int, *, fit_mean: bool = True, time_offset: typing.Any = 0.0,
                 value_offset: float = 0.0, value_bound: float = 2.0**20, sigma_floor: float = 1.0,
                 sigma_ceiling: float = 0.0, double_limb: bool = False, time_offset_ns: int = 0, unit_ns: float = 1e9,
                 trend: int = 0, span: tuple[typing.Any, typing.Any] | None = None, columns: int = 0,
                 column_bounds: ArrayLike | None = None, priors: ArrayLike | None = None):
        flags = ((0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN)
                 | (_raw.TOLIMAN_PERIOD_DOUBLE_LIMB if double_limb else 0))
        plain_offset = plain_times("time_offset", time_offset)
        options = options_of(
            _raw.toliman_period_options, flags=flags,
            time_offset=real("time_offset", plain_offset), value_offset=real("value_offset", value_offset),
            value_bound=real("value_bound", value_bound), sigma_floor=real("sigma_floor", sigma_floor),
            sigma_ceiling=real("sigma_ceiling", sigma_ceiling),
            time_offset_ns=within("time_offset_ns", time_offset_ns, -INT64, INT64), unit_ns=real("unit_ns", unit_ns),
            columns=whole("columns", columns, 2**31))
        _set_functions(options, trend, span, priors)
        if column_bounds is not None:
            options.column_bound[:columns] = list(shaped("column_bounds", column_bounds, (columns,)))
        super().__init__(self._create(library.toliman_period_create, real("f0", f0), real("df", df),
                                      whole_float("nf", nf), ctypes.byref(options)))
        self._epoch = time_offset
        if plain_offset is not time_offset:  # a date or a quantity
            self._time_unit_ns = 86400e9

    @property
    def epoch(self) -> typing.Any:
        """The time to which phases refer: time_offset as it was given, or a plain number after load()."""
        return getattr(self, "_epoch", self.info.time_offset)

    def push(self, t: float, y: float, sigma: float | None = None, *, rows: ArrayLike | None = None,
             t_low: float = 0.0, ns: bool = False) -> None:
        """Adds one sample.

        t: the time is t + t_low, in days for dates; with ns=True, t is in integer nanoseconds. sigma:
        standard error of y; None: unweighted, counted as sigma_floor. rows: values of the columns. Raises StateError for a mixture of unweighted
        samples and samples whose sigma is not sigma_floor, InputError for a value or sigma outside the bounds given at
        creation.

        Every sample counts as evidence: a sample pushed twice is counted twice.
        """
        unit, plain_t = self._unit_for(y), t if ns else plain_times("t", t)
        row = _rows(self, None if rows is None else [plain("rows", rows)], 1)
        sample = _sample(plain_t, y, sigma, t_low, ns, unit)
        check(library.toliman_period_push_samples(self._c, sample, pointer(row), 1))
        self.value_unit = unit
        if ns or plain_t is not t:
            self._time_unit_ns = self.info.unit_ns if ns else 86400e9

    def push_many(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *,
                  rows: ArrayLike | None = None) -> None:
        """Adds arrays of samples, all or none. sigma may be one number; None: unweighted. rows: values of the columns,
        of the shape (samples, columns). Exceptions as in push()."""
        unit, plain_t = self._unit_for(y), plain_times("t", t)
        times, values, sigmas = _series(plain_t, y, sigma, unit)
        functions = _rows(self, rows, len(times))
        if functions is None:
            check(library.toliman_period_push_many(self._c, pointer(times), pointer(values), pointer(sigmas), len(times)))
        else:
            check(library.toliman_period_push_samples(self._c, _samples(times, values, sigmas), pointer(functions),
                                                      len(times)))
        self.value_unit = unit
        if plain_t is not t:
            self._time_unit_ns = 86400e9

    def retract(self, t: float, y: float, sigma: float | None = None, *, rows: ArrayLike | None = None,
                t_low: float = 0.0, ns: bool = False) -> None:
        """Removes a sample previously pushed with exactly these values.

        The sums become bit-identical to never having pushed it. The library cannot check that the sample was pushed.
        Raises StateError if the remaining sums cannot be those of any samples.
        """
        row = _rows(self, None if rows is None else [plain("rows", rows)], 1)
        check(library.toliman_period_retract_samples(self._c, _sample(t, y, sigma, t_low, ns, self._unit_for(y)),
                                                  pointer(row), 1))

    def retract_many(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *,
                     rows: ArrayLike | None = None) -> None:
        """Removes arrays of samples, all or none. See retract()."""
        times, values, sigmas = _series(t, y, sigma, self._unit_for(y))
        check(library.toliman_period_retract_samples(self._c, _samples(times, values, sigmas),
                                                     pointer(_rows(self, rows, len(times))), len(times)))

    def merge(self, other: View) -> None:
        """Adds all samples of another periodogram of the same grid, a shard, which is not changed."""
        check(library.toliman_period_merge(self._c, of_kind("other", other, View)._c))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the state to a file, atomically."""
        check(library.toliman_period_save_file(self._c, file_name(path)))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Periodogram:
        """Loads a periodogram from a file written by save(); further samples can be pushed."""
        return cls._adopt(cls._create(library.toliman_period_load_file, file_name(path), None))

    @classmethod
    def from_bytes(cls, content: bytes) -> Periodogram:
        """Loads a periodogram from the bytes returned by to_bytes()."""
        content = memoryview(content).tobytes()
        return cls._adopt(cls._create(library.toliman_period_load, content, len(content), None))

    def __reduce__(self):
        return type(self).from_bytes, (self.to_bytes(),), self._not_saved()
