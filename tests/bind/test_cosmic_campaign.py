"""Frames with cosmic rays: the short form of cosmic_campaign.py, and frames that must not be cleaned."""
import unittest
import warnings

import numpy

from package import toliman
import cosmic_campaign as campaign


class Cosmic(unittest.TestCase):
    def check(self, made, found_share):
        for name, of in made.items():
            with self.subTest(estimator=name):
                self.assertEqual(of["lost"], [0, 0])
                self.assertEqual(of["bad"][0], 0)
                self.assertGreater(of["bad"][1], found_share * of["hits"])
                self.assertLessEqual(of["bad"][1], of["hits"])
                self.assertLess(of["rms"], 0.05)
                self.assertLess(of["largest"], 0.5)

    # promises: bad-pixels-are-left-out, cosmic-rays-lose-no-frame
    def test_hits_are_left_out(self):
        """Without the rejection a hit moves the fit of a small frame by up to 10 standard deviations."""
        self.check(campaign.measure(campaign.moving(60), False, 0.5, 4), 0.95)
        self.check(campaign.measure(campaign.chapter(16), True, 2, 4), 0.8)

    # promise: wrong-models-are-not-cleaned
    def test_wrong_optics_are_not_cleaned(self):
        """Frames of another focus: hundreds of pixels are off, of which at most three are left out; the fit stays poor."""
        scene = campaign.moving(4)
        fit = toliman.Fit(toliman.Simulator(scene))
        scene["telescope"]["aberrations"] = {"zernike_rms_nm": {"5": 4}}
        frames = toliman.Simulator(scene).frames(0, 4)
        frames[1, 10, 10] += 1e5
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = fit.frames(frames, times_days=numpy.arange(4))
        self.assertTrue((found["goodness"] == 803).all(), found)
        self.assertLessEqual(found["bad_pixels"].max(), 3)
        self.assertEqual([warning.category for warning in caught], [toliman.FitWarning])

    def test_another_unit_is_too_good(self):
        """Counts in DN of 2 electrons, taken for photons."""
        scene = campaign.moving(2)
        fit = toliman.Fit(toliman.Simulator(scene))
        with self.assertWarns(toliman.FitWarning):
            result, _, _ = fit.frame(toliman.Simulator(scene).frame(0) / 2, time_days=0)
        self.assertEqual(result.goodness, "too good")
        self.assertLess(result.chi_square, 0.6)


if __name__ == "__main__":
    unittest.main()
