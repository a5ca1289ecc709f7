"""Figures of images: pupil, point spread functions, frames and residuals; functions of arrays that return a Figure."""
from __future__ import annotations

import math
import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from . import style
from .results import Array
from .style import BLUE, ORANGE, new_figure, plain, styled

DEPTH = 1e-5  # lowest value of a logarithmic scale, relative to the highest
_ARROW = 0.16  # length of the arrows north and east, relative to the side of the image


class Panel(typing.NamedTuple):
    """An image: pixel [row][column] is at (first_x + column step, first_y + row step). scale: "log", "linear" or
    "difference" (0 in the middle); unit: of the values; axis_unit: of the positions."""

    title: str
    values: Array
    first_x: float
    first_y: float
    step: float
    unit: str
    axis_unit: str = "arcsec"
    scale: str = "linear"


class Sky(typing.NamedTuple):
    """What is marked on an image: stars {name: (x, y)} in the unit of the axes, unit vectors to north and east."""

    stars: dict[str, tuple[float, float]]
    north: tuple[float, float]
    east: tuple[float, float]


def _norm(panels: typing.Sequence[Panel], limit: float) -> Normalize:
    """The scale that panels share."""
    values = numpy.concatenate([panel.values.ravel() for panel in panels])
    values = values[numpy.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    if panels[0].scale == "log" and high > 0:
        return LogNorm(DEPTH * high, high, clip=True)
    if panels[0].scale == "difference":
        most = limit if limit > 0 else max(abs(low), abs(high)) or 1.0
        return Normalize(-most, most)
    return Normalize(low, high if high > low else low + 1)


def _draw(axis: Axes, panel: Panel, norm: Normalize) -> typing.Any:
    rows, columns = panel.values.shape
    left, bottom = panel.first_x - panel.step / 2, panel.first_y - panel.step / 2
    extent = left, left + columns * panel.step, bottom, bottom + rows * panel.step
    shown = axis.imshow(panel.values, norm=norm, extent=extent,
                        cmap=style.DIFFERENCE if panel.scale == "difference" else style.INTENSITY, origin="lower")
    axis.set_facecolor("#b8b8b8")
    axis.grid(False)
    axis.set_title(plain(panel.title))
    axis.set_xlabel(f"x, {panel.axis_unit}")
    return shown


def _mark(axis: Axes, panel: Panel, sky: Sky) -> None:
    """Names the stars; arrows to north and east start where they fit, near the lower left corner."""
    for name, (x, y) in sky.stars.items():
        axis.plot([x], [y], "+", color="white", markersize=9, markeredgewidth=1.2, gid=f"star-{name}")
        axis.annotate(name, (x, y), (6, 5), textcoords="offset points", color="white", weight="bold")
    rows, columns = panel.values.shape
    side = _ARROW * min(rows, columns) * panel.step
    x, y = (first + side * (0.6 - 1.3 * min(0.0, sky.north[i], sky.east[i]))
            for i, first in enumerate((panel.first_x, panel.first_y)))
    for letter, (dx, dy) in (("N", sky.north), ("E", sky.east)):
        axis.annotate("", (x + side * dx, y + side * dy), (x, y), arrowprops={"arrowstyle": "->", "color": "white"})
        axis.text(x + 1.3 * side * dx, y + 1.3 * side * dy, letter, color="white", ha="center", va="center")


@styled
def images(panels: typing.Sequence[Panel], sky: Sky | None = None, limit: float = math.nan) -> Figure:
    """Images side by side; neighbours of one scale and unit share a colour bar. sky: marks on the images whose axes are
    in arcsec. limit: end of a difference's scale."""
    figure, axes = new_figure(height_of(panels), 1, len(panels))
    draw_images(axes, panels, sky, limit)
    return figure


def height_of(panels: typing.Sequence[Panel]) -> float:
    """Returns the height in inch of a figure of images."""
    tallest = max(panel.values.shape[0] / panel.values.shape[1] for panel in panels)
    bars = len(_groups(panels))
    return 0.6 + (style.WIDTH - 0.8 - 1.1 * bars) / max(2, len(panels)) * tallest


def draw_images(axes: typing.Sequence[Axes], panels: typing.Sequence[Panel], sky: Sky | None = None,
                limit: float = math.nan) -> None:
    """Draws what images() shows on axes of one figure."""
    axes[0].set_ylabel(f"y, {panels[0].axis_unit}")
    for start, end in _groups(panels):
        norm = _norm(panels[start:end], limit)
        for axis, panel in zip(axes[start:end], panels[start:end]):
            shown = _draw(axis, panel, norm)
            if sky is not None and panel.axis_unit == "arcsec" and panel.scale == "log":
                _mark(axis, panel, sky)
        extend = "min" if panels[start].scale == "log" else "neither"
        places = axes[start] if end == start + 1 else axes[start:end]
        axes[0].figure.colorbar(shown, ax=places, label=plain(panels[start].unit), fraction=0.05, pad=0.02,
                                extend=extend)


def _groups(panels: typing.Sequence[Panel]) -> list[tuple[int, int]]:
    """Ranges of neighbours that share a colour bar."""
    starts = [i for i, panel in enumerate(panels)
              if i == 0 or (panel.scale, panel.unit, panel.axis_unit) != (panels[i - 1].scale, panels[i - 1].unit,
                                                                         panels[i - 1].axis_unit)]
    return list(zip(starts, starts[1:] + [len(panels)]))


@styled
def cut(curves: dict[str, Array], x: Array, resolution: float) -> Figure:
    """Cuts through point spread functions along x, through the star. curves: fraction of the light per pixel at each x;
    x: arcsec from the star; resolution: wavelength over aperture in arcsec, the unit of the second axis."""
    figure, (axis,) = new_figure(3.6)
    for name, values in curves.items():
        axis.semilogy(x, values, label=plain(name), linewidth=1.1)
    highest = max(float(numpy.nanmax(values)) for values in curves.values())
    axis.set_ylim(DEPTH * highest, 2 * highest)
    axis.set_xlim(float(x[0]), float(x[-1]))
    axis.set_xlabel("x, arcsec")
    axis.set_ylabel("fraction of the light\nper pixel (no unit)")
    axis.legend(loc="upper right", ncol=3)
    top = axis.secondary_xaxis("top", functions=(lambda at: at / resolution, lambda at: at * resolution))
    top.set_xlabel("x, λ/D")
    return figure


def radial_power(residuals: Array) -> tuple[Array, Array, Array]:
    """Returns spatial frequency in cycles per pixel, mean power and its standard error of residual images
    [images][rows][columns], in units of their variance: 1 everywhere for white noise."""
    count, rows, columns = residuals.shape
    power = (numpy.abs(numpy.fft.fft2(residuals)) ** 2).mean(axis=0) / (rows * columns) / residuals.var()
    radius = numpy.hypot(numpy.fft.fftfreq(rows, 1.0)[:, None], numpy.fft.fftfreq(columns, 1.0))
    inside = (radius > 0) & (radius <= 0.5)
    place = numpy.minimum((radius[inside] * 40).astype(int), 19)
    number = numpy.bincount(place, minlength=20)
    with numpy.errstate(invalid="ignore", divide="ignore"):
        frequency = numpy.bincount(place, radius[inside], 20) / number
        mean = numpy.bincount(place, power[inside], 20) / number
        error = mean / numpy.sqrt(number / 2 * count)  # a frequency and its negative have the same power
    return frequency, mean, error


@styled
def whiteness(residuals: Array) -> Figure:
    """Histogram and power spectrum of residuals over their sigma, [images][rows][columns], and those of white noise."""
    figure, (left, right) = new_figure(3.4, 1, 2)
    values = residuals[numpy.isfinite(residuals)]
    edges = numpy.linspace(-5, 5, 51)
    heights = numpy.histogram(values, edges)[0] / (len(values) * 0.2)
    left.stairs(heights, edges, color=BLUE, label="residuals")
    x = numpy.linspace(-5, 5, 201)
    left.plot(x, numpy.exp(-x * x / 2) / math.sqrt(2 * math.pi), "--", color=ORANGE, label="Gaussian, sigma 1")
    left.set_yscale("log")
    left.set_ylim(1e-6, 1)
    left.set_xlabel("residual, sigma of the pixel")
    left.set_ylabel("probability density")
    left.legend(loc="lower center")
    frequency, power, error = radial_power(residuals)
    right.errorbar(frequency, power, error, fmt="o", color=BLUE, label="residuals")
    right.axhline(1, color=ORANGE, linestyle="--", label="white noise")
    spread = max(0.1, float(numpy.nanmax(numpy.abs(power - 1))) * 1.3)
    right.set_ylim(1 - spread, 1 + spread)
    right.set_xlim(0, 0.5)
    right.set_xlabel("spatial frequency, cycles per pixel")
    right.set_ylabel("power over variance (no unit)")
    right.legend(loc="upper right")
    return figure
