"""Unknown optics, projected out: they must neither bias the separation nor cost more than the bound says.

Frames are simulated with 0.1 nm of coma, 0.05 px of jitter and stars 5 K hotter; template and network are made for a
telescope without them, with all of these projected out. TOLIMAN_SEEDS: of noise and weights. The exit status is 1 if a figure is missed."""
import json
import os
import pathlib
import sys
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

FRAMES, AT_ONCE, SEEDS = 3000, 500, int(os.environ.get("TOLIMAN_SEEDS", 1))
KNOWN = ["flux_a", "flux_b", "shift_x", "shift_y", "roll", "scale", "focus", "background"]
UNKNOWN = ["zernike_7", "jitter_xx", "jitter_yy", "jitter_xy", "temperature_a", "temperature_b"]
TEMPERATURES = {"A": 5790, "B": 5260}


def scene_with(projected, hotter=0, coma_nm=0, jitter_px=0):
    folder = ROOT / "examples" / "scenes"
    scene = json.loads((folder / "mission.json").read_text())
    scene["binary"] = {"orbit": "alpha-cen", "date": 2028.0, "centre": "barycentre"}
    for star, kelvin in TEMPERATURES.items():
        spectrum = scene["stars"][star]["spectrum"]
        spectrum.update(file=str(folder / spectrum["file"]), table_temperature_k=kelvin, star_temperature_k=kelvin + hotter)
    if coma_nm:
        scene["telescope"]["aberrations"] = {"zernike_rms_nm": {"7": coma_nm}}
    if jitter_px:
        scene["systematics"] = {"jitter_sigma_px": jitter_px}
    scene["preprocess"] = {"project": projected}
    return scene


def make(projected, seed):
    model = toliman.Simulator(scene_with(projected))
    network = toliman.CAE(model, seed=seed)
    network.train()
    return {"template": toliman.Template(model), "network": network}, model.bounds.crb_projected_px


class Unknowns(unittest.TestCase):
    def test_bias_and_efficiency(self):
        truth = toliman.Simulator(scene_with(KNOWN, hotter=5, coma_nm=0.1, jitter_px=0.05))
        quiet = truth.expect(0)
        efficiencies, biases = {"template": [], "network": []}, {"template": [], "network": []}
        for seed in range(1, SEEDS + 1):
            estimators, bound = make(KNOWN + UNKNOWN, seed)
            values_of = {name: [] for name in estimators}
            for first in range(0, FRAMES, AT_ONCE):
                frames = truth.frames(first, AT_ONCE, displacements=numpy.zeros(AT_ONCE), seed=seed)
                for name, estimator in estimators.items():
                    values_of[name].extend(estimator.encode(frames))
            for name, estimator in estimators.items():
                values = numpy.array(values_of[name])
                biases[name].append(estimator.encode(quiet) / bound)
                efficiencies[name].append(bound / values.std(ddof=1))
                self.assertLess(abs(biases[name][-1]), 0.1, name)
                self.assertLess(abs(values.mean()), 4 * bound / FRAMES ** 0.5, name)  # of these frames, with their noise
        for name in efficiencies:
            print(f"{name}: efficiency {numpy.median(efficiencies[name]):.3f} (median of {SEEDS}), largest bias "
                  f"{max(map(abs, biases[name])):.4f} sigma, bound {bound:.3e} px")
            self.assertAlmostEqual(numpy.median(efficiencies[name]), 1, delta=0.05, msg=name)

    def test_not_projected_they_bias(self):
        """The control: the same frames, with the eight nuisances of the pointing alone projected out."""
        truth = toliman.Simulator(scene_with(KNOWN, hotter=5, coma_nm=0.1, jitter_px=0.05))
        model = toliman.Simulator(scene_with(KNOWN))
        bias = toliman.Template(model).encode(truth.expect(0)) / model.bounds.crb_projected_px
        print(f"control, not projected out: bias {bias:.1f} sigma")
        self.assertGreater(abs(bias), 10)


if __name__ == "__main__":
    unittest.main()
