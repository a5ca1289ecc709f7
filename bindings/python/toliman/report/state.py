"""The section of a state folder of `toliman track`, from the files of `toliman status --out`."""
from __future__ import annotations

import math
import pathlib

import numpy

from . import detrending, figures, glossary, instrument, results
from .figures import Power, Sinusoid
from .page import Page, add_provenance
from .results import Result, Table
from .text import LOG_FAP, decimals_of, fixed, scaled, significant, with_error

_WORDS = {
    "sequential FAP": "the same for repeated monitoring, after every frame: how often noise alone has such a peak at "
                      "any number of frames",
    "outliers": "good frames whose value exceeds the limit, or whose time the periodogram cannot represent: not in the "
                "periodogram",
    "quarantined": "frames that arrived with two different contents: neither is used",
    **glossary.FAP, **glossary.FWHM, **glossary.PEAKS,
}
_COUNTS = {"received": "received", "accepted": "accepted", "outlier": "outliers", "quarantined": "quarantined",
           "repeated": "repeated", "rejected": "rejected"}
_MORE = {"expected": "expected", "missing": "missing", "dropped": "dropped by the camera",
         "sessions": "sessions and regions"}


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of a state folder to the page."""
    result = results.load(folder / "result.json", "toliman-state/1")
    status = Result(result.path, result.find("status"), "status.") if isinstance(result.find("status"), dict) else None
    if status is None:
        raise result.fail("status", "an object")
    unit_s = result.positive("unit_s")
    unit = "days" if unit_s == 86400 else f"units of {unit_s:g} s"
    fit = Result(result.path, status.find("fit"), "status.fit.") if status.has("fit") else None
    page.add("title", "toliman track: " + status.text("folder"))
    page.add("found", "All frames so far: " + _period_text(status, fit, unit))
    add_provenance(page, result)
    _add_goodness(status, page)
    _add_counts(status, page)
    if (folder / "frames.csv").exists():
        instrument.add(Table(folder / "frames.csv"), status, unit, page)
    table = Table(folder / "series.csv")
    if len(table.lines) > 1:
        _add_series(table, fit, unit, page)
        detrending.add_series(table, _wave(fit), unit, "px", page)
    if status.has("period"):
        _add_periodogram(Table(folder / "periodogram.csv"), result, status, fit, unit, page)
    if (folder / detrending.RESIDUAL).exists():
        detrending.add_residual(Table(folder / detrending.RESIDUAL), result.number("power_at_fap_1e-3"), unit, page)
    page.explain({**_WORDS, **detrending.WORDS} if "nuisance" in table.names else _WORDS)


def _period_text(status: Result, fit: Result | None, unit: str) -> str:
    if not status.has("log10_fap"):
        return "no period yet."
    period, error, fap = status.number("period"), math.nan, status.number("log10_fap")
    sequential = status.number("log10_fap_sequential")
    if fit is not None:
        period, error, fap = fit.number("period"), fit.number("period_error"), fit.number("log10_fap")
    return (f"period {with_error(period, error)} {unit}, {LOG_FAP} {fixed(fap, 1)}; sequential, for repeated "
            f"monitoring, {fixed(sequential, 1)}." + ("" if significant(sequential) else " This is not a significant "
                                                                                         "period."))


def _add_goodness(status: Result, page: Page) -> None:
    if not isinstance(status.find("goodness"), dict):  # of an earlier version
        return
    goodness = Result(status.path, status.find("goodness"), "status.goodness.")
    if goodness.has("calibration"):
        of = Result(status.path, goodness.find("calibration"), "status.goodness.calibration.")
        page.add("text", f"Calibration {'complete' if of.flag('complete') else 'incomplete'}: chi-square "
                         f"{with_error(of.number('chi_square'), of.number('chi_square_sigma'))}, {of.text('goodness')}.")
    if goodness.has("chi_square"):
        page.add("text", f"Chi-square of the frames: median {goodness.number('chi_square'):.4g}, {goodness.text('goodness')}; "
                         f"{goodness.whole('poor')} poor, {goodness.whole('too_good')} too good, {goodness.whole('misfit')} "
                         "misfits.")


def _add_counts(status: Result, page: Page) -> None:
    rows = [[word, str(status.whole(key))] for key, word in _COUNTS.items()]
    reasons = status.find("rejected_by")
    if not isinstance(reasons, dict):
        raise status.fail("rejected_by", "an object")
    of = Result(status.path, reasons, "status.rejected_by.")
    rows += [["\u2003" + reason, str(of.whole(reason))] for reason in reasons if of.whole(reason) > 0]
    rows += [[word, str(status.whole(key))] for key, word in _MORE.items()]
    page.add_table("Frames by their verdict. Every arrival of a rejected frame counts.", ["", "frames"], rows)


def _wave(fit: Result | None) -> Sinusoid | None:
    if fit is None or not (fit.has("period") and fit.has("amplitude_error")):
        return None
    return Sinusoid(*(fit.number(key) for key in ("amplitude", "period", "phase", "offset")))


def _add_series(table: Table, fit: Result | None, unit: str, page: Page) -> None:
    t, y = table.numbers("t"), table.numbers("y")
    wave = _wave(fit)
    found = fit is not None and wave is not None and significant(fit.number("log10_fap"))
    cycles = numpy.ptp(t) / wave.period if wave is not None else 0.0
    caption = "The value of each frame in the periodogram, less their mean"
    if fit is not None and wave is not None:
        caption += (", and the sinusoid that fits best: amplitude "
                    f"{scaled(wave.amplitude, fit.number('amplitude_error'))} px, "
                    f"period {with_error(wave.period, fit.number('period_error'))} {unit}")
    step = figures.thinned(len(t))
    thinned = f" One of {step} frames is drawn." if step > 1 else ""
    if not found or cycles <= figures.MOST_CYCLES:
        figure = figures.series(t, {"all frames": y}, period=wave.period if found and wave else math.nan, unit=unit,
                                fit=wave if cycles <= figures.MOST_CYCLES else None)
        page.add_figure("series", figure, f"{caption}.{thinned}")
    if found and wave is not None:
        page.add_figure("folded", figures.folded(t, {"all frames": y}, wave.period, fits={"all frames": wave}),
                        f"{caption}; folded over this period, from the first frame on.{thinned}")


def _add_periodogram(table: Table, result: Result, status: Result, fit: Result | None, unit: str, page: Page) -> None:
    period = error = math.nan
    if fit is not None:
        period, error = fit.number("period"), fit.number("period_error")
    grid = status.number("period")
    curve = Power("all frames", table.numbers("frequency"), table.numbers("power"), status.number("frequency"),
                  1 / period, error / period**2, status.number("fwhm_period") / grid**2,
                  result.number("power_at_fap_1e-3"))
    figure = figures.periodogram([curve], unit)
    if figure is None:
        page.add("text", "No figure of the periodogram: its grid does not have two frequencies above 0.")
        return
    page.add_figure("periodogram", figure, f"Lomb-Scargle power on the grid of the folder; highest at a period of "
                    f"{fixed(grid, decimals_of(error))} {unit} (grid peak). The dashed line holds for one query; for "
                    "repeated monitoring the sequential FAP applies.")
