"""Tests nuisance functions of the periodogram: the power against 80-digit arithmetic, coefficients, fits and errors
against numpy, a trend that hides a signal."""
import math
import unittest

import numpy
from mpmath import mp, mpf

from package import toliman
from refusal import refused
from toliman import Periodogram

mp.dps = 80
SPAN = 1095


def chebyshev(t, order):
    """Returns T_0 ... T_order on [0, SPAN]."""
    return [mp.chebyt(k, 2 * mpf(float(t)) / SPAN - 1) for k in range(order + 1)]


def exact_powers(t, y, sigma, columns, frequencies, extra=None):
    """Returns the power at each frequency from normal equations in 80 digits; extra: added to their diagonal."""
    weights, y = [mpf(float(s))**-2 for s in sigma], [mpf(float(value)) for value in y]

    def explained(more):
        """Of the sum of squares, by the columns and these."""
        design, extras = [*columns, *more], [*(extra or [0] * len(columns)), 0, 0]
        weighted = [[w * b for w, b in zip(weights, column)] for column in design]
        normal = mp.matrix([[mp.fdot(a, b) for b in design] for a in weighted])
        for i in range(len(design)):
            normal[i, i] += extras[i]
        right = mp.matrix([mp.fdot(a, y) for a in weighted])
        return mp.fdot(right, mp.lu_solve(normal, right))

    null = explained([])
    total = mp.fsum(w * v * v for w, v in zip(weights, y)) - null
    phases = [[2 * mp.pi * frequency * mpf(float(time)) for time in t] for frequency in frequencies]
    return [(explained([list(map(mp.cos, phase)), list(map(mp.sin, phase))]) - null) / total for phase in phases]


def mission(cover=1.0, n=110, seed=1):
    """Returns times with gaps that cover a part of the span, values and sigmas."""
    random = numpy.random.default_rng(seed)
    day = numpy.sort(random.choice(numpy.arange(SPAN), n, replace=False)) + 0.37
    day = day[(day % 365 < 300) | (day % 365 > 355)]
    y = 0.2 * numpy.sin(2 * math.pi * day / 479 + 1) + 0.3 * random.standard_normal(len(day))
    return day * cover, y, 1 / numpy.sqrt(random.uniform(0.3, 1, len(day)))


class Accuracy(unittest.TestCase):
    def worst(self, cover, functions, cycles, large=0.0):
        t, y, sigma = mission(cover)
        x = 2 * t / SPAN - 1
        y = y + large * (0.5 * x * x - 0.3 * x)
        columns = list(zip(*(chebyshev(time, functions - 1) for time in t)))
        df, worst = 1e-5, mpf(0)
        for count in cycles:
            f0 = count / SPAN / cover
            with Periodogram(f0, df, 2, trend=functions - 1, span=(0, SPAN),
                             value_bound=2.0**math.ceil(math.log2(max(abs(y))))) as periodogram:
                periodogram.push_many(t, y, sigma)
                power = periodogram.power()
            frequencies = [mpf(f0) + mpf(df) * k for k in range(2)]
            exact = exact_powers(t, y, sigma, columns, frequencies)
            worst = max(worst, *(abs(mpf(float(p)) - e) for p, e in zip(power, exact)))
        return float(worst)

    # promise: trend-power-has-twelve-digits
    def test_full_span(self):
        for functions in (2, 4, 8):
            self.assertLess(self.worst(1, functions, (0.3, 1, 1.5, 40)), 1e-12, functions)

    def test_trend_of_a_million_signals(self):
        self.assertLess(self.worst(1, 6, (0.3, 3), large=1e6), 1e-12)

    # promise: trend-power-has-twelve-digits
    def test_beginning_of_the_span(self):
        self.assertLess(self.worst(0.1, 6, (0.3, 1, 40)), 1e-12)
        self.assertLess(self.worst(0.03, 6, (0.3, 1, 40)), 1e-9)
        self.assertLess(self.worst(0.03, 3, (0.3, 40)), 1e-12)

    def test_columns_with_priors(self):
        t, y, sigma = mission()
        rows = numpy.column_stack([3 * numpy.cos(t / 58), t * t / SPAN])
        y = y + rows @ [0.3, 1e-3]
        priors = [math.inf, 0.5, 0.2, 1e-3]
        columns = [*zip(*(chebyshev(time, 1) for time in t)), *([mpf(float(v)) for v in row] for row in rows.T)]
        extra = [mpf(0) if math.isinf(s) else mpf(float(1 / s**2)) for s in priors]
        f0, df, nf = 0.4 / SPAN, 0.7 / SPAN, 5
        with Periodogram(f0, df, nf, trend=1, span=(0, SPAN), columns=2, column_bounds=[3, 1095], priors=priors,
                         value_bound=8) as periodogram:
            periodogram.push_many(t, y, sigma, rows=rows)
            power = periodogram.power()
            info = periodogram.info
        self.assertEqual((info.functions, info.free_functions), (4, 1))
        exact = exact_powers(t, y, sigma, columns, [mpf(f0) + mpf(df) * k for k in range(nf)], extra)
        self.assertLess(max(abs(mpf(float(p)) - e) for p, e in zip(power, exact)), 1e-12)


