"""toliman period: its numbers against astropy, its text, its warnings, and what it refuses."""
import json
import math
import os
import re
import resource
import signal
import subprocess
import time
import unittest
import numpy
from astropy.timeseries import LombScargle
from astropy.timeseries.periodograms.lombscargle._statistics import fap_baluev
from program import PATIENCE, PROGRAM, ROOT, ProgramTest

DATA = ROOT / "examples" / "data" / "nu_oph_rv.csv"
GRID = ("--f0", 1e-4, "--df", 2e-5, "--nf", 2500)


class RealVelocities(ProgramTest):
    def test_against_astropy(self):
        t, y, sigma = numpy.genfromtxt(DATA, delimiter=",", skip_header=3, unpack=True)
        frequency = 1e-4 + 2e-5 * numpy.arange(2500)
        for flags in ([], ["--fixed-mean"]):
            result = json.loads(self.succeed("period", DATA, *GRID, *flags, "--json", "--power", "power.npy"))
            peer, peak = LombScargle(t - t[0], y, sigma, fit_mean=not flags), result["peak"]
            power = peer.power(frequency, method="slow")
            self.assertLess(abs(numpy.load(self.folder / "power.npy") - power).max(), 1e-9)
            self.assertEqual((result["n"], result["grid"]), (t.size, {"f0": 1e-4, "df": 2e-5, "nf": 2500}))
            self.assertAlmostEqual(peak["period_error"] / peak["frequency_error"] / peak["period"] ** 2, 1, delta=1e-6)
            self.assertAlmostEqual(peak["power"], float(peer.power(peak["frequency"], method="slow")), delta=1e-9)
            for nudge in (-1e-7, 1e-7):  # it is the top
                self.assertGreater(peak["power"], float(peer.power(peak["frequency"] + nudge, method="slow")))
            # Not false_alarm_probability(): it rounds the highest frequency to a grid of its own.
            fap = fap_baluev(peak["power"], frequency[-1], t - t[0], y, sigma)
            self.assertAlmostEqual(peak["log10_fap"], math.log10(fap), delta=1e-9)
            if not flags:
                self.assertAlmostEqual(peak["period"], 532, delta=1)
                self.assertLess(peak["log10_fap"], -40)

    def test_false_alarm_probabilities(self):
        """Each method has its name; tests/bind/test_fap.py has the numbers."""
        def log10_fap(*how, grid=("--f0", 0.02, "--df", 2e-5, "--nf", 500)):
            result = json.loads(self.succeed("period", DATA, *grid, "--json", *how))
            self.assertEqual(result["fap_method"], how[1] if how else "baluev")
            return result["peak"]["log10_fap"], result["peak"]
        baluev, peak = log10_fap()
        self.assertTrue(-3 < baluev < -0.2, baluev)
        self.assertEqual(log10_fap("--fap", "baluev")[0], baluev)
        self.assertLess(log10_fap("--fap", "naive")[0], baluev)
        self.assertAlmostEqual(log10_fap("--fap", "single")[0], (150 - 3) / 2 * peak["log10_residual"], delta=1e-9)
        self.assertGreater(log10_fap("--fap", "sequential")[0], baluev)
        few = ("--fap", "bootstrap", "--resamplings", 99, "--seed", 3)
        self.assertEqual(log10_fap(*few), log10_fap(*few))
        self.assertAlmostEqual(log10_fap(*few, grid=GRID)[0], -2, delta=1e-12)
        self.assertIn("< -2.00 (bootstrap, none of 99)\n", self.succeed("period", DATA, *GRID, *few))
        self.assertIn("(sequential)", self.succeed("period", DATA, *GRID, "--fap", "sequential"))

    def test_normalisations(self):
        t, y, sigma = numpy.genfromtxt(DATA, delimiter=",", skip_header=3, unpack=True)
        frequency = 1e-4 + 2e-5 * numpy.arange(2500)
        for name in ("standard", "model", "log", "psd"):
            self.succeed("period", DATA, *GRID, "--normalisation", name, "--power", "power.npy")
            power = LombScargle(t - t[0], y, sigma, normalization=name).power(frequency, method="slow")
            self.assertLess(abs(numpy.load(self.folder / "power.npy") / power - 1).max(), 1e-9)

    def test_grids_that_do_not_suit(self):
        def warnings(*grid):
            done = self.run_program("period", DATA, *grid)
            self.assertEqual(done.returncode, 0)
            return done.stderr
        self.assertRegex(warnings(*GRID), r"^toliman: warning: chi-square 404.7 \+- 0.12: [^\n]*\n"
                                            r"toliman: warning: values are correlated [^\n]*\n$")  # by the second companion
        self.assertIn("--df 0.0001 is above 1/(5 T) = 4.96", warnings("--f0", 3e-4, "--df", 1e-4, "--nf", 100))
        self.assertEqual(warnings("--f0", 1e-4, "--df", 2e-4, "--nf", 20000).count("warning: "), 4)

    def test_pipes(self):
        expected = self.succeed("period", DATA, *GRID)
        os.mkfifo(self.folder / "pipe")
        writer = subprocess.Popen(["cp", DATA, "pipe"], cwd=self.folder)
        self.assertEqual(self.succeed("period", "pipe", *GRID), expected)
        self.assertEqual(writer.wait(), 0)
        self.assertEqual(self.succeed("period", "-", *GRID, input=DATA.read_text()), expected)

    def test_summary_for_people(self):
        out = self.succeed("period", DATA)
        self.assertIn("period      531.9", out)
        grid = json.loads(self.succeed("period", DATA, "--json"))
        shortest, longest = (grid["searched"][name] for name in ("shortest", "longest"))
        self.assertAlmostEqual(longest, 1 / grid["grid"]["f0"], delta=1e-9 * longest)
        self.assertAlmostEqual(1 / shortest, grid["grid"]["f0"] + grid["grid"]["df"] * (grid["grid"]["nf"] - 1), 12)
        self.assertIn(f"searched    periods from {shortest:.6g} to {longest:.6g}\n", out)
        zero = ("period", DATA, "--f0", 0, "--df", 1e-4, "--nf", 301)
        self.assertIn("searched    periods from 33.3333 to inf\n", self.succeed(*zero))
        self.assertIsNone(json.loads(self.succeed(*zero, "--json"))["searched"]["longest"])
        self.assertIn("log10 FAP", out)


