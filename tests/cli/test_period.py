"""toliman period against astropy and against 45-digit arithmetic."""
import json
import math
import os
import re
import resource
import signal
import subprocess
import time
import unittest

import mpmath
import numpy
from astropy.timeseries import LombScargle
from astropy.timeseries.periodograms.lombscargle._statistics import fap_baluev
from program import PATIENCE, PROGRAM, ROOT, ProgramTest

DATA = ROOT / "examples" / "data" / "nu_oph_rv.csv"
GRID = ("--f0", 1e-4, "--df", 2e-5, "--nf", 2500)


class RealVelocities(ProgramTest):
    def check_against_astropy(self, fit_mean):
        flags = [] if fit_mean else ["--fixed-mean"]
        out = self.succeed("period", DATA, *GRID, *flags, "--json", "--power", "power.npy")
        result = json.loads(out)
        t, y, sigma = numpy.genfromtxt(DATA, delimiter=",", skip_header=3, unpack=True)
        frequency = 1e-4 + 2e-5 * numpy.arange(2500)
        peer = LombScargle(t - t[0], y, sigma, fit_mean=fit_mean)
        power = peer.power(frequency, method="slow")
        self.assertLess(abs(numpy.load(self.folder / "power.npy") - power).max(), 1e-9)
        self.assertEqual(result["n"], t.size)
        self.assertAlmostEqual(result["peak"]["period_error"] / result["peak"]["frequency_error"],
                               result["peak"]["period"] ** 2, delta=1e-6 * result["peak"]["period"] ** 2)
        self.assertEqual(result["grid"], {"f0": 1e-4, "df": 2e-5, "nf": 2500})
        peak = result["peak"]
        self.assertAlmostEqual(peak["power"], float(peer.power(peak["frequency"], method="slow")), delta=1e-9)
        for nudge in (-1e-7, 1e-7):  # it is the top
            self.assertGreater(peak["power"], float(peer.power(peak["frequency"] + nudge, method="slow")))
        # Not false_alarm_probability(): it rounds the highest frequency to a grid of its own.
        fap = fap_baluev(peak["power"], frequency[-1], t - t[0], y, sigma)
        self.assertAlmostEqual(result["peak"]["log10_fap"], math.log10(fap), delta=1e-9)
        return result

    def test_floating_mean(self):
        result = self.check_against_astropy(True)
        self.assertAlmostEqual(result["peak"]["period"], 532, delta=1)
        self.assertLess(result["peak"]["log10_fap"], -40)

    def test_fixed_mean(self):
        self.check_against_astropy(False)

    def test_false_alarm_probabilities(self):
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
        counted = log10_fap("--fap", "bootstrap", "--seed", 3)[0]
        self.assertEqual(log10_fap("--fap", "bootstrap", "--seed", 3)[0], counted)
        t, y, sigma = numpy.genfromtxt(DATA, delimiter=",", skip_header=3, unpack=True)
        random, frequency = numpy.random.default_rng(1), 0.02 + 2e-5 * numpy.arange(500)
        drawn = [random.integers(0, 150, 150) for _ in range(400)]
        highest = [LombScargle(t - t[0], y[i], sigma[i]).power(frequency, method="cython").max() for i in drawn]
        share = numpy.mean(numpy.array(highest) >= peak["power"])
        self.assertAlmostEqual(10 ** counted, share, delta=5 * math.sqrt(share * (1 - share) / 400) + 0.01)
        few = log10_fap("--fap", "bootstrap", "--resamplings", 99, grid=GRID)[0]
        self.assertAlmostEqual(few, -2, delta=1e-12)
        self.assertIn("log10 FAP   < -2.00 (bootstrap, none of 99)\n",
                      self.succeed("period", DATA, *GRID, "--fap", "bootstrap", "--resamplings", 99))
        self.assertIn("(sequential)", self.succeed("period", DATA, "--fap", "sequential"))
        self.refuse(2, "--fap", arguments=("period", DATA, "--fap", "analytic"))

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
        self.assertRegex(warnings(), r"^toliman: warning: chi-square 404.7 \+- 0.12: poor: [^\n]*\n"
                                     r"toliman: warning: values are correlated [^\n]*\n$")  # by the second companion
        self.assertIn("--df 0.0001 is above 1/(5 T) = 4.96", warnings("--f0", 3e-4, "--df", 1e-4, "--nf", 100))
        self.assertIn("the last frequency that the times resolve", warnings("--f0", 1e-4, "--df", 2e-4, "--nf", 20000))

    def check_against_45_digits(self, file, t, y, sigma, f0, df):
        self.succeed("period", file, "--f0", f0, "--df", df, "--nf", 4, "--power", "power.npy")
        power = numpy.load(self.folder / "power.npy")
        with mpmath.workdps(45):
            weight = [1 / mpmath.mpf(s) ** 2 for s in sigma]
            total = [sum(w * mpmath.mpf(v) ** p for w, v in zip(weight, y)) for p in (0, 1, 2)]
            for k in range(4):
                frequency = mpmath.mpf(f0) + k * mpmath.mpf(df)
                angles = [2 * mpmath.pi * frequency * (mpmath.mpf(x) - t[0]) for x in t]
                rows = [(1, mpmath.cos(a), mpmath.sin(a)) for a in angles]
                normal, right = mpmath.matrix(3, 3), mpmath.matrix(3, 1)
                for row, w, v in zip(rows, weight, y):
                    for i in range(3):
                        right[i] += w * row[i] * mpmath.mpf(v)
                        for j in range(3):
                            normal[i, j] += w * row[i] * row[j]
                fitted = (right.T * mpmath.lu_solve(normal, right))[0]
                expected = (fitted - total[1] ** 2 / total[0]) / (total[2] - total[1] ** 2 / total[0])
                self.assertLess(abs(power[k] / expected - 1), 1e-12)

    def test_a_small_part_of_a_cycle(self):
        """Frequencies of a hundredth of a cycle over the data, where sums of doubles say anything."""
        t, y, sigma = numpy.genfromtxt(DATA, delimiter=",", skip_header=3, unpack=True)
        f = 0.01 / (t[-1] - t[0])
        self.check_against_45_digits(DATA, t, y, sigma, f, f / 10)

    def test_short_nights(self):
        """Three nights of a minute each, a thousand days apart: at any frequency each is a small part of a cycle."""
        random = numpy.random.default_rng(3)
        t = numpy.concatenate([1000 * night + numpy.sort(random.uniform(0, 0.001, 8)) for night in range(3)])
        y = random.normal(size=24)
        numpy.savetxt(self.folder / "nights.csv", numpy.column_stack([t, y]), delimiter=",", fmt="%.17g")
        self.check_against_45_digits("nights.csv", t, y, numpy.ones(24), 0.05, 0.0137)

    def test_a_named_pipe(self):
        os.mkfifo(self.folder / "pipe")
        writer = subprocess.Popen(["cp", DATA, "pipe"], cwd=self.folder)
        self.assertEqual(self.succeed("period", "pipe"), self.succeed("period", DATA))
        self.assertEqual(writer.wait(), 0)

    def test_standard_input(self):
        self.assertEqual(self.succeed("period", "-", input=DATA.read_text()), self.succeed("period", DATA))

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


