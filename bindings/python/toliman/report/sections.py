"""Recognises a folder by its files and returns the function that adds it to the page."""
from __future__ import annotations

import json
import os
import pathlib
import typing

from .._failure import malformed, readable
from . import bench, budget, calibration, experiment, mask, period, planet, run, state
from .page import Page

Section = typing.Callable[[pathlib.Path, Page], None]


def section_of(folder: pathlib.Path) -> Section:
    """Returns the section of a folder, which must be readable."""
    try:
        names = os.listdir(folder)
    except NotADirectoryError:
        raise malformed(folder, "is not a folder: give one written by run, experiment, track, period --out, planet --out, "
                                "pupil --out or `make bench`") from None
    except FileNotFoundError:
        raise malformed(folder, "No such folder") from None
    except OSError as error:
        raise malformed(folder, error.strerror or str(error)) from None
    if "ledger.tlml" in names:
        name = readable(folder)
        raise malformed(folder, f"is a state folder of toliman track: run `toliman report {name}`, or `toliman status "
                                f"{name} --out FOLDER` and give that folder")
    if "result.json" in names:
        schema = _schema(folder / "result.json")
        return (state.add if schema.startswith("toliman-state/") else
                period.add if schema.startswith("toliman-period/") else
                planet.add if schema.startswith("toliman-planet/") else run.add)
    if "experiment.json" in names:
        return experiment.add
    if "pupil.json" in names:
        return mask.add
    if "budget.json" in names:
        return budget.add
    if calibration.files_of(folder):
        return calibration.add
    if bench.files_of(folder):
        return bench.add
    kind = "a folder" if names else "an empty folder"
    raise malformed(folder, "contains neither result.json (of toliman run, toliman status --out, "
                            "toliman period --out or toliman planet --out), nor experiment.json (toliman.experiment), "
                            "nor pupil.json (toliman pupil --out), nor budget.json (toliman budget), nor a "
                            f"*.calibration.json (toliman calibrate), nor a *.json of schema {bench.SCHEMA} (make "
                            f"bench); it is {kind}")


def _schema(path: pathlib.Path) -> str:
    """The schema of a JSON file; "" if there is none, of which the section complains."""
    try:
        return str(json.loads(path.read_bytes())["schema"])
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return ""
