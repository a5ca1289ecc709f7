"""Verdicts of planets: each reason against one, by itself."""
import math
import unittest

import numpy

from package import toliman
import doubt_campaign as campaign
import planet_model as model
from toliman import _library, _raw as RAW

REASONS = {name: _library.library.toliman_constant_name(getattr(RAW, f"TOLIMAN_PLANET_REASON_{name}")).decode()
           for name in ("ODDS", "CHI_SQUARE", "JITTER", "FAP", "EDGE", "RANGE", "MASS", "CROSSING", "FRAMES", "SAMPLES")}


class Reasons(unittest.TestCase):
    """One planet each, with one reason against it; without it the same series has a planet."""

    @classmethod
    def setUpClass(cls):
        random = numpy.random.default_rng(3)
        cls.t = campaign.days(random, 150)
        cls.noise = campaign.SIGMA * random.normal(size=150)
        cls.y = model.separation(cls.t, 300, 0.2, 60, 100, 3e-6) + cls.noise
        cls.right = cls.search(cls.y)

    @classmethod
    def search(cls, y, **options):
        return campaign.search(cls.t, y, campaign.SIGMA, **{"period_min": 150, "samples": 200, **options})

    def assert_refused(self, found, *reasons):
        one = found.candidates[0]
        self.assertEqual((one.reasons, one.verdict), (tuple(REASONS[name] for name in reasons), "candidate"))
        self.assertEqual((found.info.planets, len(found), found.planets), (0, 0, []))

    # promise: one-reason-forbids-a-planet
    def test_none(self):
        (one,) = self.right.planets
        self.assertEqual((one.verdict, one.reasons, self.right.info.planets, len(self.right.outliers)), ("planet", (), 1, 0))
        self.assertEqual(self.right.info.goodness, "good")
        residuals = self.right.residuals() / campaign.SIGMA
        freedom = residuals @ residuals / self.right.info.chi_square
        self.assertAlmostEqual(freedom, 150 - 6, delta=0.3)  # mean, two amplitudes, three of the orbit with priors
        self.assertAlmostEqual(self.right.info.chi_square_sigma, math.sqrt(2 * 150) / freedom, delta=1e-9)
        self.assertAlmostEqual(self.right.info.largest_residual, abs(residuals).max(), delta=1e-9)

    # promise: one-reason-forbids-a-planet
    def test_odds(self):
        self.assert_refused(self.search(self.noise), "ODDS")

    # promise: one-reason-forbids-a-planet
    def test_chi_square(self):
        self.assert_refused(self.search(self.y + 1.2 * numpy.roll(self.noise, 1), jitter=False), "CHI_SQUARE")
        self.assert_refused(campaign.search(self.t, self.y, 2 * campaign.SIGMA, period_min=150), "CHI_SQUARE")  # too good

    # promise: one-reason-forbids-a-planet
    def test_jitter(self):
        found = self.search(self.y + 2 * numpy.roll(self.noise, 1))
        self.assert_refused(found, "JITTER")
        self.assertAlmostEqual(found.info.jitter[1] / campaign.SIGMA, 2, delta=0.5)
        self.assertAlmostEqual(found.info.chi_square_with_jitter, 1, delta=0.1)
        one = self.search(self.y + 1.2 * numpy.roll(self.noise, 1))
        self.assertEqual((one.info.planets, one.info.goodness), (1, "poor"))

    def test_star_has_a_jitter(self):
        y = 1e6 * (model.velocity(self.t, 300, 0.2, 60, 100, 8e-6) + 2 * self.noise)
        found = toliman.planets(self.t, y, 0.5, velocity=True, unit=1, star_masses=(1, 0), samples=100, period_min=200)
        self.assertEqual((found.info.planets, found.info.goodness), (1, "poor"))

    # promise: one-reason-forbids-a-planet
    def test_fap(self):
        self.assert_refused(self.search(self.y, detection_fap=1e-300), "FAP")

    # promise: one-reason-forbids-a-planet
    def test_edge(self):
        self.assert_refused(self.search(self.y, period_min=299), "EDGE")

    # promise: one-reason-forbids-a-planet
    def test_range(self):
        y = self.y + model.separation(self.t, 40, 0, 0, 7, 6e-6)
        self.assert_refused(self.search(y, threshold=0.5, eccentricity_max=0.4), "JITTER", "RANGE")
        self.assertEqual(self.search(y, period_min=38, period_max=320, max_planets=2, samples=100, eccentricity_max=0.4).info.planets, 2)

    # promise: one-reason-forbids-a-planet
    def test_mass(self):
        self.assert_refused(self.search(self.y, unit=1e6), "MASS")  # uas taken for arcsec, the other way round
        self.assertEqual(self.search(self.y, unit=1e4).info.planets, 1)

    # promise: one-reason-forbids-a-planet
    def test_crossing(self):
        y = self.y + model.separation(self.t, 200, 0.7, 200, 20, 6e-6)
        found = self.search(y, max_planets=2, period_max=350)
        verdicts = sorted((one.log10_bayes, one.verdict, one.reasons) for one in found.candidates)
        self.assertEqual([one[1:] for one in verdicts], [("candidate", (REASONS["CROSSING"],)), ("planet", ())])
        self.assertEqual((found.info.planets, len(found.planets)), (1, 1))

    def test_frames(self):
        self.assert_refused(self.search(self.y, frame_chi_square=2.1), "FRAMES")
        self.assertEqual(self.search(self.y, frame_chi_square=1.9).info.planets, 1)

    # promise: outliers-forbid-a-planet
    def test_samples(self):
        """Those that do not belong have no weight."""
        y = self.y.copy()
        y[[20, 90]] += 1e-4, -1
        found, kept = self.search(y), numpy.delete(numpy.arange(150), [20, 90])
        self.assert_refused(found, "SAMPLES")
        self.assertEqual((list(found.outliers), found.info.goodness, found.info.outliers), ([20, 90], "poor", 2))
        self.assertAlmostEqual(found.residuals()[20], 1e-4, delta=5e-6)
        clipped = self.search(y, clip=True, samples=1000)
        self.assertEqual((clipped.info.planets, clipped.info.goodness), (1, "good"))
        without = campaign.search(self.t[kept], y[kept], campaign.SIGMA, period_min=150).planets[0]
        for name in "period", "amplitude", "eccentricity":
            numpy.testing.assert_allclose(getattr(clipped.planets[0], name), getattr(without, name), rtol=1e-2)  # another reference of time

    def test_periastron_belongs(self):
        """Few samples see the periastron of an eccentric orbit."""
        y = 1e6 * self.noise + model.velocity(self.t, 420, 0.9, 30, 300, 200)
        found = toliman.planets(self.t, y, 1.0, velocity=True, samples=100, period_min=150)
        self.assertEqual((found.info.planets, len(found.outliers)), (1, 0))
        self.assertAlmostEqual(found.planets[0].eccentricity[1], 0.9, delta=0.02)

    # promise: outliers-forbid-a-planet
    def test_bounded_work(self):
        for size in 1e-4, 1e90:
            y = self.y.copy()
            y[50] += size
            self.assertEqual((list(self.search(y).outliers), self.search(y, clip=True).info.planets), ([50], 1))

    def test_names(self):
        self.assertEqual(len(set(REASONS.values())), 10)
        name = _library.library.toliman_constant_name
        self.assertEqual([name(number) for number in (15, 3 << 20, -1)], [b"?"] * 3)


if __name__ == "__main__":
    unittest.main()
