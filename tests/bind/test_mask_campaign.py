"""Designed masks at few samples, wavelengths and pixels: the short form of mask_campaign.py."""
import argparse
import pathlib
import tempfile
import unittest
import unittest.mock

import numpy

from study import run
import mask_campaign as campaign

GROUPS = {"telescope": {"pupil_samples": 64}, "band": {"min_nm": 550, "max_nm": 600, "step_nm": 12.5},
          "detector": {"shape": [80, 80]}, "cadence": {"frames": 40}}
CASES = {"mission": ("mission", (2027.0, 2031.0), 2), "sky": ("sky", (2026.5,), 2), "chapter": ("chapter", (None,), 2)}
BY_CHANCE = {"peak-to-mean over that of the spiral", "light outside the frame"}  # after few iterations


class Campaign(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.options = argparse.Namespace(folder=pathlib.Path(folder.name), masks=1, seeds=2, methods="template", iterations=10,
                                         cases=CASES, groups=GROUPS)

    def run_mode(self, mode, **more):
        """Figures that are missed, and the cells of the printed rows."""
        limits = {"ASKED": {}, "GAIN": 0.9, "EFFICIENCY": 0.8, "BIAS": 0.6}
        with unittest.mock.patch.multiple(campaign, **limits):
            wrong, lines = run(mode, argparse.Namespace(**{**vars(self.options), **more}))
        return wrong, [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]

    def test_designs(self):
        wrong, rows = self.run_mode(campaign.designs, cases={name: CASES[name] for name in ("mission", "sky")})
        self.assertLessEqual({text.split(": ")[1] for text in wrong}, BY_CHANCE)
        self.assertEqual([len(row[3].split()) for row in rows], [2, 1])
        for row in rows:
            for designed, spiral in zip(row[3].split(), row[4].split()):
                self.assertLess(float(designed), 0.9 * float(spiral))

    def test_designs_resume(self):
        first = campaign.design(self.options, "mission", 1)
        with unittest.mock.patch.object(campaign.toliman, "design_mask", side_effect=AssertionError):
            self.assertEqual(campaign.design(self.options, "mission", 1), first)

    def test_tolerances(self):
        wrong, rows = self.run_mode(campaign.tolerances)
        self.assertEqual((wrong, len(rows)), ([], 8))
        bounds = [float(row[2]) for row in rows[::2]]
        self.assertLess(bounds[0], bounds[1])

    def test_frames(self):
        wrong, rows = self.run_mode(campaign.frames)
        self.assertEqual((wrong, len(rows)), ([], 4))
        self.assertEqual([row[-2] for row in rows], ["0 of 4"] * 4)

    def test_sky(self):
        wrong, rows = self.run_mode(campaign.sky)
        self.assertEqual([text for text in wrong if "detector" in text], [])
        self.assertEqual(len(rows), 4)
        self.assertLess(float(rows[0][3]), float(rows[1][3]))


class Figures(unittest.TestCase):
    def test_small_features(self):
        """Shares of the cells: a single cell, a line, squares of 2 x 2 and of 3 x 3, and the same where it is dark."""
        for size, side, share in (((1, 1), 2, 1), ((1, 8), 2, 8), ((2, 2), 2, 0), ((2, 2), 3, 4), ((3, 3), 3, 0)):
            cells, is_open = numpy.zeros((20, 20)), numpy.ones((20, 20), bool)
            cells[4:4 + size[0], 5:5 + size[1]] = 1
            for kind in (cells, 1 - cells):
                self.assertEqual(campaign.small_share(kind, is_open, side), share / 400, (size, side))
            is_open[4:7, 5:12] = False
            self.assertLess(campaign.small_share(cells, is_open, side), 0.01, (size, side))
        checkers = numpy.indices((8, 8)).sum(0) % 2  # all but the corners are small
        self.assertEqual(campaign.small_share(checkers, numpy.ones((8, 8), bool)), 60 / 64)

    def test_limits(self):
        found = {"eight": numpy.array([2e-6, 2.2e-6]), "own eight": [3e-6] * 2, "both": [1.6e-6], "peak": numpy.array([40, 41]),
                 "own peak": numpy.array([40, 40]), "exact": -0.02, "small": 1e-3}
        wrong = campaign.misses("mission", found, {"crb_px": [2e-6, 2.3e-6], "light_in_frame": [0.9, 0.8]})
        self.assertEqual(len(wrong), 8)
        self.assertEqual(wrong[0], "bound, px: 2e-06: must be at most 1.95e-06")
        good = {**found, "eight": numpy.array([1.8e-6, 1.81e-6]), "both": [1.5e-6], "peak": found["own peak"], "exact": 1e-9,
                "small": 0}
        self.assertEqual(campaign.misses("mission", good, {"crb_px": [1.8e-6, 1.81e-6], "light_in_frame": [0.9, 0.88]}), [])

    def test_aberrations(self):
        for scene in campaign.changes_of({"telescope": {"mask": {}}})["20 nm rms, median of 5"]:
            zernikes = scene["telescope"]["aberrations"]["zernike_rms_nm"]
            self.assertAlmostEqual(numpy.linalg.norm(list(zernikes.values())), 20)
            self.assertEqual(sorted(map(int, zernikes)), list(range(5, 12)))


if __name__ == "__main__":
    unittest.main()
