"""The results of an experiment: for each method and amplitude medians over the seeds, since a lost period makes a mean
meaningless. The controls (series without signal) have the number of false alarms, the uniformity of the FAPs, and the
scatter: the variance of all series of a seed is pooled and divided by the squared slope, so that values in other units than
px compare with the Cramer-Rao bound; the result is the median over the seeds."""
from __future__ import annotations

import math
import statistics
import typing

import numpy

from .._library import version
from .campaign import Campaign, Table
from .journal import Journal, Row
from .methods import METHODS
from .theory import FOUND, uniformity

Json = typing.Dict[str, typing.Any]

_CLOSE = 0.05  # largest relative error of a period that was found


def period_error(campaign: Campaign, row: Row) -> float:
    """Returns |period / true period - 1|."""
    return abs(row.period_days / campaign.simulator.info.period_days - 1)


def found(campaign: Campaign, row: Row) -> bool:
    """Whether the signal was found: log10 FAP below FOUND, and the period within 5 % of the true one."""
    return row.log10_fap < FOUND and period_error(campaign, row) < _CLOSE


def efficiency(table: Table, row: Row) -> float:
    """Returns the Cramer-Rao bound over the scatter, both in px; 0 of a series without values."""
    return table.bound_px * abs(row.slope) / row.sigma if row.sigma > 0 else 0.0


def _ladder_row(campaign: Campaign, table: Table, rows: list[Row]) -> Json:
    return {
        "method": rows[0].method, "amplitude_px": rows[0].amplitude_px, "seeds": len(rows),
        "found": sum(found(campaign, row) for row in rows),
        "period_error": statistics.median(period_error(campaign, row) for row in rows),
        "log10_fap": statistics.median(row.log10_fap for row in rows),
        "expected_log10_fap": campaign.theory.log10_fap(rows[0].amplitude_px, table.bound_px),
        "slope": statistics.median(row.slope for row in rows),
        "efficiency": statistics.median(efficiency(table, row) for row in rows),
    }


def _pooled_sigmas(rows: list[Row]) -> list[float]:
    """Scatter in px for each seed, pooled over its series."""
    squares: dict[int, list[float]] = {}
    for row in rows:
        is_known = row.sigma > 0 and row.slope != 0
        squares.setdefault(row.seed, []).append((row.sigma / row.slope) ** 2 if is_known else math.inf)
    return [math.sqrt(statistics.fmean(of_seed)) for of_seed in squares.values()]


def _control(campaign: Campaign, table: Table, rows: list[Row]) -> Json:
    sigma_px = statistics.median(_pooled_sigmas(rows))
    return {
        "method": rows[0].method, "series": len(rows), "frames": len(rows) * campaign.simulator.info.frames,
        "alarms": sum(row.log10_fap < FOUND for row in rows),
        "ks_p": uniformity(numpy.power(10.0, [row.log10_fap for row in rows])),
        "sigma_px": sigma_px, "efficiency": table.bound_px / sigma_px,
        "bias_px": statistics.fmean(row.mean for row in rows), "slope": statistics.fmean(row.slope for row in rows),
    }


def _table(campaign: Campaign, table: Table, journal: Journal) -> Json:
    methods, bounds, theory = campaign.options.methods, table.frames.bounds, campaign.theory
    ladder = [journal.rows(table.name, method, amplitude) for amplitude in table.amplitudes for method in methods]
    blind = [journal.rows(table.name, method, 0) for method in methods]
    return {
        "table": table.name, "what": table.what, "flux_ratio": table.frames.info.flux_ratio, "crb_px": bounds.crb_px,
        "crb_projected_px": bounds.crb_projected_px, "crb_marginal_px": bounds.crb_marginal_px,
        "threshold_px": theory.threshold_px(table.bound_px),
        "pca_threshold_px": theory.pca_threshold_px(table.bound_px, math.prod(table.frames.shape)),
        "ladder": [_ladder_row(campaign, table, rows) for rows in ladder if rows],
        "controls": [_control(campaign, table, rows) for rows in blind if rows],
    }


def result_of(campaign: Campaign, journal: Journal, provenance: Json) -> Json:
    """Returns the members of experiment.json, schema toliman-experiment/1."""
    info, options = campaign.simulator.info, campaign.options
    return {
        "schema": "toliman-experiment/1", "version": version(), "provenance": provenance, "scene": info.name,
        "frames": info.frames, "true_period_days": info.period_days, "amplitude_px": info.amplitude_px,
        "seeds": options.seeds, "controls": options.controls, "blind": options.blind, "grid": campaign.grid._asdict(),
        "methods": [{"method": name, "what": METHODS[name].what} for name in options.methods],
        "tables": [_table(campaign, table, journal) for table in campaign.tables],
    }
