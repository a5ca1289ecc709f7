"""Tests false alarm probabilities from Python against astropy's and scipy's own functions."""
import math
import unittest

import numpy
from astropy.timeseries import LombScargle
from astropy.timeseries.periodograms.lombscargle import _statistics as astropy
from scipy import stats

from package import toliman
from refusal import refused

DAYS = 300
t = numpy.arange(float(DAYS))
y = numpy.random.default_rng(1).standard_normal(DAYS)
GRID = {"f0": 1.5 / DAYS, "df": 0.1 / DAYS, "nf": 5 * DAYS - 14}
LAST = GRID["f0"] + GRID["df"] * (GRID["nf"] - 1)


class Fap(unittest.TestCase):
    def made(self, count=DAYS):
        periodogram = toliman.Periodogram(**GRID)
        self.addCleanup(periodogram.close)
        periodogram.push_many(t[:count], y[:count])
        return periodogram

    def test_against_astropy(self):
        """Calls astropy's functions directly: called through LombScargle, they round the last frequency to a grid
        of their own."""
        for count in (5, 6, 40, DAYS):
            times, sigma, periodogram = t[:count], numpy.ones(count), self.made(count)
            last = LAST * math.sqrt(count**2 - 1) / (count - 1)  # its time span is one step shorter
            for power in (0.001, 0.01, 0.05, 0.1, 0.3, 0.6):
                expected = {
                    "baluev": astropy.fap_baluev(power, LAST, times, None, sigma),
                    "naive": astropy.fap_naive(power, last, times, None, sigma),
                    "single": astropy.fap_single(power, count, "standard"),
                }
                for method, value in expected.items():
                    found = 10 ** periodogram.log10_fap(math.log10(1 - power), method)
                    self.assertAlmostEqual(found / value, 1, delta=1e-11 + 1e-14 / value, msg=(count, method, power))

    def test_thresholds_against_astropy(self):
        for method in ("baluev", "naive", "single"):
            for fap in (0.1, 0.01, 1e-3):
                last = LAST * math.sqrt(DAYS**2 - 1) / (DAYS - 1) if method == "naive" else LAST
                expected = LombScargle(t, y).false_alarm_level(fap, method=method, maximum_frequency=last)
                level = self.made().threshold(math.log10(fap), method)
                self.assertAlmostEqual(1 - 10**level, float(expected), delta=1e-5, msg=(method, fap))

    def test_sequential_formula(self):
        """The same from scipy's normal distribution: FAP of a query, from independent queries per e-fold and the
        spent share."""
        for count in (5, 20, 150, DAYS):
            periodogram = self.made(count)
            for power in (0.05, 0.1, 0.2, 0.5, 0.9):
                residual = math.log10(1 - power)
                z = -math.log(10) * periodogram.log10_fap(residual, "single")
                x = math.sqrt(2 * z / count)
                nu = (2 / x) * (stats.norm.cdf(x / 2) - 0.5) / (x / 2 * stats.norm.cdf(x / 2) + stats.norm.pdf(x / 2))
                spent = 1 / (2 * (1 + abs(math.log(count / 150))) ** 2)
                expected = periodogram.log10_fap(residual) + math.log10(max(1, z * nu) / spent)
                self.assertAlmostEqual(periodogram.log10_fap(residual, "sequential"), min(0, expected), delta=1e-11)

    def test_sequential_spends_one(self):
        """With a query at every number of samples, thresholds that let exactly their share pass: the shares sum
        to 1."""
        x = numpy.linspace(-5, 5, 200001)
        tail = 1 / (2 * (1 + 5))  # beyond either end
        self.assertAlmostEqual(numpy.trapz(1 / (2 * (1 + abs(x)) ** 2), x) + 2 * tail, 1, delta=1e-8)

    def test_bootstrap_against_astropy(self):
        """Both methods resample the same data: their highest peaks have the same distribution."""
        count = 200
        ours = 1 - 10 ** self.made().bootstrap(t, y, count=count, seed=3)
        frequency = GRID["f0"] + GRID["df"] * numpy.arange(GRID["nf"])
        rng = numpy.random.default_rng(4)
        theirs = []
        for _ in range(count):
            theirs.append(LombScargle(t, rng.choice(y, DAYS)).power(frequency, method="fast").max())
        self.assertGreater(stats.ks_2samp(ours, theirs).pvalue, 0.01)
        # On Gaussian noise both agree with Baluev's formula.
        baluev = 1 - 10 ** self.made().threshold(-1)
        self.assertAlmostEqual(ours[count // 10 - 1], baluev, delta=0.008)

    def test_bootstrap_resamples_sigmas_with_values(self):
        """A single sample dominates and is an outlier: every resampling that contains it once or more follows it."""
        sigma = numpy.where(t == 10, 0.01, 1.0)
        wild = numpy.where(t == 10, 100.0, y)
        with toliman.Periodogram(**GRID, sigma_floor=0.01, sigma_ceiling=1.0) as periodogram:
            periodogram.push_many(t, wild, sigma)
            peaks = periodogram.bootstrap(t, wild, sigma, count=100, seed=1)
        alone = (peaks > -0.3).mean()  # not drawn: ordinary noise, probability 1/e
        self.assertAlmostEqual(alone, math.exp(-1), delta=0.15)

    def test_sampling(self):
        periodogram = self.made()
        for sampling in (periodogram.sampling(), periodogram.sampling(t)):
            self.assertAlmostEqual(sampling.baseline, DAYS, delta=0.01)
            self.assertAlmostEqual(sampling.nyquist, 0.5, delta=1e-4)
            self.assertFalse(sampling.coarse or sampling.above_nyquist)
        with toliman.Periodogram(0.1, 0.01, 60) as coarse:
            coarse.push_many(t, y)
            self.assertTrue(coarse.sampling().coarse and coarse.sampling(t).above_nyquist)

    def test_refusals(self):
        periodogram = self.made()
        with self.assertRaises(ValueError):
            periodogram.log10_fap(-1, "davies")
        with refused(toliman.InputError, "log10_fap"):
            periodogram.threshold(0.5)


if __name__ == "__main__":
    unittest.main()
