"""Figures of a series and of its nuisance model: values, values less the model, power of what the sinusoid leaves."""
from __future__ import annotations

import math
import typing

import numpy
from matplotlib.figure import Figure

from . import figures
from .figures import Power, Sinusoid
from .page import Page
from .results import Array, Table
from .style import BLUE, DOTS, GREEN, ORANGE, new_figure, styled
from .text import short_unit

RESIDUAL = "residual_periodogram.csv"


@styled
def before_and_after(t: Array, y: Array, nuisance: Array, fit: Sinusoid | None = None, unit: str = "days",
                     y_unit: str = "") -> Figure:
    """Values with their nuisance model, and values less the model with the fitted sinusoid, along time.

    y, nuisance: [samples], in y_unit. unit: of t."""
    figure, (top, bottom) = new_figure(5.4, 2, sharex=True)
    step, order = figures.thinned(len(t)), numpy.argsort(t)
    middle, rest = float(nuisance.mean()), y - nuisance
    factor, name = short_unit([float(numpy.abs(y - middle).max())], y_unit)
    top.plot(t[::step], factor * (y - middle)[::step], ".", color=DOTS, markersize=3, label="each sample")
    top.plot(t[order], factor * (nuisance - middle)[order], color=ORANGE, label="mean and nuisance functions")
    top.set_ylabel(_label("value less its mean", name))
    factor, name = short_unit([float(numpy.abs(rest).max())], y_unit)
    bottom.plot(t[::step], factor * rest[::step], ".", color=DOTS, markersize=3, label="each sample less these")
    place, mean, error = figures.means(t, rest, 72, float(t.min()), float(t.max()))
    bottom.errorbar(place, factor * mean, factor * numpy.nan_to_num(error), fmt="o", color=BLUE, markersize=3,
                    elinewidth=0.8, label="mean over 1/72 of the time")
    if fit is not None and numpy.ptp(t) / fit.period <= figures.MOST_CYCLES:
        x = numpy.linspace(t.min(), t.max(), 600)
        bottom.plot(x, factor * fit._replace(offset=0.0).at(x), color=GREEN, label="best sinusoid")
    bottom.set_ylabel(_label("residual", name))
    bottom.set_xlabel(f"time, {unit}")
    for axis in (top, bottom):
        low, high = axis.get_ylim()
        axis.set_ylim(low, high + 0.25 * (high - low))
        axis.legend(loc="upper right", ncol=3)
    return figure


def _label(text: str, unit: str) -> str:
    return f"{text}, {unit.strip()}" if unit.strip() else text


def add_series(table: Table, fit: Sinusoid | None, unit: str, y_unit: str, page: Page) -> None:
    """Adds the figure `nuisance` if the series has a column of that name."""
    if "nuisance" not in table.names or len(table.lines) < 2:
        return
    t, y, nuisance = (table.numbers(name) for name in ("t", "y", "nuisance"))
    page.add_figure("nuisance", before_and_after(t, y, nuisance, fit, unit, y_unit),
                    "Above: each value, and mean and nuisance functions as they were fitted together with the sinusoid at "
                    "the peak. Below: their difference.")


def add_residual(table: Table, level: float, unit: str, page: Page) -> None:
    """Adds the figure `residual-periodogram`. level: power of a peak with FAP 0.001; NaN is not drawn."""
    power = table.numbers("power")
    frequency = table.numbers("frequency")
    top = float(frequency[power.argmax()])
    curve = Power("without the sinusoid", frequency, power, top if top > 0 else math.nan, level=level)
    figure = figures.periodogram([curve], unit)
    if figure is not None:
        page.add_figure("residual-periodogram", figure, "Power of the series after the fitted sinusoid is subtracted, with "
                        "the same functions fitted at each frequency. A second signal, or harmonics of an eccentric orbit, "
                        "remain as peaks.")


WORDS: typing.Mapping[str, str] = {
    "nuisance functions": "known functions, such as a trend or the errors of the orbit, whose coefficients are fitted with the "
                          "mean and the sinusoid at each frequency"}
