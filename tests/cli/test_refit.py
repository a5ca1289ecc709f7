"""toliman refit: elements that are wrong by their errors agree with a series of measured separations afterwards."""
import json
import logging
import unittest

import numpy
from observed import DAY, EXPOSURE, SCALE, SECOND, START, SYSTEM, measured, mjd, toliman, write_orbit, write_series
from program import ProgramTest

LOW = ("--altitude", 600, "--exposure", EXPOSURE, "--time-scale", "tai")
PX = ("--plate-scale", SCALE)


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Refit(ProgramTest):
    @classmethod
    def setUpClass(cls):
        days = numpy.sort(numpy.random.default_rng(5).choice(1095 * 24, 120, replace=False)) / 24
        cls.tai_ns = START + (days * DAY).astype(numpy.int64)
        cls.truth = toliman.Sky(altitude_km=600)
        cls.arcsec = measured(cls.truth, cls.tai_ns)
        middle = EXPOSURE * SECOND // 2
        cls.exposures = [[t - middle, t + middle] for t in cls.tai_ns.tolist()]

    def setUp(self):
        super().setUp()
        self.wrong = json.loads(SYSTEM.read_text())
        random = numpy.random.default_rng(11)
        for name, (value, sigma) in self.truth.elements.items():
            self.wrong["orbit"][name] = value + sigma * (1 if random.uniform() < 0.5 else -1)
        (self.folder / "wrong.json").write_text(json.dumps(self.wrong))
        write_series(self.folder / "s.csv", mjd(self.tai_ns), self.arcsec / SCALE, 1e-6)

    def residuals(self, path):
        """Reduced separations in uas."""
        return toliman.Sky(path, altitude_km=600).reduce(self.exposures, self.arcsec).y * 1e6

    def test_wrong_elements_are_corrected(self):
        self.assertGreater(numpy.abs(self.residuals(self.folder / "wrong.json")).max(), 1000)
        found = json.loads(self.succeed("refit", "wrong.json", "s.csv", *LOW, *PX, "--out", "refit.json", "--json"))
        left = self.residuals(self.folder / "refit.json")
        self.assertLess(numpy.sqrt(numpy.mean(left**2)), 0.03)
        self.assertAlmostEqual(found["rms_uas"], numpy.sqrt(numpy.mean(left**2)), delta=1e-3)
        self.assertEqual((found["schema"], found["n"], found["unreduced"], found["out"], found["plate_scale_arcsec"]),
                         ("toliman-refit/1", 120, 0, "refit.json", SCALE))
        # as in Python
        sky, fit = toliman.Sky(self.folder / "wrong.json", altitude_km=600).refit(
            self.exposures, self.arcsec, 1e-6 * SCALE)
        saved = toliman.Sky(self.folder / "refit.json", altitude_km=600)
        for row in found["elements"]:
            value, sigma = sky.elements[row["name"]]
            self.assertAlmostEqual(row["after"], value, delta=1e-4 * max(sigma, 1e-9))
            self.assertEqual(saved.elements[row["name"]][0], row["after"])
            self.assertEqual(row["before"], self.wrong["orbit"][row["name"]])
            self.assertAlmostEqual(row["change_sigmas"] * row["sigma_before"], row["after"] - row["before"], delta=1e-12)
        errors = [row["sigma_after"] for row in found["elements"]]
        numpy.testing.assert_allclose(numpy.array(found["covariance"]) / numpy.outer(errors, errors),
                                      numpy.reshape(fit.covariance, (7, 7)) / numpy.outer(errors, errors), rtol=0, atol=1e-4)

    def test_table(self):
        (self.folder / "wrong.json").write_text(json.dumps({**self.wrong, "sigma": {"orbit": {"period_years": 0.019}}}))
        write_series(self.folder / "s.csv", mjd(self.tai_ns), self.arcsec, 1e-2)
        lines = self.succeed("refit", "wrong.json", "s.csv", *LOW, "--scale-sigma", 1e-3).splitlines()
        self.assertEqual(lines[:3], ["# system    wrong.json", "# observer  circular orbit, altitude 600 km, node at 18 h",
                                     "# samples   120, 0 left out"])
        self.assertEqual(lines[3].split(), ["element", "before", "after", "sigma", "change"])
        rows = {line.split()[0]: line.split()[1:] for line in lines[4:]}
        self.assertEqual(list(rows), [*toliman.Sky().elements, "residuals", "rms", "scale"])
        self.assertEqual(rows["eccentricity"][2:], ["-", "-"])
        self.assertEqual(rows["eccentricity"][0], rows["eccentricity"][1])
        before, after, _, change = map(float, rows["period_years"])
        self.assertAlmostEqual((after - before) / 0.019, change, delta=0.01)
        self.assertIn("good,", rows["residuals"])

    def noisy(self, size=1e-6):
        return self.arcsec + size * numpy.random.default_rng(2).normal(size=120)

    # promises: exit-codes-are-the-same, poor-orbits-are-not-written
    def test_late_times(self):
        """37 s: chi-square is 50, and no orbit is written."""
        write_series(self.folder / "s.csv", mjd(self.tai_ns + 37 * SECOND), self.noisy(), 1e-6)
        done = self.run_program("refit", "alpha-cen", "s.csv", *LOW, "--out", "refit.json", "--json")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("refit.json", done.stderr.splitlines()[-1])
        self.assertFalse((self.folder / "refit.json").exists())
        found = json.loads(done.stdout)
        self.assertEqual((found["goodness"], found["out"]), ("poor", None))
        self.assertGreater(found["chi_square"], 10)
        self.assertAlmostEqual(found["jitter_uas"]**2 / found["chi_square"], 1, delta=0.3)
        self.assertIn("warning: ", done.stderr)

    def test_noise_above_the_sigmas(self):
        """The errors are those of a fit with the right sigmas."""
        fits = []
        for sigma in 1e-6, 1e-6 / 1.5:
            write_series(self.folder / "s.csv", mjd(self.tai_ns), self.noisy(), sigma)
            done = self.run_program("refit", "alpha-cen", "s.csv", *LOW, "--out", "refit.json", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            fits.append(json.loads(done.stdout))
        self.assertEqual([(fit["goodness"], fit["out"], fit["outliers"]) for fit in fits],
                         [("good", "refit.json", 0), ("poor", "refit.json", 0)])
        self.assertEqual(fits[0]["jitter_uas"], 0)
        self.assertAlmostEqual(numpy.hypot(fits[1]["jitter_uas"], 1 / 1.5), fits[0]["chi_square"]**0.5, delta=0.02)
        for one, other in zip(fits[0]["elements"], fits[1]["elements"]):
            self.assertAlmostEqual(other["sigma_after"] / one["sigma_after"], 1, delta=0.1)
        self.assertAlmostEqual(fits[0]["chi_square"], 1, delta=0.4)
        self.assertAlmostEqual(fits[0]["chi_square_sigma"], (2 / 114) ** 0.5, delta=0.01)

    def test_sample_that_does_not_belong(self):
        arcsec = self.noisy()
        arcsec[17] += 2e-5
        write_series(self.folder / "s.csv", mjd(self.tai_ns), arcsec, 1e-6)
        done = self.run_program("refit", "alpha-cen", "s.csv", *LOW)
        self.assertRegex(done.stdout, "\noutliers    1\n")

    def test_a_wrong_plate_scale(self):
        """--scale-sigma fits it; without it, the elements would absorb it."""
        write_series(self.folder / "s.csv", mjd(self.tai_ns), self.arcsec / SCALE * 1.001, 1e-6)
        found = json.loads(self.succeed("refit", "alpha-cen", "s.csv", *LOW, *PX, "--scale-sigma", 0.01, "--json"))
        self.assertLess(abs(found["scale"] - 1e-3), 5 * found["scale_sigma"])
        self.assertLess(found["scale_sigma"], 0.01)

    # promise: uncovered-exposures-are-left-out
    def test_samples_without_a_state(self):
        write_orbit(self.folder / "low.csv", START, 120)
        tai_ns = START + (300 + 650 * numpy.arange(12)) * SECOND
        arcsec = numpy.full(12, 9.8)
        arcsec[:11] = measured(toliman.Sky(observer=self.folder / "low.csv"), tai_ns[:11])
        write_series(self.folder / "s.csv", mjd(tai_ns), arcsec, 1e-6)
        done = self.run_program("refit", "alpha-cen", "s.csv", "--observer", "low.csv", *LOW[2:], "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("warning: 1 of 12 ", done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual((found["n"], found["unreduced"], found["observer_file"]), (11, 1, "low.csv"))
        self.assertLess(found["rms_uas"], 0.01)

    def test_mistakes(self):
        write_series(self.folder / "plain.csv", mjd(self.tai_ns), self.arcsec, 1e-6, name="t")
        write_series(self.folder / "alone.csv", mjd(self.tai_ns), self.arcsec)
        (self.folder / "exact.json").write_text(json.dumps({**self.wrong, "sigma": {}}))
        (self.folder / "mine.txt").write_text("notes\n")
        self.refuse_all(
            (3, "plain.csv: ", "alpha-cen", "plain.csv", *LOW[:4]),
            (3, "alone.csv: ", "alpha-cen", "alone.csv", *LOW),
            (2, "--exposure", "alpha-cen", "s.csv", *LOW[:2], *PX),
            (2, "--plate-scale -0.375: ", "alpha-cen", "s.csv", *LOW, "--plate-scale", -SCALE),
            (2, "--scale-sigma 1: ", "alpha-cen", "s.csv", *LOW, "--scale-sigma", 1),
            (2, "", "exact.json", "s.csv", *LOW, *PX),
            (6, "mine.txt", "alpha-cen", "s.csv", *LOW, *PX, "--out", "mine.txt"),
            (3, "missing.csv: ", "alpha-cen", "missing.csv", *LOW), command=("refit",))
        done = self.run_program("refit", "alpha-cen", "s.csv", *LOW, "--plate-scale", 0.4)
        self.assertEqual((done.returncode, done.stdout, "--plate-scale" in done.stderr), (2, "", True), done.stderr)


if __name__ == "__main__":
    unittest.main()