class HardSeries(ProgramTest):
    def write(self, *columns):
        numpy.savetxt(self.folder / "series.csv", numpy.column_stack(columns), delimiter=",", fmt="%.17g")

    def test_a_signal_stops_it(self):
        self.write(numpy.arange(20000.0), numpy.arange(20000.0) % 7)
        command = [PROGRAM, "--progress=json", "period", "series.csv", "--power", "p.npy"]
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            child = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True)
            self.assertIn('"progress":"period"', child.stderr.readline())
            child.send_signal(number)
            start = time.monotonic()
            self.assertIn("stopped by a signal", child.communicate(timeout=PATIENCE)[1])
            self.assertEqual(child.returncode, code)
            self.assertLess(time.monotonic() - start, 5)
        self.assertFalse((self.folder / "p.npy").exists())

    def test_default_grid_of_bounded_cost(self):
        self.write(numpy.r_[numpy.arange(6) * 1e-15, 1e9, 2e9], numpy.arange(8) % 3)
        done = self.run_program("period", "series.csv", "--json")
        self.assertEqual((done.returncode, done.stderr.count("warning: ") > 0), (0, True), done.stderr)
        self.assertEqual(json.loads(done.stdout)["grid"]["nf"], 131072)


class Edge(ProgramTest):
    """A period beyond the default grid, which begins at 1.5/300: refined by a step it was 214.286 for one of 500."""

    def test_the_frequency_stays_inside_and_is_warned_of(self):
        t = numpy.arange(300.0)
        y = numpy.sin(2 * numpy.pi * t / 500) + 0.01 * numpy.random.default_rng(1).standard_normal(300)
        numpy.savetxt(self.folder / "long.csv", numpy.column_stack([t, y]), delimiter=",", fmt="%.17g")
        done = self.run_program("period", "long.csv", "--json")
        self.assertEqual(done.returncode, 0)
        peak = json.loads(done.stdout)["peak"]
        self.assertEqual((peak["frequency"], peak["at_edge"]), (1.5 / 300, True))
        self.assertIn("(--f0, --df, --nf)", done.stderr)
        wide = ("--f0", 1e-3, "--df", 1e-4, "--nf", 50)
        done = self.run_program("period", "long.csv", *wide, "--json")
        peak = json.loads(done.stdout)["peak"]
        self.assertAlmostEqual(peak["period"], 500, delta=5)
        self.assertEqual((peak["at_edge"], peak["long_period"]), (False, True))
        self.assertEqual(done.stderr.count("\n"), 2, done.stderr)  # long, and near a year


