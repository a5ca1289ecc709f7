"""Fits of the forward model from Python: the same numbers from all calls, predictions, the tracker, and mistakes."""
import unittest

import numpy

from package import toliman
from refusal import refused
from toliman import _raw

SIDE = 64
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96,
                  "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 297.5, "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874},
                                                                     {"a": 0.93, "f": 1.829, "m": 5}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 12.5},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "relative_flux": 3},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
    "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 40},
    "cadence": {"frames": 100, "interval_days": 2, "peak_photons": 1e5},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.2},
    "noise": {"photon": True, "read_e": 2.5, "seed": 7},
}
NAMES = ["separation", "position_angle", "shift_x", "shift_y", "flux_a", "flux_b", "background"]


class Fits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(SCENE)
        cls.fit = toliman.Fit(cls.simulator, free=["scale"])
        cls.images = numpy.stack([cls.simulator.frame(k) for k in range(5)])

    def test_windows(self):
        """A frame at the start of a window has the numbers of the fit of its scene; others are between."""
        other = toliman.Simulator({**SCENE, "detector": {**SCENE["detector"], "pixel_scale_arcsec": 0.2004}})
        both = toliman.Fit.of_windows([self.simulator, other], [0, 10], free="scale")
        second = toliman.Fit(other, free=["scale"])
        times = [-3, 0, 0, 10, 400]
        expected = [(self.fit if time < 10 else second).frame(image, time_days=time)[0]
                    for time, image in zip(times, self.images)]
        numpy.testing.assert_array_equal(both.frames(self.images, times_days=times)["separation_px"],
                                         [result.separation_px for result in expected])
        ends = [fit.predict(time_days=5)[1] for fit in (self.fit, second)]
        numpy.testing.assert_allclose(both.predict(time_days=5)[1], numpy.mean(ends, axis=0), rtol=1e-12, atol=1e-14)
        self.assertEqual(both.shape, (SIDE, SIDE))
        self.assertNotIn(both.info.digest, (self.fit.info.digest, second.info.digest))
        with refused(toliman.InputError, "first_days[1]"):
            toliman.Fit.of_windows([self.simulator, other], [10, 0])
        with refused(TypeError, "simulators"):
            toliman.Fit.of_windows([3], [0])
        with refused(toliman.UnsupportedError, "fit"):
            toliman.Bank(both)

    def test_parameters(self):
        self.assertEqual([parameter.name for parameter in self.fit.parameters], [*NAMES, "scale"])
        self.assertEqual(self.fit.parameters[1].unit, "deg")
        self.assertEqual(self.fit.info.parameters, 8)
        self.assertEqual((self.fit.info.rows, self.fit.info.cols, self.fit.info.capture_px), (SIDE, SIDE, 15))

    def test_all_calls_give_the_same_numbers(self):
        times = numpy.arange(5) * 2.0
        together = self.fit.frames(self.images, times_days=times, shifts=[[0.1, 0]] * 5)
        whole = self.fit.frames(numpy.rint(self.images).astype("u4"), times_days=times, shifts=(0.1, 0))
        self.assertNotIn("struct_size", together.dtype.names)
        self.assertEqual(len(together), 5)
        for k in range(5):
            result, values, covariance = self.fit.frame(self.images[k], time_days=times[k], shift=(0.1, 0))
            for name in ("displacement_px", "separation_px", "position_angle_deg", "chi_square", "iterations"):
                self.assertEqual(together[name][k], getattr(result, name))
            self.assertEqual(list(values[:4]), [result.separation_px, result.position_angle_deg, result.x_px, result.y_px])
            self.assertEqual(result.separation_sigma_px, covariance[0, 0] ** 0.5)
            numpy.testing.assert_allclose(covariance, covariance.T, rtol=1e-9)
            self.assertEqual((result.not_converged, result.goodness, result.bad_pixels), (False, "good", 0))
            self.assertLess(abs(whole["separation_px"][k] - together["separation_px"][k]), 0.01)

    def test_more_frames_than_a_call_takes(self):
        images = self.images[numpy.arange(130) % 5]
        times = numpy.arange(130) * 2.0
        stages = []
        results = self.fit.frames(images, times_days=times, progress=lambda stage, fraction: stages.append((stage, fraction)))
        self.assertEqual(stages[-1], ("fit", 1))
        self.assertEqual(results["separation_px"][129], self.fit.frame(images[129], time_days=258)[0].separation_px)
        self.assertEqual(len(self.fit.frames(images[:0])), 0)

    def test_predictions(self):
        image, values, covariance = self.fit.predict()
        self.assertEqual((image.shape, values.shape, covariance.shape), ((SIDE, SIDE), (8,), (8, 8)))
        self.assertGreater(image.max(), 0)
        numpy.testing.assert_allclose(self.fit.predict(separation=values[0] + 1, position_angle=values[1])[1][0], values[0] + 1)
        numpy.testing.assert_allclose(self.fit.predict(shift=(0.5, 0.25))[1][2:4] - values[2:4], (0.5, 0.25), atol=1e-9)

    def test_a_frame_without_a_fit_is_nan(self):
        result, values, covariance = self.fit.frame(numpy.zeros((SIDE, SIDE)))
        self.assertTrue(result.not_converged)
        self.assertTrue(numpy.isnan(result.displacement_px) and numpy.isnan(values).all() and numpy.isnan(covariance).all())
        flags = self.fit.frames(numpy.zeros((1, SIDE, SIDE)))["flags"]
        self.assertTrue(flags[0] & _raw.TOLIMAN_FIT_NOT_CONVERGED)

    def test_tracker(self):
        with toliman.Tracker(self.fit, 0.001, 0.001, 20, allow_zero_runs=True) as tracker:
            for k in range(5):
                frame = toliman.Frame(self.images[k], session="s", frame_id=k, camera_ns=k * 172800 * 10**9)
                outcome = tracker.push(frame)
                result = self.fit.frame(self.images[k], time_days=2 * k)[0]
                self.assertEqual((outcome.verdict, outcome.value), ("accepted", result.displacement_px))
            records = tracker.records()
            self.assertEqual(records["separation_px"][4], result.separation_px)
            self.assertEqual(records["sigma"][4], result.separation_sigma_px)

    def test_mistakes(self):
        for kind, text, call in (
            (toliman.InputError, "options->free", lambda: toliman.Fit(self.simulator, free="scal")),
            (toliman.InputError, "options->free", lambda: toliman.Fit(self.simulator, free=["focus", "flux_a"])),
            (toliman.InputError, "options->capture_px", lambda: toliman.Fit(self.simulator, capture_px=65)),
            (TypeError, "simulator", lambda: toliman.Fit(3)),
            (ValueError, "frame", lambda: self.fit.frame(self.images[0][1:])),
            (ValueError, "frames", lambda: self.fit.frames(self.images[0])),
            (ValueError, "shift", lambda: self.fit.frame(self.images[0], shift=(1, 2, 3))),
            (ValueError, "times_days", lambda: self.fit.frames(self.images, times_days=[1, 2])),
            (ValueError, "shifts", lambda: self.fit.frames(self.images, shifts=[[1, 2]])),
            (toliman.InputError, "predictions->time_days",
             lambda: self.fit.frames(self.images, times_days=[0, numpy.nan, 0, 0, 0])),
        ):
            with self.subTest(text), refused(kind, text):
                call()


if __name__ == "__main__":
    numpy.seterr(all="raise")
    unittest.main()
