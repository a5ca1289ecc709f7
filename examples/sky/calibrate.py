"""Calibrates a telescope with ten frames of its own, and shows what that changes: the errors of the separation with the
nominal optics and with the calibrated ones.

    python3 calibrate.py [SEED] [SCENE]         by default 1 examples/scenes/sky.json
"""
import json
import pathlib
import sys
import tempfile

import numpy

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(TOP / "build" / "python"))  # if it is not installed
from toliman import Fit, Simulator, calibrate
from truth import draw_truth, resolve_files, true_changes

FRAMES, DAYS, PHOTONS = 10, 1095.75, 1e10

path = pathlib.Path(sys.argv[2] if sys.argv[2:] else TOP / "examples" / "scenes" / "sky.json")
nominal = json.loads(path.read_text())
resolve_files(nominal, path.parent.resolve())
if nominal["telescope"]["mask"]["kind"] == "spiral":
    nominal["telescope"]["mask"]["edges"] = "area"  # only such a mask can rotate by little
given = nominal["cadence"]
light = ({"peak_photons": given["peak_photons"]} if "peak_photons" in given else
         {"exposure_s": PHOTONS / sum(toliman.plan(nominal).electrons_per_s)})
nominal["cadence"] = {"times_days": numpy.linspace(0, DAYS, FRAMES), **light}
nominal.pop("preprocess", None)  # of estimators for stars at rest


def errors(simulator, frames, truth):
    """Fitted separations minus the true ones, px, and their standard deviation."""
    times, displacements = truth.series()
    true = Fit(truth)
    predicted = [true.predict(time_days=time)[1][0] for time in times]
    fitted = Fit(simulator).frames(frames, times_days=times)
    return fitted["separation_px"] - predicted - displacements, numpy.median(fitted["separation_sigma_px"])


# The truth is seen by nobody: only its frames are used below, and its separations to compare with.
scene = draw_truth(nominal, int(sys.argv[1]) if sys.argv[1:] else 1)
truth, changes = Simulator(scene), true_changes(nominal, scene)
frames = truth.frames()

simulator = Simulator(nominal)
calibration = calibrate(simulator, frames)
print(calibration.verdict)
for name, value in calibration.values().items():
    print(f"  {name:14s} {value.value:11.4g} +- {value.sigma:.2g} {value.unit}, true {changes.get(name, 0):.4g}")
with tempfile.TemporaryDirectory() as folder:
    calibration.save(pathlib.Path(folder) / "fitted.json")
    fitted = Simulator(pathlib.Path(folder) / "fitted.json")
for name, optics in (("nominal", simulator), ("calibrated", fitted), ("true", truth)):
    found, sigma = errors(optics, frames, truth)
    print(f"{name:10s} optics: mean {found.mean():+.1e} px, scatter {found.std():.1e} px (photon noise {sigma:.1e} px)")
