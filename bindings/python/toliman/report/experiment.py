"""The section of `python3 -m toliman.experiment`: methods over a range of amplitudes, and series without signal."""
from __future__ import annotations

import math
import pathlib

import numpy

from . import figures, glossary, results
from .page import Page, add_provenance
from .results import Array, Result, Table
from .text import LOG_FAP, decimals_of, exponential, fixed, scientific

_LEAST = 0.05  # of -log10 FAP on a logarithmic axis
_LEFT_OUT = {"none": " They were left out (--controls none).",
             "quick": " Most were left out (--controls quick): a tenth, at least one per seed, was computed."}
_WORDS = {
    "seed": "of random weights and of noise: each seed is an independent trial",
    "found": f"{LOG_FAP} below −3 and the period within 5 % of the true one",
    "at the bound": "expected by theory of a method whose scatter is the Cramér-Rao bound",
    "slope": "change of a method's value per px of displacement: 1 if the values are in px; methods that learn from "
             "the series have units of their own and either sign",
    "efficiency": "the Cramér-Rao bound divided by a method's scatter about that slope, in px: at most 1, apart from "
                  "chance",
    "bias": "mean of a method's values without signal",
    "uniform, KS p": "Kolmogorov-Smirnov: probability that uniform FAPs, as those of noise should be, are as uneven as "
                     "these; suspicious below 0.01",
    **glossary.BOUND, **glossary.FAP,
}


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of an experiment to the page."""
    result = results.load(folder / "experiment.json", "toliman-experiment/1")
    blind = _read_blind(Table(folder / "experiment.csv"))
    page.add("title", "toliman.experiment: " + result.text("scene"))
    page.add("text", f"{result.whole('frames')} frames per series, period {result.number('true_period_days'):g} days; "
                     "seeds 1 "
             f"to {result.whole('seeds')}; {result.whole('blind')} series without signal per table."
             + _LEFT_OUT.get(str(result.find("controls", "full")), ""))
    add_provenance(page, result)
    others = []
    for table in result.items("tables"):
        if table.text("table") in ("real", "equal"):
            _add_table(table, blind, page)
        else:
            others.append(table)
    if others:
        _add_other_scenes(others, page)
    page.explain(_WORDS)
    if result.has("methods"):
        page.explain({method.text("method"): method.text("what") for method in result.items("methods")})


def _read_blind(table: Table) -> dict[str, dict[str, Array]]:
    """FAPs of the series without signal, per table and method."""
    names = list(zip(table.words("table"), table.words("method")))
    amplitude, log_fap = table.numbers("amplitude_px", finite=False), table.numbers("log10_fap", finite=False)
    faps: dict[str, dict[str, list[float]]] = {}
    for (name, method), at, value in zip(names, amplitude, log_fap):
        if at == 0:
            faps.setdefault(name, {}).setdefault(method, []).append(10**value)
    return {name: {method: numpy.array(values) for method, values in methods.items()} for name, methods in faps.items()}


def _is_seen(row: Result) -> bool:
    """Most seeds found the signal; otherwise slope and efficiency are those of noise."""
    return 2 * row.number("found") > row.number("seeds")


def _add_table(table: Result, blind: dict[str, dict[str, Array]], page: Page) -> None:
    name, rows, controls = table.text("table"), table.items("ladder"), table.items("controls")
    page.add("heading", f"Table {name}: {table.text('what')}")
    page.add("text", f"Cramér-Rao bound of a frame {scientific(table.number('crb_projected_px'), 4)} px, with all "
                     "nuisances free "
             f"{scientific(table.number('crb_marginal_px'))} px. Flux ratio {table.number('flux_ratio'):.3g}. The "
             "signal is the first principal component of whitened frames above "
             f"{scientific(table.number('pca_threshold_px'))} px.")
    if rows:
        _add_detection(table, rows, page)
        _add_rows(rows, page)
    if name in blind:
        methods = list(dict.fromkeys(row.text("method") for row in rows))
        shown = {method: blind[name][method] for method in methods if method in blind[name]}
        if shown:
            page.add_figure(f"blind-{name}", figures.false_alarms(shown),
                            f"Number of series without signal, of {max(map(len, shown.values()))}, with a FAP in each "
                            "interval. If the FAP is correct, all intervals have the same number (dashed; grey: one "
                            "standard deviation).")
    if controls:
        _add_controls(controls, page)


def _add_detection(table: Result, rows: list[Result], page: Page) -> None:
    points: dict[str, list[tuple[float, float, float]]] = {}
    bound: dict[float, float] = {}
    for row in rows:
        amplitude = row.positive("amplitude_px")
        seen = row.number("efficiency") if _is_seen(row) else math.nan
        points.setdefault(row.text("method"), []).append((amplitude, max(-_finite(row, "log10_fap"), _LEAST), seen))
        bound[amplitude] = max(-_finite(row, "expected_log10_fap"), _LEAST)
    threshold = table.number("threshold_px")
    figure = figures.detection({name: numpy.array(sorted(of)).T for name, of in points.items()},
                               numpy.array(sorted(bound.items())).T, threshold)
    page.add_figure(f"detection-{table.text('table')}", figure,
                    "Top: significance of the highest peak, median over the seeds; dashed: expected at the Cramér-Rao "
                    "bound. Bottom: efficiency, where most seeds found the signal. Dotted: the amplitude from which a "
                    f"method at the bound is expected to find it, {scientific(threshold)} px. A network may lose "
                    "efficiency at large amplitudes: it is linear only near the scene's reference image.")


def _finite(row: Result, key: str) -> float:
    value = row.number(key)
    if math.isnan(value):
        raise row.fail(key, "a finite number")
    return value


def _slope(slope: float) -> str:
    """Close to 1 for values in px; any size for methods with units of their own."""
    return fixed(slope, 3) if 0.1 <= abs(slope) < 10 else exponential(slope)


def _percent(part: float) -> str:
    return fixed(100 * part, decimals_of(100 * part, 0))


def _add_rows(rows: list[Result], page: Page) -> None:
    cells, last = [], math.nan
    for row in rows:
        amplitude = row.number("amplitude_px")
        if amplitude != last:
            expected = fixed(row.number("expected_log10_fap"), 1)
            cells.append(["at the bound", exponential(amplitude), "", "", expected, "1", "1"])
        last = amplitude
        seen = _is_seen(row)
        cells.append([row.text("method"), exponential(amplitude), f"{row.whole('found')} of {row.whole('seeds')}",
                      _percent(row.number("period_error")), fixed(row.number("log10_fap"), 1),
                      _slope(row.number("slope")) if seen else "", fixed(row.number("efficiency"), 3) if seen else ""])
    page.add_table("Medians over the seeds; slope and efficiency only where most seeds found the signal.",
                   ["method", "amplitude, px", "found", "period error, %", LOG_FAP, "slope", "efficiency"], cells)


def _add_controls(controls: list[Result], page: Page) -> None:
    page.add_table("Series without signal: the methods on noise alone.",
                   ["method", "series", "alarms at FAP 10⁻³", "uniform, KS p", "sigma, px", "efficiency"],
                   [[control.text("method"), str(control.whole("series")), str(control.whole("alarms")),
                     fixed(control.number("ks_p"), 2), exponential(control.number("sigma_px")),
                     fixed(control.number("efficiency"), 3)] for control in controls])


def _add_other_scenes(tables: list[Result], page: Page) -> None:
    cells = []
    for table in tables:
        controls = {control.text("method"): control for control in table.items("controls")}
        for row in table.items("ladder"):
            control = controls.get(row.text("method"))
            cells.append([table.text("what"), row.text("method"),
                          *([exponential(control.number("bias_px")), exponential(control.number("sigma_px")),
                             fixed(control.number("efficiency"), 3)] if control else ["", "", ""]),
                          f"{row.whole('found')} of {row.whole('seeds')}", fixed(row.number("log10_fap"), 1)])
    page.add("heading", "Frames of other scenes")
    page.add_table("Methods made for this scene, on frames that differ from it.",
                   ["frames", "method", "bias, px", "sigma, px", "efficiency", "found", LOG_FAP], cells)
