"""Periodograms: samples -> period; include/toliman/period.h is the manual."""
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
from ._arguments import (INT64, Doubles, array_of, file_name, of_kind, options_of, plain, pointer, real, saved, whole,
                         whole_float, within)
from ._handle import Handle
from ._progress import Progress, Watch
from ._results import Model, PeriodogramInfo, Sampling
from ._shown import result
from ._words import number


@result
class Peak(_results.Peak):
    __doc__ = (_results.Peak.__doc__ or "").split("\n\n")[0]

    def __repr__(self) -> str:
        error = "" if math.isnan(self.period_error) else f" +- {self.period_error:.2g}"
        return f"Peak(period={self.period:.6g}{error}, power={self.power:.6g}, log10_fap={self.log10_fap:.4g})"


def _series(t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None) -> tuple[Doubles, Doubles, Doubles | None]:
    """Arrays of equal length; one sigma stands for all."""
    if sigma is not None and numpy.ndim(sigma) == 0:
        sigma = numpy.full(numpy.shape(t), real("sigma", sigma))
    times, values = plain("t", t), plain("y", y)
    sigmas = None if sigma is None else plain("sigma", sigma)
    shapes = {array.shape for array in (times, values, sigmas) if array is not None}
    if len(shapes) != 1 or times.ndim != 1:
        raise ValueError(f"t, y and sigma must be one-dimensional and of equal length, not {sorted(shapes)}")
    return times, values, sigmas


def _sample(t: float, y: float, sigma: float | None, t_low: float, ns: bool) -> typing.Any:
    """One sample for C, where sigma 0 stands for none."""
    sample = _raw.toliman_period_sample(y=real("y", y), t_low=real("t_low", t_low))
    if ns:
        sample.flags, sample.t_ns = _raw.TOLIMAN_PERIOD_TIME_NS, within("t", t, -INT64, INT64)  # type: ignore[arg-type]
    else:
        sample.t = real("t", t)
    if sigma is not None:
        sample.sigma = real("sigma", sigma)
        if sample.sigma == 0:
            raise ValueError("sigma = 0: must be finite and above 0")
    return ctypes.byref(sample)


class AccuracyWarning(RuntimeWarning):
    """Powers that may be wrong by more than 1e-3."""


AccuracyWarning.__module__ = "toliman"


def warn_if_inaccurate(inaccurate: bool) -> None:
    """Of a result that the caller's caller asked for."""
    if inaccurate:
        warnings.warn("the power may be wrong by more than 1e-3 where the samples cover too small a part of a cycle: "
                      "double_limb=True keeps more digits; frequencies far below 1/T are best left out", AccuracyWarning,
                      stacklevel=3)


class Grid(typing.NamedTuple):
    """Frequencies f0 + k df, k < nf."""

    f0: float
    df: float
    nf: int


def suited_grid(t: ArrayLike, mission_span: float = 0.0) -> Grid:
    """The grid that suits times t: 1.5/T, steps of 0.1/T, up to 1/(2 median step), T the time span and a median step, or
    mission_span, where more samples are to come.

        grid = suited_grid(t)
        with Periodogram(*grid) as periodogram: ...
    """
    return _suggested(plain("t", t), None, None, mission_span)[0]


def _suggested(t: Doubles, y: Doubles | None, sigma: Doubles | None,
               mission_span: float) -> tuple[Grid, typing.Any]:
    """A grid and options for samples."""
    f0, df, nf = ctypes.c_double(), ctypes.c_double(), ctypes.c_int64()
    options = _raw.toliman_period_options()
    check(library.toliman_period_suggest(pointer(t), pointer(y), pointer(sigma), t.size, real("mission_span", mission_span),
                                         ctypes.byref(f0), ctypes.byref(df), ctypes.byref(nf), ctypes.byref(options)))
    return Grid(f0.value, df.value, nf.value), options


