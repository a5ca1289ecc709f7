"""toliman period with functions that are fitted with the mean, against least squares by numpy, and with correlated noise."""
import json
import unittest

import numpy
from program import ProgramTest

F0, DF, NF = 1e-3, 2e-4, 200
GRID = ("--f0", F0, "--df", DF, "--nf", NF)
FREQUENCY = F0 + DF * numpy.arange(NF)


def chebyshev(t, order, start=None, end=None):
    """T_1 ... T_order over the span of t, or over another one: [n][order]."""
    start, end = (t.min(), t.max()) if start is None else (start, end)
    return numpy.polynomial.chebyshev.chebvander((2 * t - start - end) / (end - start), order)[:, 1:]


def solved(columns, y, sigma, prior=()):
    """Coefficients, their covariance and the residual of weighted least squares. prior: standard deviation of the last
    columns, each a pseudo-observation of 0; inf is none."""
    s = numpy.r_[numpy.full(columns.shape[1] - len(prior), numpy.inf), prior]
    matrix = numpy.vstack([columns / sigma[:, None], numpy.diag(1 / s)])
    right = numpy.r_[y / sigma, numpy.zeros(len(s))]
    found = numpy.linalg.lstsq(matrix, right, rcond=None)[0]
    return found, numpy.linalg.inv(matrix.T @ matrix), ((matrix @ found - right) ** 2).sum()


class Reference:
    """Power and coefficients of mean, functions and sinusoid."""

    def __init__(self, t, y, sigma, functions, prior=()):
        self.t, self.y, self.sigma = t, y, sigma
        self.prior = tuple(prior) if len(prior) else (numpy.inf,) * functions.shape[1]
        self.base = numpy.column_stack([numpy.ones_like(t), functions])
        self.alone = solved(self.base, y, sigma, self.prior)[2]

    def at(self, frequency):
        angle = 2 * numpy.pi * frequency * (self.t - self.t[0])
        wave = numpy.column_stack([numpy.cos(angle), numpy.sin(angle)])
        return solved(numpy.column_stack([wave, self.base]), self.y, self.sigma, self.prior)

    def power(self, frequency):
        return 1 - self.at(frequency)[2] / self.alone

    def powers(self):
        return numpy.array([self.power(f) for f in FREQUENCY])


class Nuisance(ProgramTest):
    def period(self, *arguments):
        return json.loads(self.succeed("period", *arguments, "--json"))

    def write(self, t, *columns, name="s.csv"):
        head = ",".join(["t", "y", "sigma"][:1 + len(columns)])
        numpy.savetxt(self.folder / name, numpy.column_stack([t, *columns]), delimiter=",", fmt="%.17g", header=head,
                      comments="")

    def trending(self, n=200, seed=1):
        """A signal of period 120 under a cubic that is 20 times larger."""
        random = numpy.random.default_rng(seed)
        t = numpy.sort(random.uniform(5000, 6000, n))
        x, sigma = (t - 5500) / 500, random.uniform(0.3, 0.6, n)
        y = 0.5 * numpy.sin(2 * numpy.pi * t / 120) + 9 * x**3 + 3 * x**2 + sigma * random.normal(size=n)
        self.write(t, y, sigma)
        return t, y, sigma

    def check_coefficients(self, found, reference, names, free):
        """At the refined frequency; errors are scaled by the residual."""
        best, covariance, residual = reference.at(found["peak"]["frequency"])
        functions = found["functions"]
        self.assertEqual((functions["in_use"], functions["free"]), (len(names), free))
        self.assertEqual([one["name"] for one in functions["coefficients"]], names)
        scale = numpy.sqrt(residual / (len(reference.t) - free - 2))
        for i, one in enumerate(functions["coefficients"], 2):
            self.assertAlmostEqual(one["value"], best[i], delta=1e-8 * abs(best[i]) + 1e-12)
            self.assertAlmostEqual(one["error"], scale * numpy.sqrt(covariance[i, i]), delta=1e-6 * one["error"])
        self.assertAlmostEqual(found["peak"]["amplitude"], numpy.hypot(best[0], best[1]), delta=1e-8)


