"""toliman period --system: separations as a spacecraft measures them are reduced to the orbit, and show a planet of 1.2 uas."""
import json
import logging
import unittest

import numpy
from observed import DAY, EXPOSURE, SCALE, SECOND, START, measured, mjd, toliman, write_orbit, write_series
from program import ProgramTest

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
        """836 of 1095 days; the times and what a planet of 1.2 uas with a period of 350 d changes."""
        days = numpy.sort(numpy.random.default_rng(3).choice(1095, 836, replace=False)) + 0.25
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
        self.assertEqual(found["n"], 836)
        self.assertEqual(found["reduction"], {
            "system": "alpha-cen", "observer": "circular orbit", "observer_file": None, "altitude_km": 600, "node_hours": 18,
            "plate_scale_arcsec": SCALE, "exposure_s": EXPOSURE, "unreduced": 0})
        text = self.succeed("period", "s.csv", *LOW, *PX, *SHORT, *TAI)
        self.assertIn("\nreduced     alpha-cen seen from: circular orbit, altitude 600 km, node at 18 h; 0 samples left out\n",
                      text)
        # the velocity of the spacecraft, 205 to 257 uas, is not left out
        done = self.run_program("period", "s.csv", "--json", "--system", "alpha-cen", *PX, *SHORT, *TAI)
        self.assertIn("no observer given", done.stderr)
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
            found = self.period(*LOW, *SHORT, *GRID, "--time-scale", scale)
            offsets.append(found["peak"]["offset"] * 1e6)
            periods.append(found["peak"]["period"])
        write_series(self.folder / "s.csv", utc, arcsec / SCALE, name="t")
        found = self.period(*LOW, *SHORT, *GRID, *PX)
        offsets.append(found["peak"]["offset"] * SCALE * 1e6)
        self.assertLess(abs(offsets[0]), 50)
        numpy.testing.assert_allclose(offsets, offsets[0], rtol=0, atol=1e-3)  # of 40 us in a JD: 1e-5 uas
        numpy.testing.assert_allclose(periods, periods[0], rtol=1e-3)

    def test_leap_seconds(self):
        """--leap-seconds is for the times of the series as well: 26 s are 7 uas."""
        (self.folder / "old.list").write_text("#@ 3928521600\n2272060800 10\n2287785600 11\n")
        tai_ns = START + numpy.arange(12) * 20 * DAY
        arcsec = measured(toliman.Sky(altitude_km=600), tai_ns + 11 * SECOND)
        write_series(self.folder / "s.csv", numpy.datetime_as_string(tai_ns.view("M8[ns]"), unit="s").tolist(), arcsec,
                     name="t")
        for more, least, most in (((), 1, 50), (("--leap-seconds", "old.list"), 0, 0.01)):
            amplitude = self.period(*LOW, *SHORT, *GRID, *more)["peak"]["amplitude"] * 1e6
            self.assertTrue(least <= amplitude <= most, amplitude)
        offsets = [self.period(*GRID, *more)["peak"]["time_offset"] for more in ((), ("--leap-seconds", "old.list"))]
        self.assertAlmostEqual((offsets[0] - offsets[1]) * 86400, 26, delta=1e-4)  # also without a system

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
        self.assertIn(f"warning: {16 - inside.sum()} of 16 samples are left out, as the observer is not known for their times: "
                      "low.csv has states from 2027-01-01T00:00:00 to 2027-01-01T01:59:00 TAI", done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual((found["n"], found["reduction"]["unreduced"]), (inside.sum(), 16 - inside.sum()))
        self.assertLess(found["peak"]["amplitude"] * 1e6, 0.01)
        write_series(self.folder / "s.csv", mjd(tai_ns[~inside] + DAY), arcsec[~inside])
        self.refuse(3, "s.csv: the observer is not known for the time of any sample: low.csv has states from 2027-01-01",
                    arguments=("period", "s.csv", *observer, *SHORT, *TAI, *grid))

    def test_mistakes(self):
        tai_ns = START + numpy.arange(8) * 30 * DAY
        write_series(self.folder / "s.csv", mjd(tai_ns), numpy.full(8, 9.8))
        write_series(self.folder / "plain.csv", mjd(tai_ns), numpy.full(8, 9.8), name="t")
        write_series(self.folder / "negative.csv", mjd(tai_ns), numpy.full(8, -0.1))
        for code, message, arguments in (
                (3, "plain.csv: times are plain numbers: must be dates, Modified Julian Days or Julian Days (--time-format mjd",
                 ("plain.csv", *LOW, *SHORT)),
                (2, "--exposure not given: must be in (0, 600] s for an observer in orbit", ("s.csv", *LOW)),
                (2, "--exposure 601: must be in (0, 600] s for an observer in orbit", ("s.csv", *LOW, "--exposure", 601)),
                (2, "--exposure -5: must be in (0, 3.456e+07] s", ("s.csv", *LOW, "--exposure", -5)),
                (2, "--plate-scale -1: must be above 0 arcsec per px and finite", ("s.csv", *LOW, *SHORT, "--plate-scale", -1)),
                (2, "--plate-scale inf: must be", ("s.csv", *LOW, *SHORT, "--plate-scale", "inf")),
                (2, "--altitude 100: must be in [200, 2000] km", ("s.csv", *LOW[:3], 100)),
                (3, "negative.csv: sample 1: y = -0.1: must be a measured separation, above 0",
                 ("negative.csv", *LOW, *SHORT)),
                (3, "missing.json: No such file", ("s.csv", "--system", "missing.json", "--altitude", 600)),
                (2, 'system = "": must be "alpha-cen" or a system file', ("s.csv", "--system", "", *LOW[2:], *SHORT)),
                (2, "--plate-scale requires --system", ("s.csv", *PX)),
                (2, "--altitude requires --system", ("s.csv", "--altitude", 600)),
                (2, "--follow excludes --system", ("s.csv", *LOW, *SHORT, "--follow")),
                (2, "excludes --", ("s.csv", *LOW, *SHORT, "--from-state", "s.tlmp"))):
            with self.subTest(message):
                self.refuse(code, message, arguments=("period", *arguments))
        done = self.run_program("period", "s.csv", *LOW, *SHORT, "--plate-scale", 0.4, *GRID)
        self.assertIn("the mean measured separation is 3.92 arcsec, that on the orbit 9.", done.stderr)
        self.assertIn("are system, unit and --plate-scale right?", done.stderr)


if __name__ == "__main__":
    unittest.main()
