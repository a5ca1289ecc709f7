"""The figures of the page, for notebooks too: functions of arrays that return a matplotlib Figure."""
from __future__ import annotations

import math
import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator, LogLocator, MaxNLocator, NullLocator

from . import style
from .results import Array
from .style import BLUE, DARK, DOTS, GREEN, GREY, ORANGE, new_figure, plain, styled
from .text import decimals_of, fixed, short_unit, with_error

MOST_DOTS = 3000  # frames that are drawn
MOST_CYCLES = 16  # periods along a time axis
BINS = 24  # means per period
_CURVE = 600  # points of a sinusoid
_POINTS = 1500  # of a periodogram: more than the figure has pixels
_SPREAD = 4.2  # standard deviations on either side


class Sinusoid(typing.NamedTuple):
    """offset + amplitude sin(2 pi (t - time_offset)/period + phase)"""

    amplitude: float
    period: float
    phase: float
    offset: float = 0.0
    time_offset: float = 0.0

    def at(self, t: Array) -> Array:
        """Returns the values at times t."""
        angle = 2 * numpy.pi * (t - self.time_offset) / self.period + self.phase
        return self.offset + self.amplitude * numpy.sin(angle)


class Power(typing.NamedTuple):
    """A periodogram and its marks. Marks that are NaN are not drawn: grid_peak, frequency of the highest power; fit and
    fit_error, frequency of the least-squares fit; fwhm of the peak; level, power of a peak with FAP 0.001; grid_error:
    to whose digits the period of the grid peak is shown without a fit."""

    name: str
    frequency: Array
    power: Array
    grid_peak: float = math.nan
    fit: float = math.nan
    fit_error: float = math.nan
    fwhm: float = math.nan
    level: float = math.nan
    grid_error: float = math.nan


