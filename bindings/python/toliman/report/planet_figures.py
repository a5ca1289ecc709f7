"""Figures of planets: folded series, posterior, limits and detection map; functions of arrays that return a Figure."""
from __future__ import annotations

import math
import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator, ScalarFormatter

from . import figures, style
from .results import Array
from .style import BLUE, DARK, DOTS, GREEN, GREY, ORANGE, new_figure, plain, styled

SOLAR = {"Venus": (224.70, 0.815), "Earth": (365.25, 1.0), "Mars": (686.98, 0.107), "Neptune": (60190.0, 17.15)}
BELOW = "the odds are below the threshold"  # the reason of candidates that are not in the joint fit
HEIGHT_OF_FOLDED, HEIGHT_OF_LIMITS = 5.4, 4.2  # inch
_BINS = 40  # of a histogram of samples
_CURVE = 600  # points of a folded signal


class Orbit(typing.NamedTuple):
    """Signal of a planet: see toliman/planet.h. periastron: radians; velocity: whether it is that of a velocity."""

    period: float
    eccentricity: float
    periastron: float
    epoch: float
    amplitude: float
    velocity: bool

    def at(self, phase: Array) -> Array:
        """Returns the signal at phases since periastron, in periods; on the mean axis."""
        mean = 2 * numpy.pi * phase
        e = self.eccentricity
        anomaly = mean + e * numpy.sin(mean)
        for _ in range(50):  # Newton's method, from a start that converges up to e = 0.95
            anomaly = anomaly - (anomaly - e * numpy.sin(anomaly) - mean) / (1 - e * numpy.cos(anomaly))
        true = 2 * numpy.arctan2(math.sqrt(1 + e) * numpy.sin(anomaly / 2), math.sqrt(1 - e) * numpy.cos(anomaly / 2))
        if self.velocity:
            return self.amplitude * (numpy.cos(true + self.periastron) + e * math.cos(self.periastron))
        return self.amplitude * (1 - e * numpy.cos(anomaly)) * numpy.cos(true + self.periastron)


@styled
def folded(t: Array, signal: Array, residual: Array, orbit: Orbit, unit: str) -> Figure:
    """Series less all but one signal, and residuals, over the phase since periastron. Values in `unit`."""
    figure, (top, bottom) = new_figure(HEIGHT_OF_FOLDED, 2, sharex=True)
    draw_folded(top, t, signal + residual, orbit, unit)
    draw_residuals(bottom, t, residual, orbit, unit)
    label_phase(bottom)
    return figure


def _draw_samples(axis: Axes, t: Array, values: Array, orbit: Orbit) -> None:
    """Draws values over the phase since periastron, and their means."""
    phase = numpy.mod((t - orbit.epoch) / orbit.period, 1)
    step = figures.thinned(len(t))
    axis.plot(phase[::step], values[::step], ".", color=DOTS, markersize=4, label="each sample")
    place, mean, error = figures.means(phase, values, figures.BINS, 0, 1)
    axis.errorbar(place, mean, numpy.nan_to_num(error), fmt="o", color=BLUE, markersize=3, elinewidth=0.8,
                  label=f"mean of 1/{figures.BINS}")


def draw_folded(axis: Axes, t: Array, values: Array, orbit: Orbit, unit: str) -> None:
    """Draws the series less all but one signal, and the orbit, over the phase since periastron."""
    _draw_samples(axis, t, values, orbit)
    x = numpy.linspace(0, 1, _CURVE)
    axis.plot(x, orbit.at(x), color=GREEN, label="best orbit")
    axis.set_ylabel(f"signal, {unit}" if unit else "signal")
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.2 * (high - low))
    axis.legend(loc="upper right", ncol=3)


def draw_residuals(axis: Axes, t: Array, residual: Array, orbit: Orbit, unit: str) -> None:
    """Draws residuals over the phase since periastron."""
    _draw_samples(axis, t, residual, orbit)
    axis.axhline(0, color=GREEN)
    axis.set_ylabel(f"residual, {unit}" if unit else "residual")


def label_phase(axis: Axes) -> None:
    """Labels the phase of the last axes of a figure."""
    axis.set_xlabel("phase since periastron (periods)")
    axis.set_xlim(0, 1)


@styled
def corner(columns: typing.Sequence[tuple[str, Array]]) -> Figure:
    """Histograms of the samples of a posterior and of all pairs of their columns (name, values)."""
    size = len(columns)
    figure, axes = new_figure(2.0 * size, size, size)
    draw_corner(axes, columns)
    return figure


def draw_corner(axes: typing.Sequence[Axes], columns: typing.Sequence[tuple[str, Array]]) -> None:
    """Draws what corner() shows on n x n axes, row by row."""
    size = len(columns)
    for row, (name_y, y) in enumerate(columns):
        for column, (name_x, x) in enumerate(columns):
            axis = axes[row * size + column]
            if column > row:
                axis.set_visible(False)
                continue
            _draw_pair(axis, x, None if row == column else y)
            axis.tick_params(labelsize=8, labelbottom=row == size - 1, labelleft=column == 0 and row > 0)
            axis.set_xlabel(plain(name_x) if row == size - 1 else "")
            axis.set_ylabel(plain(name_y) if column == 0 and row > 0 else "")


