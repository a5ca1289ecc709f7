"""Periodograms of series with correlated noise. Reference: include/toliman/period_noise.h."""
from __future__ import annotations

import ctypes

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._arguments import Doubles, options_of, plain, pointer, real, whole
from ._library import library
from ._progress import Progress, Watch
from ._result_base import result
from ._results import NoisePeak
from .measure import Measurements
from .periodogram import Grid, _series, suited_grid
from .times import plain_times, unit_of


@result
class NoiseSearch(NoisePeak):
    __doc__ = (NoisePeak.__doc__ or "").split("\n\n")[0]

    def __repr__(self) -> str:
        return (f"NoiseSearch(period={self.period:.6g} +- {self.period_error:.2g}, rho={self.rho:.3g} +- "
                f"{self.rho_error:.2g}, log10_fap={self.log10_fap:.4g})")


def _measured(t: Measurements | ArrayLike, y: ArrayLike | None, sigma: ArrayLike | None, functions: ArrayLike | None,
              precision: ArrayLike | None) -> Measurements:
    """The series, or that of arrays with functions[n][k]; a single function may be one-dimensional."""
    if isinstance(t, Measurements):
        if any(one is not None for one in (y, sigma, functions, precision)):
            raise TypeError("t is a series: y, sigma, functions and precision must not be given")
        return t
    plain_t = plain_times("t", t)
    times, values, sigmas = _series(plain_t, y, sigma, unit_of(y))  # type: ignore[arg-type]
    series = Measurements.of(times, values, sigmas)._knows(plain_t is not t and unit_of(t) is None, unit_of(y))
    matrix = numpy.empty((len(times), 0)) if functions is None else plain("functions", functions)
    if matrix.ndim == 1:
        matrix = matrix[:, None]
    if matrix.ndim != 2 or len(matrix) != len(times):
        raise ValueError(f"functions has the shape {matrix.shape}: must be ({len(times)}, number of functions)")
    prior = numpy.zeros(matrix.shape[1:]) if precision is None else plain("precision", precision)
    if prior.shape != matrix.shape[1:]:
        raise ValueError(f"precision has the shape {prior.shape}: must be {matrix.shape[1:]}")
    for place, (column, one) in enumerate(zip(matrix.T, prior)):
        if not one >= 0:
            raise ValueError(f"precision[{place}] = {one}: must be at least 0")
        series.add_column(f"column {place + 1}", column, 1 / one**.5 if one > 0 else 0)
    return series


def search_correlated(t: Measurements | ArrayLike, y: ArrayLike | None = None, sigma: ArrayLike | None = None, *, grid: Grid | None = None,
                      functions: ArrayLike | None = None, precision: ArrayLike | None = None, white: bool = False,
                      progress: Progress | bool | None = None) -> tuple[NoiseSearch, Doubles, Doubles, Doubles]:
    """Searches a series whose noise may be correlated in time, AR(1), for a period.

        found, power, coefficients, errors = toliman.search_correlated(t, y)
        if found.log10_p_white < -3: ...

    The correlation rho of neighbouring samples is fitted, with the mean, the nuisance functions[n][k] and, if it is
    strong, the sinusoid. precision: 1/s**2 of Gaussian priors of the coefficients, 0 for none. white: power and false
    alarm probability for white noise; the whiteness test remains. grid: by default that of suited_grid(t). Returns the
    NoiseSearch, power[nf], and the coefficients of the functions with their standard errors.
    """
    series = _measured(t, y, sigma, functions, precision)
    f0, df, nf = suited_grid(series.t) if grid is None else grid
    k = series.info.functions
    power, coefficients, errors = numpy.empty(whole("nf", nf)), numpy.empty(k), numpy.empty(k)
    found = _raw.toliman_period_noise()
    with Watch(progress) as watch:
        options = options_of(_raw.toliman_period_noise_options,
                             flags=_raw.TOLIMAN_PERIOD_WHITE_NOISE if white else 0, progress=watch.callback)
        watch.check(library.toliman_measure_query_noise(
            series._c, real("f0", f0), real("df", df), len(power), ctypes.byref(options), pointer(power),
            pointer(coefficients), pointer(errors), ctypes.byref(found)))
    return NoiseSearch._of(found, series._units), power, coefficients, errors


def bootstrap_correlated(t: Measurements | ArrayLike, y: ArrayLike | None = None, sigma: ArrayLike | None = None, *, rho: float, grid: Grid | None = None,
                         functions: ArrayLike | None = None, precision: ArrayLike | None = None, count: int = 1000,
                         block: int = 0, seed: int = 0, threads: int = 0,
                         progress: Progress | bool | None = None) -> Doubles:
    """Returns log10(1 - P) of the highest power of each of `count` moving-block resamplings, strongest peak first.

    Residuals are whitened with rho, that of search_correlated(), and drawn in blocks of consecutive samples; block = 0
    means n**(1/3). Other arguments as in search_correlated().
    """
    series = _measured(t, y, sigma, functions, precision)
    f0, df, nf = suited_grid(series.t) if grid is None else grid
    peaks = numpy.empty(whole("count", count))
    with Watch(progress) as watch:
        options = options_of(_raw.toliman_period_noise_bootstrap_options, seed=whole("seed", seed, 2**64),
                             threads=whole("threads", threads, 2**32), block=whole("block", block, 2**64),
                             progress=watch.callback)
        watch.check(library.toliman_measure_query_noise_bootstrap(
            series._c, real("f0", f0), real("df", df), whole("nf", nf), real("rho", rho), ctypes.byref(options), count,
            pointer(peaks)))
    return peaks
