"""The response of each pixel that a scene names: simulation, bounds and all estimators have it; and calibrations that find it,
against dense least squares. The long form: response_map.py."""
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
import test_calibration

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

    def test_without_a_window_the_frames_have_none(self):
        """Frames that name a place on the detector are other pixels than those of the response, unless it is the first."""
        simulator = toliman.Simulator(self.scene(self.path))
        frames, fit = simulator.frames(0, 2), toliman.Fit(simulator)
        for window in None, (0, 0):
            self.assertEqual(fit.frame(frames[0], window=window)[0].goodness, "good")
        for call in (lambda: fit.frame(frames[0], window=(100, 200)), lambda: fit.frames(frames, windows=[(0, 0), (0, 1)])):
            with refused(toliman.UnsupportedError, "image->windows"):
                call()
        plain = toliman.Simulator(self.scene())
        toliman.Fit(plain).frame(plain.frame(0), window=(100, 200))

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


SMALL, FRAMES, RMS, FREE = 28, 60, 5e-3, "scale=1e-3 focus=20 zernike_7=20"
PLACES = {"A": (-3.2, 2.3), "B": (4.1, -3.6)}


class ResponseMaps(unittest.TestCase):
    """Frames of stars that move by 2 px rms, with a white response."""

    @classmethod
    def setUpClass(cls):
        random = numpy.random.default_rng(3)
        cls.response = 1 + RMS * random.standard_normal((SMALL, SMALL))
        cls.shifts = 2 * random.standard_normal((FRAMES + 4, 2))
        cls.simulators = [toliman.Simulator(cls.scene(shift)) for shift in cls.shifts]
        cls.frames = numpy.stack([random.poisson(one.image() * cls.response) for one in cls.simulators]).astype("u4")
        cls.nominal = toliman.Simulator(cls.scene((0, 0)))
        cls.options = {"shifts": cls.shifts[:FRAMES] + 0.1, "free": FREE, "detector": True, "response_rms": RMS}
        cls.found = toliman.calibrate(cls.nominal, cls.frames[:FRAMES], threads=1, **cls.options)

    @staticmethod
    def scene(shift):
        scene = copy.deepcopy(test_calibration.SCENE)
        scene["binary"] = {"offsets_px": {star: [place[0] + shift[0], place[1] + shift[1]] for star, place in PLACES.items()}}
        scene["signal"]["amplitude_px"] = 0
        scene["detector"]["shape"] = [SMALL, SMALL]
        scene["noise"] = {"photon": True, "seed": 1}
        scene["cadence"]["frames"] = FRAMES
        del scene["systematics"]
        return scene

    def dense(self):
        """The response and its standard deviations from the whole matrix of all unknowns, linearised about the truth."""
        values, names = self.found.values(), ("star_a", "star_b", "separation", "position_angle", "shift_x", "shift_y")
        pixels, n, true = SMALL**2, len(values), self.response.ravel()
        size = pixels + FRAMES * 7 + n
        matrix, right = numpy.zeros((size, size)), numpy.zeros(size)
        for k, simulator in enumerate(self.simulators[:FRAMES]):
            light = simulator.image().ravel()
            own = numpy.stack([simulator.derivative(name).ravel() if name == "position_angle" else simulator.image(name).ravel()
                               for name in names] + [numpy.ones(pixels)], 1)
            of_instrument = numpy.stack([simulator.derivative(name).ravel() for name in values], 1)
            others = numpy.concatenate([own, of_instrument], 1) * true[:, None]
            columns = numpy.r_[pixels + 7 * k:pixels + 7 * k + 7, size - n:size]
            weight = 1 / (light * true)
            residual = self.frames[k].ravel() - light * true
            matrix[range(pixels), range(pixels)] += weight * light**2
            matrix[numpy.ix_(columns, columns)] += (others * weight[:, None]).T @ others
            mixed = others * (weight * light)[:, None]
            matrix[numpy.ix_(range(pixels), columns)] += mixed
            matrix[numpy.ix_(columns, range(pixels))] += mixed.T
            right[:pixels] += weight * light * residual
            right[columns] += others.T @ (weight * residual)
        matrix[range(pixels), range(pixels)] += 1 / RMS**2
        right[:pixels] -= (true - 1) / RMS**2
        for i, value in enumerate(values.values()):
            matrix[size - n + i, size - n + i] += 1 / value.prior_sigma**2
        covariance = numpy.linalg.inv(matrix)
        shape = (SMALL, SMALL)
        # Without the response itself times a constant, which is not determined: an eigenvector.
        variance = covariance.diagonal()[:pixels].reshape(shape) - (RMS * self.response)**2 / (true**2).sum()
        apart = numpy.zeros(size)  # of the mean of the separations, which the scale changes, too
        first = pixels + 7 * numpy.arange(FRAMES)
        apart[first + names.index("separation")] = 1 / FRAMES
        apart[size - n + list(values).index("scale")] = math.dist(*PLACES.values())
        alone = [numpy.linalg.inv(matrix[k:k + 7, k:k + 7])[2, 2] for k in first]
        common = apart @ covariance @ apart - sum(alone) / FRAMES**2
        return self.response + (covariance @ right)[:pixels].reshape(shape), variance**0.5, common**0.5

    def test_dense_least_squares(self):
        response, sigma, common = self.dense()
        self.assertEqual(self.found.flags, (), self.found.verdict)
        self.assertLess(numpy.abs((self.found.response - response) / sigma).max(), 0.01)
        ratio = self.found.response_sigma / sigma
        self.assertLess(numpy.abs(ratio - 1).max(), 0.003)
        self.assertAlmostEqual(self.found.info.calibration_sigma_px / common, 1, delta=1e-3)
        self.assertAlmostEqual(self.found.info.response_parameters, (1 - sigma**2 / RMS**2).sum() - 1, delta=0.1)

    def test_steps_are_those_of_all_parameters(self):
        """In standard deviations with the response known, also of spectra, which a response imitates: one that rests does not
        end a calibration whose other parameters move."""
        free, steps = FREE + " spectrum_a_1 spectrum_b_1 temperature_a temperature_b", []

        def record(calibration, step):
            if step.is_response:
                steps.append((step.largest_step, {name: value.value for name, value in calibration.values().items()}))

        found = toliman.calibrate(self.nominal, self.frames[:FRAMES], step=record, **{**self.options, "free": free})
        with tempfile.TemporaryDirectory() as folder:
            found.save(pathlib.Path(folder) / "fitted.json")
            fitted = toliman.Simulator(pathlib.Path(folder) / "fitted.json")
        known = toliman.calibrate(fitted, self.frames[:FRAMES], shifts=self.options["shifts"], free=free).values()
        for (_, before), (largest, after) in zip(steps, steps[1:]):
            self.assertGreater(largest, 0.9 * max(abs(after[name] - before[name]) / known[name].sigma for name in known))
        self.assertLess(steps[-1][0], 0.1)

    def test_errors_are_those_stated(self):
        pulls = (self.found.response - self.response / self.response.mean()) / self.found.response_sigma
        self.assertAlmostEqual((pulls**2).mean()**0.5, 1, delta=4 / math.sqrt(2 * pulls.size))
        info = self.found.info
        self.assertEqual(info.response_pixels, (self.found.response_sigma <= 0.7 * RMS).sum())
        self.assertAlmostEqual(info.chi_square, 1, delta=5 * info.chi_square_sigma)
        self.assertAlmostEqual(self.found.response.mean(), 1, delta=1e-4)

    def test_the_fitted_scene_has_it(self):
        """Other frames are good with it, and poor without; a calibration can start from it. Bits do not depend on threads."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "fitted.json"
            self.found.save(path)
            fitted = toliman.Simulator(path)
            self.assertTrue((pathlib.Path(folder) / "fitted.response.npy").exists())
        self.enterContext(warnings.catch_warnings(action="ignore"))
        shifts, frames = self.shifts[FRAMES:], self.frames[FRAMES:]
        found, without = (toliman.Fit(one).frames(frames, shifts=shifts)["chi_square"] for one in (fitted, self.nominal))
        self.assertLess(numpy.abs(found - 1).max(), 0.4)
        self.assertGreater(without.min(), 2)
        again = toliman.calibrate(self.nominal, self.frames[:FRAMES], start=fitted, threads=2, **self.options)
        self.assertLess(numpy.abs((again.response - self.found.response) / self.found.response_sigma).max(), 0.01)
        other = toliman.calibrate(self.nominal, self.frames[:FRAMES], threads=2, **self.options)
        numpy.testing.assert_array_equal(other.response, self.found.response)
        numpy.testing.assert_array_equal(other.response_sigma, self.found.response_sigma)

    def test_sums_of_frames(self):
        """Four times the light in each: half the errors, where they are not those of the prior."""
        random = numpy.random.default_rng(4)
        sums = numpy.stack([random.poisson(4 * one.image() * self.response) for one in self.simulators[:FRAMES]]).astype("u4")
        found = toliman.calibrate(self.nominal, sums, spreads=[toliman.Spread(frames=4)] * FRAMES, **self.options)
        self.assertEqual(found.flags, (), found.verdict)
        ratio = found.response_sigma / self.found.response_sigma
        self.assertAlmostEqual(numpy.median(ratio), 0.5, delta=0.03)
        pulls = (found.response - self.response / self.response.mean()) / found.response_sigma
        self.assertAlmostEqual((pulls**2).mean()**0.5, 1, delta=4 / math.sqrt(2 * pulls.size))

    # promise: journals-continue-calibrations
    def test_journals_continue(self):
        with tempfile.TemporaryDirectory() as folder:
            journal = pathlib.Path(folder) / "part"
            with refused(toliman.Cancelled, ""):
                toliman.calibrate(self.nominal, self.frames[:FRAMES], journal=journal, step=lambda _, step: step.is_response,
                                  **self.options)
            steps = []
            again = toliman.calibrate(self.nominal, self.frames[:FRAMES], journal=journal,
                                      step=lambda _, step: steps.append((step.is_response, step.recalled)), **self.options)
        self.assertIn((True, True), steps)
        self.assertIn((True, False), steps)
        numpy.testing.assert_array_equal(again.response, self.found.response)
        numpy.testing.assert_array_equal(again.response_sigma, self.found.response_sigma)

    def test_what_has_no_response(self):
        alone = toliman.calibrate(self.nominal, self.frames[:4], shifts=self.shifts[:4], free="scale")
        self.assertTrue(numpy.isnan(alone.response).all() and numpy.isnan(alone.response_sigma).all())
        self.assertEqual((alone.info.response_pixels, alone.info.response_parameters), (0, 0))
        with refused(toliman.UnsupportedError, "options->window_days"):
            toliman.calibrate(self.nominal, self.frames[:4], detector=True, window_days=1)
        with refused(toliman.InputError, "options->response_rms"):
            toliman.calibrate(self.nominal, self.frames[:4], detector=True, response_rms=0.6)


if __name__ == "__main__":
    warnings.simplefilter("error", toliman.FitWarning)
    unittest.main()
