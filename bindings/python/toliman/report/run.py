"""The section of `toliman run`."""
from __future__ import annotations

import pathlib

from . import results
from .page import Page


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of a run to the page."""
    result = results.load(folder / "result.json", "toliman-run/2")
    page.add("title", "toliman run: " + result.text("scene"))
