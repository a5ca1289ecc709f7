"""Tests long ranges of frequency, which the search divides into boxes: times on a grid have aliases in each of them."""
import math
import unittest

import numpy

from package import toliman

STEP, SPAN, SIGMA, FREQUENCY = 0.3, 3400, 0.1, 0.99  # of the times, in steps, of the values; of the signal


class Boxes(unittest.TestCase):
    @staticmethod
    def search(shortest, longest):
        random = numpy.random.default_rng(3)
        t = STEP * numpy.unique([0, SPAN, *random.choice(SPAN, 10, replace=False)])
        y = numpy.cos(2 * math.pi * FREQUENCY * t) + SIGMA * random.normal(size=len(t))
        return toliman.planets(t, y, numpy.full(len(t), SIGMA), period_min=shortest, period_max=longest, jitter=False,
                               amplitude_min=0.8, amplitude_max=1.25)

    def test_aliases_share_the_posterior_of_two_boxes(self):
        """The evidence of each alias is in proportion to the prior at its frequency, 1/f."""
        narrow, wide = self.search(0.9, 1.2), self.search(0.19, 10)
        aliases = numpy.array([FREQUENCY, 1 / STEP - FREQUENCY, 1 / STEP + FREQUENCY])
        found = 1 / wide.samples(0)["period"]
        parts = numpy.array([numpy.mean(abs(found - alias) < 0.001) for alias in aliases])
        expected = (1 / aliases) / numpy.sum(1 / aliases)
        numpy.testing.assert_allclose(parts, expected, atol=0.02)
        change = math.log10(numpy.sum(FREQUENCY / aliases) * math.log(1.2 / 0.9) / math.log(10 / 0.19))
        odds = [result.candidates[0].log10_bayes for result in (narrow, wide)]
        self.assertAlmostEqual(odds[1] - odds[0], change, delta=0.01)


if __name__ == "__main__":
    unittest.main()