def period(t: ArrayLike, y: ArrayLike, dy: ArrayLike | None = None) -> Peak:
    """The period of samples t, y with standard errors dy, by least squares from the highest peak on the grid that suits
    them, with its false alarm probability.

        print(toliman.period(t, y, dy))
    """
    times, values, sigmas = _series(t, y, dy)
    grid, options = _suggested(times, values, sigmas, 0.0)
    with Periodogram(*grid, time_offset=options.time_offset, value_offset=options.value_offset,
                     value_bound=options.value_bound, sigma_floor=options.sigma_floor,
                     sigma_ceiling=options.sigma_ceiling, double_limb=True) as periodogram:
        periodogram.push_many(times, values, sigmas)
        return periodogram.fit(times, values, sigmas)


def batch(f0: float, df: float, nf: int, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *,
          fit_mean: bool = True, tolerance: float = 1e-9, direct: bool = False, threads: int = 0,
          progress: Progress | bool | None = None) -> Doubles:
    """Power of a whole archive at f0 + k df, k < nf, each within the tolerance of the exact one; much quicker than a
    Periodogram, but without a state. direct=True sums without an FFT, to 1e-13."""
    times, values, sigmas = _series(t, y, sigma)
    power = numpy.empty(whole_float("nf", nf))
    with Watch(progress) as watch:
        options = options_of(_raw.toliman_period_batch_options, library.toliman_period_batch_options_init,
                             flags=(0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN)
                             | (_raw.TOLIMAN_PERIOD_DIRECT if direct else 0), tolerance=real("tolerance", tolerance),
                             threads=whole("threads", threads, 2**32), progress=watch.callback)
        watch.check(library.toliman_period_batch(real("f0", f0), real("df", df), len(power), pointer(times), pointer(values), pointer(sigmas),
                                                 len(times), ctypes.byref(options), pointer(power)))
    return power