class Fits(unittest.TestCase):
    """A signal, a trend, a column with a prior: everything against plain least squares by numpy."""

    PRIORS = numpy.array([4.0, math.inf, math.inf, 0.4])

    def setUp(self):
        self.t, noise, self.sigma = mission(n=300)
        self.rows = numpy.cos(self.t / 58)[:, None]
        x = 2 * self.t / SPAN - 1
        self.y = (noise + 0.9 * numpy.sin(2 * math.pi * self.t / 121 + 0.4) + 5 + 30 * x - 7 * x * x
                  + 0.5 * self.rows[:, 0])
        self.functions = numpy.column_stack([numpy.polynomial.chebyshev.chebvander(x, 2), self.rows])
        self.periodogram = Periodogram(0.5 / SPAN, 0.1 / SPAN, 600, trend=2, span=(0, SPAN), columns=1,
                                       priors=self.PRIORS, value_bound=64, value_offset=6, sigma_floor=0.5,
                                       time_offset=self.t[0])
        self.periodogram.push_many(self.t, self.y, self.sigma, rows=self.rows)

    def tearDown(self):
        self.periodogram.close()

    def solve(self, columns):
        """Returns coefficients, their covariance and residual of least squares with the priors as rows."""
        free = numpy.isinf(self.PRIORS)
        design = numpy.vstack([columns / self.sigma[:, None],
                               numpy.pad(numpy.diag(1 / self.PRIORS)[~free], ((0, 0), (0, columns.shape[1] - 4)))])
        values = numpy.concatenate([(self.y - 6) / self.sigma, numpy.zeros(2)])
        found = numpy.linalg.lstsq(design, values, rcond=None)[0]
        residual = values - design @ found
        freedom = len(values) - columns.shape[1]
        covariance = numpy.linalg.inv(design.T @ design) * (residual @ residual) / freedom
        return found + 6 * (numpy.arange(len(found)) == 0), covariance, residual @ residual

    def wave(self, frequency):
        phase = 2 * math.pi * frequency * (self.t - self.t[0])
        return numpy.cos(phase), numpy.sin(phase)

    def test_coefficients(self):
        k = 80
        columns = numpy.column_stack([self.functions, *self.wave(self.periodogram.frequency[k])])
        found, covariance, residual = self.solve(columns)
        coefficients, errors = self.periodogram.coefficients(k)
        numpy.testing.assert_allclose(coefficients, found[:4], rtol=1e-9)
        numpy.testing.assert_allclose(errors, numpy.sqrt(numpy.diag(covariance))[:4], rtol=1e-9)
        model = self.periodogram.model(k)
        self.assertAlmostEqual(model.offset, found[0], 9)
        self.assertAlmostEqual(model.amplitude, math.hypot(*found[4:]), 9)
        self.assertAlmostEqual(model.power, 1 - residual / self.solve(self.functions)[2], 12)

    def test_fit(self):
        peak = self.periodogram.fit(self.t, self.y, self.sigma, rows=self.rows)
        cosine, sine = self.wave(peak.frequency)
        found, _, residual = self.solve(numpy.column_stack([self.functions, cosine, sine]))
        self.assertAlmostEqual(peak.power, 1 - residual / self.solve(self.functions)[2], 11)
        self.assertAlmostEqual(peak.amplitude, math.hypot(*found[4:]), 9)
        self.assertAlmostEqual(peak.phase, math.atan2(found[4], found[5]), 8)
        self.assertAlmostEqual(peak.offset, found[0], 8)
        slope = 2 * math.pi * (self.t - self.t[0]) * (found[5] * cosine - found[4] * sine)
        with_slope, covariance, least = self.solve(numpy.column_stack([self.functions, cosine, sine, slope]))
        self.assertLess(abs(with_slope[6]), 1e-6 * math.sqrt(covariance[6, 6]))  # no better frequency
        self.assertAlmostEqual(least, residual, 9)
        self.assertAlmostEqual(peak.frequency_error / math.sqrt(covariance[6, 6]), 1, 7)
        unit = found[4:6] / math.hypot(*found[4:])
        self.assertAlmostEqual(peak.amplitude_error, math.sqrt(unit @ covariance[4:6, 4:6] @ unit), 7)
        self.assertAlmostEqual(1 / peak.frequency, 121, delta=1)

    def test_bootstrap_draws_residuals(self):
        peaks = self.periodogram.bootstrap(self.t, self.y, self.sigma, rows=self.rows, count=100, seed=3)
        self.assertLess(self.periodogram.peak().log10_residual, peaks[0])
        # The values without nuisance functions give the same distribution.
        with Periodogram(0.5 / SPAN, 0.1 / SPAN, 600, sigma_floor=0.5) as plain:
            residual = self.y - self.functions @ self.solve(self.functions)[0]
            plain.push_many(self.t, residual, self.sigma)
            others = plain.bootstrap(self.t, residual, self.sigma, count=100, seed=3)
        self.assertAlmostEqual(numpy.median(peaks), numpy.median(others), delta=0.01)

    def test_trend_without_columns(self):
        with Periodogram(0.5 / SPAN, 0.1 / SPAN, 600, trend=3, span=(0, SPAN), value_bound=64) as periodogram:
            periodogram.push_many(self.t, self.y, self.sigma)
            self.assertAlmostEqual(periodogram.fit(self.t, self.y, self.sigma).period, 121, delta=1)
            self.assertEqual(len(periodogram.coefficients(0)[0]), 4)


