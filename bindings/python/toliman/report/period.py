"""The section of a folder of `toliman period --out`: period, coefficients, series and periodograms."""
from __future__ import annotations

import math
import pathlib

from . import detrending, figures, glossary, results
from .figures import Power, Sinusoid
from .page import Page, add_provenance
from .results import Result, Table, goodness_of
from .text import LOG_FAP, UNKNOWN, fixed, scientific, significant, with_error

SCHEMA = "toliman-period/2"


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of a series to the page."""
    result = results.load(folder / "result.json", SCHEMA)
    unit = "days" if result.has("time_scale") else "units of t"
    page.add("title", f"toliman period: {folder.resolve().name}")
    peak = _peak(result)
    page.add("found", _found(result, peak, unit))
    add_provenance(page, result)
    if result.has("functions"):
        _add_coefficients(result, page)
    wave = Sinusoid(peak.number("amplitude"), peak.number("period"), peak.number("phase"), 0.0,
                    peak.number("time_offset"))
    detrending.add_series(Table(folder / "series.csv"), wave if wave.period > 0 else None, unit, _unit_of_y(result), page)
    level = result.number("power_at_fap_1e-3")
    _add_periodogram(Table(folder / "periodogram.csv"), result, level, unit, page)
    detrending.add_residual(Table(folder / detrending.RESIDUAL), level, unit, page)
    page.explain({**detrending.WORDS, **glossary.FAP, **glossary.FWHM, **glossary.PEAKS})


def _peak(result: Result) -> Result:
    """The peak whose sinusoid the files hold: for correlated noise that of its model."""
    key = "noise.peak" if result.has("noise.peak") else "peak"
    if not isinstance(result.find(key), dict):
        raise result.fail(key, "an object")
    return Result(result.path, result.find(key), key + ".")


def _unit_of_y(result: Result) -> str:
    if not result.has("reduction"):
        return ""
    return "px" if result.has("reduction.plate_scale_arcsec") else "arcsec"


def _found(result: Result, peak: Result, unit: str) -> str:
    fap = peak.number("log10_fap")
    ar1 = result.has("noise.peak")
    method = peak.text("fap_method") if ar1 else result.text("fap_method")
    text = (f"{result.whole('n')} samples: period {with_error(peak.number('period'), peak.number('period_error'))} {unit}, "
            f"{LOG_FAP} {fixed(fap, 1)} ({method}{', noise ar1' if ar1 else ''}).")
    if result.flag("peak.long_period"):
        text += " It exceeds half the time span: a trend may cause it."
    if result.flag("peak.annual"):
        text += " It is within one resolution of a year: the motion of the Earth and seasons may cause it."
    if result.has("peak.chi_square"):
        text += " " + goodness_of(Result(result.path, result.find("peak"), "peak."))
    return text + ("" if significant(fap) else " This is not a significant period.")


def _add_coefficients(result: Result, page: Page) -> None:
    rows = []
    for one in result.items("functions.coefficients"):
        value, error = one.number("value"), one.number("error")
        prior = one.number("prior_sigma")
        shown = [UNKNOWN, UNKNOWN] if math.isnan(error) else [scientific(value, 6), scientific(error, 2)]
        rows.append([one.text("name"), *shown, UNKNOWN if math.isnan(prior) else scientific(prior, 4)])
    page.add_table(f"Coefficients of mean and nuisance functions at the peak: {result.whole('functions.in_use')} in use, "
                   f"{result.whole('functions.free')} without a prior.",
                   ["", "coefficient", "standard error", "prior, standard deviation"], rows)


def _add_periodogram(table: Table, result: Result, level: float, unit: str, page: Page) -> None:
    frequency, power = table.numbers("frequency"), table.numbers("power")
    peak = Result(result.path, result.find("peak"), "peak.")
    fit = peak.number("frequency")
    curve = Power("series", frequency, power, float(frequency[power.argmax()]), fit, peak.number("frequency_error"),
                  peak.number("fwhm_period") * fit**2, level)
    figure = figures.periodogram([curve], unit)
    if figure is None:
        page.add("text", "No figure of the periodogram: its grid does not have two frequencies above 0.")
        return
    page.add_figure("periodogram", figure, "Lomb-Scargle power, for white noise, with mean and nuisance functions fitted at "
                    "each frequency. The dashed line holds for one query.")
