"""State folders of a mission of three years whose reference orbit is wrong by its errors: status, rebuild and report with
the errors of the orbit, a trend, or the mean alone. The frames are written by the Python package."""
import json
import logging
import math
import pathlib
import shutil
import tempfile
import unittest

import numpy
from observed import DAY, SCALE, SECOND, START, SYSTEM, measured, toliman
from program import ProgramTest

PERIOD, AMPLITUDE, SIGMA = 226.0, 1.2, 1e-6  # days, uas, px
FRAMES, MISSION = 836, 1095.0
GRID = (1.5 / MISSION, 0.1 / MISSION, 500)


def wrong_orbit(seed):
    """A Sky whose elements differ from those of the catalogue by draws of their errors."""
    system, random = json.loads(SYSTEM.read_text()), numpy.random.default_rng(seed)
    for name, sigma in system["sigma"]["orbit"].items():
        system["orbit"][name] += sigma * random.normal()
    return toliman.Sky(json.dumps(system), altitude_km=600)


def write_mission(folder, seed, planet_uas, correlation=0.0, frames=FRAMES, **options):
    random = numpy.random.default_rng(seed)
    days = numpy.sort(random.choice(int(MISSION), frames, replace=False))
    times = START + (days * DAY + random.integers(0, 3600, frames) * SECOND)
    planet = planet_uas * numpy.sin(2 * math.pi * (times - START) / DAY / PERIOD + 1)
    noise = SIGMA * random.normal(size=frames)
    for k in range(1, frames):
        noise[k] = correlation * noise[k - 1] + math.sqrt(1 - correlation**2) * noise[k]
    separations = measured(wrong_orbit(seed + 1), times, planet) / SCALE + noise

    def estimate(image):
        return toliman.Estimate(separations[int(image[0, 0])] - separations[0], [separations[int(image[0, 0])]])

    sky = toliman.Sky("alpha-cen", altitude_km=600)
    with toliman.Tracker(estimate, *GRID, folder=folder, sigma=SIGMA, estimator_id=5, values=["separation_px"], rows=4,
                         cols=4, image_shape=(4, 4), allow_zero_runs=True, time_offset_ns=START, sync="none", sky=sky,
                         plate_scale_arcsec=SCALE, double_limb=True, **options) as tracker:
        outcomes = tracker.push_many(toliman.Frame(numpy.full((4, 4), float(k)), frame_id=k, camera_ns=int(times[k]),
                                                   exposure_s=60) for k in range(frames))
        assert all(outcome.verdict == "accepted" for outcome in outcomes)
        tracker.save()