class Trend(Nuisance):
    def test_a_trend_hides_a_signal(self):
        t, y, sigma = self.trending()
        alone = self.period("s.csv", *GRID)
        self.assertTrue(alone["peak"]["long_period"])
        self.assertNotIn("functions", alone)
        self.assertEqual(self.period("s.csv", *GRID, "--trend", 0), alone)
        found = self.period("s.csv", *GRID, "--trend", 3, "--power", "power.npy")
        self.assertAlmostEqual(found["peak"]["period"], 120, delta=2)
        self.assertFalse(found["peak"]["long_period"])
        reference = Reference(t, y, sigma, chebyshev(t, 3))
        numpy.testing.assert_allclose(numpy.load(self.folder / "power.npy"), reference.powers(), rtol=0, atol=1e-10)
        self.check_coefficients(found, reference, ["mean", "T1", "T2", "T3"], 4)
        self.assertIn("warning: ", self.run_program("period", "s.csv", *GRID).stderr)  # by the trend
        done = self.run_program("period", "s.csv", *GRID, "--trend", 3)
        self.assertEqual(done.stderr, "")
        text = done.stdout
        self.assertRegex(text, r"\nfunctions   4 in use, 4 free\n  mean +[-\d.]+ \+- [\d.]+\n  T1 ")

    def test_dates(self):
        """A span in dates, MJD and JD of UTC is converted as the times of the series are."""
        t, y, _ = self.trending(n=40)
        days = (t - t.min()).round(3)
        stamps = numpy.datetime64("2027-01-01T00:00:00.000") + (days * 86400000).astype("m8[ms]")
        lines = [f"{stamp},{value!r}" for stamp, value in zip(stamps, y.tolist())]
        (self.folder / "dates.csv").write_text("t,y\n" + "\n".join(lines) + "\n")
        found = [self.period("dates.csv", *GRID, "--trend", 2, "--span", span)["functions"]
                 for span in ("2027-01-01,2030-01-01T12:00:00", "61406,2462503.0", "2461406.5,62502.5")]
        self.assertEqual(found[1], found[0])
        self.assertEqual(found[2], found[0])
        start = 61406 + 37 / 86400  # TAI
        reference = Reference(start + days, y, numpy.ones(40), chebyshev(start + days, 2, start, 62502.5 + 37 / 86400))
        best = reference.at(self.period("dates.csv", *GRID, "--trend", 2, "--span", "61406,62502.5")["peak"]["frequency"])[0]
        numpy.testing.assert_allclose([one["value"] for one in found[0]["coefficients"]], best[2:], rtol=1e-4)

    # promise: saved-sums-continue
    def test_sums_are_continued(self):
        """Saved with a trend and continued by plain samples: the bits of all at once, which begin with the same sample."""
        t, y, sigma = self.trending()
        for name, part in (("all.csv", slice(None)), ("first.csv", slice(100)), ("rest.csv", slice(100, None))):
            self.write(t[part], y[part], sigma[part], name=name)
        how = (*GRID, "--trend", 4, "--span", "4900,6100", "--sigma-floor", 0.1, "--sigma-ceiling", 1)
        for name in ("all", "first"):
            lines = self.succeed("period", f"{name}.csv", *how, "--follow", "--save-state", f"{name}.tlmp").splitlines()
            self.assertGreater(len(lines), 80)
        self.succeed("period", "rest.csv", "--from-state", "first.tlmp", "--save-state", "two.tlmp", "--power", "two.npy")
        self.assertEqual((self.folder / "two.tlmp").read_bytes(), (self.folder / "all.tlmp").read_bytes())
        reference = Reference(t, y, sigma, chebyshev(t, 4, 4900, 6100))
        numpy.testing.assert_allclose(numpy.load(self.folder / "two.npy"), reference.powers(), rtol=0, atol=1e-10)
        found = self.period("--from-state", "two.tlmp")["functions"]  # at the nearest frequency of the grid
        self.assertEqual([one["name"] for one in found["coefficients"]], ["mean", "T1", "T2", "T3", "T4"])
        best = reference.at(FREQUENCY[reference.powers().argmax()])[0][2:]
        numpy.testing.assert_allclose([one["value"] for one in found["coefficients"]], best, rtol=1e-8)
        # Also sums of the whole series, with margins for later samples.
        self.succeed("period", "first.csv", *how[:-4], "--save-state", "whole.tlmp")
        self.succeed("period", "rest.csv", "--from-state", "whole.tlmp", "--power", "whole.npy")
        numpy.testing.assert_allclose(numpy.load(self.folder / "whole.npy"), reference.powers(), rtol=0, atol=1e-10)

    def test_refusals(self):
        t, y, sigma = self.trending(n=30)
        self.write(numpy.full(5, 3.0), y[:5], name="equal.csv")
        (self.folder / "dates.csv").write_text("t,y\n2027-01-01,1\n2027-01-03,2\n")
        self.succeed("period", "s.csv", *GRID, "--trend", 1, "--span", "5000,6000", "--save-state", "s.tlmp")
        (self.folder / "late.csv").write_text("t,y,sigma\n6001,0,0.5\n")
        self.refuse_all(
            (2, "--trend 3: --save-state", "s.csv", "--trend", 3, "--save-state", "x.tlmp"),
            (2, "--trend 3: --follow", "s.csv", "--trend", 3, "--follow", *GRID),
            (2, "--span 1,2: ", "s.csv", "--span", "1,2"), (2, "--trend 9: ", "s.csv", "--trend", 9),
            *((2, "--span " + named, "s.csv", "--trend", 1, "--span", span)
                for named, span in (("5: ", "5"), ("6000,5000: ", "6000,5000"), ("2027-01-01: ", "2027-01-01,1"))),
            (2, "--span 2027-13-01: ", "dates.csv", *GRID, "--trend", 1, "--span", "2027-13-01,2028-01-01"),
            (3, "s.csv: sample 1: t = 50", "s.csv", "--trend", 1, "--span", "5900,6100"),
            (3, "late.csv:2: t = 6001: ", "late.csv", "--from-state", "s.tlmp"),
            (3, "equal.csv: ", "equal.csv", *GRID, "--trend", 1),
            (2, "--trend ", "late.csv", "--from-state", "s.tlmp", "--trend", 1),
            (2, "--fixed-mean ", "s.csv", "--trend", 1, "--fixed-mean"), command=("period",))