class Columns(ProgramTest):
    def setUp(self):
        super().setUp()
        rows = [(k, k % 3 + 0.1 * (k % 5), 1 + 0.1 * (k % 2)) for k in range(30)]
        self.rows = rows
        self.plain = self.period("t,y,sigma", "%d,%g,%g", lambda t, y, s: (t, y, s))

    def period(self, head, form, order, *options):
        text = (head + "\n" if head else "") + "".join(form % order(*row) + "\n" for row in self.rows)
        (self.folder / "s.csv").write_text(text)
        return self.succeed("period", "s.csv", *options)

    def test_by_name(self):
        self.assertEqual(self.period("k,y,note,t,sigma", "1,%g,x,%d,%g", lambda t, y, s: (y, t, s)), self.plain)
        named = ("--columns", "BJD,RV,err")
        self.assertEqual(self.period("RV,err,BJD", "%g,%g,%d", lambda t, y, s: (y, s, t), *named), self.plain)
        self.assertEqual(self.period("\ufefft,y,sigma", "%d,%g,%g", lambda t, y, s: (t, y, s)), self.plain)

    def test_a_quoted_first_line_is_data(self):
        self.assertEqual(self.period("", '"%d","%g","%g"', lambda t, y, s: (t, y, s)), self.plain)

    def test_refusals(self):
        numpy.save(self.folder / "s.npy", numpy.ones((9, 2)))
        self.refuse(3, "s.csv:1: ", "column z", arguments=("period", "s.csv", "--columns", "t,z"))
        for name in ("s.csv", "s.npy", "missing.csv"):
            self.refuse(2, "--columns t: ", arguments=("period", name, "--columns", "t"))
        self.period("", "%d,%g,%g", lambda t, y, s: (t, y, s))
        self.refuse(3, "s.csv:1: ", "(--columns t,y)", arguments=("period", "s.csv", "--columns", "t,y"))


