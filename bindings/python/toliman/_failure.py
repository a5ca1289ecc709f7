"""Failures of the programs of this package: one line of text and the exit codes of `toliman`."""
from __future__ import annotations

import pathlib
import typing

if typing.TYPE_CHECKING:
    from ._library import Error

INTERNAL, USAGE, INPUT, OUTPUT = 1, 2, 3, 6
_CODES = {"TOLIMAN_E_NOT_FOUND": INPUT, "TOLIMAN_E_FORMAT": INPUT, "TOLIMAN_E_WRITE": OUTPUT, "TOLIMAN_E_LOST": OUTPUT,
          "TOLIMAN_E_MEMORY": INTERNAL, "TOLIMAN_E_INTERNAL": INTERNAL}


class Failure(Exception):
    """Ends the program: one line of text and an exit code."""

    def __init__(self, code: int, text: str):
        super().__init__("".join(letter if letter.isprintable() else "?" for letter in text))
        self.code = code


def malformed(path: pathlib.Path | str, why: str) -> Failure:
    """Returns the failure of an input that cannot be used."""
    return Failure(INPUT, f"{readable(path)}: {why}")


def readable(path: pathlib.Path | str) -> str:
    """Returns a file's name as text; bytes that are not UTF-8 become U+FFFD."""
    return str(path).encode(errors="surrogateescape").decode(errors="replace")


def failure_of(error: Error) -> Failure:
    """Returns the failure of a call of the library."""
    return Failure(_CODES.get(error.name, USAGE), str(error))