class Columns(Nuisance):
    def with_columns(self, n=120, seed=4):
        """A signal of period 90 under a temperature and a pressure."""
        random = numpy.random.default_rng(seed)
        t = numpy.sort(random.uniform(0, 900, n))
        values = numpy.column_stack([20 + 3 * numpy.sin(2 * numpy.pi * t / 700 + 1), random.normal(size=n)])
        sigma = random.uniform(0.3, 0.6, n)
        y = 0.6 * numpy.sin(2 * numpy.pi * t / 90) + values @ [2.5, -0.7] + sigma * random.normal(size=n)
        self.write(t, y, sigma)
        self.write_columns(t, values)
        return t, y, sigma, values

    def write_columns(self, t, values, head="t,temperature,pressure", name="c.csv"):
        numpy.savetxt(self.folder / name, numpy.column_stack([t, values]), delimiter=",", fmt="%.17g", header=head, comments="")

    def test_columns_and_trend(self):
        t, y, sigma, values = self.with_columns()
        self.assertGreater(abs(self.period("s.csv", *GRID)["peak"]["period"] - 90), 100)
        found = self.period("s.csv", *GRID, "--nuisance-file", "c.csv", "--power", "power.npy")
        self.assertAlmostEqual(found["peak"]["period"], 90, delta=2)
        reference = Reference(t, y, sigma, values)
        numpy.testing.assert_allclose(numpy.load(self.folder / "power.npy"), reference.powers(), rtol=0, atol=1e-10)
        self.check_coefficients(found, reference, ["mean", "temperature", "pressure"], 3)
        found = self.period("s.csv", *GRID, "--nuisance-file", "c.csv", "--trend", 2)
        reference = Reference(t, y, sigma, numpy.column_stack([chebyshev(t, 2), values]))
        self.check_coefficients(found, reference, ["mean", "T1", "T2", "temperature", "pressure"], 5)

    def test_priors(self):
        """Functions with one do not count as free; tests/bind/test_nuisance.py has the numbers."""
        self.with_columns()
        how = ("s.csv", *GRID, "--nuisance-file", "c.csv", "--trend", 1, "--prior", "temperature=0.02,T1=0.5")
        functions = self.period(*how)["functions"]
        self.assertEqual((functions["in_use"], functions["free"]), (4, 2))
        priors = [one["prior_sigma"] for one in functions["coefficients"]]
        numpy.testing.assert_allclose([priors[1], priors[2]], [0.5, 0.02], rtol=1e-14)
        self.assertEqual([priors[0], priors[3]], [None, None])
        self.assertIn(", prior +- 0.02\n", self.succeed("period", *how))

    def test_a_column_that_is_not_determined(self):
        """A combination of the others is left out."""
        t, y, sigma, values = self.with_columns()
        self.write_columns(t, numpy.column_stack([values, values @ [1, 2]]), "t,a,b,c")
        found = self.period("s.csv", *GRID, "--nuisance-file", "c.csv")["functions"]
        self.assertEqual((found["in_use"], found["free"]), (3, 3))
        self.assertEqual([one["error"] is None for one in found["coefficients"]], [False, False, False, True])
        self.assertIn("\n  c                 not in use\n", self.succeed("period", "s.csv", *GRID, "--nuisance-file", "c.csv"))

    def test_correlated_noise(self):
        """Of AR(1), with functions; tests/bind/test_correlated.py has the numbers."""
        t, y, sigma, values = self.with_columns(n=150)
        random = numpy.random.default_rng(6)
        error = random.normal(size=150)
        for i in range(1, 150):
            rho = numpy.exp(-(t[i] - t[i - 1]) / 20)
            error[i] = rho * error[i - 1] + numpy.sqrt(1 - rho**2) * error[i]
        how = ("--nuisance-file", "c.csv", "--trend", 1, "--prior", "pressure=2")
        y = y + 4 * sigma * error
        self.write(t, y, sigma)
        found = self.period("s.csv", *GRID, *how, "--noise", "ar1")
        noise, peak = found["noise"], found["noise"]["peak"]
        self.assertGreater(noise["rho"], 0.1)
        self.assertEqual([one["name"] for one in found["functions"]["coefficients"]], ["mean", "T1", "temperature", "pressure"])
        self.assertEqual(peak["fap_method"], "baluev")
        drawn = self.period("s.csv", *GRID, *how, "--noise", "ar1", "--fap", "bootstrap", "--resamplings", 99)["noise"]["peak"]
        self.assertEqual(drawn["fap_method"], "bootstrap")
        self.assertLess(abs(drawn["log10_fap"] - max(-2, peak["log10_fap"])), 0.7)

    def test_refusals(self):
        t, y, sigma, values = self.with_columns(n=20)
        self.write(t, y, name="plain.csv")
        self.succeed("period", "s.csv", *GRID, "--nuisance-file", "c.csv", "--save-state", "c.tlmp")
        names = [one["name"] for one in self.period("--from-state", "c.tlmp")["functions"]["coefficients"]]
        self.assertEqual(names, ["mean", "column 1", "column 2"])  # sums do not contain their names
        lines = (self.folder / "c.csv").read_text().splitlines()
        last = lines[-1]
        for message, changed in (
                ("c.csv: ", lines[:-1]), ("c.csv:22: ", lines + [last]),
                (f"c.csv:2: t = {t[1]:.17g}: ", [lines[0], *lines[2:]]),
                ("c.csv:21: pressure = nan: ", lines[:-1] + [last.rpartition(",")[0] + ",nan"]),
                ("c.csv:21: pressure = x: ", lines[:-1] + [last.rpartition(",")[0] + ",x"]),
                ("c.csv:21: ", lines[:-1] + [last.rpartition(",")[0]]),
                ('c.csv:22: t = "x": ', ["# comment", *lines[:-1], "x" + last[last.index(","):]]),
                ("c.csv:1: ", lines[1:]),
                *((f'c.csv:1: "{name}"', [f"t,{name},b", *lines[1:]]) for name in ("sigma", "factor", "T3", "")),
                ("c.csv:1: ", ["t,b,b", *lines[1:]]), ("c.csv: ", ["# nothing"])):
            with self.subTest(message):
                (self.folder / "c.csv").write_text("\n".join(changed) + "\n")
                self.refuse(3, message, arguments=("period", "s.csv", *GRID, "--nuisance-file", "c.csv"))
        (self.folder / "c.csv").write_text("\n".join(lines) + "\n")
        file = ("--nuisance-file", "c.csv")
        many = ["t," + ",".join(f"c{k}" for k in range(33))] + [line.split(",")[0] + ",1" * 33 for line in lines[1:]]
        (self.folder / "many.csv").write_text("\n".join(many) + "\n")
        self.refuse_all(
            (3, "s.csv: ", "s.csv", "--nuisance-file", "many.csv"),
            (3, "missing.csv: ", "s.csv", "--nuisance-file", "missing.csv"),
            (3, "c.tlmp: ", "s.csv", "--nuisance-file", "c.tlmp"),
            (2, "--prior x: ", "s.csv", *file, "--trend", 1, "--prior", "x=1"),
            *((2, f"--prior {named}: ", "s.csv", "--trend", 2, "--prior", given)
                for named, given in (("T2=0", "T2=0"), ("T2", "T2"), ("T2=2", "T2=1,T2=2"))),
            (2, "--prior: ", "s.csv", "--prior", "T2=1"),
            (3, "plain.csv: ", "plain.csv", "--trend", 1, "--prior", "T1=1"),
            (3, "c.tlmp: ", "s.csv", "--from-state", "c.tlmp"), (2, "--fixed-mean ", "s.csv", *file, "--fixed-mean"),
            (2, "--nuisance-file ", "s.csv", *file, "--follow", *GRID), command=("period",))


