"""Periods and their aliases: the short form of alias_campaign.py, and what the program tells of a state folder and of series."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from package import toliman
import alias_campaign as campaign


def run(*arguments):
    return subprocess.run([os.environ["TOLIMAN"], *map(str, arguments)], capture_output=True, text=True, check=True)


class Campaign(unittest.TestCase):
    # promise: longest-alias-is-shown
    def test_missions(self):
        rows = [campaign.fly(seed) for seed in range(1, 6)]
        self.assertTrue(all(campaign.is_right(row[0], shown) for row in rows for shown in row[2:]), rows)
        self.assertFalse(all(campaign.is_right(*row[:2]) for row in rows))  # the highest power would not do

    def test_the_ground(self):
        for name in campaign.GROUND:
            for seed in range(2):
                with self.subTest(name=name, seed=seed):
                    truth, period = campaign.observe(name, seed)
                    self.assertTrue(campaign.is_right(truth, period), (truth, period))


class Folder(unittest.TestCase):
    """The mission of seed 2, whose highest peak is at 3 d, in two folders: one of all frames, one merged of two halves."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        rng = numpy.random.default_rng(2)
        cls.truth = rng.uniform(132, 560)
        frames = campaign.frames(rng, cls.truth)
        for name, part in (("all", frames), ("one", frames[::2]), ("two", frames[1::2])):
            with campaign.tracker(folder=str(cls.folder / name), sync="none") as tracker:
                tracker.push_many(part)
        run("merge", cls.folder / "one", cls.folder / "two", "--out", cls.folder / "merged")
        cls.status = {name: json.loads(run("status", "--json", cls.folder / name).stdout) for name in ("all", "merged")}

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_the_period_is_true(self):
        status = self.status["all"]
        for period in (status["period"], status["fit"]["period"]):
            self.assertTrue(campaign.is_right(self.truth, period), (self.truth, period))
        self.assertEqual({**self.status["merged"], **dict.fromkeys(differing := (
            "folder", "streams", "records", "received", "repeated", "sessions"))}, {**status, **dict.fromkeys(differing)})

    def test_aliases_are_named(self):
        status = self.status["all"]
        f = status["fit"]["frequency"] if "frequency" in status["fit"] else 1 / status["fit"]["period"]
        near = {round(alias["period"], 2): alias for alias in status["aliases"]}
        for expected in 1 / abs(1 / 3 - f), 1 / (1 / 3 + f):
            alias = near[min(near, key=lambda period: abs(period - expected))]
            self.assertAlmostEqual(alias["period"], expected, delta=0.005)
            self.assertEqual((alias["cause"], alias["equal"], alias["slow"]), ("sampling", True, False))
            self.assertAlmostEqual(alias["interval"], 3, delta=0.01)


class Series(unittest.TestCase):
    def found(self, t, y, *options, date=False):
        """Returns result and messages of `period` for Julian Days without and with a name."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "s.csv"
            rows = zip(t + 2455000, y)
            path.write_text(("jd,y,sigma\n" if date else "t,y,sigma\n") + "".join(f"{a:.6f},{b:.4f},1\n" for a, b in rows))
            done = run("period", path, "--json", *options)
            return json.loads(done.stdout), done.stderr

    def test_a_slow_change_at_night(self):
        """Nights of one sidereal time: the change has a peak near one day."""
        rng = numpy.random.default_rng(3)
        t = campaign.nights(rng, 120, scatter=0.01, days=1500, step=0.99726957)
        y = 1e-5 * t**2 + rng.normal(0, 1, t.size)
        grid = ("--f0", 0.9, "--df", 1 / 15000, "--nf", 3000)
        for date in (False, True):
            result, errors = self.found(t, y, *grid, date=date)
            self.assertAlmostEqual(result["peak"]["period"], 0.99726957, delta=0.001)
            self.assertIn("a slow change, sampled at one sidereal day, has this peak as an alias: --trend", errors)
            alias = result["aliases"][0]
            self.assertEqual((alias["cause"], alias["equal"], alias["slow"]), ("sidereal day", True, True))
            cured, errors = self.found(t, y, *grid, "--trend", 3, date=date)
            self.assertGreater(cured["peak"]["log10_fap"], -3)

    def test_the_grid_is_told(self):
        rng = numpy.random.default_rng(4)
        t = campaign.nights(rng, 40, each=3)
        result, errors = self.found(t, campaign.with_wave(rng, t, 74.3, 5, 1))
        self.assertAlmostEqual(result["peak"]["period"], 74.3, delta=0.5)
        self.assertEqual(result["grid"]["nf"], 131072)
        self.assertIn("are not searched, to limit the time of the default grid", errors)

    def test_python_names_aliases(self):
        rng = numpy.random.default_rng(5)
        t = campaign.nights(rng, 200, days=400)
        y = campaign.with_wave(rng, t, 9, 5, 1)
        with toliman.Periodogram(*toliman.suited_grid(t), unit_ns=86400e9) as periodogram:
            periodogram.push_many(t, y)
            aliases = periodogram.aliases(periodogram.peak().frequency)
        self.assertEqual({alias.interval_kind for alias in aliases[:2]}, {"solar day"})
        self.assertAlmostEqual(min(abs(alias.period - 1.125) for alias in aliases), 0, delta=0.005)


if __name__ == "__main__":
    unittest.main()
