"""The short form of sky_campaign.py: five missions of a small telescope. And what compare.py and the limits are made of."""
import json
import math
import pathlib
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tools" / "studies"), str(ROOT / "examples" / "sky")]
import package  # noqa: E402, F401
import campaign  # noqa: E402
import compare  # noqa: E402
import mission  # noqa: E402
import sky_campaign  # noqa: E402
from test_observer import SCENE as OBSERVED  # noqa: E402

# The telescope of test_observer, with finer cells and electrons.
SCENE = {**OBSERVED, "telescope": {**OBSERVED["telescope"], "pupil_samples": 64}, "noise": {"photon": True},
         "stars": {name: {"spectrum": star["spectrum"], "detected_per_s": star["photons_per_s"]}
                   for name, star in OBSERVED["stars"].items()}}


class Missions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        campaign.quiet()
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        scene = cls.folder / "telescope.json"
        scene.write_text(json.dumps(SCENE))
        sky_campaign.INJECTED = 3
        cls.sizes = {"frames": 100, "photons": 5e11, "side": 0, "scene": scene}

    # promise: missions-are-found-by-defaults
    def test_missions(self):
        """Without a planet and with one: nothing is wrong, and the planet is found."""
        for seed, planets in ((0, 0), (13, 1)):
            with self.subTest(seed=seed):
                row, pulls, limits, wrong = sky_campaign.of_seed((seed, self.sizes))
                self.assertEqual((wrong, limits[1]), ([], 0 if planets else 3), row)
                self.assertEqual(len(pulls), planets, row)

    def test_the_truth(self):
        """The reflex of an Earth at 1 au of the Sun at 1.34 pc is 0.75 arcsec/au x 3e-6 au; a Kepler orbit has its amplitude."""
        earth = {"period_days": 365.25, "amplitude_uas": 750 * 3.0034896e-6 * 1e3}
        self.assertAlmostEqual(compare.mass_earth(earth, 1, 750), 1, places=6)
        planet, days = {"period_days": 100, "amplitude_uas": 2, "eccentricity": 0.3}, numpy.linspace(0, 100, 100001)
        x = mission.displacement_uas(planet, 0, days)
        self.assertAlmostEqual(numpy.ptp(x), 4, places=6)
        self.assertAlmostEqual(x[:-1].mean(), -1.5 * 0.3 * 2, places=6)

    def test_the_craft(self):
        """Velocities are the derivatives of the places, and the stars are above the limb in all arcs."""
        craft, start, step = mission.Craft(1), mission.tai_ns(mission.START), 10**8
        before, after = (craft.states(start + sign * step)[0] for sign in (-1, 1))
        numpy.testing.assert_allclose(craft.states(start)[1], (after - before) / 0.2, rtol=0, atol=0.2)
        arcs = mission.arcs(craft, [start], json.loads(mission.SYSTEM.read_text()), 1)
        total = sum(end - begin for begin, end in arcs) / 1e9
        self.assertTrue(15000 < total < 50000 and 8 < len(arcs) < 16, (total, len(arcs)))


if __name__ == "__main__":
    unittest.main()
