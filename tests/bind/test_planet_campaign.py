"""Calibration of planets on simulated series: the short form of planet_campaign.py."""
import math
import unittest

import numpy

from study import Serial, run
import planet_campaign as campaign


class Campaign(unittest.TestCase):
    def test_posteriors(self):
        wrong, lines = run(campaign.sbc, Serial, 1, 1)
        self.assertEqual((wrong, len(lines)), ([], 10))

    # promise: false-planets-are-rare
    def test_without_planet(self):
        self.assertEqual(run(campaign.null, Serial, 1, 1)[0], [])

    def test_series_shorter_than_the_period(self):
        """The functions describe most of a long period: with scales up to 5 uas, all amplitudes are wrong by 4 half widths."""
        wrong, lines = run(campaign.short, Serial, 2, 1, ((120, 200, 20), (200, 400, 20)))
        self.assertEqual((wrong, len(lines)), ([], 4))

    # promise: detectable-planets-are-found
    def test_limits(self):
        wrong, lines = run(campaign.limits, Serial, 1, 1, (800,))
        self.assertEqual((wrong, len(lines)), ([], 3))


class Figures(unittest.TestCase):
    def test_ranks_of_a_uniform_distribution(self):
        self.assertGreater(campaign.uniform_p((numpy.arange(100) + 0.5) / 100), 0.99)
        self.assertAlmostEqual(campaign.uniform_p(numpy.linspace(0.1372, 1, 99)), 0.05, delta=0.01)
        self.assertLess(campaign.uniform_p(numpy.linspace(0.5, 1, 20)), 1e-4)
        self.assertEqual(campaign.rank(2, numpy.array([1, 2, 2, 3])), 0.5)

    def test_orbits_in_the_plane_of_the_binary(self):
        """The amplitude along the axis is that asked for; a quarter of an orbit further on, the constants exchange."""
        one, other = campaign.coplanar(1, 3.0, 20), campaign.coplanar(1, 3.0, 110)
        self.assertAlmostEqual(math.hypot(*one[:2]), 3)
        self.assertAlmostEqual(math.hypot(*one), math.hypot(*other))
        numpy.testing.assert_allclose(other, [-one[1], one[0], -one[3], one[2]], rtol=1e-12)

    def test_means_of_five_days(self):
        days, means = campaign.observations(0), campaign.observations(1)
        self.assertAlmostEqual((days[3]**-2).sum() / (means[3]**-2).sum(), 1)
        for one, mean in zip(days[:3], means[:3]):
            numpy.testing.assert_allclose(numpy.average(mean, 0, means[3]**-2), one.mean(0), rtol=1e-12)

    def test_figures_that_are_missed_are_named(self):
        class Wrong:
            map = staticmethod(lambda function, tasks, chunksize: [3.0] * len(tasks))
        self.assertEqual(run(campaign.null, Wrong, 10, 1)[0], ["10 of 10 Bayes factors above 10: must be at most 1 %"])


if __name__ == "__main__":
    unittest.main()