class View(Handle):
    """What can be asked of a periodogram; that of a Tracker can only be asked."""

    _kind = _raw.toliman_period

    @property
    def info(self) -> PeriodogramInfo:
        """Grid, options and number of samples."""
        return self._read(library.toliman_period_get_info, _raw.toliman_period_info, PeriodogramInfo)

    @property
    def frequency(self) -> Doubles:
        """The grid, f0 + k df, cycles per unit of time."""
        info = self.info
        return info.f0 + info.df * numpy.arange(info.nf)

    def power(self, normalisation: str = "standard", *, first: int = 0, count: int | None = None) -> Doubles:
        """Power at every frequency, or at `count` of them from number `first` on: standard, model, log or psd, as
        astropy names them. Never NaN. Warns (AccuracyWarning) if some power of the grid may be wrong by more than 1e-3."""
        first = whole("first", first)
        power = numpy.empty(whole("count", max(self.info.nf - first, 0) if count is None else count))
        kind = number("normalisation", normalisation, "TOLIMAN_PERIOD_POWER")
        check(library.toliman_period_query_power(self._c, kind, first, len(power), pointer(power)))
        warn_if_inaccurate(self.sampling().inaccurate)
        return power

    def peak(self) -> Peak:
        """Highest peak: frequency refined by a parabola, power and FAP of the highest grid point."""
        peak = self._read(library.toliman_period_query_peak, _raw.toliman_period_peak, Peak)
        warn_if_inaccurate(peak.inaccurate)
        return peak

    def peaks(self, most: int = 10) -> list[Peak]:
        """The highest peaks, at most 64, highest first; `alias` tells of those that the sampling could make of higher
        ones. Each is judged as if it were the only one."""
        found, count = array_of(_raw.toliman_period_peak, whole("most", most, 65)), ctypes.c_size_t()
        check(library.toliman_period_query_peaks(self._c, most, found, ctypes.byref(count)))
        peaks = [Peak._of(peak) for peak in found[:count.value]]
        warn_if_inaccurate(any(peak.inaccurate for peak in peaks))
        return peaks

    def model(self, k: int) -> Model:
        """Least squares at frequency f0 + k df, from the sums: amplitude, phase and offset with their errors."""
        found = _raw.toliman_period_model()
        check(library.toliman_period_query_model(self._c, whole("k", k), ctypes.byref(found)))
        warn_if_inaccurate(found.flags & _raw.TOLIMAN_PERIOD_INACCURATE != 0)
        return Model._of(found)

    def fit(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None) -> Peak:
        """Highest peak refined by least squares on the samples that were pushed."""
        times, values, sigmas = _series(t, y, sigma)
        peak = _raw.toliman_period_peak()
        check(library.toliman_period_query_fit(self._c, pointer(times), pointer(values), pointer(sigmas), len(times),
                                               ctypes.byref(peak)))
        warn_if_inaccurate(peak.flags & _raw.TOLIMAN_PERIOD_INACCURATE != 0)
        return Peak._of(peak)

    def log10_fap(self, log10_residual: float, method: str = "baluev") -> float:
        """log10 of the false alarm probability of a power P, given as log10(1 - P), on this grid.

        method: baluev, naive, single, or sequential for looking again and again while samples come in.
        """
        fap = ctypes.c_double()
        check(library.toliman_period_query_fap(self._c, number("method", method, "TOLIMAN_PERIOD_FAP"),
                                               real("log10_residual", log10_residual), ctypes.byref(fap)))
        return fap.value

    def threshold(self, log10_fap: float, method: str = "baluev") -> float:
        """log10(1 - P) of the power P that has this log10 of the false alarm probability."""
        residual = ctypes.c_double()
        check(library.toliman_period_query_threshold(self._c, number("method", method, "TOLIMAN_PERIOD_FAP"),
                                                 real("log10_fap", log10_fap), ctypes.byref(residual)))
        return residual.value

    def bootstrap(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None, *, count: int = 1000, seed: int = 0,
                  threads: int = 0, progress: Progress | bool | None = None) -> Doubles:
        """log10(1 - P) of the highest peaks of `count` resamplings of the samples that were pushed, strongest first."""
        times, values, sigmas = _series(t, y, sigma)
        peaks = numpy.empty(whole("count", count))
        with Watch(progress) as watch:
            options = options_of(_raw.toliman_period_bootstrap_options, library.toliman_period_bootstrap_options_init,
                                 threads=whole("threads", threads, 2**32), seed=whole("seed", seed, 2**64),
                                 progress=watch.callback)
            watch.check(library.toliman_period_query_bootstrap(
                self._c, pointer(times), pointer(values), pointer(sigmas), len(times), ctypes.byref(options), count,
                pointer(peaks)))
        return peaks

    def sampling(self, t: ArrayLike | None = None) -> Sampling:
        """What the samples' times are worth, and whether the grid suits them; by the times pushed, if given."""
        times, found = None if t is None else plain("t", t), _raw.toliman_period_sampling()
        check(library.toliman_period_query_sampling(self._c, pointer(times), 0 if times is None else times.size,
                                                    ctypes.byref(found)))
        return Sampling._of(found)

    def to_bytes(self) -> bytes:
        """All sums as bytes; the same samples give the same bytes, whatever their order."""
        return saved(functools.partial(library.toliman_period_save, self._c))

    def copy(self) -> Periodogram:
        """A periodogram of its own with the same grid, options and samples."""
        return Periodogram._adopt(self._made(library.toliman_period_copy, self._c))

    def __len__(self) -> int:
        return library.toliman_period_count(self._c)

    def _told(self) -> str:
        info = self.info
        return f"{type(self).__name__} of {info.count} samples on {info.f0:g} + k {info.df:g}, k < {info.nf}"

    def _repr_html_(self) -> str:
        return self.info._repr_html_()