class Batch(unittest.TestCase):
    """Archives against the same samples in a streaming periodogram."""

    def setUp(self):
        random = numpy.random.default_rng(2)
        self.t = numpy.sort(random.uniform(0, SPAN, 400))
        self.sigma = random.uniform(0.5, 1.5, 400)
        self.rows = numpy.column_stack([numpy.cos(self.t / 58), 2 * numpy.sin(self.t / 91)])
        self.y = (3 + 20 * self.t / SPAN + self.rows @ [0.5, -1] + 0.7 * numpy.sin(0.232 * self.t)
                  + self.sigma * random.normal(size=400))

    def check_batch(self, trend, rows, priors, tolerances=(1e-3, 1e-6, 1e-9, 1e-12)):
        columns = 0 if rows is None else rows.shape[1]
        grid = (0.3 / SPAN, 0.1 / SPAN, 700)
        with Periodogram(*grid, trend=trend, span=(0, SPAN) if trend else None, columns=columns, priors=priors,
                         column_bounds=[2] * columns, value_bound=64, sigma_floor=0.5) as periodogram:
            periodogram.push_many(self.t, self.y, self.sigma, rows=rows)
            exact = periodogram.power()
        for tolerance in tolerances:
            power = toliman.batch(self.t, self.y, self.sigma, **dict(zip(("f0", "df", "nf"), grid)), trend=trend, rows=rows, priors=priors,
                                  span=(0, SPAN) if trend and priors is not None else None, tolerance=tolerance)
            self.assertLessEqual(abs(power - exact).max(), tolerance)

    def test_trend(self):
        self.check_batch(4, None, None)
        self.check_batch(8, None, None, (1e-9,))

    def test_columns(self):
        self.check_batch(0, self.rows, None)
        self.check_batch(3, self.rows, None)

    def test_priors_need_sigmas(self):
        given = {"columns": 1, "priors": [math.inf, 0.5]}
        rows = numpy.ones((5, 1))
        with Periodogram(0.01, 0.01, 5, **given) as p:
            with refused(toliman.InputError, "sigma"):
                p.push_many([0, 1, 2, 3, 5], [0, 1, 0, 2, 1], rows=rows)
            with refused(toliman.InputError, "sigma"):
                p.push(0, 1, rows=[1])
            self.assertEqual(len(p), 0)
        with refused(toliman.InputError, "sigma"):
            toliman.batch([0, 1, 2, 3, 5], [0, 1, 0, 2, 1], f0=0.01, df=0.01, nf=5, rows=rows, priors=[math.inf, 0.5])

    def test_goodness_of_a_fit(self):
        """Against least squares in numpy; the prior is one more observation."""
        random = numpy.random.default_rng(1)
        n, sigma = 90, 0.2
        t = numpy.sort(random.uniform(0, 100, n))
        rows = numpy.cos(t / 30)[:, None]
        y = 3 + numpy.sin(0.5 * t) + 0.7 * rows[:, 0] + sigma * random.normal(size=n)
        for factor, far, word in (1, 0, "good"), (1.5, 0, "poor"), (1, 4, "poor"), (0.5, 0, "too good"):
            values = y + far * (numpy.arange(n) == 40)
            with Periodogram(0.02, 0.002, 100, columns=1, priors=[math.inf, 0.5], sigma_floor=0.05, double_limb=True) as p:
                p.push_many(t, values, sigma / factor, rows=rows)
                peak, unknown = p.fit(t, values, sigma / factor, rows=rows), p.peak()
            wave = 2 * math.pi * peak.frequency * t
            design = numpy.column_stack([numpy.ones(n), rows, numpy.cos(wave), numpy.sin(wave)]) / sigma * factor
            design = numpy.vstack([design, [0, 2, 0, 0]])
            data = numpy.append(values / sigma * factor, 0)
            left = data - design @ numpy.linalg.lstsq(design, data, rcond=None)[0]
            self.assertAlmostEqual(peak.chi_square / (left @ left / (n + 1 - 5)), 1, delta=1e-5)
            self.assertAlmostEqual(peak.chi_square_sigma, math.sqrt(2 * (n + 1)) / (n + 1 - 5), delta=1e-9)
            self.assertAlmostEqual(peak.largest_residual / abs(left[:n]).max(), 1, delta=1e-4)
            self.assertEqual((peak.goodness, peak.outliers), (word, int(far > 0)))
            self.assertTrue(math.isnan(unknown.chi_square) and unknown.goodness == "unknown")

    def test_priors(self):
        self.check_batch(0, None, [2.0])
        self.check_batch(3, self.rows, [3, math.inf, 0.5, 0.2, 0.3, 0.1])

    def test_dependent_columns_are_left_out(self):
        twice = numpy.column_stack([self.rows, self.rows[:, 0]])
        grid = (0.3 / SPAN, 0.1 / SPAN, 700)
        powers = [toliman.batch(self.t, self.y, self.sigma, **dict(zip(("f0", "df", "nf"), grid)), trend=2, rows=rows) for rows in (self.rows, twice)]
        self.assertLess(abs(powers[0] - powers[1]).max(), 2e-9)

    def test_refusals(self):
        def check(name, error=toliman.Error, **options):
            with refused(error, name):
                toliman.batch(self.t, self.y, self.sigma, f0=0.01, df=0.01, nf=20, **options)

        check("t", trend=2, span=(0, 500))
        check("columns", trend=6, rows=self.t[:, None] * numpy.ones(27))
        check("rows", rows=numpy.full((400, 1), math.inf))
        check("flags", trend=1, fit_mean=False)
        check("rows", ValueError, rows=self.rows[1:])


if __name__ == "__main__":
    unittest.main()
