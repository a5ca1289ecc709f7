"""search_mask in Python: the masks of the program, the end of a search, errors."""
import copy
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bindings" / "python"))
import toliman  # noqa: E402


def small_scene():
    """The chapter's scene with few samples, wavelengths and pixels."""
    scene = json.loads((ROOT / "examples/scenes/chapter.json").read_text())
    scene["telescope"]["pupil_samples"] = 64
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    scene["detector"]["shape"] = [80, 80]
    return scene


class SearchMask(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(small_scene())
        cls.addClassCleanup(cls.simulator.close)

    def test_masks_equal_the_program_s(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.json"
            path.write_text(json.dumps(small_scene()))
            theirs = json.loads(subprocess.run([os.environ["TOLIMAN"], "pupil", path, "--count", "40", "--seed", "5", "--json"],
                                               check=True, capture_output=True).stdout)
        mask, info = toliman.search_mask(self.simulator, count=40, seed=5, threads=1)
        self.assertEqual((mask, info.tried, info.improved, info.stopped), (theirs["mask"], 40, True, False))
        for name in ("crb_before_px", "crb_px", "peak_to_mean_before", "peak_to_mean", "light_in_frame_before", "light_in_frame",
                     "gradient_energy_before", "gradient_energy"):
            self.assertAlmostEqual(getattr(info, name) / theirs[name], 1, delta=1e-12)  # the program selects OpenBLAS kernels
        scene = copy.deepcopy(small_scene())
        scene["telescope"]["mask"] = mask
        with toliman.Simulator(scene) as better:
            for name in ("crb_px", "peak_to_mean", "gradient_energy"):
                self.assertAlmostEqual(getattr(better.bounds, name) / getattr(info, name), 1, delta=1e-12)

    def test_design(self):
        """A mask whose scene has the scores of the design; the same on any number of threads."""
        simulator = toliman.Simulator(small_scene())
        made = toliman.design_mask(simulator, free=["flux_a", "flux_b", "shift_x", "shift_y"], position_angles=[30, 40],
                                   peak_to_mean=40, light_in_frame=0.5, iterations=40, seed=2, threads=2)
        self.assertEqual(made.mask, {"kind": "file", "file": "mask.npy", "quantity": "binary", "opd_nm": 297.5})
        self.assertEqual((made.cells.shape, made.cells.dtype), ((64, 64), numpy.uint8))
        again = toliman.design_mask(simulator, free=["flux_a", "flux_b", "shift_x", "shift_y"], position_angles=[30, 40],
                                    peak_to_mean=40, light_in_frame=0.5, iterations=40, seed=2, threads=1)
        self.assertTrue((again.cells == made.cells).all())
        self.assertEqual(again.places, made.places)
        with tempfile.TemporaryDirectory() as folder:
            numpy.save(pathlib.Path(folder) / "mask.npy", made.cells)
            for angle, info in zip((30, 40), made.places):
                scene = small_scene()
                scene["binary"]["position_angle_deg"] = angle
                for suffix, mask in (("_before", scene["telescope"]["mask"]), ("", made.mask)):
                    scene["telescope"]["mask"] = mask
                    bounds = toliman.Simulator(scene, folder=folder).bounds
                    for name, value in (("crb", bounds.crb_flux_shift_px), ("peak_to_mean", bounds.peak_to_mean),
                                        ("gradient_energy", bounds.gradient_energy)):
                        known = getattr(info, f"crb{suffix}_px" if name == "crb" else name + suffix)
                        self.assertAlmostEqual(known / value, 1, delta=1e-6)
                self.assertLess(info.peak_to_mean, 40)

    def test_refusals_of_a_design(self):
        for text, options in (("scale_x", {"free": ["scale_x"]}), ("zernike_5: a design", {"free": ["zernike_5"]}),
                              ("focus is named twice", {"free": ["focus", "focus"]}),
                              ("binary.orbit: dates of a design need", {"dates": [2027]}),
                              ("at most one", {"dates": [2027], "position_angles": [3]}),
                              (r"position_angles_deg\[1\] = nan", {"position_angles": [3, numpy.nan]}),
                              ("peak_to_mean = 0.5", {"peak_to_mean": 0.5}), ("light_in_frame = 1", {"light_in_frame": 1}),
                              ("feature_cells = 99", {"feature_cells": 99}), ("iterations = 200000", {"iterations": 200000})):
            with self.subTest(text), self.assertRaisesRegex((toliman.InputError, ValueError), text):
                toliman.design_mask(self.simulator, **options)
        with self.assertRaisesRegex(ValueError, "symmetry = 'threefold': must be one of none, even, odd"):
            toliman.design_mask(self.simulator, symmetry="threefold")
        stopped = toliman.design_mask(self.simulator, progress=lambda stage, fraction: True)
        self.assertTrue(stopped.places[0].stopped)
        self.assertEqual(set(stopped.cells.ravel()), {0, 1})

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

    def test_progress_ends_the_search(self):
        seen = []
        mask, info = toliman.search_mask(self.simulator, progress=lambda stage, fraction: seen.append(stage) or True)
        self.assertEqual((mask, info.tried, info.improved, info.stopped), (None, 0, False, True))
        self.assertRegex(seen[0], "^draw: best .* px$")
        self.assertEqual(len(seen), 1)
        with self.assertRaises(ZeroDivisionError):
            toliman.search_mask(self.simulator, progress=lambda stage, fraction: 1 / 0)

    def test_refusals(self):
        with self.assertRaisesRegex(ValueError, "minutes"):
            toliman.search_mask(self.simulator, minutes=-1)
        with self.assertRaises(TypeError):
            toliman.search_mask("chapter.json")
        with self.assertRaisesRegex(ValueError, "count = -1"):
            toliman.search_mask(self.simulator, count=-1)


if __name__ == "__main__":
    unittest.main()