class Mission(ProgramTest):
    @classmethod
    def setUpClass(cls):
        logging.getLogger("toliman").setLevel(logging.ERROR)
        cls.made = tempfile.TemporaryDirectory()
        for name, planet in (("planet", AMPLITUDE), ("none", 0)):
            write_mission(pathlib.Path(cls.made.name) / name, 11, planet)

    @classmethod
    def tearDownClass(cls):
        cls.made.cleanup()

    def setUp(self):
        super().setUp()
        for name in ("planet", "none"):
            shutil.copytree(pathlib.Path(self.made.name) / name, self.folder / name)

    def status(self, state):
        return json.loads(self.succeed("status", state, "--json"))

    def test_errors_of_the_orbit_are_fitted(self):
        found = self.status("planet")
        self.assertAlmostEqual(found["fit"]["period"], PERIOD, delta=4 * found["fit"]["period_error"])
        self.assertAlmostEqual(found["fit"]["amplitude"] * SCALE * 1e6, AMPLITUDE, delta=0.15)
        self.assertLess(found["log10_fap"], -20)
        self.assertFalse(found["long_period"] or found["annual"])
        self.assertGreater(self.status("none")["log10_fap"], -3)
        functions = found["functions"]
        self.assertEqual((functions["in_use"], functions["free"]), (8, 1))
        truth, catalogue = wrong_orbit(12).elements, toliman.Sky("alpha-cen", altitude_km=600).elements
        for one in functions["coefficients"][1:]:
            error = truth[one["name"]][0] - catalogue[one["name"]][0]
            self.assertAlmostEqual(one["prior_sigma"], catalogue[one["name"]][1], delta=1e-12)
            self.assertAlmostEqual(one["value"], error, delta=4.5 * catalogue[one["name"]][1])
        text = self.succeed("status", "planet")
        self.assertIn("  functions   8 in use, 1 free\n", text)
        self.assertIn("    eccentricity ", text)

    def test_results_for_a_report(self):
        """series.csv has the orbit's error as it was fitted; without it and the sinusoid, noise is left."""
        status = self.status("planet")
        self.assertGreater(status["log10_p_white"], -3)
        self.succeed("status", "planet", "--out", "results")
        lines = (self.folder / "results" / "series.csv").read_text().splitlines()
        self.assertEqual([line for line in lines if line[0] != "#"][0], "t,y,sigma,nuisance")
        t, y, _, nuisance = numpy.loadtxt(lines, delimiter=",", skiprows=lines.index("t,y,sigma,nuisance") + 1).T
        fit = status["fit"]
        rest = y - nuisance - fit["amplitude"] * numpy.sin(2 * math.pi * t / fit["period"] + fit["phase"])
        self.assertGreater(y.std(), 10 * SIGMA)
        self.assertAlmostEqual(rest.std() / SIGMA, 1, delta=0.1)
        power, left = (numpy.loadtxt(self.folder / "results" / name, delimiter=",", skiprows=2)[:, 1]
                       for name in ("periodogram.csv", "residual_periodogram.csv"))
        level = json.loads((self.folder / "results" / "result.json").read_text())["power_at_fap_1e-3"]
        self.assertGreater(power.max(), 5 * level)
        self.assertLess(left.max(), level)
        page = (self.folder / self.succeed("report", "results", "--out", "page").strip()).read_text()
        for figure in ("nuisance", "residual-periodogram"):
            self.assertIn(figure, page)

    def test_correlated_values(self):
        write_mission(self.folder / "red", 3, 0, correlation=0.7, frames=300)
        self.assertLess(self.status("red")["log10_p_white"], -10)
        self.assertIn("log10 p = ", self.succeed("status", "red"))

    def test_other_functions(self):
        """The mean alone makes a false alarm; a trend of order 5 makes none, and rebuild restores the first bits."""
        before = (self.folder / "none" / "checkpoint.tlmc").read_bytes()
        self.succeed("rebuild", "none", "--trend", 0)
        alone = self.status("none")
        self.assertLess(alone["log10_fap"], -10)
        self.assertIsNone(alone["functions"])
        self.assertTrue(alone["long_period"])
        self.assertIn("long period", self.succeed("status", "none"))
        sky = ("--system", "alpha-cen", "--altitude", 600)
        self.succeed("rebuild", "none", *sky)
        self.assertEqual((self.folder / "none" / "checkpoint.tlmc").read_bytes()[40:-4], before[40:-4])
        self.succeed("rebuild", "none", "--trend", 5)
        trend = self.status("none")
        self.assertGreater(trend["log10_fap"], -3)
        self.assertEqual([one["name"] for one in trend["functions"]["coefficients"]], ["mean"] + [f"T{k}" for k in range(1, 6)])
        self.refuse(2, "--trend", arguments=("rebuild", "none", "--trend", 9))
        self.succeed("rebuild", "none", "--system", "alpha-cen", "--altitude", 600, "--trend", 5)
        self.assertEqual(self.status("none")["functions"]["in_use"], 6)
        how = toliman.Tracker.open(self.folder / "none").options
        self.assertEqual((how["trend"], how["trend_end"]), (5, 1.5 * MISSION))

    def test_plate_scale_error(self):
        self.succeed("rebuild", "none", "--system", "alpha-cen", "--altitude", 600, "--scale-sigma", 1e-3)
        axis, = [one for one in self.status("none")["functions"]["coefficients"] if one["name"] == "semi_major_arcsec"]
        self.assertAlmostEqual(axis["prior_sigma"], math.hypot(0.0096, 17.4930e-3), delta=1e-9)
        self.refuse(2, "--observer FILE", arguments=("rebuild", "none", "--scale-sigma", 1e-4))


if __name__ == "__main__":
    unittest.main()