class Flags(Nuisance):
    def test_long_and_annual(self):
        """Periods above half the time span, and near a year; plain numbers are taken as days."""
        t = 61406 + numpy.arange(0, 1000, 4.0)
        random = numpy.random.default_rng(2)
        noise = 0.1 * random.normal(size=len(t))
        for truth, long, annual in ((700, True, False), (372, False, True), (250, False, False)):
            self.write(t, numpy.sin(2 * numpy.pi * t / truth) + noise, name="s.csv")
            text = (self.folder / "s.csv").read_text()
            (self.folder / "s.csv").write_text(text.replace("t,", "mjd,", 1))
            done = self.run_program("period", "s.csv", *GRID, "--json", "--peaks", 2)
            found = json.loads(done.stdout)
            self.assertEqual((found["peak"]["long_period"], found["peak"]["annual"]), (long, annual))
            self.assertEqual((found["peaks"][0]["long_period"], found["peaks"][0]["annual"]), (long, annual))
            self.assertEqual(("half the time span" in done.stderr, "of a year" in done.stderr), (long, annual), done.stderr)
            line = self.succeed("period", "s.csv", *GRID).splitlines()[0]
            self.assertEqual((line.endswith(", long period"), line.endswith(", annual")), (long, annual))
            self.succeed("period", "s.csv", *GRID, "--save-state", "s.tlmp")
            found = json.loads(self.succeed("period", "--from-state", "s.tlmp", "--json"))["peak"]
            self.assertEqual((found["long_period"], found["annual"]), (long, annual))
        self.write(t - t[0], numpy.sin(2 * numpy.pi * t / 365.25) + noise)
        self.assertTrue(self.period("s.csv", *GRID)["peak"]["annual"])


