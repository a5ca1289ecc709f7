"""Designed masks against their limits: the short form of mask_campaign.py."""
import contextlib
import io
import pathlib
import sys
import tempfile
import types
import unittest
import unittest.mock

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import mask_campaign as campaign  # noqa: E402


def coarse():
    """The mission with 80 cells per axis, 80 x 80 pixels and few wavelengths."""
    scene = campaign.scene_of("mission", detector={"shape": [80, 80], "pixel_scale_arcsec": 0.6})
    scene["telescope"]["pupil_samples"] = 80
    scene["binary"] = {"orbit": "alpha-cen", "date": 2027.0, "centre": "barycentre"}
    scene["band"].update(step_nm=10)
    return scene


class Campaign(unittest.TestCase):
    def test_a_design_is_judged(self):
        """A mask of one iteration has the bound that is stated, and misses the limits."""
        shown = io.StringIO()
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(shown):
            options = types.SimpleNamespace(folder=pathlib.Path(folder), iterations=1)
            bound, flux_shift, good = campaign.design("coarse", coarse(), 1, options, [2027.0, 2028.0])
        self.assertFalse(good)
        self.assertLess(flux_shift, bound)
        exact = float(shown.getvalue().rsplit("|", 2)[1])
        self.assertLess(abs(exact), campaign.NODES)

    def test_small_features(self):
        """A single cell, and an edge one cell wide, are not covered by squares; wider ones are."""
        cells, open_cells = numpy.zeros((20, 20), numpy.uint8), numpy.ones((20, 20), bool)
        cells[3, 3] = 1
        cells[10:13, 5:9] = 1
        self.assertEqual(campaign.small_share(cells, open_cells) * 400, 1)
        cells[16, 2:7] = 1
        self.assertEqual(campaign.small_share(cells, open_cells) * 400, 6)

    def test_the_sky_is_fitted(self):
        scene = campaign.sky_scene(None)
        scene["detector"]["shape"] = [96, 96]
        with unittest.mock.patch.object(campaign, "sky_scene", lambda path: scene), contextlib.redirect_stdout(io.StringIO()):
            wrong = campaign.sky(types.SimpleNamespace(frames=10, seeds=1))
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