def _draw_pair(axis: Axes, x: Array, y: Array | None) -> None:
    places = [axis.xaxis]
    if y is None:
        axis.hist(x, _BINS, range=_range(x), color=BLUE)
        axis.set_xlim(_range(x))
        for point in numpy.percentile(x, (16, 50, 84)):
            axis.axvline(point, color=DARK, linestyle="--", linewidth=0.8)
        axis.yaxis.set_major_locator(NullLocator())
    else:
        heights, edges_x, edges_y = numpy.histogram2d(x, y, _BINS, (_range(x), _range(y)))
        shown = numpy.ma.masked_equal(heights.T, 0)
        axis.imshow(shown, extent=(edges_x[0], edges_x[-1], edges_y[0], edges_y[-1]), aspect="auto", origin="lower")
        places.append(axis.yaxis)
    axis.grid(False)
    for place in places:
        place.set_major_locator(MaxNLocator(3))
        place.set_major_formatter(ScalarFormatter(useOffset=False))


def _range(values: Array) -> tuple[float, float]:
    low, high = numpy.percentile(values, (0.1, 99.9))
    return (float(low), float(high)) if high > low else (float(low) - 0.5, float(low) + 0.5)


@styled
def limits(period: Array, upper: Array, detectable: Array, unit: str, found: typing.Sequence[tuple[float, float]] = (),
           masses: bool = False) -> Figure:
    """Upper limits and detectable sizes along the period, days. found: period and size of planets. masses: sizes are
    masses in Earths, and planets of the solar system are marked."""
    figure, (axis,) = new_figure(HEIGHT_OF_LIMITS)
    draw_limits(axis, period, upper, detectable, unit, found, masses)
    axis.legend(**style.OUTSIDE)
    return figure


def draw_limits(axis: Axes, period: Array, upper: Array, detectable: Array, unit: str,
                found: typing.Sequence[tuple[float, float]], masses: bool) -> None:
    """Draws what limits() shows, without legend."""
    axis.plot(period, upper, color=BLUE, label="upper limit")
    axis.plot(period, detectable, "--", color=ORANGE, label="detectable")
    if found:
        axis.plot(*zip(*found), "*", color=GREEN, markersize=12, label="planets of this series")
    sizes = numpy.concatenate([upper, detectable, [size for _, size in found]])
    sizes = sizes[numpy.isfinite(sizes)]
    if masses:  # also the planets of the solar system, unless the limits are far from them
        near = [mass for _, mass in SOLAR.values() if sizes.min() / 10 <= mass <= 10 * sizes.max()]
        sizes = numpy.append(sizes, near)
    _set_axes(axis, period, numpy.array([0.8 * sizes.min(), 1.4 * sizes.max()]), unit)
    if masses:
        _mark_solar(axis)


@styled
def detection_map(periods: Array, sizes: Array, fraction: Array, unit: str, masses: bool,
                  detectable: tuple[Array, Array] | None = None) -> Figure:
    """Fraction of injected planets that are detected, [sizes][periods], between the edges of cells; detectable: period
    and size of the analytic limit."""
    figure, (axis,) = new_figure(4.8)
    shown = axis.pcolormesh(periods, sizes, fraction, vmin=0, vmax=1, cmap="Blues")
    if detectable is not None:
        axis.plot(*detectable, color=ORANGE, label="detectable")
        axis.legend(loc="upper right")
    _set_axes(axis, periods, sizes, unit)
    if masses:
        _mark_solar(axis)
    axis.grid(False)
    figure.colorbar(shown, ax=axis, label="fraction detected (no unit)")
    return figure


def _set_axes(axis: Axes, periods: Array, sizes: Array, unit: str) -> None:
    """Logarithmic axes of period and size, from the least to the largest."""
    for place, low, high in ((axis.xaxis, periods.min(), periods.max()), (axis.yaxis, sizes.min(), sizes.max())):
        place.axes.set(**{f"{place.axis_name}scale": "log", f"{place.axis_name}lim": (low, high)})
        ticks = figures.nice(float(low), float(high))
        figures.set_ticks(place, ticks, ticks)
    axis.set_xlabel("period, days")
    axis.set_ylabel(unit)


def _mark_solar(axis: Axes) -> None:
    """Points of the planets of the solar system that are in the range; lines for the masses of others."""
    for name, (period, mass) in SOLAR.items():
        if not axis.get_ylim()[0] <= mass <= axis.get_ylim()[1]:
            continue
        low, high = axis.get_xlim()
        inside = low <= period <= high
        if inside:
            axis.plot([period], [mass], "o", color=style.dark(axis), markeredgecolor=style.background(axis),
                      markersize=6)
        else:
            axis.axhline(mass, color=GREY, linewidth=1)
        axis.annotate(name if inside else f"mass of {name}", (period if inside else low, mass), (6, 4),
                      textcoords="offset points",
                      bbox={"facecolor": style.background(axis), "edgecolor": "none", "alpha": 0.7, "pad": 1})
