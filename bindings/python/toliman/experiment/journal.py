"""Journal of an experiment: JSON Lines. The first line has the arguments, every other line one result, so that a stopped
experiment resumes. Each line is written by one write(2), and fdatasync'ed at most once per second, since a sync takes as
long as many results. A lock keeps out a second process."""
from __future__ import annotations

import json
import math
import os
import pathlib
import time
import typing

from .._failure import OUTPUT, USAGE, Failure, malformed, readable
from .._output import has_name, try_lock


class Row(typing.NamedTuple):
    """A method on one series of frames."""

    table: str
    method: str
    amplitude_px: float  # 0: frames without signal
    seed: int  # of weights and noise
    series: int = 0  # number among the series without signal of this seed
    period_days: float = 0.0
    log10_fap: float = 0.0
    slope: float = 0.0  # of the values over the true displacement in px; without signal over expected images
    sigma: float = 0.0  # scatter of the values about that line
    mean: float = 0.0  # of the values

    @property
    def key(self) -> tuple[typing.Any, ...]:
        """What identifies the result."""
        return self[:5]


_TYPES = {"table": str, "method": str, "amplitude_px": float, "seed": int, "series": int}


def line_of(values: typing.Any) -> str:
    """Returns JSON on one line; null for a number that is not finite."""
    if isinstance(values, dict):
        values = {key: None if isinstance(value, float) and not math.isfinite(value) else value
                  for key, value in values.items()}
    return json.dumps(values, ensure_ascii=False, separators=(",", ":"))


class Journal:
    """Opens or creates the file, and removes an incomplete last line, left by a process that died. Raises Failure if the
    file has other arguments or damaged lines, or if another process writes to it."""

    def __init__(self, path: pathlib.Path, arguments: dict[str, typing.Any]):
        self._path, self._synced = path, 0.0
        self._rows: dict[tuple[typing.Any, ...], Row] = {}
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            self._file = os.fdopen(os.open(path, flags, 0o666), "r+b", buffering=0)
            if not try_lock(self._file) or not has_name(self._file, path):
                raise Failure(OUTPUT, f"{readable(path)}: another process is writing to it: wait until it ends, or give "
                                      "another --out")
            content = path.read_bytes()
            whole = content.rfind(b"\n") + 1
            if whole < len(content):
                self._file.truncate(whole)
        except OSError as error:
            raise self._unwritable(error) from None
        lines = content[:whole].decode(errors="replace").splitlines()
        if not lines:
            self._append(line_of(arguments))
            return
        self._check(lines[0], arguments)
        for number, line in enumerate(lines[1:], 2):
            row = self._parse(line, number)
            self._rows[row.key] = row

    def _unwritable(self, error: OSError) -> Failure:
        return Failure(OUTPUT, f"{readable(self._path)}: cannot be written: {error.strerror}")

    def _check(self, line: str, arguments: dict[str, typing.Any]) -> None:
        try:
            found = dict(json.loads(line))
        except (ValueError, TypeError):
            raise malformed(f"{self._path}:1", "is not the journal of an experiment: give another --out") from None
        for key, wanted in arguments.items():
            if found.get(key) != wanted:
                there = line_of(found[key]) if key in found else "nothing"
                raise Failure(USAGE, f"{readable(self._path)}: {key} = {there}: must be {line_of(wanted)}, as in this "
                                     "experiment: give another --out or the same arguments")

    def _parse(self, line: str, number: int) -> Row:
        try:
            found = json.loads(line)
            values = [found[name] for name in Row._fields]
            for name, value in zip(Row._fields, values):
                if not (type(value) is _TYPES.get(name, float) or _TYPES.get(name, float) is float and
                        (type(value) is int or value is None and name != "amplitude_px")):
                    raise ValueError
        except (ValueError, LookupError, TypeError):
            raise malformed(f"{self._path}:{number}", "is not a result of an experiment: remove this line, and the result "
                                                      "is computed again") from None
        return Row(*(math.nan if value is None else value for value in values))

    def __contains__(self, row: Row) -> bool:
        return row.key in self._rows

    def add(self, row: Row) -> None:
        """Appends a result."""
        self._append(line_of(row._asdict()))
        self._rows[row.key] = row

    def _append(self, line: str) -> None:
        try:
            self._file.write(line.encode() + b"\n")
            if time.monotonic() - self._synced >= 1:
                os.fdatasync(self._file.fileno())
                self._synced = time.monotonic()
        except OSError as error:
            raise self._unwritable(error) from None

    def rows(self, table: str, method: str, amplitude_px: float) -> list[Row]:
        """Returns the results of a method in a table, by seed and series. amplitude_px 0: all series without signal."""
        wanted = (table, method, amplitude_px)
        return sorted((row for row in self._rows.values() if row[:3] == wanted), key=lambda row: row.key)

    def discard(self) -> None:
        """Removes a file without results."""
        if not self._rows:
            self._path.unlink(missing_ok=True)