class Periodogram(View):
    """Lomb-Scargle periodogram on the grid f0 + k df, k < nf, that takes one sample at a time.

    time_offset and value_offset are subtracted exactly; |y - value_offset| must stay within value_bound, and sigma
    between sigma_floor and sigma_ceiling (by default 32 times, at most 1e8 times sigma_floor). The sums are exact: any
    order of pushes gives the same bits. With small sigmas give sigma_floor=min(sigma), sigma_ceiling=max(sigma).
    double_limb=True keeps all digits where sampling().needs_double_limb says that they are lost, as over small parts of a cycle.
    Whole nanoseconds, push(..., ns=True), count from time_offset_ns and have unit_ns in a unit of t.
    suited_grid(t) gives a grid that suits times.
    """

    _end = "toliman_period_destroy"

    def __init__(self, f0: float, df: float, nf: int, *, fit_mean: bool = True, time_offset: float = 0.0,
                 value_offset: float = 0.0, value_bound: float = 2.0**20, sigma_floor: float = 1.0,
                 sigma_ceiling: float = 0.0, double_limb: bool = False, time_offset_ns: int = 0, unit_ns: float = 1e9):
        options = options_of(
            _raw.toliman_period_options, library.toliman_period_options_init, time_offset=real("time_offset", time_offset),
            value_offset=real("value_offset", value_offset), value_bound=real("value_bound", value_bound),
            sigma_floor=real("sigma_floor", sigma_floor), sigma_ceiling=real("sigma_ceiling", sigma_ceiling),
            time_offset_ns=within("time_offset_ns", time_offset_ns, -INT64, INT64), unit_ns=real("unit_ns", unit_ns),
            flags=(0 if fit_mean else _raw.TOLIMAN_PERIOD_FIXED_MEAN) | (_raw.TOLIMAN_PERIOD_DOUBLE_LIMB if double_limb else 0))
        super().__init__(self._made(library.toliman_period_create, real("f0", f0), real("df", df), whole_float("nf", nf),
                                    ctypes.byref(options)))

    def push(self, t: float, y: float, sigma: float | None = None, *, t_low: float = 0.0, ns: bool = False) -> None:
        """Adds one sample; without sigma it is unweighted. Its time is t + t_low, as astropy's Time.jd1 and jd2, or
        with ns=True t whole nanoseconds."""
        check(library.toliman_period_push_samples(self._c, _sample(t, y, sigma, t_low, ns), 1))

    def push_many(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None) -> None:
        """Adds arrays of samples, all or none; sigma may be one number. Without it they are unweighted."""
        times, values, sigmas = _series(t, y, sigma)
        check(library.toliman_period_push_many(self._c, pointer(times), pointer(values), pointer(sigmas), len(times)))

    def retract(self, t: float, y: float, sigma: float | None = None, *, t_low: float = 0.0, ns: bool = False) -> None:
        """Removes a sample that was pushed with exactly these values."""
        check(library.toliman_period_retract_samples(self._c, _sample(t, y, sigma, t_low, ns), 1))

    def retract_many(self, t: ArrayLike, y: ArrayLike, sigma: ArrayLike | None = None) -> None:
        """Removes arrays of samples, all or none."""
        times, values, sigmas = _series(t, y, sigma)
        check(library.toliman_period_retract_many(self._c, pointer(times), pointer(values), pointer(sigmas),
                                                  len(times)))

    def merge(self, other: View) -> None:
        """Adds all samples of another periodogram, which stays as it is: a shard of the same grid."""
        check(library.toliman_period_merge(self._c, of_kind("other", other, View)._c))

    def reset(self) -> None:
        """Forgets every sample."""
        check(library.toliman_period_reset(self._c))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes all sums to a file, as a whole or not at all."""
        check(library.toliman_period_save_file(self._c, file_name(path)))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Periodogram:
        """A periodogram from such a file; it goes on where the other stood."""
        return cls._adopt(cls._made(library.toliman_period_load_file, file_name(path), None))

    @classmethod
    def from_bytes(cls, content: bytes) -> Periodogram:
        """The same from bytes."""
        content = memoryview(content).tobytes()
        return cls._adopt(cls._made(library.toliman_period_load, content, len(content), None))

    def __reduce__(self):
        return type(self).from_bytes, (self.to_bytes(),)
