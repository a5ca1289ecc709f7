"""Error budgets: which unknown parameters limit the separation. Reference: include/toliman/budget.h."""
from __future__ import annotations

import ctypes
import typing

import numpy

from . import _raw
from ._arguments import Doubles, listed, options_of, pointer, real, whole
from ._library import check, library
from ._plots import Axes, plots
from ._shown import documented
from ._table import Column, Rows, Tabular
from ._results import BudgetRow, BudgetStep, BudgetSummary


class _Budget(typing.NamedTuple):
    summary: BudgetSummary
    steps: Rows[BudgetStep]
    rows: Rows[BudgetRow]
    correlations: Doubles

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the bound of one frame with more and more parameters free, and the displacement by an Earth, if it is
        known. ax: Axes to draw into, in their style; None: a new figure of pyplot."""
        return plots().budget(self, ax)


@documented(summary="bounds and the displacement due to an Earth", steps="bounds with more and more parameters free",
            rows="one per parameter", correlations="of the separation and the free parameters, [free + 1][free + 1]")
class Budget(_Budget, Tabular):
    """Error budget of a scene: summary, bounds with more and more parameters free, one row per parameter, and the
    correlations of the separation and the free parameters, [free + 1][free + 1]. In a table: the rows."""

    def _columns(self) -> dict[str, Column]:
        return Rows(self.rows)._columns()

    def _facts(self) -> dict[str, typing.Any]:
        return {"crb_px": self.summary.crb_px, "earth_px": self.summary.earth_px, "free": self.summary.free_count}

    def __repr__(self) -> str:
        summary = self.summary
        return f"<Budget of {len(self.rows)} parameters: bound {summary.crb_px:.3g} px, {summary.free_count} free>"


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
    return Budget(BudgetSummary._of(summary), Rows(map(BudgetStep._of, steps)), Rows(map(BudgetRow._of, rows)),
                  correlations)
