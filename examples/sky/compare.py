"""Prints what is true of a mission of mission.py next to what the three commands found.

    python3 compare.py FOLDER"""
import json
import logging
import math
import os
import pathlib
import shutil
import subprocess
import sys

import numpy

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(TOP / "build" / "python"))  # if it is not installed
import toliman  # noqa: E402
from truth import true_changes  # noqa: E402

EARTH_SUNS, DAYS_PER_YEAR = 3.0034896e-6, 365.25
CONTROLS = "scale", "mask_rotation", "focus", "jitter_xx", "temperature_a"


def program():
    return os.environ.get("TOLIMAN") or shutil.which("toliman") or str(TOP / "build" / "bin" / "toliman")


def mass_earth(planet, star_mass, parallax_mas):
    """Kepler's third law: the reflex of a star is the planet's share of the mass times the semi-major axis."""
    axis_au = (star_mass * (planet["period_days"] / DAYS_PER_YEAR) ** 2) ** (1 / 3)
    return planet["amplitude_uas"] / (1e3 * parallax_mas * axis_au) * star_mass / EARTH_SUNS


def separations(folder, truth):
    """Measured minus true separations in standard deviations of a frame."""
    measured = toliman.Measurements(folder / "mission", kind="separation")
    numbers = numpy.searchsorted(truth["middles_tai_ns"], measured.tai_ns - 10**9)  # times are rounded
    return (measured.y - numpy.array(truth["separations_px"])[numbers]) / measured.sigma


def calibration(folder):
    """Rows of the parameters of the telescope: name, truth, value, standard deviation, unit."""
    nominal, true = (json.loads((folder / name).read_text()) for name in ("scene.json", "truth/scene.json"))
    said = json.loads((folder / "fitted.calibration.json").read_text())
    changes, rows = true_changes(nominal, true), []
    for row in said["windows"][0]["parameters"]:
        if row["name"] in CONTROLS or row["name"] in ("zernike_5", "zernike_6"):
            rows.append((row["name"], changes.get(row["name"], 0.0), row["value"], row["sigma"], row["unit"]))
    return rows, said


def said_by(folder, *words):
    """What a command says as JSON."""
    done = subprocess.run([program(), *words, "--json"], cwd=folder, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def compare(folder):
    """Everything that is compared, for a campaign."""
    folder = pathlib.Path(folder).resolve()
    truth = json.loads((folder / "truth" / "truth.json").read_text())
    for planet in truth["planets"]:
        planet["mass_earth"] = mass_earth(planet, truth["masses"][0], truth["parallax_mas"])
    parameters, said = calibration(folder)
    status = said_by(folder, "status", "mission")
    found, errors = {"candidates": []}, numpy.empty(0)
    if status["accepted"]:  # otherwise the frames do not fit: there is nothing to search
        found, errors = said_by(folder, "planet", "mission", "--max", "2"), separations(folder, truth)
    return {"planets": truth["planets"], "found": [one for one in found["candidates"] if one["verdict"] == "planet"],
            "candidates": found["candidates"], "parameters": parameters, "complete": said["complete"],
            "chi_square": said["chi_square"], "goodness": status["goodness"]["goodness"], "errors": errors}


def interval(values):
    low, middle, high = values
    return f"{middle:.4g} -{middle - low:.3g} +{high - middle:.3g}"


def pairs(planets, found):
    """Each planet with the one that was found at its period, to a third of it, or None; then those that are not there."""
    rest, rows = list(found), []
    for true in planets:
        near = min(rest, key=lambda one: abs(math.log(one["period"][1] / true["period_days"])), default=None)
        if near and abs(math.log(near["period"][1] / true["period_days"])) < 0.3:
            rest.remove(near)
        else:
            near = None
        rows.append((true, near))
    return rows + [(None, one) for one in rest]


def show(result):
    print(f"{'':16s} {'true':>12s}   {'found':s}")
    for name, true, value, sigma, unit in result["parameters"]:
        print(f"{name:16s} {true:12.5g}   {value:.5g} +- {sigma:.2g} {unit}")
    errors = result["errors"]
    said = (f"{len(errors)} frames: errors of mean {errors.mean():+.2f} and scatter {errors.std():.2f} in standard deviations of a frame"
            if len(errors) else "no frame is accepted")
    print(f"{'separations':16s} {'':12s}   {said}")
    for true, found in pairs(result["planets"], result["found"]):
        for name, key, given in (("period, d", "period", "period_days"), ("amplitude, uas", "amplitude_uas", "amplitude_uas"),
                                 ("mass g, Earths", "mass_a_earth", "mass_earth")):
            print(f"{name:16s} {'none' if true is None else format(true[given], '.5g'):>12s}   "
                  f"{'none' if found is None else interval(found[key])}")
    if not result["planets"] and not result["found"]:
        print(f"{'planet':16s} {'none':>12s}   none")


if __name__ == "__main__":
    logging.getLogger("toliman").setLevel(logging.ERROR)
    show(compare(sys.argv[1] if sys.argv[1:] else "."))
