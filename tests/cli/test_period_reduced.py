"""toliman period --system: separations as a spacecraft measures them are reduced to the orbit, and show a planet of 1.2 uas."""
import json
import logging
import unittest

import numpy
from observed import DAY, EXPOSURE, SCALE, SECOND, START, SYSTEM, measured, mjd, toliman, write_orbit, write_series
from program import ProgramTest, leap_seconds

LOW = ("--system", "alpha-cen", "--altitude", 600)
TAI = ("--time-scale", "tai")
PX = ("--plate-scale", SCALE)
SHORT = ("--exposure", EXPOSURE)
GRID = ("--f0", 1 / 800, "--df", 1e-4, "--nf", 100)


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Reduced(ProgramTest):
    def period(self, *arguments):
        return json.loads(self.succeed("period", "s.csv", "--json", *arguments))

    def mission(self):
        """200 of 1095 days; the times and what a planet of 1.2 uas with a period of 350 d changes."""
        days = numpy.sort(numpy.random.default_rng(3).choice(1095, 200, replace=False)) + 0.25
        tai_ns = START + (days * DAY).astype(numpy.int64)
        return tai_ns, 1.2 * numpy.sin(2 * numpy.pi * days / 350 + 0.4)

    def test_a_planet(self):
        tai_ns, planet = self.mission()
        px = measured(toliman.Sky(altitude_km=600), tai_ns, planet) / SCALE
        write_series(self.folder / "s.csv", mjd(tai_ns), px)
        found = self.period(*LOW, *PX, *SHORT, *TAI)
        peak = found["peak"]
        self.assertAlmostEqual(peak["amplitude"] * SCALE * 1e6, 1.2, delta=0.03)
        self.assertAlmostEqual(peak["period"], 350, delta=1)
        self.assertEqual(found["n"], 200)
        self.assertEqual(found["reduction"], {
            "system": "alpha-cen", "observer": "circular orbit", "observer_file": None, "altitude_km": 600, "node_hours": 18,
            "plate_scale_arcsec": SCALE, "exposure_s": EXPOSURE, "unreduced": 0, "diagnosis": None})
        text = self.succeed("period", "s.csv", *LOW, *PX, *SHORT, *TAI)
        self.assertRegex(text, r"\nreduced     alpha-cen .* 600 km, .* 18 h; 0 ")
        # the velocity of the spacecraft, 205 to 257 uas, is not left out
        done = self.run_program("period", "s.csv", "--json", "--system", "alpha-cen", *PX, *SHORT, *TAI)
        self.assertIn("warning: ", done.stderr)
        self.assertEqual(json.loads(done.stdout)["reduction"]["observer"], "Earth")
        self.assertGreater(json.loads(done.stdout)["peak"]["amplitude"] * SCALE * 1e6, 10)

    def test_times_and_units(self):
        """Dates of UTC, MJD of TAI and JD of TT; px and arcsec."""
        tai_ns = START + (numpy.arange(30) + numpy.random.default_rng(1).uniform(0, 1, 30)) * 20 * DAY
        tai_ns = (tai_ns // SECOND).astype(numpy.int64) * SECOND
        arcsec = measured(toliman.Sky(altitude_km=600), tai_ns, numpy.linspace(-9, 9, 30))
        utc = numpy.datetime_as_string((tai_ns - 37 * SECOND).view("M8[ns]"), unit="s").tolist()
        offsets, periods = [], []
        for name, times, scale, sigma in (("t", utc, "utc", None), ("mjd", mjd(tai_ns), "tai", 1e-6),
                                          ("jd", mjd(tai_ns + 32184 * 10**6) + 2400000.5, "tt", 1e-6)):
            write_series(self.folder / "s.csv", times, arcsec, sigma, name)
            found = self.period(*LOW, *SHORT, *GRID, "--time-scale", scale, "--trend", 0)
            offsets.append(found["peak"]["offset"] * 1e6)
            periods.append(found["peak"]["period"])
        write_series(self.folder / "s.csv", utc, arcsec / SCALE, name="t")
        found = self.period(*LOW, *SHORT, *GRID, *PX, "--trend", 0)
        offsets.append(found["peak"]["offset"] * SCALE * 1e6)
        self.assertLess(abs(offsets[0]), 50)
        numpy.testing.assert_allclose(offsets, offsets[0], rtol=0, atol=1e-3)  # of 40 us in a JD: 1e-5 uas
        numpy.testing.assert_allclose(periods, periods[0], rtol=1e-3)

    def test_leap_seconds(self):
        """--leap-seconds is for the times of the series as well: 26 s are 7 uas."""
        first = round(mjd(START)) - 30
        (self.folder / "new.list").write_text(leap_seconds(*range(first, first + 26)))
        tai_ns = START + numpy.arange(12) * 20 * DAY
        arcsec = measured(toliman.Sky(altitude_km=600), tai_ns + 63 * SECOND)
        write_series(self.folder / "s.csv", numpy.datetime_as_string(tai_ns.view("M8[ns]"), unit="s").tolist(), arcsec,
                     name="t")
        for more, least, most in (((), 1, 50), (("--leap-seconds", "new.list"), 0, 0.01)):
            amplitude = self.period(*LOW, *SHORT, *GRID, *more)["peak"]["amplitude"] * 1e6
            self.assertTrue(least <= amplitude <= most, amplitude)
        offsets = [self.period(*GRID, *more)["peak"]["time_offset"] for more in ((), ("--leap-seconds", "new.list"))]
        self.assertAlmostEqual((offsets[1] - offsets[0]) * 86400, 26, delta=1e-4)  # also without a system

    # promise: uncovered-exposures-are-left-out
    def test_samples_without_a_state(self):
        """They are left out; the others are reduced by the states of the file."""
        write_orbit(self.folder / "low.csv", START, 120)
        observer = ("--system", "alpha-cen", "--observer", "low.csv")
        tai_ns = START + (300 + 500 * numpy.arange(16)) * SECOND
        inside = tai_ns < START + (119 * 60 - 30) * SECOND
        arcsec = numpy.full(16, 9.8)
        arcsec[inside] = measured(toliman.Sky(observer=self.folder / "low.csv"), tai_ns[inside])
        write_series(self.folder / "s.csv", mjd(tai_ns), arcsec)
        grid = ("--f0", 10, "--df", 1, "--nf", 100)
        done = self.run_program("period", "s.csv", *observer, *SHORT, *TAI, *grid, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, rf"warning: {16 - inside.sum()} of 16 .* low.csv .* 2027-01-01T00:00:00 to 2027-01-01T01:59:00 TAI")
        found = json.loads(done.stdout)
        self.assertEqual((found["n"], found["reduction"]["unreduced"]), (inside.sum(), 16 - inside.sum()))
        self.assertLess(found["peak"]["amplitude"] * 1e6, 0.01)
        write_series(self.folder / "s.csv", mjd(tai_ns[~inside] + DAY), arcsec[~inside])
        self.refuse(3, "s.csv: ", "low.csv", arguments=("period", "s.csv", *observer, *SHORT, *TAI, *grid))

    def test_mistakes(self):
        tai_ns = START + numpy.arange(8) * 30 * DAY
        write_series(self.folder / "s.csv", mjd(tai_ns), numpy.full(8, 9.8))
        write_series(self.folder / "plain.csv", mjd(tai_ns), numpy.full(8, 9.8), name="t")
        write_series(self.folder / "negative.csv", mjd(tai_ns), numpy.full(8, -0.1))
        self.refuse_all(
            (3, "plain.csv: ", "plain.csv", *LOW, *SHORT), (2, "--exposure", "s.csv", *LOW),
            *((2, f"--exposure {value}: ", "s.csv", *LOW, "--exposure", value) for value in (601, -5)),
            *((2, f"--plate-scale {value}: ", "s.csv", *LOW, *SHORT, "--plate-scale", value) for value in (-1, "inf")),
            (2, "--altitude 100: ", "s.csv", *LOW[:3], 100),
            (3, "negative.csv: sample 1: y = -0.1: ", "negative.csv", *LOW, *SHORT),
            (3, "missing.json: ", "s.csv", "--system", "missing.json", "--altitude", 600),
            (2, 'system = "": ', "s.csv", "--system", "", *LOW[2:], *SHORT), (2, "--plate-scale ", "s.csv", *PX),
            (2, "--altitude ", "s.csv", "--altitude", 600), (2, "--follow ", "s.csv", *LOW, *SHORT, "--follow"),
            (2, "--from-state ", "s.csv", *LOW, *SHORT, "--from-state", "s.tlmp"), command=("period",))
        for scale, words in ((0.4, ("s.csv: ", " 0.3974 ")), (0.8, (" 7.84 arcsec", "--plate-scale"))):
            done = self.run_program("period", "s.csv", *LOW, *SHORT, "--plate-scale", scale, *GRID)
            self.assertEqual([word in done.stderr for word in words], [True] * 2, done.stderr)


class OrbitFunctions(ProgramTest):
    """What is fitted with the mean of a reduced series: by default the errors of the orbit."""

    NAMES = ["period_years", "semi_major_arcsec", "eccentricity", "inclination_deg", "node_deg", "periastron_deg", "epoch"]
    WRONG = (*LOW[:1], "wrong.json", *LOW[2:], *SHORT, *TAI)
    SIGMA = 0.5625e-6  # arcsec

    @classmethod
    def setUpClass(cls):
        """A planet of 1.2 uas with a period of 250 d, and elements that are one standard deviation wrong."""
        random = numpy.random.default_rng(3)
        days = numpy.sort(random.choice(1095, 209, replace=False)) + 0.25
        cls.tai_ns = START + (days * DAY).astype(numpy.int64)
        cls.arcsec = measured(toliman.Sky(altitude_km=600), cls.tai_ns, 1.2 * numpy.sin(2 * numpy.pi * days / 250 + 0.4))
        cls.arcsec += cls.SIGMA * random.normal(size=209)
        cls.system = json.loads(SYSTEM.read_text())
        cls.errors = {name: sign * cls.system["sigma"]["orbit"][name] for name, sign in zip(cls.NAMES, (1, 1, -1, 1, 1, -1, 1))}

    def setUp(self):
        super().setUp()
        orbit = {**self.system["orbit"], **{name: self.system["orbit"][name] + self.errors[name] for name in self.NAMES}}
        self.wrong = {**self.system, "orbit": orbit}
        (self.folder / "wrong.json").write_text(json.dumps(self.wrong))
        write_series(self.folder / "s.csv", mjd(self.tai_ns), self.arcsec / SCALE, self.SIGMA / SCALE)
        write_series(self.folder / "plain.csv", mjd(self.tai_ns), self.arcsec / SCALE)

    def period(self, *arguments, warning=""):
        done = self.run_program("period", *arguments, *self.WRONG, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.assertIn if warning else self.assertEqual)(warning, done.stderr)
        return json.loads(done.stdout)

    def test_a_planet_is_found(self):
        alone = self.period("s.csv", *PX, *GRID, "--trend", 0, warning="--trend")
        self.assertLess(alone["peak"]["log10_fap"], -3)  # a false alarm, of the orbit
        self.assertGreater(abs(alone["peak"]["period"] - 250), 100)
        found = self.period("s.csv", *PX, *GRID)
        self.assertAlmostEqual(found["peak"]["period"], 250, delta=6)
        self.assertAlmostEqual(found["peak"]["amplitude"] * SCALE * 1e6, 1.2, delta=0.25)
        self.assertLess(found["peak"]["log10_fap"], -20)
        functions = found["functions"]
        self.assertEqual((functions["in_use"], functions["free"]), (8, 1))
        mean, *elements = functions["coefficients"]
        self.assertEqual([one["name"] for one in elements], self.NAMES)
        for one in elements:
            prior = self.system["sigma"]["orbit"][one["name"]]
            self.assertAlmostEqual(one["prior_sigma"], prior, delta=1e-12)
            self.assertLess(abs(one["value"] + self.errors[one["name"]]), 3 * prior)
        # In arcsec, the same errors of the elements.
        write_series(self.folder / "arcsec.csv", mjd(self.tai_ns), self.arcsec, self.SIGMA)
        again = self.period("arcsec.csv", *GRID)["functions"]["coefficients"][1:]
        numpy.testing.assert_allclose([one["value"] for one in again], [one["value"] for one in elements], rtol=1e-3)
        text = self.succeed("period", "s.csv", *PX, *GRID, *self.WRONG)
        self.assertRegex(text, r"\nfunctions   8 in use, 1 free\n  mean .*\n  period_years .* prior \+- 0.019\n")

    def test_least_squares(self):
        """Power against numpy, with the partial derivatives of the prediction and pseudo-observations for the priors."""
        part = slice(0, 209, 5)
        write_series(self.folder / "s.csv", mjd(self.tai_ns[part]), self.arcsec[part] / SCALE, self.SIGMA / SCALE)
        self.period("s.csv", *PX, *GRID, "--scale-sigma", 1e-3, "--power", "power.npy")
        half = EXPOSURE * SECOND // 2
        intervals = numpy.stack([self.tai_ns[part] - half, self.tai_ns[part] + half], axis=-1)
        sky = toliman.Sky(str(self.folder / "wrong.json"), altitude_km=600)
        reduced, seen = sky.reduce(intervals, self.arcsec[part]).y, sky.predict_exposures(intervals)
        partials, factor = seen["partials"], seen["factor"]
        prior = numpy.array([self.system["sigma"]["orbit"][name] for name in self.NAMES])
        prior[1] = numpy.hypot(prior[1], 1e-3 * self.wrong["orbit"]["semi_major_arcsec"])
        weight = factor / self.SIGMA
        t, base = mjd(self.tai_ns[part]), numpy.column_stack([numpy.ones(len(factor)), partials])
        base = numpy.vstack([base * weight[:, None], numpy.column_stack([numpy.zeros(7), numpy.diag(1 / prior)])])
        right = numpy.r_[reduced * weight, numpy.zeros(7)]

        def residual(matrix):
            matrix = matrix / numpy.linalg.norm(matrix, axis=0)
            return ((matrix @ numpy.linalg.lstsq(matrix, right, rcond=None)[0] - right) ** 2).sum()
        expected = []
        for frequency in 1 / 800 + 1e-4 * numpy.arange(100):
            wave = numpy.exp(2j * numpy.pi * frequency * (t - t[0])) * weight
            wave = numpy.vstack([numpy.column_stack([wave.real, wave.imag]), numpy.zeros((7, 2))])
            expected.append(1 - residual(numpy.column_stack([base, wave])) / residual(base))
        numpy.testing.assert_allclose(numpy.load(self.folder / "power.npy"), expected, rtol=0, atol=1e-6)

    def test_a_trend_instead(self):
        """Without sigmas, or without standard deviations of the elements, with a warning; or as an option says."""
        trend = ["mean", "T1", "T2", "T3", "T4"]

        def names(found):
            return [one["name"] for one in found["functions"]["coefficients"]]
        self.assertEqual(names(self.period("plain.csv", *PX, *GRID, warning="--trend")), trend)
        (self.folder / "wrong.json").write_text(json.dumps({k: v for k, v in self.wrong.items() if k != "sigma"}))
        self.assertEqual(names(self.period("s.csv", *PX, *GRID, warning="--trend")), trend)
        self.assertEqual(names(self.period("s.csv", *PX, *GRID, "--trend", 5)), [*trend, "T5"])
        self.assertNotIn("functions", self.period("plain.csv", *PX, *GRID, "--fixed-mean", warning="--trend"))

    def test_columns_of_a_file(self):
        """They are those of the samples that are reduced."""
        write_orbit(self.folder / "low.csv", START, 120)
        tai_ns = START + (300 + 400 * numpy.arange(20)) * SECOND
        inside = tai_ns < START + (119 * 60 - 30) * SECOND
        values = numpy.random.default_rng(1).normal(size=20)
        arcsec = numpy.full(20, 9.8)
        arcsec[inside] = measured(toliman.Sky(observer=self.folder / "low.csv"), tai_ns[inside], 50 * values[inside])
        order = numpy.random.default_rng(2).permutation(20)
        write_series(self.folder / "s.csv", mjd(tai_ns)[order], arcsec[order], 1e-6)
        (self.folder / "c.csv").write_text("any,drift\n" + "".join(
            f"{t!r},{v!r}\n" for t, v in zip(mjd(tai_ns)[order].tolist(), values[order].tolist())))
        done = self.run_program("period", "s.csv", "--system", "alpha-cen", "--observer", "low.csv", *SHORT, *TAI, "--f0", 10,
                                "--df", 1, "--nf", 50, "--nuisance-file", "c.csv", "--json")
        self.assertIn("low.csv", done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual(found["n"], inside.sum())
        self.assertEqual(found["functions"]["coefficients"][1]["name"], "drift")
        self.assertAlmostEqual(found["functions"]["coefficients"][1]["value"] * 1e6, 50, delta=1e-3)

    def test_refusals(self):
        for message, arguments in (
                ("--scale-sigma ", ("s.csv", "--scale-sigma", 0.1)),
                ("--trend ", ("s.csv", *self.WRONG, "--scale-sigma", 0.1, "--trend", 2)),
                ("--scale-sigma 1: ", ("s.csv", *self.WRONG, "--scale-sigma", 1)),
                ("--span 61400,63000: ", ("s.csv", *PX, *self.WRONG, "--span", "61400,63000"))):
            with self.subTest(message):
                self.refuse(2, message, arguments=("period", *arguments))
        done = self.run_program("period", "plain.csv", *PX, *self.WRONG, "--save-state", "s.tlmp")
        self.assertEqual((done.returncode, "--span START,END" in done.stderr), (2, True), done.stderr)


if __name__ == "__main__":
    unittest.main()
