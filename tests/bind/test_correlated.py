"""Periodograms with correlated noise from Python, against dense generalised least squares in numpy."""
import unittest

import numpy

from package import toliman
from refusal import refused


def series(n=120, rho=0.6, seed=2):
    random = numpy.random.default_rng(seed)
    t = numpy.cumsum(random.uniform(0.5, 1.5, n))
    sigma = random.uniform(0.5, 1.5, n)
    x, y = 0.0, numpy.empty(n)
    for i in range(n):
        phi = rho ** (t[i] - t[i - 1]) if i else 0
        x = phi * x + numpy.sqrt(1 - phi**2) * random.normal()
        y[i] = sigma[i] * x
    return t, y + 3 + 0.9 * numpy.sin(0.8 * t), sigma


def solved(design, y, covariance):
    """Coefficients, residual sum of squares and normal matrix."""
    inverse = numpy.linalg.inv(covariance)
    normal = design.T @ inverse @ design
    x = numpy.linalg.solve(normal, design.T @ inverse @ y)
    rest = y - design @ x
    return x, rest @ inverse @ rest, normal


class Correlated(unittest.TestCase):
    def setUp(self):
        self.t, self.y, self.sigma = series()
        self.functions = numpy.c_[numpy.linspace(-1, 1, 120), numpy.linspace(-1, 1, 120) ** 2]

    def covariance(self, rho, step):
        gap = abs(self.t[:, None] - self.t) / step
        return rho**gap * self.sigma[:, None] * self.sigma

    def design(self, frequency=None):
        columns = [numpy.ones(120), *self.functions.T]
        if frequency is not None:
            phase = 2 * numpy.pi * frequency * self.t
            columns += [numpy.cos(phase), numpy.sin(phase)]
        return numpy.array(columns).T

    def test_against_numpy(self):
        grid = toliman.suited_grid(self.t)
        found, power, coefficients, errors = toliman.search_correlated(self.t, self.y, self.sigma,
                                                                       functions=self.functions)
        covariance = self.covariance(found.rho, found.step)
        null = solved(self.design(), self.y, covariance)[1]
        for k in range(0, grid.nf, 29):
            rest = solved(self.design(grid.f0 + k * grid.df), self.y, covariance)[1]
            self.assertAlmostEqual(power[k], 1 - rest / null, delta=1e-10)
        self.assertEqual(power.argmax(), found.index)
        x, rest, normal = solved(self.design(found.frequency), self.y, covariance)
        numpy.testing.assert_allclose(coefficients, x[1:3], rtol=1e-6)
        deviation = numpy.sqrt(numpy.diag(numpy.linalg.inv(normal)) * rest / (120 - 5))
        numpy.testing.assert_allclose(errors, deviation[1:3], rtol=1e-6)
        self.assertAlmostEqual(found.offset_error, deviation[0], delta=1e-6)
        self.assertAlmostEqual(found.amplitude, numpy.hypot(x[3], x[4]), delta=1e-7)
        direction = x[3:] / found.amplitude
        spread = numpy.linalg.inv(normal)[3:, 3:] * rest / (120 - 5)
        self.assertAlmostEqual(found.amplitude_error, numpy.sqrt(direction @ spread @ direction), delta=1e-7)
        across = numpy.array([-direction[1], direction[0]])
        self.assertAlmostEqual(found.phase_error * found.amplitude, numpy.sqrt(across @ spread @ across), delta=1e-7)
        self.assertIn("NoiseSearch(period=", repr(found))

    def test_signal_is_not_taken_for_noise(self):
        found = toliman.search_correlated(self.t, self.y, self.sigma)[0]
        self.assertAlmostEqual(found.period, 2 * numpy.pi / 0.8, delta=4 * found.period_error)
        self.assertLess(found.log10_fap, -2)
        self.assertLess(found.log10_p_white, -3)
        white = toliman.search_correlated(self.t, self.y, self.sigma, white=True)[0]
        self.assertEqual((white.rho, white.tau, white.log10_p_white), (0, 0, found.log10_p_white))
        peak = toliman.period(self.t, self.y, self.sigma)
        self.assertAlmostEqual(white.period, peak.period, delta=1e-5)

    def test_bootstrap(self):
        found = toliman.search_correlated(self.t, self.y, self.sigma)[0]
        peaks = toliman.bootstrap_correlated(self.t, self.y, self.sigma, rho=found.rho, count=50, threads=2)
        again = toliman.bootstrap_correlated(self.t, self.y, self.sigma, rho=found.rho, count=50, threads=1)
        numpy.testing.assert_array_equal(peaks, again)
        self.assertLess(found.log10_residual, peaks[2])

    def test_refusals(self):
        with refused(ValueError, "functions"):
            toliman.search_correlated(self.t, self.y, functions=[1, 2, 3])
        with refused(ValueError, "precision"):
            toliman.search_correlated(self.t, self.y, functions=self.functions, precision=[1.0])
        with self.assertRaises(toliman.Cancelled):
            toliman.search_correlated(self.t, self.y, progress=lambda stage, fraction: True)


if __name__ == "__main__":
    unittest.main()