def thinned(count: int, most: int = MOST_DOTS) -> int:
    """Returns the step that leaves at most `most` of `count` samples."""
    return max(1, -(-count // most))


def means(x: Array, y: Array, bins: int, start: float, end: float) -> tuple[Array, Array, Array]:
    """Returns place, mean and standard error of y in equal intervals of x; intervals with one sample have no error,
    those without samples are left out."""
    width = (end - start) / bins
    place = numpy.clip(((x - start) / width).astype(int), 0, bins - 1) if width > 0 else numpy.zeros(len(x), int)
    count, total, squares = (numpy.bincount(place, weights, bins) for weights in (None, y, y * y))
    centre = numpy.bincount(place, x, bins)
    filled = count > 0
    n = count[filled]
    mean = total[filled] / n
    variance = numpy.maximum(squares[filled] / n - mean**2, 0) * n / numpy.maximum(n - 1, 1)
    error = numpy.where(n > 1, numpy.sqrt(variance / n), numpy.nan)
    return centre[filled] / n, mean, error


def _centred(values: Array) -> Array:
    return values - values.mean()


def _separation_axes(axes: list[Axes], values: typing.Iterable[Array], truth: Array | None,
                     uas_per_px: float) -> tuple[float, float]:
    """Labels and limits of axes in px, a second axis in microarcsec; returns the factor from px and the limit."""
    spread = max(float(numpy.std(one)) for one in values)
    if truth is not None:
        spread = max(spread, float(numpy.ptp(truth)) / 8)
    factor, unit = short_unit([_SPREAD * spread], "px")
    limit = _SPREAD * spread * factor or 1.0
    for axis in axes:
        axis.set_ylim(-limit, 1.25 * limit)
        axis.set_ylabel(f"separation, {unit}")
        if uas_per_px > 0:
            scale = uas_per_px / factor
            right = axis.secondary_yaxis("right", functions=(lambda y: y * scale, lambda y: y / scale))
            right.set_ylabel("separation, µas")
    return factor, limit


@styled
def series(t: Array, panels: dict[str, Array], truth: Array | None = None, uas_per_px: float = 0.0,
           period: float = math.nan, unit: str = "days", fit: Sinusoid | None = None) -> Figure:
    """Values of each frame along time, less their mean, over means of 1/24 of a period (1/72 of the time without one).

    panels: what was measured: values in px, [frames]. truth: displacement of each frame in px, or None. uas_per_px:
    microarcsec per pixel, 0 for no second axis."""
    figure, axes = new_figure(1.0 + 2.2 * len(panels), len(panels), sharex=True)
    factor, _ = _separation_axes(axes, panels.values(), truth, uas_per_px)
    span = float(numpy.ptp(t))
    bins = max(1, round(BINS * span / period)) if period > 0 else 72
    step = thinned(len(t))
    for axis, (name, values) in zip(axes, panels.items()):
        axis.plot(t[::step], factor * _centred(values)[::step], ".", color=DOTS, markersize=3, label="each frame")
        if truth is not None:
            axis.plot(t[::step], factor * _centred(truth)[::step], color=ORANGE, label="truth")
        if fit is not None:
            x = numpy.linspace(t.min(), t.max(), _CURVE)
            axis.plot(x, factor * (fit.at(x) - values.mean()), color=GREEN, label="best sinusoid")
        place, mean, error = means(t, factor * _centred(values), bins, float(t.min()), float(t.max()))
        axis.errorbar(place, mean, numpy.nan_to_num(error), fmt="o", color=BLUE, markersize=3, elinewidth=0.8,
                      label=f"mean over 1/{BINS} of a period" if period > 0 else "mean over 1/72 of the time")
        axis.set_title(plain(name), loc="left")
        axis.legend(loc="upper right", ncol=4)
    axes[-1].set_xlabel(f"time, {unit}")
    axes[-1].set_xlim(float(t.min()), float(t.max()) if span > 0 else None)
    return figure


def draw_folded(axis: Axes, t: Array, values: Array, period: float, factor: float = 1.0,
                truth: Sinusoid | None = None, fit: Sinusoid | None = None, each: str = "each frame") -> float:
    """Draws factor times values less their mean over the phase of a period, counted from the first time, with their
    means in 24 intervals and the standard errors of these. Returns the height that these and the truth need. each:
    label of the values."""
    phase = numpy.mod((t - t.min()) / period + 1e-9, 1)
    x = numpy.linspace(0, 1, _CURVE)
    step = thinned(len(t))
    axis.plot(phase[::step], factor * _centred(values)[::step], ".", color=DOTS, markersize=3, label=each, zorder=1)
    place, mean, error = means(phase, factor * _centred(values), BINS, 0, 1)
    axis.errorbar(place, mean, numpy.nan_to_num(error), fmt="o", color=BLUE, elinewidth=1, label="mean of 1/24",
                  zorder=4)
    height = float(numpy.nanmax(numpy.abs(mean) + numpy.nan_to_num(error)))
    if truth is not None:
        curve = truth._replace(offset=0.0).at(t.min() + x * truth.period)
        axis.plot(x, factor * curve, color=ORANGE, label="truth", zorder=2)
        height = max(height, factor * abs(truth.amplitude))
    if fit is not None:
        curve = fit.at(t.min() + x * period) - values.mean()
        axis.plot(x, factor * curve, "--", color=GREEN, label="best sinusoid", zorder=3)
    axis.set_xlabel("phase (periods)")
    axis.set_xlim(0, 1)
    return height


@styled
def folded(t: Array, panels: dict[str, Array], period: float, truth: Sinusoid | None = None, uas_per_px: float = 0.0,
           fits: dict[str, Sinusoid] | None = None) -> Figure:
    """Values of each frame over the phase of a period, counted from the first frame, with their means in 24 intervals
    and the standard errors of these. truth, fits: sinusoids in px; a fit belongs to the panel of its name."""
    figure, axes = new_figure(4.0, 1, len(panels), sharey=True)
    factor, _ = _separation_axes(axes, panels.values(), None, 0.0)
    height = 0.0
    for axis, (name, values) in zip(axes, panels.items()):
        height = max(height, draw_folded(axis, t, values, period, factor, truth, (fits or {}).get(name)))
        axis.set_title(plain(name), loc="left")
    axes[0].set_ylim(-2 * height or -1, 2.5 * height or 1)
    axes[0].legend(loc="upper left", ncol=2)
    for axis in axes[1:]:
        axis.set_ylabel("")
    if uas_per_px > 0:
        scale = uas_per_px / factor
        right = axes[-1].secondary_yaxis("right", functions=(lambda y: y * scale, lambda y: y / scale))
        right.set_ylabel("separation, µas")
    return figure


def envelope(frequency: Array, power: Array) -> tuple[Array, Array]:
    """Returns the highest power of each of many narrow intervals of log frequency, so that no peak is lost."""
    above = frequency > 0
    frequency, power = frequency[above], power[above]
    if len(frequency) <= _POINTS:
        return frequency, power
    part = numpy.log(frequency / frequency[0]) / math.log(frequency[-1] / frequency[0])
    place = numpy.minimum((part * _POINTS).astype(int), _POINTS - 1)
    order = numpy.lexsort((power, place))
    last = order[numpy.append(numpy.diff(place[order]) > 0, True)]  # the highest of each place
    return frequency[last], power[last]


def nice(low: float, high: float) -> Array:
    """Returns places of ticks: 1, 2, 5 of each decade; even steps within a decade; powers of ten over many decades."""
    digits = (1, 2, 5) if high < 1e5 * low else (1,)
    locator = MaxNLocator(6, steps=(1, 2, 5, 10)) if high < 8 * low else LogLocator(subs=digits, numticks=20)
    places = locator.tick_values(low, high)
    return places[(places >= low * (1 - 1e-9)) & (places <= high * (1 + 1e-9))]


def set_ticks(axis: typing.Any, places: Array, values: Array) -> None:
    """Labels places of an axis with values."""
    axis.set_major_locator(FixedLocator(places))
    axis.set_major_formatter(FixedFormatter([f"{value:.6g}" for value in values]))
    axis.set_minor_locator(NullLocator())


def _mark_peak(axis: Axes, curve: Power, top: float, middle: float, unit: str) -> None:
    """Marks grid peak, fit with its error, and FWHM; the text is on the side that has more space."""
    at = curve.fit if curve.fit > 0 else curve.grid_peak
    if not at > 0:
        return
    on_right = at > middle
    side, shift = ("right", -10) if on_right else ("left", 10)
    text, dark = [], style.dark(axis)
    if curve.grid_peak > 0:
        axis.plot([curve.grid_peak], [top], "v", color=dark, markersize=7, zorder=5, label="grid peak")
        error = (curve.grid_error if math.isnan(curve.fit_error) else curve.fit_error) / curve.grid_peak**2
        text.append(f"grid peak {fixed(1 / curve.grid_peak, decimals_of(error))} {unit}")
    if curve.fit > 0:
        error = curve.fit_error / curve.fit**2
        known = not math.isnan(error)
        axis.errorbar([curve.fit], [1.08 * top], xerr=[curve.fit_error] if known else None, fmt="D", color=GREEN,
                      capsize=3, zorder=6, label="fit ± error" if known else "fit")
        shown = with_error(1 / curve.fit, error) if known else fixed(1 / curve.fit, 2)
        text.insert(0, f"fit {shown} {unit}")
    axis.annotate("\n".join(text), (at, top), (shift, 0), textcoords="offset points", ha=side, va="center",
                  bbox={"facecolor": style.background(axis), "edgecolor": "none", "alpha": 0.8, "pad": 1})
    if curve.fwhm > 0:
        peak = curve.grid_peak if curve.grid_peak > 0 else at
        low, high = max(peak - curve.fwhm / 2, float(curve.frequency[curve.frequency > 0][0])), peak + curve.fwhm / 2
        axis.annotate("", (low, top / 2), (high, top / 2), arrowprops={"arrowstyle": "<->", "color": dark})
        axis.annotate("FWHM", (low if on_right else high, top / 2), (shift, 0), textcoords="offset points", ha=side,
                      va="center")


def draw_power(axis: Axes, curve: Power, low: float, high: float, unit: str, color: str = BLUE) -> None:
    """Draws power over frequencies low ... high with its marks. unit: of the period."""
    axis.set_xscale("log")
    x, power = envelope(curve.frequency, curve.power)
    axis.plot(x, power, color=color, linewidth=1.1, label=plain(curve.name))
    top = max(float(power.max()), 1e-300)
    if curve.level > 0:
        axis.axhline(curve.level, color=style.dark(axis), linestyle="--", linewidth=1, label="FAP 0.001")
    _mark_peak(axis, curve, top, math.sqrt(low * high), unit)
    axis.set_ylim(0, 1.25 * max(top, curve.level if curve.level > 0 else 0))
    axis.set_ylabel("power (no unit)")
    peak = curve.fit if curve.fit > 0 else curve.grid_peak
    axis.legend(loc="upper left" if peak > math.sqrt(low * high) else "upper right", ncol=4)
    set_ticks(axis.xaxis, nice(low, high), nice(low, high))


def draw_frequencies(bottom: Axes, top: Axes, low: float, high: float, unit: str) -> None:
    """Labels the frequencies below the axes `bottom` and the periods, in `unit`, above the axes `top`."""
    bottom.set_xlabel("frequency, 1/" + ("day" if unit == "days" else unit))
    bottom.set_xlim(low, high)
    top_axis = top.secondary_xaxis("top")
    periods = nice(1 / high, 1 / low)
    set_ticks(top_axis.xaxis, 1 / periods, periods)
    top_axis.set_xlabel(f"period, {unit}")


@styled
def periodogram(curves: typing.Sequence[Power], unit: str = "days") -> Figure | None:
    """Lomb-Scargle power over frequency, one curve per panel, the period on a second axis. Returns None if the grid
    does not have two frequencies above 0. unit: of the period."""
    frequency = curves[0].frequency
    frequency = frequency[frequency > 0]
    if len(frequency) < 2:
        return None
    low, high = float(frequency[0]), float(frequency[-1])
    figure, axes = new_figure(1.3 + 2.0 * len(curves), len(curves), sharex=True)
    for axis, curve, color in zip(axes, curves, (BLUE, style.GOLD, style.PURPLE, DARK)):
        draw_power(axis, curve, low, high, unit, color)
    draw_frequencies(axes[-1], axes[0], low, high, unit)
    return figure


@styled
def bounds(steps: typing.Sequence[str], series: dict[str, list[float]], earth_px: float = math.nan) -> Figure:
    """Bounds (px) of one frame for each set of free parameters, one mark per series; NaN where a bound is infinite."""
    figure, (axis,) = new_figure(height_of_bounds(steps))
    draw_bounds(axis, steps, series, earth_px)
    axis.legend(**style.OUTSIDE)
    return figure


def height_of_bounds(steps: typing.Sequence[str]) -> float:
    """Returns the height in inch of a figure of bounds."""
    return 1.2 + 0.35 * len(steps)


def draw_bounds(axis: Axes, steps: typing.Sequence[str], series: dict[str, list[float]], earth_px: float) -> None:
    """Draws what bounds() shows, without legend."""
    places = numpy.arange(len(steps))[::-1]
    for number, (name, values) in enumerate(series.items()):
        axis.plot(values, places, style.MARKERS[number % len(style.MARKERS)], markersize=7, label=plain(name))
    if earth_px > 0:
        axis.axvline(earth_px, color=style.dark(axis), linestyle="--", linewidth=1, label="an Earth")
    axis.set_xscale("log")
    axis.set_yticks(places, [plain(step) for step in steps])
    axis.margins(0.08)
    axis.set_xlabel("standard deviation of the separation, px")


@styled
def bank(t: Array, latent: Array, fit: Array, efficiency: Array) -> Figure:
    """Latents of a bank of networks against the fit (px), and their efficiency along time (days), of each frame."""
    figure, (left, right) = new_figure(3.6, 1, 2)
    step = thinned(len(t))
    factor, unit = short_unit([float(numpy.abs(fit).max(initial=0))], "px")
    ends = numpy.array([min(latent.min(), fit.min()), max(latent.max(), fit.max())]) * factor
    left.plot(ends, ends, color=ORANGE, label="equal")
    left.plot(factor * fit[::step], factor * latent[::step], ".", color=BLUE, markersize=3, label="each frame")
    left.set_xlabel(f"fit, {unit}")
    left.set_ylabel(f"latent, {unit}")
    left.legend(loc="upper left")
    right.plot(t[::step], efficiency[::step], ".", color=BLUE, markersize=3)
    right.axhline(0.95, color=ORANGE, linestyle="--")
    right.set_ylim(min(0.94, float(efficiency.min())), 1)
    right.set_xlabel("time, days")
    right.set_ylabel("efficiency (no unit)")
    return figure


@styled
def training(step: Array, loss: Array) -> Figure:
    """Loss after each training step."""
    figure, (axis,) = new_figure(3.2)
    axis.semilogy(step, loss, label="loss")
    above = loss[loss > 0]
    if above.size:
        set_ticks(axis.yaxis, *[nice(float(above.min()), float(above.max()))] * 2)
    axis.set_xlabel("training step")
    axis.set_ylabel("1 − cosine² (no unit)")
    return figure


@styled
def detection(methods: dict[str, Array], bound: Array, threshold: float = math.nan) -> Figure:
    """Significance of the highest peak and efficiency of each method over the amplitude of the signal.

    methods: [3][points] per method: amplitude in px, -log10 FAP, efficiency (NaN: not drawn). bound: [2][points],
    amplitude and -log10 FAP of a method at the Cramer-Rao bound. threshold: the amplitude from which such a method is
    expected to find the signal."""
    figure, (top, bottom) = new_figure(6.2, 2, sharex=True)
    top.plot(*bound, "--", color=DARK, label="at the bound")
    top.axhline(3, color=GREY, linewidth=1, label="found: FAP 0.001")
    for number, (name, (amplitude, log_fap, efficiency)) in enumerate(methods.items()):
        look = {"color": f"C{number}", "marker": style.MARKERS[number % len(style.MARKERS)], "markersize": 5}
        top.plot(amplitude, log_fap, label=plain(name), **look)
        bottom.plot(amplitude, efficiency, **look)
    for axis in (top, bottom):
        if threshold > 0:
            axis.axvline(threshold, color=DARK, linestyle=":", linewidth=1.2)
    top.set_xscale("log")
    top.set_yscale("log")
    top.set_ylabel("−log₁₀ FAP (no unit)")
    bottom.axhline(1, color=DARK, linestyle="--")
    bottom.set_ylim(0, 1.15)
    bottom.set_ylabel("efficiency (no unit)")
    bottom.set_xlabel("amplitude of the signal, px")
    top.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    return figure


@styled
def false_alarms(faps: dict[str, Array]) -> Figure:
    """How many series without signal have a FAP of their highest peak in each interval, per method; faps: 0 to 1."""
    count = max(len(values) for values in faps.values())
    bins = 20 if count >= 200 else 10 if count >= 50 else 5
    figure, (axis,) = new_figure(3.6)
    each = count / bins
    sigma = math.sqrt(each * (1 - 1 / bins))
    axis.axhspan(max(0.0, each - sigma), each + sigma, color="#e4e4e4", zorder=0)
    axis.axhline(each, color=DARK, linestyle="--", label="uniform, ± 1 sigma")
    bar = 0.85 / bins / len(faps)
    highest = 0
    for number, (name, values) in enumerate(faps.items()):
        heights, edges = numpy.histogram(values[~numpy.isnan(values)], bins, (0, 1))
        highest = max(highest, int(heights.max()))
        axis.bar(edges[:-1] + 0.075 / bins + bar * (number + 0.5), heights, bar, color=f"C{number}", label=plain(name))
    axis.set_xlim(0, 1)
    axis.set_ylim(0, max(2 * each, each + 5 * sigma, 1.3 * highest) + 1)
    axis.set_xlabel("FAP of the highest peak (no unit)")
    axis.set_ylabel("number of series")
    axis.legend(loc="upper left", ncol=3)
    return figure


@styled
def benchmark(points: dict[str, tuple[Array, Array]], x: str, y: str, logarithmic: bool = True) -> Figure:
    """Two measured quantities against each other, one mark per series; x, y: labels of the axes."""
    figure, (axis,) = new_figure(4.0)
    for number, (name, (at_x, at_y)) in enumerate(points.items()):
        axis.plot(at_x, at_y, style.MARKERS[number % len(style.MARKERS)], color=f"C{number}", markersize=7,
                  label=plain(name))
    if logarithmic:
        axis.set_xscale("log")
        axis.set_yscale("log")
    axis.margins(0.08)
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    return figure
