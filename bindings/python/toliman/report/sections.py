"""Recognises a folder by its files and returns the function that adds it to the page."""
from __future__ import annotations

import os
import pathlib
import typing

from . import run
from .page import Page
from .results import malformed

Section = typing.Callable[[pathlib.Path, Page], None]


def section_of(folder: pathlib.Path) -> Section:
    """Returns the section of a folder; the folder must be readable."""
    try:
        names = os.listdir(folder)
    except OSError as error:
        raise malformed(folder, error.strerror or str(error)) from None
    if "result.json" in names:
        return run.add
    raise malformed(folder, "contains no results")