def correlated(rho, signal=0.0):
    """A series of AR(1) noise with a signal of 20 days."""
    random = numpy.random.default_rng(4)
    y = numpy.zeros(300)
    for i in range(300):
        y[i] = (rho * y[i - 1] if i else 0) + numpy.sqrt(1 - rho**2 if i else 1) * random.normal()
    t = numpy.arange(300.0)
    return numpy.c_[t, y + signal * numpy.sin(2 * numpy.pi * t / 20)]


class CorrelatedNoise(ProgramTest):
    def saved(self, series):
        numpy.savetxt(self.folder / "series.csv", series, delimiter=",", header="t,y", comments="")
        return "series.csv"

    def test_correlated_series(self):
        file = self.saved(correlated(0.7))
        plain = self.run_program("period", file, "--json")
        self.assertEqual((plain.returncode, "--noise ar1" in plain.stderr), (0, True), plain.stderr)
        white = json.loads(plain.stdout)
        self.assertLess(white["peak"]["log10_fap"], -2)
        self.assertEqual(white["noise"]["model"], "white")
        fitted = self.run_program("period", file, "--json", "--noise", "ar1")
        self.assertNotIn("--noise", fitted.stderr)
        noise = json.loads(fitted.stdout)["noise"]
        self.assertAlmostEqual(noise["rho"], 0.7, delta=4 * noise["rho_error"])
        self.assertAlmostEqual(noise["rho_error"], numpy.sqrt((1 - noise["rho"]**2) / 300), delta=0.01)
        self.assertAlmostEqual(noise["tau"], -1 / numpy.log(noise["rho"]), delta=1e-9)
        self.assertEqual(noise["log10_p_white"], white["noise"]["log10_p_white"])
        self.assertLess(noise["log10_p_white"], -20)
        self.assertGreater(noise["peak"]["log10_fap"], -2)
        text = self.succeed("period", file, "--noise", "ar1")
        self.assertRegex(text, rf"(?s)ar1: \D*{noise['rho']:.3f} \+- {noise['rho_error']:.2g} .*\nwith ar1    period ")

    def test_signal_in_correlated_noise(self):
        file = self.saved(correlated(0.5, signal=1.0))
        peak = json.loads(self.succeed("period", file, "--json", "--noise", "ar1"))["noise"]["peak"]
        self.assertLess(peak["log10_fap"], -6)
        self.assertAlmostEqual(peak["period"], 20, delta=4 * peak["period_error"])
        self.assertAlmostEqual(peak["amplitude"], 1, delta=4 * peak["amplitude_error"])

    def test_white_series_and_refusals(self):
        plain = self.run_program("period", self.saved(correlated(0)), "--json")
        self.assertNotIn("--noise", plain.stderr)
        self.assertGreater(json.loads(plain.stdout)["noise"]["log10_p_white"], -3)
        series = correlated(0.5)
        series[7, 0] = series[6, 0]
        file = self.saved(series)
        self.assertNotIn("noise", json.loads(self.succeed("period", file, "--json")))
        self.refuse_all(
            (3, "sample 7: t = 6: ", "ar1"), (2, "--noise", "ar1", "--fixed-mean"), (2, "--noise", "pink"),
            command=("period", file, "--noise"))


if __name__ == "__main__":
    unittest.main()