class BadSeries(ProgramTest):
    def test_malformed_files(self):
        """tests/unit/test_series.c and test_series_tables.c have the rules of a line and of a table."""
        for text, *expected in (
            ("t,y\n1,2\n2,three\n", "bad.csv:3: y", "three"),
            ("0,1\n1,2\0junk\n", 'bad.csv:2: y = "2?junk"'),
            ("", "bad.csv: "),
            ("y,when\n1,2\n", "bad.csv:1: ", "y,when", "--columns"),
            ("t,y\n" + "".join(f"{k},{k % 7 / 8}\n" for k in range(20)) + "20,-999\n", "bad.csv: y = -999 on line 22"),
            ("t,y\n1,2\n2,3\n", "bad.csv: "),
        ):
            with self.subTest(text=text):
                (self.folder / "bad.csv").write_text(text)
                self.refuse(3, *expected, arguments=("period", "bad.csv"))
        done = self.run_program("period", "-", input="t,y\n1,2\n2,three\n")
        self.assertEqual((done.returncode, "standard input:3: y" in done.stderr), (3, True), done.stderr)

    def test_last_line_without_its_end(self):
        rows = "".join(f"{k},{k % 3 + 0.5}\n" for k in range(9))
        (self.folder / "s.csv").write_text(rows)
        whole = self.run_program("period", "s.csv", "--save-state", "s.tlmp")
        self.assertEqual((whole.returncode, whole.stderr), (0, ""))
        (self.folder / "s.csv").write_text(rows[:-1])
        cut = self.run_program("period", "s.csv")
        self.assertEqual((cut.returncode, cut.stdout), (0, whole.stdout))
        self.assertRegex(cut.stderr, "^toliman: warning: s.csv:9: [^\n]*\n$")
        more = self.run_program("period", "-", "--from-state", "s.tlmp", input="9,0.5\n10,1.25")
        self.assertEqual((more.returncode, "warning: standard input:2: " in more.stderr), (0, True), more.stderr)
        done = self.run_program("period", "-", input=rows + "# the end")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_a_grid_that_needs_more_memory_than_there_is(self):
        (self.folder / "s.csv").write_text("".join(f"{k},{k % 3}\n" for k in range(9)))
        done = subprocess.run([PROGRAM, "period", "s.csv", "--f0", "0.1", "--df", "1e-9", "--nf", str(2**26)],
                              capture_output=True, text=True, cwd=self.folder, timeout=PATIENCE,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31)))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"out of memory: .* [1-9]\d{9} bytes")

    def test_digits_follow_the_error(self):
        t = numpy.arange(300) * 1.7
        noise = numpy.random.default_rng(4).normal(size=t.size)
        for amplitude, scatter in ((1, 0.3), (1e-6, 4e-8), (300, 1), (1, 5), (1e12, 1e11)):
            y = amplitude * numpy.sin(t / 7) + scatter * noise
            (self.folder / "s.csv").write_text("".join(f"{a},{b!r}\n" for a, b in zip(t, map(float, y))))
            lines = self.succeed("period", "s.csv").split("\n")
            peak = json.loads(self.succeed("period", "s.csv", "--json"))["peak"]
            error = peak["frequency_error"] / peak["frequency"] ** 2
            for line, value, sigma in ((lines[0], peak["period"], error),
                                       (lines[1], peak["amplitude"], peak["amplitude_error"])):
                number, error = re.match(r"\w+ +(\S+) \+- ([^\s,]+)[ ,]", line).groups()
                with self.subTest(line=line):
                    self.assertEqual(float(error), float(f"{sigma:.1e}") if sigma < 10 else round(sigma))
                    self.assertLess(abs(float(number) - value), max(0.06 * sigma, 0.51 if sigma > 10 else 0))
                    self.assertEqual("e" in number, abs(value) < 1e-5)
                    if "e" not in number:
                        self.assertEqual(len(number.partition(".")[2]), len(error.partition(".")[2]))

    def test_few_samples_on_a_given_grid(self):
        (self.folder / "short.csv").write_text("0,1\n1,2\n2,0\n")
        self.refuse(3, "short.csv: ", arguments=("period", "short.csv", "--f0", 0.1, "--df", 0.1, "--nf", 3))

    def test_missing_file_and_bad_options(self):
        numpy.save(self.folder / "f.npy", numpy.ones((9, 4)))
        for name in ("f.npy", "none.csv"):
            self.refuse(3, f"{name}: ", arguments=("period", name))
        self.refuse(2, "--f0", arguments=("period", DATA, "--f0", 1))
        for f0, df, nf, *texts in (("nan", 1, 5, "--f0 nan: "), (1, "inf", 5, "--df inf: "),
                                   (1, 1, 0, "nf = 0: ", "--f0, --df, --nf: "), (0, 1, 1, "--f0, --df, --nf: ")):
            self.refuse(2, *texts, arguments=("period", DATA, "--f0", f0, "--df", df, "--nf", nf))
        self.refuse(2, "--nf", arguments=("period", DATA, "--nf", "many"))
        self.refuse(2, "--fap", arguments=("period", DATA, "--fap", "analytic"))
        self.refuse(6, "no/power.npy", arguments=("period", DATA, "--power", "no/power.npy"))


if __name__ == "__main__":
    unittest.main()
