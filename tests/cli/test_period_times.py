"""Dates, Modified Julian Days and Julian Days in the series of toliman period, against astropy."""
import json
import random
import unittest
import warnings

import numpy
from astropy.time import Time
from program import ProgramTest

GRID = ("--f0", 0.01, "--df", 0.001, "--nf", 300)
ULP = 2**-37  # days, of an MJD


def quietly(make):
    """Without warnings of years to come, of which no leap seconds are known."""
    with warnings.catch_warnings(action="ignore"):
        return make()


def mjd(text, scale, form="isot"):
    """MJD of the result's scale: TAI for UTC, otherwise the same."""
    time = quietly(lambda: Time(text, scale=scale, format=form))
    return quietly(lambda: time.tai.mjd if scale == "utc" else time.mjd)


class Times(ProgramTest):
    def setUp(self):
        super().setUp()
        chance = random.Random(5)
        self.dates = [f"{chance.randint(1972, 2098)}-{chance.randint(1, 12):02d}-{chance.randint(1, 28):02d}"
                      f"T{chance.randint(0, 23):02d}:{chance.randint(0, 59):02d}:{chance.uniform(0, 59.9):06.3f}"
                      for _ in range(40)]
        self.dates += ["2016-12-31T23:59:59", "2016-12-31T23:59:60", "2016-12-31T23:59:60.5", "2017-01-01T00:00:00"]
        self.y = [chance.gauss(0, 1) for _ in self.dates]

    def series(self, head, times, name="s.csv"):
        (self.folder / name).write_text(head + "".join(f"{t},{float(y)!r}\n" for t, y in zip(times, self.y)))
        return name

    def times(self, name, *more, stdin=None):
        """The times that the program uses, from the fifth on, and their scale."""
        out = self.run_program("period", name, "--follow", *GRID, *more, input=stdin)
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertNotIn("skipped", out.stderr)
        lines = [json.loads(line) for line in out.stdout.splitlines()]
        self.assertEqual(len(lines), len(self.dates) - 4)
        scales = {line["time_scale"] for line in lines}
        self.assertEqual(len(scales), 1)
        return [line["t"] for line in lines], scales.pop()

    def check(self, found, expected, scale):
        self.assertEqual(found[1], scale)
        numpy.testing.assert_allclose(found[0], expected[4:], rtol=0, atol=ULP)

    def test_dates(self):
        """tests/bind/test_times.py has the times of each scale, tests/unit/test_series.c the forms."""
        in_tai = [date for date in self.dates if ":60" not in date]
        for scale in ("utc", "tai", "tt", "tdb"):
            dates = self.dates if scale == "utc" else in_tai + in_tai[:2]
            options = () if scale == "utc" else ("--time-scale", scale)
            expected = [mjd(date, scale) for date in dates]
            self.check(self.times(self.series("", dates), *options), expected, "TAI" if scale == "utc" else scale.upper())
        objects = "".join(json.dumps({"t": t, "y": y}) + "\n" for t, y in zip(self.dates, self.y))
        self.check(self.times("-", stdin=objects), [mjd(date, "utc") for date in self.dates], "TAI")
        self.assertEqual(self.times(self.series("", in_tai + in_tai[:2]), "--time-scale", "gps")[1], "GPS")

    def test_days(self):
        days = [f"{41400 + 900 * k}.{k * 7919 % 1000:03d}5" for k in range(len(self.dates) - 2)] + ["57753.5", "57753.99"]
        julian = [f"{int(day.split('.')[0]) + 2400000}.{day.split('.')[1]}" for day in days]
        by_mjd, by_jd = [mjd(day, "utc", "mjd") for day in days], [mjd(day, "utc", "jd") for day in julian]
        self.check(self.times(self.series("mjd,y\n", days)), by_mjd, "TAI")
        self.check(self.times(self.series("JD,y\n", julian)), by_jd, "TAI")
        self.check(self.times(self.series("", days), "--time-format", "mjd"), by_mjd, "TAI")
        found = self.times(self.series("mjd,y\n", days), "--time-scale", "tdb")
        self.check(found, [mjd(day, "tdb", "mjd") for day in days], "TDB")
        plain = [float(day) for day in days]
        self.check(self.times(self.series("mjd,y\n", days), "--time-format", "days"), plain, None)
        self.check(self.times(self.series("mjd,t,y\n", [f"{k},{day}" for k, day in enumerate(days)])), plain, None)

    def test_results(self):
        """The scale is in all results, and the period is that of plain numbers."""
        self.y = [numpy.sin(2 * numpy.pi * k / 9.7) for k in range(60)]
        dates = [str(numpy.datetime64("2016-12-01") + k) for k in range(60)]
        name, plain = self.series("", dates), self.series("", range(60), "plain.csv")
        result, other = (json.loads(self.succeed("period", file, "--json")) for file in (name, plain))
        self.assertEqual((result["time_scale"], other["time_scale"]), ("TAI", None))
        self.assertEqual(result["peak"]["time_offset"], mjd("2016-12-01T00:00:00", "utc"))
        self.assertAlmostEqual(result["peak"]["period"], other["peak"]["period"], delta=1e-5)
        self.assertIn(", Modified Julian Day in TAI\n", self.succeed("period", name))
        self.assertNotIn("Modified", self.succeed("period", plain))
        numpy.save(self.folder / "s.npy", numpy.array([[57723.0 + k, y] for k, y in enumerate(self.y)]))
        for options, scale in ((("--time-format", "mjd"), "TAI"), ((), None)):
            result = json.loads(self.succeed("period", "s.npy", "--json", *options))
            self.assertEqual(result["time_scale"], scale)
            self.assertEqual(result["peak"]["time_offset"], mjd("57723", "utc", "mjd") if scale else 57723)

    def test_states(self):
        """Sums contain no scale: that of further samples must be given, and then the bits are those of all at once."""
        (self.folder / "all.csv").write_text("".join(f"{t},{float(y)!r}\n" for t, y in zip(self.dates, self.y)))
        for name, part in (("a.csv", slice(20)), ("b.csv", slice(20, None))):
            (self.folder / name).write_text("".join(f"{t},{float(y)!r}\n" for t, y in zip(self.dates[part], self.y[part])))
        for name in ("all", "a"):
            self.run_program("period", f"{name}.csv", "--follow", *GRID, "--save-state", f"{name}.tlmp")
        self.refuse(2, "--time-scale", arguments=("period", "b.csv", "--from-state", "a.tlmp"))
        done = self.run_program("period", "b.csv", "--from-state", "a.tlmp", "--time-scale", "utc", "--json",
                                "--save-state", "b.tlmp")
        self.assertEqual(json.loads(done.stdout)["time_scale"], "TAI")
        self.assertEqual((self.folder / "b.tlmp").read_bytes(), (self.folder / "all.tlmp").read_bytes())

    def test_refused(self):
        for text, *why in (("2028-03-01,1\n2028-02-30,2\n", "s.csv:2: t: ", "2028-02-30"),
                           ("mjd,y\n2460000.5,1\n", "s.csv:2: t: ", "--time-format days"),
                           ("jd,y\n6000.5,1\n", "s.csv:2: t: ", "--time-format days")):
            (self.folder / "s.csv").write_text(text)
            self.refuse(3, *why, arguments=("period", "s.csv"))
        self.series("", range(len(self.y)))
        for options in (("--time-scale", "tt"), ("--time-scale", "utc", "--time-format", "days"), ("--time-scale", "ut1"),
                        ("--time-format", "date")):
            self.refuse(2, options[0], arguments=("period", "s.csv", *options))
        numpy.save(self.folder / "s.npy", numpy.array([[5.0, 1.0]] * 6))
        self.refuse(3, "s.npy: row 0, t: ", arguments=("period", "s.npy", "--time-format", "mjd"))


if __name__ == "__main__":
    unittest.main()
