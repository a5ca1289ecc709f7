"""The results of an experiment as text: JSON, CSV with one row per method and series of frames, tables in Markdown."""
from __future__ import annotations

import json
import math
import typing

from .campaign import Campaign
from .journal import Journal
from .summary import Json, efficiency, found, period_error
from .theory import FOUND

# How the program's files begin, so that a later run replaces them without --force.
MARKS = {
    "experiment.csv": "# a method on a series of frames: amplitude_px 0 is without signal; the rest in pixels and days\n",
    "experiment.md": "# Experiment: ",
    "experiment.json": '{\n\t"schema":\t"toliman-experiment/',
}
_COLUMNS = ("table", "method", "amplitude_px", "seed", "series", "period_days", "period_error", "log10_fap", "found", "slope",
            "sigma", "mean", "efficiency")


def _known(value: typing.Any) -> typing.Any:
    """Returns JSON with null for each number that is not finite."""
    if isinstance(value, dict):
        return {key: _known(member) for key, member in value.items()}
    if isinstance(value, list):
        return [_known(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_of(result: Json) -> str:
    """Returns the text of experiment.json."""
    return json.dumps(_known(result), ensure_ascii=False, indent="\t", separators=(",", ":\t")) + "\n"


def csv_of(campaign: Campaign, journal: Journal) -> str:
    """Returns the text of experiment.csv."""
    lines = [MARKS["experiment.csv"], ",".join(_COLUMNS) + "\n"]
    for table in campaign.tables:
        for amplitude in [*table.amplitudes, 0.0]:
            for method in campaign.options.methods:
                for row in journal.rows(table.name, method, amplitude):
                    values = {**row._asdict(), "period_error": period_error(campaign, row),
                              "found": int(found(campaign, row)), "efficiency": efficiency(table, row)}
                    cells = (f"{value:.17g}" if isinstance(value, float) else str(value)
                             for value in map(values.get, _COLUMNS))
                    lines.append(",".join(cells) + "\n")
    return "".join(lines)


def _ladder(table: Json, frames: int) -> str:
    out = (f"\n## Table {table['table']}: {table['what']}\n\n"
           f"Flux ratio {table['flux_ratio']:.3g}. Cramer-Rao bound of a frame {table['crb_projected_px']:.4g} px (all "
           f"nuisances free {table['crb_marginal_px']:.3g} px). A method at the bound is expected to\nreach FAP = 1e-3 at "
           f"{table['threshold_px']:.3g} px. The signal is the first principal component of whitened frames above "
           f"{table['pca_threshold_px']:.3g} px.\n\n"
           "| amplitude, px | method | found | period error, % | log10 FAP | slope | efficiency |\n"
           "|---|---|---|---|---|---|---|\n")
    last = math.nan
    for row in table["ladder"]:
        amplitude = f"{row['amplitude_px']:g}"
        if row["amplitude_px"] != last:
            out += f"| {amplitude} | at the bound | | | {row['expected_log10_fap']:.1f} | 1 | 1 |\n"
        last = row["amplitude_px"]
        out += (f"| {amplitude} | {row['method']} | {row['found']} of {row['seeds']} | {100 * row['period_error']:.2g} | "
                f"{row['log10_fap']:.1f} |")
        is_seen = 2 * row["found"] > row["seeds"]  # otherwise the slope is that of noise
        out += f" {row['slope']:.3g} | {row['efficiency']:.3g} |\n" if is_seen else " | |\n"
    if table["controls"]:
        out += (f"\nSeries of {frames} frames without signal:\n\n"
                "| method | series | alarms at FAP 1e-3 | uniform, KS p | sigma, px | efficiency |\n"
                "|---|---|---|---|---|---|\n")
    for control in table["controls"]:
        out += (f"| {control['method']} | {control['series']} | {control['alarms']} | {control['ks_p']:.2g} | "
                f"{control['sigma_px']:.3g} | {control['efficiency']:.3f} |\n")
    return out


def _robust(tables: list[Json], amplitude_px: float, seeds: int) -> str:
    """The tables with a single amplitude as one table: each has a few rows, with the scene's own signal."""
    lines = ""
    for table in tables:
        controls = {control["method"]: control for control in table["controls"]}
        for row in table["ladder"]:
            lines += f"| {table['what']} | {row['method']} | {table['crb_projected_px']:.3g} | "
            control = controls.get(row["method"])
            lines += "| | | " if control is None else (
                f"{control['bias_px']:.2g} | {control['sigma_px']:.3g} | {control['slope']:.4f} | {control['efficiency']:.3f} ")
            lines += f"| {row['found']} of {row['seeds']} | {row['log10_fap']:.1f} |\n"
    if not lines:
        return ""
    return (f"\n## Table robust: frames of other scenes, methods of this scene\n\nThe scene's own signal of {amplitude_px:g} "
            f"px, at most {seeds} seeds. Bias, sigma and efficiency are those of frames without signal, the slope\nis that of "
            "expected images. For frames relative to their own mean, their expected image is replaced by the reference\nimage "
            "of the methods' scene.\n\n"
            "| frames | method | bound, px | bias, px | sigma, px | slope | efficiency | found | log10 FAP |\n"
            "|---|---|---|---|---|---|---|---|---|\n") + lines


def markdown_of(campaign: Campaign, result: Json) -> str:
    """Returns the text of experiment.md."""
    rows, cols = campaign.simulator.shape
    out = (f"{MARKS['experiment.md']}{result['scene']}\n\n{result['frames']} frames of {rows}x{cols}, period "
           f"{result['true_period_days']:g} days, seeds 1 to {result['seeds']}. Medians over the seeds; found: log10 FAP "
           f"below {FOUND:g} and the period\nwithin 5 %.\n")
    if result["controls"] == "none":
        out += "\nControls: none: no series without signal.\n"
    if result["controls"] == "quick":
        out += f"\nControls: quick: {result['blind']} series without signal per table.\n"
    pairs = list(zip(campaign.tables, result["tables"]))
    for table, summary in pairs:
        if table.compares_amplitudes:
            out += _ladder(summary, result["frames"])
    others = [summary for table, summary in pairs if not table.compares_amplitudes]
    return out + _robust(others, result["amplitude_px"], len(campaign.tables[-1].blind))
