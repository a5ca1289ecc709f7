"""toliman refit SYSTEM STATE with day-long sums in a low orbit: lists of on-target intervals; and what an orbit that was
refitted to frames is not used for."""
import json
import logging
import unittest

import numpy
from observed import DAY, SCALE, SECOND, START, SYSTEM, toliman
from program import ProgramTest

FRAMES, SIGMA = 60, 6e-6  # px: 2.2 uas
ORBIT = 5801 * SECOND  # about that of 600 km
ARCS = [[start, start + 1800 * SECOND] for start in range(0, DAY - 1800 * SECOND, 2 * ORBIT)]
LOW = ("--altitude", 600)


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class RefitSums(ProgramTest):
    def make(self, seed, name="s", days=1095, first=0):
        """A folder whose stars move on an orbit that differs from alpha-cen by its errors; returns the elements."""
        random = numpy.random.default_rng(seed)
        true = json.loads(SYSTEM.read_text())
        nominal = toliman.Sky(altitude_km=600)
        for element, (value, sigma) in nominal.elements.items():
            true["orbit"][element] = value + sigma * random.normal()
        (self.folder / "true.json").write_text(json.dumps(true))
        truth = toliman.Sky(self.folder / "true.json", altitude_km=600)
        self.starts = START + DAY * (first + numpy.sort(random.choice(days, FRAMES, replace=False)))
        self.exposures = [[[int(start + a), int(start + b)] for a, b in ARCS] for start in self.starts]
        seen = truth.predict_exposures(self.exposures)["separation_arcsec"] / SCALE
        self.separations = seen + SIGMA * random.normal(size=FRAMES)

        def estimate(image):
            number = int(image[0, 0])
            return toliman.Estimate(self.separations[number] - 26, further=[self.separations[number]])
        with toliman.Tracker(estimate, 1e-3, 1e-4, 60, folder=self.folder / name, estimator_id=1, sigma=SIGMA, rows=8, cols=8,
                             image_shape=(8, 8), values=["separation_px"], sync="none", allow_zero_runs=True, sky=nominal,
                             plate_scale_arcsec=SCALE, exposure_s=86400) as tracker:
            seconds = [[a / SECOND, b / SECOND] for a, b in ARCS]
            for number, start in enumerate(self.starts):
                frame = toliman.Frame(numpy.full((8, 8), number, numpy.uint16), frame_id=number,
                                      camera_ns=int(start + DAY // 2), exposure_s=86400, intervals=seconds)
                self.assertEqual(tracker.push(frame).verdict, "accepted")
            tracker.save()
        return true["orbit"]

    def test_elements_are_those_of_python_and_of_the_stars(self):
        distances = []
        for seed in range(3):
            with self.subTest(seed):
                true = self.make(seed, f"s{seed}")
                found = json.loads(self.succeed("refit", "alpha-cen", f"s{seed}", *LOW, "--json"))
                self.assertEqual((found["n"], found["unreduced"], found["goodness"]), (FRAMES, 0, "good"))
                expected, _ = toliman.Sky(altitude_km=600).refit(self.exposures, self.separations * SCALE,
                                                                 numpy.full(FRAMES, SIGMA * SCALE))
                for row in found["elements"]:
                    value, sigma = expected.elements[row["name"]]
                    self.assertAlmostEqual(row["after"], value, delta=1e-6 * sigma)
                    self.assertAlmostEqual(row["sigma_after"], sigma, delta=1e-6 * sigma)
                    self.assertLess(abs(value - true[row["name"]]), 3 * sigma)
                covariance = numpy.array(found["covariance"])
                error = [row["after"] - true[row["name"]] for row in found["elements"]]
                distances.append(error @ numpy.linalg.solve(covariance, error))
        self.assertLess(sum(distances), 45)  # chi-square of 21 degrees of freedom: once in 500

    def test_a_series_with_windows(self):
        """The numbers of the folder of the same sums; a window ends in the next exposure."""
        self.make(0)
        windows = [[a, b] for exposure in self.exposures for a, b in exposure]
        self.write_windows(windows)
        self.write_series(0.5)
        command = ("refit", "alpha-cen", "series.csv", *self.how, "--exposure", 86400)
        found = json.loads(self.succeed(*command, "--on-target", "windows.csv", "--json"))
        of_folder = json.loads(self.succeed("refit", "alpha-cen", "s", *LOW, "--json"))
        for one, other in zip(found["elements"], of_folder["elements"]):
            self.assertAlmostEqual(one["after"], other["after"], delta=1e-3 * other["sigma_after"])
        for name in "period", "planet":
            self.succeed(name, "series.csv", "--system", "alpha-cen", *self.how, "--exposure", 86400, "--on-target", "windows.csv")
        self.refuse(2, "--exposure 86400", "--on-target", arguments=command)
        self.refuse(2, "--on-target", arguments=("refit", "alpha-cen", "s", *LOW, "--on-target", "windows.csv"))
        self.write_windows(windows[len(ARCS):])
        self.refuse(3, "series.csv: sample 1: ", arguments=(*command, "--on-target", "windows.csv"))

    how = (*LOW, "--plate-scale", SCALE, "--time-scale", "tai")

    def write_windows(self, windows):
        iso = lambda ns: str(numpy.datetime64(int(ns), "ns"))
        (self.folder / "windows.csv").write_text("start_tai,end_tai\n" + "".join(f"{iso(a)},{iso(b)}\n" for a, b in windows))

    def write_series(self, middle):
        """middle: of an exposure, in days from its start."""
        (self.folder / "series.csv").write_text("mjd,y,sigma\n" + "".join(
            f"{start / DAY + 40587 + middle!r},{y!r},{SIGMA!r}\n"
            for start, y in zip(self.starts.tolist(), self.separations.tolist())))

    # promise: refitted-orbits-are-not-searched
    def test_frames_of_a_refit_are_not_searched(self):
        self.make(0)
        self.succeed("refit", "alpha-cen", "s", *LOW, "--out", "refit.json")
        dates = json.loads((self.folder / "refit.json").read_text())["refit"]
        years = (self.starts / DAY + 40587 - 51544.5) / 365.25 + 2000
        numpy.testing.assert_allclose([dates["first"], dates["last"]], years[[0, -1]], rtol=0, atol=1e-5)
        done = self.run_program("rebuild", "s", *LOW, "--system", "refit.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("warning: s: ", done.stderr)
        for arguments in (("planet", "s"), ("refit", "refit.json", "s", *LOW)):
            with self.subTest(arguments):
                self.refuse(2, "refit", arguments=arguments)
        with self.assertRaisesRegex(toliman.InputError, "refit") as caught:
            toliman.planets(toliman.Measurements(self.folder / "s"))
        self.assertEqual(caught.exception.field, "series")
        self.succeed("rebuild", "s", *LOW, "--system", "alpha-cen")
        self.succeed("planet", "s")
        # later frames have not been used
        later = self.folder / "later"
        self.make(0, "later", first=1100)
        self.succeed("rebuild", later, *LOW, "--system", "refit.json")
        self.succeed("planet", later, "--period-max", 800)

    def test_series_of_a_refit(self):
        self.make(1)
        sky = toliman.Sky(altitude_km=600)
        given = (self.exposures, self.separations * SCALE, numpy.full(FRAMES, SIGMA * SCALE))
        better, _ = sky.refit(*given)
        self.assertEqual([bool(one.reduce(*given).info.is_refitted) for one in (sky, better)], [False, True])
        self.write_series(0.01)
        better.save(self.folder / "refit.json")
        for command in "period", "planet":
            self.refuse(2, "refit.json",
                        arguments=(command, "series.csv", "--system", "refit.json", *self.how, "--exposure", 60))


if __name__ == "__main__":
    unittest.main()
