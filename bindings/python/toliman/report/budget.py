"""The section of `toliman budget --json`: bounds and the parameters that limit them."""
from __future__ import annotations

import math
import pathlib

from . import figures, results
from .page import Page
from .results import Result
from .text import exponential, scientific

SCHEMA = "toliman-budget/1"
_MOST = 12  # rows of a table of parameters
_WITH, _WITHOUT = "with the mask of the scene", "without mask"


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds an error budget to the page."""
    file = results.load(folder / "budget.json", SCHEMA)
    earth_px, uas_per_px = file.number("earth_px"), file.positive("uas_per_px")
    budgets = {_WITH: "scene_mask", **({_WITHOUT: "without_mask"} if file.has("without_mask") else {})}
    page.add("title", f"Error budget of {file.text('scene')}")
    page.add("text", f"An Earth is a displacement of {exponential(earth_px)} px, {scientific(earth_px * uas_per_px)} µas: "
             f"{file.text('earth_from')}.")
    bounds = {name: [step.number("crb_px") for step in file.items(f"{key}.steps")] for name, key in budgets.items()}
    steps = [step.text("name") for step in file.items("scene_mask.steps")]
    page.add_figure("budget-bounds", figures.bounds(steps, bounds, earth_px),
                    "Smallest standard deviation of the separation in one frame, with more and more parameters fitted together "
                    "with it.")
    page.add_table("Bounds per frame, px", ["free", *budgets],
                   [[name, *(exponential(of[i]) for of in bounds.values())] for i, name in enumerate(steps)])
    rows = file.items("scene_mask.parameters")
    others = {row.text("name"): row for row in file.items("without_mask.parameters")} if _WITHOUT in budgets else {}
    for free, caption in ((False, "Parameters that are not fitted: amounts with the effect of an Earth and of a tenth of the "
                                  "bound"), (True, "Fitted parameters: amounts whose second order has these effects")):
        chosen = [row for row in rows if row.flag("free") is free]
        if chosen:
            _add_parameters(caption, chosen if free else _limiting(chosen), others, page)


def _limiting(rows: list[Result]) -> list[Result]:
    """Returns the first rows of each unit with the smallest amounts, at most _MOST, in the order of the file."""
    units: dict[str, list[Result]] = {}
    for row in rows:
        units.setdefault(row.text("unit"), []).append(row)
    ranked = [sorted(of, key=_amount) for of in units.values()]
    chosen = [of[place] for place in range(_MOST) for of in ranked if place < len(of)][:_MOST]
    return [row for row in rows if row in chosen]


def _amount(row: Result) -> float:
    value = row.number("earth_amount")
    return math.inf if math.isnan(value) else value


def _with_unit(value: float, unit: str) -> str:
    return f"{scientific(value, 2)} {unit}".strip() if math.isfinite(value) else "–"


def _add_parameters(caption: str, rows: list[Result], others: dict[str, Result], page: Page) -> None:
    heads = ["parameter", "an Earth", "0.1 σ"] + (["an Earth, without mask"] if others else [])
    cells = []
    for row in rows:
        name, unit = row.text("name"), row.text("unit")
        line = [name, _with_unit(row.number("earth_amount"), unit), _with_unit(row.number("tenth_crb_amount"), unit)]
        if others:
            line.append(_with_unit(others[name].number("earth_amount"), unit) if name in others else "–")
        cells.append(line)
    page.add_table(caption, heads, cells)
