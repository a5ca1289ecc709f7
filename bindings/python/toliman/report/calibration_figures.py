"""Figures of a calibration, for notebooks too: functions of arrays that return a matplotlib Figure."""
from __future__ import annotations

import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from . import style
from .results import Array
from .style import BLUE, DARK, GREY, ORANGE, new_figure, plain, styled
from .text import short_unit

_MOST_NAMES = 40  # that fit along an axis


class Track(typing.NamedTuple):
    """A parameter in each window: values and standard deviations, [windows]."""

    name: str
    unit: str
    values: Array
    sigmas: Array


@styled
def bars(names: typing.Sequence[str], values: Array, sigmas: Array, unit: str) -> Figure:
    """Values of parameters with their standard deviations, where these are large enough to be seen."""
    figure, (axis,) = new_figure(3.4)
    draw_bars(axis, names, values, sigmas, unit)
    return figure


def draw_bars(axis: Axes, names: typing.Sequence[str], values: Array, sigmas: Array, unit: str) -> None:
    """Draws what bars() shows. unit: "" for numbers without one."""
    places, dark = numpy.arange(len(names)), style.dark(axis)
    axis.bar(places, values, 0.7, color=BLUE, yerr=sigmas, ecolor=dark, capsize=2)
    axis.axhline(0, color=dark, linewidth=0.8)
    axis.set_xticks(places, [plain(name) for name in names], rotation=90 if len(names) > 8 else 0)
    axis.set_ylabel(_change(unit))


def _change(unit: str) -> str:
    return f"change, {plain(unit)}" if unit else "change (no unit)"


@styled
def correlations(names: typing.Sequence[str], matrix: Array) -> Figure:
    """The correlation matrix of parameters."""
    figure, (axis,) = new_figure(height_of_correlations(names))
    draw_correlations(axis, names, matrix)
    return figure


def height_of_correlations(names: typing.Sequence[str]) -> float:
    """Returns the height in inch of a figure of correlations."""
    return min(8.0, 2.4 + 0.22 * len(names))


def draw_correlations(axis: Axes, names: typing.Sequence[str], matrix: Array) -> None:
    """Draws what correlations() shows."""
    count = len(names)
    shown = axis.imshow(matrix, cmap=style.DIFFERENCE, vmin=-1, vmax=1, origin="upper")
    axis.grid(False)
    step = -(-count // _MOST_NAMES)
    labels = [plain(name) for name in names[::step]]
    axis.set_xticks(range(0, count, step), labels, rotation=90)
    axis.set_yticks(range(0, count, step), labels)
    axis.figure.colorbar(shown, ax=axis, label="correlation (no unit)")


@styled
def convergence(parameters: Array, of_map: Array) -> Figure:
    """Chi-square per degree of freedom after each iteration, [2][iterations]: number and value."""
    figure, (axis,) = new_figure(3.2)
    for points, colour, name in ((parameters, BLUE, "parameters"), (of_map, ORANGE, "map")):
        if points.size:
            axis.plot(*points, "o-", color=colour, label=name)
    axis.axhline(1, color=GREY, linestyle="--", label="noise alone")
    axis.set_yscale("log")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.set_xlabel("iteration")
    axis.set_ylabel("chi-square per\ndegree of freedom (no unit)")
    axis.legend(loc="upper right")
    return figure


@styled
def windows(days: Array, tracks: typing.Sequence[Track]) -> Figure:
    """Parameters over time: change from the first window, one panel per unit."""
    units = list(dict.fromkeys(track.unit for track in tracks))
    figure, axes = new_figure(1.0 + 2.2 * len(units), len(units), sharex=True)
    for axis, unit in zip(axes, units):
        for number, track in enumerate(track for track in tracks if track.unit == unit):
            axis.errorbar(days, track.values - track.values[0], track.sigmas, fmt="o-",
                          color=style.CYCLE[number % len(style.CYCLE)], label=plain(track.name))
        axis.axhline(0, color=DARK, linewidth=0.8)
        axis.set_ylabel(_change(unit))
        axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    axes[-1].set_xlabel("start of the window, days")
    return figure


@styled
def separations(days: Array, displacements: Array, sigmas: Array) -> Figure:
    """Separation of each frame minus the predicted one, px, with its standard deviation."""
    figure, (axis,) = new_figure(3.2)
    factor, unit = short_unit(displacements, "px")
    axis.errorbar(days, factor * displacements, factor * sigmas, fmt="o", color=BLUE, label="each frame")
    axis.axhline(0, color=GREY, linestyle="--", label="predicted")
    axis.set_xlabel("time, days")
    axis.set_ylabel(f"separation minus\nthe predicted one, {unit}")
    axis.legend(loc="upper right")
    return figure
