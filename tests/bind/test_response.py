"""The response of each pixel that a scene names: simulation, bounds and all estimators have it."""
import copy
import math
import pathlib
import tempfile
import unittest
import warnings

import numpy

from package import toliman
from refusal import refused
import test_bad_pixels

SIDE = test_bad_pixels.SIDE
DETECTOR = {"qe": 0.8, "flat_rms": 0.01}


class Responses(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.response = 1 + 0.02 * numpy.random.default_rng(5).standard_normal((SIDE, SIDE))
        self.path = pathlib.Path(self.folder.name, "response.npy")
        numpy.save(self.path, self.response)

    def scene(self, path=None, **detector):
        scene = copy.deepcopy(test_bad_pixels.SCENE)
        scene["detector"].update(detector)
        if path is not None:
            scene["detector"]["response"] = str(path)
        return scene

    def test_images_are_multiplied(self):
        """Every image of light, after qe and flat_rms; the variance is that of the light."""
        with_it, without = (toliman.Simulator(self.scene(path, **DETECTOR)) for path in (self.path, None))
        for name in ("separation", "star_a", "star_b", "shift_x", "both"):
            numpy.testing.assert_allclose(with_it.image(name), self.response * without.image(name), rtol=1e-15)
        noise = test_bad_pixels.SCENE["noise"]["read_e"]**2
        numpy.testing.assert_allclose(with_it.image("variance") - noise,
                                      self.response * (without.image("variance") - noise), rtol=1e-12, atol=1e-11)
        frames = numpy.stack([with_it.frame(k) for k in range(4)]) - with_it.image()
        self.assertAlmostEqual((frames**2 / with_it.image("variance")).mean(), 1, delta=5 * math.sqrt(2 / frames.size))

    def test_estimators_have_it(self):
        """A frame with the response: good with it, poor without; bounds against dense least squares."""
        simulator, other = (toliman.Simulator(self.scene(path, **DETECTOR)) for path in (self.path, None))
        self.enterContext(warnings.catch_warnings(action="ignore"))
        design = numpy.stack([simulator.image(name).ravel()
                              for name in ("separation", "star_a", "star_b", "shift_x", "shift_y")], 1)
        covariance = numpy.linalg.inv((design / simulator.image("variance").reshape(-1, 1)).T @ design)
        self.assertAlmostEqual(simulator.bounds.crb_projected_px / covariance[0, 0]**0.5, 1, delta=1e-6)
        frame = simulator.frame(0)
        for source, goodness in (simulator, "good"), (other, "poor"):
            found = toliman.Fit(source).frame(frame)[0]
            value, about = toliman.Template(source).encode(frame, goodness=True)
            calibration = toliman.calibrate(source, simulator.frames(0, 4), free="scale")
            self.assertEqual((found.goodness, about.goodness, calibration.goodness), (goodness,) * 3)
            if goodness == "good":
                for displacement in (value, found.displacement_px):
                    self.assertLess(abs(displacement), 5 * covariance[0, 0]**0.5)
        self.assertNotEqual(toliman.Fit(simulator).info.digest, toliman.Fit(other).info.digest)

    def test_windows_that_move_are_refused(self):
        simulator = toliman.Simulator(self.scene(self.path, window=[100, 200]))
        frames, fit = simulator.frames(0, 2), toliman.Fit(simulator)
        fit.frame(frames[0], window=(100, 200))
        for call, field in (
            (lambda: fit.frame(frames[0], window=(100, 201)), "image->windows"),
            (lambda: fit.frames(frames, windows=[(100, 200), (101, 200)]), "image->windows"),
            (lambda: toliman.Template(simulator), "detector.response"),
        ):
            with refused(toliman.UnsupportedError, field):
                call()

    def test_mistakes(self):
        for bad in (numpy.nan, 0, -1, 11, numpy.inf):
            response = self.response.copy()
            response[3, 4] = bad
            numpy.save(self.path, response)
            with refused(toliman.InputError, self.path):
                toliman.Simulator(self.scene(self.path))
        numpy.save(self.path, self.response[1:])
        with refused(toliman.InputError, "detector.response"):
            toliman.Simulator(self.scene(self.path))
        with refused(toliman.NotFoundError, pathlib.Path(self.folder.name, "missing.npy")):
            toliman.Simulator(self.scene(pathlib.Path(self.folder.name, "missing.npy")))


if __name__ == "__main__":
    warnings.simplefilter("error", toliman.FitWarning)
    unittest.main()
