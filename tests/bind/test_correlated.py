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


class Correlated(unittest.TestCase):
    def setUp(self):
        self.t, self.y, self.sigma = series()
        self.functions = numpy.c_[numpy.linspace(-1, 1, 120), numpy.linspace(-1, 1, 120) ** 2]

    def test_with_functions(self):
        """Against numpy, with the correlation that was found. More frequencies and the errors: tests/unit/test_period_noise.c."""
        grid = toliman.suited_grid(self.t)
        found, power, coefficients, errors = toliman.search_correlated(self.t, self.y, self.sigma, functions=self.functions)
        covariance = found.rho ** (abs(self.t[:, None] - self.t) / found.step) * self.sigma[:, None] * self.sigma
        phase = 2 * numpy.pi * found.frequency * self.t
        design = numpy.c_[numpy.ones(120), self.functions, numpy.cos(phase), numpy.sin(phase)]
        whitened = numpy.linalg.inv(numpy.linalg.cholesky(covariance))
        x, (rest,), _, _ = numpy.linalg.lstsq(whitened @ design, whitened @ self.y, rcond=None)
        _, (null,), _, _ = numpy.linalg.lstsq(whitened @ design[:, :3], whitened @ self.y, rcond=None)
        self.assertEqual((power.argmax(), len(power)), (found.index, grid.nf))
        self.assertAlmostEqual(power[found.index], 1 - rest / null, delta=1e-4)  # between frequencies of the grid
        numpy.testing.assert_allclose(coefficients, x[1:3], rtol=1e-6)
        normal = numpy.linalg.inv((whitened @ design).T @ (whitened @ design)) * rest / 115
        numpy.testing.assert_allclose(errors, numpy.sqrt(numpy.diag(normal))[1:3], rtol=1e-6)

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
