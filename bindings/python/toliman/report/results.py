"""Reads result files: JSON, CSV and .npy. Each error names file, line or key, value, and what is allowed."""
from __future__ import annotations

import json
import math
import pathlib
import typing

import numpy

from .._failure import Failure, malformed, readable

MISSING: typing.Any = object()
Array = numpy.ndarray[typing.Any, typing.Any]


def _read(path: pathlib.Path) -> str:
    try:
        return path.read_bytes().decode(errors="replace")
    except OSError as error:
        raise malformed(path, error.strerror or str(error)) from None


class Result:
    """An object of a JSON file. Keys of nested objects are joined by points: "template.sigma_px"."""

    def __init__(self, path: pathlib.Path, values: dict[str, typing.Any], where: str = ""):
        self.path, self.values, self.where = path, values, where

    def fail(self, key: str, allowed: str) -> Failure:
        """Returns the failure of a key whose value is not allowed."""
        try:
            value = self.find(key)
        except Failure as missing:
            return missing
        shown = json.dumps(value, ensure_ascii=False)
        return malformed(self.path, f"{self.where}{key} = {shown[:60]}: must be {allowed}")

    def find(self, key: str, default: typing.Any = MISSING) -> typing.Any:
        """Returns the value of a key; the default if the key, or an object above it, is absent."""
        value: typing.Any = self.values
        for part in key.split("."):
            if isinstance(value, dict) and part in value:
                value = value[part]
            elif default is MISSING:
                raise malformed(self.path, f"{self.where}{key}: is missing")
            else:
                return default
        return value

    def has(self, key: str) -> bool:
        """Whether a key is present and not null."""
        return self.find(key, None) is not None

    def number(self, key: str, default: float | None = None) -> float:
        """Returns a number; NaN for null; the default, if there is one, for a key that is absent."""
        value = self.find(key, MISSING if default is None else default)
        if value is None or value is default:
            return math.nan if value is None else float(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < math.inf:
            raise self.fail(key, "a finite number or null")
        return float(value)

    def positive(self, key: str) -> float:
        """Returns a number above 0."""
        value = self.number(key)
        if not value > 0:
            raise self.fail(key, "above 0")
        return value

    def whole(self, key: str) -> int:
        """Returns an integer, with all its digits."""
        value = self.find(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value // 1:
            raise self.fail(key, "a whole number")
        return int(value)

    def text(self, key: str, default: str | None = None) -> str:
        """Returns a text."""
        value = self.find(key, MISSING if default is None else default)
        if not isinstance(value, str):
            raise self.fail(key, "text")
        return value

    def flag(self, key: str) -> bool:
        """Returns true or false."""
        value = self.find(key)
        if not isinstance(value, bool):
            raise self.fail(key, "true or false")
        return value

    def items(self, key: str) -> list[Result]:
        """Returns a list of objects."""
        value = self.find(key)
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.fail(key, "a list of objects")
        return [Result(self.path, item, f"{self.where}{key}[{i}].") for i, item in enumerate(value)]


def load(path: pathlib.Path, *schemas: str) -> Result:
    """Reads a JSON file of one of these schemas."""
    try:
        values = json.loads(_read(path))
    except (ValueError, RecursionError) as error:
        raise malformed(path, f"is damaged: {error}") from None
    if not isinstance(values, dict):
        raise malformed(path, "is not a JSON object")
    result = Result(path, values)
    if result.find("schema") not in schemas:
        raise result.fail("schema", " or ".join(schemas))
    return result


class Table:
    """Columns of a CSV file: lines that begin with # are comments, the first other line has the names."""

    def __init__(self, path: pathlib.Path):
        self.path = path
        lines = [(number, line) for number, line in enumerate(_read(path).splitlines(), 1)
                 if line and not line.startswith("#")]
        if not lines:
            raise malformed(path, "is empty")
        (self.first, head), rows = lines[0], lines[1:]
        self.names, self.lines = head.split(","), [number for number, _ in rows]
        cells = [line.split(",") for _, line in rows]
        for number, row in zip(self.lines, cells):
            if len(row) != len(self.names):
                raise malformed(f"{readable(path)}:{number}", f"has {len(row)} columns, the header {len(self.names)}")
        self.columns: list[tuple[str, ...]] = list(zip(*cells)) if cells else [()] * len(self.names)

    def words(self, name: str) -> tuple[str, ...]:
        """Returns a column as text."""
        if name not in self.names:
            raise malformed(f"{readable(self.path)}:{self.first}", f"has no column {name}")
        return self.columns[self.names.index(name)]

    def numbers(self, name: str, finite: bool = True) -> Array:
        """Returns a column of at least one number; all are finite unless stated otherwise."""
        words = self.words(name)
        if not words and finite:
            raise malformed(self.path, "has no rows")
        try:
            values = numpy.array(words, dtype=float)
        except ValueError:
            values = numpy.array([_number(word) for word in words])
            raise self._fail(name, words, numpy.isnan(values)) from None
        if finite and not numpy.isfinite(values).all():
            raise self._fail(name, words, ~numpy.isfinite(values))
        return values

    def _fail(self, name: str, words: tuple[str, ...], bad: Array) -> Failure:
        at = int(numpy.flatnonzero(bad)[0])
        where = f"{readable(self.path)}:{self.lines[at]}"
        return malformed(where, f"{name} = {words[at][:60]}: must be a finite number")


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan


def goodness_of(result: Result) -> str:
    """Returns the goodness of the fit of a series in words."""
    return (f"Residuals: chi-square {result.number('chi_square'):.4g} ± {result.number('chi_square_sigma'):.2g} per degree of "
            f"freedom, {result.text('goodness')}; the largest is {result.number('largest_residual'):.2g} sigma.")


def array(path: pathlib.Path, dimensions: int) -> Array:
    """Reads a .npy file of real numbers with so many axes."""
    try:
        values = numpy.load(path, allow_pickle=False)
    except OSError as error:
        raise malformed(path, error.strerror or str(error)) from None
    except (ValueError, EOFError) as error:
        raise malformed(path, f"is damaged: {error}") from None
    if values.dtype.kind not in "fiu" or values.ndim != dimensions or not values.size:
        raise malformed(path, f"must be an array of real numbers with {dimensions} axes")
    return values.astype(float)