class PureSignal(ProgramTest):
    """The first row of the chapter's table: 0.33 +- 0.05, FAP 0."""

    def test_row(self):
        n = 1095
        t = numpy.arange(n) / n
        y = numpy.sin(2 * numpy.pi * 3 * t)
        numpy.savetxt(self.folder / "signal.csv", numpy.column_stack([t, y]), delimiter=",", fmt="%.17g")
        result = json.loads(self.succeed("period", "signal.csv", "--json"))
        self.assertAlmostEqual(result["peak"]["period"], 1 / 3, delta=1e-12)
        self.assertAlmostEqual(result["peak"]["half_width_period"], 0.0499, delta=1e-4)
        self.assertLess(result["peak"]["log10_fap"], -16000)
        grid = result["grid"]
        highest = grid["f0"] + grid["df"] * (grid["nf"] - 1)
        self.assertAlmostEqual(result["peak"]["log10_fap"], self.fap_in_45_digits(t, y, highest), delta=1)

    @staticmethod
    def fap_in_45_digits(t, y, highest):
        with mpmath.workdps(45):
            t, y = [mpmath.mpf(float(v)) for v in t], [mpmath.mpf(float(v)) for v in y]
            n = len(t)

            def residual(f):
                rows = [(mpmath.mpf(1), mpmath.cos(2 * mpmath.pi * f * u), mpmath.sin(2 * mpmath.pi * f * u)) for u in t]
                matrix = mpmath.matrix(3, 3)
                right = mpmath.matrix(3, 1)
                for row, value in zip(rows, y):
                    for i in range(3):
                        right[i] += row[i] * value
                        for j in range(3):
                            matrix[i, j] += row[i] * row[j]
                x = mpmath.lu_solve(matrix, right)
                return sum((v - sum(r * c for r, c in zip(row, x))) ** 2 for row, v in zip(rows, y))

            f, h = mpmath.mpf(3), mpmath.mpf(10) ** -12
            for _ in range(2):  # Newton on central differences
                left, middle, right = residual(f - h), residual(f), residual(f + h)
                f -= h * (right - left) / 2 / (left - 2 * middle + right)
            mean = sum(y) / n
            ratio = residual(f) / sum((v - mean) ** 2 for v in y)
            centre = sum(t) / n
            width = mpmath.mpf(highest) * mpmath.sqrt(4 * mpmath.pi * sum((u - centre) ** 2 for u in t) / n)
            free = mpmath.mpf(n - 1)
            gamma = mpmath.sqrt(2 / free) * mpmath.gamma(free / 2) / mpmath.gamma((free - 1) / 2)
            tau = gamma * width * ratio ** ((free - 3) / 2) * mpmath.sqrt(free / 2 * (1 - ratio))
            return float(mpmath.log10(tau + ratio ** ((free - 2) / 2)))


