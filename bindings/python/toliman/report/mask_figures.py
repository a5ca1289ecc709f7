"""Figures of a designed mask, for notebooks too: functions of arrays that return a matplotlib Figure."""
from __future__ import annotations

import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from . import figures
from .images import Panel, images
from .results import Array
from .style import BLUE, OUTSIDE, new_figure, styled
from .text import short_unit

_CLOSED, _OPEN = "#b8b8b8", "#fff8e0"
HEIGHT_OF_MASK = 4.6  # inch
_DEPTH = 1e-3  # lowest value of a logarithmic scale, relative to the highest


@styled
def mask(cells: Array, amplitude: Array | None = None) -> Figure:
    """Cells of the pupil: 1 where the mask steps. amplitude: transmission of each cell, 0 where it is closed."""
    figure, (axis,) = new_figure(HEIGHT_OF_MASK)
    draw_mask(axis, cells, amplitude, **OUTSIDE)
    return figure


def draw_mask(axis: Axes, cells: Array, amplitude: Array | None = None, **legend: typing.Any) -> None:
    """Draws what mask() shows. legend: options of Axes.legend()."""
    side = len(cells)
    kinds = cells + 1 if amplitude is None else numpy.where(amplitude > 0, cells + 1, 0)
    axis.imshow(kinds, cmap=ListedColormap([_CLOSED, _OPEN, BLUE]), vmin=0, vmax=2, extent=(-side / 2, side / 2) * 2)
    axis.grid(False)
    axis.set_xlabel("x, cells")
    axis.set_ylabel("y, cells")
    names = {"step": BLUE, "no step": _OPEN, "closed": _CLOSED}
    patches = [Patch(facecolor=colour, edgecolor="#444444", linewidth=0.5, label=name) for name, colour in names.items()]
    axis.legend(handles=patches[:2 if amplitude is None else 3], **legend)


def _panel(title: str, values: Array, unit: str) -> Panel:
    rows, columns = values.shape
    return Panel(title, values, -(columns - 1) / 2, -(rows - 1) / 2, 1.0, unit, "px", "log")


@styled
def information(frame: Array, unit: str, share: Array, stars: dict[str, tuple[float, float]]) -> Figure:
    """The noise-free frame in `unit`, and the share of each pixel in the information. stars: {name: (x, y)}, px from the
    centre of the frame."""
    figure = images([_panel("noise-free frame", frame, unit),
                     _panel("information", share, "share of the information (no unit)")])
    for axis in figure.axes[:2]:
        norm = axis.images[0].norm
        norm.vmin = _DEPTH * norm.vmax
        for name, (x, y) in stars.items():
            axis.plot([x], [y], "+", color="white", markersize=7, markeredgewidth=1)
            axis.annotate(name, (x, y), (5, 4), textcoords="offset points", color="white", weight="bold")
    return figure


@styled
def descent(bounds: Array) -> Figure:
    """Bound (px) of the sketch in each iteration; NaN where it is infinite."""
    figure, (axis,) = new_figure(3.2)
    factor, unit = short_unit(bounds, "px")
    axis.semilogy(numpy.arange(1, len(bounds) + 1), factor * bounds, color=BLUE)
    low, high = axis.get_ylim()
    figures.set_ticks(axis.yaxis, *[figures.nice(low, high)] * 2)
    axis.set_xlabel("iteration")
    axis.set_ylabel(f"bound of the sketch, {unit}")
    return figure
