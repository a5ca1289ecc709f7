"""design_mask in Python: the masks of the program, scores, quantum bounds, the end of a design, errors."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused


def small_scene():
    """The chapter's scene with few samples, wavelengths and pixels."""
    scene = json.loads((ROOT / "examples/scenes/chapter.json").read_text())
    scene["telescope"]["pupil_samples"] = 64
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    scene["detector"]["shape"] = [80, 80]
    return scene


class DesignMask(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(small_scene())
        cls.addClassCleanup(cls.simulator.close)

    def test_masks_equal_the_program_s(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.json"
            path.write_text(json.dumps(small_scene()))
            theirs = json.loads(subprocess.run(
                [os.environ["TOLIMAN"], "pupil", path, "--iterations", "6", "--seed", "5", "--out", path.parent / "made", "--json"],
                check=True, capture_output=True).stdout)
            cells = numpy.load(path.parent / "made/mask.npy")
        made = toliman.design_mask(self.simulator, iterations=6, seed=5, threads=1)
        info = made.places[0]
        self.assertEqual((made.mask, info.iterations, info.improved), (theirs["mask"], theirs["iterations"], theirs["improved"]))
        self.assertGreater((made.cells == cells).mean(), 0.999)  # the program selects OpenBLAS kernels
        numpy.testing.assert_allclose(made.descent, theirs["descent_px"], rtol=1e-6)
        for name, value in theirs["places"][0]["scene_mask"].items():
            before = name.replace("_px", "_before_px") if name.endswith("_px") else name + "_before"
            self.assertAlmostEqual(getattr(info, before) / value, 1, delta=1e-9)
        for name, value in theirs["places"][0]["designed"].items():
            self.assertAlmostEqual(getattr(info, name) / value, 1, delta=0.01)

    def test_quantum_bound(self):
        """Of a round aperture: lambda/(pi D sqrt(N)), which the clear pupil reaches in one colour but for the light it loses."""
        wavelength, aperture, photons, pixel = 585e-9, 0.125, 1e9, 0.2
        scene = {
            "schema": "toliman-scene/1", "telescope": {"aperture_m": aperture, "pupil_samples": 256},
            "band": {"min_nm": 584.99, "max_nm": 585.01, "step_nm": 0.02},
            "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": photons}},
            "binary": {"offsets_px": {"A": [0, 0]}}, "cadence": {"frames": 4, "exposure_s": 1},
            "signal": {"kind": "sinusoid", "star": "A", "amplitude_px": 1e-6, "period_days": 9},
            "detector": {"shape": [160, 160], "pixel_scale_arcsec": pixel}, "noise": {"photon": True}, "accuracy": 1e-9}
        with toliman.Simulator(scene) as clear:
            info = toliman.design_mask(clear, free=[], iterations=1, peak_to_mean=1e6, light_in_frame=0.1).places[0]
            bound = clear.bounds.crb_px
        expected = wavelength / (numpy.pi * aperture * photons**0.5) / (pixel * numpy.pi / 648000)
        self.assertAlmostEqual(info.quantum_px / expected, 1, delta=2e-3)
        self.assertEqual(info.crb_before_px, info.crb_alone_before_px)
        self.assertAlmostEqual(info.crb_before_px / bound, 1, delta=1e-9)
        self.assertGreater(bound, info.quantum_px)
        self.assertLess(bound, 1.05 * info.quantum_px)
        self.assertEqual(info.quantum_flux_shift_px, numpy.inf)

    def test_design(self):
        """At two position angles. Scores of its scene, and threads: tests/unit/test_mask.c."""
        simulator = toliman.Simulator(small_scene())
        made = toliman.design_mask(simulator, free=["flux_a", "flux_b", "shift_x", "shift_y"], position_angles=[30, 40],
                                   peak_to_mean=40, light_in_frame=0.5, iterations=40, seed=2, threads=2)
        self.assertEqual(made.mask, {"kind": "file", "file": "mask.npy", "quantity": "binary", "opd_nm": 297.5})
        self.assertEqual((made.cells.shape, made.cells.dtype), ((64, 64), numpy.uint8))
        self.assertEqual(len(made.places), 2)
        for info in made.places:
            self.assertLess(info.peak_to_mean, 40)
            self.assertLess(info.crb_px, info.crb_before_px)

    def test_refusals_of_a_design(self):
        for text, options in (("options->free", {"free": ["scale_x"]}), ("options->free", {"free": ["zernike_5"]}),
                              ("options->free", {"free": ["focus", "focus"]}),
                              ("binary.orbit", {"dates": [2027]}),
                              ("options->date_count", {"dates": [2027], "position_angles": [3]}),
                              ("options->position_angles_deg[1]", {"position_angles": [3, numpy.nan]}),
                              ("options->peak_to_mean", {"peak_to_mean": 0.5}), ("options->light_in_frame", {"light_in_frame": 1}),
                              ("options->feature_cells", {"feature_cells": 99}), ("options->iterations", {"iterations": 200000})):
            with self.subTest(text), refused(toliman.InputError, text):
                toliman.design_mask(self.simulator, **options)
        with refused(ValueError, "symmetry"):
            toliman.design_mask(self.simulator, symmetry="threefold")
        with refused(TypeError, "simulator"):
            toliman.design_mask(3)
        with refused(ValueError, "iterations"):
            toliman.design_mask(self.simulator, iterations=-1)

    def test_structure_of_the_light(self):
        """Differences between neighbouring points of a grid nine times as fine, which has every pixel's centre."""
        frame = self.simulator.expect(0)
        scene = small_scene()
        scene["detector"] = {"shape": [720, 720], "pixel_scale_arcsec": 0.2 / 9}
        with toliman.Simulator(scene) as fine:
            light = fine.expect(0)
        slopes = [9 * slope[4::9, 4::9] for slope in numpy.gradient(light)]
        light = light[4::9, 4::9]
        energy = numpy.mean(slopes[0]**2 + slopes[1]**2) / light.mean()**2
        self.assertAlmostEqual(self.simulator.bounds.gradient_energy / energy, 1, delta=0.01)
        for image in (frame, light):
            self.assertAlmostEqual(self.simulator.bounds.peak_to_mean / (image.max() / image.mean()), 1, delta=1e-6)

    def test_progress_ends_the_design(self):
        seen = []
        made = toliman.design_mask(self.simulator, progress=lambda stage, fraction: seen.append(stage) or True)
        self.assertEqual((seen, made.places[0].stopped, made.places[0].iterations, len(made.descent)), (["draw"], True, 0, 0))
        self.assertEqual(set(made.cells.ravel()), {0, 1})
        with self.assertRaises(ZeroDivisionError):
            toliman.design_mask(self.simulator, progress=lambda stage, fraction: 1 / 0)


if __name__ == "__main__":
    unittest.main()
