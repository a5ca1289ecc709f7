"""Error budgets: which unknown parameters limit the separation. Reference: include/toliman/budget.h."""
from __future__ import annotations

import ctypes
import typing

import numpy

from . import _raw
from ._arguments import Doubles, listed, options_of, pointer, real, whole
from ._library import check, library
from ._plots import Axes, plots
from ._results import BudgetRow, BudgetStep, BudgetSummary


class Budget(typing.NamedTuple):
    """Error budget of a scene: summary, bounds with more and more parameters free, one row per parameter, and the
    correlations of the separation and the free parameters, [free + 1][free + 1]."""

    summary: BudgetSummary
    steps: list[BudgetStep]
    rows: list[BudgetRow]
    correlations: Doubles

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the bound of one frame with more and more parameters free, and the displacement by an Earth, if it is
        known. ax: Axes to draw into, in their style; None: a new figure of pyplot."""
        return plots().budget(self, ax)


def budget_of(sim: typing.Any, free: typing.Sequence[str] | None, frames: int, earth_px: float) -> Budget:
    """Returns the budget of a C simulator; see Simulator.budget()."""
    if isinstance(free, str):
        raise ValueError(f"free = {free!r}: must be a list of names")
    names = None if free is None else " ".join(free).encode()
    options = options_of(_raw.toliman_sim_budget_options, free_names=names,
                         frames=whole("frames", frames, 2**53 + 1), earth_px=real("earth_px", earth_px))
    summary = _raw.toliman_sim_budget()
    check(library.toliman_sim_get_budget(sim, ctypes.byref(options), ctypes.byref(summary)))
    steps = listed(_raw.toliman_sim_budget_step, library.toliman_sim_get_budget_steps, sim, ctypes.byref(options),
                   capacity=summary.steps)
    side = summary.free_count + 1
    correlations = numpy.empty((side, side))
    rows = listed(_raw.toliman_sim_budget_row, library.toliman_sim_get_budget_rows, sim, ctypes.byref(options),
                  pointer(correlations), side, capacity=summary.rows)
    return Budget(BudgetSummary._of(summary), [BudgetStep._of(step) for step in steps],
                  [BudgetRow._of(row) for row in rows], correlations)