class HardSeries(ProgramTest):
    def write(self, *columns):
        numpy.savetxt(self.folder / "series.csv", numpy.column_stack(columns), delimiter=",", fmt="%.17g")

    def test_nyquist_frequency(self):
        """The sine vanishes at every sample: the amplitude is the mean of +-y, and no error is NaN."""
        t = numpy.arange(40.0)
        self.write(t, (-1.0) ** t)
        result = json.loads(self.succeed("period", "series.csv", "--json"))
        peak = result["peak"]
        self.assertAlmostEqual(peak["period"], 2, delta=1e-12)
        self.assertAlmostEqual(peak["amplitude"], 1, delta=1e-12)
        self.assertIsNone(peak["frequency_error"])
        self.assertGreaterEqual(peak["log10_residual"], -4900)
        self.assertLess(result["peak"]["log10_fap"], -100)
        self.assertNotIn("nan", self.succeed("period", "series.csv"))

    def test_one_sigma_of_1e_8(self):
        """astropy loses its digits here too; without the heavy sample the answer is nearly the same."""
        t = numpy.arange(200.0)
        y = numpy.sin(2 * numpy.pi * t / 10) + 0.3 * numpy.random.default_rng(1).standard_normal(200)
        sigma = numpy.ones(200)
        self.write(t, y, sigma)
        plain = json.loads(self.succeed("period", "series.csv", "--json"))
        sigma[77] = 1e-8
        self.write(t, y, sigma)
        peak = json.loads(self.succeed("period", "series.csv", "--json", "--power", "power.npy"))["peak"]
        self.assertAlmostEqual(peak["period"], plain["peak"]["period"], delta=0.02)
        self.assertAlmostEqual(numpy.load(self.folder / "power.npy").max(), peak["power"], delta=0.01)
        sigma[78] = 2e-9
        sigma[79] = 10
        self.write(t, y, sigma)
        self.refuse(3, "series.csv: sigma_ceiling = 10", "the ratio must be at most 1e+08", arguments=("period", "series.csv"))

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

    def test_progress_only_on_a_terminal(self):
        self.write(numpy.arange(50.0), numpy.arange(50.0) % 7)
        self.assertEqual(self.run_program("period", "series.csv").stderr, "")
        try:
            controller, terminal = os.openpty()
        except OSError as error:
            self.skipTest(f"no pseudo terminal here: {error}")
        subprocess.run([PROGRAM, "period", "series.csv"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=terminal)
        self.assertIn(b"period     [", os.read(controller, 4096))
        os.close(controller)
        os.close(terminal)

    def test_default_grid_of_bounded_cost(self):
        for step, span in ((1e-15, 1e9), (1e-98, 1e97), (1e-3, 1e7)):
            self.write(numpy.r_[numpy.arange(6) * step, span, 2 * span], numpy.arange(8) % 3)
            done = self.run_program("period", "series.csv", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["grid"]["nf"], 131072)
            self.assertIn("are not searched, to limit the time of the default grid", done.stderr)


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
        self.assertIn("edge of the frequency grid", done.stderr)
        self.assertIn("give another grid (--f0, --df, --nf)", done.stderr)
        wide = ("--f0", 1e-3, "--df", 1e-4, "--nf", 50)
        done = self.run_program("period", "long.csv", *wide, "--json")
        peak = json.loads(done.stdout)["peak"]
        self.assertAlmostEqual(peak["period"], 500, delta=5)
        self.assertEqual((peak["at_edge"], peak["long_period"]), (False, True))
        self.assertRegex(done.stderr, "^[^\n]*half the time span[^\n]*\n[^\n]*: if t is in days, the period is within one "
                                      "resolution of a year[^\n]*\n$")
        # Nearest to the first grid point, but inside: no edge.
        peak = json.loads(self.succeed("period", "long.csv", "--f0", 1.98e-3, "--df", 1e-4, "--nf", 9, "--json"))["peak"]
        self.assertAlmostEqual(peak["period"], 500, delta=5)
        self.assertFalse(peak["at_edge"])


class Phase(ProgramTest):
    def test_its_origin_is_told(self):
        t = 1e6 + numpy.arange(100.0)
        truth = 3 + 2 * numpy.sin(2 * numpy.pi * t / 17.3 + 0.4)
        numpy.savetxt(self.folder / "s.csv", numpy.column_stack([t, truth]), delimiter=",", fmt="%.17g")
        peak = json.loads(self.succeed("period", "s.csv", "--json"))["peak"]
        model = peak["offset"] + peak["amplitude"] * numpy.sin(
            2 * numpy.pi * peak["frequency"] * (t - peak["time_offset"]) + peak["phase"])
        self.assertLess(abs(model - truth).max(), 1e-9)
        self.assertIn(f"phase       {peak['phase']:.4g} rad at t = 1000000\n", self.succeed("period", "s.csv"))


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
        self.assertEqual(self.period("", "%d,%g,%g", lambda t, y, s: (t, y, s)), self.plain)
        self.assertEqual(self.period("sigma,t,y", "%g,%d,%g", lambda t, y, s: (s, t, y)), self.plain)
        self.assertEqual(self.period("k,y,note,t,sigma", "1,%g,x,%d,%g", lambda t, y, s: (y, t, s)), self.plain)
        named = ("--columns", "BJD,RV,err")
        self.assertEqual(self.period("RV,err,BJD", "%g,%g,%d", lambda t, y, s: (y, s, t), *named), self.plain)
        self.assertEqual(self.period("\ufefft,y,sigma", "%d,%g,%g", lambda t, y, s: (t, y, s)), self.plain)

    def test_a_quoted_first_line_is_data(self):
        self.assertEqual(self.period("", '"%d","%g","%g"', lambda t, y, s: (t, y, s)), self.plain)

    def test_refusals(self):
        self.refuse(3, "s.csv:1: has no column z among t,y,sigma", arguments=("period", "s.csv", "--columns", "t,z"))
        numpy.save(self.folder / "s.npy", numpy.ones((9, 2)))
        for name in ("s.csv", "s.npy", "missing.csv"):
            self.refuse(2, "--columns t: must be T,Y or T,Y,SIGMA", arguments=("period", name, "--columns", "t"))
        self.period("", "%d,%g,%g", lambda t, y, s: (t, y, s))
        self.refuse(3, "s.csv:1: has no column names", "(--columns t,y)", arguments=("period", "s.csv", "--columns", "t,y"))


class BadSeries(ProgramTest):
    def test_malformed_files(self):
        """tests/unit/test_series.c has the rules of a line."""
        for text, *expected in (
            ("t,y\n1,2\n2,three\n", "bad.csv:3: y", "three", "finite number"),
            ("0,1\n1,2\0junk\n", 'bad.csv:2: y = "2?junk"', "finite number"),
            ("", "bad.csv: is empty"),
            ("t,y\n", "bad.csv: contains no samples"),
            ("y,when\n1,2\n", "bad.csv:1: has no column t among y,when", "--columns"),
            ("BJD,HJD,RV\n1,2,3\n", "bad.csv:1: has the columns BJD and HJD, which could both be t", "--columns"),
            ("t,y\n" + "".join(f"{k},{k % 7 / 8}\n" for k in range(20)) + "20,-999\n", "bad.csv: y = -999 on line 22",
             "missing value"),
            ("".join(f"{k},7.1\n" for k in range(20)), "bad.csv: ", "not all equal"),
            ("t,y\n1,2\n2,3\n", "bad.csv: has 2 different times", "needs at least five"),
        ):
            with self.subTest(text=text):
                (self.folder / "bad.csv").write_text(text)
                self.refuse(3, *expected, arguments=("period", "bad.csv"))

    def test_space_around_numbers(self):
        rows = [f"{k},{k % 3}" for k in range(9)]
        (self.folder / "plain.csv").write_text("t,y\n" + "".join(row + "\n" for row in rows))
        spaced = "".join(" " + row.replace(",", "\t, ") + " \r\n" for row in rows)
        (self.folder / "spaced.csv").write_bytes((" t , y\r\n  # a comment\r\n \r\n" + spaced).encode())
        self.assertEqual(self.succeed("period", "plain.csv"), self.succeed("period", "spaced.csv"))

    def test_separators(self):
        """White space, tabs, semicolons or commas, recognised by the first line that is not a comment."""
        rows = [(k, k % 3 + 0.25 * (k % 2), 1 + k % 4) for k in range(12)]
        expected = None
        for between in (",", ";", " ", "\t", "  \t ", ", ", " ; "):
            for names in ("", "t{0}y{0}sigma\n"):
                text = "# a b; c, d\n\n" + names.format(between) + "".join(
                    f"{t}{between}{y}{between}{sigma}\n" for t, y, sigma in rows)
                with self.subTest(between=between, names=names):
                    (self.folder / "s.txt").write_text(text)
                    found = self.succeed("period", "s.txt", "--json")
                    expected = expected or found
                    self.assertEqual(found, expected)
                    self.assertEqual(self.run_program("period", "-", "--json", input=text).stdout, expected)
        (self.folder / "named.txt").write_text("  BJD  quality  RV\n" + "".join(f" {t}  ok  {y} \n" for t, y, _ in rows))
        (self.folder / "plain.txt").write_text("".join(f"{t}\t{y}\n" for t, y, _ in rows))
        self.assertEqual(self.succeed("period", "named.txt", "--columns", "BJD,RV"), self.succeed("period", "plain.txt"))

    def test_last_line_without_its_end(self):
        rows = "".join(f"{k},{k % 3 + 0.5}\n" for k in range(9))
        (self.folder / "s.csv").write_text(rows)
        whole = self.run_program("period", "s.csv", "--save-state", "s.tlmp")
        self.assertEqual((whole.returncode, whole.stderr), (0, ""))
        (self.folder / "s.csv").write_text(rows[:-1])
        cut = self.run_program("period", "s.csv")
        self.assertEqual((cut.returncode, cut.stdout), (0, whole.stdout))
        self.assertEqual(cut.stderr, "toliman: warning: s.csv:9: has no newline at its end; its last number may be truncated\n")
        more = self.run_program("period", "-", "--from-state", "s.tlmp", input="9,0.5\n10,1.25")
        self.assertEqual(more.returncode, 0, more.stderr)
        self.assertIn("warning: standard input:2: has no newline at its end", more.stderr)
        done = self.run_program("period", "-", input=rows + "# the end")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_values_that_are_too_small(self):
        rows = "".join(f"{k},{k % 3}e-310\n" for k in range(150))
        done = self.run_program("period", "-", input=rows)
        self.assertEqual(done.returncode, 3)
        self.assertIn("the 150 samples pushed are equal, or differ by less than value_bound = 1e-99 resolves", done.stderr)
        self.assertIn("its minimum is 1e-100: scale smaller values up", done.stderr)

    def test_a_grid_that_needs_more_memory_than_there_is(self):
        (self.folder / "s.csv").write_text("".join(f"{k},{k % 3}\n" for k in range(9)))
        done = subprocess.run([PROGRAM, "period", "s.csv", "--f0", "0.1", "--df", "1e-9", "--nf", str(2**26)],
                              capture_output=True, text=True, cwd=self.folder, timeout=PATIENCE,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31)))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"out of memory: cannot allocate [1-9]\d{9} bytes")

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

    def test_standard_input_that_is_no_series(self):
        done = self.run_program("period", "-", input="t,y\n1,2\n2,three\n")
        self.assertEqual(done.returncode, 3)
        self.assertIn("standard input:3: y", done.stderr)

    def test_few_samples_on_a_given_grid(self):
        (self.folder / "short.csv").write_text("0,1\n1,2\n2,0\n")
        self.refuse(3, "short.csv: ", "five samples",
                    arguments=("period", "short.csv", "--f0", 0.1, "--df", 0.1, "--nf", 3))

    def test_files_that_are_no_text(self):
        numpy.save(self.folder / "f.npy", numpy.ones((9, 4)))
        self.refuse(3, "f.npy: must be a float64 array of shape [samples][2 or 3]", arguments=("period", "f.npy"))

    def test_missing_file_and_bad_options(self):
        self.refuse(3, "none.csv", "No such file", arguments=("period", "none.csv"))
        self.refuse(2, "all three or none", arguments=("period", DATA, "--f0", 1))
        for f0, df, nf, text in (("nan", 1, 5, "f0 = nan: must be finite and at least 0"),
                                 (1, "inf", 5, "df = inf: must be finite and above 0"),
                                 (1, 1, 0, "nf = 0: must be in [1, 67108864]"),
                                 (0, 1, 1, "the grid must have a frequency above 0")):
            self.refuse(2, text, "--f0, --df, --nf: ", arguments=("period", DATA, "--f0", f0, "--df", df, "--nf", nf))
        self.refuse(2, "df = -1", arguments=("period", DATA, "--f0", 1, "--df", -1, "--nf", 5))
        self.refuse(2, "--nf", arguments=("period", DATA, "--nf", "many"))
        self.refuse(6, "no/power.npy", "cannot be written", arguments=("period", DATA, "--power", "no/power.npy"))


if __name__ == "__main__":
    unittest.main()
