"""toliman refit SYSTEM STATE_FOLDER: the separations that track measured correct the orbit, to which rebuild then reduces."""
import copy
import json
import logging
import unittest

import numpy
from astropy.io import fits
from observed import SECOND, SYSTEM, toliman, write_orbit
from program import ProgramTest
from test_track_reduced import GRID, HOURS, SCALE, SCENE

FRAMES = len(SCENE["cadence"]["times_days"])


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class RefitState(ProgramTest):
    """A spacecraft whose predicted orbit is 1 s late and covers 13 of 24 frames; elements that are wrong by their errors."""

    def setUp(self):
        super().setUp()
        self.zero = toliman.parse_time("2461406.75", "jd", "tt")
        write_orbit(self.folder / "definitive.csv", self.zero, 60 * HOURS)
        write_orbit(self.folder / "predicted.csv", self.zero + SECOND, 60 * HOURS // 2)
        self.write_scene("scene.json", {"file": "definitive.csv"})
        self.write_scene("model.json", "none")
        wrong = json.loads(SYSTEM.read_text())
        random = numpy.random.default_rng(11)
        for name, (value, sigma) in toliman.Sky().elements.items():
            wrong["orbit"][name] = value + sigma * (1 if random.uniform() < 0.5 else -1)
        (self.folder / "wrong.json").write_text(json.dumps(wrong))

    def write_scene(self, name, observer, **cadence):
        scene = copy.deepcopy(SCENE)
        scene["binary"]["observer"] = observer
        scene["cadence"].update(cadence)
        for star in scene["stars"].values():
            star["photons_per_s"] *= 8
        (self.folder / name).write_text(json.dumps(scene))

    def track(self, state, *more):
        if not (self.folder / "in").exists():
            self.succeed("simulate", "scene.json", "--out", "in", "--session", "s", "--dtype", "u32le")
        done = self.run_program("track", "--fit", "model.json", "--state", state, "--dtype", "u32le", *GRID,
                                "--epoch", self.zero, *more, "in")
        self.assertEqual(done.returncode, 0, done.stderr)

    def largest(self, state):
        """Largest value, uas."""
        lines = map(json.loads, self.succeed("status", state, "--records").splitlines())
        return max(abs(line["value"]) for line in lines if line["verdict"] == "accepted") * SCALE * 1e6

    def check(self, elements):
        """Against Sky.refit, with the separations that the rebuilt folder lists."""
        records = [json.loads(line) for line in self.succeed("status", "s", "--records").splitlines()]
        half = 30 * SECOND
        wrong = toliman.Sky(self.folder / "wrong.json", self.folder / "definitive.csv")
        expected, _ = wrong.refit([[one["tai_ns"] - half, one["tai_ns"] + half] for one in records],
                                  [one["reduction"]["separation_px"] * SCALE for one in records],
                                  [one["sigma"] * SCALE for one in records])
        for row in elements:
            value, sigma = expected.elements[row["name"]]
            self.assertAlmostEqual(row["after"], value, delta=1e-6 * max(sigma, 1e-9))
            self.assertAlmostEqual(row["sigma_after"], sigma, delta=1e-6 * sigma)

    # promise: rebuild-gives-first-bits
    def test_track_refit_rebuild(self):
        self.track("s", "--system", "wrong.json", "--observer", "predicted.csv")
        self.assertGreater(self.largest("s"), 1000)
        observer = ("--observer", "definitive.csv")
        found = json.loads(self.succeed("refit", "wrong.json", "s", *observer, "--out", "refit.json", "--json"))
        self.assertEqual((found["n"], found["unreduced"], found["plate_scale_arcsec"], found["exposure_s"]),
                         (FRAMES, 0, SCALE, None))
        self.assertLess(found["rms_uas"], 5)  # sigma is 75 uas
        self.succeed("rebuild", "s", *observer, "--system", "refit.json")
        self.assertLess(self.largest("s"), 10)
        self.check(found["elements"])
        # the frames that the observer file covers
        done = self.run_program("refit", "wrong.json", "s", "--observer", "predicted.csv", "--json")
        self.assertIn(f"warning: 11 of {FRAMES} ", done.stderr)
        self.assertEqual(json.loads(done.stdout)["n"], 13)

    def test_a_folder_without_a_system(self):
        self.track("plain")
        command = ("refit", "wrong.json", "plain", "--observer", "definitive.csv")
        self.refuse(2, "plain: ", "--plate-scale", arguments=command)
        found = json.loads(self.succeed(*command, "--plate-scale", SCALE, "--json"))
        self.assertEqual((found["n"], found["plate_scale_arcsec"]), (FRAMES, SCALE))
        self.assertLess(found["rms_uas"], 5)

    def test_exposures_of_the_folder(self):
        """Of frames that state none."""
        self.succeed("simulate", "scene.json", "--out", "two.fits", "--frames", "0:2")
        fits.delval(self.folder / "two.fits", "XPOSURE")
        done = self.run_program("track", "--fit", "model.json", "--state", "s", *GRID, "--epoch", self.zero, "--system",
                                "wrong.json", "--observer", "definitive.csv", "--exposure", "60", "two.fits")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(self.succeed("refit", "wrong.json", "s", "--observer", "definitive.csv", "--json"))
        self.assertEqual(found["n"], 2)

    def test_lists_of_intervals(self):
        """The mean over the intervals of the side file, in which the stars of the scene moved."""
        self.write_scene("scene.json", {"file": "definitive.csv"}, on_target_s=[0, 30, 40, 60])
        self.track("s", "--system", "wrong.json", "--observer", "definitive.csv")
        found = json.loads(self.succeed("refit", "wrong.json", "s", "--observer", "definitive.csv", "--json"))
        self.assertEqual((found["n"], found["unreduced"]), (FRAMES, 0))
        self.assertLess(found["rms_uas"], 3)  # the noise of a frame is 2

    def test_mistakes(self):
        self.track("s", "--system", "alpha-cen", "--observer", "definitive.csv")
        command = ("refit", "alpha-cen", "s", "--observer", "definitive.csv")
        for option in (("--exposure", "60"), ("--columns", "t,y,sigma"), ("--time-scale", "tai"), ("--time-format", "mjd")):
            self.refuse(2, f"{' '.join(option)}: ", arguments=(*command, *option))
        (self.folder / "empty").mkdir()
        self.refuse(3, "empty", arguments=("refit", "alpha-cen", "empty", "--observer", "definitive.csv"))


if __name__ == "__main__":
    unittest.main()
