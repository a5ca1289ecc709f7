"""Error budgets: which unknown parameters limit the separation. Reference: include/toliman/budget.h."""
from __future__ import annotations

import ctypes
import typing

import numpy

from . import _raw
from ._arguments import Doubles, array_of, options_of, pointer, real, whole
from ._library import check, library
from ._results import BudgetRow, BudgetStep, BudgetSummary


class Budget(typing.NamedTuple):
    """Error budget of a scene: summary, bounds with more and more parameters free, one row per parameter, and the
    correlations of the separation and the free parameters, [free + 1][free + 1]."""

    summary: BudgetSummary
    steps: list[BudgetStep]
    rows: list[BudgetRow]
    correlations: Doubles


def _array(function: typing.Any, sim: typing.Any, options: typing.Any, struct: typing.Any, capacity: int) -> typing.Any:
    """Calls a function that fills an array of structs."""
    found, count = array_of(struct, capacity), ctypes.c_size_t()
    check(function(sim, ctypes.byref(options), found, capacity, ctypes.byref(count)))
    return found[:count.value]


def budget_of(sim: typing.Any, free: typing.Sequence[str] | None, frames: int, earth_px: float) -> Budget:
    """Returns the budget of a C simulator; see Simulator.budget()."""
    if isinstance(free, str):
        raise ValueError(f"free = {free!r}: must be a list of names")
    names = None if free is None else " ".join(free).encode()
    options = options_of(_raw.toliman_sim_budget_options, free_names=names,
                         frames=whole("frames", frames, 2**53 + 1), earth_px=real("earth_px", earth_px))
    summary = _raw.toliman_sim_budget()
    check(library.toliman_sim_get_budget(sim, ctypes.byref(options), ctypes.byref(summary)))
    steps = _array(library.toliman_sim_get_budget_steps, sim, options, _raw.toliman_sim_budget_step,
                   summary.steps)
    rows = _array(library.toliman_sim_get_budget_rows, sim, options, _raw.toliman_sim_budget_row, summary.rows)
    side = summary.free_count + 1
    correlations = numpy.empty((side, side))
    check(library.toliman_sim_get_budget_correlations(sim, ctypes.byref(options), side, pointer(correlations)))
    return Budget(BudgetSummary._of(summary), [BudgetStep._of(step) for step in steps],
                  [BudgetRow._of(row) for row in rows], correlations)
