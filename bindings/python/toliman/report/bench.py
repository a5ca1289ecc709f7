"""The section of `make bench`: time against error."""
from __future__ import annotations

import math
import pathlib

import numpy

from .._failure import Failure
from . import figures, results
from .page import Page
from .results import Array, Result
from .text import scientific

SCHEMA = "toliman-bench/1"
_FEWEST = 7  # points of a figure
_SPEED = ("error", "seconds", "error (relative)", "time, s", "time against error: better is lower and further left")
_BYTES = ("bytes", "efficiency", "size of the weights file, bytes", "efficiency (no unit)",
          "efficiency against size, of the same frames: better is higher and further left")
_GROWTH = ("size", "seconds", "frames, samples or cells", "time, s", "time against size: better is lower and flatter")


def files_of(folder: pathlib.Path) -> list[pathlib.Path]:
    """Returns the files of a folder that are results of `make bench`."""
    found = []
    for path in sorted(folder.glob("*.json")):
        try:
            results.load(path, SCHEMA)
            found.append(path)
        except Failure:
            continue
    return found


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of benchmarks to the page."""
    files = [results.load(path, SCHEMA) for path in files_of(folder)]
    page.add("title", "make bench: time against error")
    page.add("text", "Medians of processor time on one core, or of all threads of a command, with half the interquartile "
             "range of the runs; wall time and peak memory of a command; the largest error; a reference that was "
             "measured in the same run and its time divided by this one; the time divided by the lower bound that the "
             "hardware allows.")
    machines: dict[str, list[list[str]]] = {}
    for file in files:
        rows = [_cells(row) for row in file.items("rows") if row.find("headline", False) is True]
        machines.setdefault(_machine(file), []).extend(rows)
    for machine, rows in machines.items():
        _add_cells(machine, rows, page)
    for file in files:
        benches: dict[str, list[Result]] = {}
        for row in file.items("rows"):
            benches.setdefault(row.text("bench"), []).append(row)
        for bench, rows_of in benches.items():
            page.add("heading", bench)
            _add_figure(bench, rows_of, page)
            _add_cells("", [_cells(row) for row in rows_of], page)


def _add_figure(bench: str, rows: list[Result], page: Page) -> None:
    x, y, x_label, y_label, what = (_BYTES if rows[0].has("bytes") else _GROWTH if rows[0].has("size") else _SPEED)
    points: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        at = row.number(x, math.nan), row.number(y, math.nan)
        if at[0] > 0 and at[1] > 0:
            points.setdefault(row.text("series", ""), []).append(at)
    if sum(map(len, points.values())) < _FEWEST:
        return
    columns: dict[str, tuple[Array, Array]] = {}
    exponents = {row.text("series", ""): row.number("exponent", math.nan) for row in rows}
    for name, of in points.items():
        array = numpy.array(of)
        if exponents[name] > -math.inf:  # of those that have one
            name = f"{name}: size^{exponents[name]:.2f}"
        columns[name] = array[:, 0], array[:, 1]
    page.add_figure("bench-" + bench, figures.benchmark(columns, x_label, y_label, x != "bytes"), f"{bench}: {what}.")


def _machine(file: Result) -> str:
    words = [file.find(f"machine.{key}", None) for key in ("date", "cpu", "isa", "blas_core", "fftw")]
    return "Machine: " + ", ".join(word for word in words if isinstance(word, str)) + "."


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"


def _ratio(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else ""


def _spread(part: float) -> str:
    return "" if math.isnan(part) else "< 1 %" if part < 0.005 else f"{100 * part:.0f} %"


def _error(row: Result) -> str:
    error = row.number("error", math.nan)
    largest = row.number("error_largest", math.nan)
    of, at = row.text("error_of", ""), row.text("error_at", "")
    if not math.isfinite(error):
        return ""
    return (scientific(error, 1 if error < 0.1 else 3) + (f" {of}" if of else "") + (f", largest {largest:.2g}," if math.isfinite(largest) else "")
            + (f" at {at}" if at else ""))


def _cells(row: Result) -> list[str]:
    seconds = row.positive("seconds")
    wall, memory = row.number("wall_seconds", math.nan), row.number("memory_bytes", math.nan)
    return [row.text("what"), _time(seconds), _spread(row.number("spread", math.nan) / seconds),
            _time(wall) if wall > 0 else "", f"{memory / 1e6:.0f} MB" if memory > 0 else "", _error(row),
            row.text("peer", ""), _ratio(row.number("ratio_peer", math.nan), ".3g"),
            _ratio(row.number("ratio_roofline", math.nan), ".2f")]


def _add_cells(caption: str, rows: list[list[str]], page: Page) -> None:
    if rows:
        page.add_table(caption, ["", "time", "±", "wall time", "memory", "error", "reference", "speed-up", "× roofline"], rows)
