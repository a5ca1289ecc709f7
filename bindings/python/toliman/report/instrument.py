"""The instrument over the time of a state folder: goodness of fit, pointing, fluxes, focus and jitter of its frames."""
from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from . import figures
from .page import Page
from .results import Array, Result, Table
from .style import BLUE, DOTS, new_figure, styled

NAMES = {"chi_square": "chi-square", "x_px": "pointing x, px", "y_px": "pointing y, px", "flux_a": "flux of A, relative",
         "flux_b": "flux of B, relative", "focus": "focus, nm", "jitter_xx": "jitter xx, px²", "jitter_yy": "jitter yy, px²"}
WORDS = {"rms": "1.4826 times the median absolute deviation from the median",
         "drifts": "the slope of a line has 5 standard errors, and exceeds 3 times the scatter of a frame from the first to the "
                   "last"}
_BINS = 36


@styled
def over_time(t: Array, panels: dict[str, Array], unit: str) -> Figure:
    """One panel per quantity: every frame, and means over 1/36 of the time."""
    figure, axes = new_figure(0.8 + 1.1 * len(panels), len(panels), sharex=True)
    step = figures.thinned(len(t))
    for axis, (name, values) in zip(axes, panels.items()):
        known = numpy.isfinite(values)
        axis.plot(t[known][::step], values[known][::step], ".", color=DOTS, markersize=3)
        place, mean, error = figures.means(t[known], values[known], _BINS, float(t.min()), float(t.max()))
        axis.errorbar(place, mean, numpy.nan_to_num(error), fmt="o", color=BLUE, markersize=3, elinewidth=0.8)
        axis.set_title(name, loc="left")
    axes[-1].set_xlabel(f"time, {unit}")
    return figure


def add(table: Table, status: Result, unit: str, page: Page) -> None:
    """Adds the figure, and the table of the trends if there are some."""
    t = table.numbers("t")
    panels = {}
    for name, label in NAMES.items():
        values = table.numbers(name, finite=False) if name in table.names else numpy.empty(0)
        if numpy.isfinite(values).any():
            panels[label] = values
    if panels:
        page.add_figure("instrument", over_time(t, panels, unit), "The accepted and unreduced frames: goodness of fit, and what "
                        "each was fitted with. Large dots: means over 1/36 of the time.")
    rows = []
    for trend in status.items("trends"):
        slope, error = trend.number("per_year"), trend.number("sigma_per_year")
        rows.append([" ".join((trend.text("name"), trend.text("unit"))).strip(), f"{trend.number('median'):.4g}",
                     f"{trend.number('rms'):.2g}", f"{slope:+.2g} ± {error:.1g}", f"{slope / error:+.1f}",
                     "drifts" if trend.flag("significant") else ""])
    if rows:
        page.add_table("Trends of the frames.", ["", "median", "rms", "per year", "in standard errors", ""], rows)
        page.explain(WORDS)
