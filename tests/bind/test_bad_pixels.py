"""The bad pixels of a scene: estimators, bounds and calibration do not use them."""
import copy
import math
import pathlib
import tempfile
import unittest
import warnings

import numpy

from package import toliman
from refusal import refused
import test_fit

SIDE = test_fit.SIDE
SCENE = {
    **test_fit.SCENE, "name": "bad",
    "binary": {"separation_arcsec": 7, "position_angle_deg": 30},
    "signal": {"kind": "sinusoid", "star": "A", "amplitude_px": 1e-4, "period_days": 17},
    "cadence": {"frames": 4, "interval_days": 1, "peak_photons": 1e6},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.4},
    "preprocess": {"project": ["flux_a", "flux_b", "shift_x", "shift_y"]},
}


class BadPixels(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        random = numpy.random.default_rng(1)
        self.bad = random.random((SIDE, SIDE)) < 0.02
        self.bad[30:34, 28:36] = True

    def save(self, name, array):
        path = pathlib.Path(self.folder.name, name)
        numpy.save(path, array)
        return path

    def scene(self, path=None, side=SIDE):
        scene = copy.deepcopy(SCENE)
        scene["detector"]["shape"] = [side, side]
        scene["telescope"]["pupil_samples"] = 96 if side == SIDE else 128
        if path is not None:
            scene["detector"]["bad_pixels"] = str(path)
        return scene

    def test_estimators_use_the_other_pixels(self):
        """Against dense least squares without them, whatever the counts there; key and argument are the same."""
        path = self.save("bad.npy", self.bad)
        simulator = toliman.Simulator(self.scene(path))
        self.assertEqual(simulator.info.bad_pixels, self.bad.sum())
        self.assertEqual(toliman.plan(self.scene(path)).bad_pixels, self.bad.sum())
        frame = simulator.frame(0)
        numpy.testing.assert_array_equal(frame, toliman.Simulator(self.scene()).frame(0))
        variance = simulator.image("variance")
        numpy.testing.assert_array_equal(numpy.isinf(variance), self.bad)
        good = ~self.bad
        design = numpy.stack([simulator.image(name)[good] for name in ("separation", "star_a", "star_b", "shift_x", "shift_y")], 1)
        weight = 1 / numpy.sqrt(variance[good])
        covariance = numpy.linalg.inv((design * weight[:, None]).T @ (design * weight[:, None]))
        expected = covariance @ design.T @ (weight**2 * (frame - simulator.image())[good])
        template, fit = toliman.Template(simulator), toliman.Fit(simulator)
        self.assertAlmostEqual(template.sigma / covariance[0, 0] ** 0.5, 1, delta=1e-9)
        self.assertAlmostEqual(simulator.bounds.crb_projected_px / template.sigma, 1, delta=1e-6)
        result, _, _ = fit.frame(frame)
        damaged = frame.copy()
        damaged[self.bad] = numpy.random.default_rng(2).choice([0, 1e9, -5], self.bad.sum())
        for counts in (frame, damaged):
            value, goodness = template.encode(counts, goodness=True)
            self.assertAlmostEqual(value, expected[0], delta=1e-9 * covariance[0, 0] ** 0.5)
            self.assertEqual((goodness.goodness, goodness.bad_pixels), ("good", 0))
            self.assertEqual(fit.frame(counts)[0], result)
        self.assertAlmostEqual(result.displacement_px, expected[0], delta=0.1 * template.sigma)
        other = toliman.Simulator(self.scene(), bad_pixels=path)
        self.assertEqual(toliman.Template(other).encode(damaged), template.encode(damaged))
        self.assertEqual(toliman.Fit(other).info.digest, fit.info.digest)
        self.assertNotEqual(toliman.Fit(toliman.Simulator(self.scene())).info.digest, fit.info.digest)

    def test_limit_and_false_alarms(self):
        """A pixel below and above the limit; and the limit of all frames: Poisson counts exceed it in 1 of 8,000 frames of
        256x256."""
        simulator = toliman.Simulator(self.scene())
        template, frame, variance = toliman.Template(simulator), simulator.image(), simulator.image("variance")
        self.enterContext(warnings.catch_warnings(action="ignore"))  # without noise, the fit is too good
        for pixel in ((SIDE // 2, SIDE // 2), (3, 5)):
            root = variance[pixel]**0.5
            for limit in (-6, 6 / root + (36 / root**2 + 36)**0.5):  # x^2 = 36 (1 + max(x, 0)/(3 sqrt(V)))
                for factor, found in ((0.98, 0), (1.02, 1)):
                    counts = frame.copy()
                    counts[pixel] += factor * limit * root
                    self.assertEqual(template.encode(counts, goodness=True)[1].bad_pixels, found, (pixel, limit))
        shares = []
        for mean in (1000, 10000, 100000):
            counts = numpy.arange(mean + 10 * int(mean**0.5))
            logs = counts * math.log(mean) - mean - numpy.array([math.lgamma(k + 1) for k in counts])
            x = (counts - mean) / mean**0.5
            shares.append(numpy.exp(logs)[x**2 > 36 * (1 + numpy.maximum(x, 0) / (3 * mean**0.5))].sum())
        self.assertAlmostEqual(1 / (shares[-1] * 65536) / 8000, 1, delta=0.1)
        self.assertLess(max(shares), 1.1 * shares[-1])

    def test_a_search_does_not_see_them(self):
        simulator = toliman.Simulator(self.scene(self.save("bad.npy", self.bad)))
        frame = numpy.roll(simulator.frame(0), (3, -2), (0, 1))
        frame[self.bad] = 1e9
        result, _, _ = toliman.Fit(simulator).frame(frame)
        self.assertTrue(result.searched)
        self.assertAlmostEqual(result.x_px, -2, delta=5 * result.x_sigma_px + 1e-3)

    def test_networks_keep_them(self):
        """Through files of every encoding; the latent does not depend on the counts there."""
        bad = numpy.zeros((256, 256), "u1")
        bad[100:130, ::37] = 1
        simulator = toliman.Simulator(self.scene(self.save("bad.npy", bad), 256))
        network = toliman.CAE(simulator)
        network.train(steps=3)
        frame = simulator.frame(1)
        damaged = numpy.where(bad, 1e8, frame)
        latent, goodness = network.encode(frame, goodness=True)
        self.assertEqual(network.encode(damaged, goodness=True), (latent, goodness))
        self.assertEqual(goodness.goodness, "good")
        for encoding in ("float32", "bf16", "fp16"):
            content = network.to_bytes(planes=encoding) if encoding != "float32" else network.to_bytes()
            loaded = toliman.CAE.from_bytes(content)
            self.assertEqual(loaded.encode(damaged), loaded.encode(frame))
            self.assertEqual(loaded.to_bytes(planes=encoding) if encoding != "float32" else loaded.to_bytes(), content)
        with refused(toliman.UnsupportedError, "detector.bad_pixels"):
            toliman.CAE(toliman.Simulator(self.scene(self.save("wide.npy", numpy.eye(260)), 260)), centre="image")

    def test_calibration_does_not_use_them(self):
        """Frames whose bad pixels are off by far: chi-square 1, and the fitted scene names the file."""
        path = self.save("bad.npy", self.bad)
        simulator = toliman.Simulator(self.scene(path))
        frames = simulator.frames(0, 4)
        frames[:, self.bad] += 1e6
        calibration = toliman.calibrate(simulator, frames, free="scale")
        self.assertAlmostEqual(calibration.info.chi_square, 1, delta=6 * calibration.info.chi_square_sigma)

    def test_mistakes(self):
        nan = numpy.zeros((SIDE, SIDE))
        nan[3, 4] = numpy.nan
        for array, error, name in (
            (numpy.zeros((SIDE, SIDE - 1)), toliman.InputError, "detector.bad_pixels"),
            (numpy.ones((SIDE, SIDE)), toliman.InputError, "detector.bad_pixels"),
            (nan, toliman.InputError, ""),
            (numpy.zeros(SIDE), toliman.InputError, ""),
            (None, toliman.NotFoundError, ""),
        ):
            path = self.save("bad.npy", array) if array is not None else pathlib.Path(self.folder.name, "missing.npy")
            for options in {"scene": self.scene(path)}, {"scene": self.scene(), "bad_pixels": path}:
                with refused(error, name or path):
                    toliman.Simulator(**options)


if __name__ == "__main__":
    warnings.simplefilter("error", toliman.FitWarning)
    unittest.main()
