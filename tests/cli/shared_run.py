"""A short run of the chapter's scene that several tests read, none of which changes it. `python3 shared_run.py FOLDER` makes
it: ctest does so once, as a fixture, and sets TOLIMAN_RUN to the folder. A test without TOLIMAN_RUN makes its own."""
import atexit
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy
from program import PROGRAM, one_wavelength

SIDE, COLUMNS, FRAMES, AMPLITUDE, PERIOD = 256, 276, 20, 1e-4, 7
SEED = 2**53 + 1  # no double holds it
SCENE, NAME = "it's a scene.json", "short.1"


def scene_of(**groups):
    """Few frames at one wavelength, on a detector that is turned by 50 degrees and longer than the network's crop."""
    scene = {**one_wavelength(), "name": NAME}
    scene["cadence"]["frames"] = FRAMES
    scene["signal"].update(amplitude_px=AMPLITUDE, period_days=PERIOD)
    scene["detector"].update(rotation_deg=50, shape=[SIDE, COLUMNS])
    for name, group in groups.items():
        scene[name] = {**scene[name], **group}
    return scene


def make(folder):
    """Writes the scene to the folder and the results to the folder in it that is the default."""
    (folder / SCENE).write_text(json.dumps(scene_of()))
    done = subprocess.run([PROGRAM, "run", SCENE, "--seed", str(SEED)], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def shared_run():
    """The folder of the run's results; the scene is in the folder above it."""
    if "TOLIMAN_RUN" not in os.environ:
        folder = tempfile.mkdtemp()
        atexit.register(shutil.rmtree, folder)
        os.environ["TOLIMAN_RUN"] = folder
        make(pathlib.Path(folder))
    return pathlib.Path(os.environ["TOLIMAN_RUN"]) / f"{NAME}.run"


def rows_of(path):
    """{name: array} of the columns of a CSV file with comments."""
    with open(path) as file:
        rows = list(csv.DictReader(line for line in file if line[0] != "#"))
    return {name: numpy.array([float(row[name]) for row in rows]) for name in rows[0]}


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    make(target)
