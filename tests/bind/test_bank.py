"""Banks of networks from Python: the same numbers from all calls, training, saved banks, and mistakes."""
import gc
import pathlib
import tempfile
import unittest

import numpy

from package import toliman
from refusal import refused
from toliman import _raw

SIDE = 256
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96,
                  "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 297.5, "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874},
                                                                     {"a": 0.93, "f": 1.829, "m": 5}]}},
    "band": {"wavelength_nm": 580},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "relative_flux": 3},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
    "binary": {"date": 2027, "moving": True,
               "orbit": {"period_years": 2.739726, "semi_major_arcsec": 2.7, "eccentricity": 0, "inclination_deg": 0,
                         "node_deg": 40, "periastron_deg": 0, "epoch": 2027}},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 20},
    "cadence": {"frames": 6, "interval_days": 10, "peak_photons": 1e6},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.2},
    "noise": {"photon": True, "read_e": 2.5, "seed": 7},
}
SMALL = {"places": 1, "spacing_px": 2.5, "steps": 20}
TIMES = numpy.arange(6) * 10.0


class Banks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(SCENE)
        cls.fit = toliman.Fit(cls.simulator, capture_px=2)
        cls.images = cls.simulator.frames(0, 6)
        cls.bank = toliman.Bank(cls.fit, **SMALL)
        cls.bank.train()

    def test_tracker(self):
        bank = toliman.Bank(toliman.Fit(self.simulator, capture_px=2), **{**SMALL, "steps": 60})
        with refused(toliman.InputError, "options->estimator.bank"):
            toliman.Tracker(bank, 0.001, 0.001, 20)
        bank.train()
        results, fits = bank.encode(self.images, times_days=TIMES)
        with toliman.Tracker(bank, 0.001, 0.001, 20, allow_zero_runs=True) as tracker:
            del bank  # the tracker keeps bank and fit alive
            gc.collect()
            for k in range(6):
                frame = toliman.Frame(self.images[k], session="s", frame_id=k, camera_ns=k * 864000 * 10**9)
                outcome = tracker.push(frame)
                self.assertEqual((outcome.verdict, outcome.value), ("accepted", results["displacement_px"][k]))
            records = tracker.records()
        numpy.testing.assert_array_equal(records["separation_px"], results["separation_px"])
        numpy.testing.assert_array_equal(records["fit_separation_px"], fits["separation_px"])
        numpy.testing.assert_array_equal(records["sigma"], results["sigma_px"])
        numpy.testing.assert_array_equal(
            records["flags"], fits["flags"] + _raw.TOLIMAN_TRACK_BANK_FLAGS * results["flags"])

    def test_properties(self):
        plan, info = toliman.Bank.plan(self.simulator, **SMALL), self.bank.info
        self.assertEqual((plan.networks, plan.dates, plan.places), (2, 2, 1))
        self.assertEqual((info.networks, info.trained_networks, info.steps, info.layout), (2, 2, 20, "flight"))
        self.assertEqual((info.first_days, info.last_days, self.bank.shape), (0, 50, (SIDE, SIDE)))
        self.assertEqual(info.fit_digest, self.fit.info.digest)
        first, second = self.bank.networks
        self.assertEqual((first.first_days, first.last_days, second.last_days), (0, second.first_days, 50))
        self.assertTrue(first.trained and 0.3 < first.cosine < 1)
        paper = toliman.Bank(self.fit, layout="paper", first_days=-2, last_days=3, **SMALL)
        self.assertEqual((paper.info.layout, paper.info.first_days, paper.info.last_days), ("paper", -2, 3))
        self.assertEqual(paper.info.trained_networks, 0)

    def test_all_calls_give_the_same_numbers(self):
        results, fits = self.bank.encode(self.images, times_days=TIMES)
        self.assertEqual(results.dtype.names, ("flags", "displacement_px", "separation_px", "sigma_px", "efficiency",
                                               "distance_px", "network", "goodness", "bad_pixels", "chi_square",
                                               "chi_square_sigma", "largest_residual"))
        numpy.testing.assert_array_equal(fits, self.fit.frames(self.images, times_days=TIMES))
        by_one_thread = toliman.Bank.from_bytes(self.bank.to_bytes(), self.fit, threads=1)
        numpy.testing.assert_array_equal(by_one_thread.encode(self.images, times_days=TIMES)[0], results)
        for k in range(6):
            result, fitted = self.bank.encode_frame(self.images[k], time_days=TIMES[k])
            self.assertEqual((result.goodness, result.chi_square), (fitted.goodness, fitted.chi_square))
            for name in set(results.dtype.names) - {"flags", "goodness"}:
                self.assertEqual(results[name][k], getattr(result, name))
            self.assertEqual(fitted.separation_px, fits["separation_px"][k])
            self.assertFalse(result.not_fitted or result.outside)
            expected = self.bank.predict(time_days=TIMES[k])
            self.assertEqual((expected.displacement_px, expected.network), (0, result.network))
            numpy.testing.assert_allclose(result.sigma_px, expected.sigma_px, rtol=0.01)
            self.assertLess(abs(result.displacement_px - fitted.displacement_px), 5 * result.sigma_px)

    def test_more_frames_than_a_call_takes(self):
        stages = []
        images = self.images[numpy.zeros(66, int)]
        results, fits = self.bank.encode(images, times_days=0, progress=lambda stage, fraction: stages.append((stage, fraction)))
        self.assertEqual(stages[-1], ("encode", 1))
        self.assertEqual((len(results), len(fits)), (66, 66))
        self.assertEqual(results["separation_px"][65], results["separation_px"][0])
        self.assertEqual([len(array) for array in self.bank.encode(images[:0], times_days=0)], [0, 0])

    def test_training_continues(self):
        bank = toliman.Bank(self.fit, **SMALL)
        with self.assertRaises(toliman.Cancelled):
            bank.train(threads=1, progress=lambda stage, fraction: fraction > 0)
        self.assertEqual(bank.info.trained_networks, 1)
        bank.train(threads=1)
        self.assertEqual(bank.to_bytes(), self.bank.to_bytes())

    def test_saved_banks(self):
        expected = self.bank.encode(self.images[:1], times_days=0)[0]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bank.tlmb"
            self.bank.save(path)
            loaded = toliman.Bank.load(path, self.fit)
            self.assertEqual(path.read_bytes(), self.bank.to_bytes())
            self.assertEqual(loaded.info, self.bank.info)
            numpy.testing.assert_array_equal(loaded.encode(self.images[:1], times_days=0)[0], expected)
            self.bank.save(path, encoding="fp16")
            small = toliman.Bank.load(path, self.fit)
        self.assertLess(len(small.to_bytes(encoding="fp16")), len(self.bank.to_bytes()))
        again = toliman.Bank.from_bytes(self.bank.to_bytes(), self.fit)
        self.assertEqual(again.info.digest, self.bank.info.digest)

    def test_renewal(self):
        early, late = self.bank.renewal(0.5), self.bank.renewal(0.1)
        self.assertTrue(50 < early <= late)
        self.assertTrue(self.bank.predict(time_days=60).outside)

    def test_a_frame_without_a_fit_is_nan(self):
        result, fitted = self.bank.encode_frame(numpy.zeros((SIDE, SIDE)), time_days=0)
        self.assertTrue(result.not_fitted and fitted.not_converged and numpy.isnan(result.separation_px))
        flags = self.bank.encode(numpy.zeros((1, SIDE, SIDE)), times_days=0)[0]["flags"]
        self.assertEqual(flags[0], _raw.TOLIMAN_BANK_NOT_FITTED)

    def test_mistakes(self):
        other = toliman.Fit(self.simulator, capture_px=1)
        content = self.bank.to_bytes()
        for kind, text, call in (
            (toliman.InputError, "options->places", lambda: toliman.Bank(self.fit, places=9)),
            (toliman.InputError, "options->spacing_px", lambda: toliman.Bank.plan(self.simulator, spacing_px=0.01)),
            (ValueError, "layout", lambda: toliman.Bank(self.fit, layout="deep")),
            (ValueError, "encoding", lambda: self.bank.to_bytes(encoding="fp8")),
            (TypeError, "fit", lambda: toliman.Bank(self.simulator)),
            (TypeError, "fit", lambda: toliman.Bank.from_bytes(content, None)),
            (toliman.Error, "", lambda: toliman.Bank.from_bytes(content[:-1], self.fit)),
            (toliman.Error, "bank", lambda: toliman.Bank.from_bytes(content, other).predict()),
            (FileNotFoundError, "none.tlmb", lambda: toliman.Bank.load("none.tlmb", self.fit)),
            (ValueError, "frames", lambda: self.bank.encode(self.images[0], times_days=0)),
            (ValueError, "frame", lambda: self.bank.encode_frame(self.images[0][1:])),
            (ValueError, "times_days", lambda: self.bank.encode(self.images, times_days=[1, 2])),
            (toliman.InputError, "least_efficiency", lambda: self.bank.renewal(2)),
        ):
            with self.subTest(text), refused(kind, text):
                call()
        other.close()
        with refused(ValueError, "this"):
            toliman.Bank.from_bytes(content, other).predict()


if __name__ == "__main__":
    numpy.seterr(all="raise")
    unittest.main()
